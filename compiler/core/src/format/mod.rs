//! The formatter: one canonical form of a text, which keeps every comment and never changes what the text means.
//!
//! [`lex`] cuts the text into tokens with their comments, `statement` and `expr` lay them out as documents, one function for
//! each construct, and [`doc`] prints those. The rules:
//!
//! - 4 blanks a level, 120 columns, at most one empty line in a row, no alignment; numbers and strings stay as written.
//! - A blank on both sides of operators except `..`.
//! - A bracket stays on one line if that fits and the author wrote no comma behind its last item; else every item has a line
//!   and a comma. Lists of numbers and of plain vectors are filled.
//! - A declaration that is too long puts each `|>` and `with` on a line; a lone bracket goes to the next line if it fits there.
//! - Comments stay before or behind what they stood before or behind, and end their line.

mod doc;
mod expr;
mod lex;
mod statement;

use crate::diag::{FileId, Finding, Severity, Sources, Span};
use crate::syntax;

use doc::{Doc, Printer};
use lex::Token;

/// Why a text has not been formatted.
#[derive(Debug)]
pub enum FormatError {
    /// It has errors, which are listed.
    Malformed(Vec<Finding>),
    /// The formatter would have changed what the text says: a fault of ours. The text stays as it is.
    Fault(String),
}

/// The canonical form of `text`. Findings are about the file that is added to `sources` as `path`.
///
/// # Errors
/// Errors of syntax; a fault of the formatter, which reads its own result to find out.
pub fn format(sources: &mut Sources, path: &str, text: &str) -> Result<String, FormatError> {
    let file = sources.add(path, text);
    let (_, findings) = syntax::parse(file, text);
    if findings.iter().any(|finding| finding.severity >= Severity::Error) {
        return Err(FormatError::Malformed(findings));
    }
    let made = layout(text);
    match difference(file, text, &made) {
        None => Ok(made),
        Some(difference) => Err(FormatError::Fault(difference)),
    }
}

/// That the text of `file` has not its canonical form, which is `made`; the place is the first line that differs.
pub fn unformatted(file: FileId, text: &str, made: &str) -> Finding {
    let mut start = 0;
    for (line, other) in text.split_inclusive('\n').zip(made.split_inclusive('\n')) {
        if line != other {
            break;
        }
        start += line.len();
    }
    let line = text[start..].lines().next().unwrap_or_default();
    Finding::new("unformatted", Severity::Deny, Span::new(file, start, start + line.len()), "the file is not formatted")
        .label("the first line that differs")
        .help("`ltsc fmt` writes it")
}

fn layout(text: &str) -> String {
    let mut reader = Reader { tokens: settled(lex::tokens(text)), at: 0 };
    let mut printer = Printer::default();
    reader.file(&mut printer);
    printer.finish()
}

/// Comments around a comma move behind it: they are about what stands before. So do those behind the last item of a bracket,
/// which may get a comma.
fn settled(mut tokens: Vec<Token<'_>>) -> Vec<Token<'_>> {
    for at in 1..tokens.len() {
        if tokens[at].text == "," {
            let mut comments = std::mem::take(&mut tokens[at - 1].after);
            comments.append(&mut tokens[at].before);
            comments.append(&mut tokens[at].after);
            tokens[at].after = comments;
        } else if matches!(tokens[at].text, ")" | "]") && !matches!(tokens[at - 1].text, "(" | "[" | ",") {
            tokens[at].inside = std::mem::take(&mut tokens[at - 1].after);
        }
    }
    tokens
}

/// Reads tokens and makes documents of them.
struct Reader<'t> {
    tokens: Vec<Token<'t>>,
    at: usize,
}

