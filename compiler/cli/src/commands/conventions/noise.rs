//! The samples that renderers need which compute with wavelengths, and what noise is left.

use ltsc_render::run::Driver;

use super::kinds::{Channel, Measure, Tolerance};
use super::measure::pixels;
use super::results::Asked;

/// The most samples of an image, all pixels together: some ten seconds.
const MOST: f64 = 8e6;

/// Standard errors that a bound has room for.
const ERRORS: f64 = 4.0;

/// What a channel takes of the noise of a brighter one: a lamp of (0.5, 2, 30) has a standard deviation of 3.2 in red and 2.8 in
/// green for each sample (measured with pbrt-r4 4.5.2).
const SPILLED: f64 = 0.1;

/// Samples per pixel of a view for a renderer: those of its scene, and more where wavelengths alone would be noise beyond the
/// bounds of its checks.
pub fn samples(driver: &Driver, asked: &Asked) -> u32 {
    let plain = asked.scene.sampler.samples();
    if driver.wavelengths.is_none() {
        return plain;
    }
    let film = &asked.scene.film;
    let pixels = f64::from(film.width) * f64::from(film.height);
    let enough = |at: usize| {
        let check = &asked.view.checks[at];
        let (bound, relative) = check.tolerance.parts();
        let share = if relative { bound } else { bound / asked.expected[at] };
        let needed = (ERRORS * deviation(driver, asked, at) / share).powi(2);
        if needed.is_finite() { needed / measured_pixels(asked, at) } else { 0.0 }
    };
    let needed = (0..asked.view.checks.len()).map(enough).fold(0.0, f64::max);
    let affordable = (MOST / pixels).max(f64::from(plain));
    // At most MOST.
    needed.min(affordable).ceil().max(f64::from(plain)) as u32
}

/// What noise of wavelengths is left in the check, in the unit of its tolerance: nothing for other renderers.
pub fn left(driver: &Driver, asked: &Asked, at: usize) -> f64 {
    let taken = f64::from(samples(driver, asked)) * measured_pixels(asked, at);
    let share = ERRORS * deviation(driver, asked, at) / taken.sqrt();
    match asked.view.checks[at].tolerance {
        Tolerance::Share(bound) => (share - bound).max(0.0),
        Tolerance::Plain(bound) => (share * asked.expected[at].abs() - bound).max(0.0),
    }
}

/// The standard deviation of a sample by its wavelengths, as a share of what is measured; 0 where that is none or no mean.
fn deviation(driver: &Driver, asked: &Asked, at: usize) -> f64 {
    let (Some(wavelengths), Measure::Mean(region, channel)) = (driver.wavelengths, asked.view.checks[at].measure) else {
        return 0.0;
    };
    let value = asked.expected[at];
    if value <= 0.0 {
        return 0.0;
    }
    let others = asked.view.checks.iter().zip(&asked.expected).filter_map(|(check, value)| match check.measure {
        Measure::Mean(other, _) if other == region => Some(*value),
        Measure::Mean(..) | Measure::Covered(..) | Measure::Middle(..) | Measure::Shift(_) => None,
    });
    let brightest = others.fold(value, f64::max);
    let own = wavelengths[match channel {
        Channel::Red => 0,
        Channel::Green => 1,
        Channel::Blue => 2,
        Channel::All => 3,
    }];
    let spilled = if brightest > value { SPILLED * brightest / value } else { 0.0 };
    own.hypot(spilled)
}

fn measured_pixels(asked: &Asked, at: usize) -> f64 {
    let size = (asked.scene.film.width as usize, asked.scene.film.height as usize);
    match asked.view.checks[at].measure {
        Measure::Mean(region, _) => {
            let (columns, rows) = pixels(&region, size);
            (columns.len() * rows.len()) as f64
        }
        Measure::Covered(..) | Measure::Middle(..) | Measure::Shift(_) => (size.0 * size.1) as f64,
    }
}
