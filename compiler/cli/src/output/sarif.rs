//! Findings as a SARIF 2.1.0 log: one run, with the pages of the rules.
//!
//! Paths are relative to `%SRCROOT%`, the root of the repository. Columns count code points.

use std::collections::{BTreeMap, BTreeSet};

use ltsc_core::diag::{CODES, Finding, Fix, Origin, Severity, Span};
use ltsc_core::lint::{self, Level};
use serde_json::{Map, Value, json};

use super::{Exit, Failure, Located};

const SCHEMA: &str = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// Where paths begin.
const BASE: &str = "%SRCROOT%";

/// What was found.
pub fn document(all: &[Located<'_>]) -> Value {
    let rules = Rules::of(all);
    let exit = all.iter().map(|located| Exit::of_finding(&located.finding)).max().unwrap_or(Exit::Done);
    let invocation = json!({ "executionSuccessful": exit != Exit::Fault, "exitCode": exit.code() });
    let results: Vec<Value> = all.iter().map(|located| result(located, &rules)).collect();
    let artifacts: BTreeSet<String> = all.iter().filter_map(path).collect();
    let artifacts = artifacts.iter().map(|path| json!({ "location": artifact(path) })).collect();
    log(&rules.list, &invocation, results, artifacts)
}

/// A command that could not do its work.
pub fn failure(failure: &Failure) -> Value {
    let help = failure.help.as_ref().map_or(String::new(), |help| format!("\nhelp: {help}"));
    let invocation = json!({
        "executionSuccessful": false,
        "exitCode": failure.exit.code(),
        "toolExecutionNotifications": [{ "level": "error", "message": { "text": format!("{}{help}", failure.message) } }],
    });
    log(&[], &invocation, Vec::new(), Vec::new())
}

fn log(rules: &[Value], invocation: &Value, results: Vec<Value>, artifacts: Vec<Value>) -> Value {
    json!({
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": { "name": "ltsc", "semanticVersion": env!("CARGO_PKG_VERSION"), "rules": rules } },
            "invocations": [invocation],
            "originalUriBaseIds": { BASE: { "description": { "text": "The root of the repository." } } },
            "columnKind": "unicodeCodePoints",
            "artifacts": artifacts,
            "results": results,
        }],
    })
}

/// The rules of the log, and where each stands.
struct Rules {
    list: Vec<Value>,
    index: BTreeMap<&'static str, usize>,
}

impl Rules {
    /// All rules of lint, and the other codes that were found.
    fn of(all: &[Located<'_>]) -> Self {
        let found: BTreeSet<&str> = all.iter().map(|located| located.finding.id).collect();
        let mut rules = Self { list: Vec::new(), index: BTreeMap::new() };
        for rule in lint::RULES {
            let mut value = descriptor(rule.id, rule.summary, rule.doc.trim_end());
            value["defaultConfiguration"] = json!({
                "enabled": rule.level != Level::Allow,
                "level": if rule.level == Level::Deny { "error" } else { "warning" },
            });
            value["properties"] = json!({ "targets": rule.targets });
            rules.add(rule.id, value);
        }
        for code in CODES.iter().filter(|code| found.contains(code.id)) {
            let (first, rest) = code.doc.split_once('\n').unwrap_or((code.doc, ""));
            rules.add(code.id, descriptor(code.id, first, if rest.is_empty() { first } else { rest }));
        }
        rules
    }

    fn add(&mut self, id: &'static str, value: Value) {
        self.index.insert(id, self.list.len());
        self.list.push(value);
    }
}

fn descriptor(id: &str, summary: &str, page: &str) -> Value {
    json!({
        "id": id,
        "shortDescription": { "text": summary },
        "fullDescription": { "text": summary },
        "help": { "text": page, "markdown": page },
    })
}

fn result(located: &Located<'_>, rules: &Rules) -> Value {
    let Finding { id, severity, message, origin, label, labels, notes, help, suppression, fixable: _, fix } =
        &located.finding;
    let mut value = Map::new();
    value.insert("ruleId".to_owned(), json!(id));
    if let Some(index) = rules.index.get(id) {
        value.insert("ruleIndex".to_owned(), json!(index));
    }
    value.insert("level".to_owned(), json!(level(id, *severity)));
    let mut text = format!("{message}{}.", if label.is_empty() { String::new() } else { format!(": {label}") });
    let mut places = Vec::new();
    match origin {
        Origin::Text(span) => places.push(json!({ "physicalLocation": physical(located, *span) })),
        Origin::File { path, place } => {
            let mut physical = json!({ "artifactLocation": artifact(&located.path(path)) });
            if let Some(region) = region_of(place) {
                physical["region"] = region;
            } else if !place.is_empty() {
                text.push_str(&format!(" ({place})"));
            }
            places.push(json!({ "physicalLocation": physical }));
        }
        Origin::Made => {}
    }
    for note in notes {
        text.push_str(&format!("\nnote: {note}"));
    }
    if let Some(help) = help {
        text.push_str(&format!("\nhelp: {help}"));
    }
    value.insert("message".to_owned(), json!({ "text": text }));
    value.insert("locations".to_owned(), json!(places));
    if !labels.is_empty() {
        let related = labels.iter().enumerate().map(|(at, label)| {
            json!({ "id": at, "physicalLocation": physical(located, label.span), "message": { "text": label.text } })
        });
        value.insert("relatedLocations".to_owned(), related.collect());
    }
    if let Some(fix) = fix {
        value.insert("fixes".to_owned(), json!([fixed(located, fix)]));
    }
    if let Some(suppression) = suppression {
        let place = json!({ "physicalLocation": physical(located, suppression.span) });
        let justification = &suppression.reason;
        value.insert(
            "suppressions".to_owned(),
            json!([{ "kind": "inSource", "justification": justification, "location": place }]),
        );
    } else if *severity == Severity::Allow {
        value.insert("suppressions".to_owned(), json!([{ "kind": "external" }]));
    }
    Value::Object(value)
}

/// A fix, its edits by file.
fn fixed(located: &Located<'_>, fix: &Fix) -> Value {
    let mut files: BTreeMap<String, Vec<Value>> = BTreeMap::new();
    for edit in &fix.edits {
        let path = located.path(&located.sources.get(edit.span.file).path);
        let replacement =
            json!({ "deletedRegion": region(located, edit.span), "insertedContent": { "text": edit.text } });
        files.entry(path).or_default().push(replacement);
    }
    let changes = files
        .iter()
        .map(|(path, replacements)| json!({ "artifactLocation": artifact(path), "replacements": replacements }));
    json!({ "description": { "text": fix.title }, "artifactChanges": changes.collect::<Vec<_>>() })
}

/// The level; that of the rule where the finding is suppressed.
fn level(id: &str, severity: Severity) -> &'static str {
    match severity {
        Severity::Error | Severity::Deny => "error",
        Severity::Warn => "warning",
        Severity::Info => "note",
        Severity::Allow => match lint::find(id).map(|rule| rule.level) {
            Some(Level::Deny) => "error",
            Some(Level::Warn) => "warning",
            Some(Level::Allow) | None => "note",
        },
    }
}

