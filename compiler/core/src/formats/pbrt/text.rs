//! The text of PBRT files: words, and parameters that are asked for by type and name.

use std::borrow::Cow;
use std::cell::Cell;

use nom::branch::alt;
use nom::bytes::complete::{tag, take_till, take_while, take_while1};
use nom::character::complete::{char, one_of};
use nom::combinator::{map, recognize, value};
use nom::multi::many0_count;
use nom::sequence::preceded;
use nom::{IResult, Parser};

use crate::diag::nearest;
use crate::formats::shared::reading::Rgb;
use crate::formats::shared::source::{SYNTAX, Source, Text, UNKNOWN, number, shown};
use crate::ir::{Color, Meaning, Spectrum};

/// The most values that one parameter may have; meshes lie in files of their own.
const MOST_VALUES: usize = 1 << 24;

/// A word of the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Token<'t> {
    /// What stands between double quotes, escapes unread.
    Quoted(&'t str),
    /// `[`
    Open,
    /// `]`
    Close,
    /// A directive, a number, `true` or `false`.
    Word(&'t str),
}

fn blank(input: &str) -> IResult<&str, ()> {
    let space = take_while1(|letter: char| letter.is_ascii_whitespace());
    let comment = preceded(char('#'), take_till(|letter| letter == '\n'));
    value((), many0_count(alt((space, comment)))).parse(input)
}

fn quoted(input: &str) -> IResult<&str, &str> {
    let (mut rest, _) = char('"').parse(input)?;
    let inside = rest;
    loop {
        let (after, _) = take_while(|letter| letter != '"' && letter != '\\' && letter != '\n').parse(rest)?;
        let end = inside.len() - after.len();
        let closed: IResult<&str, &str> = tag("\"").parse(after);
        if let Ok((after, _)) = closed {
            return Ok((after, &inside[..end]));
        }
        let escaped: IResult<&str, &str> = recognize((char('\\'), one_of("\\\"nrtbf"))).parse(after);
        (rest, _) = escaped?;
    }
}

fn token(input: &str) -> IResult<&str, Token<'_>> {
    let ends = |letter: char| letter.is_ascii_whitespace() || matches!(letter, '"' | '[' | ']' | '#');
    alt((
        map(quoted, Token::Quoted),
        value(Token::Open, char('[')),
        value(Token::Close, char(']')),
        map(take_while1(move |letter| !ends(letter)), Token::Word),
    ))
    .parse(input)
}

/// The words of a text with the bytes at which they begin.
pub struct Tokens<'t> {
    text: &'t str,
    rest: &'t str,
    /// A word that was looked at.
    ahead: Option<(usize, Token<'t>)>,
}

/// The text cannot be cut into words at this byte.
#[derive(Debug, PartialEq)]
pub struct Broken(pub usize);

impl<'t> Tokens<'t> {
    /// Of a whole text.
    pub fn new(text: &'t str) -> Self {
        Self { text, rest: text, ahead: None }
    }

    /// The next word and where it begins; none at the end.
    pub fn next(&mut self) -> Result<Option<(usize, Token<'t>)>, Broken> {
        if let Some(ahead) = self.ahead.take() {
            return Ok(Some(ahead));
        }
        let rest = blank(self.rest).map_or(self.rest, |(rest, ())| rest);
        let at = self.text.len() - rest.len();
        if rest.is_empty() {
            self.rest = rest;
            return Ok(None);
        }
        match token(rest) {
            Ok((rest, token)) => {
                self.rest = rest;
                Ok(Some((at, token)))
            }
            Err(_) => Err(Broken(at)),
        }
    }

    /// The next word, which stays.
    pub fn peek(&mut self) -> Result<Option<Token<'t>>, Broken> {
        if self.ahead.is_none() {
            self.ahead = self.next()?;
        }
        Ok(self.ahead.map(|(_, token)| token))
    }
}

/// A string without its escapes.
pub fn unescaped(raw: &str) -> Cow<'_, str> {
    if !raw.contains('\\') {
        return Cow::Borrowed(raw);
    }
    let mut text = String::with_capacity(raw.len());
    let mut letters = raw.chars();
    while let Some(letter) = letters.next() {
        if letter != '\\' {
            text.push(letter);
            continue;
        }
        match letters.next() {
            Some('n') => text.push('\n'),
            Some('r') => text.push('\r'),
            Some('t') => text.push('\t'),
            Some('b') => text.push('\u{8}'),
            Some('f') => text.push('\u{c}'),
            Some(other) => text.push(other),
            None => {}
        }
    }
    Cow::Owned(text)
}

