//! Settings that replace the scene's own: of the command line, and neutral ones of test cases.

use super::Limits;
use crate::diag::{Finding, Origin, nearest};
use crate::ir::{Film, Filter, Integrator, Sampler, Scene};

/// Settings that replace the scene's own, from the command line or a test case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Pixels, at least 1.
    pub width: Option<u32>,
    /// Pixels, at least 1.
    pub height: Option<u32>,
    /// Samples per pixel, at least 1.
    pub samples: Option<u32>,
    /// Start of the random numbers.
    pub seed: Option<u32>,
    /// Segments of a path, at least 1.
    pub max_depth: Option<u32>,
    /// The algorithm, by its word; one of [`Integrator::WORDS`].
    pub integrator: Option<&'static str>,
    /// The sampler, by its word; one of [`Sampler::WORDS`].
    pub sampler: Option<&'static str>,
    /// The reconstruction filter.
    pub filter: Option<Filter>,
    /// Values of the scene's parameters, as texts of expressions; the last one of a name counts.
    pub set: Vec<(String, String)>,
    /// How large the scene may become.
    pub limits: Limits,
}

/// A value of a neutral setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting<'t> {
    /// A number.
    Number(f64),
    /// A word.
    Word(&'t str),
    /// What no setting takes.
    Other,
}

/// The names of neutral settings.
const SETTINGS: [&str; 8] = ["integrator", "max_depth", "samples", "seed", "sampler", "filter", "width", "height"];