fn physical(located: &Located<'_>, span: Span) -> Value {
    let path = located.path(&located.sources.get(span.file).path);
    json!({ "artifactLocation": artifact(&path), "region": region(located, span) })
}

fn region(located: &Located<'_>, span: Span) -> Value {
    let [line, column, end_line, end_column] = located.lines(span);
    json!({ "startLine": line, "startColumn": column, "endLine": end_line, "endColumn": end_column })
}

/// A place in words: "line 7", "byte 120".
fn region_of(place: &str) -> Option<Value> {
    let (word, number) = place.split_once(' ')?;
    let number: u64 = number.parse().ok()?;
    match word {
        "line" if number > 0 => Some(json!({ "startLine": number })),
        "byte" => Some(json!({ "byteOffset": number, "byteLength": 0 })),
        _ => None,
    }
}

/// The path of the finding's file.
fn path(located: &Located<'_>) -> Option<String> {
    match &located.finding.origin {
        Origin::Text(span) => Some(located.path(&located.sources.get(span.file).path)),
        Origin::File { path, place: _ } => Some(located.path(path)),
        Origin::Made => None,
    }
}

/// A path as a reference that a URI is made from; an absolute one has no base.
fn artifact(path: &str) -> Value {
    let uri = percent(path);
    if path.starts_with('/') {
        return json!({ "uri": format!("file://{uri}") });
    }
    json!({ "uri": uri, "uriBaseId": BASE })
}

/// A path with what a URI cannot hold written as `%XX` (RFC 3986, `pchar` without `:` and `@`, and `/`).
fn percent(path: &str) -> String {
    let mut text = String::with_capacity(path.len());
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~!$&'()*+,;=/".contains(&byte) {
            text.push(char::from(byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_references() {
        assert_eq!(artifact("a b/é#1.lts"), json!({ "uri": "a%20b/%C3%A9%231.lts", "uriBaseId": "%SRCROOT%" }));
        assert_eq!(artifact("/a:b"), json!({ "uri": "file:///a%3Ab" }));
    }

    #[test]
    fn places_in_words_become_regions() {
        assert_eq!(region_of("line 7"), Some(json!({ "startLine": 7 })));
        assert_eq!(region_of("byte 0"), Some(json!({ "byteOffset": 0, "byteLength": 0 })));
        assert_eq!(region_of("/materials/0/name"), None);
        assert_eq!(region_of("line 0"), None);
    }
}
