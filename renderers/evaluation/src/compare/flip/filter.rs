//! The filters of FLIP as sums of separable ones, and how they run over a plane of numbers.

use std::array::from_fn;

/// Pixels per degree of visual angle where a display of 3840 pixels and 0.7 m is seen from 0.7 m: FLIP's default (Andersson et al.
/// 2020; `flip-evaluator` 1.7 says 67.02064).
pub(super) const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * std::f64::consts::PI / 180.0;

/// Sums of Gaussians `a sqrt(pi / b) exp(-pi^2 d^2 / b)` over degrees `d`, pairs `(a, b)`: the contrast sensitivity of the eye to
/// luminance, red against green, and blue against yellow (Andersson et al. 2020, after Johnson and Fairchild 2003). The
/// second summands of the first two have the factor 0.
const LUMINANCE: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Degrees from the middle of one edge to that of the next where features are seen best (Andersson et al. 2020).
const FEATURE: f64 = 0.082;

/// Pixels around a pixel that count for it: three standard deviations of the widest filter.
pub(super) const HALO: usize = 10;

/// Numbers that are worked on side by side. Rows are filtered in multiples of it.
pub(super) const LANES: usize = 8;

/// `N` filters of one radius along a row or column, `taps[k][n]` the weight of the `n`th at distance `k - radius`.
pub(super) struct Kernel<const N: usize> {
    taps: Vec<[f32; N]>,
}

/// All filters.
pub(super) struct Filters {
    pub luminance: Kernel<1>,
    pub red_green: Kernel<1>,
    /// Both summands along rows.
    pub blue_yellow: Kernel<2>,
    /// Each summand along columns, with its share.
    pub blue_yellow_down: [Kernel<1>; 2],
    /// First derivative, second derivative and Gaussian, along rows.
    pub features: Kernel<3>,
    /// Gaussian, along columns.
    pub features_smooth: Kernel<1>,
    /// First and second derivative, along columns.
    pub features_down: Kernel<2>,
}

impl Filters {
    pub(super) fn new() -> Self {
        let deviation = |(_, b): (f64, f64)| (b / 2.0).sqrt() / std::f64::consts::PI * PIXELS_PER_DEGREE;
        // One radius for all three: that of the widest.
        let radius = (3.0 * deviation(BLUE_YELLOW[0])).ceil() as usize;
        debug_assert_eq!(radius, HALO);
        // Beyond six standard deviations weights are below the rounding of single precision.
        let narrow = |own: (f64, f64)| {
            let radius = radius.min((6.0 * deviation(own)).ceil() as usize);
            Kernel::new(radius, [&unit(gaussian(radius, deviation(own)))])
        };
        let wide = BLUE_YELLOW.map(|own| gaussian(radius, deviation(own)));
        // The weights of the sum over the plane add up to 1, not those of its summands.
        let weight: [f64; 2] = from_fn(|at| {
            let (a, b) = BLUE_YELLOW[at];
            a * (std::f64::consts::PI / b).sqrt() * wide[at].iter().sum::<f64>().powi(2)
        });
        let wide = wide.map(unit);
        let share =
            |at: usize| wide[at].iter().map(|tap| tap * weight[at] / (weight[0] + weight[1])).collect::<Vec<_>>();
        let sharp = 0.5 * FEATURE * PIXELS_PER_DEGREE;
        let reach = (3.0 * sharp).ceil() as usize;
        let smooth = gaussian(reach, sharp);
        let from_middle = |at: usize| at as f64 - reach as f64;
        let first = balanced(smooth.iter().enumerate().map(|(at, tap)| -from_middle(at) * tap));
        let second = balanced(
            smooth.iter().enumerate().map(|(at, tap)| (from_middle(at).powi(2) / (sharp * sharp) - 1.0) * tap),
        );
        let smooth = unit(smooth);
        Self {
            luminance: narrow(LUMINANCE),
            red_green: narrow(RED_GREEN),
            blue_yellow: Kernel::new(radius, [&wide[0], &wide[1]]),
            blue_yellow_down: [Kernel::new(radius, [&share(0)]), Kernel::new(radius, [&share(1)])],
            features: Kernel::new(reach, [&first, &second, &smooth]),
            features_smooth: Kernel::new(reach, [&smooth]),
            features_down: Kernel::new(reach, [&first, &second]),
        }
    }
}

fn gaussian(radius: usize, deviation: f64) -> Vec<f64> {
    (0..=2 * radius).map(|at| (-0.5 * ((at as f64 - radius as f64) / deviation).powi(2)).exp()).collect()
}

/// Weights that add up to 1.
fn unit(taps: Vec<f64>) -> Vec<f64> {
    let sum: f64 = taps.iter().sum();
    taps.into_iter().map(|tap| tap / sum).collect()
}

/// Positive weights that add up to 1, and negative ones that add up to -1 (Andersson et al. 2020).
fn balanced(taps: impl Iterator<Item = f64>) -> Vec<f64> {
    let taps: Vec<f64> = taps.collect();
    let above: f64 = taps.iter().filter(|tap| **tap > 0.0).sum();
    let below: f64 = taps.iter().filter(|tap| **tap < 0.0).sum();
    taps.into_iter().map(|tap| if tap > 0.0 { tap / above } else { -tap / below }).collect()
}

impl<const N: usize> Kernel<N> {
    fn new(radius: usize, filters: [&[f64]; N]) -> Self {
        Self { taps: (0..=2 * radius).map(|at| filters.map(|filter| filter[at] as f32)).collect() }
    }

    fn radius(&self) -> usize {
        self.taps.len() / 2
    }

    /// Filters along rows: `source` has [`HALO`] numbers more than `out` at both ends of each row.
    pub(super) fn rows(&self, source: &[f32], width: usize, rows: usize, out: [&mut [f32]; N]) {
        self.run(&source[HALO - self.radius()..], (width + 2 * HALO, 1), (width, rows), out);
    }

    /// Filters along columns: `source` has [`HALO`] rows more than `out` above and below.
    pub(super) fn columns(&self, source: &[f32], width: usize, rows: usize, out: [&mut [f32]; N]) {
        self.run(&source[(HALO - self.radius()) * width..], (width, width), (width, rows), out);
    }

    /// Each number of `out` is the weighted sum of those that lie `step` apart in `source`, whose rows begin `pitch` apart.
    fn run(
        &self,
        source: &[f32],
        (pitch, step): (usize, usize),
        (width, rows): (usize, usize),
        mut out: [&mut [f32]; N],
    ) {
        for y in 0..rows {
            for x in (0..width).step_by(LANES) {
                let mut sums = [[0.0_f32; LANES]; N];
                let mut at = y * pitch + x;
                for tap in &self.taps {
                    let Some(values) = source[at..].first_chunk() else { break };
                    let mut filter = 0;
                    while filter < N {
                        add(&mut sums[filter], tap[filter], values);
                        filter += 1;
                    }
                    at += step;
                }
                for (out, sums) in out.iter_mut().zip(sums) {
                    out[y * width + x..][..LANES].copy_from_slice(&sums);
                }
            }
        }
    }
}

/// Adds numbers times a weight. Written out, and called by a plain loop, since a build without optimization, in which tests and first users
/// compare images, spends nearly all its time here.
#[inline]
fn add(sums: &mut [f32; LANES], weight: f32, values: &[f32; LANES]) {
    sums[0] += weight * values[0];
    sums[1] += weight * values[1];
    sums[2] += weight * values[2];
    sums[3] += weight * values[3];
    sums[4] += weight * values[4];
    sums[5] += weight * values[5];
    sums[6] += weight * values[6];
    sums[7] += weight * values[7];
}
