//! A finding with the text that its place lies in, as a line and as JSON.

use ltsc_core::diag::{Edit, Finding, Origin, Sources, Span};
use serde_json::{Value, json};

use crate::terminal::{self, severity_word};

/// A finding with the text that its spans lie in.
pub struct Located<'s> {
    pub finding: Finding,
    pub sources: &'s Sources,
    /// What stands before the paths of `sources` where they are seen from the repository: empty, or with a `/` at its end.
    pub prefix: &'s str,
}

impl Located<'_> {
    /// Path, line and column; zeros where there is no such thing.
    fn place(&self) -> (String, usize, usize) {
        match &self.finding.origin {
            Origin::Text(span) => {
                let at = self.sources.position(span.file, span.start);
                (self.sources.get(span.file).path.clone(), at.line, at.column)
            }
            Origin::File { path, .. } => (path.clone(), 0, 0),
            Origin::Made => (String::new(), 0, 0),
        }
    }

    /// What makes two findings the same: a library's is found once for each scene that uses it.
    pub fn key(&self) -> (String, usize, usize, &'static str, String) {
        let (path, line, column) = self.place();
        (path, line, column, self.finding.id, self.finding.message.clone())
    }

    /// `path:line:column: error[id]: message`
    pub fn short(&self) -> String {
        let (path, line, column) = self.place();
        let place = match (path.as_str(), line) {
            ("", _) => String::new(),
            (path, 0) => format!("{path}: "),
            (path, line) => format!("{path}:{line}:{column}: "),
        };
        let Finding { id, severity, message, .. } = &self.finding;
        let line = format!("{place}{}[{id}]: {message}", severity_word(*severity));
        terminal::harmless(&line).replace('\n', " ")
    }

    /// A path of `sources` as it is seen from the repository.
    pub fn path(&self, path: &str) -> String {
        let plain = path.starts_with('/') || path.contains(':') || path.starts_with("..");
        if plain { path.to_owned() } else { format!("{}{path}", self.prefix) }
    }

    /// First and last line and column of a span: the last column is one past its end.
    pub fn lines(&self, span: Span) -> [usize; 4] {
        let (from, to) = (self.sources.position(span.file, span.start), self.sources.position(span.file, span.end));
        [from.line, from.column, to.line, to.column]
    }

    fn span_json(&self, span: Span) -> Value {
        let [line, column, end_line, end_column] = self.lines(span);
        json!({
            "path": self.sources.get(span.file).path,
            "line": line, "column": column, "end_line": end_line, "end_column": end_column,
        })
    }

    fn place_json(&self) -> Value {
        match &self.finding.origin {
            Origin::Text(span) => self.span_json(*span),
            Origin::File { path, place } => json!({ "path": path, "place": place }),
            Origin::Made => Value::Null,
        }
    }

    /// What programs read about a finding that was fixed; `fix` is the title of the fix.
    pub fn fixed_json(&self, fix: &str) -> Value {
        let Finding { id, message, .. } = &self.finding;
        json!({ "id": id, "message": message, "place": self.place_json(), "fix": fix })
    }

    /// The stable JSON form.
    pub fn json(&self) -> Value {
        let Finding { id, severity, message, origin: _, label, labels, notes, help, suppression, fixable: _, fix } =
            &self.finding;
        let place = self.place_json();
        let labels: Vec<Value> =
            labels.iter().map(|label| json!({ "place": self.span_json(label.span), "text": label.text })).collect();
        let fix = fix.as_ref().map(|fix| {
            let edit = |edit: &Edit| json!({ "place": self.span_json(edit.span), "text": edit.text });
            json!({ "title": fix.title, "edits": fix.edits.iter().map(edit).collect::<Vec<_>>() })
        });
        let reason = suppression.as_ref().map(|suppression| &suppression.reason);
        json!({
            "id": id, "severity": severity, "message": message, "place": place, "label": label,
            "labels": labels, "notes": notes, "help": help, "allowed_because": reason, "fix": fix,
        })
    }
}
