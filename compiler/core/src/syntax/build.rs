//! Pairs of the grammar to the tree. Pest stays inside this folder.

#![expect(clippy::wildcard_enum_match_arm, reason = "the enum of rules is made by pest and also lists every token")]

use std::ops::Range;

use pest::iterators::{Pair, Pairs};

use crate::diag::{FileId, Finding, Span};

use super::parse::Rule;
use super::tree::{
    Arg, Binary, Call, Clause, Expr, ExprKind, Field, Kind, Name, Param, Statement, StatementKind, Type, Unary,
};
use super::{NAME_LIMIT, NESTING_LIMIT};

/// Builds the statements of one piece of a file.
pub(super) struct Builder<'t> {
    file: FileId,
    offset: usize,
    text: &'t str,
    junk: Vec<Range<usize>>,
    findings: Vec<Finding>,
    depth: usize,
}

/// The statement has been reported and is left out.
struct Broken;

type Built<T> = Result<T, Broken>;

impl<'t> Builder<'t> {
    /// A builder for the piece of `text` that starts at `offset`.
    pub(super) fn new(file: FileId, offset: usize, text: &'t str) -> Self {
        Self { file, offset, text, junk: Vec::new(), findings: Vec::new(), depth: 0 }
    }

    /// What the grammar refused, as ranges of the whole text, and findings about the rest.
    pub(super) fn finish(self) -> (Vec<Range<usize>>, Vec<Finding>) {
        (self.junk, self.findings)
    }

    /// The statements of a whole piece.
    pub(super) fn file(&mut self, pairs: Pairs<'t, Rule>) -> Vec<Statement> {
        let mut statements = Vec::new();
        for file in pairs {
            self.items(file.into_inner(), &mut statements);
        }
        statements
    }

    fn items(&mut self, pairs: Pairs<'t, Rule>, statements: &mut Vec<Statement>) {
        let mut pairs = pairs.peekable();
        while let Some(pair) = pairs.next() {
            match pair.as_rule() {
                Rule::item => {
                    // Lines of documentation before a broken statement are no mistakes of their own.
                    let more = pairs.peek().is_some_and(|next| next.as_rule() == Rule::item);
                    for inner in pair.into_inner() {
                        if inner.as_rule() == Rule::junk {
                            if !more || !is_documentation(inner.as_str()) {
                                self.junk.push(self.range(&inner));
                            }
                        } else if let Ok(statement) = self.statement(inner) {
                            statements.push(statement);
                        }
                    }
                }
                Rule::stray => {
                    let span = self.span(&pair);
                    self.findings.push(
                        Finding::error("syntax-error", span, "this `}` closes nothing")
                            .label("no open `{`")
                            .help("remove it, or look for a statement above whose `{` is missing"),
                    );
                }
                _ => {}
            }
        }
    }

    fn range(&self, pair: &Pair<'t, Rule>) -> Range<usize> {
        let span = pair.as_span();
        span.start() + self.offset..span.end() + self.offset
    }

    /// The place of a pair without blanks and comments behind it.
    fn span(&self, pair: &Pair<'t, Rule>) -> Span {
        let range = self.range(pair);
        let trimmed = self.text[range.clone()].trim_end().len();
        Span::new(self.file, range.start, range.start + trimmed)
    }

    fn refuse<T>(&mut self, finding: Finding) -> Built<T> {
        self.findings.push(finding);
        Err(Broken)
    }

    fn deeper(&mut self, span: Span) -> Built<()> {
        self.depth += 1;
        if self.depth <= NESTING_LIMIT * 2 {
            return Ok(());
        }
        self.depth = 0;
        self.refuse(
            Finding::error("nesting-limit", span, "the expression is nested too deeply")
                .note(format!("at most {} levels of operators, conditions and signs are read", NESTING_LIMIT * 2))
                .help("give the inner parts names with `let`"),
        )
    }

