//! What a scene is for: the documentation that every scene of a test suite carries.

/// Documentation of a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Documentation {
    /// One sentence; empty where the author wrote none.
    pub brief: String,
    /// Markdown after the first paragraph; may be empty.
    pub full: String,
    /// Classes of light paths in Heckbert's notation that the scene tests.
    pub paths: Vec<String>,
    /// Similar scenes and why this one is kept beside them.
    pub similar: Vec<Similar>,
    /// What else is to be said.
    pub comments: String,
    /// Where the scene comes from.
    pub source: String,
    /// Under which license it may be used.
    pub license: String,
    /// Values of its parameters, which say what it became; those of its header alone have none.
    pub parameters: Vec<ParameterValue>,
}

/// A parameter of a scene and the value that it has, from the command line or by default.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterValue {
    /// Its name.
    pub name: String,
    /// Its type in words.
    pub ty: String,
    /// Its value, as it would be written.
    pub value: String,
    /// What it may be, as it would be written; empty where that is not limited.
    pub allowed: String,
}

/// A similar scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Similar {
    /// Its name.
    pub scene: String,
    /// Why this one is kept beside it.
    pub reason: String,
}
