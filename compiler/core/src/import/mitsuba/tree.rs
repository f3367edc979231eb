//! XML as a tree of elements with their places; includes, defaults and aliases are resolved on the way.

use std::cell::Cell;
use std::collections::BTreeMap;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader as Xml;

use crate::diag::{FileId, Finding, Span};
use crate::files::VPath;
use crate::import::reader::{Fate, Reader, shown};

/// How deep elements may be nested: scenes need about ten.
const DEPTH: usize = 64;

/// How deep files may include each other.
const INCLUDES: usize = 16;

/// How many bytes values may take once defaults are put in, for each byte of the texts: none of them grows much.
const GROWTH: usize = 64;

/// An element. What nobody looks at is a finding in the end.
#[derive(Debug)]
pub struct Element {
    /// Its name; those of 0.4 and 0.5 are today's (`luminaire` is `emitter`).
    pub tag: String,
    /// Where it stands.
    pub span: Span,
    /// Attributes in their order, defaults put in; the value of `name` is in snake case.
    pub attributes: Vec<(String, String)>,
    /// What stands in it.
    pub children: Vec<Element>,
    /// Whether it has been looked at.
    pub used: Cell<bool>,
}

impl Element {
    /// An attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// An attribute; empty where it is missing.
    pub fn word(&self, name: &str) -> &str {
        self.get(name).unwrap_or_default()
    }
}

/// What holds for a whole scene.
pub struct Whole {
    /// The elements of the scene, with those of included files in the place of their `include`.
    pub elements: Vec<Element>,
    /// Where the main file begins.
    pub start: Span,
}

/// Reads a file and all that it includes; none where its main file is no scene.
pub fn read(reader: &mut Reader<'_>, path: &VPath) -> Option<Whole> {
    let defines = reader.options.defines.clone();
    let mut reading = Reading { reader, main: path.folder().to_owned(), values: defines, open: Vec::new(), bytes: 0 };
    let root = reading.file(path, None)?;
    Some(Whole { start: root.span, elements: root.children })
}

struct Reading<'r, 'f> {
    reader: &'r mut Reader<'f>,
    /// The folder of the main file, from which paths are meant.
    main: String,
    /// What `$name` stands for: what the user says, then the first `default`.
    values: BTreeMap<String, String>,
    /// The files that are being read.
    open: Vec<VPath>,
    /// What values take.
    bytes: usize,
}

impl Reading<'_, '_> {
    /// The root element of a file, with all that it includes.
    fn file(&mut self, path: &VPath, from: Option<Span>) -> Option<Element> {
        let file = match self.reader.text(path) {
            Ok(file) => file,
            Err(error) => {
                let message = format!("`{path}` cannot be read: {error}");
                match from {
                    Some(span) => self.reader.error("missing-file", span, message),
                    None => {
                        let origin = crate::diag::Origin::File { path: path.to_string(), place: String::new() };
                        self.reader.error("missing-file", origin, message);
                    }
                }
                return None;
            }
        };
        self.open.push(path.clone());
        let root = parse(self.reader, file);
        let root = root.and_then(|root| self.expanded(root, path));
        self.open.pop();
        root
    }

    /// The root with defaults put in, and includes in their place.
    fn expanded(&mut self, root: Element, path: &VPath) -> Option<Element> {
        if root.tag != "scene" {
            let message = format!("this is no scene of Mitsuba: the first element is `{}`", shown(&root.tag));
            self.reader.add(Finding::error("syntax-error", root.span, message).help("a scene begins with `<scene>`"));
            return None;
        }
        let mut children = Vec::new();
        // Up to 0.6 renderers of three channels took one number of a spectrum for red, green and blue; since 2 it is that of every
        // wavelength, which has a color where it is light.
        let version = root.word("version").split('.').next().and_then(|major| major.trim().parse::<u32>().ok());
        let old = version.is_some_and(|major| major < 2);
        let Element { tag, span, attributes, children: before, used } = root;
        for mut child in before {
            if old {
                plain_spectra(&mut child);
            }
            self.element(child, path, &mut children);
        }
        Some(Element { tag, span, attributes, children, used })
    }

    fn element(&mut self, mut element: Element, path: &VPath, to: &mut Vec<Element>) {
        for (name, value) in &mut element.attributes {
            if value.contains('$') && !matches!(name.as_str(), "id") {
                *value = self.filled(value, element.span);
            }
        }
        match element.tag.as_str() {
            "default" => {
                let value = element.word("value").to_owned();
                self.reader.declare(element.word("name"));
                self.values.entry(element.word("name").to_owned()).or_insert(value);
            }
            "include" => self.include(&element, path, to),
            // Where Mitsuba looks for files besides; what is found there is not below the root.
            "path" => {
                let message = "a search path is not followed: files are looked for beside the scene";
                self.reader.lost(Fate::Noise, element.span, message);
            }
            _ => {
                let mut children = Vec::new();
                for child in std::mem::take(&mut element.children) {
                    self.element(child, path, &mut children);
                }
                element.children = children;
                if let Some((_, name)) = element.attributes.iter_mut().find(|(known, _)| known == "name") {
                    *name = snake(name);
                }
                to.push(element);
            }
        }
    }

