//! What an evaluation needs to know beyond its own text, asked of whoever knows it.

use ltsc_core::formats::Target;

use super::model::Source;

/// Answers about scenes and files. Paths are as the evaluation file writes them: relative to it.
pub trait Surroundings {
    /// The names of the project's scenes, for misspelt ones.
    fn scenes(&self) -> Vec<String>;
    /// Why a scene is not there.
    fn missing(&self, scene: &Source) -> Option<String>;
    /// Why a scene cannot be rendered by what reads a target's files.
    fn lacks(&self, scene: &Source, target: &'static Target) -> Option<String>;
    /// The parameters that a scene declares; none where that is not known.
    fn parameters(&self, scene: &Source) -> Option<Vec<String>>;
    /// Whether there is a file.
    fn has_file(&self, path: &str) -> bool;
    /// The image that is kept as the reference of a scene for a target, where there is one.
    fn reference(&self, scene: &Source, target: &'static Target) -> Option<String>;
}

/// Knows nothing, and so finds nothing missing.
pub struct Unknown;

impl Surroundings for Unknown {
    fn scenes(&self) -> Vec<String> {
        Vec::new()
    }

    fn missing(&self, _scene: &Source) -> Option<String> {
        None
    }

    fn lacks(&self, _scene: &Source, _target: &'static Target) -> Option<String> {
        None
    }

    fn parameters(&self, _scene: &Source) -> Option<Vec<String>> {
        None
    }

    fn has_file(&self, _path: &str) -> bool {
        true
    }

    fn reference(&self, _scene: &Source, _target: &'static Target) -> Option<String> {
        None
    }
}
