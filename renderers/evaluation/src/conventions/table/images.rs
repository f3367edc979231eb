//! Conventions of images: on surfaces, and of the environment.

use ltsc_core::capability::Feature;

use super::super::kinds::{
    By, Channel, Check, Convention, Expected, Known, Measure, Region, Tolerance, View, Within, area,
};
use super::{check, convention};

pub(super) const ROWS: &[Convention] = &[
    convention!(
        "texture_quarters",
        TEXTURES,
        &[
            quarters("sRGB in PNG of 8 bits", &[("file", "\"images/quarters.png\"")], SRGB),
            quarters("sRGB in PNG of 16 bits", &[("file", "\"images/quarters_16.png\"")], SRGB),
            quarters("sRGB in JPEG", &[("file", "\"images/quarters.jpg\"")], SRGB),
            quarters("linear in PNG of 8 bits", &[("file", "\"images/quarters.png\""), LINEAR], CODES),
            quarters("linear in PNG of 16 bits", &[("file", "\"images/quarters_16.png\""), LINEAR], CODES),
            quarters("linear in JPEG", &[("file", "\"images/quarters.jpg\""), LINEAR], CODES),
            quarters("OpenEXR", &[("file", "\"images/quarters.exr\""), LINEAR], FLOATS),
            quarters("PFM", &[("file", "\"images/quarters.pfm\""), LINEAR], FLOATS),
            quarters("Radiance HDR", &[("file", "\"images/quarters.hdr\""), LINEAR], FLOATS),
        ]
    ),
    convention!(
        "texture_interpolation",
        TEXTURES,
        &[
            quarters("sRGB in PNG of 8 bits", &[("file", "\"images/edge.png\"")], RAMP),
            quarters("sRGB in PNG of 16 bits", &[("file", "\"images/edge_16.png\"")], RAMP),
            quarters("sRGB in JPEG", &[("file", "\"images/edge.jpg\"")], RAMP),
            quarters("linear in PNG of 8 bits", &[("file", "\"images/edge.png\""), LINEAR], RAMP),
            quarters("linear in PNG of 16 bits", &[("file", "\"images/edge_16.png\""), LINEAR], RAMP),
            quarters("linear in JPEG", &[("file", "\"images/edge.jpg\""), LINEAR], RAMP),
            quarters("OpenEXR", &[("file", "\"images/edge.exr\""), LINEAR], RAMP),
            quarters("PFM", &[("file", "\"images/edge.pfm\""), LINEAR], RAMP),
            quarters("Radiance HDR", &[("file", "\"images/edge.hdr\""), LINEAR], RAMP),
        ]
    ),
    convention!(
        "texture_colors",
        &[Feature::ColoredTexture, Feature::TextureCoordinates, Feature::ScaledTexture],
        &[
            View::plain(&[
                tone("upper left, red", UPPER_LEFT, Channel::Red, 0.577_580),
                tone("upper left, green", UPPER_LEFT, Channel::Green, 0.045_186),
                tone("upper left, blue", UPPER_LEFT, Channel::Blue, 0.012_983),
                tone("upper right, green", UPPER_RIGHT, Channel::Green, 0.456_411),
                tone("upper right, blue", UPPER_RIGHT, Channel::Blue, 0.102_242),
                tone("lower left, red", LOWER_LEFT, Channel::Red, 0.012_983),
                tone("lower left, blue", LOWER_LEFT, Channel::Blue, 0.715_694),
                tone("lower right, red", LOWER_RIGHT, Channel::Red, 0.351_533),
                tone("lower right, blue", LOWER_RIGHT, Channel::Blue, 0.021_219),
            ]),
            quarters(
                "with a factor",
                &[("factor", "rgb(0.5, 0.25, 0.75)")],
                &[
                    tone("upper left, red", UPPER_LEFT, Channel::Red, 0.288_790),
                    tone("upper right, green", UPPER_RIGHT, Channel::Green, 0.114_103),
                    tone("lower left, blue", LOWER_LEFT, Channel::Blue, 0.536_770),
                ]
            )
        ]
    ),
    convention!(
        "environment_image",
        &[Feature::EnvironmentImage, Feature::TurnedEnvironment, Feature::TintedEnvironment],
        &[
            View { name: "along +y", set: &[], ..View::plain(SKY) },
            View { name: "along -y", set: &[("y", "-1")], ..View::plain(SKY) },
            View { name: "along +x", set: &[("x", "1"), ("y", "0")], ..View::plain(SKY) },
            View { name: "along -x", set: &[("x", "-1"), ("y", "0")], ..View::plain(SKY) },
            View { name: "along +z", set: &[("z", "1"), ("y", "0")], ..View::plain(SKY) },
            View { name: "along -z", set: &[("z", "-1"), ("y", "0")], ..View::plain(SKY) },
            View {
                name: "turned, along +y",
                set: &[("turn", "70deg"), ("scale", "3"), ("red", "0.5"), ("blue", "2")],
                ..View::plain(SKY)
            },
            View {
                name: "turned, along -x",
                set: &[("x", "-1"), ("y", "0"), ("turn", "70deg"), ("scale", "3"), ("red", "0.5"), ("blue", "2"),],
                ..View::plain(SKY)
            },
            View {
                name: "turned, along +z",
                set: &[("z", "1"), ("y", "0"), ("turn", "70deg"), ("scale", "3"), ("red", "0.5"), ("blue", "2"),],
                ..View::plain(SKY)
            },
        ]
    ),
];

