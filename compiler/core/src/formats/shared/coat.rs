//! What is seen of a Lambertian base under a clear coat, for targets whose coats do not darken their base, and the other way round.

use crate::ir::{Color, ColorOrTexture};

/// A coat by how much of the base's light it throws back.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// The share of diffuse light from inside that the coat reflects, 0..1.
    inner: f64,
}

impl Coat {
    /// A coat of index of refraction `ior` > 1 against vacuum.
    ///
    /// Its diffuse reflectance from inside by the fit of Egan and Hilgeman, Optical Properties of Inhomogeneous Materials (1979),
    /// for indices up to 2 or so; Mitsuba uses the same.
    pub fn new(ior: f64) -> Self {
        let fit = -1.4399 / (ior * ior) + 0.7099 / ior + 0.6681 + 0.0636 * ior;
        Self { inner: fit.clamp(0.0, 0.999) }
    }

    /// What is seen of a base of reflectance `base`: all its light that leaves at once or after reflections at the coat.
    pub fn seen(&self, base: f64) -> f64 {
        base * (1.0 - self.inner) / (1.0 - base * self.inner)
    }

    /// The base of which `seen` is seen.
    pub fn base(&self, seen: f64) -> f64 {
        seen / (1.0 - self.inner + seen * self.inner)
    }
}

/// The reflectance of a coat head-on.
pub fn normal_reflectance(ior: f64) -> f64 {
    let root = (ior - 1.0) / (ior + 1.0);
    root * root
}

/// A color through `map`, or for a texture the factor that does the same to a grey of 0.5.
pub fn mapped(paint: &ColorOrTexture, map: impl Fn(f64) -> f64) -> Mapped {
    match paint {
        ColorOrTexture::Color(color) => Mapped::Color(Color::Rgb(color.rgb().map(map))),
        ColorOrTexture::Texture(texture) => Mapped::Texture(*texture, map(0.5) / 0.5),
    }
}

/// What [`mapped`] gives.
#[derive(Clone, Debug, PartialEq)]
pub enum Mapped {
    /// A color.
    Color(Color),
    /// A texture and a factor of its values.
    Texture(crate::ir::Handle<crate::ir::Texture>, f64),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coat_darkens_its_base() {
        let coat = Coat::new(1.5);
        // 0.596 is the known value for 1.5; black and white stay.
        assert!((coat.inner - 0.596).abs() < 2e-3, "{}", coat.inner);
        assert_eq!((coat.seen(0.0), coat.seen(1.0)), (0.0, 1.0));
        assert!((coat.seen(0.5) - 0.2876).abs() < 1e-3);
        for share in [0.0, 0.1, 0.5, 0.9, 1.0] {
            assert!((coat.base(coat.seen(share)) - share).abs() < 1e-12);
        }
        assert!((normal_reflectance(1.5) - 0.04).abs() < 1e-12);
    }

    #[test]
    fn textures_take_the_factor_of_a_grey() {
        let twice = |x: f64| 2.0 * x * x;
        assert_eq!(mapped(&Color::Grey(0.25).into(), twice), Mapped::Color(Color::Rgb([0.125; 3])));
        let mut textures = crate::ir::Arena::default();
        let handle: crate::ir::Handle<crate::ir::Texture> = {
            let image =
                crate::ir::ImageInfo { format: crate::ir::ImageFormat::Png, width: 1, height: 1, channels: 3, bits: 8 };
            let file = crate::ir::ImageFile::new(b"a");
            let encoding = crate::ir::Encoding::Srgb;
            let texture =
                crate::ir::Texture { name: "a".to_owned(), file, image, encoding, peak: 1.0, factor: [1.0; 3] };
            textures.push(texture, crate::diag::Origin::Made)
        };
        assert_eq!(mapped(&ColorOrTexture::Texture(handle), twice), Mapped::Texture(handle, 1.0));
    }
}
