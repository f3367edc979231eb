//! The spectra that pbrt-v4 makes of RGB colors, and how far its products of colors lie from those of RGB.
//!
//! A reflectance becomes S(c0 x^2 + c1 x + c2) with S(x) = 1/2 + x / (2 sqrt(1 + x^2)) of the wavelength x in 0..1, the one whose
//! color in D65 is nearest in CIELAB (Jakob and Hanika, A Low-Dimensional Function Space for Efficient Spectral Upsampling,
//! 2019). Light is D65 times twice its largest channel times the spectrum of the rest, an index of refraction the same
//! without D65 (`RGBIlluminantSpectrum`, `RGBUnboundedSpectrum`). pbrt-v4 looks coefficients up in a table instead; see [`TABLE`].

use std::sync::OnceLock;

use crate::ir::{Color, Meaning, Spectrum};

/// Wavelengths that are looked at, from 360 to 830 nm.
const COUNT: usize = 95;
const FIRST: f64 = 360.0;
const STEP: f64 = 5.0;

/// How far the table of pbrt-v4 lies beside the nearest spectrum, as a share of the brightest channel: reflectances and lamps of
/// eight colors, saturated ones among them, were off by up to 0.0013 (pbrt-r4 4.5.2).
pub const TABLE: f64 = 0.0015;

/// A value for each wavelength.
pub type Values = [f64; COUNT];

fn wavelength(at: usize) -> f64 {
    FIRST + STEP * at as f64
}

/// What a unit at each wavelength adds to red, green and blue: in daylight, and as light of its own.
fn weights() -> &'static [[[f64; 3]; COUNT]; 2] {
    static WEIGHTS: OnceLock<[[[f64; 3]; COUNT]; 2]> = OnceLock::new();
    WEIGHTS.get_or_init(|| {
        let hat = |at: usize, meaning: Meaning| {
            let middle = wavelength(at);
            Spectrum::new(&[(middle - STEP, 0.0), (middle, 1.0), (middle + STEP, 0.0)], meaning).exact_rgb()
        };
        [Meaning::Share, Meaning::Light].map(|meaning| std::array::from_fn(|at| hat(at, meaning)))
    })
}

/// Linear sRGB of what reflects `values` of daylight.
pub fn in_daylight(values: &Values) -> [f64; 3] {
    sum(values, &weights()[0])
}

/// Linear sRGB of light of this spectrum.
fn as_light(values: &Values) -> [f64; 3] {
    sum(values, &weights()[1])
}

fn sum(values: &Values, weights: &[[f64; 3]; COUNT]) -> [f64; 3] {
    let mut rgb = [0.0; 3];
    for (value, weight) in values.iter().zip(weights) {
        for (channel, part) in rgb.iter_mut().zip(weight) {
            *channel += value * part;
        }
    }
    rgb
}

/// The reflectance that stands for a color within 0..1.
pub fn reflectance(rgb: [f64; 3]) -> Values {
    let [r, g, b] = rgb;
    if r == g && g == b {
        return [r; COUNT];
    }
    let of = |c: [f64; 3]| -> Values {
        std::array::from_fn(|at| {
            let x = at as f64 / (COUNT - 1) as f64;
            let y = (c[0] * x + c[1]) * x + c[2];
            0.5 + y / (2.0 * (1.0 + y * y).sqrt())
        })
    };
    let target = lab(rgb);
    let miss = |c: [f64; 3]| {
        let found = lab(in_daylight(&of(c)));
        [0, 1, 2].map(|part| found[part] - target[part])
    };
    // Levenberg and Marquardt, from the grey of the same luminance.
    let mut c = [0.0; 3];
    let mut error = miss(c);
    let mut damping = 1e-3;
    for _ in 0..300 {
        let columns = [0, 1, 2].map(|part| {
            let mut moved = c;
            moved[part] += 1e-5;
            let there = miss(moved);
            [0, 1, 2].map(|row| (there[row] - error[row]) / 1e-5)
        });
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let matrix: [[f64; 3]; 3] = [0, 1, 2].map(|row| {
            [0, 1, 2].map(|column| {
                let entry = dot(&columns[row], &columns[column]);
                if row == column { entry * (1.0 + damping) + 1e-12 } else { entry }
            })
        });
        let Some(step) = solved(matrix, [0, 1, 2].map(|part| -dot(&columns[part], &error))) else { break };
        let next = [0, 1, 2].map(|part| c[part] + step[part]);
        let there = miss(next);
        if dot(&there, &there) < dot(&error, &error) {
            (c, error, damping) = (next, there, (damping * 0.3_f64).max(1e-9));
        } else {
            damping *= 4.0;
        }
        if dot(&error, &error) < 1e-12 || damping > 1e12 {
            break;
        }
    }
    of(c)
}

/// The values that stand for a color without an upper bound: of light as a share of daylight, of an index as they are.
pub fn unbounded(color: &Color) -> Values {
    let rgb = color.rgb();
    let largest = rgb.into_iter().fold(0.0, f64::max);
    if largest <= 0.0 {
        return [0.0; COUNT];
    }
    reflectance(rgb.map(|channel| channel / (2.0 * largest))).map(|value| 2.0 * largest * value)
}

