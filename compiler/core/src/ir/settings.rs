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
    /// Equal weight within `radius` of the pixel's centre in both axes; radius 0.5 is the pixel itself.
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
#[derive(Clone, Debug, PartialEq)]
pub enum Integrator {
    /// Unidirectional path tracing with next event estimation and multiple importance sampling. Unbiased.
    ///
    /// `max_depth` spelling: Mitsuba `maxDepth` D; PBRT `maxdepth` D - 1; LuxCore `path.pathdepth.total` D.
    Path {
        /// Largest number of segments, at least 1.
        max_depth: u32,
    },
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
}
