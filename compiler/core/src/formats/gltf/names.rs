//! The conventions of glTF 2.0 for numbers, from its specification and those of its extensions.

use crate::formats::shared::camera::across;
use crate::formats::shared::fresnel;
use crate::formats::texture_files;
use crate::ir::{Affine, Color, Encoding, ImageFormat, Scene, Texture, Vec3, cross, normalized};

/// `componentType` of 32-bit floats.
pub const FLOAT: u32 = 5126;
/// `componentType` of unsigned 32-bit integers.
pub const UNSIGNED_INT: u32 = 5125;
/// `target` of a buffer view with vertices.
pub const ARRAY_BUFFER: u32 = 34962;
/// `target` of a buffer view with indices.
pub const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// `magFilter` and `minFilter`: linearly between the middles of pixels.
pub const LINEAR: u32 = 9729;
/// `wrapS` and `wrapT`: images repeat.
pub const REPEAT: u32 = 10497;

/// Whether glTF can hold the image: PNG and JPEG (3.9.2), whose colors are those of sRGB in a base color (3.9.2).
pub fn reads(texture: &Texture) -> bool {
    !texture.image.format.is_float() && texture.encoding == Encoding::Srgb
}

/// `mimeType` of the formats that [`reads`] lets pass; of others the general one for bytes.
pub fn mime(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::Png => "image/png",
        ImageFormat::Jpeg => "image/jpeg",
        ImageFormat::Exr | ImageFormat::Pfm | ImageFormat::Hdr => "application/octet-stream",
    }
}

/// The root's matrix: the Scene's z is up, glTF's y is: (x, y, z) becomes (x, z, -y).
pub const Z_UP_TO_Y_UP: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0]] };

/// The roughness whose square is the GGX width (glTF 2.0, appendix B.2.3: alpha = roughness^2).
pub fn roughness(alpha: f64) -> f64 {
    alpha.sqrt().min(1.0)
}

/// The base color of a metal, whose Fresnel term is Schlick's: the reflectance seen head-on per channel.
pub fn base_color(eta: &Color, k: &Color) -> [f64; 3] {
    let (eta, k) = (eta.rgb(), k.rgb());
    [0, 1, 2].map(|channel| fresnel::head_on(eta[channel], k[channel]))
}

/// `ior` of KHR_materials_ior: the relative index of refraction, which may not be below 1.
pub fn ior(interior: f64, exterior: f64) -> f64 {
    (interior / exterior).max(1.0)
}

/// `color` (0..1 per channel) and `intensity` of KHR_lights_punctual, whose product is what the Scene says. Its units are
/// candela and lux; written are the numbers of W/sr and W/m2, as [`emission`] writes those of W/(m2 sr).
pub fn strength(color: &Color) -> ([f64; 3], f64) {
    emission(color)
}

/// A turn that takes -z to `direction`: lights of KHR_lights_punctual shine along their node's -z.
pub fn aim(direction: Vec3) -> Affine {
    let back = normalized(direction.map(|x| -x)).unwrap_or([0.0, 0.0, 1.0]);
    let right = normalized(cross(across(back), back)).unwrap_or([1.0, 0.0, 0.0]);
    let up = cross(back, right);
    Affine { rows: [0, 1, 2].map(|axis| [right[axis], up[axis], back[axis], 0.0]) }
}

/// `innerConeAngle` and `outerConeAngle` of a spot in radians. They are halves of openings, and the inner one must be the
/// smaller: a sharp edge becomes one of a millionth.
pub fn cone(angle: f64, inner: f64) -> (f64, f64) {
    let outer = angle.to_radians();
    (inner.to_radians().min(outer * (1.0 - 1e-6)), outer)
}

