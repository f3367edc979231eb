//! Parameters of directives: `"float fov" [45]`, asked for by name. What nobody asks for is a finding.

use std::cell::Cell;

use super::tokens::{Token, Tokens};
use crate::diag::Span;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::Vec3;

/// What a parameter says.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers.
    Numbers(Vec<f64>),
    /// Strings.
    Strings(Vec<String>),
    /// `true` or `false` without quotes.
    Bools(Vec<bool>),
}

/// A parameter.
#[derive(Clone, Debug)]
pub struct Param {
    /// Where it stands.
    pub span: Span,
    /// Its type: `float`, `rgb`.
    pub kind: String,
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: Values,
    used: Cell<bool>,
}

impl Param {
    /// Its numbers, if it has such.
    pub fn numbers(&self) -> &[f64] {
        match &self.values {
            Values::Numbers(numbers) => numbers,
            Values::Strings(_) | Values::Bools(_) => &[],
        }
    }

    /// Its strings, if it has such.
    pub fn strings(&self) -> &[String] {
        match &self.values {
            Values::Strings(strings) => strings,
            Values::Numbers(_) | Values::Bools(_) => &[],
        }
    }
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub struct Params {
    /// Where the directive stands.
    pub span: Span,
    /// What they belong to: `matte`.
    pub kind: String,
    list: Vec<Param>,
}

impl Params {
    /// None at a place.
    pub fn none(kind: &str, span: Span) -> Self {
        Self { span, kind: kind.to_owned(), list: Vec::new() }
    }

    /// Reads parameters as long as strings follow; `start` is where their directive begins.
    pub fn read(kind: &str, start: usize, tokens: &mut Tokens<'_>, reader: &mut Reader<'_>) -> Self {
        let mut params = Self::none(kind, tokens.since(start));
        while tokens.peek() == Some(b'"') {
            let begin = tokens.at;
            let head = match tokens.next() {
                Some((Token::Quoted(head), _)) => head,
                _ => {
                    reader.lost(Fate::Dropped, tokens.since(begin), "a text in quotes without an end is left out");
                    continue;
                }
            };
            let span = tokens.since(begin);
            let mut words = head.split_ascii_whitespace();
            let (kind, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if name.is_empty() || words.next().is_some() {
                let message = format!("`{}` is left out: it is no type with a name", shown(&head));
                reader.lost(Fate::Dropped, span, message);
            }
            let Some(values) = values(tokens, reader) else {
                let message = format!("`{}` of `{}` is left out: it has no value", shown(&head), shown(&params.kind));
                reader.lost(Fate::Dropped, span, message);
                continue;
            };
            if name.is_empty() {
                continue;
            }
            if params.has(name) {
                let message =
                    format!("`{}` of `{}` stands twice: the last one counts", shown(name), shown(&params.kind));
                reader.lost(Fate::Noise, span, message);
                params.list.retain(|known| known.name != name);
            }
            let (kind, name) = (kind.to_owned(), name.to_owned());
            params.list.push(Param { span, kind, name, values, used: Cell::new(false) });
        }
        params
    }

    /// Adds those of another list that are not there; nobody has to ask for them.
    pub fn inherit(&mut self, defaults: &[Param]) {
        for param in defaults {
            if !self.has(&param.name) {
                param.used.set(true);
                self.list.push(param.clone());
            }
        }
    }

    /// Those of a list of defaults, the newest first.
    pub fn into_list(self) -> Vec<Param> {
        self.list
    }

    /// A parameter of this name, whatever its type.
    pub fn find(&self, name: &str) -> Option<&Param> {
        let found = self.list.iter().find(|param| param.name == name)?;
        found.used.set(true);
        Some(found)
    }

    /// Whether there is a parameter of this name.
    pub fn has(&self, name: &str) -> bool {
        self.list.iter().any(|param| param.name == name)
    }

    /// Where a parameter stands, or the directive.
    pub fn span_of(&self, name: &str) -> Span {
        self.list.iter().find(|param| param.name == name).map_or(self.span, |param| param.span)
    }

    /// Parameters that mean nothing to the image are looked at and left alone.
    pub fn pass(&self, names: &[&str]) {
        for name in names {
            let _looked_at: Option<&Param> = self.find(name);
        }
    }

    /// Everything was looked at.
    pub fn pass_all(&self) {
        self.list.iter().for_each(|param| param.used.set(true));
    }

    /// Says that parameters which are there and change something are left out.
    pub fn drop(&self, fate: Fate, names: &[&str], why: &str, reader: &mut Reader<'_>) {
        for name in names {
            if let Some(found) = self.find(name) {
                reader.lost(fate, found.span, format!("`{name}` of `{}` is left out: {why}", shown(&self.kind)));
            }
        }
    }

    fn wrong(&self, param: &Param, wanted: &str, reader: &mut Reader<'_>) {
        let message = format!("`{}` of `{}` is left out: it is not {wanted}", shown(&param.name), shown(&self.kind));
        reader.lost(Fate::Dropped, param.span, message);
    }

    /// One number. A texture is none.
    pub fn float(&self, name: &str, reader: &mut Reader<'_>) -> Option<f64> {
        let found = self.find(name)?;
        match found.numbers() {
            [value] => Some(*value),
            _ => {
                self.wrong(found, "one finite number", reader);
                None
            }
        }
    }

    /// A number within bounds; what lies outside is a finding, and the nearest bound.
    pub fn float_in(&self, name: &str, range: (f64, f64), default: f64, reader: &mut Reader<'_>) -> f64 {
        let Some(value) = self.float(name, reader) else { return default };
        let cut = value.clamp(range.0, range.1);
        if cut != value {
            let message = format!("`{name}` of `{}` is {value}: {cut} is taken", shown(&self.kind));
            reader.lost(Fate::Approximated, self.span_of(name), message);
        }
        cut
    }

    /// A whole number from 0 on.
    pub fn count(&self, name: &str, reader: &mut Reader<'_>) -> Option<u32> {
        let value = self.float(name, reader)?;
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Some(value as u32);
        }
        let found = self.find(name)?;
        self.wrong(found, "a count", reader);
        None
    }

