//! Native statements: how they are written, and how those of several parameter sets become one.

use ltsc_core::diag::Finding;
use ltsc_core::formats::statements::replaced;

use super::model::{At, Parameter, Statement, Value};
use super::reader::{Item, Reader, Table};
use super::written::Parameters;

/// The parameter that is the type of its statement.
const TYPE: &str = "type";

/// `base` and statements.
pub(super) fn parameters(mut table: Table<'_>, reader: &mut Reader) -> Parameters {
    let base = table.take("base").map(|item| item.words(reader)).unwrap_or_default();
    let mut statements = Vec::new();
    for (name, item) in table.rest() {
        if let Some(parameters) = statement(&item, reader) {
            statements.push((At::new(name.value.to_owned(), name.span), parameters));
        }
    }
    Parameters { base, statements }
}

/// The parameters of a statement: a table, or a list of triples and tables.
fn statement(item: &Item<'_>, reader: &mut Reader) -> Option<Vec<Parameter>> {
    let mut found = Vec::new();
    if let Some(table) = item.as_table(reader, "a statement") {
        plain(table, reader, &mut found);
        return Some(found);
    }
    let Some(list) = item.as_list(reader) else {
        reader.mismatch(item, "a table, or a list of `[name, type, value]`");
        let shown = item.as_str().map_or_else(|| "...".to_owned(), |text| format!("{text:?}"));
        if let Some(found) = reader.findings.last_mut() {
            found.help = Some(format!("write `{} = {{ type = {shown} }}`", item.name));
        }
        return None;
    };
    // The commonest slip: one parameter in the place of a list of parameters.
    if list.first().is_some_and(|first| first.as_str().is_some()) {
        let message = format!("`{}` takes a list of parameters, not one parameter", item.name);
        reader.error("evaluation-parameter", item.span, message).help =
            Some("put it into brackets of its own: `[[name, type, value]]`".to_owned());
        return None;
    }
    for element in &list {
        if let Some(table) = element.as_table(reader, "a statement") {
            plain(table, reader, &mut found);
        } else if let Some(words) = element.as_list(reader) {
            found.extend(triple(element, &words, reader));
        } else {
            reader.mismatch(element, "parameters of the form `[name, type, value]`");
        }
    }
    Some(found)
}

/// The parameters of a table: the type follows from the value.
fn plain(mut table: Table<'_>, reader: &mut Reader, found: &mut Vec<Parameter>) {
    for (name, item) in table.rest() {
        let kind = (name.value == TYPE).then(String::new);
        if let Some(value) = value(&item, reader) {
            found.push(Parameter { name: name.value.to_owned(), kind, value, span: name.span.to(item.span) });
        }
    }
}

/// What is wrong with a parameter of another length than three.
pub(super) fn not_three(count: usize, place: ltsc_core::diag::Span, statement: &str) -> Finding {
    let message =
        format!("a parameter of `{statement}` has the form `[name, type, value]`, and this one has {count} of three");
    let help = match count {
        2 => {
            "say the type too: `[\"maxDepth\", \"integer\", 10]`; that of the statement's own `type` is empty: `[\"type\", \"\", \"path\"]`"
        }
        count if count > 3 => "put several values into a list of their own: `[\"range\", \"integer\", [1, 2]]`",
        _ => "write for example `[\"maxDepth\", \"integer\", 10]`",
    };
    Finding::error("evaluation-parameter", place, message).help(help)
}

fn triple(element: &Item<'_>, words: &[Item<'_>], reader: &mut Reader) -> Option<Parameter> {
    let [name, kind, given] = words else {
        reader.findings.push(not_three(words.len(), element.span, &element.name));
        return None;
    };
    let (Some(name), Some(kind)) = (name.as_str(), kind.as_str()) else {
        let wrong = if name.as_str().is_none() { ("name", name) } else { ("type", kind) };
        let message = format!("the {} of a parameter is a string, not {}", wrong.0, wrong.1.kind());
        reader.error("evaluation-parameter", wrong.1.span, message);
        return None;
    };
    let value = value(given, reader)?;
    Some(Parameter { name: name.to_owned(), kind: Some(kind.to_owned()), value, span: element.span })
}

fn value(item: &Item<'_>, reader: &mut Reader) -> Option<Value> {
    if let Some(text) = item.as_str() {
        return Some(Value::String(text.to_owned()));
    }
    if let Some(value) = item.as_bool() {
        return Some(Value::Bool(value));
    }
    if item.is_int() {
        let value = item.as_int();
        if value.is_none() {
            reader.error("evaluation-value", item.span, "the integer has more than 64 bits");
        }
        return value.map(Value::Integer);
    }
    if let Some(value) = item.as_float() {
        if !value.is_finite() {
            reader.error("evaluation-value", item.span, "the number is not finite").help =
                Some("a renderer's own word for it is a string".to_owned());
            return None;
        }
        return Some(Value::Float(value));
    }
    if let Some(list) = item.as_list(reader) {
        if list.is_empty() {
            reader.error("evaluation-value", item.span, format!("the list `{}` is empty", item.name));
            return None;
        }
        let values: Vec<Option<Value>> = list.iter().map(|element| value(element, reader)).collect();
        return values.into_iter().collect::<Option<_>>().map(Value::List);
    }
    reader.mismatch(item, "a boolean, a number, a string or a list of them");
    if item.as_table(reader, "").is_some()
        && let Some(found) = reader.findings.last_mut()
    {
        found.help = Some("a name with points is written in quotes: `\"path.maxdepth\" = 10`".to_owned());
    }
    None
}

/// Puts parameters into the place of those that they replace, and others behind them. One without a type has that of the one before.
pub(super) fn merge(into: &mut Vec<Parameter>, parameters: &[Parameter]) {
    for parameter in parameters {
        let known = into.iter().map(|known| (known.name.as_str(), known.kind.as_deref()));
        match replaced(known, &parameter.name, parameter.kind.as_deref()) {
            Some(at) => {
                let kind = parameter.kind.clone().or_else(|| into[at].kind.take());
                into[at] = Parameter { kind, ..parameter.clone() };
            }
            None => into.push(parameter.clone()),
        }
    }
}

/// Merges statements into those that are inherited.
pub(super) fn merge_statements(into: &mut Vec<Statement>, statements: &[Statement]) {
    for statement in statements {
        match into.iter_mut().find(|known| known.name == statement.name) {
            Some(known) => merge(&mut known.parameters, &statement.parameters),
            None => {
                let mut parameters = Vec::new();
                merge(&mut parameters, &statement.parameters);
                into.push(Statement { name: statement.name.clone(), parameters });
            }
        }
    }
}
