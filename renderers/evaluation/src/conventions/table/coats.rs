//! Conventions of coated and principled materials, and of spectra.

use ltsc_core::capability::Feature;

use super::super::formula::coated;
use super::super::kinds::{By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "plastic",
        &[Feature::Plastic],
        &[
            View {
                name: "alpha 0, 0 degrees",
                set: &[("alpha", "0"), ("turn", "0deg")],
                ..View::plain(&[smooth(|| coated(0.5, 1.5, 0.0))])
            },
            View {
                name: "alpha 0, 60 degrees",
                set: &[("alpha", "0"), ("turn", "60deg")],
                ..View::plain(&[smooth(|| coated(0.5, 1.5, 60.0))])
            },
            View {
                name: "alpha 0, 80 degrees",
                set: &[("alpha", "0"), ("turn", "80deg")],
                ..View::plain(&[smooth(|| coated(0.5, 1.5, 80.0))])
            },
            View {
                name: "alpha 0.1, 0 degrees",
                set: &[("alpha", "0.1"), ("turn", "0deg")],
                ..View::plain(&[rough(0.30872)])
            },
            View {
                name: "alpha 0.1, 60 degrees",
                set: &[("alpha", "0.1"), ("turn", "60deg")],
                ..View::plain(&[rough(0.34006)])
            },
            View {
                name: "alpha 0.1, 80 degrees",
                set: &[("alpha", "0.1"), ("turn", "80deg")],
                ..View::plain(&[rough(0.44700)])
            },
            View {
                name: "alpha 0.3, 0 degrees",
                set: &[("alpha", "0.3"), ("turn", "0deg")],
                ..View::plain(&[rough(0.27770)])
            },
            View {
                name: "alpha 0.3, 60 degrees",
                set: &[("alpha", "0.3"), ("turn", "60deg")],
                ..View::plain(&[rough(0.28569)])
            },
            View {
                name: "alpha 0.3, 80 degrees",
                set: &[("alpha", "0.3"), ("turn", "80deg")],
                ..View::plain(&[rough(0.30982)])
            },
        ]
    ),
    convention!(
        "principled",
        &[Feature::Principled],
        &[
            View { name: "no metal, 0 degrees", set: &[("turn", "0deg")], ..View::plain(&[burley(0.53706)]) },
            View { name: "no metal, 60 degrees", set: &[("turn", "60deg")], ..View::plain(&[burley(0.58123)]) },
            View { name: "no metal, 80 degrees", set: &[("turn", "80deg")], ..View::plain(&[burley(0.72269)]) },
            View {
                name: "metal, 0 degrees",
                set: &[("metallic", "1"), ("turn", "0deg")],
                ..View::plain(&[burley(0.49412)])
            },
            View {
                name: "metal, 60 degrees",
                set: &[("metallic", "1"), ("turn", "60deg")],
                ..View::plain(&[burley(0.50071)])
            },
            View {
                name: "metal, 80 degrees",
                set: &[("metallic", "1"), ("turn", "80deg")],
                ..View::plain(&[burley(0.56339)])
            },
            View { name: "half metal, 0 degrees", set: HALF_0, ..View::plain(&[burley(0.49900)]) },
            View { name: "half metal, 60 degrees", set: HALF_60, ..View::plain(&[burley(0.505)]) },
            View { name: "half metal, 80 degrees", set: HALF_80, ..View::plain(&[burley(0.560)]) },
        ]
    ),
    convention!(
        "textured_plastic",
        &[Feature::TexturedPlastic],
        &[
            View { name: "of 0.2", ..View::plain(&[under(|| coated(0.2, 1.5, 0.0))]) },
            View { name: "of 0.8", set: LIGHT, ..View::plain(&[under(|| coated(0.8, 1.5, 0.0))]) },
        ]
    ),
    convention!(
        "textured_principled",
        &[Feature::TexturedPrincipled],
        &[
            View { name: "of 0.2", ..View::plain(&[over(0.238_61)]) },
            View { name: "of 0.8", set: LIGHT, ..View::plain(&[over(0.835_51)]) },
        ]
    ),
    convention!(
        "spectrum",
        &[Feature::Spectrum],
        &[
            View { name: "reflectance", set: &[("card", "\"moss\"")], ..View::plain(MOSS) },
            View { name: "light", set: &[("light", "\"warm\"")], ..View::plain(WARM) },
            View { name: "both", set: &[("card", "\"moss\""), ("light", "\"warm\"")], ..View::plain(BOTH) },
        ]
    ),
];

const HALF_0: &[(&str, &str)] = &[("metallic", "0.5"), ("roughness", "0.5"), ("turn", "0deg")];
const HALF_60: &[(&str, &str)] = &[("metallic", "0.5"), ("roughness", "0.5"), ("turn", "60deg")];
const HALF_80: &[(&str, &str)] = &[("metallic", "0.5"), ("roughness", "0.5"), ("turn", "80deg")];

const LIGHT: &[(&str, &str)] = &[("file", "\"images/light.png\"")];

const fn under(formula: fn() -> f64) -> Check {
    albedo(Expected::Formula(formula), TEXTURED_PLASTIC)
}

const fn over(value: f64) -> Check {
    albedo(Expected::Reference { value, by: MITSUBA }, TEXTURED_PRINCIPLED)
}

