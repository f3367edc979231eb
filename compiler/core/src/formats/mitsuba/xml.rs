//! XML as elements, and plugins whose parameters are asked for by type and name.

use std::cell::Cell;
use std::collections::BTreeMap;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::diag::{Finding, nearest};
use crate::formats::shared::reading::Rgb;
use crate::formats::shared::source::{LIMIT, SYNTAX, Source, Text, UNKNOWN, number, numbers, shown};
use crate::ir::{Affine, Vec3, cross, normalized, sub};

/// How XML may begin: in these words, whatever their case.
const DECLARATIONS: &[&str] = &[
    "<?xml version=\"1.0\" encoding=\"utf-8\"?>",
    "<?xml version=\"1.0\"?>",
    "<?xml version='1.0' encoding='utf-8'?>",
];

/// How deep elements may be nested: a scene needs about six.
const DEPTH: usize = 64;

/// An element.
#[derive(Debug)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// Where it begins.
    pub at: usize,
    attributes: Vec<(String, String)>,
    /// What stands in it.
    pub children: Vec<Element>,
    used: Cell<bool>,
}

impl Element {
    /// An attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// Attributes other than `known` are findings.
    pub fn only(&self, known: &[&str], to: &mut Said<'_, '_, '_>) {
        for (name, _) in self.attributes.iter().filter(|(name, _)| !known.contains(&name.as_str())) {
            to.say(UNKNOWN, self.at, format!("`{}` has an unknown attribute `{}`", shown(&self.name), shown(name)));
        }
    }
}

/// The root element of a text. What cannot be read is a finding.
pub fn parse(text: Text<'_>, source: &mut Source<'_>) -> Option<Element> {
    let mut reader = Reader::from_str(text.text);
    let mut open: Vec<Element> = Vec::new();
    let mut root: Option<Element> = None;
    loop {
        let at = reader.buffer_position() as usize;
        let mut to = Said { source, text };
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(problem) => {
                to.say(SYNTAX, reader.error_position() as usize, format!("this is no XML: {problem}"));
                return None;
            }
        };
        let done = match event {
            Event::Start(start) => {
                if open.len() == DEPTH {
                    to.say(LIMIT, at, format!("elements are nested more than {DEPTH} deep"));
                    return None;
                }
                open.push(element(&start, at, &mut to)?);
                None
            }
            Event::Empty(start) => Some(element(&start, at, &mut to)?),
            // The reader has seen that it is the end of what is open.
            Event::End(_) => open.pop(),
            Event::Text(words) => {
                if !words.trim().is_empty() {
                    to.say(SYNTAX, at, "text stands between the elements");
                }
                None
            }
            Event::Comment(_) => None,
            Event::Decl(_) => {
                let line = text.text.lines().next().unwrap_or_default();
                if !DECLARATIONS.iter().any(|known| line.trim_end().eq_ignore_ascii_case(known)) {
                    to.say(SYNTAX, at, "a text other than XML 1.0 in UTF-8 is not read");
                }
                None
            }
            Event::CData(_) | Event::PI(_) | Event::DocType(_) | Event::GeneralRef(_) => {
                to.say(SYNTAX, at, "this is not read");
                None
            }
            Event::Eof => {
                if let Some(open) = open.last() {
                    to.say(SYNTAX, open.at, format!("`{}` does not end", shown(&open.name)));
                    return None;
                }
                if root.is_none() {
                    to.say(SYNTAX, at, "there is no element");
                }
                return root;
            }
        };
        let Some(done) = done else { continue };
        match open.last_mut() {
            Some(outer) => outer.children.push(done),
            None if root.is_none() => root = Some(done),
            None => to.say(SYNTAX, done.at, "a second element stands behind the first"),
        }
    }
}

fn element(start: &BytesStart<'_>, at: usize, to: &mut Said<'_, '_, '_>) -> Option<Element> {
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let read = attribute.map_err(|problem| problem.to_string()).and_then(|attribute| {
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|problem| problem.to_string())?;
            Ok((attribute.key.as_ref().to_owned(), value.into_owned()))
        });
        match read {
            Ok(read) => attributes.push(read),
            Err(problem) => {
                to.say(SYNTAX, at, format!("an attribute cannot be read: {problem}"));
                return None;
            }
        }
    }
    let name = start.name().as_ref().to_owned();
    Some(Element { name, at, attributes, children: Vec::new(), used: Cell::new(false) })
}

/// Where findings go: the reading and the text that is read.
pub struct Said<'s, 'f, 't> {
    /// The reading.
    pub source: &'s mut Source<'f>,
    /// The text.
    pub text: Text<'t>,
}

