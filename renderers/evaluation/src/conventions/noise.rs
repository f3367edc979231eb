//! The samples that renderers need which compute with wavelengths, and what noise is left.

use ltsc_render::run::Driver;

use super::kinds::{Axis, Channel, Measure, Tolerance};
use super::measure::pixels;
use super::results::Asked;

/// The most samples of an image, all pixels together: some five seconds.
const MOST: f64 = 4e6;

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
        let (bound, _) = asked.view.checks[at].tolerance.parts();
        let (deviation, measured) = deviation(driver, asked, at);
        (ERRORS * deviation / bound).powi(2) / measured
    };
    let needed = (0..asked.view.checks.len()).map(enough).fold(0.0, f64::max);
    let affordable = (MOST / pixels).max(f64::from(plain));
    // At most MOST.
    needed.min(affordable).ceil().max(f64::from(plain)) as u32
}

/// What noise of wavelengths is left in the check, in the unit of its tolerance: nothing for other renderers.
pub fn left(driver: &Driver, asked: &Asked, at: usize) -> f64 {
    let (bound, _) = asked.view.checks[at].tolerance.parts();
    let (deviation, measured) = deviation(driver, asked, at);
    let taken = f64::from(samples(driver, asked)) * measured;
    (ERRORS * deviation / taken.sqrt() - bound).max(0.0)
}

/// The standard deviation that wavelengths alone give a check of one sample in each pixel that counts, in the unit of its
/// tolerance, and how many pixels count.
fn deviation(driver: &Driver, asked: &Asked, at: usize) -> (f64, f64) {
    const NONE: (f64, f64) = (0.0, 1.0);
    let Some(wavelengths) = driver.wavelengths else { return NONE };
    let own = |channel: Channel| {
        wavelengths[match channel {
            Channel::Red => 0,
            Channel::Green => 1,
            Channel::Blue => 2,
            Channel::All => 3,
        }]
    };
    let film = &asked.scene.film;
    let size = (film.width as usize, film.height as usize);
    let check = &asked.view.checks[at];
    let value = asked.expected[at];
    match check.measure {
        Measure::Mean(region, channel) if value > 0.0 => {
            let (columns, rows) = pixels(&region, size);
            let others =
                asked.view.checks.iter().zip(&asked.expected).filter_map(|(check, value)| match check.measure {
                    Measure::Mean(other, _) if other == region => Some(*value),
                    Measure::Mean(..) | Measure::Covered(..) | Measure::Middle(..) | Measure::Shift(_) => None,
                });
            let brightest = others.fold(value, f64::max);
            let spilled = if brightest > value { SPILLED * brightest / value } else { 0.0 };
            let share = own(channel).hypot(spilled);
            let unit = match check.tolerance {
                Tolerance::Share(_) => share,
                Tolerance::Plain(_) => share * value,
            };
            (unit, (columns.len() * rows.len()) as f64)
        }
        // A quarter of the side away lies light of other colors; a sixteenth of the image has light.
        Measure::Middle(channel, axis) => {
            let side = match axis {
                Axis::X => film.width,
                Axis::Y => film.height,
            };
            let pixels = f64::from(film.width) * f64::from(film.height) / 16.0;
            (f64::from(side) / 4.0 * own(channel).hypot(3.0 * SPILLED), pixels)
        }
        Measure::Mean(..) | Measure::Covered(..) | Measure::Shift(_) => NONE,
    }
}
