//! The subset of Python that a scene consists of: calls, one to a line, of literals.

use std::cell::Cell;

use crate::formats::shared::reading::Rgb;
use crate::formats::shared::source::{SYNTAX, Source, Text, UNKNOWN, number, shown};
use crate::ir::{Affine, Vec3};

/// How deep values may be nested: a matrix is two deep, a material one.
const DEPTH: usize = 8;

/// A literal, or a call.
#[derive(Debug, PartialEq)]
pub enum Value<'t> {
    /// A number.
    Number(f64),
    /// `True` or `False`.
    Bool(bool),
    /// A string, escapes read.
    Text(String),
    /// Values in round brackets.
    Tuple(Vec<Value<'t>>),
    /// A call.
    Call(Call<'t>),
}

/// `name(value, key=value)`.
#[derive(Debug, PartialEq)]
pub struct Call<'t> {
    /// The function.
    pub name: &'t str,
    /// Where it begins.
    pub at: usize,
    arguments: Vec<(Option<&'t str>, Value<'t>)>,
}

/// The text cannot be read at this byte.
#[derive(Debug, PartialEq)]
pub struct Broken(pub usize);

/// A text in which calls are read.
pub struct Scanner<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Scanner<'t> {
    /// From a byte of a text on.
    pub fn new(text: &'t str, at: usize) -> Self {
        Self { text, at }
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn blank(&mut self) {
        while self.peek() == Some(b' ') {
            self.at += 1;
        }
    }

    fn take(&mut self, byte: u8) -> bool {
        self.blank();
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    fn word(&mut self) -> &'t str {
        self.blank();
        let start = self.at;
        while self.peek().is_some_and(|byte| byte == b'_' || byte.is_ascii_alphanumeric()) {
            self.at += 1;
        }
        &self.text[start..self.at]
    }

    /// A literal.
    pub fn literal(&mut self) -> Result<Value<'t>, Broken> {
        let at = self.at;
        match self.value(0)? {
            Value::Call(_) => Err(Broken(at)),
            value @ (Value::Number(_) | Value::Bool(_) | Value::Text(_) | Value::Tuple(_)) => Ok(value),
        }
    }

    /// A call.
    pub fn call(&mut self) -> Result<Call<'t>, Broken> {
        self.call_at(0)
    }

    fn call_at(&mut self, depth: usize) -> Result<Call<'t>, Broken> {
        self.blank();
        let at = self.at;
        let name = self.word();
        if name.is_empty() || name.as_bytes()[0].is_ascii_digit() || !self.take(b'(') || depth > DEPTH {
            return Err(Broken(at));
        }
        let mut arguments = Vec::new();
        while !self.take(b')') {
            if !arguments.is_empty() && !self.take(b',') {
                return Err(Broken(self.at));
            }
            self.blank();
            let start = self.at;
            let key = self.word();
            let named = !key.is_empty() && !key.as_bytes()[0].is_ascii_digit() && self.take(b'=');
            if !named {
                self.at = start;
            }
            arguments.push((named.then_some(key), self.value(depth + 1)?));
        }
        Ok(Call { name, at, arguments })
    }

    fn value(&mut self, depth: usize) -> Result<Value<'t>, Broken> {
        self.blank();
        let at = self.at;
        if depth > DEPTH {
            return Err(Broken(at));
        }
        match self.peek() {
            Some(b'"') => self.string().map(Value::Text),
            Some(b'(') => {
                self.at += 1;
                let mut values = Vec::new();
                while !self.take(b')') {
                    if !values.is_empty() && !self.take(b',') {
                        return Err(Broken(self.at));
                    }
                    values.push(self.value(depth + 1)?);
                }
                Ok(Value::Tuple(values))
            }
            Some(b'-' | b'0'..=b'9') => {
                let rest = &self.text[at..];
                let ends = |byte: u8| !(byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'+'));
                let end = rest.bytes().position(ends).unwrap_or(rest.len());
                self.at += end;
                number(&rest[..end]).map(Value::Number).ok_or(Broken(at))
            }
            _ => {
                let word = self.word();
                match word {
                    "True" => return Ok(Value::Bool(true)),
                    "False" => return Ok(Value::Bool(false)),
                    _ => {}
                }
                self.at = at;
                self.call_at(depth + 1).map(Value::Call)
            }
        }
    }

    fn string(&mut self) -> Result<String, Broken> {
        let at = self.at;
        self.at += 1;
        let mut text = String::new();
        let mut letters = self.text[self.at..].char_indices();
        while let Some((place, letter)) = letters.next() {
            match letter {
                '"' => {
                    self.at += place + 1;
                    return Ok(text);
                }
                '\\' => match letters.next().map(|(_, letter)| letter) {
                    Some(letter @ ('"' | '\\')) => text.push(letter),
                    Some('U') => {
                        let digits: String = letters.by_ref().take(8).map(|(_, letter)| letter).collect();
                        let code = (digits.len() == 8).then(|| u32::from_str_radix(&digits, 16).ok()).flatten();
                        text.push(code.and_then(char::from_u32).ok_or(Broken(at))?);
                    }
                    _ => return Err(Broken(at)),
                },
                '\n' => return Err(Broken(at)),
                other => text.push(other),
            }
        }
        Err(Broken(at))
    }

    /// Whether nothing but what `end` is stands before the end of the line, which is passed over.
    pub fn line_end(&mut self, end: &str) -> bool {
        let rest = self.text[self.at..].strip_prefix(end);
        let Some(rest) = rest else { return false };
        let ends = rest.is_empty() || rest.starts_with('\n');
        self.at = self.text.len() - rest.len() + usize::from(rest.starts_with('\n'));
        ends
    }

    /// The byte that is next.
    pub fn at(&self) -> usize {
        self.at
    }
}

