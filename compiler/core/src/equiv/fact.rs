//! Single facts of two things, and how near is near.

use crate::formats::shared::number::Num;
use crate::ir::{Color, Vec3, length, sub};

/// How near is near.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// The tolerance: a share.
    pub share: f64,
    /// The size of the scene in its units.
    pub size: f64,
}

impl Measure {
    /// How far two places may be apart whose largest coordinate is `reach`.
    pub fn distance(&self, reach: f64) -> f64 {
        // Positions have single precision.
        (self.share * self.size.min(reach)).max(reach * f64::from(f32::EPSILON))
    }

    /// Whether two numbers are equal.
    pub fn numbers(&self, a: f64, b: f64) -> bool {
        a == b || (a - b).abs() <= self.share * a.abs().max(b.abs())
    }

    /// Whether two places are the same.
    pub fn places(&self, a: Vec3, b: Vec3) -> bool {
        let reach = a.iter().chain(&b).fold(0.0_f64, |most, x| most.max(x.abs()));
        length(sub(a, b)) <= self.distance(reach.max(self.size))
    }

    /// Whether two unit vectors are the same.
    pub fn directions(&self, a: Vec3, b: Vec3) -> bool {
        length(sub(a, b)) <= self.share
    }

    /// Whether two unit normals, which are often written with few digits, are the same.
    pub fn normals(&self, a: Vec3, b: Vec3) -> bool {
        length(sub(a, b)) <= 10.0 * self.share
    }

    /// Whether two colors are the same, at every wavelength where both are spectra.
    pub fn colors(&self, a: &Color, b: &Color) -> bool {
        let near = |a: &[f64], b: &[f64]| {
            let most = a.iter().chain(b).fold(0.0_f64, |most, x| most.max(x.abs()));
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= self.share * most)
        };
        match (a.spectrum(), b.spectrum()) {
            (Some(a), Some(b)) => {
                let sampled = |spectrum: &crate::ir::Spectrum| -> Vec<f64> {
                    (0..=94).map(|step| spectrum.value(360.0 + 5.0 * f64::from(step))).collect()
                };
                near(&sampled(a), &sampled(b))
            }
            _ => near(&a.rgb(), &b.rgb()),
        }
    }
}

/// One fact of a thing.
#[derive(Clone, Debug)]
pub enum Fact {
    /// A word or a whole number, in words.
    Exact(String),
    /// A number with what it counts: `deg`, or nothing.
    Number(f64, &'static str),
    /// A place in the scene.
    Place(Vec3),
    /// A unit vector.
    Direction(Vec3),
    /// A color.
    Color(Color),
}

impl Fact {
    /// Whether it is the same as another one.
    pub fn same(&self, other: &Self, measure: Measure) -> bool {
        match (self, other) {
            (Self::Exact(a), Self::Exact(b)) => a == b,
            (Self::Number(a, _), Self::Number(b, _)) => measure.numbers(*a, *b),
            (Self::Place(a), Self::Place(b)) => measure.places(*a, *b),
            (Self::Direction(a), Self::Direction(b)) => measure.directions(*a, *b),
            (Self::Color(a), Self::Color(b)) => measure.colors(a, b),
            (
                Self::Exact(_) | Self::Number(_, _) | Self::Place(_) | Self::Direction(_) | Self::Color(_),
                Self::Exact(_) | Self::Number(_, _) | Self::Place(_) | Self::Direction(_) | Self::Color(_),
            ) => false,
        }
    }

    /// In words.
    pub fn words(&self) -> String {
        match self {
            Self::Exact(word) => word.clone(),
            Self::Number(number, "") => short(*number),
            Self::Number(number, unit) => format!("{} {unit}", short(*number)),
            Self::Place(vector) | Self::Direction(vector) => point(*vector),
            Self::Color(color) => shown(color),
        }
    }
}

/// What a thing is, and its facts by name.
#[derive(Clone, Debug)]
pub struct Facts {
    /// What kind of thing.
    pub word: &'static str,
    /// Facts; things of one kind have the same names in the same order.
    pub rows: Vec<(&'static str, Fact)>,
}

impl Facts {
    /// What differs: what it is, what A has, what B has. Things of two kinds differ as wholes.
    pub fn differences(&self, other: &Self, measure: Measure) -> Vec<(String, [String; 2])> {
        if self.word != other.word || self.rows.len() != other.rows.len() {
            return vec![("kind".to_owned(), [self.words(), other.words()])];
        }
        let rows = self.rows.iter().zip(&other.rows);
        rows.filter(|((_, a), (_, b))| !a.same(b, measure))
            .map(|((name, a), (_, b))| (format!("{} {name}", self.word), told_apart(a, b)))
            .collect()
    }

    /// In words: `conductor(eta: 0.2, k: 3, alpha: 0.1)`.
    pub fn words(&self) -> String {
        let rows: Vec<String> = self.rows.iter().map(|(name, fact)| format!("{name}: {}", fact.words())).collect();
        if rows.is_empty() { self.word.to_owned() } else { format!("{}({})", self.word, rows.join(", ")) }
    }
}

/// Both in words, with all digits where few do not tell them apart.
fn told_apart(a: &Fact, b: &Fact) -> [String; 2] {
    match (a, b) {
        (Fact::Number(one, unit), Fact::Number(other, _)) if short(*one) == short(*other) => {
            [one, other].map(|number| format!("{} {unit}", Num(*number)).trim_end().to_owned())
        }
        _ => [a.words(), b.words()],
    }
}

/// A color in words: a grey is a number.
pub fn shown(color: &Color) -> String {
    let [r, g, b] = color.rgb().map(short);
    if color.spectrum().is_some() {
        format!("a spectrum of rgb({r}, {g}, {b})")
    } else if r == g && g == b {
        r
    } else {
        format!("rgb({r}, {g}, {b})")
    }
}

/// A place or a direction in words.
pub fn point(vector: Vec3) -> String {
    let [x, y, z] = vector.map(short);
    format!("({x}, {y}, {z})")
}

/// A number with six digits at most.
pub fn short(number: f64) -> String {
    let rounded = format!("{number:.5e}").parse().unwrap_or(number);
    Num(rounded).to_string()
}
