//! Names as the language writes them, and names that nothing else has.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use crate::syntax::{NAME_LIMIT, RESERVED};

/// Values that the language itself names; what is declared under such a name would hide them.
const BUILT_IN: [&str; 4] = ["X", "Y", "Z", "PI"];

/// Room for a number behind a name.
const NUMBER: usize = 21;

/// A name as it stands in a text: words as they are, all others in backticks.
pub(super) fn written(name: &str) -> Cow<'_, str> {
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let word = starts && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    if word && !RESERVED.contains(&name) { Cow::Borrowed(name) } else { Cow::Owned(format!("`{name}`")) }
}

/// Names of one space, each given once.
#[derive(Debug, Default)]
pub(super) struct Names {
    taken: BTreeSet<String>,
    /// The number that was tried last behind a name.
    tried: BTreeMap<String, u64>,
}

impl Names {
    /// The space of values.
    pub(super) fn of_values() -> Self {
        Self { taken: BUILT_IN.map(str::to_owned).into(), tried: BTreeMap::new() }
    }

    /// Whether `name` can be had as it is.
    pub(super) fn is_free(&self, name: &str) -> bool {
        is_writable(name) && !self.taken.contains(name)
    }

    /// `wish` itself, or a name near it where that is taken or cannot be written.
    pub(super) fn take(&mut self, wish: &str) -> String {
        let name = if is_writable(wish) { wish.to_owned() } else { writable(wish) };
        if self.taken.insert(name.clone()) {
            return name;
        }
        let base = cut(&name, NAME_LIMIT - NUMBER).to_owned();
        let tried = self.tried.entry(base.clone()).or_insert(1);
        loop {
            *tried += 1;
            let name = format!("{base}_{tried}");
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}

fn is_writable(name: &str) -> bool {
    !name.is_empty() && name.len() <= NAME_LIMIT && !name.chars().any(|c| c.is_control() || c == '`')
}

/// A name without what the language has no way to write.
fn writable(name: &str) -> String {
    let kept: String = name.chars().filter(|c| !c.is_control() && *c != '`').collect();
    let kept = cut(&kept, NAME_LIMIT);
    if kept.is_empty() { "unnamed".to_owned() } else { kept.to_owned() }
}

/// At most so many bytes of a text, letters whole.
fn cut(text: &str, most: usize) -> &str {
    let end = (0..=most.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    &text[..end]
}
