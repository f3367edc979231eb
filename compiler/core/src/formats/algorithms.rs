//! Algorithms by the names that renderers give them: what they converge to, and how they count the depth of paths.
//!
//! One table. An algorithm that is not in it passes through, and nothing is said of it. Whether an algorithm is unbiased is said of
//! the radiance up to its depth, in scenes without media; what its parameters can make of it (clamping, regularization) is not.

/// What an image tends to with more samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Convergence {
    /// The expected value is the radiance at any number of samples.
    Unbiased,
    /// The expected value comes near the radiance with more samples, and is off at any number of them.
    Consistent,
    /// Something else, however many samples are taken.
    Biased,
}

impl Convergence {
    /// `unbiased`, `consistent`, `biased`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unbiased => "unbiased",
            Self::Consistent => "consistent",
            Self::Biased => "biased",
        }
    }
}

/// How an algorithm bounds paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// By the length of whole paths, which its parameter says in the renderer's own counting.
    Whole,
    /// Always at this many segments.
    Always(u32),
    /// In a way of its own, which no number of segments is.
    Own,
}

/// An algorithm of a renderer.
#[derive(Debug, PartialEq, Eq)]
pub struct Algorithm {
    /// Targets whose renderers have it.
    pub targets: &'static [&'static str],
    /// Its name there.
    pub native: &'static str,
    /// What it is, by the word of the language where that has one.
    pub family: &'static str,
    /// What it tends to.
    pub convergence: Convergence,
    /// How it bounds paths.
    pub depth: Depth,
    /// Where that is from.
    pub source: &'static str,
}

const fn row(
    targets: &'static [&'static str],
    (native, family): (&'static str, &'static str),
    convergence: Convergence,
    depth: Depth,
    source: &'static str,
) -> Algorithm {
    Algorithm { targets, native, family, convergence, depth, source }
}

const MITSUBA_0: &[&str] = &["mitsuba-0.5", "mitsuba-0.6"];
const MITSUBA: &[&str] = &["mitsuba-0.5", "mitsuba-0.6", "mitsuba-3"];
const MITSUBA_3: &[&str] = &["mitsuba-3"];
const PBRT: &[&str] = &["pbrt-v3", "pbrt-v4"];
const PBRT_3: &[&str] = &["pbrt-v3"];
const PBRT_4: &[&str] = &["pbrt-v4"];
const LUXCORE: &[&str] = &["luxcore"];
const CYCLES: &[&str] = &["cycles"];

use Convergence::{Biased, Consistent, Unbiased};
use Depth::{Always, Own, Whole};

/// Path tracing, in all renderers.
const PATH: &str = "Kajiya 1986; Veach 1997, chapter 10";
/// Metropolis light transport.
const METROPOLIS: &str = "Veach and Guibas 1997; Kelemen et al. 2002; \"unbiased algorithms such as Metropolis Light Transport\" \
                          (manual of Mitsuba 0.6, integrators)";
/// Stochastic progressive photon mapping.
const PROGRESSIVE: &str = "Hachisuka et al. 2008; Hachisuka and Jensen 2009: the radius goes to 0 with more passes; \"noise and bias\" \
                           decrease together (manual of Mitsuba 0.6, integrators)";