/// A parameter: `"float fov" [45]`.
#[derive(Debug)]
struct Param<'t> {
    at: usize,
    kind: &'t str,
    name: &'t str,
    values: Vec<Token<'t>>,
    used: Cell<bool>,
}

/// The parameters of one directive. What nobody asks for is a finding in the end.
#[derive(Debug)]
pub struct Params<'t> {
    /// Where the directive begins.
    pub at: usize,
    list: Vec<Param<'t>>,
}

impl<'t> Params<'t> {
    /// Reads parameters as long as strings follow.
    pub fn read(at: usize, tokens: &mut Tokens<'t>, source: &mut Source<'_>, text: Text<'_>) -> Result<Self, Broken> {
        let mut list: Vec<Param<'t>> = Vec::new();
        while let Some(Token::Quoted(head)) = tokens.peek()? {
            let (at, _) = tokens.next()?.unwrap_or((at, Token::Close));
            let mut words = head.split_ascii_whitespace();
            let (kind, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if name.is_empty() || words.next().is_some() {
                let message = format!("`{}` is no type with a name", shown(head));
                source.say(SYNTAX, text.origin(at), message);
            }
            let values = values(tokens)?;
            if list.iter().any(|known| known.name == name) {
                source.say(SYNTAX, text.origin(at), format!("the parameter `{}` stands twice", shown(name)));
            }
            list.push(Param { at, kind, name, values, used: Cell::new(false) });
        }
        Ok(Self { at, list })
    }

    fn find(&self, kinds: &[&str], name: &str) -> Option<&Param<'t>> {
        let found = self.list.iter().find(|param| param.name == name && kinds.contains(&param.kind))?;
        found.used.set(true);
        Some(found)
    }

    /// Whether there is a parameter of this name, of whatever type.
    pub fn has(&self, name: &str) -> bool {
        self.list.iter().any(|param| param.name == name)
    }

    /// The byte of a parameter, else of the directive.
    pub fn place(&self, name: &str) -> usize {
        self.list.iter().find(|param| param.name == name).map_or(self.at, |param| param.at)
    }

    /// Numbers, as many as `count` says.
    pub fn numbers(
        &self,
        kinds: &[&str],
        name: &str,
        count: Option<usize>,
        to: &mut Said<'_, '_, '_>,
    ) -> Option<Vec<f64>> {
        let param = self.find(kinds, name)?;
        let read = |token: &Token<'_>| if let Token::Word(word) = token { number(word) } else { None };
        let values: Option<Vec<f64>> = param.values.iter().map(read).collect();
        match values {
            Some(values) if count.is_none_or(|count| values.len() == count) => Some(values),
            Some(values) => {
                let message = format!("`{name}` has {} numbers, not {}", values.len(), count.unwrap_or_default());
                to.say(SYNTAX, param.at, message);
                None
            }
            None => {
                to.say(SYNTAX, param.at, format!("`{name}` is not made of finite numbers"));
                None
            }
        }
    }

