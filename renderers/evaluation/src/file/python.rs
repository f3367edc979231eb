//! Literals of Python, read without running anything: assignments of dictionaries, lists, strings, numbers and names.
//!
//! What is more than that (functions, loops, calls) is listed with its place, and the names that it may change are no longer known.

use std::collections::BTreeMap;

use ltsc_core::diag::{FileId, Span};

use super::model::At;

/// How deep brackets may be nested.
const DEEPEST: usize = 100;

/// The most values that names may stand for: lists of lists of lists multiply.
const MOST_VALUES: usize = 1_000_000;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Python {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(String),
    /// A list or a tuple.
    List(Vec<At<Python>>),
    Dict(Vec<(At<Python>, At<Python>)>),
}

impl Python {
    /// What it is, with its article.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::None => "`None`",
            Self::Bool(_) => "a boolean",
            Self::Int(_) => "an integer",
            Self::Float(_) => "a float",
            Self::Text(_) => "a string",
            Self::List(_) => "a list",
            Self::Dict(_) => "a dictionary",
        }
    }

    /// How many values it holds.
    fn size(&self) -> usize {
        match self {
            Self::List(values) => values.iter().map(|value| value.value.size()).sum::<usize>() + 1,
            Self::Dict(entries) => {
                entries.iter().map(|(key, value)| key.value.size() + value.value.size()).sum::<usize>() + 1
            }
            Self::None | Self::Bool(_) | Self::Int(_) | Self::Float(_) | Self::Text(_) => 1,
        }
    }
}

/// What a text says.
pub(super) struct Said {
    /// The value of each name, as it is at the end.
    pub names: BTreeMap<String, At<Python>>,
    /// What could not be read, and why.
    pub unread: Vec<(Span, String)>,
}

