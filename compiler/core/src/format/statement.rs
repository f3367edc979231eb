//! Statements to documents.

use super::Reader;
use super::doc::{Doc, Printer};
use super::expr::{Inside, own_lines, written};
use super::lex::Token;

impl<'t> Reader<'t> {
    /// The whole file, printed statement by statement.
    pub fn file(&mut self, printer: &mut Printer) {
        while !self.text().is_empty() {
            let statement = self.parted_statement();
            printer.print(&statement);
            printer.print(&Doc::hard());
        }
        let end = self.take();
        printer.print(&lines(&end));
    }

    /// A statement with its comments, behind an empty line where the author left one.
    fn parted_statement(&mut self) -> Doc<'t> {
        let Some(first) = self.tokens.get_mut(self.at) else { return Doc::text("") };
        let comments = Token { before: std::mem::take(&mut first.before), ..Token::bare("") };
        let blank = if first.blank { Doc::blank() } else { Doc::hard() };
        let start = self.at;
        let above = lines(&comments);
        let statement = self.statement();
        if self.at == start {
            // A broken text must not keep the reader here for ever.
            self.at += 1;
        }
        Doc::concat(vec![above, blank, statement])
    }

    fn statement(&mut self) -> Doc<'t> {
        match self.text() {
            "lts" | "allow" => self.words(),
            "scene" => self.header(),
            "use" => self.use_names(),
            "param" => self.parameter(),
            "for" => {
                let head = self.clauses();
                let body = self.block();
                Doc::concat(vec![head, Doc::text(" "), body])
            }
            "if" => self.condition(),
            "group" if self.is_block() => {
                let head = self.head();
                let body = self.block();
                Doc::concat(vec![head, Doc::text(" "), body])
            }
            _ => self.declaration(),
        }
    }

    /// `lts 1`, `allow id "reason"`
    fn words(&mut self) -> Doc<'t> {
        let count = if self.text() == "lts" { 2 } else { 3 };
        let mut parts = vec![self.token()];
        for _ in 1..count {
            parts.extend([Doc::text(" "), self.token()]);
        }
        Doc::concat(parts)
    }

    /// `scene name { field: value ... }`, a field on each line.
    fn header(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token(), Doc::text(" "), self.token(), Doc::text(" ")];
        parts.push(self.braced(|reader| {
            let (label, colon) = (reader.token(), reader.token());
            let value = reader.expr().doc;
            // The line end parts fields; a comma there means nothing.
            let comma = if reader.text() == "," { written(Token { text: "", ..reader.take() }) } else { Doc::text("") };
            Doc::concat(vec![label, colon, Doc::text(" "), value, comma])
        }));
        Doc::concat(parts)
    }

    /// `use a, b as c from "path"`
    fn use_names(&mut self) -> Doc<'t> {
        let word = self.token();
        let mut parts = Vec::new();
        loop {
            parts.push(self.token());
            if self.text() == "as" {
                parts.extend([Doc::text(" "), self.token(), Doc::text(" "), self.token()]);
            }
            if self.text() != "," {
                break;
            }
            let comma = self.take();
            if self.text() == "from" {
                parts.push(written(Token { text: "", ..comma }));
                break;
            }
            parts.extend([written(comma), Doc::line()]);
        }
        parts.extend([Doc::line(), self.token(), Doc::text(" "), self.token()]);
        Doc::concat(vec![word, Doc::text(" "), Doc::concat(parts).indent()]).group()
    }

    /// `param name: type = default in range`
    fn parameter(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token(), Doc::text(" "), self.typed()];
        let assign = self.token();
        let value = self.expr().doc;
        parts.extend([Doc::text(" "), assign, Doc::concat(vec![Doc::line(), value]).indent()]);
        if self.text() == "in" {
            let word = self.token();
            let range = self.expr().doc;
            parts.push(Doc::concat(vec![Doc::line(), word, Doc::text(" "), range]).indent());
        }
        Doc::concat(parts).group()
    }

    /// `name: type`
    fn typed(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token(), self.token(), Doc::text(" ")];
        while self.text() == "[" {
            parts.push(self.token());
        }
        parts.push(self.token());
        while self.text() == "]" {
            parts.push(self.token());
        }
        Doc::concat(parts)
    }

    fn condition(&mut self) -> Doc<'t> {
        let (word, condition) = (self.token(), self.expr().doc);
        let mut parts = vec![word, Doc::text(" "), condition.group(), Doc::text(" "), self.block()];
        while self.text() == "else" {
            parts.extend([Doc::text(" "), self.token(), Doc::text(" ")]);
            if self.text() == "if" {
                let (word, condition) = (self.token(), self.expr().doc);
                parts.extend([word, Doc::text(" "), condition.group(), Doc::text(" ")]);
            }
            parts.push(self.block());
        }
        Doc::concat(parts)
    }

    /// `{ statements }`
    fn block(&mut self) -> Doc<'t> {
        self.braced(Self::parted_statement)
    }

    /// Braces with something on each line.
    fn braced(&mut self, mut item: impl FnMut(&mut Self) -> Doc<'t>) -> Doc<'t> {
        let mut open = self.take();
        // The first line needs no empty one above.
        let behind = std::mem::take(&mut open.after);
        let noted = !behind.is_empty();
        let mut inner = vec![written(Token { after: behind, ..Token::bare("") }), Doc::hard()];
        if let Some(first) = self.tokens.get_mut(self.at) {
            first.blank &= !first.before.is_empty();
            if let Some(comment) = first.before.first_mut() {
                comment.blank = false;
            }
        }
        let mut empty = true;
        while !matches!(self.text(), "}" | "") {
            let start = self.at;
            inner.extend([item(self), Doc::hard()]);
            empty = false;
            if self.at == start {
                break;
            }
        }
        let close = self.take();
        let comments = Token { before: close.before, ..Token::bare("") };
        let close = Token { after: close.after, ..Token::bare(close.text) };
        if empty && !noted && comments.before.is_empty() {
            return Doc::concat(vec![written(open), written(close)]);
        }
        inner.push(lines(&comments));
        Doc::concat(vec![written(open), Doc::concat(inner).indent(), Doc::hard(), written(close)])
    }

    /// Whether the group that starts here has braces.
    fn is_block(&self) -> bool {
        let rest = &self.tokens[self.at..];
        rest.iter().find(|token| matches!(token.text, "{" | "=" | "")).is_some_and(|token| token.text == "{")
            || rest.get(2).is_some_and(|token| token.text == "(") && self.opens_behind_parameters()
    }

    /// Whether `{` follows the parameters of the group that starts here; their defaults hold `=`.
    fn opens_behind_parameters(&self) -> bool {
        let mut depth = 0_usize;
        for token in &self.tokens[self.at + 2..] {
            match token.text {
                "(" | "[" | "{" if depth > 0 || token.text == "(" => depth += 1,
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                text if depth == 0 => return text == "{",
                _ => {}
            }
        }
        false
    }

    /// `kind name(params)`
    fn head(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token()];
        if self.text() != "=" && self.text() != "(" {
            parts.extend([Doc::text(" "), self.token()]);
        }
        if self.text() == "(" {
            parts.push(self.bracket(Inside::Items, |reader| {
                let typed = reader.typed();
                if reader.text() != "=" {
                    return typed;
                }
                let assign = reader.token();
                Doc::concat(vec![typed, Doc::text(" "), assign, Doc::text(" "), reader.expr().doc])
            }));
        }
        Doc::concat(parts)
    }

    /// `kind name(params) = value |> stages with surface`
    fn declaration(&mut self) -> Doc<'t> {
        let head = self.head();
        let assign = self.take();
        let noted = !assign.after.is_empty() || self.tokens.get(self.at).is_some_and(|token| !token.before.is_empty());
        let assign = written(assign);
        let (first, mut further) = self.chain().stages();
        if self.text() == "with" {
            let word = self.token();
            let surface = self.expr().doc;
            further.push(Doc::concat(vec![word, Doc::text(" "), surface]));
        }
        let head = Doc::concat(vec![head, Doc::text(" "), assign]);
        if further.is_empty() && first.bracket && !noted {
            return Doc::concat(vec![head, first.doc.assigned()]);
        }
        let mut parts = vec![Doc::line(), first.doc];
        for part in further {
            parts.extend([Doc::line(), part]);
        }
        Doc::concat(vec![head, Doc::concat(parts).indent()]).group()
    }
}

/// The comments before a token on lines of their own, with empty lines where the author left them.
fn lines<'t>(token: &Token<'t>) -> Doc<'t> {
    let mut parts = Vec::new();
    for comment in &token.before {
        parts
            .extend([if comment.blank { Doc::blank() } else { Doc::hard() }, own_lines(std::slice::from_ref(comment))]);
    }
    Doc::concat(parts)
}
