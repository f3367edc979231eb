//! Lights without a surface: the environment, points, and light from one direction.

use super::{Color, Vec3};

/// A light that is no surface. Emitters with a surface are [`super::Shape`]s with an emission.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSource {
    /// As the author wrote it, with the instances and loops around it; unique among all emitters of the scene.
    pub name: String,
    /// What it sends out.
    pub kind: LightKind,
}

/// What a light sends out, in scene coordinates. No light is seen by the camera but the environment.
///
/// | | Mitsuba | PBRT v3, v4 | LuxCore | glTF |
/// |---|---|---|---|---|
/// | `Environment` | `constant`, `radiance` | `infinite`, `L` | `constantinfinite`, `color` | cannot be said |
/// | `Point` | `point`, `position`, `intensity` | `point`, `from`, `I` | `point`, `position`, `color`, gain 4 pi | `KHR_lights_punctual` `point`, the node's place |
/// | `Directional` | `directional`, `direction`, `irradiance` | `distant`, `from` 0 0 0, `to` the direction, `L` | `sharpdistant`, `direction`, `color` | `KHR_lights_punctual` `directional`, along the node's -z |
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Light from everywhere behind the surfaces, the same from all directions; a scene has at most one.
    Environment {
        /// Radiance in W/(m2 sr), >= 0 per channel.
        radiance: Color,
    },
    /// A point that sends the same in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity in W/sr, >= 0 per channel. At the distance r the irradiance across the direction is intensity / r^2.
        intensity: Color,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Where the light travels to; needs no unit length, but has one.
        direction: Vec3,
        /// Irradiance in W/m2 on a surface across the direction, >= 0 per channel.
        irradiance: Color,
    },
}

impl LightKind {
    /// Its strength, whatever the unit.
    pub fn color(&self) -> &Color {
        match self {
            Self::Environment { radiance } => radiance,
            Self::Point { position: _, intensity } => intensity,
            Self::Directional { direction: _, irradiance } => irradiance,
        }
    }

    /// The constructor that makes it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Environment { radiance: _ } => "environment",
            Self::Point { position: _, intensity: _ } => "point",
            Self::Directional { direction: _, irradiance: _ } => "directional",
        }
    }
}