/// The arguments of a call by the names of its function's parameters.
pub struct Arguments<'c, 't> {
    call: &'c Call<'t>,
    names: &'static [&'static str],
    used: Vec<Cell<bool>>,
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

impl<'c, 't> Arguments<'c, 't> {
    /// Of a call whose function has these parameters.
    pub fn new(call: &'c Call<'t>, names: &'static [&'static str]) -> Self {
        Self { call, names, used: vec![Cell::new(false); call.arguments.len()] }
    }

    /// Where the call is.
    pub fn at(&self) -> usize {
        self.call.at
    }

    /// A value, by its key or its place.
    pub fn get(&self, name: &str) -> Option<&'c Value<'t>> {
        let place = self.names.iter().position(|known| *known == name);
        let found = self.call.arguments.iter().enumerate().find(|(at, (key, _))| match key {
            Some(key) => *key == name,
            None => Some(*at) == place,
        });
        let (at, (_, value)) = found?;
        self.used[at].set(true);
        Some(value)
    }

    fn wrong(&self, name: &str, what: &str, to: &mut Said<'_, '_, '_>) {
        to.say(SYNTAX, self.at(), format!("`{name}` of `{}` is {what}", shown(self.call.name)));
    }

    /// A number.
    pub fn float(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<f64> {
        match self.get(name) {
            Some(Value::Number(value)) => Some(*value),
            Some(Value::Bool(_) | Value::Text(_) | Value::Tuple(_) | Value::Call(_)) | None => {
                self.wrong(name, "no number", to);
                None
            }
        }
    }

    /// A whole number, not negative.
    pub fn count(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<u32> {
        let value = self.float(name, to)?;
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Some(value as u32);
        }
        self.wrong(name, "no count", to);
        None
    }

    /// A string.
    pub fn text(&self, name: &str, to: &mut Said<'_, '_, '_>) -> &'c str {
        match self.get(name) {
            Some(Value::Text(value)) => value,
            Some(Value::Number(_) | Value::Bool(_) | Value::Tuple(_) | Value::Call(_)) | None => {
                self.wrong(name, "no string", to);
                ""
            }
        }
    }

    /// Three numbers.
    pub fn row(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Vec3> {
        let found = self.get(name).and_then(row::<3>);
        if found.is_none() {
            self.wrong(name, "not made of three numbers", to);
        }
        found
    }

    /// A color.
    pub fn rgb(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Rgb {
        self.row(name, to).unwrap_or([0.0; 3])
    }

    /// A transform of three rows, if there is one.
    pub fn matrix(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Affine {
        let Some(value) = self.get(name) else { return Affine::IDENTITY };
        let rows = if let Value::Tuple(rows) = value { rows.as_slice() } else { &[] };
        let found = match rows {
            [a, b, c] => row::<4>(a).zip(row::<4>(b)).zip(row::<4>(c)),
            _ => None,
        };
        match found {
            Some(((a, b), c)) => Affine { rows: [a, b, c] },
            None => {
                self.wrong(name, "no matrix of three rows", to);
                Affine::IDENTITY
            }
        }
    }

    /// Says what was not asked for.
    pub fn finish(&self, to: &mut Said<'_, '_, '_>) {
        for ((key, _), _) in self.call.arguments.iter().zip(&self.used).filter(|(_, used)| !used.get()) {
            let what =
                key.map_or("a value too many".to_owned(), |key| format!("an unknown parameter `{}`", shown(key)));
            to.say(UNKNOWN, self.at(), format!("`{}` has {what}", shown(self.call.name)));
        }
    }
}

/// As many numbers as `N` in round brackets.
pub fn row<const N: usize>(value: &Value<'_>) -> Option<[f64; N]> {
    let Value::Tuple(values) = value else { return None };
    let mut found = [0.0; N];
    if values.len() != N {
        return None;
    }
    for (found, value) in found.iter_mut().zip(values) {
        let Value::Number(number) = value else { return None };
        *found = *number;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_of_literals_are_read() {
        let text = "f(\"a\\\"\\U000000e9\", g(-1.5e3, k=(1, 2)), on=True)\n";
        let mut scanner = Scanner::new(text, 0);
        let call = scanner.call().expect("a call");
        assert!(scanner.line_end("") && scanner.at() == text.len());
        let arguments = Arguments::new(&call, &["name", "inner", "on"]);
        assert_eq!(arguments.get("name"), Some(&Value::Text("a\"\u{e9}".to_owned())));
        assert_eq!(arguments.get("on"), Some(&Value::Bool(true)));
        let Some(Value::Call(inner)) = arguments.get("inner") else { panic!("a call within") };
        assert_eq!(Arguments::new(inner, &["x"]).get("x"), Some(&Value::Number(-1500.0)));
        assert_eq!(Arguments::new(inner, &["x"]).get("k").and_then(row::<2>), Some([1.0, 2.0]));
    }

    #[test]
    fn everything_else_is_broken() {
        for text in
            ["f(", "f(1", "f(1 2)", "f(x)", "f(\"a)", "f(\"\\q\")", "f(\"\\Uffffffff\")", "1()", "", "f(nan)", "f(-)"]
        {
            assert!(Scanner::new(text, 0).call().is_err(), "{text}");
        }
        let deep = "f(".repeat(1000);
        assert!(Scanner::new(&deep, 0).call().is_err());
        let deep = format!("f({}", "(".repeat(100_000));
        assert!(Scanner::new(&deep, 0).call().is_err());
    }
}
