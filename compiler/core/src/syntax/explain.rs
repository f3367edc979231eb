//! What the grammar refused, in words: the commonest mistakes by hand, the rest from what pest expected.

use std::ops::Range;

use pest::Parser;
use pest::error::InputLocation;

use crate::diag::{FileId, Finding, Span, nearest};

use super::build::clip;
use super::mistakes;
use super::parse::{Grammar, Rule};
use super::{RESERVED, STARTERS};

/// The finding for the junk at `range` of `text`.
pub(super) fn explain(file: FileId, text: &str, range: Range<usize>) -> Finding {
    let junk = &text[range.clone()];
    let at = |offset: usize, length: usize| {
        let start = (range.start + offset).min(text.len());
        Span::new(file, start, (start + length).min(text.len()))
    };
    if let Some(finding) = whole(junk, &at) {
        return finding;
    }
    let (offset, expected) = refusal(junk);
    let rest = &junk[offset..];
    if let Some(finding) = mistakes::find(junk, offset, &at) {
        return finding;
    }
    if let Some(open) = unclosed(junk) {
        let what = &junk[open..=open];
        let close = match what {
            "(" => ")",
            "[" => "]",
            _ => "}",
        };
        let stop = Span::new(file, range.end.saturating_sub(1), range.end);
        let place = if offset > open { at(offset.min(junk.trim_end().len()), 1) } else { stop };
        return Finding::error("syntax-error", at(open, 1), format!("this `{what}` is not closed"))
            .label("opened here")
            .also(place, format!("a `{close}` is missing at or before this place"));
    }
    if let Some(finding) = local(junk, offset, rest, &at) {
        return finding;
    }
    let found = token(rest);
    let length = found.len().max(1);
    let message = if found.is_empty() {
        "the statement is not complete".to_owned()
    } else {
        format!("`{}` does not fit here", clip(found))
    };
    let finding = Finding::error("syntax-error", at(offset.min(junk.trim_end().len()), length), message);
    if expected.is_empty() { finding } else { finding.label(format!("expected {expected}")) }
}

/// Mistakes that are seen from the start of the junk.
fn whole(junk: &str, at: &dyn Fn(usize, usize) -> Span) -> Option<Finding> {
    if junk.starts_with("///") {
        return Some(
            Finding::error(
                "syntax-error",
                at(0, junk.lines().next().unwrap_or_default().trim_end().len()),
                "this documents nothing",
            )
            .label("no statement behind it")
            .help("write `//` for a comment, or the statement that it belongs to"),
        );
    }
    let first = token(junk);
    if junk.starts_with("/*") || find_outside(junk, "/*").is_some() {
        let offset = find_outside(junk, "/*").unwrap_or(0);
        return Some(
            Finding::error("syntax-error", at(offset, 2), "there are no block comments")
                .help("write `//` before each line"),
        );
    }
    if let Some(open) = open_string(junk) {
        return Some(
            Finding::error("syntax-error", at(open, 1), "the string is not closed on its line")
                .label("opened here")
                .help("write a closing `\"`; a line break in a string is `\\n`"),
        );
    }
    let is_word = first.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if is_word && !STARTERS.contains(&first) {
        let similar = mistakes::statement_word(first).or_else(|| nearest(first, STARTERS.iter().copied()));
        let after = junk[first.len()..].trim_start();
        if after.starts_with('=') && !after.starts_with("==") {
            let finding = Finding::error(
                "syntax-error",
                at(0, first.len()),
                format!("no statement starts with `{}`", clip(first)),
            );
            return Some(finding.label("a name without its kind").help(format!("write `let {} = ...`", clip(first))));
        }
        let help = similar.map_or_else(
            || {
                "a statement starts with its kind, for example `let name = ...` or `shape name = ... with ...`"
                    .to_owned()
            },
            |word| format!("did you mean `{word}`?"),
        );
        return Some(
            Finding::error("syntax-error", at(0, first.len()), format!("no statement starts with `{}`", clip(first)))
                .label("unknown kind of statement")
                .help(help),
        );
    }
    None
}