    /// One number.
    pub fn float(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<f64> {
        self.numbers(&["float"], name, Some(1), to)?.first().copied()
    }

    /// One whole number, not negative.
    pub fn integer(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<u32> {
        let value = self.numbers(&["integer"], name, Some(1), to)?.first().copied()?;
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Some(value as u32);
        }
        to.say(SYNTAX, self.place(name), format!("`{name}` is no count"));
        None
    }

    /// Three coordinates.
    pub fn point(&self, kind: &str, name: &str, to: &mut Said<'_, '_, '_>) -> Option<[f64; 3]> {
        self.numbers(&[kind], name, Some(3), to)?.try_into().ok()
    }

    /// `true` or `false`, with or without quotes.
    pub fn bool(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<bool> {
        let param = self.find(&["bool"], name)?;
        if let [Token::Word(word) | Token::Quoted(word)] = param.values[..] {
            match word {
                "true" => return Some(true),
                "false" => return Some(false),
                _ => {}
            }
        }
        to.say(SYNTAX, param.at, format!("`{name}` is neither `true` nor `false`"));
        None
    }

    /// Strings.
    pub fn strings(&self, kind: &str, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Vec<Cow<'t, str>>> {
        let param = self.find(&[kind], name)?;
        let read = |token: &Token<'t>| if let Token::Quoted(raw) = token { Some(unescaped(raw)) } else { None };
        let strings: Option<Vec<_>> = param.values.iter().map(read).collect();
        if strings.is_none() {
            to.say(SYNTAX, param.at, format!("`{name}` is not made of strings"));
        }
        strings
    }

    /// One string.
    pub fn string(&self, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Cow<'t, str>> {
        self.one("string", name, to)
    }

    /// One string of a type of its own, as the name of a texture.
    pub fn one(&self, kind: &str, name: &str, to: &mut Said<'_, '_, '_>) -> Option<Cow<'t, str>> {
        let mut strings = self.strings(kind, name, to)?;
        if strings.len() == 1 {
            return strings.pop();
        }
        to.say(SYNTAX, self.place(name), format!("`{name}` is not one string"));
        None
    }

    /// A color: RGB, or a spectrum with what it means. The second part is the luminance of a spectrum.
    pub fn color(&self, name: &str, meaning: Meaning, to: &mut Said<'_, '_, '_>) -> Option<(Rgb, Option<f64>)> {
        if let Some(values) = self.numbers(&["rgb", "color"], name, Some(3), to) {
            return values.try_into().ok().map(|rgb| (rgb, None));
        }
        let values = self.numbers(&["spectrum"], name, None, to)?;
        let pairs: Vec<(f64, f64)> = values.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        let grow = pairs.windows(2).all(|two| two[0].0 < two[1].0);
        if pairs.is_empty() || values.len() % 2 != 0 || !grow {
            to.say(SYNTAX, self.place(name), format!("`{name}` is no list of growing wavelengths and values"));
            return None;
        }
        let spectrum = Spectrum::new(&pairs, meaning);
        let luminance = spectrum.luminance();
        Some((Color::Spectrum(spectrum).rgb(), Some(luminance)))
    }

    /// Says what was not asked for.
    pub fn finish(&self, what: &str, to: &mut Said<'_, '_, '_>) {
        for param in self.list.iter().filter(|param| !param.used.get()) {
            let message = format!("{what} has an unknown parameter `{} {}`", shown(param.kind), shown(param.name));
            to.say(UNKNOWN, param.at, message);
        }
    }
}

fn values<'t>(tokens: &mut Tokens<'t>) -> Result<Vec<Token<'t>>, Broken> {
    let Some((at, first)) = tokens.next()? else { return Ok(Vec::new()) };
    if first != Token::Open {
        return if first == Token::Close { Err(Broken(at)) } else { Ok(vec![first]) };
    }
    let mut values = Vec::new();
    loop {
        match tokens.next()? {
            Some((_, Token::Close)) => return Ok(values),
            Some((_, one @ (Token::Word(_) | Token::Quoted(_)))) if values.len() < MOST_VALUES => values.push(one),
            Some((at, Token::Open | Token::Word(_) | Token::Quoted(_))) => return Err(Broken(at)),
            None => return Err(Broken(at)),
        }
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

    /// Adds a finding about a word that is none of `known`.
    pub fn unknown(&mut self, at: usize, what: &str, word: &str, known: &[&str]) {
        let message = format!("there is no {what} `{}`", shown(word));
        let finding = crate::diag::Finding::error(UNKNOWN, self.text.origin(at), message);
        let help = nearest(word, known.iter().copied()).map(|near| format!("is `{near}` meant?"));
        self.source.add(finding.maybe_help(help));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Result<Vec<Token<'_>>, Broken> {
        let mut tokens = Tokens::new(text);
        let mut all = Vec::new();
        while let Some((_, token)) = tokens.next()? {
            all.push(token);
        }
        Ok(all)
    }

    #[test]
    fn text_is_cut_into_words() {
        use Token::{Close, Open, Quoted, Word};
        assert_eq!(
            words("# a \"b\"\nShape \"x\\\"y\"[1 -2.5]#c"),
            Ok(vec![Word("Shape"), Quoted("x\\\"y"), Open, Word("1"), Word("-2.5"), Close])
        );
        assert_eq!(unescaped("x\\\"\\n"), "x\"\n");
        assert_eq!(words("a \"b"), Err(Broken(2)));
        assert_eq!(words("\"a\\q\""), Err(Broken(0)));
        assert_eq!(words("\"a\nb\""), Err(Broken(0)));
        assert_eq!(words("#"), Ok(vec![]));
    }
}
