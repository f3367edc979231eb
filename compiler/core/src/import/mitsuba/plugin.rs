//! Plugins: elements with a type, whose children are their parameters, asked for by name. What nobody asks for is a finding.

use super::color;
use super::tree::Element;
use crate::diag::Span;
use crate::import::color::Use;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Affine, Color, Vec3, cross, normalized, sub};

/// The most numbers of a list.
const MOST: usize = 1 << 16;

/// An element with a type.
#[derive(Clone, Copy)]
pub struct Plugin<'e> {
    /// The element.
    pub element: &'e Element,
}

/// Elements that are values; all others are plugins.
const VALUES: [&str; 15] = [
    "float",
    "integer",
    "boolean",
    "string",
    "rgb",
    "srgb",
    "spectrum",
    "blackbody",
    "point",
    "vector",
    "transform",
    "animation",
    "ref",
    "alias",
    "color",
];

impl<'e> Plugin<'e> {
    /// The plugin that an element is.
    pub fn new(element: &'e Element) -> Self {
        element.used.set(true);
        Self { element }
    }

    /// Its type, in lower case.
    pub fn kind(&self) -> &'e str {
        self.element.word("type")
    }

    /// Where it stands.
    pub fn span(&self) -> Span {
        self.element.span
    }

    /// The name that it is known by; empty where it has none.
    pub fn id(&self) -> &'e str {
        self.element.word("id")
    }

    /// A parameter of this name, whatever its type.
    pub fn find(&self, name: &str) -> Option<&'e Element> {
        let found = self.element.children.iter().rfind(|child| child.get("name") == Some(name))?;
        found.used.set(true);
        Some(found)
    }

    /// Whether it has a parameter of this name.
    pub fn has(&self, name: &str) -> bool {
        self.element.children.iter().any(|child| child.get("name") == Some(name))
    }

    /// Parameters that mean nothing to the image are looked at and left alone.
    pub fn pass(&self, names: &[&str]) {
        for name in names {
            let _looked_at: Option<&Element> = self.find(name);
        }
    }

    /// Says that parameters which are there and change something are left out.
    pub fn drop(&self, fate: Fate, names: &[&str], why: &str, reader: &mut Reader<'_>) {
        for name in names {
            if let Some(found) = self.find(name) {
                let message = format!("`{name}` of `{}` is left out: {why}", shown(self.kind()));
                reader.lost(fate, found.span, message);
            }
        }
    }

    /// A number.
    pub fn float(&self, name: &str, reader: &mut Reader<'_>) -> Option<f64> {
        let found = self.find(name)?;
        let value = number(found.word("value"));
        let right = matches!(found.tag.as_str(), "float" | "integer" | "spectrum" | "rgb");
        match value.filter(|_| right) {
            Some(value) => Some(value),
            None => {
                self.wrong(found, name, "a finite number", reader);
                None
            }
        }
    }

    /// A number within bounds; what lies outside is a finding, and the nearest bound.
    pub fn float_in(&self, name: &str, range: (f64, f64), default: f64, reader: &mut Reader<'_>) -> f64 {
        let Some(value) = self.float(name, reader) else { return default };
        let cut = value.clamp(range.0, range.1);
        if cut != value {
            let message = format!("`{name}` of `{}` is {value}: {cut} is taken", shown(self.kind()));
            reader.lost(Fate::Approximated, self.span_of(name), message);
        }
        cut
    }

    /// Where a parameter stands, or the plugin.
    pub fn span_of(&self, name: &str) -> Span {
        self.find(name).map_or(self.span(), |found| found.span)
    }

    /// A whole number.
    pub fn integer(&self, name: &str, reader: &mut Reader<'_>) -> Option<i64> {
        let found = self.find(name)?;
        let value = found.word("value").trim();
        let whole = value.parse().ok().or_else(|| number(value).filter(|x| x.fract() == 0.0).map(|x| x as i64));
        if whole.is_none() {
            self.wrong(found, name, "a whole number", reader);
        }
        whole
    }

    /// `true` or `false`.
    pub fn boolean(&self, name: &str, reader: &mut Reader<'_>) -> Option<bool> {
        let found = self.find(name)?;
        match found.word("value").trim() {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            _ => {
                self.wrong(found, name, "`true` or `false`", reader);
                None
            }
        }
    }

    /// Words.
    pub fn string(&self, name: &str) -> Option<&'e str> {
        self.find(name).map(|found| found.word("value").trim())
    }

    fn wrong(&self, found: &Element, name: &str, wanted: &str, reader: &mut Reader<'_>) {
        let message = format!("`{name}` of `{}` is not {wanted}: its default is taken", shown(self.kind()));
        reader.lost(Fate::Dropped, found.span, message);
    }

    /// A color that is the same everywhere; none where the parameter is missing or is a texture, which stays to be looked at.
    pub fn color(&self, name: &str, use_of: Use, reader: &mut Reader<'_>) -> Option<Color> {
        let found = self.find(name)?;
        if !VALUES.contains(&found.tag.as_str()) || found.tag == "ref" {
            return None;
        }
        match color::read(found, use_of, reader) {
            Ok(color) => Some(color),
            Err(why) => {
                let message = format!("`{name}` of `{}` is left out, its default is taken: {why}", shown(self.kind()));
                reader.lost(Fate::Dropped, found.span, message);
                None
            }
        }
    }

    /// Three coordinates, in attributes of their own or in one.
    pub fn vector(&self, name: &str, reader: &mut Reader<'_>) -> Option<Vec3> {
        let found = self.find(name)?;
        let made = match found.get("value") {
            Some(text) => numbers(text).and_then(|numbers| Vec3::try_from(numbers).ok()),
            None => axes(found, 0.0),
        };
        if made.is_none() {
            self.wrong(found, name, "three finite numbers", reader);
        }
        made
    }

    /// A transform; the identity where there is none.
    pub fn transform(&self, name: &str, reader: &mut Reader<'_>) -> Affine {
        let Some(found) = self.find(name) else { return Affine::IDENTITY };
        let found = if found.tag == "animation" {
            reader.lost(Fate::Dropped, found.span, "a motion is left out: the scene stands still at its beginning");
            let Some(first) = found.children.iter().find(|child| child.tag == "transform") else {
                return Affine::IDENTITY;
            };
            first
        } else {
            found
        };
        let mut map = Affine::IDENTITY;
        for step in &found.children {
            step.used.set(true);
            match step_of(step) {
                Some(step) => map = map.then(&step),
                None => {
                    let message = format!("a step of a transform cannot be read: `{}`", shown(&step.tag));
                    reader.add(crate::diag::Finding::error("syntax-error", step.span, message));
                }
            }
        }
        map
    }

    /// The plugins within it that have no name, or whatever name.
    pub fn inner(&self, tag: &'static str) -> impl Iterator<Item = Plugin<'e>> + use<'e> {
        self.element.children.iter().filter(move |child| child.tag == tag).map(Plugin::new)
    }

    /// Says what was not asked for.
    pub fn finish(&self, reader: &mut Reader<'_>) {
        for child in self.element.children.iter().filter(|child| !child.used.get()) {
            let name = child.get("name").or_else(|| child.get("type")).unwrap_or_default();
            let (kind, tag) = (shown(self.kind()), shown(&child.tag));
            let what = format!("{tag} {}", shown(name));
            let message = format!("`{}` of `{kind}` is left out: it is not known", what.trim_end());
            reader.lost(Fate::Dropped, child.span, message);
        }
    }
}