/// Mistakes that are seen at the place that the grammar refused, or just before it.
fn local(junk: &str, offset: usize, rest: &str, at: &dyn Fn(usize, usize) -> Span) -> Option<Finding> {
    let before = junk[..offset].trim_end();
    let word = token(rest);
    let error =
        |start: usize, length: usize, message: String| Finding::error("syntax-error", at(start, length), message);
    if RESERVED.contains(&word) {
        let names = before.is_empty() || STARTERS.contains(&last_word(before)) || before.ends_with(['(', ',', '.']);
        if names || before.ends_with('=') || ends_with_operator(before) {
            return Some(
                error(offset, word.len(), format!("`{word}` is a reserved word"))
                    .label("cannot be a name")
                    .help(format!("choose another name, or write it in backticks: `` `{word}` ``")),
            );
        }
    }
    let last = last_word(before);
    if RESERVED.contains(&last)
        && (rest.starts_with(['=', ',', '{', '(']) && !RESERVED.contains(&word))
        && last != "camera"
    {
        let head = before[..before.len() - last.len()].trim_end();
        if STARTERS.contains(&last_word(head)) {
            return Some(
                error(before.len() - last.len(), last.len(), format!("`{last}` is a reserved word"))
                    .label("cannot be a name")
                    .help(format!("choose another name, or write it in backticks: `` `{last}` ``")),
            );
        }
    }
    let adjacent = rest.starts_with('=') && junk[..offset].ends_with('=');
    if rest.starts_with("==") || adjacent {
        let start = if adjacent { offset - 1 } else { offset };
        return Some(error(start, 2, "`==` compares two values".to_owned()).help("a declaration has one `=`"));
    }
    if rest.starts_with(';') {
        return Some(error(offset, 1, "statements end without `;`".to_owned()).help("remove it"));
    }
    if rest.starts_with('.') && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
        return Some(
            error(offset, 1, "a number needs a digit before the point".to_owned())
                .help(format!("write `0{}`", clip(number(rest)))),
        );
    }
    if rest.starts_with('.') && before.ends_with(|c: char| c.is_ascii_digit()) {
        return Some(
            error(offset, 1, "a number needs a digit behind the point".to_owned()).help("write for example `1.0`"),
        );
    }
    if rest.starts_with('^') || rest.starts_with("**") {
        let sign = if rest.starts_with('^') { "^" } else { "**" };
        return Some(
            error(offset, sign.len(), format!("there is no operator `{sign}`")).help("write `pow(a, b)`, or `a * a`"),
        );
    }
    if rest.starts_with('%') {
        return Some(error(offset, 1, "there is no operator `%`".to_owned()).help("write `mod(a, b)`"));
    }
    if rest.starts_with("&&") || rest.starts_with("||") {
        let sign = &rest[..2];
        let word = if sign == "&&" { "and" } else { "or" };
        return Some(error(offset, 2, format!("there is no operator `{sign}`")).help(format!("write `{word}`")));
    }
    if rest.starts_with('!') {
        return Some(error(offset, 1, "there is no operator `!`".to_owned()).help("write `not`"));
    }
    if rest.starts_with('\'') {
        return Some(error(offset, 1, "strings stand in double quotes".to_owned()).help("write `\"...\"`"));
    }
    if rest.starts_with("///") {
        return Some(
            error(offset, 3, "a `///` comment documents the statement behind it".to_owned())
                .help("write `//` here, or move it before the statement"),
        );
    }
    let after_number = before.ends_with(|c: char| c.is_ascii_digit());
    if after_number && matches!(word, "deg" | "rad") {
        return Some(
            error(offset, word.len(), "the unit must touch the number".to_owned())
                .help(format!("write `{}{word}`", last_number(before))),
        );
    }
    let starts_value =
        rest.starts_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | '(' | '[' | '`' | '-'));
    let ends_value = before.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | ')' | ']' | '`'));
    if starts_value && ends_value && inside_brackets(before) {
        return Some(
            error(offset, word.len().max(1), "a comma is missing".to_owned())
                .label("before this")
                .help("write `,` between values"),
        );
    }
    None
}

/// Where the strict grammar stops, and what it expected there.
fn refusal(junk: &str) -> (usize, String) {
    // The flag belongs to the whole process; it only makes pest remember what it tried.
    pest::set_error_detail(true);
    let parsed = Grammar::parse(Rule::lone, junk);
    pest::set_error_detail(false);
    let Err(error) = parsed else {
        return (0, String::new());
    };
    let (InputLocation::Pos(offset) | InputLocation::Span((offset, _))) = error.location;
    let mut offset = offset.min(junk.len());
    let mut expected = String::new();
    if let Some(attempts) = error.parse_attempts() {
        offset = offset.max(attempts.max_position).min(junk.len());
        expected = words(attempts.expected_tokens().iter().map(ToString::to_string));
    }
    while !junk.is_char_boundary(offset) {
        offset -= 1;
    }
    // The grammar stops before the blanks that it would have skipped.
    let blanks = junk[offset..].len() - junk[offset..].trim_start().len();
    (offset + blanks, expected)
}

