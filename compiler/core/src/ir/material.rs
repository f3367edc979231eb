//! Materials: how a surface scatters light.

use super::{Color, ColorOrTexture, Handle, Texture};

/// A named scattering function.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the author wrote it; need not be a word.
    pub name: String,
    /// What it does.
    pub bsdf: Bsdf,
}

/// The four basic scattering functions. Diffuse, conductor and mirror scatter on both sides alike.
///
/// | | Mitsuba | PBRT v3 | PBRT v4 | LuxCore | glTF |
/// |---|---|---|---|---|---|
/// | `Diffuse` | `twosided`, `diffuse` | `matte` | `diffuse` | `matte` | metallic 0, roughness 1, specular 0 |
/// | `Conductor` | `twosided`, `roughconductor` ggx | `metal` | `conductor` | `metal2` | metallic 1, roughness sqrt(alpha) |
/// | `Dielectric` | `dielectric`, `roughdielectric` ggx | `glass` | `dielectric` | `glass` | transmission, volume, ior |
/// | `Mirror` | `twosided`, `conductor` none | `mirror` | `conductor` reflectance | `mirror` | metallic 1, roughness 0 |
#[derive(Clone, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian reflection.
    Diffuse {
        /// Share of light reflected, 0..1 per channel.
        reflectance: ColorOrTexture,
    },
    /// Metal: GGX microfacets with the Fresnel term of a complex index of refraction against vacuum.
    Conductor {
        /// Real part of the index of refraction, > 0 per channel.
        eta: Color,
        /// Imaginary part (extinction), >= 0 per channel.
        k: Color,
        /// GGX width, >= 0; 0 is smooth.
        alpha: f64,
    },
    /// Clear glass or water: reflects and refracts, absorbs nothing. Radiance scales with the square of the relative
    /// index of refraction when it is refracted.
    Dielectric {
        /// Index of refraction behind the normals, > 0.
        interior: f64,
        /// Index of refraction in front of the normals, > 0.
        exterior: f64,
        /// GGX width, >= 0; 0 is smooth.
        alpha: f64,
    },
    /// Ideal specular reflection without a Fresnel term.
    Mirror {
        /// Share of light reflected, 0..1 per channel.
        reflectance: Color,
    },
}

impl Bsdf {
    /// What kind of scattering it is, in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Diffuse { reflectance: _ } => "diffuse",
            Self::Conductor { eta: _, k: _, alpha } if *alpha == 0.0 => "smooth conductor",
            Self::Conductor { eta: _, k: _, alpha: _ } => "rough conductor",
            Self::Dielectric { interior: _, exterior: _, alpha } if *alpha == 0.0 => "smooth dielectric",
            Self::Dielectric { interior: _, exterior: _, alpha: _ } => "rough dielectric",
            Self::Mirror { reflectance: _ } => "mirror",
        }
    }

    /// Whether it is known to scatter no light at all. What a texture holds is not known.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Diffuse { reflectance } => reflectance.color().is_some_and(Color::is_black),
            Self::Mirror { reflectance } => reflectance.is_black(),
            Self::Conductor { eta: _, k: _, alpha: _ } | Self::Dielectric { interior: _, exterior: _, alpha: _ } => {
                false
            }
        }
    }

    /// What may be a texture in it.
    fn paint(&self) -> Option<&ColorOrTexture> {
        match self {
            Self::Diffuse { reflectance } => Some(reflectance),
            Self::Conductor { eta: _, k: _, alpha: _ }
            | Self::Dielectric { interior: _, exterior: _, alpha: _ }
            | Self::Mirror { reflectance: _ } => None,
        }
    }

    /// The texture that colours it, if one does.
    pub fn texture(&self) -> Option<Handle<Texture>> {
        self.paint().and_then(ColorOrTexture::texture)
    }

    /// The same scattering with another texture in the place of the one that it has.
    #[must_use]
    pub fn with_texture(&self, texture: Handle<Texture>) -> Self {
        let changed = |paint: &ColorOrTexture| match paint {
            ColorOrTexture::Color(color) => ColorOrTexture::Color(*color),
            ColorOrTexture::Texture(_) => ColorOrTexture::Texture(texture),
        };
        match self {
            Self::Diffuse { reflectance } => Self::Diffuse { reflectance: changed(reflectance) },
            Self::Conductor { eta: _, k: _, alpha: _ }
            | Self::Dielectric { interior: _, exterior: _, alpha: _ }
            | Self::Mirror { reflectance: _ } => self.clone(),
        }
    }
}
