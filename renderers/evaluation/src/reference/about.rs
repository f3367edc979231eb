//! What is known of a reference: who rendered it, how, how well, and of which scene.

use serde::{Deserialize, Serialize};

use ltsc_core::formats::algorithms::{ALGORITHMS, Convergence};
use ltsc_render::image::Provenance;

use crate::compare::verdict::MeanError;
use crate::failure::{Exit, Failure};

/// The attribute of the file that holds it all, as JSON.
const ATTRIBUTE: &str = "reference";

/// The version of that JSON; a newer one is refused.
const FORM: u32 = 1;

/// What is known of a reference. Its serialized form is stable: fields may come, but not go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Always [`FORM`].
    form: u32,
    /// The scene.
    pub scene: String,
    /// The name under which it is kept: that of a renderer or a target, or one of its own.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// The target whose files tell whether the scene has changed.
    pub target: String,
    /// The hash of those files when it was rendered.
    pub content: String,
    /// How they were written.
    pub settings: Settings,
    /// Its error; none where that is not known.
    pub error: Option<MeanError>,
    /// Images whose mean it is.
    pub images: u32,
    /// Samples per pixel in all; none where that is not known.
    pub samples: Option<u64>,
    /// What storing it has changed.
    pub stored: Stored,
}

/// Where a reference comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "from", rename_all = "lowercase")]
pub enum Origin {
    /// ltsc rendered it.
    Rendered {
        /// The renderer.
        renderer: String,
        /// Its version, as it says.
        version: String,
        /// What its algorithm tends to, where that is known.
        convergence: Option<String>,
        /// What the renderer is known to render otherwise, of what is in the scene.
        defects: Option<String>,
        /// [`crate::job::Job::identity`] of its chunks, the first of which has seed 0.
        identity: String,
        /// Seconds of rendering of all chunks.
        seconds: f64,
        /// Seconds of processor time; none where that is not known.
        cpu_seconds: Option<f64>,
        /// The machines.
        machines: Vec<String>,
    },
    /// Somebody says so; ltsc has looked at its size only.
    Declared {
        /// Who or what it is from.
        by: String,
        /// The name of the file that it was taken from.
        file: String,
        /// The algorithm, as they call it.
        algorithm: Option<String>,
    },
}

/// How a scene was written for a reference.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The algorithm, by its word in scenes.
    pub integrator: String,
    /// Segments of the longest paths.
    pub max_depth: u32,
    /// The sampler, by its word.
    pub sampler: String,
    /// Samples per pixel of each image.
    pub samples: u32,
}

/// How pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stored {
    /// 16 or 32 bits for each number.
    pub bits: u32,
    /// The largest change of the mean of one of the 8 by 8 tiles by it, as a share; tiles darker than a tenth of the image count
    /// as a tenth.
    pub change: f64,
}

impl About {
    /// A new one; how it is stored is not known yet.
    pub(super) fn new(
        scene: &str,
        name: &str,
        origin: Origin,
        target: &str,
        content: String,
        settings: Settings,
    ) -> Self {
        Self {
            form: FORM,
            scene: scene.to_owned(),
            name: name.to_owned(),
            origin,
            target: target.to_owned(),
            content,
            settings,
            error: None,
            images: 1,
            samples: None,
            stored: Stored { bits: 32, change: 0.0 },
        }
    }

    /// Whether ltsc rendered it.
    #[must_use]
    pub fn is_rendered(&self) -> bool {
        matches!(self.origin, Origin::Rendered { .. })
    }

    /// Who made it, in a few words: `mitsuba-3 3.9.1, light_tracing`, or what was declared.
    #[must_use]
    pub fn maker(&self) -> String {
        match &self.origin {
            Origin::Rendered { renderer, version, .. } => {
                format!("{renderer} {version}, {}", self.settings.integrator)
            }
            Origin::Declared { by, algorithm, .. } => {
                let algorithm = algorithm.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
                format!("declared: {by}{algorithm}")
            }
        }
    }

    /// What somebody who compares with it should know beside its error; none of an image that tends to the truth.
    #[must_use]
    pub fn caution(&self) -> Option<String> {
        let Origin::Rendered { convergence, defects, .. } = &self.origin else { return None };
        let off = match convergence.as_deref() {
            Some("consistent") => Some("consistent: off by more than its error, less with more samples in each image"),
            Some("biased") => Some("biased: off by more than its error"),
            _ => None,
        };
        let words: Vec<&str> = off.into_iter().chain(defects.as_deref()).collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    /// The attributes of the file. One that was not rendered here has nothing of a rendering.
    pub(super) fn provenance(&self) -> Provenance {
        let text = serde_json::to_string(self).unwrap_or_default();
        let mut extra = vec![(ATTRIBUTE.to_owned(), text)];
        let mut of = Provenance {
            scene: self.scene.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            ..Provenance::default()
        };
        match &self.origin {
            Origin::Rendered { renderer, version, seconds, .. } => {
                of.scene_hash.clone_from(&self.content);
                of.renderer.clone_from(renderer);
                of.renderer_version.clone_from(version);
                of.seconds = *seconds;
                of.samples = self.samples.unwrap_or_default();
            }
            Origin::Declared { by, .. } => extra.push(("declared-by".to_owned(), by.clone())),
        }
        of.extra = extra;
        of
    }

    /// Reads it from the attributes of a file; none where there is none of ours.
    ///
    /// # Errors
    /// If it is damaged or newer than this ltsc.
    pub(super) fn read(attributes: &[(String, String)]) -> Result<Option<Self>, Failure> {
        let name = format!("ltsc:{ATTRIBUTE}");
        let Some((_, text)) = attributes.iter().find(|(known, _)| *known == name) else { return Ok(None) };
        let about: Self = serde_json::from_str(text).map_err(|error| {
            Failure::new(Exit::Input, format!("what it says of itself is damaged: {error}"))
                .help("render or add it again")
        })?;
        if about.form > FORM {
            return Err(Failure::new(Exit::Input, "a newer ltsc wrote it").help("use that ltsc, or render it again"));
        }
        Ok(Some(about))
    }
}

/// What the algorithm that a target has for a word of the language tends to, where that is known.
pub(super) fn convergence(target: &str, word: &str) -> Option<Convergence> {
    let row = ALGORITHMS.iter().find(|row| row.family == word && row.targets.contains(&target));
    row.map(|row| row.convergence)
}
