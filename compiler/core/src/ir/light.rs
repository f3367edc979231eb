//! Lights without a surface: the environment, points, spots, and light from one direction.

use super::{Affine, Color, ColorOrTexture, Handle, Texture, Vec3};

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
/// | `Environment` | `constant`, `radiance`; `envmap` | `infinite`, `L`; v3 `mapname`, v4 `filename` | `constantinfinite`, `color`; `infinite` | cannot be said |
/// | `Point` | `point`, `position`, `intensity` | `point`, `from`, `I` | `point`, `position`, `color`, gain 4 pi | `KHR_lights_punctual` `point`, the node's place |
/// | `Spot` | `spot`, `cutoff_angle`, `beam_width` | `spot`, `coneangle`, `conedeltaangle` | `spot` | `KHR_lights_punctual` `spot` |
/// | `Directional` | `directional`, `direction`, `irradiance` | `distant`, `from` 0 0 0, `to` the direction, `L` | `sharpdistant`, `direction`, `color` | `KHR_lights_punctual` `directional`, along the node's -z |
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Light from everywhere behind the surfaces, the same from all directions or by an image; a scene has at most one.
    Environment {
        /// Radiance in W/(m2 sr), >= 0 per channel. An image holds all directions: its middle is +y, the right edge and the left
        /// one are -y, a quarter of the width to the right of the middle is +x, its upper edge is +z.
        radiance: ColorOrTexture,
        /// A factor of an image, >= 0 per channel; 1 for a color, which says its own strength.
        tint: Color,
        /// A rotation of an image: from the directions above to those in which it is seen. None for a color.
        turn: Affine,
    },
    /// A point that sends the same in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity in W/sr, >= 0 per channel. At the distance r the irradiance across the direction is intensity / r^2.
        intensity: Color,
    },
    /// A point that sends light into a cone: the whole intensity within `inner` of the axis, from there linearly with the
    /// angle to nothing at `angle` (`spot` of all Mitsubas).
    Spot {
        /// Where it is.
        position: Vec3,
        /// A point on the axis, not equal to `position`.
        target: Vec3,
        /// Radiant intensity in W/sr within `inner` of the axis, >= 0 per channel.
        intensity: Color,
        /// Half of the cone's opening in degrees, 0 < angle <= 90.
        angle: f64,
        /// Half of the opening of the inner cone in degrees, 0 <= inner <= angle; equal to `angle` for a sharp edge.
        inner: f64,
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
    /// An environment as it is, neither tinted nor turned.
    pub fn environment(radiance: ColorOrTexture) -> Self {
        Self::Environment { radiance, tint: Color::Grey(1.0), turn: Affine::IDENTITY }
    }

    /// The image that says how much comes from where, if there is one.
    pub fn texture(&self) -> Option<Handle<Texture>> {
        match self {
            Self::Environment { radiance, tint: _, turn: _ } => radiance.texture(),
            Self::Point { position: _, intensity: _ }
            | Self::Spot { position: _, target: _, intensity: _, angle: _, inner: _ }
            | Self::Directional { direction: _, irradiance: _ } => None,
        }
    }

    /// Its strength, whatever the unit; of an image its tint.
    pub fn color(&self) -> &Color {
        match self {
            Self::Environment { radiance, tint, turn: _ } => radiance.color().unwrap_or(tint),
            Self::Point { position: _, intensity } => intensity,
            Self::Spot { position: _, target: _, intensity, angle: _, inner: _ } => intensity,
            Self::Directional { direction: _, irradiance } => irradiance,
        }
    }

    /// The constructor that makes it.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Environment { radiance: _, tint: _, turn: _ } => "environment",
            Self::Point { position: _, intensity: _ } => "point",
            Self::Spot { position: _, target: _, intensity: _, angle: _, inner: _ } => "spot",
            Self::Directional { direction: _, irradiance: _ } => "directional",
        }
    }
}