const TEXTURES: &[Feature] = &[
    Feature::Texture,
    Feature::SrgbTexture,
    Feature::LinearTexture,
    Feature::DeepTexture,
    Feature::JpegTexture,
    Feature::LinearJpegTexture,
    Feature::ExrTexture,
    Feature::PfmTexture,
    Feature::HdrTexture,
];

const LINEAR: (&str, &str) = ("encoding", "\"linear\"");

const fn quarters(name: &'static str, set: &'static [(&'static str, &'static str)], checks: &'static [Check]) -> View {
    View { name, set, ..View::plain(checks) }
}

/// The middle of a quarter, where neither its neighbors nor the repeated image on the other side show.
const UPPER_LEFT: Region = area(0.125, 0.375, 0.125, 0.375);
const UPPER_RIGHT: Region = area(0.625, 0.875, 0.125, 0.375);
const LOWER_LEFT: Region = area(0.125, 0.375, 0.625, 0.875);
const LOWER_RIGHT: Region = area(0.625, 0.875, 0.625, 0.875);

/// The code of a quarter by the sRGB curve.
const SRGB: &[Check] = &[
    level("upper left", UPPER_LEFT, 0.012_983),
    level("upper right", UPPER_RIGHT, 0.215_861),
    level("lower left", LOWER_LEFT, 0.577_580),
    level("lower right", LOWER_RIGHT, 1.0),
];

/// The code of a quarter as a share.
const CODES: &[Check] = &[
    level("upper left", UPPER_LEFT, 30.0 / 255.0),
    level("upper right", UPPER_RIGHT, 128.0 / 255.0),
    level("lower left", LOWER_LEFT, 200.0 / 255.0),
    level("lower right", LOWER_RIGHT, 1.0),
];

const FLOATS: &[Check] = &[
    level("upper left", UPPER_LEFT, 0.125),
    level("upper right", UPPER_RIGHT, 0.25),
    level("lower left", LOWER_LEFT, 0.5),
    level("lower right", LOWER_RIGHT, 1.0),
];

/// 64 pixels of 64 samples, all of which have one value but in spectral renderers.
const fn level(name: &'static str, region: Region, value: f64) -> Check {
    check(name, Measure::Mean(region, Channel::All), Expected::Number(value), Tolerance::Share(5e-3))
}

const fn tone(name: &'static str, region: Region, channel: Channel, value: f64) -> Check {
    check(name, Measure::Mean(region, channel), Expected::Number(value), Tolerance::Plain(2e-3))
}

/// From the middle of a black pixel to that of a white one.
const RAMP: &[Check] = &[
    ramp("the first quarter", area(0.0, 0.25, 0.0, 1.0), 0.125),
    ramp("the whole", Region::ALL, 0.5),
    ramp("the last quarter", area(0.75, 1.0, 0.0, 1.0), 0.875),
];

const fn ramp(name: &'static str, region: Region, value: f64) -> Check {
    check(name, Measure::Mean(region, Channel::All), Expected::Number(value), Tolerance::Plain(4e-3))
}

/// The sky in the quarters of the image, where each has another color, and the whole.
const SKY: &[Check] = &[
    sky("upper left, red", area(0.0, 0.5, 0.0, 0.5), Channel::Red),
    sky("upper left, green", area(0.0, 0.5, 0.0, 0.5), Channel::Green),
    sky("upper left, blue", area(0.0, 0.5, 0.0, 0.5), Channel::Blue),
    sky("upper right, red", area(0.5, 1.0, 0.0, 0.5), Channel::Red),
    sky("upper right, green", area(0.5, 1.0, 0.0, 0.5), Channel::Green),
    sky("upper right, blue", area(0.5, 1.0, 0.0, 0.5), Channel::Blue),
    sky("lower left, all", area(0.0, 0.5, 0.5, 1.0), Channel::All),
    sky("lower right, all", area(0.5, 1.0, 0.5, 1.0), Channel::All),
];

/// Only where samples lie within pixels is left to chance.
const fn sky(name: &'static str, region: Region, channel: Channel) -> Check {
    Check {
        known: POLES,
        rests_on: &[Feature::EnvironmentImage],
        ..check(name, Measure::Mean(region, channel), Expected::Ideal, Tolerance::Share(5e-3))
    }
}

/// A pole is half a row of 16, or two pixels of the film, in a quarter of 16 x 16.
const POLES: &[Known] = &[mixed("luxcore"), mixed("cycles"), mixed("pbrt-v3")];

const fn mixed(target: &'static str) -> Known {
    let by = By::Feature(Feature::EnvironmentImage, "half a row of pixels at each pole");
    Known { target: Some(target), by, within: Within::Ratio(0.985, 1.015) }
}
