//! What evaluation may spend: work, counted where it is done, and memory, counted where it is held.
//!
//! A step is a call or an iteration; [`PER_STEP`] units of work are one step more: each part of an expression that is
//! evaluated and each element of a list that is looked at or made is a unit. No text takes more than `limits.steps` of
//! either kind, so that every text ends.

use std::cell::Cell;
use std::fmt::Write;
use std::hash::{DefaultHasher, Hasher};
use std::ops::Deref;
use std::rc::Rc;

use crate::diag::{Finding, Span};

use super::value::Value;
use super::{Interpreter, Limit, Reported};

/// Units of work that make a step.
const PER_STEP: u64 = 32;

/// Units that any text may spend, so that a low limit of steps concerns loops and not the length of the text.
const FREE: u64 = 1 << 18;

/// How deep lists and functions may hold each other: what holds them is also left level by level.
pub(super) const HOLD_DEPTH: usize = 256;

/// Bytes of a value's text that are read in one unit; numbers take long to be written.
const BYTES_PER_UNIT: u64 = 1;

/// Bytes that are held, by all lists of one evaluation together.
#[derive(Clone, Debug, Default)]
pub(super) struct Held(Rc<Cell<u64>>);

impl Held {
    fn add(&self, bytes: u64) {
        self.0.set(self.0.get().saturating_add(bytes));
    }
}

/// Elements that are kept, and counted as long as they are.
struct Elements {
    items: Vec<Value>,
    depth: usize,
    held: Held,
}

impl Drop for Elements {
    fn drop(&mut self) {
        self.held.0.set(self.held.0.get().saturating_sub(bytes(self.items.len())));
    }
}

/// What `count` elements take, with what a short vector in each of them takes.
fn bytes(count: usize) -> u64 {
    count as u64 * (size_of::<Value>() as u64 + 48)
}

/// Elements of a list or tuple. Copies and slices share them.
#[derive(Clone)]
pub(super) struct List {
    all: Rc<Elements>,
    start: usize,
    end: usize,
}

impl List {
    /// The elements of `range`, which lies within it.
    pub(super) fn slice(&self, range: std::ops::RangeInclusive<usize>) -> Self {
        let end = self.start + range.end() + 1;
        Self { all: Rc::clone(&self.all), start: self.start + range.start(), end: end.min(self.end) }
    }

    /// How deep lists lie within each other, this one included.
    pub(super) fn depth(&self) -> usize {
        self.all.depth
    }
}

impl Deref for List {
    type Target = [Value];

    fn deref(&self) -> &[Value] {
        self.all.items.get(self.start..self.end).unwrap_or_default()
    }
}

impl std::fmt::Debug for List {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// What has been spent up to now.
#[derive(Debug, Default)]
pub(super) struct Work {
    units: u64,
    pub held: Held,
    /// Whether the limit has been reported.
    told: (bool, bool),
}

impl Interpreter<'_> {
    /// Counts one call or iteration; the limit keeps a scene from running without end.
    pub(super) fn step(&mut self, span: Span) -> Result<(), Reported> {
        self.steps += 1;
        if self.steps <= self.limits.steps { Ok(()) } else { self.too_many_steps(span) }
    }

    /// Counts `units` of work that is about to be done.
    pub(super) fn spend(&mut self, units: u64, span: Span) -> Result<(), Reported> {
        self.work.units = self.work.units.saturating_add(units);
        if self.work.units <= self.most_units() { Ok(()) } else { self.too_many_steps(span) }
    }

    /// Whether `units` may still be spent.
    pub(super) fn affords(&self, units: u64) -> bool {
        self.work.units.saturating_add(units) <= self.most_units()
    }

    /// The units that may still be spent.
    pub(super) fn left(&self) -> u64 {
        self.most_units().saturating_sub(self.work.units)
    }

    fn most_units(&self) -> u64 {
        self.limits.steps.saturating_mul(PER_STEP).saturating_add(FREE)
    }

    fn too_many_steps(&mut self, span: Span) -> Result<(), Reported> {
        if !std::mem::replace(&mut self.work.told.0, true) {
            self.findings.push(
                Finding::error("step-limit", span, format!("the file takes more than {} steps", self.limits.steps))
                    .label("reached here")
                    .note(format!(
                        "calls and iterations of loops count as steps, and so do every {PER_STEP} parts of expressions and \
                         elements of lists"
                    ))
                    .help(Limit::help("steps")),
            );
        }
        Err(Reported)
    }

    /// Counts `bytes` that are kept until the end of the evaluation.
    pub(super) fn hold(&mut self, bytes: u64, span: Span) -> Result<(), Reported> {
        self.work.held.add(bytes);
        self.fits(span)
    }

    fn fits(&mut self, span: Span) -> Result<(), Reported> {
        let most = self.limits.memory;
        if self.work.held.0.get() <= most {
            return Ok(());
        }
        if !std::mem::replace(&mut self.work.told.1, true) {
            self.findings.push(
                Finding::error("memory-limit", span, format!("the values of the file take more than {most} bytes"))
                    .label("reached here")
                    .note("lists, spectra, places of instances and vertices count")
                    .help(Limit::help("memory")),
            );
        }
        Err(Reported)
    }

    /// A list or tuple of these elements; they count as long as something holds them.
    pub(super) fn elements(&mut self, items: Vec<Value>, span: Span) -> Result<List, Reported> {
        self.spend(items.len() as u64, span)?;
        let depth = 1 + items.iter().map(Value::depth).max().unwrap_or(0);
        if depth > HOLD_DEPTH {
            let message = format!("lists hold each other more than {HOLD_DEPTH} levels deep");
            return self.report(Finding::error("nesting-limit", span, message));
        }
        self.work.held.add(bytes(items.len()));
        let end = items.len();
        let all = Rc::new(Elements { items, depth, held: self.work.held.clone() });
        self.fits(span)?;
        Ok(List { all, start: 0, end })
    }
}

/// Hashes what is written, without keeping it, up to a length.
struct Fingerprint {
    hashers: [DefaultHasher; 2],
    left: u64,
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.left = self.left.checked_sub(text.len() as u64).ok_or(std::fmt::Error)?;
        self.hashers.iter_mut().for_each(|hasher| hasher.write(text.as_bytes()));
        Ok(())
    }
}

impl Interpreter<'_> {
    /// A number that equal values have in common, and other values have not (128 bits). Nothing of it leaves the evaluation.
    pub(super) fn fingerprint(&mut self, values: &[Value], span: Span) -> Result<u128, Reported> {
        let most = self.left().saturating_mul(BYTES_PER_UNIT);
        let mut found = Fingerprint { hashers: [DefaultHasher::new(), DefaultHasher::new()], left: most };
        found.hashers[1].write_u8(1);
        let whole = write!(found, "{values:?}").is_ok();
        let used = if whole { 1 + (most - found.left) / BYTES_PER_UNIT } else { u64::MAX };
        self.spend(used, span)?;
        let [a, b] = found.hashers.map(|hasher| u128::from(hasher.finish()));
        Ok(a << 64 | b)
    }
}
