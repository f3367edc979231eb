//! How an image came to be, as it is written into the image.

/// Origin of an image, kept as string attributes named `ltsc:...` in the header of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Name of the scene.
    pub scene: String,
    /// Hash of everything the renderer read.
    pub scene_hash: String,
    /// Version of ltsc.
    pub version: String,
    /// Name of the renderer, such as `mitsuba-3`.
    pub renderer: String,
    /// What the renderer says its version is.
    pub renderer_version: String,
    /// Samples per pixel.
    pub samples: u64,
    /// Seed of the run.
    pub seed: u64,
    /// Rendering time in seconds, without start and loading.
    pub seconds: f64,
    /// Further facts; each name is written behind `ltsc:`.
    pub extra: Vec<(String, String)>,
}

impl Provenance {
    /// The attributes to write, by name, without those that say nothing.
    #[must_use]
    pub fn attributes(&self) -> Vec<(String, String)> {
        let mut all: Vec<(String, String)> = [
            ("scene", self.scene.clone()),
            ("scene-hash", self.scene_hash.clone()),
            ("version", self.version.clone()),
            ("renderer", self.renderer.clone()),
            ("renderer-version", self.renderer_version.clone()),
            ("samples", self.samples.to_string()),
            ("seed", self.seed.to_string()),
            ("seconds", format!("{:.3}", self.seconds)),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .chain(self.extra.iter().cloned())
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| (format!("ltsc:{name}"), value))
        .collect();
        all.sort();
        all.dedup_by(|later, earlier| later.0 == earlier.0);
        all
    }

    /// Finds the provenance among the attributes of a file; facts that are not there stay empty.
    #[must_use]
    pub fn from_attributes(attributes: &[(String, String)]) -> Self {
        let mut found = Self::default();
        for (name, value) in attributes {
            let Some(name) = name.strip_prefix("ltsc:") else { continue };
            match name {
                "scene" => found.scene.clone_from(value),
                "scene-hash" => found.scene_hash.clone_from(value),
                "version" => found.version.clone_from(value),
                "renderer" => found.renderer.clone_from(value),
                "renderer-version" => found.renderer_version.clone_from(value),
                "samples" => found.samples = value.parse().unwrap_or_default(),
                "seed" => found.seed = value.parse().unwrap_or_default(),
                "seconds" => found.seconds = value.parse().unwrap_or_default(),
                _ => found.extra.push((name.to_owned(), value.clone())),
            }
        }
        found
    }
}
