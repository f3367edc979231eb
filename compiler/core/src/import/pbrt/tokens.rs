//! The text of PBRT files, cut into words with nom. Numbers go into lists at once, without a word for each: a text may be one mesh of
//! millions of them.

use nom::branch::alt;
use nom::bytes::complete::{take_till, take_while, take_while1};
use nom::character::complete::char;
use nom::combinator::{map, value};
use nom::multi::many0_count;
use nom::sequence::preceded;
use nom::{IResult, Parser};

use crate::diag::{FileId, Span};

/// A word of the text.
#[derive(Clone, Debug, PartialEq)]
pub enum Token {
    /// What stands between double quotes, its escapes read.
    Quoted(String),
    /// `[`
    Open,
    /// `]`
    Close,
    /// A directive, `true`, or whatever else stands alone.
    Word(String),
    /// A finite number.
    Number(f64),
    /// A quote without an end, and other text that is no word.
    Broken,
}

type Input<'t> = &'t [u8];

fn is_blank(byte: u8) -> bool {
    // Arrays may have commas, which separate as blanks do.
    byte.is_ascii_whitespace() || byte == b',' || byte == 0x0b
}

fn ends(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b'"' | b'[' | b']' | b'#')
}

/// Blanks and comments.
fn blank(input: Input<'_>) -> IResult<Input<'_>, ()> {
    let comment = preceded(char('#'), take_till(|byte| byte == b'\n' || byte == b'\r'));
    value((), many0_count(alt((take_while1(is_blank), comment)))).parse(input)
}

fn word(input: Input<'_>) -> IResult<Input<'_>, Input<'_>> {
    take_while1(|byte| !ends(byte)).parse(input)
}

/// What stands between quotes; a line does not end in it.
fn quoted(input: Input<'_>) -> IResult<Input<'_>, String> {
    let (mut rest, _) = char('"').parse(input)?;
    let mut bytes = Vec::new();
    loop {
        let (after, plain) = take_while(|byte| !matches!(byte, b'"' | b'\\' | b'\n')).parse(rest)?;
        bytes.extend_from_slice(plain);
        match after {
            [b'"', after @ ..] => return Ok((after, String::from_utf8_lossy(&bytes).into_owned())),
            [b'\\', b'\n', after @ ..] => rest = after,
            [b'\\', escaped, after @ ..] => {
                bytes.push(match escaped {
                    b'n' => b'\n',
                    b'r' => b'\r',
                    b't' => b'\t',
                    b'b' => 8,
                    b'f' => 12,
                    other => *other,
                });
                rest = after;
            }
            _ => {
                let error = nom::error::Error::new(after, nom::error::ErrorKind::Char);
                return Err(nom::Err::Error(error));
            }
        }
    }
}

fn number_of(word: &[u8]) -> Option<f64> {
    // `parse` takes "inf" and "nan" too.
    if !matches!(word.first(), Some(b'0'..=b'9' | b'+' | b'-' | b'.')) {
        return None;
    }
    // Short whole numbers, as indices are, need no general reader.
    if word.len() <= 15 && word.iter().all(u8::is_ascii_digit) {
        let whole = word.iter().fold(0_u64, |whole, digit| whole * 10 + u64::from(digit - b'0'));
        return Some(whole as f64);
    }
    std::str::from_utf8(word).ok()?.parse::<f64>().ok().filter(|value| value.is_finite())
}

fn token(input: Input<'_>) -> IResult<Input<'_>, Token> {
    let plain = |word: Input<'_>| match number_of(word) {
        Some(number) => Token::Number(number),
        None => Token::Word(String::from_utf8_lossy(word).into_owned()),
    };
    alt((map(quoted, Token::Quoted), value(Token::Open, char('[')), value(Token::Close, char(']')), map(word, plain)))
        .parse(input)
}

/// The words of a text from a byte on.
#[derive(Clone)]
pub struct Tokens<'t> {
    text: &'t [u8],
    /// The next byte.
    pub at: usize,
    file: FileId,
}

impl<'t> Tokens<'t> {
    /// Of a text from a byte on.
    pub fn new(text: &'t str, at: usize, file: FileId) -> Self {
        Self { text: text.as_bytes(), at, file }
    }

    fn rest(&self) -> &'t [u8] {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn move_to(&mut self, rest: &[u8]) {
        self.at = self.text.len() - rest.len();
    }

    /// Passes over blanks and comments; the next byte, if there is one.
    pub fn peek(&mut self) -> Option<u8> {
        loop {
            let rest = self.rest();
            match rest.first() {
                Some(b' ') => self.at += 1,
                Some(byte) if is_blank(*byte) || *byte == b'#' => {
                    if let Ok((rest, ())) = blank(rest) {
                        self.move_to(rest);
                    }
                }
                other => return other.copied(),
            }
        }
    }

    /// The next word and its place; none at the end. What cannot be read is passed over up to the end of its line.
    pub fn next(&mut self) -> Option<(Token, Span)> {
        self.peek()?;
        let start = self.at;
        let token = match token(self.rest()) {
            Ok((rest, token)) => {
                self.move_to(rest);
                token
            }
            Err(_) => {
                let line = self.rest().iter().position(|byte| *byte == b'\n').unwrap_or(self.rest().len());
                self.at += line.max(1);
                Token::Broken
            }
        };
        Some((token, Span::new(self.file, start, self.at)))
    }

    /// The place of the next byte.
    pub fn here(&self) -> Span {
        Span::new(self.file, self.at, (self.at + 1).min(self.text.len()))
    }

    /// The place from a byte to the next one.
    pub fn since(&self, start: usize) -> Span {
        Span::new(self.file, start, self.at)
    }

    /// Adds the numbers that follow to a list.
    pub fn numbers(&mut self, to: &mut Vec<f64>) {
        while let Some(b'0'..=b'9' | b'+' | b'-' | b'.') = self.peek() {
            let Ok((rest, word)) = word(self.rest()) else { return };
            let Some(number) = number_of(word) else { return };
            to.push(number);
            self.move_to(rest);
        }
    }

    /// As many numbers as a directive has, in brackets or not.
    pub fn row<const N: usize>(&mut self) -> Option<[f64; N]> {
        let bracket = self.peek() == Some(b'[');
        if bracket {
            self.next();
        }
        let mut row = [0.0; N];
        for value in &mut row {
            let Some(b'0'..=b'9' | b'+' | b'-' | b'.') = self.peek() else { return None };
            let Token::Number(number) = self.next()?.0 else { return None };
            *value = number;
        }
        if bracket {
            if self.peek() != Some(b']') {
                return None;
            }
            self.next();
        }
        Some(row)
    }

    /// The string that follows, in brackets or not.
    pub fn string(&mut self) -> Option<String> {
        let bracket = self.peek() == Some(b'[');
        if bracket {
            self.next();
        }
        if self.peek() != Some(b'"') {
            return None;
        }
        let Some((Token::Quoted(text), _)) = self.next() else { return None };
        if bracket && self.peek() == Some(b']') {
            self.next();
        }
        Some(text)
    }

    /// Passes over what belongs to a directive that is not read: up to a word that can be one.
    pub fn skip(&mut self) {
        while let Some(byte) = self.peek() {
            if byte.is_ascii_uppercase() {
                return;
            }
            self.next();
        }
    }
}
