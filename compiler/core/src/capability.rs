//! What scenes ask for and what targets answer.

use crate::diag::Origin;
use crate::ir::Scene;

/// One thing that a scene can ask for. Closed: a new one fails to compile in every target until someone decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// A diffuse material.
    Diffuse,
}

/// What a target answers.
#[derive(Clone, Debug, PartialEq)]
pub enum Support {
    /// The target means the same.
    Exact,
    /// The target means nearly the same.
    Approximate {
        /// What differs.
        why: &'static str,
        /// By how much, and how that was found.
        bound: &'static str,
    },
    /// The target cannot say it.
    Unsupported {
        /// What is missing.
        why: &'static str,
    },
}

/// What `scene` asks for, each feature once with the first place that asks for it.
pub fn features(_scene: &Scene) -> Vec<(Feature, Origin)> {
    Vec::new()
}
