//! The formulas behind the answers: Fresnel terms, microfacets, polygons of light, and where points lie in an image. Nothing here
//! is shared with what writes files for renderers.

use std::f64::consts::PI;

use ltsc_core::ir::{Camera, Vec3, cross, dot, length, normalized, sub};

/// The unpolarised reflectance of a smooth surface for light that comes from index 1 to index `n`, `cosine` to its normal
/// (Fresnel's equations; Born and Wolf, Principles of Optics, 1.5.2).
pub fn dielectric(cosine: f64, n: f64) -> f64 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt() / n;
    if sine >= 1.0 {
        return 1.0;
    }
    let inside = (1.0 - sine * sine).sqrt();
    let across = (cosine - n * inside) / (cosine + n * inside);
    let along = (n * cosine - inside) / (n * cosine + inside);
    f64::midpoint(across * across, along * along)
}

/// The share of light that passes a slab of index `n`, all reflections in it counted: with R at each face, (1 - R)^2 (1 + R^2 + R^4
/// + ...) = (1 - R) / (1 + R).
pub fn slab(degrees: f64, n: f64) -> f64 {
    let r = dielectric(degrees.to_radians().cos(), n);
    (1.0 - r) / (1.0 + r)
}

/// The same without any reflection in it.
pub fn slab_once(degrees: f64, n: f64) -> f64 {
    (1.0 - dielectric(degrees.to_radians().cos(), n)).powi(2)
}

/// The unpolarised reflectance of a metal of the complex index `eta` - i `k` (Born and Wolf, 14.2), in complex arithmetic written out:
/// sqrt(n^2 - sin^2) = p - i q.
pub fn conductor(cosine: f64, eta: f64, k: f64) -> f64 {
    let sine2 = 1.0 - cosine * cosine;
    let real = eta * eta - k * k - sine2;
    let size = (real * real + 4.0 * eta * eta * k * k).sqrt();
    let (p, q) = ((f64::midpoint(size, real)).max(0.0).sqrt(), (f64::midpoint(size, -real)).max(0.0).sqrt());
    // Across: |(cos - p + i q) / (cos + p - i q)|^2. Along: the same times |(p - sin tan - i q) / (p + sin tan - i q)|^2.
    let across = ((cosine - p).powi(2) + q * q) / ((cosine + p).powi(2) + q * q);
    let bend = sine2 / cosine;
    let along = across * ((p - bend).powi(2) + q * q) / ((p + bend).powi(2) + q * q);
    f64::midpoint(across, along)
}

/// The albedo in even light of a Lambertian base under a smooth coat of index `n`, seen at an angle: what the coat reflects, and what
/// passes it, is scattered and leaves, at once or after reflections at the coat from inside. Of even light inside, the share that
/// leaves is that which enters from even light outside, over n^2 (reciprocity), by the midpoint rule.
pub fn coated(base: f64, n: f64, degrees: f64) -> f64 {
    const STEPS: usize = 100_000;
    let outer = (0..STEPS).map(|at| {
        let cosine = (at as f64 + 0.5) / STEPS as f64;
        2.0 * cosine * dielectric(cosine, n)
    });
    let leaves = (1.0 - outer.sum::<f64>() / STEPS as f64) / (n * n);
    let r = dielectric(degrees.to_radians().cos(), n);
    r + (1.0 - r) * base * leaves / (1.0 - base * (1.0 - leaves))
}

/// GGX, the density of microfacets whose normals have `cosine` to the surface's (Walter et al. 2007, eq. 33).
pub fn ggx(cosine: f64, alpha: f64) -> f64 {
    let (cos2, a2) = (cosine * cosine, alpha * alpha);
    let term = cos2 * (a2 - 1.0) + 1.0;
    a2 / (PI * term * term)
}