/// An albedo that a target states for a feature to be off by so much.
const fn off(target: &'static str, feature: Feature, words: &'static str, by: f64) -> Known {
    Known { target: Some(target), by: By::Feature(feature, words), within: Within::Distance(by) }
}

const TEXTURED_PLASTIC: &[Known] = &[
    off("luxcore", Feature::TexturedPlastic, "0.46 instead of 0.62 for 0.8", 0.165),
    off("cycles", Feature::TexturedPlastic, "0.8 instead of 0.62", 0.19),
    off("pbrt-v4", Feature::TexturedPlastic, "0.618 for 0.633", 0.016),
    off("pbrt-v3", Feature::TexturedPlastic, "0.46 instead of 0.62 for 0.8", 0.17),
];

const TEXTURED_PRINCIPLED: &[Known] = &[
    known("luxcore", Feature::TexturedPrincipled, "0.84, 0.83, 0.84 of Mitsuba 3.9.1 without metal", (0.82, 1.0)),
    known("cycles", Feature::TexturedPrincipled, "3, 7 and 15 % darker", (0.84, 1.005)),
    off("pbrt-v4", Feature::TexturedPrincipled, "seen 0.135 where 0.2 is asked for, 1 where 0.8 is asked for", 0.2),
    known("pbrt-v3", Feature::TexturedPrincipled, "darker by 15 to 21 % with 0.5", (0.78, 1.013)),
];

/// 500 000 samples: a standard error below 0.1 %.
const fn smooth(formula: fn() -> f64) -> Check {
    albedo(Expected::Formula(formula), PLASTIC)
}

const fn rough(value: f64) -> Check {
    albedo(Expected::Reference { value, by: MITSUBA }, PLASTIC)
}

const fn burley(value: f64) -> Check {
    albedo(Expected::Reference { value, by: MITSUBA }, PRINCIPLED)
}

const MITSUBA: &str = "Mitsuba 3.9.1, 4.2 million samples";

const fn albedo(expected: Expected, known: &'static [Known]) -> Check {
    Check { known, ..check("albedo", Measure::Mean(Region::ALL, Channel::All), expected, Tolerance::Share(5e-3)) }
}

/// A ratio of the albedo that a target states for a feature.
const fn known(target: &'static str, feature: Feature, words: &'static str, within: (f64, f64)) -> Known {
    Known { target: Some(target), by: By::Feature(feature, words), within: Within::Ratio(within.0, within.1) }
}

const PLASTIC: &[Known] = &[
    known(
        "luxcore",
        Feature::Plastic,
        "1.00, 0.98, 1.21 of Mitsuba 3.9.1 for `alpha` 0, 1.01, 1.00, 1.23 for 0.1",
        (0.975, 1.245),
    ),
    known(
        "cycles",
        Feature::Plastic,
        "within 0.4 % for a smooth coat, up to 3 % brighter at `alpha` 0.1",
        (0.995, 1.19),
    ),
    known("pbrt-v4", Feature::Plastic, "0.279, 0.287, 0.324 for 0.278, 0.286, 0.310 at 0.3", (0.99, 1.05)),
    known("pbrt-v3", Feature::Plastic, "0.97, 0.80, 0.90 of Mitsuba's albedo at `alpha` 0", (0.73, 1.08)),
];

const PRINCIPLED: &[Known] = &[
    known("luxcore", Feature::Principled, "0.84, 0.83, 0.84 of Mitsuba 3.9.1 without metal", (0.82, 1.0)),
    known("cycles", Feature::Principled, "3, 7 and 15 % darker", (0.84, 1.005)),
    known("pbrt-v4", Feature::Principled, "without metal 0.4977, 0.5174 for 0.538, 0.582", (0.79, 1.03)),
    known("pbrt-v3", Feature::Principled, "the port pbrt-r3 3.2.0 differs", (0.69, 1.51)),
];

/// The product of two colors stands for that of two spectra: up to 16 % of the largest channel off.
const PRODUCT: &[Known] = &[rgb("mitsuba-3"), rgb("luxcore"), rgb("cycles"), rgb("pbrt-v3")];

const fn rgb(target: &'static str) -> Known {
    let words = "each further product of colors differs, of saturated ones by up to 16 % of the largest channel";
    Known { target: Some(target), by: By::Feature(Feature::Spectrum, words), within: Within::Distance(0.16 * 0.49) }
}

const MOSS: &[Check] = &[
    color("red", Channel::Red, 0.29414),
    color("green", Channel::Green, 0.40050),
    color("blue", Channel::Blue, 0.09953),
];
const WARM: &[Check] = &[
    color("red", Channel::Red, 0.85331),
    color("green", Channel::Green, 0.40488),
    color("blue", Channel::Blue, 0.15171),
];
const BOTH: &[Check] = &[
    Check { known: PRODUCT, ..color("red", Channel::Red, 0.49007) },
    Check { known: PRODUCT, ..color("green", Channel::Green, 0.33174) },
    Check { known: PRODUCT, ..color("blue", Channel::Blue, 0.01191) },
];

const fn color(name: &'static str, channel: Channel, expected: f64) -> Check {
    check(name, Measure::Mean(Region::ALL, channel), Expected::Number(expected), Tolerance::Plain(2e-3))
}
