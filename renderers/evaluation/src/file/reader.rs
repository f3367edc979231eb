//! TOML with the place of every word, read key by key; what is wrong becomes a finding, and the rest is read on.

use std::ops::{Range, RangeInclusive};

use ltsc_core::diag::{FileId, Finding, Span, nearest};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::model::At;

/// Where findings are collected.
pub(super) struct Reader {
    file: FileId,
    /// What was found so far.
    pub findings: Vec<Finding>,
}

/// A value with its key.
#[derive(Clone)]
pub(super) struct Item<'t> {
    /// How messages call it, such as `chunks`.
    pub name: String,
    /// Where the key stands; for an element of a list the element.
    pub key: Span,
    value: &'t DeValue<'t>,
    /// Where the value stands.
    pub span: Span,
}

/// A table whose keys are taken one by one.
pub(super) struct Table<'t> {
    /// How messages call it.
    name: String,
    /// Where it begins.
    pub span: Span,
    entries: Vec<(At<&'t str>, Item<'t>)>,
    asked: Vec<&'static str>,
}

impl Reader {
    pub fn new(file: FileId) -> Self {
        Self { file, findings: Vec::new() }
    }

    /// Parses a text; all that is wrong with it is found, and what can be read is given.
    pub fn parse<'t>(&mut self, text: &'t str) -> Spanned<DeTable<'t>> {
        let (table, errors) = DeTable::parse_recoverable(text);
        for error in errors {
            let range = error.span().unwrap_or(0..0);
            let span = self.within(text, range);
            let message = error.message().trim().replace('\n', "; ");
            self.findings.push(Finding::error("evaluation-syntax", span, format!("the file is no TOML: {message}")));
        }
        table
    }

    /// A range of the text, moved to the letters around it.
    fn within(&self, text: &str, range: Range<usize>) -> Span {
        let mut start = range.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let mut end = range.end.clamp(start, text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        Span::new(self.file, start, end)
    }

    /// The table that a file is.
    pub fn whole<'t>(&self, table: &'t Spanned<DeTable<'t>>) -> Table<'t> {
        self.table_of(table.get_ref(), "the file", Span::new(self.file, 0, 0))
    }

    fn place(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range.start, range.end)
    }

    fn table_of<'t>(&self, table: &'t DeTable<'t>, name: &str, span: Span) -> Table<'t> {
        let mut entries: Vec<(At<&str>, Item<'_>)> = table
            .iter()
            .map(|(key, value)| {
                let at = self.place(key.span());
                let text: &str = key.get_ref();
                let item =
                    Item { name: text.to_owned(), key: at, value: value.get_ref(), span: self.place(value.span()) };
                (At::new(text, at), item)
            })
            .collect();
        // The order of the text, where the map has that of the alphabet.
        entries.sort_by_key(|(key, _)| (key.span.start, key.span.end));
        Table { name: name.to_owned(), span, entries, asked: Vec::new() }
    }

    /// Says what is wrong.
    pub fn error(&mut self, id: &'static str, span: Span, message: impl Into<String>) -> &mut Finding {
        self.findings.push(Finding::error(id, span, message));
        let last = self.findings.len() - 1;
        &mut self.findings[last]
    }

    /// Says that a value has another type than its key takes.
    pub fn mismatch(&mut self, item: &Item<'_>, takes: &str) {
        let message = format!("`{}` takes {takes}, not {}", item.name, item.kind());
        self.error("evaluation-type", item.span, message);
    }
}

/// A help with the nearest name, or all that are known.
pub(super) fn near<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let known: Vec<&str> = known.into_iter().collect();
    match nearest(name, known.iter().copied()) {
        Some(similar) => Some(format!("did you mean `{similar}`?")),
        None if known.is_empty() => None,
        None if known.len() > 20 => Some(format!("known: {} and {} more", known[..12].join(", "), known.len() - 12)),
        None => Some(format!("known: {}", known.join(", "))),
    }
}

impl<'t> Table<'t> {
    /// The value of a key, which from now on is known.
    pub fn take(&mut self, key: &'static str) -> Option<Item<'t>> {
        self.asked.push(key);
        let at = self.entries.iter().position(|(name, _)| name.value == key)?;
        Some(self.entries.remove(at).1)
    }

    /// All that was not taken, in the order of the text.
    pub fn rest(&mut self) -> Vec<(At<&'t str>, Item<'t>)> {
        std::mem::take(&mut self.entries)
    }

    /// Says which keys are not known.
    pub fn finish(self, reader: &mut Reader) {
        for (key, _) in self.entries {
            let message = format!("{} has no key `{}`", self.name, key.value);
            let help = near(key.value, self.asked.iter().copied());
            reader.error("evaluation-key", key.span, message).help = help;
        }
    }
}

impl<'t> Item<'t> {
    /// What the value is, with its article.
    pub fn kind(&self) -> &'static str {
        match self.value {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a float",
            DeValue::Boolean(_) => "a boolean",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        }
    }