/// All that are known.
pub static ALGORITHMS: &[Algorithm] = &[
    row(MITSUBA, ("path", "path"), Unbiased, Whole, PATH),
    row(
        MITSUBA,
        ("volpath", "path"),
        Unbiased,
        Whole,
        "path tracing that also scatters in media (manual of Mitsuba 0.6 and of 3)",
    ),
    row(
        MITSUBA_0,
        ("volpath_simple", "path"),
        Unbiased,
        Whole,
        "the same with simpler sampling (manual of Mitsuba 0.6)",
    ),
    row(MITSUBA_3, ("volpathmis", "path"), Unbiased, Whole, "the same with spectral sampling (manual of Mitsuba 3)"),
    row(
        MITSUBA,
        ("ptracer", "light_tracing"),
        Unbiased,
        Whole,
        "the adjoint of path tracing (manual of Mitsuba 0.6 and of 3)",
    ),
    row(MITSUBA_0, ("bdpt", "bidirectional"), Unbiased, Whole, "Veach and Guibas 1994; Veach 1997, chapter 10"),
    row(MITSUBA_0, ("pssmlt", "metropolis"), Unbiased, Whole, METROPOLIS),
    row(MITSUBA_0, ("mlt", "metropolis"), Unbiased, Whole, METROPOLIS),
    row(
        MITSUBA_0,
        ("erpt", "energy_redistribution"),
        Unbiased,
        Whole,
        "Cline et al. 2005, without its filters, \"since they add bias\" (`erpt.cpp` of 0.6)",
    ),
    row(MITSUBA_0, ("sppm", "photon_map"), Consistent, Whole, PROGRESSIVE),
    row(MITSUBA_0, ("ppm", "photon_map"), Consistent, Whole, PROGRESSIVE),
    row(
        MITSUBA_0,
        ("photonmapper", "photon_mapping"),
        Biased,
        Whole,
        "Jensen 1996: a fixed number of photons, blurred over the nearest (manual of Mitsuba 0.6)",
    ),
    row(
        MITSUBA_0,
        ("vpl", "virtual_point_lights"),
        Biased,
        Whole,
        "Keller 1997: clamping loses energy, and glossy materials are made duller (`vpl.cpp` of 0.6)",
    ),
    row(
        MITSUBA_0,
        ("irrcache", "irradiance_caching"),
        Biased,
        Own,
        "Ward et al. 1988: irradiance is interpolated between points (manual of Mitsuba 0.6)",
    ),
    row(MITSUBA, ("direct", "path"), Unbiased, Always(2), "emission and direct light (manual of Mitsuba 0.6 and of 3)"),
    row(MITSUBA_0, ("ao", "ambient_occlusion"), Biased, Own, "no light transport (manual of Mitsuba 0.6)"),
    row(PBRT, ("path", "path"), Unbiased, Whole, PATH),
    row(
        PBRT,
        ("volpath", "path"),
        Unbiased,
        Whole,
        "path tracing that also scatters in media (file format of pbrt-v3 and pbrt-v4)",
    ),
    row(
        PBRT_4,
        ("simplepath", "path"),
        Unbiased,
        Whole,
        "path tracing without multiple importance sampling (file format of pbrt-v4)",
    ),
    row(PBRT_4, ("randomwalk", "path"), Unbiased, Whole, "paths that find lights by chance (file format of pbrt-v4)"),
    row(
        PBRT_4,
        ("lightpath", "light_tracing"),
        Unbiased,
        Whole,
        "the adjoint of path tracing (file format of pbrt-v4)",
    ),
    row(PBRT, ("bdpt", "bidirectional"), Unbiased, Whole, "Veach and Guibas 1994; Veach 1997, chapter 10"),
    row(PBRT, ("mlt", "metropolis"), Unbiased, Whole, "Kelemen et al. 2002; Hachisuka et al. 2014"),
    row(PBRT, ("sppm", "photon_map"), Consistent, Whole, "Hachisuka and Jensen 2009"),
    row(
        PBRT_3,
        ("directlighting", "direct"),
        Biased,
        Own,
        "direct light, and what mirrors and glass show of it: no other indirect light (`directlighting.cpp`)",
    ),
    row(
        PBRT_3,
        ("whitted", "direct"),
        Biased,
        Own,
        "Whitted 1980: no indirect light but by mirrors and glass (`whitted.cpp`)",
    ),
    row(
        PBRT,
        ("ambientocclusion", "ambient_occlusion"),
        Biased,
        Own,
        "no light transport (`ao.cpp`; file format of pbrt-v4)",
    ),
    row(LUXCORE, ("PATHCPU", "path"), Unbiased, Whole, PATH),
    row(LUXCORE, ("PATHOCL", "path"), Unbiased, Whole, PATH),
    row(
        LUXCORE,
        ("TILEPATHCPU", "path"),
        Unbiased,
        Whole,
        "path tracing tile by tile (LuxCore's wiki, render configuration)",
    ),
    row(
        LUXCORE,
        ("TILEPATHOCL", "path"),
        Unbiased,
        Whole,
        "path tracing tile by tile (LuxCore's wiki, render configuration)",
    ),
    row(
        LUXCORE,
        ("LIGHTCPU", "light_tracing"),
        Unbiased,
        Own,
        "paths from the lights; their depth is `light.maxdepth` (LuxCore's wiki)",
    ),
    row(
        LUXCORE,
        ("BIDIRCPU", "bidirectional"),
        Biased,
        Own,
        "eye and light paths are bounded each by itself; a Cornell box has 1.038 of its light at 32 and at 96 samples, where 1.007 is \
         all that longer paths can add (2.11.2)",
    ),
    row(LUXCORE, ("BIDIRVMCPU", "vertex_merging"), Consistent, Own, "Georgiev et al. 2012; Hachisuka et al. 2012"),
    row(CYCLES, ("CYCLES", "path"), Unbiased, Whole, PATH),
];

/// The algorithm that a target's renderer calls `native`.
pub fn find(target: &str, native: &str) -> Option<&'static Algorithm> {
    ALGORITHMS.iter().find(|one| one.native == native && one.targets.contains(&target))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_stands_once_and_belongs_to_a_target() {
        for (at, one) in ALGORITHMS.iter().enumerate() {
            for target in one.targets {
                assert!(super::super::find(target).is_some_and(|known| known.name == *target), "{target}");
                let same = |other: &&Algorithm| other.native == one.native && other.targets.contains(target);
                assert_eq!(ALGORITHMS.iter().position(|other| same(&other)), Some(at), "{} of {target}", one.native);
            }
        }
    }

    #[test]
    fn names_are_those_of_their_own_renderer() {
        let of = |target, native| find(target, native).map(|one| (one.family, one.convergence, one.depth));
        assert_eq!(of("mitsuba-0.5", "bdpt"), Some(("bidirectional", Unbiased, Whole)));
        assert_eq!(of("mitsuba-3", "bdpt"), None);
        assert_eq!(of("pbrt-v3", "sppm"), Some(("photon_map", Consistent, Whole)));
        assert_eq!(of("luxcore", "path"), None);
        assert_eq!(of("mitsuba-0.6", "vpl").map(|(_, convergence, _)| convergence), Some(Biased));
    }
}
