//! A document algebra in the manner of Wadler (2003) and Prettier, and its printer.
//!
//! A [`Doc`] says where lines may break; the printer decides. A group is printed on one line if that fits, else all its own
//! lines break. Line ends collapse: a break at the start of a line prints nothing, so that comments, which always end
//! their line, need no care by those who build documents. Time is linear: looking ahead ends at the margin.

use std::borrow::Cow;
use std::rc::Rc;

/// The margin.
const WIDTH: usize = 120;

/// Blanks of a level.
const INDENT: usize = 4;

/// A layout with choices.
#[derive(Clone, Debug)]
pub(super) struct Doc<'t> {
    kind: Kind<'t>,
    /// Whether it holds a line end that is not a choice, and something behind it.
    hard: bool,
    /// Whether it ends with a comment: what follows stands on another line.
    tail: bool,
}

#[derive(Clone, Debug)]
enum Kind<'t> {
    Text(Cow<'t, str>),
    /// A blank, or a line end where the group breaks.
    Line,
    /// Nothing, or a line end where the group breaks.
    Soft,
    /// A line end.
    Hard,
    /// A line end and an empty line.
    Blank,
    /// A comment behind what stands on the line, or on a line of its own; the line ends behind it.
    Note(&'t str, bool),
    /// Printed only where the group breaks.
    IfBroken(&'static str),
    Concat(Rc<[Doc<'t>]>),
    Indent(Rc<Doc<'t>>),
    Group(Rc<Doc<'t>>),
    /// Items parted by blanks or line ends, as many on a line as fit.
    Fill(Rc<[Doc<'t>]>),
    /// Behind `=`: on the same line if it fits; on the next, if it fits there; else broken from here on.
    Assigned(Rc<Doc<'t>>),
}

impl<'t> Doc<'t> {
    fn plain(kind: Kind<'t>) -> Self {
        Self { kind, hard: false, tail: false }
    }

    /// Whether it cannot stand on one line with what follows.
    pub fn breaks(&self) -> bool {
        self.hard || self.tail
    }

    /// Whether it prints nothing.
    fn is_empty(&self) -> bool {
        if let Kind::Text(text) = &self.kind {
            return text.is_empty();
        }
        if let Kind::Concat(parts) = &self.kind { parts.is_empty() } else { false }
    }

    pub fn text(text: impl Into<Cow<'t, str>>) -> Self {
        Self::plain(Kind::Text(text.into()))
    }

    pub fn line() -> Self {
        Self::plain(Kind::Line)
    }

    pub fn soft() -> Self {
        Self::plain(Kind::Soft)
    }

    pub fn hard() -> Self {
        Self { hard: true, ..Self::plain(Kind::Hard) }
    }

    pub fn blank() -> Self {
        Self { hard: true, ..Self::plain(Kind::Blank) }
    }

    /// A comment behind what stands on the line, or on a line of its own.
    pub fn note(text: &'t str, own: bool) -> Self {
        Self { tail: true, ..Self::plain(Kind::Note(text, own)) }
    }

    pub fn if_broken(text: &'static str) -> Self {
        Self::plain(Kind::IfBroken(text))
    }

    pub fn concat(mut parts: Vec<Self>) -> Self {
        parts.retain(|part| !part.is_empty());
        let tail = parts.last().is_some_and(|last| last.tail);
        let hard = parts.iter().any(|part| part.hard) || parts.iter().rev().skip(1).any(|part| part.tail);
        Self { kind: Kind::Concat(parts.into()), hard, tail }
    }

    pub fn indent(self) -> Self {
        Self { hard: self.hard, tail: self.tail, kind: Kind::Indent(Rc::new(self)) }
    }

    pub fn group(self) -> Self {
        Self { hard: self.hard, tail: self.tail, kind: Kind::Group(Rc::new(self)) }
    }

    /// Items that do not break.
    pub fn fill(items: Vec<Self>) -> Self {
        Self::plain(Kind::Fill(items.into()))
    }

    pub fn assigned(self) -> Self {
        Self { hard: self.hard, tail: self.tail, kind: Kind::Assigned(Rc::new(self)) }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Flat,
    Broken,
}

/// What is still to be printed, the next one last.
type Work<'d, 't> = Vec<(usize, Mode, &'d Doc<'t>)>;

/// Prints documents one behind the other.
#[derive(Default)]
pub(super) struct Printer {
    out: String,
    /// The columns of the line so far; none before its indentation has been written.
    column: Option<usize>,
}

impl Printer {
    /// The text, which ends with a line end unless it is empty.
    pub fn finish(mut self) -> String {
        self.end_line();
        self.out
    }

    pub fn print(&mut self, doc: &Doc<'_>) {
        let mut work: Work<'_, '_> = vec![(0, Mode::Broken, doc)];
        while let Some((indent, mode, doc)) = work.pop() {
            match &doc.kind {
                Kind::Text(text) => self.write(indent, text),
                Kind::IfBroken(text) => {
                    if mode == Mode::Broken {
                        self.write(indent, text);
                    }
                }
                Kind::Line | Kind::Soft => match mode {
                    Mode::Broken => self.end_line(),
                    Mode::Flat if matches!(doc.kind, Kind::Line) => self.space(),
                    Mode::Flat => {}
                },
                Kind::Hard => self.end_line(),
                Kind::Note(text, own) => {
                    if *own {
                        self.end_line();
                    }
                    self.space();
                    self.write(indent, text);
                    self.end_line();
                }
                Kind::Blank => {
                    self.end_line();
                    if !self.out.is_empty() && !self.out.ends_with("\n\n") {
                        self.out.push('\n');
                    }
                }
                Kind::Concat(parts) => work.extend(parts.iter().rev().map(|part| (indent, mode, part))),
                Kind::Indent(inner) => work.push((indent + INDENT, mode, inner)),
                Kind::Group(inner) => {
                    let column = self.column.unwrap_or(indent);
                    let flat = mode == Mode::Flat || !inner.hard && fits(column, indent, inner, &work);
                    work.push((indent, if flat { Mode::Flat } else { Mode::Broken }, inner));
                }
                Kind::Assigned(inner) => {
                    let column = self.column.map_or(indent, |column| column + 1);
                    let further = indent + INDENT;
                    if inner.hard || mode == Mode::Flat || fits(column, indent, inner, &work) {
                        self.space();
                        work.push((indent, if inner.hard { Mode::Broken } else { Mode::Flat }, inner));
                    } else if fits(further, further, inner, &work) {
                        self.end_line();
                        work.push((further, Mode::Flat, inner));
                    } else {
                        self.space();
                        work.push((indent, Mode::Broken, inner));
                    }
                }
                Kind::Fill(items) => self.fill(indent, mode, items, &work),
            }
        }
    }

    /// Items of a fill are short: they are printed at once.
    fn fill(&mut self, indent: usize, outer: Mode, items: &[Doc<'_>], rest: &Work<'_, '_>) {
        for (at, item) in items.iter().enumerate() {
            if at > 0 {
                let column = self.column.map_or(indent, |column| column + 1);
                let last = at + 1 == items.len();
                let empty = Vec::new();
                if outer == Mode::Flat || fits(column, indent, item, if last { rest } else { &empty }) {
                    self.space();
                } else {
                    self.end_line();
                }
            }
            let mut inner = vec![(indent, outer, item)];
            while let Some((indent, mode, doc)) = inner.pop() {
                match &doc.kind {
                    Kind::Text(text) => self.write(indent, text),
                    Kind::Line => self.space(),
                    Kind::Concat(parts) => inner.extend(parts.iter().rev().map(|part| (indent, mode, part))),
                    Kind::Indent(doc) => inner.push((indent, mode, doc)),
                    Kind::Group(doc) | Kind::Assigned(doc) => inner.push((indent, Mode::Flat, doc)),
                    Kind::Fill(parts) => inner.extend(parts.iter().rev().map(|part| (indent, mode, part))),
                    Kind::IfBroken(text) if mode == Mode::Broken => self.write(indent, text),
                    Kind::Soft | Kind::Hard | Kind::Blank | Kind::Note(..) | Kind::IfBroken(_) => {}
                }
            }
        }
    }

    fn write(&mut self, indent: usize, text: &str) {
        // A gap between two tokens is none at the start of a line.
        if text.is_empty() || text == " " && self.column.is_none() {
            return;
        }
        let column = match self.column {
            Some(column) => column,
            None => {
                self.out.extend(std::iter::repeat_n(' ', indent));
                indent
            }
        };
        self.out.push_str(text);
        self.column = Some(column + text.chars().count());
    }

    fn space(&mut self) {
        if let Some(column) = &mut self.column {
            self.out.push(' ');
            *column += 1;
        }
    }

    /// Ends the line unless nothing stands on it.
    fn end_line(&mut self) {
        if self.column.take().is_some() {
            let end = self.out.trim_end_matches(' ').len();
            self.out.truncate(end);
            self.out.push('\n');
        }
    }
}

/// Whether `doc` on one line, and what follows up to the next possible line end, stays within the margin.
fn fits(column: usize, indent: usize, doc: &Doc<'_>, rest: &Work<'_, '_>) -> bool {
    let mut left = match WIDTH.checked_sub(column) {
        Some(left) => left,
        None => return false,
    };
    let mut work: Work<'_, '_> = vec![(indent, Mode::Flat, doc)];
    let mut behind = rest.iter().rev();
    loop {
        let (indent, mode, doc) = match work.pop() {
            Some(next) => next,
            None => match behind.next() {
                Some(next) => *next,
                None => return true,
            },
        };
        let used = match &doc.kind {
            Kind::Text(text) => text.chars().count(),
            Kind::Line if mode == Mode::Flat => 1,
            Kind::Soft if mode == Mode::Flat => 0,
            Kind::Line | Kind::Soft | Kind::Hard | Kind::Blank | Kind::Note(..) => return true,
            Kind::IfBroken(text) => {
                if mode == Mode::Broken {
                    text.len()
                } else {
                    0
                }
            }
            Kind::Concat(parts) => {
                work.extend(parts.iter().rev().map(|part| (indent, mode, part)));
                0
            }
            // A group behind what must fit may break: a line end within it is a possible one.
            Kind::Indent(inner) | Kind::Group(inner) => {
                work.push((indent, mode, inner));
                0
            }
            // A line end is possible there.
            Kind::Assigned(_) if mode == Mode::Broken => return true,
            Kind::Assigned(inner) => {
                work.push((indent, mode, inner));
                1
            }
            Kind::Fill(items) => {
                work.extend(items.iter().rev().map(|item| (indent, mode, item)));
                items.len().saturating_sub(1)
            }
        };
        left = match left.checked_sub(used) {
            Some(left) => left,
            None => return false,
        };
    }
}
