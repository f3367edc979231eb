//! What targets state of a scene, and verdicts that allow for it.

use serde::{Deserialize, Serialize};

use super::{CompareError, Outcome, Tolerance, Verdict};

/// By how much a target says that it may be off for a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stated {
    /// The renderer.
    pub by: String,
    /// In what.
    pub what: String,
    /// The largest share.
    pub share: f64,
}

/// By how much of what targets state the tolerance for agreement grows at most: images may differ by more without being called
/// different, and are not called equal.
const MOST_STATED: f64 = 0.1;

/// Beyond this share an image may be as dark as it likes.
const NEARLY_ALL: f64 = 0.99;

/// The tolerance with a share of the right value that may be missing beside it: tolerances are held against the darker of two images, and the
/// one that is off may be that one.
fn beside(tolerance: f64, share: f64) -> f64 {
    (tolerance + share) / (1.0 - share.min(NEARLY_ALL))
}

/// The verdict within a tolerance and what targets state beside it, `more`; and whether the images differ by more than would still be
/// called agreement, and by no more than is stated.
///
/// # Errors
/// As of [`judge_in`].
pub fn judge_stated(
    judge: impl Fn(Tolerance) -> Result<Verdict, CompareError>,
    tolerance: Tolerance,
    more: f64,
) -> Result<(Verdict, bool), CompareError> {
    let added = more.min(MOST_STATED);
    let verdict = judge(Tolerance { tiles: tolerance.tiles + added, whole: tolerance.whole + added })?;
    if more <= MOST_STATED || verdict.outcome != Outcome::Differ {
        return Ok((verdict, false));
    }
    let wide = judge(Tolerance { tiles: beside(tolerance.tiles, more), whole: beside(tolerance.whole, more) })?;
    if wide.outcome == Outcome::Differ {
        return Ok((wide, false));
    }
    Ok((Verdict { outcome: Outcome::Undecided, ..verdict }, true))
}

#[cfg(test)]
mod tests {
    use super::super::{Outcome, Rendered, judge};
    use super::*;
    use crate::compare::Images;
    use ltsc_render::image::Image;

    #[test]
    fn what_is_stated_widens_agreement_by_a_tenth_at_most() {
        let flat = |value: f32| vec![Image::filled(16, 16, [value; 3]); 4];
        let of = |ratio: f32, more: f64| {
            let (a, b) = (flat(1.0), flat(ratio));
            let side = |images| Rendered { images: Images::Held(images), samples: 16.0 };
            let (verdict, excused) = judge_stated(
                |tolerance| judge(side(&a), side(&b), tolerance),
                Tolerance { tiles: 0.05, whole: 0.01 },
                more,
            )
            .expect("a verdict");
            (verdict.outcome, excused)
        };
        assert_eq!(of(1.005, 0.0), (Outcome::Agree, false));
        assert_eq!(of(1.08, 0.0), (Outcome::Differ, false));
        assert_eq!(of(1.08, 0.09), (Outcome::Agree, false));
        assert_eq!(of(1.08, 2.7), (Outcome::Agree, false), "within what a tenth allows");
        assert_eq!(of(1.5, 2.7), (Outcome::Undecided, true), "stated, and no agreement");
        assert_eq!(of(1.5, 0.2), (Outcome::Differ, false), "more than is stated");
        assert_eq!(of(0.35, 0.691), (Outcome::Undecided, true), "darker by what is stated");
        assert_eq!(of(0.307, 0.691), (Outcome::Undecided, true), "and by the tolerance of what is left");
        assert_eq!(of(0.25, 0.691), (Outcome::Differ, false), "darker than is stated");
        assert_eq!(of(0.01, 1.2), (Outcome::Undecided, true), "as dark as it likes");
    }

    /// What is off by a half may be the darker one: it is off by all of itself.
    #[test]
    fn shares_of_the_right_value_become_shares_of_the_darker() {
        for (share, of_darker) in [(0.0, 0.0), (0.2, 0.25), (0.5, 1.0), (0.75, 3.0), (0.99, 99.0), (2.0, 200.0)] {
            assert!((beside(0.0, share) - of_darker).abs() < 1e-9, "{share}");
        }
    }

    /// What is asked of the judge: up to a tenth the same more of both tolerances, beyond it those of what is left.
    #[test]
    fn both_tolerances_grow() {
        let asked = std::cell::RefCell::new(Vec::new());
        let flat = vec![Image::filled(8, 8, [1.0; 3]); 3];
        let twice = vec![Image::filled(8, 8, [2.0; 3]); 3];
        let side = |images| Rendered { images: Images::Held(images), samples: 1.0 };
        let of = |more: f64| {
            asked.borrow_mut().clear();
            let judged = |tolerance: Tolerance| {
                asked.borrow_mut().push((tolerance.tiles, tolerance.whole));
                judge(side(&flat), side(&twice), tolerance)
            };
            let (verdict, excused) =
                judge_stated(judged, Tolerance { tiles: 0.25, whole: 0.125 }, more).expect("a verdict");
            (verdict.outcome, verdict.tolerance.tiles, excused)
        };
        assert_eq!(of(0.0625), (Outcome::Differ, 0.3125, false));
        assert_eq!(*asked.borrow(), [(0.3125, 0.1875)]);
        assert_eq!(of(MOST_STATED), (Outcome::Differ, 0.25 + MOST_STATED, false), "no more than agreement allows");
        assert_eq!(asked.borrow().len(), 1);
        // Half of the right value is as much as the darker one, and images that differ by all of it are excused.
        assert_eq!(of(0.5), (Outcome::Undecided, 0.25 + MOST_STATED, true));
        assert_eq!(*asked.borrow(), [(0.25 + MOST_STATED, 0.125 + MOST_STATED), (1.5, 1.25)]);
        assert_eq!(of(0.25), (Outcome::Differ, 2.0 / 3.0, false), "by more than is stated");
    }
}