#[derive(Clone, Debug, PartialEq)]
enum Word {
    Name(String),
    Number(String),
    Text(String),
    /// A string that is no plain text, with the reason.
    Strange(&'static str),
    Sign(char),
}

#[derive(Clone, Debug)]
struct Token {
    word: Word,
    start: usize,
    end: usize,
}

/// A line in the sense of Python: brackets and `\` join lines of text.
struct Line {
    tokens: Vec<Token>,
    indented: bool,
}

/// Reads a text.
pub(super) fn read(file: FileId, text: &str) -> Said {
    let mut said = Said { names: BTreeMap::new(), unread: Vec::new() };
    let lines = lines(text);
    let mut at = 0;
    let mut size = 0;
    while let Some(line) = lines.get(at) {
        at += 1;
        let (Some(first), Some(last)) = (line.tokens.first(), line.tokens.last()) else { continue };
        let place = Span::new(file, first.start, first.end);
        // A block: everything that is indented below it.
        let mut end = at;
        while lines.get(end).is_some_and(|inner| inner.indented) {
            end += 1;
        }
        let opens = last.word == Word::Sign(':');
        if opens || end > at {
            let block = &lines[at - 1..end];
            at = end;
            said.unread.push((place, "a block of code is not run".to_owned()));
            for token in block.iter().flat_map(|line| &line.tokens) {
                if let Word::Name(name) = &token.word {
                    said.names.remove(name);
                }
            }
            // What goes on a level above belongs to it: `else`, or the function below a decorator.
            continue;
        }
        for statement in line.tokens.split(|token| token.word == Word::Sign(';')).filter(|tokens| !tokens.is_empty()) {
            let mut parser = Parser { file, tokens: statement, at: 0, depth: 0, names: &said.names };
            let place = Span::new(file, statement[0].start, statement[0].end);
            match parser.statement() {
                Ok(assigned) => {
                    for (name, value) in assigned {
                        size += value.value.size();
                        if size > MOST_VALUES {
                            said.unread.push((place, "it makes more than a million values".to_owned()));
                            said.names.remove(&name);
                            continue;
                        }
                        said.names.insert(name, value);
                    }
                }
                Err((span, why)) => {
                    // What it would have changed is not known any more.
                    if let Word::Name(name) = &statement[0].word {
                        said.names.remove(name);
                    }
                    let span = if span.start == span.end { place } else { span };
                    said.unread.push((span, why));
                }
            }
        }
    }
    said
}

fn lines(text: &str) -> Vec<Line> {
    let mut found = Vec::new();
    let mut tokens: Vec<Token> = Vec::new();
    let mut depth = 0_usize;
    let mut begins = true;
    let mut indented = false;
    let mut at = 0;
    while let Some(letter) = text[at..].chars().next() {
        let start = at;
        at += letter.len_utf8();
        match letter {
            '\n' | '\r' => {
                if depth == 0 {
                    if !tokens.is_empty() {
                        found.push(Line { tokens: std::mem::take(&mut tokens), indented });
                    }
                    begins = true;
                }
            }
            '#' => at = text[at..].find(['\n', '\r']).map_or(text.len(), |end| at + end),
            '\\' if text[at..].starts_with('\n') => at += 1,
            '\\' if text[at..].starts_with("\r\n") => at += 2,
            blank if blank.is_whitespace() || blank == '\u{feff}' => {}
            _ => {
                if begins {
                    let line = text[..start].rfind(['\n', '\r']).map_or(0, |end| end + 1);
                    indented = text[line..start].starts_with([' ', '\t']);
                    begins = false;
                }
                let word = if letter == '"' || letter == '\'' {
                    quoted(text, &mut at, letter, "")
                } else if letter.is_alphabetic() || letter == '_' {
                    let end = text[at..].find(|next: char| !(next.is_alphanumeric() || next == '_'));
                    at = end.map_or(text.len(), |end| at + end);
                    let name = &text[start..at];
                    let prefix = name.to_ascii_lowercase();
                    match text[at..].chars().next() {
                        Some(quote @ ('"' | '\''))
                            if ["r", "u", "b", "f", "br", "rb", "fr", "rf"].contains(&prefix.as_str()) =>
                        {
                            at += 1;
                            quoted(text, &mut at, quote, &prefix)
                        }
                        _ => Word::Name(name.to_owned()),
                    }
                } else if letter.is_ascii_digit()
                    || letter == '.' && text[at..].starts_with(|next: char| next.is_ascii_digit())
                {
                    number(text, start, &mut at)
                } else {
                    match letter {
                        '(' | '[' | '{' => depth += 1,
                        ')' | ']' | '}' => depth = depth.saturating_sub(1),
                        _ => {}
                    }
                    Word::Sign(letter)
                };
                tokens.push(Token { word, start, end: at });
            }
        }
    }
    if !tokens.is_empty() {
        found.push(Line { tokens, indented });
    }
    found
}

/// A number from its first letter on.
fn number(text: &str, start: usize, at: &mut usize) -> Word {
    let mut last = ' ';
    let based = text[start..].to_ascii_lowercase().starts_with(['0'])
        && text[*at..].starts_with(['x', 'X', 'o', 'O', 'b', 'B']);
    for (offset, letter) in text[start..].char_indices() {
        let signed = !based && matches!(letter, '+' | '-') && matches!(last, 'e' | 'E');
        if !(letter.is_ascii_alphanumeric() || letter == '_' || letter == '.' || signed) {
            break;
        }
        last = letter;
        *at = start + offset + letter.len_utf8();
    }
    Word::Number(text[start..*at].to_owned())
}

/// A string behind its first quote.
fn quoted(text: &str, at: &mut usize, quote: char, prefix: &str) -> Word {
    let triple: String = std::iter::repeat_n(quote, 3).collect();
    let mut end = quote.to_string();
    if text[*at..].starts_with(&triple[1..]) {
        *at += 2;
        end = triple;
    }
    let raw = prefix.contains('r');
    let mut content = String::new();
    let mut strange = None;
    if prefix.contains('f') {
        strange = Some("a formatted string is not evaluated");
    } else if prefix.contains('b') {
        strange = Some("bytes are no string");
    }
    loop {
        let rest = &text[*at..];
        if rest.starts_with(&end) {
            *at += end.len();
            break;
        }
        let Some(letter) = rest.chars().next().filter(|letter| end.len() == 3 || !matches!(letter, '\n' | '\r')) else {
            strange = Some("a string is not closed");
            break;
        };
        *at += letter.len_utf8();
        if letter != '\\' {
            content.push(letter);
            continue;
        }
        let Some(escaped) = text[*at..].chars().next() else { continue };
        *at += escaped.len_utf8();
        if raw {
            content.extend(['\\', escaped]);
            continue;
        }
        match escaped {
            '\n' => {}
            '\r' => {
                if text[*at..].starts_with('\n') {
                    *at += 1;
                }
            }
            '\\' | '\'' | '"' => content.push(escaped),
            'n' => content.push('\n'),
            't' => content.push('\t'),
            'r' => content.push('\r'),
            'a' => content.push('\u{7}'),
            'b' => content.push('\u{8}'),
            'f' => content.push('\u{c}'),
            'v' => content.push('\u{b}'),
            'x' | 'u' | 'U' => {
                let count = match escaped {
                    'x' => 2,
                    'u' => 4,
                    _ => 8,
                };
                let digits =
                    text.get(*at..*at + count).filter(|digits| digits.chars().all(|digit| digit.is_ascii_hexdigit()));
                match digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).and_then(char::from_u32) {
                    Some(letter) => {
                        content.push(letter);
                        *at += count;
                    }
                    None => strange = Some("a letter of a string is given by a number that stands for none"),
                }
            }
            'N' | '0'..='7' => strange = Some("a letter of a string is given by name or by an octal number"),
            // Python keeps what it does not know.
            other => content.extend(['\\', other]),
        }
    }
    strange.map_or(Word::Text(content), Word::Strange)
}