impl<'t> Reader<'t> {
    /// The text of the token that is read next; empty at the end.
    fn text(&self) -> &'t str {
        self.text_at(0)
    }

    fn text_at(&self, further: usize) -> &'t str {
        self.tokens.get(self.at + further).map_or("", |token| token.text)
    }

    fn take(&mut self) -> Token<'t> {
        let Some(token) = self.tokens.get_mut(self.at) else { return Token::bare("") };
        self.at += 1;
        // Its text stays: what lies behind it looks back.
        let bare = Token::bare(token.text);
        std::mem::replace(token, bare)
    }

    /// The next token as a document.
    fn token(&mut self) -> Doc<'t> {
        expr::written(self.take())
    }

    /// Whether the next token is a name and no word of the language.
    fn is_name(&self) -> bool {
        let text = self.text();
        text.starts_with('`')
            || text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && !syntax::RESERVED.contains(&text)
    }

    /// How many commas stand directly within the bracket that opens here.
    fn commas(&self) -> usize {
        self.within().filter(|(depth, text)| *depth == 1 && *text == ",").count()
    }

    /// Whether the bracket that opens here holds only numbers and vectors of numbers, and no comment.
    fn is_plain(&self) -> bool {
        let number =
            |text: &str| text.starts_with(|c: char| c.is_ascii_digit()) || matches!(text, "-" | "," | "(" | ")");
        let mut count = 0;
        for (depth, text) in self.within() {
            let token = &self.tokens[self.at + count];
            count += 1;
            if count > 1 && (depth > 2 || !number(text)) || !token.before.is_empty() || !token.after.is_empty() {
                return false;
            }
        }
        // Only the closing bracket itself may have comments behind it.
        let close = self.tokens.get(self.at + count);
        close.is_none_or(|close| close.before.is_empty())
    }

    /// The tokens of the bracket that opens here, without the closing one, with the depth that each leads to.
    fn within(&self) -> impl Iterator<Item = (usize, &'t str)> {
        let mut depth = 0_usize;
        self.tokens[self.at..].iter().map_while(move |token| {
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            (depth > 0).then_some((depth, token.text))
        })
    }
}

/// What the formatted text says otherwise than the original, if anything: its tokens but for commas before a closing
/// bracket, its comments, or that it does not parse.
fn difference(file: crate::diag::FileId, before: &str, after: &str) -> Option<String> {
    let (_, findings) = syntax::parse(file, after);
    if let Some(finding) = findings.iter().find(|finding| finding.severity >= Severity::Error) {
        return Some(format!("the result does not parse: {}", finding.message));
    }
    let (before, after) = (lex::tokens(before), lex::tokens(after));
    let (one, other) = (significant(&before), significant(&after));
    if let Some(at) = (0..one.len().max(other.len())).find(|at| one.get(*at) != other.get(*at)) {
        let show = |tokens: &[&str]| tokens.get(at).map_or("the end".to_owned(), |token| format!("`{token}`"));
        return Some(format!("{} became {}", show(&one), show(&other)));
    }
    let (one, other) = (comments(&before), comments(&after));
    let at = (0..one.len().max(other.len())).find(|at| one.get(*at) != other.get(*at))?;
    let show = |comments: &[&str]| comments.get(at).map_or("nothing".to_owned(), |comment| format!("`{comment}`"));
    Some(format!("the comment {} became {}", show(&one), show(&other)))
}

fn comments<'t>(tokens: &[Token<'t>]) -> Vec<&'t str> {
    let all = tokens.iter().flat_map(|token| token.before.iter().chain(&token.after));
    all.map(|comment| comment.text).collect()
}

/// The tokens that mean something: commas before a closing bracket or `from`, and those between fields, mean nothing.
fn significant<'t>(tokens: &[Token<'t>]) -> Vec<&'t str> {
    let mut kept = Vec::with_capacity(tokens.len());
    // Of each open bracket, whether it is that of `scene name {`.
    let mut open = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        match token.text {
            "(" | "[" | "{" => open.push(at >= 2 && tokens[at - 2].text == "scene"),
            ")" | "]" | "}" => drop(open.pop()),
            _ => {}
        }
        let next = tokens.get(at + 1).map_or("", |next| next.text);
        if token.text == "," && (matches!(next, ")" | "]" | "}" | "from") || open.last() == Some(&true)) {
            continue;
        }
        kept.push(token.text);
    }
    kept
}

#[cfg(test)]
mod tests;