    fn statement(&mut self, pair: Pair<'t, Rule>) -> Built<Statement> {
        self.depth = 0;
        let mut doc = String::new();
        for inner in pair.into_inner() {
            if inner.as_rule() == Rule::docs {
                doc = doc_text(inner);
                continue;
            }
            let mut span = self.span(&inner);
            let kind = match inner.as_rule() {
                Rule::version => StatementKind::Version(self.only_expr(inner)?),
                Rule::scene => self.scene(inner)?,
                Rule::use_names => self.use_names(inner)?,
                Rule::parameter => self.parameter(inner)?,
                Rule::for_loop => self.for_loop(inner)?,
                Rule::condition => self.condition(inner)?,
                Rule::allow => self.allow(inner)?,
                Rule::group => self.group(inner)?,
                _ => self.declaration(inner)?,
            };
            if let StatementKind::Declaration { value, with, .. } = &kind {
                // Rules that end in `?` reach over the blanks and comments behind them.
                span.end = with.as_ref().unwrap_or(value).span.end;
            }
            return Ok(Statement { span, doc, kind });
        }
        Err(Broken)
    }

    fn only_expr(&mut self, pair: Pair<'t, Rule>) -> Built<Expr> {
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::expr => return self.expr(inner),
                Rule::number => return self.primary(inner),
                _ => {}
            }
        }
        Err(Broken)
    }

    fn scene(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let mut name = None;
        let mut fields = Vec::new();
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::name => name = Some(self.name(inner)?),
                Rule::field => {
                    let label = self.label(&inner);
                    fields.push(Field { name: label, value: self.only_expr(inner)? });
                }
                _ => {}
            }
        }
        Ok(StatementKind::Scene { name: name.ok_or(Broken)?, fields })
    }

    fn label(&self, pair: &Pair<'t, Rule>) -> Name {
        let found = pair.clone().into_inner().find(|inner| inner.as_rule() == Rule::label);
        let pair = found.as_ref().unwrap_or(pair);
        Name { text: pair.as_str().to_owned(), span: self.span(pair) }
    }

    fn use_names(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let mut names = Vec::new();
        let mut path = None;
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::used => {
                    let mut both = Vec::new();
                    for name in inner.into_inner().filter(|part| part.as_rule() == Rule::name) {
                        both.push(self.name(name)?);
                    }
                    let mut both = both.into_iter();
                    names.push((both.next().ok_or(Broken)?, both.next()));
                }
                Rule::string => path = Some(self.string(&inner)?),
                _ => {}
            }
        }
        Ok(StatementKind::Use { names, path: path.ok_or(Broken)? })
    }

    fn parameter(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let (mut name, mut ty, mut default, mut range) = (None, None, None, None);
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::name => name = Some(self.name(inner)?),
                Rule::type_name => ty = Some(self.type_name(&inner)),
                Rule::expr if default.is_none() => default = Some(self.expr(inner)?),
                Rule::expr => range = Some(self.expr(inner)?),
                _ => {}
            }
        }
        Ok(StatementKind::Parameter {
            name: name.ok_or(Broken)?,
            ty: ty.ok_or(Broken)?,
            default: default.ok_or(Broken)?,
            range,
        })
    }

    fn type_name(&self, pair: &Pair<'t, Rule>) -> Type {
        let text = pair.as_str();
        let word = text.trim_matches(|c: char| matches!(c, '[' | ']') || c.is_whitespace());
        let lists = text.bytes().filter(|byte| *byte == b'[').count();
        Type { name: Name { text: word.to_owned(), span: self.span(pair) }, lists }
    }

    fn for_loop(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let mut clauses = Vec::new();
        let mut body = Vec::new();
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::clause => clauses.push(self.clause(inner)?),
                Rule::body => body = self.body(inner),
                _ => {}
            }
        }
        Ok(StatementKind::For { clauses, body })
    }

    fn body(&mut self, pair: Pair<'t, Rule>) -> Vec<Statement> {
        let mut statements = Vec::new();
        self.items(pair.into_inner(), &mut statements);
        statements
    }

    fn clause(&mut self, pair: Pair<'t, Rule>) -> Built<Clause> {
        let (mut names, mut over, mut tuple) = (Vec::new(), None, false);
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::pattern => {
                    tuple = inner.as_str().starts_with('(');
                    for name in inner.into_inner() {
                        names.push(self.name(name)?);
                    }
                }
                Rule::expr => over = Some(self.expr(inner)?),
                _ => {}
            }
        }
        Ok(Clause { names, tuple, over: over.ok_or(Broken)? })
    }

    fn condition(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let mut branches = Vec::new();
        let mut otherwise = Vec::new();
        let mut next = Some(pair);
        while let Some(pair) = next.take() {
            let mut when = None;
            for inner in pair.into_inner() {
                match inner.as_rule() {
                    Rule::expr => when = Some(self.expr(inner)?),
                    Rule::body => match when.take() {
                        Some(condition) => branches.push((condition, self.body(inner))),
                        None => otherwise = self.body(inner),
                    },
                    Rule::condition => next = Some(inner),
                    _ => {}
                }
            }
        }
        Ok(StatementKind::If { branches, otherwise })
    }

    fn allow(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let (mut id, mut reason) = (None, None);
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::finding_id => id = Some(Name { text: inner.as_str().to_owned(), span: self.span(&inner) }),
                Rule::string => reason = Some(self.string(&inner)?),
                _ => {}
            }
        }
        Ok(StatementKind::Allow { id: id.ok_or(Broken)?, reason: reason.ok_or(Broken)? })
    }

    fn group(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let (mut name, mut params, mut body) = (None, Vec::new(), Vec::new());
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::name => name = Some(self.name(inner)?),
                Rule::params => params = self.params(inner)?,
                Rule::body => body = self.body(inner),
                _ => {}
            }
        }
        Ok(StatementKind::Group { name: name.ok_or(Broken)?, params, body })
    }

    fn params(&mut self, pair: Pair<'t, Rule>) -> Built<Vec<Param>> {
        let mut params = Vec::new();
        for param in pair.into_inner() {
            let (mut name, mut ty, mut default) = (None, None, None);
            for inner in param.into_inner() {
                match inner.as_rule() {
                    Rule::name => name = Some(self.name(inner)?),
                    Rule::type_name => ty = Some(self.type_name(&inner)),
                    Rule::expr => default = Some(self.expr(inner)?),
                    _ => {}
                }
            }
            params.push(Param { name: name.ok_or(Broken)?, ty: ty.ok_or(Broken)?, default });
        }
        Ok(params)
    }

    fn declaration(&mut self, pair: Pair<'t, Rule>) -> Built<StatementKind> {
        let (mut kind, mut name, mut params, mut value, mut with) = (Kind::Let, None, None, None, None);
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::kind => kind = kind_of(inner.as_str()),
                Rule::name => name = Some(self.name(inner)?),
                Rule::params => params = Some(self.params(inner)?),
                Rule::expr => value = Some(self.expr(inner)?),
                Rule::with_part => with = Some(self.only_expr(inner)?),
                _ => {}
            }
        }
        Ok(StatementKind::Declaration { kind, name, params, value: value.ok_or(Broken)?, with })
    }

    fn name(&mut self, pair: Pair<'t, Rule>) -> Built<Name> {
        let span = self.span(&pair);
        let text = pair.as_str().trim_matches('`').to_owned();
        if text.len() > NAME_LIMIT {
            return self.refuse(
                Finding::error("name-limit", span, format!("a name has more than {NAME_LIMIT} bytes"))
                    .label("this one"),
            );
        }
        if let Some(bad) = text.chars().find(|c| c.is_control()) {
            let message = format!("a name contains the control character U+{:04X}", u32::from(bad));
            return self.refuse(Finding::error("syntax-error", span, message));
        }
        Ok(Name { text, span })
    }

    fn string(&mut self, pair: &Pair<'t, Rule>) -> Built<Name> {
        let span = self.span(pair);
        let raw = pair.as_str();
        let inner = raw.get(1..raw.len().saturating_sub(1)).unwrap_or("");
        let mut text = String::with_capacity(inner.len());
        let mut rest = inner.chars();
        while let Some(c) = rest.next() {
            if c != '\\' {
                text.push(c);
                continue;
            }
            let escaped = match rest.next() {
                Some('n') => Some('\n'),
                Some(quoted @ ('"' | '\\')) => Some(quoted),
                Some('u') => {
                    let code: String = rest.by_ref().skip_while(|c| *c == '{').take_while(|c| *c != '}').collect();
                    u32::from_str_radix(&code, 16).ok().and_then(char::from_u32)
                }
                _ => None,
            };
            match escaped {
                Some(c) => text.push(c),
                None => {
                    return self.refuse(
                        Finding::error("syntax-error", span, "a string contains an unknown escape")
                            .help("known: `\\\"`, `\\\\`, `\\n` and `\\u{e9}`; write paths with `/`"),
                    );
                }
            }
        }
        Ok(Name { text, span })
    }

    fn expr(&mut self, pair: Pair<'t, Rule>) -> Built<Expr> {
        let span = self.span(&pair);
        self.deeper(span)?;
        let mut tokens = pair.into_inner().filter(|inner| !matches!(inner.as_rule(), Rule::EOI)).peekable();
        let built = self.climb(&mut tokens, 0)?;
        self.depth = self.depth.saturating_sub(1);
        Ok(built)
    }

    /// Precedence climbing over the flat list; all operators are left-associative, comparisons do not chain.
    fn climb<I>(&mut self, tokens: &mut std::iter::Peekable<I>, least: u8) -> Built<Expr>
    where
        I: Iterator<Item = Pair<'t, Rule>>,
    {
        let mut left = self.signed(tokens)?;
        let mut chain = 0;
        while let Some(token) = tokens.peek() {
            let Some((power, infix)) = infix(token.as_str()) else {
                break;
            };
            if power < least {
                break;
            }
            let sign = self.span(token);
            let _taken = tokens.next();
            // A chain becomes a tree that leans to the left; whoever walks it must not run out of stack.
            chain += 1;
            if chain > NESTING_LIMIT * 2 {
                self.depth = NESTING_LIMIT * 2;
                self.deeper(sign)?;
            }
            let right = self.climb(tokens, power + 1)?;
            left = match infix {
                Infix::Pipe => self.pipe(left, right)?,
                Infix::Operator(operator) => {
                    if power == COMPARISON
                        && tokens.peek().is_some_and(|next| infix_power(next.as_str()) == Some(COMPARISON))
                    {
                        let both = left.span.to(right.span);
                        return self.refuse(
                            Finding::error("syntax-error", both, "comparisons do not chain")
                                .help("write `a < b and b < c`"),
                        );
                    }
                    let span = left.span.to(right.span);
                    Expr { span, kind: ExprKind::Binary(operator, sign, Box::new((left, right))) }
                }
            };
        }
        Ok(left)
    }

    fn signed<I>(&mut self, tokens: &mut std::iter::Peekable<I>) -> Built<Expr>
    where
        I: Iterator<Item = Pair<'t, Rule>>,
    {
        let mut signs = Vec::new();
        while let Some(token) = tokens.next_if(|token| token.as_rule() == Rule::prefix) {
            let span = self.span(&token);
            signs.push((if token.as_str().starts_with('-') { Unary::Minus } else { Unary::Not }, span));
            if signs.len() > NESTING_LIMIT {
                self.depth = NESTING_LIMIT * 2;
                self.deeper(span)?;
            }
        }
        let operand = tokens.next().ok_or(Broken)?;
        let mut value = self.operand(operand)?;
        for (sign, span) in signs.into_iter().rev() {
            value = Expr { span: span.to(value.span), kind: ExprKind::Unary(sign, Box::new(value)) };
        }
        Ok(value)
    }

    fn pipe(&mut self, piped: Expr, right: Expr) -> Built<Expr> {
        let span = piped.span.to(right.span);
        match right.kind {
            ExprKind::Call(call) if call.piped.is_none() => {
                let Call { name, piped: _, args, span: own } = *call;
                let call = Call { name, piped: Some(piped), args, span: own };
                Ok(Expr { span, kind: ExprKind::Call(Box::new(call)) })
            }
            _ => self.refuse(
                Finding::error("syntax-error", right.span, "the right side of `|>` must be a call")
                    .label("no call")
                    .help("write for example `|> faceted()`"),
            ),
        }
    }

    fn operand(&mut self, pair: Pair<'t, Rule>) -> Built<Expr> {
        let mut value: Option<Expr> = None;
        for inner in pair.into_inner() {
            value = Some(match (value, inner.as_rule()) {
                (Some(of), Rule::postfix) => {
                    let span = of.span.to(self.span(&inner));
                    self.deeper(span)?;
                    match inner.into_inner().next() {
                        Some(part) if part.as_rule() == Rule::expr => {
                            let index = self.expr(part)?;
                            Expr { span, kind: ExprKind::Index(Box::new((of, index))) }
                        }
                        Some(part) => {
                            let name = self.name(part)?;
                            Expr { span, kind: ExprKind::Member(Box::new(of), name) }
                        }
                        None => return Err(Broken),
                    }
                }
                (_, _) => self.primary(inner)?,
            });
        }
        value.ok_or(Broken)
    }

    fn primary(&mut self, pair: Pair<'t, Rule>) -> Built<Expr> {
        let span = self.span(&pair);
        let kind = match pair.as_rule() {
            Rule::number => self.number(&pair, span)?,
            Rule::string => ExprKind::String(self.string(&pair)?.text),
            Rule::truth => ExprKind::Bool(pair.as_str() == "true"),
            Rule::name => ExprKind::Name(self.name(pair)?.text),
            Rule::call => return self.call(pair, span),
            Rule::row => ExprKind::Row(self.row(&pair, span)?),
            Rule::paren => return self.paren(pair, span),
            Rule::list => ExprKind::List(self.exprs(pair)?),
            Rule::comprehension => {
                let (mut clauses, mut value) = (Vec::new(), None);
                for inner in pair.into_inner() {
                    match inner.as_rule() {
                        Rule::clause => clauses.push(self.clause(inner)?),
                        Rule::expr => value = Some(self.expr(inner)?),
                        _ => {}
                    }
                }
                ExprKind::Comprehension(clauses, Box::new(value.ok_or(Broken)?))
            }
            _ => {
                let mut parts = self.exprs(pair)?.into_iter();
                match (parts.next(), parts.next(), parts.next()) {
                    (Some(when), Some(then), Some(otherwise)) => ExprKind::If(Box::new((when, then, otherwise))),
                    _ => return Err(Broken),
                }
            }
        };
        Ok(Expr { span, kind })
    }

    fn exprs(&mut self, pair: Pair<'t, Rule>) -> Built<Vec<Expr>> {
        let inner = pair.into_inner().filter(|inner| inner.as_rule() == Rule::expr);
        inner.map(|expr| self.expr(expr)).collect()
    }

    fn paren(&mut self, pair: Pair<'t, Rule>, span: Span) -> Built<Expr> {
        let trailing = pair.clone().into_inner().any(|inner| inner.as_rule() == Rule::trailing_comma);
        let mut parts = self.exprs(pair)?;
        if parts.len() == 1 && !trailing {
            // Brackets round one value only group; the place stays that of the whole.
            return Ok(Expr { span, kind: parts.remove(0).kind });
        }
        if parts.len() == 1 {
            return self.refuse(
                Finding::error("syntax-error", span, "a tuple needs at least two values").help("remove the comma"),
            );
        }
        Ok(Expr { span, kind: ExprKind::Tuple(parts) })
    }

    fn call(&mut self, pair: Pair<'t, Rule>, span: Span) -> Built<Expr> {
        let (mut name, mut args) = (None, Vec::new());
        for inner in pair.into_inner() {
            match inner.as_rule() {
                Rule::name => name = Some(self.name(inner)?),
                Rule::args => {
                    for arg in inner.into_inner() {
                        let labeled = arg.clone().into_inner().any(|part| part.as_rule() == Rule::label);
                        let label = labeled.then(|| self.label(&arg));
                        args.push(Arg { label, value: self.only_expr(arg)? });
                    }
                }
                _ => {}
            }
        }
        let call = Call { name: name.ok_or(Broken)?, piped: None, args, span };
        Ok(Expr { span, kind: ExprKind::Call(Box::new(call)) })
    }

    fn number(&mut self, pair: &Pair<'t, Rule>, span: Span) -> Built<ExprKind> {
        let text = pair.as_str();
        let suffix = pair.clone().into_inner().find(|inner| inner.as_rule() == Rule::suffix);
        let suffix = suffix.as_ref().map_or("", Pair::as_str);
        let value = self.value(&text[..text.len() - suffix.len()], span)?;
        Ok(if suffix.is_empty() { ExprKind::Number(value) } else { ExprKind::Unit(value, suffix.to_owned()) })
    }

    fn row(&mut self, pair: &Pair<'t, Rule>, span: Span) -> Built<Vec<f64>> {
        let text = pair.as_str();
        let inner = text.trim_start_matches('(').trim_end_matches(')').trim().trim_end_matches(',');
        inner.split(',').map(|number| self.value(number.trim(), span)).collect()
    }

    fn value(&mut self, text: &str, span: Span) -> Built<f64> {
        let parsed: Option<f64> =
            if text.contains('_') { text.replace('_', "").parse().ok() } else { text.parse().ok() };
        match parsed {
            Some(value) if value.is_finite() => Ok(value),
            _ => self.refuse(
                Finding::error("number-range", span, format!("`{}` is too large for a number", clip(text)))
                    .note("numbers are double precision, up to 1.8e308"),
            ),
        }
    }
}