/// Smith's share of microfacets that is seen along a direction with `cosine` to the surface (eq. 34).
pub fn smith(cosine: f64, alpha: f64) -> f64 {
    let tan2 = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// Rough metal: `eta`, `k` and the GGX width.
#[derive(Clone, Copy)]
pub struct Metal {
    pub eta: f64,
    pub k: f64,
    pub alpha: f64,
}

impl Metal {
    /// The reflectance distribution between two unit directions, both away from the surface of the unit normal `n` (eq. 20 and
    /// 23, the masking of both directions independent).
    pub fn reflects(&self, n: Vec3, one: Vec3, other: Vec3) -> f64 {
        let (a, b) = (dot(n, one), dot(n, other));
        let Some(half) = normalized([0, 1, 2].map(|axis| one[axis] + other[axis])) else { return 0.0 };
        if a <= 0.0 || b <= 0.0 {
            return 0.0;
        }
        let d = ggx(dot(n, half), self.alpha);
        let g = smith(a, self.alpha) * smith(b, self.alpha);
        d * g * conductor(dot(one, half), self.eta, self.k) / (4.0 * a * b)
    }

    /// The share of light that is reflected towards a direction of this cosine in even light: the integral of the distribution times
    /// the cosine over the hemisphere, by the midpoint rule over half vectors, so that narrow lobes are met. With h the half vector,
    /// f cos(i) d(i) = D G F 4 (o h) / (4 cos(o)) d(h).
    pub fn albedo(&self, cosine: f64) -> f64 {
        const RINGS: usize = 400;
        const SECTORS: usize = 200;
        let out = [(1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine];
        let mut sum = 0.0;
        for ring in 0..RINGS {
            // Equal shares of D cos(h): cos^2 = (1 - u) / (1 + (a^2 - 1) u) (eq. 35).
            let u = (ring as f64 + 0.5) / RINGS as f64;
            let cos2 = (1.0 - u) / (1.0 + (self.alpha * self.alpha - 1.0) * u);
            let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).sqrt());
            for sector in 0..SECTORS {
                let phi = (sector as f64 + 0.5) / SECTORS as f64 * PI;
                let half = [sin * phi.cos(), sin * phi.sin(), cos];
                let along = dot(out, half);
                let into = 2.0 * along * half[2] - out[2];
                if along <= 0.0 || into <= 0.0 {
                    continue;
                }
                let g = smith(cosine, self.alpha) * smith(into, self.alpha);
                // The density of half vectors is D cos(h), which cancels D.
                sum += g * conductor(along, self.eta, self.k) * along / (cosine * cos);
            }
        }
        sum / (RINGS * SECTORS) as f64
    }
}

/// The irradiance of a polygon of radiance 1 on a point with a unit normal, for polygons above its horizon: half the sum over its edges of
/// the angle that each spans times the cosine between the normal and that of the edge's plane (Lambert's formula).
pub fn polygon(corners: &[Vec3], point: Vec3, normal: Vec3) -> f64 {
    let to = |corner: &Vec3| normalized(sub(*corner, point)).unwrap_or([0.0; 3]);
    let mut sum = 0.0;
    for (at, corner) in corners.iter().enumerate() {
        let (a, b) = (to(corner), to(&corners[(at + 1) % corners.len()]));
        let plane = cross(a, b);
        let sine = length(plane);
        if sine > 0.0 {
            sum += sine.atan2(dot(a, b)) * dot(plane, normal) / sine;
        }
    }
    (sum / 2.0).abs()
}

/// Where a point lies in an image of a camera: pixels from the left and from the top.
pub fn projected(camera: &Camera, size: (usize, usize), point: Vec3) -> (f64, f64) {
    let forward = sub(camera.target, camera.eye);
    let forward = normalized(forward).unwrap_or(forward);
    let right = normalized(cross(forward, camera.up)).unwrap_or(camera.up);
    let up = cross(right, forward);
    let to = sub(point, camera.eye);
    let scale = size.0 as f64 / 2.0 / (camera.fov_x / 2.0).to_radians().tan() / dot(to, forward);
    (size.0 as f64 / 2.0 + dot(to, right) * scale, size.1 as f64 / 2.0 - dot(to, up) * scale)
}

/// What a pixel shows of a lamp of radiance 1 whose straight edge lies `at` from the pixel's middle, the lamp towards lesser values:
/// the integral up to there of a Gaussian cut at `radius`, its value there subtracted (with the error function by its integral, the
/// midpoint rule).
pub fn gaussian_edge(stddev: f64, radius: f64, at: f64) -> f64 {
    const STEPS: usize = 2_000;
    let bell = |x: f64| (-x * x / (2.0 * stddev * stddev)).exp();
    let sum = |to: f64| {
        let step = (to + radius) / STEPS as f64;
        (0..STEPS).map(|i| (bell((i as f64 + 0.5) * step - radius) - bell(radius)) * step).sum::<f64>()
    };
    sum(at.clamp(-radius, radius)) / sum(radius)
}

/// Likewise for equal weights within `radius`.
pub fn box_edge(radius: f64, at: f64) -> f64 {
    ((at + radius) / (2.0 * radius)).clamp(0.0, 1.0)
}