/// A finite number.
pub fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite())
}

/// Numbers between blanks and commas.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words.take(MOST + 1).map(number).collect::<Option<_>>()?;
    (numbers.len() <= MOST).then_some(numbers)
}

fn axes(element: &Element, default: f64) -> Option<Vec3> {
    let mut values = [default; 3];
    for (value, name) in values.iter_mut().zip(["x", "y", "z"]) {
        if let Some(text) = element.get(name) {
            *value = number(text)?;
        }
    }
    Some(values)
}

/// A step of a transform, applied after those before it.
fn step_of(step: &Element) -> Option<Affine> {
    let row = |name: &str| step.get(name).and_then(numbers).unwrap_or_default();
    let three = |default: f64| match step.get("value").map(numbers) {
        Some(values) => match values.as_deref() {
            Some([all]) => Some([*all; 3]),
            Some([x, y, z]) => Some([*x, *y, *z]),
            _ => None,
        },
        None => axes(step, default),
    };
    match step.tag.as_str() {
        "translate" => three(0.0).map(Affine::translation),
        "scale" => three(1.0).map(Affine::scaling),
        "rotate" => {
            let axis = match step.get("value") {
                Some(text) => numbers(text).and_then(|numbers| Vec3::try_from(numbers).ok()),
                None => axes(step, 0.0),
            };
            let degrees = step.get("angle").and_then(number)?;
            axis.and_then(normalized).map(|axis| Affine::rotation(axis, degrees))
        }
        "matrix" => {
            let rows = row("value");
            let of = |side: usize| -> Affine {
                let entry = |axis: usize, column: usize| rows.get(axis * side + column).copied().unwrap_or_default();
                let last = |axis: usize| if side == 4 { entry(axis, 3) } else { 0.0 };
                Affine { rows: [0, 1, 2].map(|axis| [entry(axis, 0), entry(axis, 1), entry(axis, 2), last(axis)]) }
            };
            match rows.len() {
                9 => Some(of(3)),
                16 if rows[12..] == [0.0, 0.0, 0.0, 1.0] => Some(of(4)),
                _ => None,
            }
        }
        "lookat" => {
            let [origin, target] = ["origin", "target"].map(|name| Vec3::try_from(row(name)).ok());
            let (origin, target) = (origin?, target?);
            let up = Vec3::try_from(row("up")).ok();
            // Without `up`, or with one along the view, any direction across it will do (as Mitsuba does).
            up.and_then(|up| look_at(origin, target, up))
                .or_else(|| look_at(origin, target, [0.0, 1.0, 0.0]))
                .or_else(|| look_at(origin, target, [1.0, 0.0, 0.0]))
        }
        _ => None,
    }
}

/// From camera to scene coordinates: x = up x forward, y up, z along the axis (`Transform::lookAt` of 0.6, `look_at` of 3.9.1).
fn look_at(origin: Vec3, target: Vec3, up: Vec3) -> Option<Affine> {
    let forward = normalized(sub(target, origin))?;
    let x = normalized(cross(normalized(up)?, forward))?;
    let y = cross(forward, x);
    Some(Affine { rows: [0, 1, 2].map(|axis| [x[axis], y[axis], forward[axis], origin[axis]]) })
}