    fn include(&mut self, element: &Element, path: &VPath, to: &mut Vec<Element>) {
        let written = element.word("filename").replace('\\', "/");
        let candidates = [self.main.as_str(), path.folder()].map(|folder| VPath::resolve(folder, &written));
        let found = candidates.iter().flatten().find(|path| self.reader.bytes(path).is_ok());
        let Some(found) = found.or_else(|| candidates[0].as_ref().ok()).cloned() else {
            let why = candidates[0].as_ref().err().map(ToString::to_string).unwrap_or_default();
            let message = format!("`{}` is not included: {why}", shown(&written));
            self.reader.error("bad-path", element.span, message);
            return;
        };
        if self.open.contains(&found) || self.open.len() == INCLUDES {
            let message = if self.open.len() == INCLUDES {
                format!("`{found}` is not included: files include each other more than {INCLUDES} deep")
            } else {
                format!("`{found}` includes itself")
            };
            self.reader.error("import-limit", element.span, message);
            return;
        }
        if let Some(root) = self.file(&found, Some(element.span)) {
            to.extend(root.children);
        }
    }

    /// A value with what its `$names` stand for.
    fn filled(&mut self, value: &str, span: Span) -> String {
        let mut filled = String::new();
        let mut rest = value;
        while let Some(at) = rest.find('$') {
            filled.push_str(&rest[..at]);
            let after = &rest[at + 1..];
            let length = after.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(after.len());
            let name = &after[..length];
            self.reader.declare(name);
            match self.values.get(name) {
                Some(value) => filled.push_str(value),
                None => {
                    let message = format!("`${}` has no value", shown(name));
                    let help = format!("give it one: `--set {}=...`", shown(name));
                    self.reader.add(Finding::error("unknown-name", span, message).help(help));
                }
            }
            rest = &after[length..];
            self.bytes += filled.len();
            if self.bytes > GROWTH * (1 << 20) {
                self.reader.error("import-limit", span, "the values of `default` elements make too long a text");
                return filled;
            }
        }
        filled.push_str(rest);
        filled
    }
}

/// Makes colors of the spectra that have no wavelengths. Elements are nested to a bounded depth.
fn plain_spectra(element: &mut Element) {
    if element.tag == "spectrum" && element.get("filename").is_none() && !element.word("value").contains(':') {
        "rgb".clone_into(&mut element.tag);
    }
    element.children.iter_mut().for_each(plain_spectra);
}

/// The root element of a text; none where there is none, which is a finding.
fn parse(reader: &mut Reader<'_>, file: FileId) -> Option<Element> {
    let text = std::sync::Arc::clone(&reader.sources.get(file).text);
    let mut xml = Xml::from_str(&text);
    let mut open: Vec<Element> = Vec::new();
    let mut root: Option<Element> = None;
    let span = |start: usize, end: usize| Span { file, start: start as u32, end: end as u32 };
    loop {
        let at = xml.buffer_position() as usize;
        let event = xml.read_event();
        let here = span(at, xml.buffer_position() as usize);
        let event = match event {
            Ok(event) => event,
            Err(problem) => {
                let at = xml.error_position() as usize;
                reader.error("syntax-error", span(at, at), format!("this is no XML: {problem}"));
                return None;
            }
        };
        let done = match event {
            Event::Start(start) => {
                if open.len() == DEPTH {
                    reader.error("import-limit", here, format!("elements are nested more than {DEPTH} deep"));
                    return None;
                }
                open.push(element(&start, here, reader)?);
                None
            }
            Event::Empty(start) => Some(element(&start, here, reader)?),
            // The parser has seen that it is the end of what is open.
            Event::End(_) => open.pop(),
            Event::Text(words) => {
                if !words.trim().is_empty() {
                    reader.lost(Fate::Noise, here, "text between the elements is passed over");
                }
                None
            }
            Event::CData(_) | Event::GeneralRef(_) => {
                reader.lost(Fate::Noise, here, "text between the elements is passed over");
                None
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => None,
            Event::Eof => {
                if let Some(open) = open.last() {
                    let message = format!("`{}` does not end", shown(&open.tag));
                    reader.error("syntax-error", open.span, message);
                    return None;
                }
                if root.is_none() {
                    reader.error("syntax-error", here, "there is no element");
                }
                return root;
            }
        };
        let Some(done) = done else { continue };
        match open.last_mut() {
            Some(outer) => outer.children.push(done),
            None if root.is_none() => root = Some(done),
            None => {
                reader.error("syntax-error", done.span, "a second element stands behind the first");
                return root;
            }
        }
    }
}

fn element(start: &BytesStart<'_>, span: Span, reader: &mut Reader<'_>) -> Option<Element> {
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let read = attribute.map_err(|problem| problem.to_string()).and_then(|attribute| {
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|problem| problem.to_string())?;
            Ok((attribute.key.as_ref().to_owned(), value.into_owned()))
        });
        match read {
            Ok(read) => attributes.push(read),
            Err(problem) => {
                reader.error("syntax-error", span, format!("an attribute cannot be read: {problem}"));
                return None;
            }
        }
    }
    let name = start.name();
    let tag = match name.as_ref() {
        "luminaire" => "emitter",
        "camera" => "sensor",
        "lookAt" => "lookat",
        other => other,
    };
    Some(Element { tag: tag.to_owned(), span, attributes, children: Vec::new(), used: Cell::new(false) })
}

/// A name as Mitsuba 3 writes it: `toWorld` is `to_world`, `intIOR` is `int_ior`.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    let mut before = '_';
    for c in name.chars() {
        if c.is_ascii_uppercase() && (before.is_ascii_lowercase() || before.is_ascii_digit()) {
            snake.push('_');
        }
        snake.push(c.to_ascii_lowercase());
        before = c;
    }
    snake
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_snake_case() {
        for (name, known) in
            [("toWorld", "to_world"), ("intIOR", "int_ior"), ("max_depth", "max_depth"), ("toUV", "to_uv")]
        {
            assert_eq!(snake(name), known);
        }
    }
}