impl Said<'_, '_, '_> {
    /// Adds a finding at a byte of the text.
    pub fn say(&mut self, id: &'static str, at: usize, message: impl Into<String>) {
        let origin = self.text.origin(at);
        self.source.say(id, origin, message);
    }

    /// Adds a finding about a word that is none of `known`.
    pub fn unknown(&mut self, at: usize, what: &str, word: &str, known: &[&str]) {
        let finding = Finding::error(UNKNOWN, self.text.origin(at), format!("there is no {what} `{}`", shown(word)));
        let help = nearest(word, known.iter().copied()).map(|near| format!("is `{near}` meant?"));
        self.source.add(finding.maybe_help(help));
    }
}

/// Values that `$name` stands for.
pub type Defaults = BTreeMap<String, String>;

/// An element with a type, whose children are its parameters. What nobody asks for is a finding in the end.
#[derive(Clone, Copy)]
pub struct Plugin<'e> {
    /// The element.
    pub element: &'e Element,
    defaults: &'e Defaults,
}

impl<'e> Plugin<'e> {
    /// The plugin that an element is.
    pub fn new(element: &'e Element, defaults: &'e Defaults) -> Self {
        element.used.set(true);
        Self { element, defaults }
    }

    /// Its type.
    pub fn kind(&self) -> &'e str {
        self.element.get("type").unwrap_or_default()
    }

    /// Where it begins.
    pub fn at(&self) -> usize {
        self.element.at
    }

    /// Whether it has a parameter of this name, of whatever type.
    pub fn has(&self, name: &str) -> bool {
        self.element.children.iter().any(|child| child.get("name") == Some(name))
    }

    /// A child that is a parameter.
    fn find(&self, tag: &str, name: &str) -> Option<&'e Element> {
        let found = self.element.children.iter().find(|child| child.name == tag && child.get("name") == Some(name))?;
        found.used.set(true);
        Some(found)
    }

    /// The value of a parameter, defaults put in.
    fn value(&self, tag: &str, name: &str, to: &mut Said<'_, '_, '_>) -> Option<(&'e Element, &'e str)> {
        let found = self.find(tag, name)?;
        found.only(&["name", "value"], to);
        let value = found.get("value").unwrap_or_default();
        match value.strip_prefix('$') {
            None => Some((found, value)),
            Some(default) => match self.defaults.get(default) {
                Some(value) => Some((found, value.as_str())),
                None => {
                    to.say(SYNTAX, found.at, format!("`${}` has no default", shown(default)));
                    None
                }
            },
        }
    }

    /// A number.
    pub fn float(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<f64> {
        let (found, value) = self.value("float", name, to)?;
        let number = number(value.trim());
        if number.is_none() {
            to.say(SYNTAX, found.at, format!("`{name}` is no finite number"));
        }
        number
    }

    /// A whole number.
    pub fn integer(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<i64> {
        let (found, value) = self.value("integer", name, to)?;
        let number = value.trim().parse().ok();
        if number.is_none() {
            to.say(SYNTAX, found.at, format!("`{name}` is no whole number"));
        }
        number
    }

    /// `true` or `false`.
    pub fn boolean(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<bool> {
        let (found, value) = self.value("boolean", name, to)?;
        match value {
            "true" => Some(true),
            "false" => Some(false),
            _ => {
                to.say(SYNTAX, found.at, format!("`{name}` is neither `true` nor `false`"));
                None
            }
        }
    }

    /// Words.
    pub fn string(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<&'e str> {
        self.value("string", name, to).map(|(_, value)| value)
    }

    /// A string that must be one of those that are understood.
    pub fn expect(&self, name: &str, known: &[&str], to: &mut Said<'_, '_, '_>) {
        if let Some((found, value)) = self.value("string", name, to).filter(|(_, value)| !known.contains(value)) {
            to.unknown(found.at, &format!("`{name}`"), value, known);
        }
    }

    /// A color, of one number or three.
    pub fn rgb(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Rgb> {
        let (found, value) = self.value("rgb", name, to)?;
        match numbers(value, true).as_deref() {
            Some([grey]) => Some([*grey; 3]),
            Some([r, g, b]) => Some([*r, *g, *b]),
            _ => {
                to.say(SYNTAX, found.at, format!("`{name}` is not made of three finite numbers"));
                None
            }
        }
    }

    /// Three coordinates in attributes of their own.
    pub fn vector(&self, tag: &str, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Vec3> {
        let found = self.find(tag, name)?;
        found.only(&["name", "x", "y", "z"], to);
        axes(found, 0.0, to)
    }

    /// A transform; the identity where there is none.
    pub fn transform(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Affine {
        let Some(found) = self.find("transform", name) else { return Affine::IDENTITY };
        found.only(&["name"], to);
        let steps = found.children.iter().map(|step| step_of(step, to));
        steps.fold(Affine::IDENTITY, |map, step| map.then(&step.unwrap_or(Affine::IDENTITY)))
    }

    /// The id of what a parameter refers to; without a name for what needs none.
    pub fn refers(&self, name: Option<&str>, to: &mut Said<'_, '_, '_>) -> Option<(&'e Element, &'e str)> {
        let found = self.element.children.iter().find(|child| child.name == "ref" && child.get("name") == name)?;
        found.used.set(true);
        found.only(&["name", "id"], to);
        Some((found, found.get("id").unwrap_or_default()))
    }

    /// The plugins of a kind within it.
    pub fn inner(&self, tag: &'static str) -> impl Iterator<Item = Plugin<'e>> + use<'e> {
        let defaults = self.defaults;
        let inner = self.element.children.iter().filter(move |child| child.name == tag);
        inner.map(move |element| Plugin::new(element, defaults))
    }

    /// Says what was not asked for.
    pub fn finish(&self, to: &mut Said<'_, '_, '_>) {
        self.element.only(&["type", "id", "name"], to);
        for child in self.element.children.iter().filter(|child| !child.used.get()) {
            let name = child.get("name").or_else(|| child.get("type")).unwrap_or_default();
            let (kind, tag) = (shown(self.kind()), shown(&child.name));
            to.say(UNKNOWN, child.at, format!("`{kind}` has an unknown parameter `{tag} {}`", shown(name)));
        }
    }
}

fn axes(element: &Element, default: f64, to: &mut Said<'_, '_, '_>) -> Option<Vec3> {
    let mut values = [default; 3];
    for (value, name) in values.iter_mut().zip(["x", "y", "z"]) {
        if let Some(text) = element.get(name) {
            let Some(read) = number(text.trim()) else {
                to.say(SYNTAX, element.at, format!("`{name}` is no finite number"));
                return None;
            };
            *value = read;
        }
    }
    Some(values)
}

/// A step of a transform, applied after those before it.
fn step_of(step: &Element, to: &mut Said<'_, '_, '_>) -> Option<Affine> {
    let row = |name: &str| step.get(name).and_then(|text| numbers(text, true)).unwrap_or_default();
    let made = match step.name.as_str() {
        "translate" => {
            step.only(&["x", "y", "z"], to);
            axes(step, 0.0, to).map(Affine::translation)
        }
        "scale" => {
            step.only(&["x", "y", "z", "value"], to);
            let all = step.get("value").and_then(|text| number(text.trim()));
            axes(step, all.unwrap_or(1.0), to).map(Affine::scaling)
        }
        "rotate" => {
            step.only(&["x", "y", "z", "angle"], to);
            let degrees = step.get("angle").and_then(|text| number(text.trim()));
            let axis = axes(step, 0.0, to).and_then(normalized);
            axis.zip(degrees).map(|(axis, degrees)| Affine::rotation(axis, degrees))
        }
        "matrix" => {
            step.only(&["value"], to);
            let rows = row("value");
            let affine = rows.len() == 16 && rows[12..] == [0.0, 0.0, 0.0, 1.0];
            affine.then(|| Affine { rows: [0, 4, 8].map(|at| [rows[at], rows[at + 1], rows[at + 2], rows[at + 3]]) })
        }
        "lookat" => {
            step.only(&["origin", "target", "up"], to);
            let [origin, target, up] = ["origin", "target", "up"].map(|name| Vec3::try_from(row(name)).ok());
            origin.zip(target).zip(up).and_then(|((origin, target), up)| look_at(origin, target, up))
        }
        other => {
            to.unknown(step.at, "transform", other, &["translate", "scale", "rotate", "matrix", "lookat"]);
            return None;
        }
    };
    if made.is_none() {
        to.say(SYNTAX, step.at, format!("`{}` cannot be read", shown(&step.name)));
    }
    made
}

/// From camera to scene coordinates: x = up x forward, y up, z along the axis (`Transform::lookAt` of 0.6, `look_at` of 3.9.1).
fn look_at(origin: Vec3, target: Vec3, up: Vec3) -> Option<Affine> {
    let forward = normalized(sub(target, origin))?;
    let x = normalized(cross(normalized(up)?, forward))?;
    let y = cross(forward, x);
    Some(Affine { rows: [0, 1, 2].map(|axis| [x[axis], y[axis], forward[axis], origin[axis]]) })
}
