//! Two images as a screen shows them: at one exposure, clamped, in sRGB.

use rayon::prelude::*;

use super::{Pair, exposure};
use ltsc_render::image::{Image, finite};

/// Luminance of linear sRGB (IEC 61966-2-1, the second row of its matrix to XYZ).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The exposure at which both images are compared where none is said, in stops: that of the reference, by [`exposure`].
#[must_use]
pub fn pair_exposure(pair: &Pair) -> f64 {
    exposure(pair.a)
}

/// The transfer function of sRGB (IEC 61966-2-1), its argument clamped between 0 and 1.
pub(super) fn srgb(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Both images at this exposure in sRGB, values between 0 and 1; pixels that are not finite stay so.
pub(super) fn shown(pair: &Pair, exposure: f64) -> [Image; 2] {
    let gain = exposure.exp2();
    [pair.a, pair.b].map(|image| {
        let of = |pixel: &[f32; 3]| {
            if finite(pixel) { pixel.map(|value| srgb(f64::from(value) * gain) as f32) } else { [f32::NAN; 3] }
        };
        Image { pixels: image.pixels.par_iter().map(of).collect(), ..*image }
    })
}

/// The luminance of what [`shown`] gives, as sRGB encodes it; nothing in pixels that are not finite in both images.
pub(super) fn luminances(pair: &Pair, exposure: f64) -> Vec<Option<[f64; 2]>> {
    let gain = exposure.exp2();
    let luminance = |pixel: &[f32; 3]| {
        let parts = LUMINANCE.iter().zip(pixel).map(|(part, value)| part * (f64::from(*value) * gain).clamp(0.0, 1.0));
        srgb(parts.sum())
    };
    let pixels = pair.a.pixels.par_iter().zip(&pair.b.pixels);
    pixels.map(|(a, b)| (finite(a) && finite(b)).then(|| [luminance(a), luminance(b)])).collect()
}