/// `emissiveFactor` (0..1 per channel) and `emissiveStrength` (KHR_materials_emissive_strength), whose product is the
/// radiance. glTF's unit is candela per square meter; written is the number of W/(m2 sr), so that nothing depends on
/// an assumed luminous efficacy. The strength is that of the color: the largest value of a spectrum is another number.
pub fn emission(radiance: &Color) -> ([f64; 3], f64) {
    let color = radiance.rgb().map(|x| x.max(0.0));
    let strength = color.into_iter().fold(0.0, f64::max);
    if strength > 0.0 { (color.map(|x| x / strength), strength) } else { ([0.0; 3], 0.0) }
}

/// A matrix by columns.
pub fn matrix(map: &Affine) -> [f64; 16] {
    let Affine { rows } = map;
    let mut entries = [0.0; 16];
    for column in 0..4 {
        for (row, values) in rows.iter().enumerate() {
            // Without negative zeros, which print as such.
            entries[column * 4 + row] = values[column] + 0.0;
        }
    }
    entries[15] = 1.0;
    entries
}

/// The textures that glTF can hold, each with its file and its index in the document.
pub fn textures(scene: &Scene) -> impl Iterator<Item = ((&Texture, String), usize)> {
    let files = texture_files(scene);
    scene.textures.values().zip(files).filter(|(texture, _)| reads(texture)).zip(0..)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{Meaning, Spectrum};

    #[test]
    fn the_root_stands_scenes_upright() {
        assert_eq!(Z_UP_TO_Y_UP.point([1.0, 2.0, 3.0]), [1.0, 3.0, -2.0]);
        assert_eq!(Z_UP_TO_Y_UP.determinant(), 1.0);
        // Read as glTF reads it: column-major, M p.
        let m = matrix(&Z_UP_TO_Y_UP);
        let at = |row: usize| m[row] + 2.0 * m[4 + row] + 3.0 * m[8 + row] + m[12 + row];
        assert_eq!([at(0), at(1), at(2), at(3)], [1.0, 3.0, -2.0, 1.0]);
    }

    #[test]
    fn lights_shine_where_they_should() {
        for direction in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, -0.8, 0.0], [0.48, 0.6, -0.64]] {
            let turn = aim(direction);
            let there = turn.point([0.0, 0.0, -1.0]);
            assert!(there.iter().zip(direction).all(|(a, b)| (a - b).abs() < 1e-15), "{direction:?} {there:?}");
            assert!((turn.determinant() - 1.0).abs() < 1e-15, "a turn, not a mirror");
        }
        let (inner, outer) = cone(90.0, 90.0);
        assert!(inner < outer && outer == std::f64::consts::FRAC_PI_2 && inner > 0.999_99 * outer);
        assert_eq!(cone(60.0, 0.0).0, 0.0);
        assert_eq!(strength(&Color::Rgb([3.0, 1.5, 0.0])), ([1.0, 0.5, 0.0], 3.0));
    }

    #[test]
    fn materials_by_hand() {
        assert_eq!(roughness(0.25), 0.5);
        // Glass head-on: (1.5 - 1)^2 / (1.5 + 1)^2.
        let [r, _, _] = base_color(&Color::Grey(1.5), &Color::BLACK);
        assert!((r - 0.04).abs() < 1e-12);
        assert_eq!(ior(1.0, 1.5), 1.0);
        assert_eq!(emission(&Color::Rgb([30.0, 15.0, 0.0])), ([1.0, 0.5, 0.0], 30.0));
        assert_eq!(emission(&Color::BLACK), ([0.0; 3], 0.0));
        // Constant light is reddish in sRGB: its red is more than its values are.
        let flat = Color::Spectrum(Spectrum::new(&[(400.0, 2.0), (700.0, 2.0)], Meaning::Light));
        let (factor, strength) = emission(&flat);
        assert_eq!((factor[0], strength), (1.0, flat.rgb()[0]));
        assert!(strength > 2.3 && factor.iter().all(|share| (0.0..=1.0).contains(share)), "{factor:?} {strength}");
    }
}
