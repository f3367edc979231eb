//! Expressions to documents.

use super::Reader;
use super::doc::Doc;
use super::lex::{Comment, Token};

/// Operators by how loosely they bind, loosest first.
const LEVELS: [&[&str]; 7] =
    [&["|>"], &[".."], &["or"], &["and"], &["==", "!=", "<", "<=", ">", ">="], &["+", "-"], &["*", "/"]];

/// An expression, and whether it is one bracket (perhaps behind a name), which may break without a line end before it.
pub(super) struct Made<'t> {
    pub doc: Doc<'t>,
    pub bracket: bool,
}

/// Operands and the operators between them: `operators[i]` stands before `operands[i + 1]`.
pub(super) struct Chain<'t> {
    pub operands: Vec<Made<'t>>,
    operators: Vec<Token<'t>>,
}

/// How the inside of a bracket breaks.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Inside {
    /// An item on each line, a comma behind the last.
    Items,
    /// One expression in brackets: no comma.
    Single,
    /// As many on a line as fit, a comma behind the last.
    Filled,
}

impl<'t> Reader<'t> {
    /// A whole expression.
    pub fn expr(&mut self) -> Made<'t> {
        let chain = self.chain();
        chain.made()
    }

    /// The operands and operators of an expression.
    pub fn chain(&mut self) -> Chain<'t> {
        let mut chain = Chain { operands: vec![self.operand()], operators: Vec::new() };
        while LEVELS.iter().any(|level| level.contains(&self.text())) {
            let operator = self.take();
            chain.operators.push(operator);
            chain.operands.push(self.operand());
        }
        chain
    }

    fn operand(&mut self) -> Made<'t> {
        match self.text() {
            "-" => {
                let sign = self.token();
                let of = self.operand();
                Made { doc: Doc::concat(vec![sign, of.doc]), bracket: false }
            }
            "not" => {
                let word = self.token();
                let of = self.operand();
                Made { doc: Doc::concat(vec![word, Doc::text(" "), of.doc]), bracket: false }
            }
            _ => {
                let mut made = self.primary();
                loop {
                    match self.text() {
                        "[" => {
                            let index = self.bracket(Inside::Single, |reader| reader.expr().doc);
                            made = Made { doc: Doc::concat(vec![made.doc, index]), bracket: false };
                        }
                        "." => {
                            let (dot, member) = (self.token(), self.token());
                            made = Made { doc: Doc::concat(vec![made.doc, dot, member]), bracket: false };
                        }
                        _ => return made,
                    }
                }
            }
        }
    }

    fn primary(&mut self) -> Made<'t> {
        match self.text() {
            "if" => Made { doc: self.choice(), bracket: false },
            "(" => Made { doc: self.paren(), bracket: true },
            "[" if self.text_at(1) == "for" => Made { doc: self.comprehension(), bracket: true },
            "[" => Made { doc: self.list(), bracket: true },
            _ => {
                let called = self.text_at(1) == "(" && self.is_name();
                let first = self.token();
                if !called {
                    return Made { doc: first, bracket: false };
                }
                let args = self.bracket(Inside::Items, |reader| {
                    if reader.text_at(1) == ":" && reader.text() != "(" {
                        let (label, colon) = (reader.token(), reader.token());
                        return Doc::concat(vec![label, colon, Doc::text(" "), reader.expr().doc]);
                    }
                    reader.expr().doc
                });
                Made { doc: Doc::concat(vec![first, args]), bracket: true }
            }
        }
    }

    /// `if c then a else b`
    fn choice(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token(), Doc::text(" "), self.expr().doc];
        for _ in ["then", "else"] {
            let word = self.token();
            parts.push(Doc::concat(vec![Doc::line(), word, Doc::text(" "), self.expr().doc]).indent());
        }
        Doc::concat(parts).group()
    }

    /// `(a)` for order, or a tuple.
    fn paren(&mut self) -> Doc<'t> {
        let inside = if self.commas() == 0 { Inside::Single } else { Inside::Items };
        self.bracket(inside, |reader| reader.expr().doc)
    }

    fn list(&mut self) -> Doc<'t> {
        let inside = if self.is_plain() { Inside::Filled } else { Inside::Items };
        self.bracket(inside, |reader| reader.expr().doc)
    }

    /// `[for p in list: expr]`
    fn comprehension(&mut self) -> Doc<'t> {
        self.bracket(Inside::Single, |reader| {
            let head = reader.clauses();
            let colon = reader.token();
            let body = reader.expr().doc;
            Doc::concat(vec![head, colon, Doc::line(), body])
        })
    }

    /// `for a in x, b in y`
    pub fn clauses(&mut self) -> Doc<'t> {
        let mut parts = vec![self.token(), Doc::text(" ")];
        loop {
            parts.push(if self.text() == "(" {
                self.bracket(Inside::Items, |reader| reader.token())
            } else {
                self.token()
            });
            parts.extend([Doc::text(" "), self.token(), Doc::text(" "), self.expr().doc]);
            if self.text() != "," {
                return Doc::concat(parts).group();
            }
            parts.extend([self.token(), Doc::line()]);
        }
    }

    /// A bracket with its items, which `item` reads one by one.
    pub fn bracket(&mut self, inside: Inside, mut item: impl FnMut(&mut Self) -> Doc<'t>) -> Doc<'t> {
        let open = self.token();
        let mut items: Vec<Doc<'t>> = Vec::new();
        let mut trailing = false;
        while !matches!(self.text(), ")" | "]" | "}" | "") {
            let start = self.at;
            // Comments above an item are no reason for the item itself to break.
            let above = self.tokens.get_mut(self.at).map(|first| std::mem::take(&mut first.before));
            let above = own_lines(&above.unwrap_or_default());
            let made = Doc::concat(vec![above, item(self)]);
            if self.text() == "," {
                let comma = self.take();
                trailing = matches!(self.text(), ")" | "]" | "}");
                let comma = if trailing {
                    // The layout prints it.
                    Doc::concat(vec![Doc::if_broken(","), comments(comma.after)])
                } else {
                    written(comma)
                };
                items.push(Doc::concat(vec![made, comma]));
            } else {
                let comma = if inside == Inside::Single { Doc::text("") } else { Doc::if_broken(",") };
                let behind = self.tokens.get_mut(self.at).map(|close| std::mem::take(&mut close.inside));
                items.push(Doc::concat(vec![made, comma, comments(behind.unwrap_or_default())]));
            }
            // A broken text must not keep the reader here for ever.
            if self.at == start {
                break;
            }
        }
        let close = self.take();
        let before = own_lines(&close.before);
        let close = Token { before: Vec::new(), ..close };
        if items.is_empty() {
            let inner = Doc::concat(vec![Doc::soft(), before]).indent();
            return Doc::concat(vec![open, inner, Doc::soft(), written(close)]).group();
        }
        let inside =
            if items.iter().any(|item| item.breaks()) && inside == Inside::Filled { Inside::Items } else { inside };
        let body = match inside {
            Inside::Filled => Doc::fill(items),
            Inside::Items | Inside::Single => {
                let mut parts = Vec::with_capacity(2 * items.len());
                for item in items {
                    if !parts.is_empty() {
                        parts.push(Doc::line());
                    }
                    parts.push(item);
                }
                Doc::concat(parts)
            }
        };
        let end = if trailing { Doc::hard() } else { Doc::soft() };
        Doc::concat(vec![open, Doc::concat(vec![Doc::soft(), body, before]).indent(), end, written(close)]).group()
    }
}