/// At most 40 characters of a text, for messages.
pub(super) fn clip(text: &str) -> String {
    if text.chars().count() <= 40 { text.to_owned() } else { text.chars().take(37).chain("...".chars()).collect() }
}

enum Infix {
    Pipe,
    Operator(Binary),
}

const COMPARISON: u8 = 5;

fn infix_power(sign: &str) -> Option<u8> {
    infix(sign).map(|(power, _)| power)
}

/// How strongly an operator binds, loosest first.
fn infix(sign: &str) -> Option<(u8, Infix)> {
    let (power, operator) = match sign.trim() {
        "|>" => return Some((1, Infix::Pipe)),
        ".." => (2, Binary::Range),
        "or" => (3, Binary::Or),
        "and" => (4, Binary::And),
        "==" => (COMPARISON, Binary::Equal),
        "!=" => (COMPARISON, Binary::NotEqual),
        "<" => (COMPARISON, Binary::Less),
        "<=" => (COMPARISON, Binary::LessEqual),
        ">" => (COMPARISON, Binary::Greater),
        ">=" => (COMPARISON, Binary::GreaterEqual),
        "+" => (6, Binary::Add),
        "-" => (6, Binary::Subtract),
        "*" => (7, Binary::Multiply),
        "/" => (7, Binary::Divide),
        _ => return None,
    };
    Some((power, Infix::Operator(operator)))
}

fn kind_of(word: &str) -> Kind {
    let all = [
        Kind::Material,
        Kind::Mesh,
        Kind::Texture,
        Kind::Group,
        Kind::Shape,
        Kind::Emitter,
        Kind::Instance,
        Kind::Camera,
        Kind::Film,
        Kind::Integrator,
        Kind::Sampler,
    ];
    all.into_iter().find(|kind| kind.word() == word).unwrap_or(Kind::Let)
}

fn doc_text(pair: Pair<'_, Rule>) -> String {
    let lines = pair.into_inner().map(|line| {
        let text = line.as_str().trim_end();
        let text = text.strip_prefix("///").unwrap_or(text);
        text.strip_prefix(' ').unwrap_or(text)
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Whether junk is one line of documentation.
fn is_documentation(junk: &str) -> bool {
    let line = junk.trim();
    line.starts_with("///") && !line.starts_with("////") && !line.contains('\n')
}