    /// The string, if it is one.
    pub fn as_str(&self) -> Option<&'t str> {
        self.value.as_str()
    }

    /// The boolean, if it is one.
    pub fn as_bool(&self) -> Option<bool> {
        self.value.as_bool()
    }

    /// The integer, if it is one; none also where it has more than 64 bits.
    pub fn as_int(&self) -> Option<i64> {
        self.value.as_integer().and_then(|number| i64::from_str_radix(number.as_str(), number.radix()).ok())
    }

    /// Whether it is an integer of any size.
    pub fn is_int(&self) -> bool {
        self.value.is_integer()
    }

    /// The float, if it is one.
    pub fn as_float(&self) -> Option<f64> {
        self.value.as_float().and_then(|number| number.as_str().parse().ok())
    }

    /// The number, if it is a finite one.
    pub fn as_number(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "what is written as an integer is small where a number is due")]
        let of_int = |number: i64| number as f64;
        self.as_float().or_else(|| self.as_int().map(of_int)).filter(|number| number.is_finite())
    }

    /// The elements, if it is a list.
    pub fn as_list(&self, reader: &Reader) -> Option<Vec<Item<'t>>> {
        let list = self.value.as_array()?;
        Some(
            list.iter()
                .map(|element| {
                    let span = reader.place(element.span());
                    Item { name: self.name.clone(), key: span, value: element.get_ref(), span }
                })
                .collect(),
        )
    }

    /// The table, if it is one.
    pub fn as_table(&self, reader: &Reader, name: &str) -> Option<Table<'t>> {
        Some(reader.table_of(self.value.as_table()?, name, self.key))
    }

    /// A table; anything else is a finding.
    pub fn table(&self, reader: &mut Reader, name: &str) -> Option<Table<'t>> {
        let table = self.as_table(reader, name);
        if table.is_none() {
            reader.mismatch(self, "a table");
        }
        table
    }

    /// A list; anything else is a finding.
    pub fn list(&self, reader: &mut Reader) -> Option<Vec<Item<'t>>> {
        let list = self.as_list(reader);
        if list.is_none() {
            reader.mismatch(self, "a list");
        }
        list
    }

    /// A string; anything else is a finding.
    pub fn string(&self, reader: &mut Reader) -> Option<At<String>> {
        let Some(text) = self.as_str() else {
            reader.mismatch(self, "a string");
            return None;
        };
        Some(At::new(text.to_owned(), self.span))
    }

    /// A string that is not empty and has no control characters; anything else is a finding.
    pub fn word(&self, reader: &mut Reader) -> Option<At<String>> {
        let text = self.string(reader)?;
        if text.value.trim().is_empty() {
            reader.error("evaluation-value", self.span, format!("`{}` is empty", self.name));
            return None;
        }
        if text.value.chars().any(char::is_control) {
            reader.error("evaluation-value", self.span, format!("`{}` contains a control character", self.name));
            return None;
        }
        Some(text)
    }

    /// Strings in a list that is not empty, or one string; anything else is a finding.
    pub fn words(&self, reader: &mut Reader) -> Vec<At<String>> {
        if self.as_str().is_some() {
            return self.word(reader).into_iter().collect();
        }
        let Some(list) = self.as_list(reader) else {
            reader.mismatch(self, "a string or a list of strings");
            return Vec::new();
        };
        if list.is_empty() {
            reader.error("evaluation-value", self.span, format!("the list `{}` is empty", self.name));
        }
        list.iter().filter_map(|element| element.word(reader)).collect()
    }

    /// A boolean; anything else is a finding.
    pub fn bool(&self, reader: &mut Reader) -> Option<bool> {
        let value = self.as_bool();
        if value.is_none() {
            reader.mismatch(self, "`true` or `false`");
        }
        value
    }

    /// An integer of a range; anything else is a finding.
    pub fn count(&self, reader: &mut Reader, range: RangeInclusive<u32>) -> Option<At<u32>> {
        if !self.is_int() {
            reader.mismatch(self, "an integer");
            return None;
        }
        let value = self.as_int().and_then(|value| u32::try_from(value).ok()).filter(|value| range.contains(value));
        if value.is_none() {
            let bounds = if *range.end() == u32::MAX {
                format!("of at least {}", range.start())
            } else {
                format!("from {} to {}", range.start(), range.end())
            };
            reader.error("evaluation-value", self.span, format!("`{}` takes an integer {bounds}", self.name));
        }
        value.map(|value| At::new(value, self.span))
    }

    /// A number above zero; anything else is a finding.
    pub fn above_zero(&self, reader: &mut Reader) -> Option<At<f64>> {
        if !self.is_int() && self.as_float().is_none() {
            reader.mismatch(self, "a number");
            return None;
        }
        let value = self.as_number().filter(|value| *value > 0.0);
        if value.is_none() {
            reader.error("evaluation-value", self.span, format!("`{}` takes a finite number above 0", self.name));
        }
        value.map(|value| At::new(value, self.span))
    }

    /// A number that is finite; anything else is a finding.
    pub fn number(&self, reader: &mut Reader) -> Option<At<f64>> {
        let value = self.as_number();
        if value.is_none() {
            reader.mismatch(self, "a finite number");
        }
        value.map(|value| At::new(value, self.span))
    }
}
