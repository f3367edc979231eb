//! Settings that replace the scene's own: of the command line, and neutral ones of test cases.

use super::Limits;
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

impl Overrides {
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

    #[test]
    fn what_is_said_replaces_and_the_rest_stays() {
        let overrides = Overrides {
            integrator: Some("bidirectional"),
            max_depth: Some(7),
            samples: Some(256),
            filter: Some(Filter::Gaussian { stddev: 0.5, radius: 2.0 }),
            ..Overrides::default()
        };
        assert_eq!(
            overrides.integrator(&Integrator::Path { max_depth: 3 }),
            Integrator::Bidirectional { max_depth: 7 }
        );
        let sampler = Sampler::Sobol { samples: 1, seed: 5 };
        assert_eq!(overrides.sampler(&sampler), Sampler::Sobol { samples: 256, seed: 5 });
        let film = Film { width: 3, height: 4, filter: Filter::Box { radius: 2.0 } };
        let filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 };
        assert_eq!(overrides.film(&film), Film { width: 3, height: 4, filter });
        let other = Overrides { sampler: Some("independent"), seed: Some(0), ..Overrides::default() };
        assert_eq!(other.sampler(&sampler), Sampler::Independent { samples: 1, seed: 0 });
        assert_eq!(other.integrator(&Integrator::PhotonMap { max_depth: 3 }), Integrator::PhotonMap { max_depth: 3 });
    }

    #[test]
    fn words_are_those_of_the_language() {
        for word in Integrator::WORDS {
            assert_eq!(Integrator::of_word(word, 4).map(|one| (one.word(), one.max_depth())), Some((word, 4)));
        }
        for word in Integrator::WORDS.iter().chain(&Sampler::WORDS) {
            assert!(super::super::table().any(|constructor| constructor.name == *word), "{word}");
        }
        assert!(Sampler::WORDS.iter().all(|word| Sampler::of_word(word, 1, 0).is_some()));
    }
}