struct Parser<'t> {
    file: FileId,
    tokens: &'t [Token],
    at: usize,
    depth: usize,
    names: &'t BTreeMap<String, At<Python>>,
}

type Problem = (Span, String);

/// An entry of a dictionary.
type Entry = (At<Python>, At<Python>);

impl Parser<'_> {
    fn peek(&self) -> Option<&Word> {
        self.tokens.get(self.at).map(|token| &token.word)
    }

    /// The place of the next token, or of the last one.
    fn place(&self) -> Span {
        let token = self.tokens.get(self.at).or(self.tokens.last());
        token.map_or(Span::new(self.file, 0, 0), |token| Span::new(self.file, token.start, token.end))
    }

    fn from(&self, start: usize) -> Span {
        let end = self.tokens[start..self.at.max(start + 1).min(self.tokens.len())].last();
        let start = self.tokens[start].start;
        Span::new(self.file, start, end.map_or(start, |token| token.end))
    }

    fn sign(&mut self, sign: char) -> bool {
        let there = self.peek() == Some(&Word::Sign(sign));
        self.at += usize::from(there);
        there
    }

    /// Assignments, a text that stands alone, or `pass`.
    fn statement(&mut self) -> Result<Vec<(String, At<Python>)>, Problem> {
        let assigns = self.tokens.get(1).is_some_and(|token| token.word == Word::Sign('='))
            && self.tokens.get(2).is_none_or(|token| token.word != Word::Sign('='));
        let adds = self.tokens.get(1).is_some_and(|token| token.word == Word::Sign('+'))
            && self.tokens.get(2).is_some_and(|token| token.word == Word::Sign('='));
        match self.peek() {
            // The documentation of the file.
            Some(Word::Text(_)) if self.tokens.iter().all(|token| matches!(token.word, Word::Text(_))) => {
                Ok(Vec::new())
            }
            Some(Word::Name(name)) if name == "pass" && self.tokens.len() == 1 => Ok(Vec::new()),
            Some(Word::Name(name)) if adds => {
                let name = name.clone();
                let known =
                    self.names.get(&name).cloned().ok_or_else(|| (self.place(), format!("`{name}` is not known")))?;
                self.at = 3;
                let value = self.value()?;
                self.end()?;
                let sum = self.sum(known, value)?;
                Ok(vec![(name, sum)])
            }
            Some(Word::Name(_)) if assigns => {
                let mut names = Vec::new();
                while let (Some(Word::Name(name)), Some(Word::Sign('='))) =
                    (self.peek(), self.tokens.get(self.at + 1).map(|token| &token.word))
                {
                    names.push(name.clone());
                    self.at += 2;
                }
                let value = self.value()?;
                self.end()?;
                Ok(names.into_iter().map(|name| (name, value.clone())).collect())
            }
            Some(Word::Name(word)) if word == "import" || word == "from" => {
                Err((self.place(), "nothing is imported".to_owned()))
            }
            _ => Err((self.place(), "it is no assignment of a value to a name".to_owned())),
        }
    }

    fn end(&self) -> Result<(), Problem> {
        match self.tokens.get(self.at) {
            None => Ok(()),
            Some(_) => Err((self.place(), "what follows the value is not read".to_owned())),
        }
    }

    /// Values joined by `+`.
    fn value(&mut self) -> Result<At<Python>, Problem> {
        let mut sum = self.single()?;
        while self.sign('+') {
            let next = self.single()?;
            sum = self.sum(sum, next)?;
        }
        Ok(sum)
    }

    fn sum(&self, a: At<Python>, b: At<Python>) -> Result<At<Python>, Problem> {
        let span = a.span.to(b.span);
        let value = match (a.value, b.value) {
            (Python::List(mut a), Python::List(b)) => {
                if a.len() + b.len() > MOST_VALUES {
                    return Err((span, "it makes more than a million values".to_owned()));
                }
                a.extend(b);
                Python::List(a)
            }
            (Python::Text(a), Python::Text(b)) if a.len() + b.len() <= MOST_VALUES => Python::Text(a + &b),
            _ => return Err((span, "only lists and strings are joined".to_owned())),
        };
        Ok(At::new(value, span))
    }

    fn single(&mut self) -> Result<At<Python>, Problem> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err((self.place(), "brackets are nested too deeply".to_owned()));
        }
        let start = self.at;
        let here = self.place();
        let Some(word) = self.peek().cloned() else {
            return Err((here, "a value is missing".to_owned()));
        };
        self.at += 1;
        let value = match word {
            Word::Text(mut text) => {
                // Strings that stand side by side are one.
                while let Some(next) = self.peek() {
                    match next {
                        Word::Text(more) => text.push_str(more),
                        Word::Strange(why) => return Err((self.place(), (*why).to_owned())),
                        Word::Name(_) | Word::Number(_) | Word::Sign(_) => break,
                    }
                    self.at += 1;
                }
                Python::Text(text)
            }
            Word::Strange(why) => return Err((here, why.to_owned())),
            Word::Number(text) => {
                number_value(&text).ok_or_else(|| (here, format!("`{text}` is no number that is read")))?
            }
            Word::Name(name) => match name.as_str() {
                "None" => Python::None,
                "True" => Python::Bool(true),
                "False" => Python::Bool(false),
                _ => match self.names.get(&name) {
                    Some(known) => known.value.clone(),
                    None => return Err((here, format!("`{name}` is not known"))),
                },
            },
            Word::Sign('-') => match self.single()?.value {
                Python::Int(value) if value != i64::MIN => Python::Int(-value),
                Python::Float(value) => Python::Float(-value),
                _ => return Err((here, "`-` stands before a number only".to_owned())),
            },
            Word::Sign('[') => Python::List(self.elements(']')?),
            Word::Sign('(') => self.bracket()?,
            Word::Sign('{') => Python::Dict(self.entries()?),
            Word::Sign(sign) => return Err((here, format!("`{sign}` begins no value"))),
        };
        self.depth -= 1;
        // A value that goes on is something else: a call, an element, a member.
        if let Some(Word::Sign(sign @ ('(' | '[' | '.'))) = self.peek() {
            let what = match sign {
                '(' => "a call is not run",
                '[' => "elements are not looked up",
                _ => "members are not looked up",
            };
            return Err((self.from(start), what.to_owned()));
        }
        Ok(At::new(value, self.from(start)))
    }

    /// The elements of a list up to its bracket.
    fn elements(&mut self, close: char) -> Result<Vec<At<Python>>, Problem> {
        let mut found = Vec::new();
        loop {
            if self.sign(close) {
                return Ok(found);
            }
            found.push(self.value()?);
            if !self.sign(',') && self.peek() != Some(&Word::Sign(close)) {
                return Err((self.place(), format!("`,` or `{close}` is missing, or it is no literal")));
            }
        }
    }

    /// A tuple, or a value in brackets.
    fn bracket(&mut self) -> Result<Python, Problem> {
        if self.sign(')') {
            return Ok(Python::List(Vec::new()));
        }
        let first = self.value()?;
        if self.sign(')') {
            return Ok(first.value);
        }
        if !self.sign(',') {
            return Err((self.place(), "`,` or `)` is missing, or it is no literal".to_owned()));
        }
        let mut found = vec![first];
        found.extend(self.elements(')')?);
        Ok(Python::List(found))
    }

    /// The entries of a dictionary; the last value of a key counts, in the place of the first.
    fn entries(&mut self) -> Result<Vec<Entry>, Problem> {
        let mut found: Vec<Entry> = Vec::new();
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        loop {
            if self.sign('}') {
                return Ok(found);
            }
            let key = self.value()?;
            if !self.sign(':') {
                return Err((self.place(), "`:` is missing, or it is no literal".to_owned()));
            }
            let value = self.value()?;
            match places.get(&format!("{:?}", key.value)) {
                Some(at) => found[*at].1 = value,
                None => {
                    places.insert(format!("{:?}", key.value), found.len());
                    found.push((key, value));
                }
            }
            if !self.sign(',') && self.peek() != Some(&Word::Sign('}')) {
                return Err((self.place(), "`,` or `}` is missing, or it is no literal".to_owned()));
            }
        }
    }
}

/// An integer in any base, or a float.
fn number_value(text: &str) -> Option<Python> {
    let lower = text.to_ascii_lowercase();
    if lower.starts_with('_') || lower.ends_with('_') || lower.contains("__") {
        return None;
    }
    let digits = lower.replace('_', "");
    for (prefix, radix) in [("0x", 16), ("0o", 8), ("0b", 2)] {
        if let Some(digits) = digits.strip_prefix(prefix) {
            return i64::from_str_radix(digits, radix).ok().map(Python::Int);
        }
    }
    if digits.chars().all(|digit| digit.is_ascii_digit()) {
        return digits.parse().ok().map(Python::Int);
    }
    if !digits.starts_with(|first: char| first.is_ascii_digit() || first == '.') {
        return None;
    }
    digits.parse().ok().filter(|value: &f64| value.is_finite()).map(Python::Float)
}