/// What a closed surface that emits 1 and reflects `rho` shows for paths of `depth` segments.
pub fn furnace(rho: f64, depth: i32) -> f64 {
    (1.0 - rho.powi(depth)) / (1.0 - rho)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, by: f64) {
        assert!((a - b).abs() <= by, "{a} is not {b}");
    }

    #[test]
    fn slabs_of_the_literature() {
        near(slab(0.0, 1.5), 0.923_08, 1e-5);
        near(slab(60.0, 1.5), 0.836_23, 1e-5);
        near(slab(0.0, 1.8), 0.849_06, 1e-5);
        near(slab(60.0, 1.8), 0.762_67, 1e-5);
        near(slab_once(0.0, 1.8), 0.843_40, 1e-5);
    }

    #[test]
    fn metals_become_glass_without_extinction_and_mirrors_at_grazing_angles() {
        for cosine in [1.0, 0.7, 0.3, 0.05] {
            near(conductor(cosine, 1.5, 0.0), dielectric(cosine, 1.5), 1e-12);
        }
        // ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2) head-on.
        near(conductor(1.0, 0.2, 3.9), (0.64 + 15.21) / (1.44 + 15.21), 1e-12);
        near(conductor(1e-9, 0.2, 3.9), 1.0, 1e-6);
    }

    #[test]
    fn the_distribution_of_slopes_is_normalised() {
        for alpha in [0.1, 0.5, 1.0] {
            // Of D cos over the hemisphere, by the midpoint rule in the cosine's square.
            let sum: f64 = (0..200_000)
                .map(|at| {
                    let square = (f64::from(at) + 0.5) / 200_000.0;
                    PI * ggx(square.sqrt(), alpha) / 200_000.0
                })
                .sum();
            near(sum, 1.0, 1e-3);
        }
    }

    #[test]
    fn albedos_agree_with_the_plain_integral() {
        let metal = Metal { eta: 0.2, k: 3.9, alpha: 0.5 };
        for cosine in [1.0_f64, 0.5, 0.2] {
            let out = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
            let (mut sum, steps) = (0.0, 600);
            for i in 0..steps {
                // Equal shares of the solid angle.
                let z = (f64::from(i) + 0.5) / f64::from(steps);
                for j in 0..steps {
                    let phi = (f64::from(j) + 0.5) / f64::from(steps) * PI;
                    let r = (1.0 - z * z).sqrt();
                    sum += metal.reflects([0.0, 0.0, 1.0], out, [r * phi.cos(), r * phi.sin(), z]) * z;
                }
            }
            let plain = sum * 2.0 * PI / f64::from(steps * steps);
            near(metal.albedo(cosine), plain, 2e-3);
        }
        // Smooth metal loses nothing to masking.
        let smooth = Metal { alpha: 0.01, ..metal };
        near(smooth.albedo(1.0), conductor(1.0, 0.2, 3.9), 1e-3);
    }

    #[test]
    fn a_polygon_that_fills_the_sky_gives_pi() {
        let far = [[-1e6, -1e6, 1.0], [1e6, -1e6, 1.0], [1e6, 1e6, 1.0], [-1e6, 1e6, 1.0]];
        near(polygon(&far, [0.0; 3], [0.0, 0.0, 1.0]), PI, 1e-4);
        // A small square at the distance 10: its area over the distance squared.
        let small = [[-0.1, -0.1, 10.0], [0.1, -0.1, 10.0], [0.1, 0.1, 10.0], [-0.1, 0.1, 10.0]];
        near(polygon(&small, [0.0; 3], [0.0, 0.0, 1.0]), 4e-4, 1e-7);
    }

    #[test]
    fn edges_of_gaussians() {
        // The normal distribution at -2, -1, 0, 0.5 standard deviations.
        for (at, share) in [(-2.0, 0.022_75), (-1.0, 0.158_66), (0.0, 0.5), (0.5, 0.691_46)] {
            near(gaussian_edge(0.7, 9.0, 0.7 * at), share, 1e-5);
        }
        // Cut at two, 0.1353 subtracted: (0.4773 sqrt(2 pi) - 2 0.1353) of each side, 0.3413 sqrt(2 pi) - 0.1353 within one.
        let (side, one) = (0.477_25 * 2.506_63 - 2.0 * 0.135_34, 0.341_34 * 2.506_63 - 0.135_34);
        near(gaussian_edge(1.0, 2.0, 1.0), 0.5 + one / side / 2.0, 1e-4);
        assert_eq!((gaussian_edge(1.0, 2.0, 3.0), gaussian_edge(1.0, 2.0, -3.0)), (1.0, 0.0));
        assert_eq!((box_edge(1.5, 0.75), box_edge(1.5, 2.0), box_edge(0.5, -0.25)), (0.75, 1.0, 0.25));
    }

    #[test]
    fn furnaces_sum_up() {
        near(furnace(0.8, 1), 1.0, 1e-12);
        near(furnace(0.8, 3), 1.0 + 0.8 + 0.64, 1e-12);
        near(furnace(0.8, 10), 4.463_129, 1e-6);
    }
}
