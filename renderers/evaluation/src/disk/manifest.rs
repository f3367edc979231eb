//! Which files of a folder are ours, and what stood in them.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use ltsc_core::files::VPath;
use ltsc_render::regular;
use serde::{Deserialize, Serialize};

use super::sink::hash_of;

/// The name of the file that says which files of a folder are ours.
pub const MANIFEST: &str = "manifest.json";

/// More than the manifest of a million files.
const LARGEST: u64 = 1 << 30;

/// Which files a folder holds, by path below it, and their content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always "ltsc".
    pub generator: String,
    /// The scene.
    pub scene: String,
    /// Names of the features that the scene uses, where that is written down.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub features: Vec<String>,
    /// BLAKE3 of each file.
    pub files: BTreeMap<String, String>,
}

impl Manifest {
    /// The manifest of a folder; none where there is none of ours.
    pub fn read(folder: &Path) -> Option<Self> {
        let bytes = regular::read(&folder.join(MANIFEST), LARGEST).ok()?;
        let manifest: Self = serde_json::from_slice(&bytes).ok()?;
        (manifest.generator == "ltsc").then_some(manifest)
    }

    /// The manifest of a folder all of whose files are as it says.
    ///
    /// # Errors
    /// If there is none, or a file is missing or another one.
    pub fn verified(folder: &Path) -> io::Result<Self> {
        let wrong = |message: String| io::Error::new(io::ErrorKind::InvalidData, message);
        let manifest = Self::read(folder).ok_or_else(|| wrong(format!("there is no `{MANIFEST}` of ltsc")))?;
        for (path, hash) in &manifest.files {
            let inside = VPath::resolve("", path).map_err(|error| wrong(error.to_string()))?;
            if hash_of(&folder.join(inside.as_str())).as_ref() != Some(hash) {
                return Err(wrong(format!("`{path}` is missing, or not as ltsc wrote it")));
            }
        }
        Ok(manifest)
    }

    /// A hash of the paths and contents of the files that `counts` says yes to.
    #[must_use]
    pub fn content(&self, counts: impl Fn(&str) -> bool) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        for (path, hash) in self.files.iter().filter(|(path, _)| counts(path)) {
            // Lengths keep two different lists of files from looking alike.
            hasher.update(&(path.len() as u64).to_le_bytes());
            hasher.update(path.as_bytes());
            hasher.update(hash.as_bytes());
        }
        hasher.finalize()
    }

    /// Its text.
    pub fn bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }
}
