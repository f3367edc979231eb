//! Why a mesh could not be made.

use std::fmt;

/// Why a generator or a stage refuses its arguments. The message reads as that of a finding: lower-case, one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshError {
    /// The argument at fault, as the constructor table spells it (`segments`); empty where it is the mesh itself.
    pub argument: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl MeshError {
    pub(crate) fn new(argument: &'static str, message: impl Into<String>) -> Self {
        Self { argument, message: message.into(), help: None }
    }

    #[must_use]
    pub(crate) fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for MeshError {}

/// `value` if it is finite.
pub(crate) fn finite(argument: &'static str, value: f64) -> Result<f64, MeshError> {
    if value.is_finite() { Ok(value) } else { Err(MeshError::new(argument, format!("`{argument}` is not finite"))) }
}

/// A point rounded to single precision, if it fits.
pub(crate) fn round(argument: &'static str, point: [f64; 3]) -> Result<[f32; 3], MeshError> {
    let rounded = point.map(|x| x as f32);
    if rounded.iter().all(|x| x.is_finite()) {
        return Ok(rounded);
    }
    let message = if point.iter().all(|x| x.is_finite()) {
        format!("a vertex lies beyond the range of single precision ({:e})", f32::MAX)
    } else {
        "a vertex is not finite".to_owned()
    };
    Err(MeshError::new(argument, message).help("scale the scene down"))
}