    /// A list of numbers.
    pub fn numbers(&self, name: &str, reader: &mut Reader<'_>) -> Option<&[f64]> {
        let found = self.find(name)?;
        if let Values::Numbers(numbers) = &found.values {
            return Some(numbers);
        }
        self.wrong(found, "made of finite numbers", reader);
        None
    }

    /// Three coordinates.
    pub fn vector(&self, name: &str, reader: &mut Reader<'_>) -> Option<Vec3> {
        let found = self.find(name)?;
        match found.numbers() {
            [x, y, z] => Some([*x, *y, *z]),
            _ => {
                self.wrong(found, "three finite numbers", reader);
                None
            }
        }
    }

    /// `true` or `false`, with or without quotes.
    pub fn boolean(&self, name: &str, reader: &mut Reader<'_>) -> Option<bool> {
        let found = self.find(name)?;
        match &found.values {
            Values::Bools(bools) if bools.len() == 1 => return bools.first().copied(),
            Values::Strings(strings) => match strings.as_slice() {
                [word] if word == "true" => return Some(true),
                [word] if word == "false" => return Some(false),
                _ => {}
            },
            Values::Bools(_) | Values::Numbers(_) => {}
        }
        self.wrong(found, "`true` or `false`", reader);
        None
    }

    /// One string.
    pub fn string(&self, name: &str, reader: &mut Reader<'_>) -> Option<&str> {
        let found = self.find(name)?;
        match found.strings() {
            [text] => Some(text),
            _ => {
                self.wrong(found, "one string", reader);
                None
            }
        }
    }

    /// Says what was not asked for.
    pub fn finish(&self, reader: &mut Reader<'_>) {
        for param in self.list.iter().filter(|param| !param.used.get()) {
            let (kind, name) = (shown(&param.kind), shown(&param.name));
            let message = format!("`{kind} {name}` of `{}` is left out: it is not known", shown(&self.kind));
            reader.lost(Fate::Dropped, param.span, message);
        }
    }
}

/// The values of a parameter; none where there are none.
fn values(tokens: &mut Tokens<'_>, reader: &mut Reader<'_>) -> Option<Values> {
    let (mut numbers, mut strings, mut bools) = (Vec::new(), Vec::new(), Vec::new());
    let array = tokens.peek()? == b'[';
    let begin = tokens.at;
    if array {
        tokens.next();
    }
    loop {
        let here = tokens.here();
        match tokens.peek() {
            None if array => {
                reader.lost(Fate::Dropped, tokens.since(begin).to(here), "an array has no end");
                break;
            }
            None => break,
            // A directive: the array was not ended.
            Some(byte) if byte.is_ascii_uppercase() => {
                if array {
                    reader.lost(Fate::Dropped, tokens.here(), "a directive stands in an array, which ends before it");
                }
                break;
            }
            Some(b'0'..=b'9' | b'+' | b'-' | b'.') if array => {
                let before = numbers.len();
                tokens.numbers(&mut numbers);
                if numbers.len() > before {
                    continue;
                }
            }
            Some(_) => {}
        }
        match tokens.next() {
            Some((Token::Close, span)) => {
                if !array {
                    reader.lost(Fate::Dropped, span, "`]` is left out: no array is open");
                }
                break;
            }
            Some((Token::Number(number), _)) => numbers.push(number),
            Some((Token::Quoted(text), _)) => strings.push(text),
            Some((Token::Word(word), span)) => match word.as_str() {
                "true" => bools.push(true),
                "false" => bools.push(false),
                other => {
                    let message = format!("`{}` is left out: it is neither a finite number nor a string", shown(other));
                    reader.lost(Fate::Dropped, span, message);
                    // An array with a hole would be read as another one.
                    if array {
                        close(tokens);
                    }
                    return None;
                }
            },
            Some((Token::Open, span)) => {
                reader.lost(Fate::Dropped, span, "`[` is left out: an array stands in no other")
            }
            Some((Token::Broken, span)) => {
                reader.lost(Fate::Dropped, span, "a text in quotes without an end is left out");
            }
            None => break,
        }
        if !array {
            break;
        }
    }
    match (numbers.is_empty(), strings.is_empty(), bools.is_empty()) {
        (false, true, true) => Some(Values::Numbers(numbers)),
        (true, false, true) => Some(Values::Strings(strings)),
        (true, true, false) => Some(Values::Bools(bools)),
        (true, true, true) if array => Some(Values::Numbers(numbers)),
        (true, true, true) => None,
        _ => {
            reader.lost(Fate::Dropped, tokens.since(begin), "an array of numbers and strings together is left out");
            None
        }
    }
}

/// Passes over the rest of an array.
fn close(tokens: &mut Tokens<'_>) {
    while let Some(byte) = tokens.peek() {
        if byte.is_ascii_uppercase() {
            return;
        }
        if let Some((Token::Close, _)) = tokens.next() {
            return;
        }
    }
}