/// A spectrum as it is.
pub fn given(spectrum: &Spectrum) -> Values {
    std::array::from_fn(|at| spectrum.value(wavelength(at)))
}

/// Light that shines on things: a share of daylight, or a spectrum of its own.
pub enum Light {
    /// Made of RGB.
    Daylight(Values),
    /// Given.
    Own(Values),
}

impl Light {
    /// What pbrt-v4 makes of the strength of a light.
    pub fn of(strength: &Color) -> Self {
        match strength.spectrum() {
            Some(spectrum) => Self::Own(given(spectrum)),
            None => Self::Daylight(unbounded(strength)),
        }
    }

    /// The color of this light after things that reflect these shares of it.
    pub fn after<'v>(&self, surfaces: impl Iterator<Item = &'v Values>) -> [f64; 3] {
        let (&Self::Daylight(mut values) | &Self::Own(mut values)) = self;
        for surface in surfaces {
            for (value, share) in values.iter_mut().zip(surface) {
                *value *= share;
            }
        }
        match self {
            Self::Daylight(_) => in_daylight(&values),
            Self::Own(_) => as_light(&values),
        }
    }
}

/// CIELAB of linear sRGB, the white of which is that of D65.
fn lab(rgb: [f64; 3]) -> [f64; 3] {
    // Linear sRGB to CIE XYZ, each row a share of white (IEC 61966-2-1).
    const ROWS: [[f64; 3]; 3] =
        [[0.433_887, 0.376_224, 0.189_889], [0.212_639, 0.715_169, 0.072_192], [0.017_750, 0.109_448, 0.872_802]];
    let [x, y, z] = ROWS.map(|row| {
        let share: f64 = row.iter().zip(rgb).map(|(part, channel)| part * channel).sum();
        if share > 0.008_856_451_679 { libm::cbrt(share) } else { (share * 24_389.0 / 27.0 + 16.0) / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The solution of three linear equations, by Cramer's rule.
fn solved(matrix: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(&matrix);
    if whole == 0.0 || !whole.is_finite() {
        return None;
    }
    Some([0, 1, 2].map(|column| {
        let mut replaced = matrix;
        for (row, value) in replaced.iter_mut().zip(right) {
            row[column] = value;
        }
        determinant(&replaced) / whole
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::fresnel;

    fn near(found: [f64; 3], wanted: [f64; 3], by: f64) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= by), "{found:?} instead of {wanted:?}");
    }

    #[test]
    fn colors_are_met_in_daylight() {
        for rgb in [[0.5, 0.2, 0.1], [0.1, 0.5, 0.15], [0.05, 0.1, 0.6], [0.8, 0.4, 0.2], [0.3; 3]] {
            near(in_daylight(&reflectance(rgb)), rgb, 1e-6);
            near(Light::of(&Color::Rgb(rgb.map(|c| 40.0 * c))).after([].into_iter()), rgb.map(|c| 40.0 * c), 1e-4);
        }
    }
    /// The program itself, of June 2026: the micro-scenes `point_light`, `directional_light` and `environment_light`, whose floor
    /// reflects (0.8, 0.4, 0.2), and a metal like copper head-on.
    #[test]
    fn products_of_colors_are_those_of_the_program() {
        let floor = reflectance([0.8, 0.4, 0.2]);
        let share = |light: [f64; 3], channel: usize| {
            let product = light[channel] * [0.8, 0.4, 0.2][channel];
            Light::of(&Color::Rgb(light)).after([&floor].into_iter())[channel] / product - 1.0
        };
        for (light, channel, measured) in [
            ([100.0, 50.0, 10.0], 0, -0.085),
            ([100.0, 50.0, 10.0], 2, -0.79),
            ([3.0, 2.0, 1.0], 2, -0.18),
            ([1.0, 2.0, 0.5], 0, 0.073),
            ([1.0, 2.0, 0.5], 2, -0.29),
        ] {
            let found = share(light, channel);
            assert!((found - measured).abs() < 0.01, "{light:?}, {channel}: {found} instead of {measured}");
        }
        let eta = unbounded(&Color::Rgb([0.200_438, 0.924_033, 1.102_212]));
        let k = unbounded(&Color::Rgb([3.912_949, 2.452_848, 2.142_188]));
        let head_on: Values = std::array::from_fn(|at| fresnel::head_on(eta[at], k[at]));
        near(in_daylight(&head_on), [0.9823, 0.6240, 0.5127], 2e-3);
    }

    /// Lightness and the two axes of the primaries of sRGB, as tables of color spaces have them, and of greys on both sides of the bend.
    #[test]
    fn cielab_is_that_of_tables() {
        near(lab([1.0; 3]), [100.0, 0.0, 0.0], 1e-4);
        near(lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.03);
        near(lab([0.0, 1.0, 0.0]), [87.73, -86.18, 83.18], 0.03);
        near(lab([0.0, 0.0, 1.0]), [32.30, 79.19, -107.86], 0.03);
        near(lab([0.184_187; 3]), [50.0, 0.0, 0.0], 1e-3);
        // Below 0.008856 it is linear: 903.2963 of each part.
        near(lab([0.002; 3]), [1.806_593, 0.0, 0.0], 1e-4);
        near(lab([0.0; 3]), [0.0; 3], 1e-9);
    }

    #[test]
    fn equations_are_solved() {
        let matrix = [[2.0, -1.0, 3.0], [4.0, 5.0, -6.0], [7.0, 8.0, 10.0]];
        near(solved(matrix, [13.0, -24.0, 21.0]).expect("one solution"), [1.0, -2.0, 3.0], 1e-12);
        near(solved(matrix, [-3.5, 15.5, 5.5]).expect("one solution"), [0.5, 1.5, -1.0], 1e-12);
        assert_eq!(solved([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]], [1.0; 3]), None);
        assert_eq!(solved([[f64::INFINITY; 3]; 3], [1.0; 3]), None);
    }

    /// A spectrum with its corners on wavelengths that are looked at has the color that it has exactly.
    #[test]
    fn spectra_have_their_own_colors() {
        let points = [(360.0, 0.5), (420.0, 1.0), (500.0, 0.2), (620.0, 0.75), (700.0, 0.1), (830.0, 0.4)];
        let of = |meaning: Meaning| {
            let spectrum = Spectrum::new(&points, meaning);
            (given(&spectrum), spectrum.exact_rgb())
        };
        let (share, exact) = of(Meaning::Share);
        assert_eq!((share[0], share[12], share[68], share[94]), (0.5, 1.0, 0.1, 0.4));
        assert!((share[20] - 0.6).abs() < 1e-12, "460 nm lies in the middle of 420 and 500");
        near(in_daylight(&share), exact, 2e-4);
        let (light, exact) = of(Meaning::Light);
        near(as_light(&light), exact, 2e-4 * exact[0].abs().max(1.0));
        near(in_daylight(&[1.0; COUNT]), [1.0; 3], 2e-4);
        // After things each wavelength has its own product.
        let dark: Values = std::array::from_fn(|at| if at < 40 { 0.5 } else { 0.25 });
        let both: Values = std::array::from_fn(|at| light[at] * share[at] * dark[at]);
        near(Light::Own(light).after([&share, &dark].into_iter()), as_light(&both), 1e-12);
        let both: Values = std::array::from_fn(|at| share[at] * dark[at]);
        near(Light::Daylight(share).after([&dark].into_iter()), in_daylight(&both), 1e-12);
    }

    #[test]
    fn colors_without_a_bound_are_twice_their_largest_channel() {
        let half = reflectance([0.5, 0.25, 0.125]);
        let found = unbounded(&Color::Rgb([40.0, 20.0, 10.0]));
        assert!(found.iter().zip(&half).all(|(value, share)| (value - 80.0 * share).abs() < 1e-12));
        assert_eq!(unbounded(&Color::Grey(3.0)), [3.0; COUNT]);
        assert_eq!((unbounded(&Color::Grey(0.0)), reflectance([0.25; 3])), ([0.0; COUNT], [0.25; COUNT]));
    }

    /// The quadratic that a reflectance is made of, from three of its values, and the distance of its color in CIELAB from another one.
    fn quadratic(values: &Values) -> [f64; 3] {
        let y = |at: usize| {
            let s = 2.0 * values[at] - 1.0;
            s / (1.0 - s * s).sqrt()
        };
        let (first, middle, last) = (y(0), y(47), y(94));
        let bend = 2.0 * (first - 2.0 * middle + last);
        [bend, last - first - bend, first]
    }

    fn distance(c: [f64; 3], rgb: [f64; 3]) -> f64 {
        let values: Values = std::array::from_fn(|at| {
            let x = at as f64 / 94.0;
            let y = c[0] * x * x + c[1] * x + c[2];
            0.5 + 0.5 * y / (1.0 + y * y).sqrt()
        });
        let (found, wanted) = (lab(in_daylight(&values)), lab(rgb));
        found.iter().zip(wanted).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// Nearly grey, nearly black, nearly white and saturated colors are met as well, by spectra of the form that is written above.
    #[test]
    fn colors_at_the_edges_are_met_by_spectra_of_the_form() {
        for rgb in [
            [0.5, 0.2, 0.1],
            [0.05, 0.1, 0.6],
            [0.02, 0.9, 0.9],
            [0.2, 0.201, 0.2],
            [0.001, 0.002, 0.001],
            [0.98, 0.97, 0.99],
            [0.4, 0.0, 0.0],
        ] {
            let values = reflectance(rgb);
            assert!(values.iter().all(|value| (0.0..=1.0).contains(value)));
            let found = distance(quadratic(&values), rgb);
            assert!(found < 1e-3, "{rgb:?}: {found}");
            near(in_daylight(&values), rgb, 1e-5);
        }
    }
}
