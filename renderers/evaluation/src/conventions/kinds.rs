//! What a convention is: a micro-scene, the images to take of it, and what is measured in each with its answer.

use ltsc_core::capability::Feature;

/// One convention. Its scene, `renderers/evaluation/conventions/NAME.lts`, says in words what holds and where the answer comes from.
pub struct Convention {
    /// The name of its scene.
    pub name: &'static str,
    /// The text of its scene.
    pub text: &'static str,
    /// What targets answer to these is wrong where the checks of a view that asks for it fail.
    pub proves: &'static [Feature],
    /// The images to take.
    pub views: &'static [View],
}

/// One image of a micro-scene.
pub struct View {
    /// What tells it from the others; empty for the only one.
    pub name: &'static str,
    /// Values of the scene's parameters.
    pub set: &'static [(&'static str, &'static str)],
    /// Width and height, if not the scene's.
    pub size: Option<(u32, u32)>,
    /// The depth of paths, if not the scene's.
    pub depth: Option<u32>,
    /// What is measured.
    pub checks: &'static [Check],
}

impl View {
    /// The scene as it is.
    pub const fn plain(checks: &'static [Check]) -> Self {
        Self { name: "", set: &[], size: None, depth: None, checks }
    }
}

/// One number of an image and its answer.
pub struct Check {
    /// What it is, unique within the view.
    pub name: &'static str,
    /// How it is measured.
    pub measure: Measure,
    /// What it should be.
    pub expected: Expected,
    /// How far off it may be and still hold, noise of the scene's samples included.
    pub tolerance: Tolerance,
    /// What a target must be able to say for it: where one of them is unsupported, so is the row, and where one is approximate,
    /// its bound for the scene counts.
    pub rests_on: &'static [Feature],
    /// Deviations that are stated in words only.
    pub known: &'static [Known],
}

/// A part of the image in shares of its width and height, from the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// From and to across.
    pub x: (f64, f64),
    /// From and to down.
    pub y: (f64, f64),
}

impl Region {
    /// The whole image.
    pub const ALL: Self = area(0.0, 1.0, 0.0, 1.0);
}

/// The region from `left` to `right` and from `top` to `bottom`.
pub const fn area(left: f64, right: f64, top: f64, bottom: f64) -> Region {
    Region { x: (left, right), y: (top, bottom) }
}

/// Which channel is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// The mean of the three.
    All,
}

/// An axis of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// To the right.
    X,
    /// Downwards.
    Y,
}

/// How a number is taken from an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// The mean over a region.
    Mean(Region, Channel),
    /// How many pixels a lamp of radiance 1 covers along an axis within a region: the sum along it of the mean across it.
    Covered(Region, Axis),
    /// The middle of the brightness along an axis, in pixels from the left or from the top.
    Middle(Channel, Axis),
    /// The whole shift along an axis, in pixels, that moves the image best onto that of the formulas.
    Shift(Axis),
}

/// Where an answer comes from.
#[derive(Clone, Copy)]
pub enum Expected {
    /// A number that the scene's text derives.
    Number(f64),
    /// A formula or a quadrature.
    Formula(fn() -> f64),
    /// The mean over the rays to the region's pixels of what formulas say of the scene; see [`super::ideal`].
    Ideal,
    /// A mean over renderings of a named renderer, version and number of samples, where no formula exists.
    Reference {
        /// The number.
        value: f64,
        /// Which.
        by: &'static str,
    },
}

/// How far a number may be off and still hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// As a share of the answer.
    Share(f64),
    /// In the number's own unit.
    Plain(f64),
}

impl Tolerance {
    /// The number, and whether it is a share.
    pub fn parts(self) -> (f64, bool) {
        match self {
            Self::Share(bound) => (bound, true),
            Self::Plain(bound) => (bound, false),
        }
    }
}

/// A deviation of a target that is stated somewhere already.
pub struct Known {
    /// The target; none where it is so with all of them.
    pub target: Option<&'static str>,
    /// Where it is stated.
    pub by: By,
    /// How large it may be.
    pub within: Within,
}

/// Where a deviation is stated.
pub enum By {
    /// In the answer of the target to a feature. The words stand in its reason or bound, so that neither changes alone.
    Feature(Feature, &'static str),
    /// In a rule of lint that refuses such scenes.
    Rule(&'static str),
}

/// How large a stated deviation may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Within {
    /// Measured over expected lies between the two.
    Ratio(f64, f64),
    /// The difference is at most this.
    Distance(f64),
}
