//! Materials: how a surface scatters light.

use super::{Color, ColorOrTexture, Handle, Texture};

/// A named scattering function.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the author wrote it; need not be a word.
    pub name: String,
    /// What it does.
    pub bsdf: Bsdf,
    /// On which sides of a surface it does it.
    pub sides: Sides,
}

/// The sides of a surface on which its material scatters light; a dielectric has no sides.
///
/// | | Mitsuba | PBRT | LuxCore | Cycles | glTF |
/// |---|---|---|---|---|---|
/// | `Both` | within `twosided` | the material | the material | the shader | `doubleSided` |
/// | `Front` | without it | cannot be said | `twosided`, a black `backmaterial` | mixed with black by `Backfacing` | no `doubleSided`: not seen at all |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sides {
    /// On both alike.
    #[default]
    Both,
    /// On the side of the normals; from behind the surface is black, and lets no light through.
    Front,
}

/// Scattering functions: four basic ones, which renderers share, and two that each renderer has in a way of its own. All but the
/// dielectric scatter on both sides alike, unless the material says otherwise ([`Sides`]).
///
/// | | Mitsuba | PBRT v3 | PBRT v4 | LuxCore | glTF |
/// |---|---|---|---|---|---|
/// | `Diffuse` | `twosided`, `diffuse` | `matte` | `diffuse` | `matte` | metallic 0, roughness 1, specular 0 |
/// | `Conductor` | `twosided`, `roughconductor` ggx | `metal` | `conductor` | `metal2` | metallic 1, roughness sqrt(alpha) |
/// | `Dielectric` | `dielectric`, `roughdielectric` ggx | `glass` | `dielectric` | `glass` | transmission, volume, ior |
/// | `Mirror` | `twosided`, `conductor` none | `mirror` | `conductor` reflectance | `mirror` | metallic 1, roughness 0 |
/// | `Plastic` | `twosided`, `plastic`, `roughplastic` ggx, nonlinear | `substrate` | `coateddiffuse` | `glossy2` | metallic 0, ior |
/// | `Principled` | `twosided`, `principled`; 0.x a blend | `disney` | a mix | `disney` | metallic, roughness, ior |
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
    /// A Lambertian base under a clear coat. Light that the coat throws back from inside meets the base again, so that what is
    /// seen of the base is darker and more saturated than `reflectance`: Mitsuba's `plastic` and `roughplastic` with `nonlinear`.
    Plastic {
        /// Share of light that the base reflects, 0..1 per channel.
        reflectance: ColorOrTexture,
        /// Index of refraction of the coat against vacuum, > 1.
        ior: f64,
        /// GGX width of the coat, >= 0; 0 is smooth.
        alpha: f64,
    },
    /// A blend of a coated base and a metal, made for artists: Mitsuba 3's `principled` with nothing else switched on, which
    /// follows Burley, "Physically Based Shading at Disney" (2012).
    Principled {
        /// Color of the base, and of the metal head-on, 0..1 per channel.
        base: ColorOrTexture,
        /// From 0 (no metal) to 1 (metal only).
        metallic: f64,
        /// The root of the GGX width, 0..1.
        roughness: f64,
        /// Index of refraction of the coat against vacuum, > 1.
        ior: f64,
    },
}

impl Material {
    /// A material that scatters on both sides.
    pub fn new(name: impl Into<String>, bsdf: Bsdf) -> Self {
        Self { name: name.into(), bsdf, sides: Sides::Both }
    }

    /// Whether it is black where a surface is seen from behind, and not from the front.
    pub fn is_one_sided(&self) -> bool {
        self.sides == Sides::Front && !self.bsdf.is_clear() && !self.bsdf.is_black()
    }
}

impl Bsdf {
    /// The name of its constructor in scenes.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Diffuse { reflectance: _ } => "diffuse",
            Self::Conductor { eta: _, k: _, alpha: _ } => "conductor",
            Self::Dielectric { interior: _, exterior: _, alpha: _ } => "dielectric",
            Self::Mirror { reflectance: _ } => "mirror",
            Self::Plastic { reflectance: _, ior: _, alpha: _ } => "plastic",
            Self::Principled { base: _, metallic: _, roughness: _, ior: _ } => "principled",
        }
    }

    /// What kind of scattering it is, in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Diffuse { reflectance: _ } => "diffuse",
            Self::Conductor { eta: _, k: _, alpha } if *alpha == 0.0 => "smooth conductor",
            Self::Conductor { eta: _, k: _, alpha: _ } => "rough conductor",
            Self::Dielectric { interior: _, exterior: _, alpha } if *alpha == 0.0 => "smooth dielectric",
            Self::Dielectric { interior: _, exterior: _, alpha: _ } => "rough dielectric",
            Self::Mirror { reflectance: _ } => "mirror",
            Self::Plastic { reflectance: _, ior: _, alpha: _ } => "plastic",
            Self::Principled { base: _, metallic: _, roughness: _, ior: _ } => "principled",
        }
    }

    /// Whether it is known to scatter no light at all. What a texture holds is not known.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Diffuse { reflectance } => reflectance.color().is_some_and(Color::is_black),
            Self::Mirror { reflectance } => reflectance.is_black(),
            Self::Conductor { eta: _, k: _, alpha: _ }
            | Self::Dielectric { interior: _, exterior: _, alpha: _ }
            | Self::Plastic { reflectance: _, ior: _, alpha: _ }
            | Self::Principled { base: _, metallic: _, roughness: _, ior: _ } => false,
        }
    }

    /// Whether it lets light through.
    pub fn is_clear(&self) -> bool {
        matches!(self, Self::Dielectric { interior: _, exterior: _, alpha: _ })
    }

    /// The color that may be a texture.
    pub fn paint(&self) -> Option<&ColorOrTexture> {
        match self {
            Self::Diffuse { reflectance } | Self::Plastic { reflectance, ior: _, alpha: _ } => Some(reflectance),
            Self::Principled { base, metallic: _, roughness: _, ior: _ } => Some(base),
            Self::Conductor { eta: _, k: _, alpha: _ }
            | Self::Dielectric { interior: _, exterior: _, alpha: _ }
            | Self::Mirror { reflectance: _ } => None,
        }
    }

    /// The texture that colors it, if one does.
    pub fn texture(&self) -> Option<Handle<Texture>> {
        self.paint().and_then(ColorOrTexture::texture)
    }

    /// The same scattering with another texture in the place of the one that it has.
    #[must_use]
    pub fn with_texture(&self, texture: Handle<Texture>) -> Self {
        let changed = |paint: &ColorOrTexture| match paint {
            ColorOrTexture::Color(color) => ColorOrTexture::Color(color.clone()),
            ColorOrTexture::Texture(_) => ColorOrTexture::Texture(texture),
        };
        match self {
            Self::Diffuse { reflectance } => Self::Diffuse { reflectance: changed(reflectance) },
            Self::Plastic { reflectance, ior, alpha } => {
                Self::Plastic { reflectance: changed(reflectance), ior: *ior, alpha: *alpha }
            }
            Self::Principled { base, metallic, roughness, ior } => {
                let (metallic, roughness, ior) = (*metallic, *roughness, *ior);
                Self::Principled { base: changed(base), metallic, roughness, ior }
            }
            Self::Conductor { eta: _, k: _, alpha: _ }
            | Self::Dielectric { interior: _, exterior: _, alpha: _ }
            | Self::Mirror { reflectance: _ } => self.clone(),
        }
    }
}
