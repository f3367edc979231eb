//! The Fresnel term of metals: LuxCore's is an approximation, and is given other numbers with which it comes near.
//!
//! `FresnelTexture::GeneralEvaluate` (`fresneltexture.cpp`) refracts by sin / n alone, as if the metal did not absorb. It is
//! exact at normal incidence and up to 21 % too bright at 75 degrees (measured with 2.11.2). The pair of `n` and `k` whose
//! approximate term is nearest to the exact one, by least squares over the hemisphere with the cosine as weight, is within 0.04
//! of the reflectance for gold and copper at every angle.

use crate::formats::shared::fresnel::conductor;

/// `n` and `k` for LuxCore, and how well they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Index of refraction that LuxCore is given.
    pub n: f64,
    /// Extinction coefficient that LuxCore is given.
    pub k: f64,
    /// Root mean square, over the cosine-weighted hemisphere, of the difference from the exact reflectance.
    pub rms: f64,
    /// The largest difference up to 85 degrees.
    pub most: f64,
}

/// What LuxCore computes for `n` and `k`.
pub fn approximate(n: f64, k: f64, cosine: f64) -> f64 {
    let sin2 = (1.0 - cosine * cosine) / (n * n);
    let cos2 = 1.0 - sin2;
    let a = 2.0 * k * k * sin2;
    let inner = (0.5 * (cos2 + (cos2 * cos2 + a * a).sqrt())).max(0.0).sqrt();
    let size = n * n + k * k;
    let part = |sum: f64| (sum - 2.0 * cosine * inner * n) / (sum + 2.0 * cosine * inner * n);
    0.5 * (part(size * cosine * cosine + inner * inner) + part(size * inner * inner + cosine * cosine))
}

/// Places where both terms are compared: the middles of equal steps of the cosine.
const STEPS: usize = 32;

/// Rounds of the search; from the best place of the grid it takes about a hundred.
const ROUNDS: usize = 300;

fn cosines() -> impl Iterator<Item = f64> {
    (0..STEPS).map(|step| (step as f64 + 0.5) / STEPS as f64)
}

/// The mean of the squared difference over the hemisphere: the cosine is its weight, 2 cos d(cos).
fn error(targets: &[f64], n: f64, k: f64) -> f64 {
    let squares = cosines().zip(targets).map(|(cosine, target)| {
        let off = approximate(n, k, cosine) - target;
        2.0 * cosine * off * off
    });
    squares.sum::<f64>() / STEPS as f64
}

/// The numbers with which LuxCore's term is nearest to the exact one of `eta` and `k`.
///
/// A search on the grid of the logarithms of both, then steps along the axes and diagonals that halve where none helps: the
/// same on every machine, since only sums, products and roots are computed.
pub fn fit(eta: f64, k: f64) -> Fit {
    let targets: Vec<f64> = cosines().map(|cosine| conductor(eta, k, cosine)).collect();
    // Powers of the root of 2 from 1/32 to 64.
    let grid = || (-10_i32..=12).map(|at| libm::exp2(f64::from(at) / 2.0));
    let mut best = (error(&targets, eta, k), eta, k);
    for n in grid() {
        for k in grid() {
            let here = error(&targets, n, k);
            if here < best.0 {
                best = (here, n, k);
            }
        }
    }
    let mut step = 0.2;
    for _ in 0..ROUNDS {
        if step < 1e-5 {
            break;
        }
        let (_, n, k) = best;
        let (up, down) = (1.0 + step, 1.0 / (1.0 + step));
        let around = [(up, 1.0), (down, 1.0), (1.0, up), (1.0, down), (up, up), (up, down), (down, up), (down, down)];
        let tried = around.map(|(a, b)| (error(&targets, n * a, k * b), n * a, k * b));
        match tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).filter(|found| found.0 < best.0) {
            Some(found) => best = found,
            None => step *= 0.5,
        }
    }
    let (mean, fitted_n, fitted_k) = best;
    // Seven digits say as much as single precision holds.
    let short = |x: f64| format!("{x:.6e}").parse::<f64>().unwrap_or(x);
    let (fitted_n, fitted_k) = (short(fitted_n), short(fitted_k));
    let most = (0..=85).map(|degrees| {
        let cosine = libm::cos(f64::from(degrees).to_radians());
        (approximate(fitted_n, fitted_k, cosine) - conductor(eta, k, cosine)).abs()
    });
    Fit { n: fitted_n, k: fitted_k, rms: mean.sqrt(), most: most.fold(0.0, f64::max) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `eta` and `k` of the scenes' gold and copper, channel by channel.
    const METALS: [(f64, f64); 6] = [
        (0.143_119, 3.983_16),
        (0.374_957, 2.385_72),
        (1.442_48, 1.603_22),
        (0.200_438, 3.912_949),
        (0.924_033, 2.452_848),
        (1.102_212, 2.142_188),
    ];

    #[test]
    fn both_terms_agree_at_normal_incidence_and_grazing() {
        for (eta, k) in METALS {
            let normal = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
            assert!((conductor(eta, k, 1.0) - normal).abs() < 1e-12);
            assert!((approximate(eta, k, 1.0) - normal).abs() < 1e-12);
            assert!((conductor(eta, k, 1e-9) - 1.0).abs() < 1e-6 && (approximate(eta, k, 1e-9) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn both_terms_agree_for_what_absorbs_nothing() {
        assert!((approximate(1.5, 0.0, 0.5) - conductor(1.5, 0.0, 0.5)).abs() < 1e-12);
    }

    #[test]
    fn the_fit_is_near_where_the_numbers_themselves_are_not() {
        for (eta, k) in METALS {
            let targets: Vec<f64> = cosines().map(|cosine| conductor(eta, k, cosine)).collect();
            let before = error(&targets, eta, k).sqrt();
            let Fit { n, k: fitted, rms, most } = fit(eta, k);
            assert!(rms < 0.013 && most < 0.04, "{eta} {k} -> {n} {fitted}: {rms} {most}");
            assert!(rms < before / 2.0, "{eta} {k}: {before} -> {rms}");
        }
    }

    /// The minimum of the same sum on a grid of steps of 0.01 and 0.1, computed apart with complex numbers.
    #[test]
    fn the_fit_is_the_least_of_all() {
        let Fit { n, k, rms, most: _ } = fit(0.2, 3.9);
        assert!((n - 1.31).abs() < 0.01 && (k - 20.2).abs() < 0.1, "{n} {k}");
        assert!((rms * rms - 1.4715e-4).abs() < 1e-7, "{rms}");
    }

    #[test]
    fn whatever_comes_gives_numbers() {
        for (eta, k) in [(1e-6, 0.0), (1.5, 0.0), (1e-3, 1e-3), (100.0, 100.0), (1.0, 1e-9), (0.05, 30.0)] {
            let Fit { n, k: fitted, rms, most } = fit(eta, k);
            assert!(n > 0.0 && fitted >= 0.0 && n.is_finite() && fitted.is_finite(), "{eta} {k}: {n} {fitted}");
            assert!((0.0..=1.0).contains(&rms) && (0.0..=1.0).contains(&most), "{eta} {k}: {rms} {most}");
        }
    }
}