/// What was expected, in few words. Pest keeps its type of a token to itself, so this reads their texts.
fn words(tokens: impl Iterator<Item = String>) -> String {
    let mut out: Vec<String> = Vec::new();
    let mut put = |word: &str| {
        if !out.iter().any(|known| known == word) {
            out.push(word.to_owned());
        }
    };
    for token in tokens {
        match token.as_str() {
            "+" | "*" | "/" | "|>" | ".." | "==" | "!=" | "<" | "<=" | ">" | ">=" | "and" | "or" => {
                put("an operator");
            }
            "_" | "`" | "\"" | "true" | "false" | "(" | "[" | "not" | "if" | "a..z" | "A..Z" | "0..9" => put("a value"),
            "-" | " " | "\t" | "\r" | "\n" | "\u{FEFF}" | "//" | "///" | "." | "e" | "E" | "\\" | "BUILTIN_RULE" => {}
            other => put(&format!("`{other}`")),
        }
    }
    match out.len() {
        0 => String::new(),
        1 => out.remove(0),
        2..=6 => {
            let last = out.pop().unwrap_or_default();
            format!("{} or {last}", out.join(", "))
        }
        _ => String::new(),
    }
}

/// The word, number or sign at the start of a text.
pub(super) fn token(text: &str) -> &str {
    let word = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    if word > 0 {
        return &text[..word];
    }
    text.chars().next().filter(|c| !c.is_whitespace()).map_or("", |c| &text[..c.len_utf8()])
}

fn number(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '.')).unwrap_or(text.len());
    &text[..end]
}

pub(super) fn last_word(text: &str) -> &str {
    let start = text
        .rfind(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .map_or(0, |found| found + text[found..].chars().next().map_or(1, char::len_utf8));
    &text[start..]
}

fn last_number(text: &str) -> &str {
    let start = text
        .rfind(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '_')))
        .map_or(0, |found| found + text[found..].chars().next().map_or(1, char::len_utf8));
    &text[start..]
}

pub(super) fn ends_with_operator(text: &str) -> bool {
    text.ends_with(['+', '*', '/', '<', '>', ':']) || text.ends_with("..")
}

pub(super) fn inside_brackets(text: &str) -> bool {
    unclosed(text).is_some()
}

/// The outermost bracket that is opened and not closed, outside strings and comments.
fn unclosed(text: &str) -> Option<usize> {
    open_brackets(text).first().copied()
}

/// The innermost one.
pub(super) fn innermost(text: &str) -> Option<usize> {
    open_brackets(text).last().copied()
}

/// All brackets that are opened and not closed, outermost first.
fn open_brackets(text: &str) -> Vec<usize> {
    let mut open: Vec<usize> = Vec::new();
    walk(text, |at, byte| {
        match byte {
            b'(' | b'[' | b'{' => open.push(at),
            b')' | b']' | b'}' => {
                let _closed = open.pop();
            }
            _ => {}
        }
        true
    });
    open
}

/// The first place of `needle` outside strings and comments.
fn find_outside(text: &str, needle: &str) -> Option<usize> {
    let mut found = None;
    walk(text, |at, _| {
        if text.as_bytes()[at..].starts_with(needle.as_bytes()) {
            found = Some(at);
        }
        found.is_none()
    });
    found
}

/// The quote of a string that is not closed on its line.
fn open_string(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut found = None;
    walk(text, |at, byte| {
        if byte == b'"' && found.is_none() {
            let mut end = at + 1;
            while end < bytes.len() && !matches!(bytes[end], b'"' | b'\n') {
                end += if bytes[end] == b'\\' { 2 } else { 1 };
            }
            if bytes.get(end) != Some(&b'"') {
                found = Some(at);
            }
        }
        found.is_none()
    });
    found
}

/// Calls `visit` for each byte outside strings and comments (a string shows its opening quote only), until it says no.
fn walk(text: &str, mut visit: impl FnMut(usize, u8) -> bool) {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        if bytes[at..].starts_with(b"//") {
            at += bytes[at..].iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len() - at);
            continue;
        }
        if !visit(at, bytes[at]) {
            return;
        }
        if bytes[at] == b'"' {
            at += 1;
            while at < bytes.len() && !matches!(bytes[at], b'"' | b'\n') {
                at += if bytes[at] == b'\\' { 2 } else { 1 };
            }
        }
        at += 1;
    }
}
