//! Fresnel terms, for what formats write and for how far they are off.

/// The reflectance of a metal in vacuum for unpolarised light (Born and Wolf, "Principles of Optics", section 14.2, as in
/// `FrConductor` of PBRT); `cosine` of the angle of incidence.
pub fn conductor(eta: f64, k: f64, cosine: f64) -> f64 {
    let (cos2, sin2) = (cosine * cosine, 1.0 - cosine * cosine);
    let (eta2, k2) = (eta * eta, k * k);
    let t = eta2 - k2 - sin2;
    let sum = (t * t + 4.0 * eta2 * k2).sqrt();
    let (t1, t2) = (sum + cos2, 2.0 * cosine * (0.5 * (sum + t)).max(0.0).sqrt());
    let across = (t1 - t2) / (t1 + t2);
    let (t3, t4) = (cos2 * sum + sin2 * sin2, t2 * sin2);
    0.5 * across * (1.0 + (t3 - t4) / (t3 + t4))
}

/// The reflectance of a metal seen head-on, `((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2)` (Born and Wolf, section 14.2).
pub fn head_on(eta: f64, k: f64) -> f64 {
    ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
}

/// Schlick's approximation (1994) with the reflectance `head_on`.
pub fn schlick(head_on: f64, cosine: f64) -> f64 {
    let rest = 1.0 - cosine;
    head_on + (1.0 - head_on) * rest * rest * rest * rest * rest
}

/// The reflectance of a clear material whose index of refraction is `eta` against what lies before it (Born and Wolf,
/// section 1.5.2); 1 where all light is reflected.
pub fn dielectric(eta: f64, cosine: f64) -> f64 {
    let sin2 = (1.0 - cosine * cosine) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let inner = (1.0 - sin2).sqrt();
    let across = (cosine - eta * inner) / (cosine + eta * inner);
    let along = (eta * cosine - inner) / (eta * cosine + inner);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_agree_head_on_and_at_grazing_incidence() {
        for (eta, k) in [(0.143_119, 3.983_16), (1.442_48, 1.603_22), (1.5, 0.0)] {
            let normal = head_on(eta, k);
            assert!((conductor(eta, k, 1.0) - normal).abs() < 1e-12);
            assert!((schlick(normal, 1.0) - normal).abs() < 1e-12);
            assert!((conductor(eta, k, 1e-9) - 1.0).abs() < 1e-6 && (schlick(normal, 1e-9) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_dielectric_has_the_textbook_reflectance() {
        // Glass of 1.5 at 60 degrees: Rs 0.177, Rp 0.0018.
        assert!((conductor(1.5, 0.0, 0.5) - 0.0892).abs() < 1e-3);
        assert!((dielectric(1.5, 0.5) - conductor(1.5, 0.0, 0.5)).abs() < 1e-12);
        // All light is reflected beyond asin(1 / 1.5) = 41.8 degrees from inside.
        assert!(dielectric(1.0 / 1.5, 0.5) == 1.0 && dielectric(1.0, 0.3) < 1e-12);
        // By hand: sine 0.6 becomes 0.9; Rs 0.2182, Rp 0.0101.
        assert!((dielectric(1.0 / 1.5, 0.8) - 0.1141).abs() < 1e-3);
    }
}
