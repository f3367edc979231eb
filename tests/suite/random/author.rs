//! Writes calls of constructors by their table, and keeps a record of which it has written.

use std::collections::{BTreeMap, BTreeSet};

use ltsc_core::eval::{Constructor, Family, table};

use super::dice::Dice;

/// The rows and parameters that were written: by family and name.
pub type Written = BTreeMap<(Family, &'static str), BTreeSet<&'static str>>;

/// Functions of numbers, each in a term that leaves a number as it is: `x` stands for it.
const TERMS: &[(&str, &str)] = &[
    ("sin", "x + sin(0deg)"),
    ("cos", "x * cos(0deg)"),
    ("tan", "x + tan(0rad)"),
    ("asin", "x + sin(asin(0))"),
    ("acos", "x * cos(acos(1))"),
    ("atan", "x + sin(atan(0))"),
    ("atan2", "x * cos(atan2(0, 1))"),
    ("sqrt", "x * sqrt(1)"),
    ("abs", "x * abs(-1)"),
    ("floor", "x + floor(0.7)"),
    ("ceil", "x * ceil(0.7)"),
    ("round", "x + round(0.4)"),
    ("exp", "x * exp(0)"),
    ("log", "x + log(1)"),
    ("pow", "x * pow(7, 0)"),
    ("mod", "x + mod(4, 2)"),
    ("min", "min(x, x)"),
    ("max", "max(x, x)"),
    ("random", "x + 0 * random(1, b: 2, c: 3, d: 4)"),
    ("sum", "sum([x, 0])"),
    ("len", "x * len([7])"),
    ("reverse", "reverse([1, x])[0]"),
    ("concat", "concat([1], [x])[1]"),
    ("dot", "dot(X, (x, 1, 2))"),
    ("cross", "x * cross(X, Y).z"),
    ("length", "x * length(Y)"),
    ("normalize", "x * normalize((3, 0, 0)).x"),
    ("table", "x + 0 * table(\"heights.npy\")[0][0]"),
];

/// Writes the texts of scenes.
pub struct Author {
    pub dice: Dice,
    pub written: Written,
    /// Whether all terms of numbers are plain: in texts that must not read files.
    pub plain: bool,
    names: u32,
}

impl Author {
    pub fn new(seed: u64) -> Self {
        Self { dice: Dice::new(seed), written: Written::new(), plain: false, names: 0 }
    }

    /// A call of the constructor `name`, which the table must have, with these arguments in the order of its parameters. Those
    /// that may stand without a label sometimes do.
    pub fn call(&mut self, family: Family, name: &'static str, arguments: &[(&'static str, String)]) -> String {
        let row = row(family, name);
        let stage = usize::from(family == Family::Stage);
        let params = &row.params[stage..];
        let used = self.written.entry((family, name)).or_default();
        let mut parts = Vec::new();
        let mut unlabelled = self.dice.chance(0.6);
        for (at, (param, value)) in arguments.iter().enumerate() {
            let known = params.iter().find(|known| known.name == *param);
            used.insert(known.unwrap_or_else(|| panic!("`{name}` has no parameter `{param}`")).name);
            unlabelled &= at < row.positional && params[at].name == *param;
            parts.push(if unlabelled { value.clone() } else { format!("{param}: {value}") });
        }
        format!("{name}({})", parts.join(", "))
    }

    /// A number as a term.
    pub fn number(&mut self, value: f64) -> String {
        let plain = if value != 0.0 && (value.abs() < 1e-3 || value.abs() >= 1e7) && self.dice.chance(0.5) {
            format!("{value:e}")
        } else {
            format!("{value}")
        };
        if self.plain || !self.dice.chance(0.02) {
            return plain;
        }
        let (name, term) = self.dice.pick(TERMS);
        let row = row(Family::Function, name);
        self.written.entry((Family::Function, name)).or_default().extend(row.params.iter().map(|param| param.name));
        // The letter stands alone in every term.
        let words = term.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| *word == "x").count();
        let mut text = String::new();
        let mut rest = term;
        let mut left = words;
        while let Some(at) = rest.find('x') {
            let alone = |c: Option<char>| c.is_none_or(|c| !c.is_ascii_alphanumeric() && c != '.');
            let (before, after) = (rest[..at].chars().last().or(text.chars().last()), rest[at + 1..].chars().next());
            text.push_str(&rest[..at]);
            if left > 0 && alone(before) && alone(after) {
                text.push_str(&plain);
                left -= 1;
            } else {
                text.push('x');
            }
            rest = &rest[at + 1..];
        }
        text.push_str(rest);
        format!("({text})")
    }

    /// Any number from `low` to `high`.
    pub fn within(&mut self, low: f64, high: f64) -> String {
        let value = self.dice.between(low, high);
        self.number(value)
    }

    pub fn vector(&mut self, parts: &[f64]) -> String {
        let parts: Vec<String> = parts.iter().map(|part| self.number(*part)).collect();
        format!("({})", parts.join(", "))
    }

    /// A vector whose parts lie within `reach` of 0.
    pub fn near(&mut self, reach: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| self.dice.between(-reach, reach))
    }

    /// A direction that is not near to 0.
    pub fn direction(&mut self) -> [f64; 3] {
        let mut vector = self.near(5.0);
        let axis = self.dice.at(3);
        vector[axis] = self.dice.between(1.0, 5.0);
        vector
    }

    pub fn angle(&mut self, low: f64, high: f64) -> String {
        let degrees = self.dice.between(low, high);
        if self.dice.chance(0.8) { format!("{degrees}deg") } else { format!("{}rad", degrees.to_radians()) }
    }

    pub fn range(&mut self, low: f64, high: f64) -> String {
        let (low, high) = (self.number(low), self.number(high));
        format!("{low}..{high}")
    }

    /// A color from 0 to `most`.
    pub fn color(&mut self, most: f64) -> String {
        let channel = |author: &mut Self| match author.dice.at(8) {
            0 => 0.0,
            1 => most,
            _ => author.dice.between(0.0, most),
        };
        match self.dice.at(6) {
            0 | 1 => {
                let grey = channel(self);
                self.number(grey)
            }
            2 if most == 1.0 => {
                let code = format!("\"#{:06x}\"", self.dice.whole(0, 0xff_ffff));
                self.call(Family::Color, "srgb", &[("hex", code)])
            }
            3 if most <= 100.0 => {
                let points = [400, 550, 700].map(|nm| {
                    let value = self.dice.between(0.02, 0.8) * most;
                    format!("({nm}, {value})")
                });
                self.call(Family::Color, "spectrum", &[("values", format!("[{}]", points.join(", ")))])
            }
            _ => {
                let [r, g, b] = [0, 1, 2].map(|_| channel(self)).map(|value| self.number(value));
                self.call(Family::Color, "rgb", &[("r", r), ("g", g), ("b", b)])
            }
        }
    }

    /// A name of an item that no other has in this scene.
    pub fn name(&mut self, stem: &str) -> String {
        self.names += 1;
        let at = self.names;
        match self.dice.at(12) {
            0 => format!("`{stem} {at}`"),
            1 => format!("`{stem}/{at}`"),
            2 => format!("`{stem}-\u{e4}\u{3bb}\u{4e2d}-{at}`"),
            3 => format!("`<{stem} & \"{at}\">`"),
            4 => format!("`\\{stem}.{at}#`"),
            5 => format!("{}_{at}", stem.to_ascii_uppercase()),
            _ => format!("{stem}{at}"),
        }
    }

    /// A name that is a word.
    pub fn word(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}_{}", self.names)
    }
}

/// The row of a constructor.
pub fn row(family: Family, name: &str) -> &'static Constructor {
    let found = table().find(|row| row.family == family && row.name == name);
    found.unwrap_or_else(|| panic!("there is no constructor `{name}` of {}", family.words()))
}
