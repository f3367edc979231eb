//! Findings as GitHub's workflow commands, which become annotations of a commit.
//!
//! `::error file=..,line=..,endLine=..,col=..,endColumn=..,title=..::message`; columns only within one line, since an
//! annotation over several lines has none.

use ltsc_core::diag::{Finding, Origin, Severity};

use crate::terminal::harmless;

use super::{Failure, Located};

/// One finding.
pub fn line(located: &Located<'_>) -> String {
    let Finding { id, severity, message, origin, label, labels: _, notes, help, suppression: _, fixable: _, fix: _ } =
        &located.finding;
    let word = match severity {
        Severity::Error | Severity::Deny => "error",
        Severity::Warn => "warning",
        Severity::Info | Severity::Allow => "notice",
    };
    let mut properties = Vec::new();
    let mut text = message.clone();
    match origin {
        Origin::Text(span) => {
            let [line, column, end_line, end_column] = located.lines(*span);
            properties.push(("file", located.path(&located.sources.get(span.file).path)));
            properties.push(("line", line.to_string()));
            properties.push(("endLine", end_line.to_string()));
            if line == end_line {
                properties.push(("col", column.to_string()));
                properties.push(("endColumn", end_column.to_string()));
            }
        }
        Origin::File { path, place } => {
            properties.push(("file", located.path(path)));
            if !place.is_empty() {
                text.push_str(&format!(" ({place})"));
            }
        }
        Origin::Made => {}
    }
    properties.push(("title", (*id).to_owned()));
    if !label.is_empty() {
        text.push_str(&format!(": {label}"));
    }
    for note in notes {
        text.push_str(&format!("\nnote: {note}"));
    }
    if let Some(help) = help {
        text.push_str(&format!("\nhelp: {help}"));
    }
    command(word, &properties, &text)
}

/// A command that could not do its work.
pub fn failure(failure: &Failure) -> String {
    let help = failure.help.as_ref().map_or(String::new(), |help| format!("\nhelp: {help}"));
    command("error", &[("title", "ltsc".to_owned())], &format!("{}{help}", failure.message))
}

fn command(word: &str, properties: &[(&str, String)], text: &str) -> String {
    let list: Vec<String> = properties.iter().map(|(name, value)| format!("{name}={}", property(value))).collect();
    format!("::{word} {}::{}\n", list.join(","), data(text))
}

/// Text behind the second `::`, escaped as `@actions/core` does.
fn data(text: &str) -> String {
    harmless(text).replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// The value of a property.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_end_a_command_is_escaped() {
        let properties = [("file", "a,b:c%.lts".to_owned()), ("title", "x\ny".to_owned())];
        assert_eq!(
            command("warning", &properties, "50 %, a::b\r\nnext\x1b[0m"),
            "::warning file=a%2Cb%3Ac%25.lts,title=x%0Ay::50 %25, a::b%0D%0Anext?[0m\n"
        );
    }
}
