//! The text of LuxCore's files: lines `key = value`, gathered by the thing that the key is about.

use std::cell::Cell;
use std::collections::BTreeMap;

use crate::formats::shared::reading::Rgb;
use crate::formats::shared::source::{SYNTAX, Source, Text, UNKNOWN, numbers, shown};

/// A line.
#[derive(Clone, Copy, Debug)]
pub struct Property<'t> {
    /// The key.
    pub key: &'t str,
    /// The value as it stands there.
    pub value: &'t str,
    /// Where the line begins.
    pub at: usize,
}

/// The lines of a text. One that is none is a finding.
pub fn lines<'t>(text: Text<'t>, source: &mut Source<'_>, mut see: impl FnMut(Property<'t>, &mut Source<'_>)) {
    let mut at = 0;
    for line in text.text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if source.is_full() {
            break;
        }
        match line.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                see(Property { key: key.trim_end(), value: value.trim_start(), at: start }, source);
            }
            _ => source.say(SYNTAX, text.origin(start), "the line is no property"),
        }
    }
}

/// A thing: what its lines say.
#[derive(Debug)]
pub struct Thing<'t> {
    /// Its id.
    pub id: &'t str,
    /// Where its first line begins.
    pub at: usize,
    lines: Vec<(&'t str, Property<'t>, Cell<bool>)>,
}

/// Things of one kind in the order of their first lines.
#[derive(Debug, Default)]
pub struct Things<'t> {
    /// The things.
    pub all: Vec<Thing<'t>>,
    places: BTreeMap<&'t str, usize>,
}

impl<'t> Things<'t> {
    /// Adds a line whose key ends in `rest`: an id, and the name of a property.
    pub fn add(&mut self, rest: &'t str, property: Property<'t>, text: Text<'_>, source: &mut Source<'_>) {
        let Some((id, name)) = rest.split_once('.') else {
            source.say(SYNTAX, text.origin(property.at), format!("`{}` names no property", shown(property.key)));
            return;
        };
        // Lines of a thing stand together.
        let last = self.all.len().wrapping_sub(1);
        let place = match self.all.last() {
            Some(thing) if thing.id == id => last,
            _ => *self.places.entry(id).or_insert_with(|| {
                self.all.push(Thing { id, at: property.at, lines: Vec::with_capacity(3) });
                self.all.len() - 1
            }),
        };
        let thing = &mut self.all[place];
        if thing.lines.iter().any(|(known, _, _)| *known == name) {
            source.say(SYNTAX, text.origin(property.at), format!("`{}` is given twice", shown(property.key)));
        }
        thing.lines.push((name, property, Cell::new(false)));
    }

    /// The thing called `id`.
    pub fn find(&self, id: &str) -> Option<&Thing<'t>> {
        self.place(id).map(|place| &self.all[place])
    }

    /// Its place among all.
    pub fn place(&self, id: &str) -> Option<usize> {
        self.places.get(id).copied()
    }
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
}

/// The value within double quotes. Nothing in it is escaped.
pub fn string(value: &str) -> Option<&str> {
    let inner = value.strip_prefix('"')?.strip_suffix('"')?;
    (!inner.contains(['"', '\\'])).then_some(inner)
}

impl<'t> Thing<'t> {
    /// Where a property stands, else the thing.
    pub fn place(&self, name: &str) -> usize {
        self.lines.iter().find(|(known, _, _)| *known == name).map_or(self.at, |(_, property, _)| property.at)
    }

    fn find(&self, name: &str) -> Option<Property<'t>> {
        let (_, property, used) = self.lines.iter().find(|(known, _, _)| *known == name)?;
        used.set(true);
        Some(*property)
    }

    /// A string.
    pub fn string(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<&'t str> {
        let property = self.find(name)?;
        let found = string(property.value);
        if found.is_none() {
            to.say(SYNTAX, property.at, format!("`{name}` is no string in double quotes"));
        }
        found
    }

    /// A string, if it is one and not numbers.
    pub fn reference(&self, name: &str) -> Option<&'t str> {
        let property = self.lines.iter().find(|(known, _, _)| *known == name)?.1;
        let found = string(property.value)?;
        self.find(name);
        Some(found)
    }

    /// As many numbers as `N`.
    pub fn row<const N: usize>(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<[f64; N]> {
        let property = self.find(name)?;
        let found = numbers(property.value, false).and_then(|all| <[f64; N]>::try_from(all).ok());
        if found.is_none() {
            to.say(SYNTAX, property.at, format!("`{name}` is not made of {N} finite numbers"));
        }
        found
    }

    /// One number.
    pub fn float(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<f64> {
        self.row::<1>(name, to).map(|[value]| value)
    }

    /// A color.
    pub fn rgb(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Rgb> {
        self.row::<3>(name, to)
    }

    /// What must have this value where it is given: what another one means is not read.
    pub fn expect(&self, name: &str, value: &str, to: &mut Said<'_, '_, '_>) {
        if let Some(property) = self.find(name).filter(|property| property.value != value) {
            to.say(SYNTAX, property.at, format!("`{name}` other than {value} is not read"));
        }
    }

    /// The same for what must be given, since the default is another value.
    pub fn demand(&self, name: &str, value: &str, to: &mut Said<'_, '_, '_>) {
        if self.find(name).is_none_or(|property| property.value != value) {
            to.say(SYNTAX, self.place(name), format!("`{name}` other than {value} is not read"));
        }
    }

    /// Says what was not asked for.
    pub fn finish(&self, to: &mut Said<'_, '_, '_>) {
        for (_, property, _) in self.lines.iter().filter(|(_, _, used)| !used.get()) {
            to.say(UNKNOWN, property.at, format!("the property `{}` is not known", shown(property.key)));
        }
    }
}
