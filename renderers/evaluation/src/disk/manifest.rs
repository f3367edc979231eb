//! Which files of a folder are ours, and what stood in them.

use std::collections::BTreeMap;
use std::path::Path;

use ltsc_render::regular;
use serde::{Deserialize, Serialize};

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

    /// Its text.
    pub fn bytes(&self) -> Vec<u8> {
        let mut text = serde_json::to_vec_pretty(self).unwrap_or_default();
        text.push(b'\n');
        text
    }
}
