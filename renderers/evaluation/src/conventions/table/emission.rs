//! Conventions of lamps and of the length of paths.

use ltsc_core::capability::Feature;

use super::super::formula::furnace;
use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "emitter_radiance",
        &[Feature::BlackEmitter, Feature::ColoredEmitter],
        &[View::plain(&[
            lamp("red", Channel::Red, Expected::Number(0.5)),
            lamp("green", Channel::Green, Expected::Number(2.0)),
            lamp("blue", Channel::Blue, Expected::Number(30.0)),
        ])]
    ),
    convention!(
        "emitter_side",
        &[Feature::BlackEmitter, Feature::Diffuse],
        &[View::plain(&[
            check("the back", Measure::Mean(area(0.4, 0.6, 0.34, 0.43), Channel::All), Expected::Number(0.0), DARK),
            check(
                "behind the back",
                Measure::Mean(area(0.3, 0.7, 0.6, 0.75), Channel::All),
                Expected::Number(0.0),
                DARK
            ),
            check(
                "before the front",
                Measure::Mean(area(0.38, 0.62, 0.19, 0.28), Channel::All),
                Expected::Ideal,
                Tolerance::Share(0.01),
            ),
        ])]
    ),
    convention!(
        "path_depth",
        &[
            Feature::Path,
            Feature::EmissionOnly,
            Feature::IndirectLight,
            Feature::Diffuse,
            Feature::ScatteringEmitter,
            Feature::IndependentSampler
        ],
        &[
            View {
                name: "depth 1",
                depth: Some(1),
                ..View::plain(&[Check {
                    rests_on: &[Feature::EmissionOnly],
                    ..furnace_of(Expected::Formula(|| furnace(0.8, 1)))
                },])
            },
            View {
                name: "depth 2",
                depth: Some(2),
                ..View::plain(&[furnace_of(Expected::Formula(|| furnace(0.8, 2)))])
            },
            View {
                name: "depth 3",
                depth: Some(3),
                ..View::plain(&[furnace_of(Expected::Formula(|| furnace(0.8, 3)))])
            },
        ]
    ),
    convention!(
        "specular_depth",
        &[Feature::Path, Feature::DimMirror, Feature::IndirectLight],
        &[View::plain(&[
            band("no mirror", 15.0, Expected::Number(1.0)),
            band("one mirror", 11.0, Expected::Number(0.5)),
            band("two mirrors", 7.0, Expected::Number(0.25)),
            band("three mirrors", 3.0, Expected::Number(0.125)),
            check(
                "four mirrors",
                Measure::Mean(area(0.0, 1.0, 0.0, 1.0 / 32.0), Channel::All),
                Expected::Number(0.0),
                DARK,
            ),
        ])]
    ),
    convention!(
        "cube_furnace",
        &[
            Feature::Path,
            Feature::IndirectLight,
            Feature::Diffuse,
            Feature::ScatteringEmitter,
            Feature::IndependentSampler
        ],
        // A standard error of 0.03 %.
        &[View::plain(&[check(
            "depth 10",
            Measure::Mean(Region::ALL, Channel::All),
            Expected::Formula(|| furnace(0.8, 10)),
            Tolerance::Share(2e-3),
        )])]
    ),
    convention!(
        "algorithms",
        &[
            Feature::Bidirectional,
            Feature::LightTracing,
            Feature::Metropolis,
            Feature::PhotonMap,
            Feature::IndependentSampler,
            Feature::SobolSampler,
            Feature::SobolForLightPaths,
        ],
        &[
            View {
                name: "bidirectional",
                set: &[("algorithm", "\"bidirectional\"")],
                ..View::plain(&[found(BIDIRECTIONAL)])
            },
            View {
                name: "light tracing",
                set: &[("algorithm", "\"light_tracing\"")],
                ..View::plain(&[found(LIGHT_TRACING)])
            },
            View { name: "Metropolis", set: &[("algorithm", "\"metropolis\"")], ..View::plain(&[found(METROPOLIS)]) },
            View { name: "photon map", set: &[("algorithm", "\"photon_map\"")], ..View::plain(&[found(PHOTON_MAP)]) },
            View { name: "Sobol", set: &[("points", "\"sobol\"")], ..View::plain(&[found(SOBOL)]) },
            View {
                name: "Sobol, Metropolis",
                set: &[("algorithm", "\"metropolis\""), ("points", "\"sobol\"")],
                ..View::plain(&[found(SOBOL_METROPOLIS)])
            },
        ]
    ),
];

const BIDIRECTIONAL: &[Feature] = &[Feature::Bidirectional];
const LIGHT_TRACING: &[Feature] = &[Feature::LightTracing];
const METROPOLIS: &[Feature] = &[Feature::Metropolis];
const PHOTON_MAP: &[Feature] = &[Feature::PhotonMap];
const SOBOL: &[Feature] = &[Feature::SobolSampler];
const SOBOL_METROPOLIS: &[Feature] = &[Feature::Metropolis, Feature::SobolForLightPaths];

const LESS: &[Known] = &[Known {
    target: Some("pbrt-v4"),
    by: By::Feature(Feature::LightTracing, "17 % less in a closed cube"),
    within: Within::Ratio(0.82, 0.84),
}];

const fn found(rests_on: &'static [Feature]) -> Check {
    Check {
        rests_on,
        known: if matches!(rests_on, [Feature::LightTracing]) { LESS } else { &[] },
        ..check(
            "middle of a face",
            Measure::Mean(area(0.25, 0.75, 0.25, 0.75), Channel::All),
            Expected::Formula(|| furnace(0.8, 3)),
            Tolerance::Share(0.01),
        )
    }
}

const DARK: Tolerance = Tolerance::Plain(1e-4);

const fn lamp(name: &'static str, channel: Channel, expected: Expected) -> Check {
    Check {
        rests_on: &[Feature::ColoredEmitter],
        ..check(name, Measure::Mean(Region::ALL, channel), expected, Tolerance::Share(1e-3))
    }
}

const fn furnace_of(expected: Expected) -> Check {
    check("inside", Measure::Mean(Region::ALL, Channel::All), expected, Tolerance::Share(5e-3))
}

/// Two rows from `top` of 32, in the middle of a band of four.
const fn band(name: &'static str, top: f64, expected: Expected) -> Check {
    let region = area(0.0, 1.0, top / 32.0, (top + 2.0) / 32.0);
    Check {
        known: &[Known {
            target: Some("pbrt-v4"),
            by: By::Feature(Feature::DimMirror, "0.820 for 0.5"),
            // Up to three reflections at 77 to 87 degrees.
            within: Within::Ratio(1.0, 5.0),
        }],
        ..check(name, Measure::Mean(region, Channel::All), expected, Tolerance::Share(1e-3))
    }
}
