//! Default settings of a rendering; test cases replace them whole.

/// Resolution and reconstruction filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels, at least 1.
    pub width: u32,
    /// Pixels, at least 1.
    pub height: u32,
    /// Reconstruction filter.
    pub filter: Filter,
}

/// Reconstruction filter, lengths in pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Filter {
    /// Equal weight within `radius` of the pixel's center in both axes; radius 0.5 is the pixel itself.
    Box {
        /// Half the side, > 0.
        radius: f64,
    },
    /// A Gaussian cut at `radius`, the value there subtracted.
    Gaussian {
        /// Standard deviation, > 0.
        stddev: f64,
        /// Half the side, > 0.
        radius: f64,
    },
}

/// Light transport algorithm.
///
/// | | Mitsuba 0.5, 0.6 | Mitsuba 3 | PBRT v3 | PBRT v4 | LuxCore |
/// |---|---|---|---|---|---|
/// | `Path` | `path` D | `path` D | `path` D - 1 | `path` D - 1 | `PATHCPU` D |
/// | `Bidirectional` | `bdpt` D | | `bdpt` D - 1 | `bdpt` D - 1 | |
/// | `LightTracing` | `ptracer` D | `ptracer` D | | `lightpath` D - 1 | |
/// | `Metropolis` | `pssmlt` D | | `mlt` D - 1 | `mlt` D - 1 | |
/// | `PhotonMap` | `sppm` D | | `sppm` D - 1 | `sppm` D - 1 | |
///
/// The letter is what the target's own depth is for a `max_depth` of D; `names.rs` of each format has the sources. Where a
/// target has no such algorithm it gets `Path` of the same depth, and `loss-dropped` says so. glTF has none at all.
#[derive(Clone, Debug, PartialEq)]
pub enum Integrator {
    /// Unidirectional path tracing with next event estimation and multiple importance sampling. Unbiased.
    Path {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
    /// Bidirectional path tracing: paths from the camera and from the lights, connected, with multiple importance sampling.
    /// Unbiased.
    Bidirectional {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
    /// Paths from the lights only, each vertex connected to the camera. Unbiased for what it finds; with a pinhole camera it
    /// finds no path that meets the camera by way of an ideally specular surface, which stays black.
    LightTracing {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
    /// Metropolis light transport in the space of primary samples (Kelemen et al. 2002; Hachisuka et al. 2014), over
    /// bidirectional path tracing. Unbiased; neighboring samples are correlated. The sampler's samples are mutations per pixel.
    Metropolis {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
    /// Stochastic progressive photon mapping (Hachisuka and Jensen 2009). Consistent: biased by blur at any number of
    /// samples, right in the limit. The sampler's samples are passes.
    PhotonMap {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
}

impl Integrator {
    /// Largest number of segments of a path.
    pub fn max_depth(&self) -> u32 {
        match *self {
            Self::Path { max_depth }
            | Self::Bidirectional { max_depth }
            | Self::LightTracing { max_depth }
            | Self::Metropolis { max_depth }
            | Self::PhotonMap { max_depth } => max_depth,
        }
    }

    /// The same algorithm with another depth.
    #[must_use]
    pub fn with_max_depth(&self, max_depth: u32) -> Self {
        match self {
            Self::Path { max_depth: _ } => Self::Path { max_depth },
            Self::Bidirectional { max_depth: _ } => Self::Bidirectional { max_depth },
            Self::LightTracing { max_depth: _ } => Self::LightTracing { max_depth },
            Self::Metropolis { max_depth: _ } => Self::Metropolis { max_depth },
            Self::PhotonMap { max_depth: _ } => Self::PhotonMap { max_depth },
        }
    }

    /// The words of all.
    pub const WORDS: [&str; 5] = ["path", "bidirectional", "light_tracing", "metropolis", "photon_map"];

    /// The algorithm of a word.
    pub fn of_word(word: &str, max_depth: u32) -> Option<Self> {
        match word {
            "path" => Some(Self::Path { max_depth }),
            "bidirectional" => Some(Self::Bidirectional { max_depth }),
            "light_tracing" => Some(Self::LightTracing { max_depth }),
            "metropolis" => Some(Self::Metropolis { max_depth }),
            "photon_map" => Some(Self::PhotonMap { max_depth }),
            _ => None,
        }
    }

    /// The constructor that makes it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Path { max_depth: _ } => "path",
            Self::Bidirectional { max_depth: _ } => "bidirectional",
            Self::LightTracing { max_depth: _ } => "light_tracing",
            Self::Metropolis { max_depth: _ } => "metropolis",
            Self::PhotonMap { max_depth: _ } => "photon_map",
        }
    }
}

/// Sampling.
#[derive(Clone, Debug, PartialEq)]
pub enum Sampler {
    /// Independent random numbers.
    Independent {
        /// Samples per pixel, at least 1.
        samples: u32,
        /// Start of the random numbers, where the renderer has one.
        seed: u32,
    },
    /// Points of a Sobol sequence, which lie more evenly than random ones.
    ///
    /// Spelling: Mitsuba 0.x, PBRT and LuxCore `sobol`; Mitsuba 3 has none.
    Sobol {
        /// Samples per pixel, at least 1; powers of 2 are the best.
        samples: u32,
        /// What the points are scrambled with, where the renderer has such a number.
        seed: u32,
    },
}

impl Sampler {
    /// The words of all.
    pub const WORDS: [&str; 2] = ["independent", "sobol"];

    /// The sampler of a word.
    pub fn of_word(word: &str, samples: u32, seed: u32) -> Option<Self> {
        match word {
            "independent" => Some(Self::Independent { samples, seed }),
            "sobol" => Some(Self::Sobol { samples, seed }),
            _ => None,
        }
    }

    /// The constructor that makes it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Independent { samples: _, seed: _ } => "independent",
            Self::Sobol { samples: _, seed: _ } => "sobol",
        }
    }

    /// Samples per pixel.
    pub fn samples(&self) -> u32 {
        match *self {
            Self::Independent { samples, seed: _ } | Self::Sobol { samples, seed: _ } => samples,
        }
    }

    /// Start of the random numbers.
    pub fn seed(&self) -> u32 {
        match *self {
            Self::Independent { samples: _, seed } | Self::Sobol { samples: _, seed } => seed,
        }
    }

    /// The same points with other numbers.
    #[must_use]
    pub fn with(&self, samples: u32, seed: u32) -> Self {
        match self {
            Self::Independent { samples: _, seed: _ } => Self::Independent { samples, seed },
            Self::Sobol { samples: _, seed: _ } => Self::Sobol { samples, seed },
        }
    }
}