impl<'t> Chain<'t> {
    /// The parts of a chain of `|>`: what it begins with, and each further part with its operator.
    pub fn stages(self) -> (Made<'t>, Vec<Doc<'t>>) {
        let mut parts = self.split(0).into_iter();
        let first = parts.next().map_or_else(|| Made { doc: Doc::text(""), bracket: false }, |(_, first)| first.made());
        let stages = parts.map(|(sign, stage)| {
            let sign = sign.map_or_else(|| Doc::text(""), written);
            Doc::concat(vec![sign, Doc::text(" "), stage.made().doc])
        });
        (first, stages.collect())
    }

    /// Breaks before the loosest operators, all or none.
    fn made(mut self) -> Made<'t> {
        let present = |level: &&[&str]| self.operators.iter().any(|operator| level.contains(&operator.text));
        let Some(level) = LEVELS.iter().position(present) else {
            return self.operands.pop().unwrap_or(Made { doc: Doc::text(""), bracket: false });
        };
        let mut parts = Vec::new();
        for (at, (sign, operand)) in self.split(level).into_iter().enumerate() {
            let operand = operand.made().doc;
            let part = match sign {
                None => operand,
                Some(sign) if sign.text == ".." => Doc::concat(vec![written(sign), operand]),
                Some(sign) => Doc::concat(vec![Doc::line(), written(sign), Doc::text(" "), operand]),
            };
            parts.push(if at == 0 { part } else { part.indent() });
        }
        Made { doc: Doc::concat(parts).group(), bracket: false }
    }

    /// Cuts the chain at the operators of a level.
    fn split(self, level: usize) -> Vec<(Option<Token<'t>>, Chain<'t>)> {
        let mut operands = self.operands.into_iter();
        let first = operands.next().into_iter().collect();
        let mut parts = vec![(None, Chain { operands: first, operators: Vec::new() })];
        for (operator, operand) in self.operators.into_iter().zip(operands) {
            if LEVELS[level].contains(&operator.text) {
                parts.push((Some(operator), Chain { operands: vec![operand], operators: Vec::new() }));
            } else if let Some((_, last)) = parts.last_mut() {
                last.operators.push(operator);
                last.operands.push(operand);
            }
        }
        parts
    }
}

/// A token with its comments.
pub(super) fn written(token: Token<'_>) -> Doc<'_> {
    let Token { text, before, after, inside, blank: _ } = token;
    if before.is_empty() && after.is_empty() && inside.is_empty() {
        return Doc::text(text);
    }
    Doc::concat(vec![comments(inside), own_lines(&before), Doc::text(text), comments(after)])
}

/// Comments behind a token: the first on its line.
fn comments(after: Vec<Comment<'_>>) -> Doc<'_> {
    Doc::concat(after.into_iter().enumerate().map(|(at, comment)| Doc::note(comment.text, at > 0)).collect())
}

/// Comments on lines of their own.
pub(super) fn own_lines<'t>(before: &[Comment<'t>]) -> Doc<'t> {
    let mut parts = Vec::new();
    for comment in before {
        parts.extend([Doc::hard(), Doc::text(comment.text), Doc::hard()]);
    }
    Doc::concat(parts)
}