impl Overrides {
    /// Takes a neutral setting by its name.
    ///
    /// # Errors
    /// There is no such setting, or it cannot have this value.
    pub fn give(&mut self, name: &str, value: Setting<'_>, origin: &Origin) -> Result<(), Box<Finding>> {
        let wrong = |message: String| Finding::error("invalid-setting", origin.clone(), message);
        let count = |least: u32| match value {
            Setting::Number(number)
                if number.fract() == 0.0 && (f64::from(least)..=f64::from(u32::MAX)).contains(&number) =>
            {
                Ok(Some(number as u32))
            }
            Setting::Number(_) | Setting::Word(_) | Setting::Other => {
                Err(Box::new(wrong(format!("the setting `{name}` is no whole number of at least {least}"))))
            }
        };
        let word = |known: &[&'static str]| match value {
            Setting::Word(word) => match known.iter().find(|known| **known == word) {
                Some(known) => Ok(Some(*known)),
                None => {
                    let finding = wrong(format!("the setting `{name}` cannot be `{word}`"));
                    Err(Box::new(finding.help(match nearest(word, known.iter().copied()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => {
                            format!("known: {}; what only one renderer has is a native parameter", known.join(", "))
                        }
                    })))
                }
            },
            Setting::Number(_) | Setting::Other => {
                let finding = wrong(format!("the setting `{name}` is no word"));
                Err(Box::new(finding.help(format!("known: {}", known.join(", ")))))
            }
        };
        match name {
            "width" => self.width = count(1)?,
            "height" => self.height = count(1)?,
            "samples" => self.samples = count(1)?,
            "seed" => self.seed = count(0)?,
            "max_depth" => self.max_depth = count(1)?,
            "integrator" => self.integrator = word(&Integrator::WORDS)?,
            "sampler" => self.sampler = word(&Sampler::WORDS)?,
            "filter" => self.filter = word(&Filter::WORDS)?.and_then(Filter::of_word),
            _ => {
                let finding = wrong(format!("there is no setting `{name}`"));
                return Err(Box::new(finding.help(match nearest(name, SETTINGS) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("known: {}", SETTINGS.join(", ")),
                })));
            }
        }
        Ok(())
    }

    /// Replaces the settings of a scene. Cameras stay as they are: `fov_x` is the angle of the width.
    pub fn apply(&self, scene: &mut Scene) {
        scene.film = self.film(&scene.film);
        scene.integrator = self.integrator(&scene.integrator);
        scene.sampler = self.sampler(&scene.sampler);
    }

    /// The film that replaces another one.
    pub(super) fn film(&self, film: &Film) -> Film {
        let Film { width, height, filter } = film;
        Film {
            width: self.width.unwrap_or(*width),
            height: self.height.unwrap_or(*height),
            filter: self.filter.as_ref().unwrap_or(filter).clone(),
        }
    }

    /// The algorithm that replaces another one.
    pub(super) fn integrator(&self, integrator: &Integrator) -> Integrator {
        let max_depth = self.max_depth.unwrap_or(integrator.max_depth());
        let other = self.integrator.and_then(|word| Integrator::of_word(word, max_depth));
        other.unwrap_or_else(|| integrator.with_max_depth(max_depth))
    }

    /// The sampler that replaces another one.
    pub(super) fn sampler(&self, sampler: &Sampler) -> Sampler {
        let (samples, seed) = (self.samples.unwrap_or(sampler.samples()), self.seed.unwrap_or(sampler.seed()));
        let other = self.sampler.and_then(|word| Sampler::of_word(word, samples, seed));
        other.unwrap_or_else(|| sampler.with(samples, seed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(settings: &[(&str, Setting<'_>)]) -> Result<Overrides, Box<Finding>> {
        let mut overrides = Overrides::default();
        settings.iter().try_for_each(|(name, value)| overrides.give(name, *value, &Origin::Made))?;
        Ok(overrides)
    }

    #[test]
    fn settings_are_taken_by_their_names() {
        let overrides = given(&[
            ("integrator", Setting::Word("bidirectional")),
            ("max_depth", Setting::Number(7.0)),
            ("samples", Setting::Number(256.0)),
            ("filter", Setting::Word("gaussian")),
        ])
        .expect("settings");
        assert_eq!(
            overrides.integrator(&Integrator::Path { max_depth: 3 }),
            Integrator::Bidirectional { max_depth: 7 }
        );
        let sampler = Sampler::Sobol { samples: 1, seed: 5 };
        assert_eq!(overrides.sampler(&sampler), Sampler::Sobol { samples: 256, seed: 5 });
        let film = Film { width: 3, height: 4, filter: Filter::Box { radius: 2.0 } };
        let filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 };
        assert_eq!(overrides.film(&film), Film { width: 3, height: 4, filter });
        let other =
            given(&[("sampler", Setting::Word("independent")), ("seed", Setting::Number(0.0))]).expect("settings");
        assert_eq!(other.sampler(&sampler), Sampler::Independent { samples: 1, seed: 0 });
        assert_eq!(other.integrator(&Integrator::PhotonMap { max_depth: 3 }), Integrator::PhotonMap { max_depth: 3 });
    }

    #[test]
    fn what_is_no_setting_is_said() {
        let wrong = |name, value| {
            let finding = given(&[(name, value)]).expect_err("no setting");
            (finding.message, finding.help.unwrap_or_default())
        };
        assert_eq!(wrong("max_dept", Setting::Number(1.0)).1, "did you mean `max_depth`?");
        assert_eq!(wrong("integrator", Setting::Word("pat")).1, "did you mean `path`?");
        assert!(wrong("integrator", Setting::Word("vpl")).1.starts_with("known: path, bidirectional"));
        for (name, value) in [
            ("samples", Setting::Number(0.0)),
            ("samples", Setting::Number(1.5)),
            ("seed", Setting::Number(-1.0)),
            ("width", Setting::Word("wide")),
        ] {
            assert!(wrong(name, value).0.starts_with(&format!("the setting `{name}` is no whole number")));
        }
        assert!(wrong("filter", Setting::Other).0.ends_with("is no word"));
    }

    #[test]
    fn words_are_those_of_the_language() {
        for word in Integrator::WORDS {
            assert_eq!(Integrator::of_word(word, 4).map(|one| (one.word(), one.max_depth())), Some((word, 4)));
        }
        for word in Integrator::WORDS.iter().chain(&Filter::WORDS).chain(&Sampler::WORDS) {
            assert!(super::super::table().any(|constructor| constructor.name == *word), "{word}");
        }
        assert!(Filter::WORDS.iter().all(|word| Filter::of_word(word).is_some()));
        assert!(Sampler::WORDS.iter().all(|word| Sampler::of_word(word, 1, 0).is_some()));
    }
}
