//! Configurations of the thesis's tool, which are Python, as evaluations of ours. Nothing is run.

use std::collections::{BTreeMap, BTreeSet};

use ltsc_core::diag::{FileId, Finding, Span};
use ltsc_core::formats;

use super::model::{At, Parameter, Source, Value};
use super::python::{self, Python};
use super::reader::near;
use super::statement::not_three;
use super::written::{Overriding, Parameters, Written, WrittenCase, WrittenOutput, WrittenRenderer, WrittenScene};
use crate::command::split;

/// What the tool asks of a configuration.
const NAMES: [&str; 5] = ["configuration", "scenes", "renderers", "parameter_sets", "test_cases"];

/// Those of them that may be left out.
const OPTIONAL: [&str; 1] = ["parameter_sets"];

/// Reads a configuration; what cannot be read is listed.
#[must_use]
pub fn read(file: FileId, text: &str) -> (Written, Vec<Finding>) {
    let said = python::read(file, text);
    let mut reading = Reading { findings: Vec::new(), typed: BTreeMap::new(), paths: None };
    for (span, why) in &said.unread {
        reading.findings.push(
            Finding::warn("lteval-unread", *span, format!("this could not be read: {why}"))
                .help("a configuration is read as literals, and nothing is run; write the value itself"),
        );
    }
    let mut written = Written::default();
    for name in NAMES {
        match said.names.get(name) {
            Some(value) => reading.part(name, value, &mut written),
            None if OPTIONAL.contains(&name) => {}
            None => {
                let message = format!("the configuration has no `{name}` that could be read");
                reading.findings.push(Finding::error("evaluation-missing", Span::new(file, 0, 0), message));
            }
        }
    }
    if let Some(span) = reading.paths {
        reading.findings.push(
            Finding::warn("lteval-paths", span, "relative paths were those below the folder of lteval")
                .help("an evaluation sees them from its own folder: change them, or put the file there"),
        );
    }
    let typed = std::mem::take(&mut reading.typed);
    for (_, set) in &mut written.sets {
        untype(set, &typed);
    }
    for case in &mut written.cases {
        untype(&mut case.all.parameters, &typed);
    }
    reading.findings.sort_by_key(|finding| finding.origin.span());
    (written, reading.findings)
}

/// The types that each parameter of a statement has anywhere in a configuration.
type Typed = BTreeMap<(String, String), BTreeSet<String>>;

struct Reading {
    findings: Vec<Finding>,
    typed: Typed,
    /// Where a relative path stands first.
    paths: Option<Span>,
}

type Entries<'v> = Vec<(At<&'v str>, &'v At<Python>)>;

impl Reading {
    fn error(&mut self, id: &'static str, span: Span, message: impl Into<String>) {
        self.findings.push(Finding::error(id, span, message));
    }

    fn mismatch(&mut self, what: &str, takes: &str, value: &At<Python>) {
        self.error("evaluation-type", value.span, format!("`{what}` takes {takes}, not {}", value.value.kind()));
    }

    fn part(&mut self, name: &str, value: &At<Python>, written: &mut Written) {
        match name {
            "configuration" => self.configuration(value, written),
            "scenes" => {
                let scenes = self.list("scenes", value).iter().filter_map(|scene| self.text("scenes", scene));
                let scene = |name: At<String>| WrittenScene {
                    source: At::new(Source::Name(name.value), name.span),
                    name: None,
                    set: Vec::new(),
                    camera: None,
                    reference: None,
                };
                written.scenes = Some(At::new(scenes.map(scene).collect(), value.span));
            }
            "renderers" => {
                for (name, renderer) in self.entries("renderers", value) {
                    written.renderers.extend(self.renderer(name, renderer));
                }
            }
            "parameter_sets" => {
                for (name, set) in self.entries("parameter_sets", value) {
                    let parameters = self.parameters(set);
                    written.sets.push((At::new(name.value.to_owned(), name.span), parameters));
                }
            }
            _ => {
                for case in self.list("test_cases", value) {
                    written.cases.extend(self.case(case));
                }
            }
        }
    }

    fn entries<'v>(&mut self, what: &str, value: &'v At<Python>) -> Entries<'v> {
        let Python::Dict(entries) = &value.value else {
            self.mismatch(what, "a dictionary", value);
            return Vec::new();
        };
        let mut found = Vec::new();
        for (key, value) in entries {
            match &key.value {
                Python::Text(text) => found.push((At::new(text.as_str(), key.span), value)),
                _ => self.error("evaluation-type", key.span, format!("a name of `{what}` is {}", key.value.kind())),
            }
        }
        found
    }

    fn list<'v>(&mut self, what: &str, value: &'v At<Python>) -> &'v [At<Python>] {
        match &value.value {
            Python::List(values) => values,
            _ => {
                self.mismatch(what, "a list", value);
                &[]
            }
        }
    }

    fn text(&mut self, what: &str, value: &At<Python>) -> Option<At<String>> {
        match &value.value {
            Python::Text(text) => Some(At::new(text.clone(), value.span)),
            _ => {
                self.mismatch(what, "a string", value);
                None
            }
        }
    }

    /// What Python takes for true.
    fn switch(&mut self, what: &str, value: &At<Python>) -> Option<bool> {
        match &value.value {
            Python::Bool(value) => Some(*value),
            Python::None => Some(false),
            Python::Int(value) => Some(*value != 0),
            _ => {
                self.mismatch(what, "`True` or `False`", value);
                None
            }
        }
    }

    fn unknown(&mut self, what: &str, key: &At<&str>, known: &[&str]) {
        let message = format!("{what} has no key `{}`", key.value);
        let mut finding = Finding::warn("lteval-unread", key.span, message);
        finding.help = near(key.value, known.iter().copied());
        self.findings.push(finding);
    }

    /// A path; the first relative one is remembered.
    fn path(&mut self, what: &str, value: &At<Python>) -> Option<At<String>> {
        let path = self.text(what, value)?;
        let absolute = path.value.starts_with(['/', '\\']) || path.value.as_bytes().get(1) == Some(&b':');
        if !absolute && self.paths.is_none() {
            self.paths = Some(path.span);
        }
        Some(path)
    }

    fn configuration(&mut self, value: &At<Python>, written: &mut Written) {
        let known = ["name", "description", "output_dir", "output_dir_date", "webpage_generate", "webpage_display"];
        let mut output = WrittenOutput::default();
        for (key, value) in self.entries("configuration", value) {
            match key.value {
                "name" => written.name = self.text("name", value).filter(|name| !name.value.is_empty()),
                "description" => written.description = self.text("description", value),
                "output_dir" => output.folder = self.path("output_dir", value),
                "output_dir_date" => output.dated = self.switch("output_dir_date", value),
                "webpage_generate" => output.page = self.switch("webpage_generate", value),
                "webpage_display" => output.display = self.switch("webpage_display", value),
                _ => self.unknown("`configuration`", &key, &known),
            }
        }
        written.output = output;
    }

    fn renderer(&mut self, name: At<&str>, value: &At<Python>) -> Option<WrittenRenderer> {
        let (mut target, mut path, mut options) = (None, None, Vec::new());
        for (key, value) in self.entries("renderers", value) {
            match key.value {
                "type" => target = self.text("type", value),
                "path" => path = self.path("path", value),
                "options" if value.value == Python::None => {}
                "options" => match self.text("options", value).map(|line| split(&line.value)) {
                    Some(Ok(words)) => options = words,
                    Some(Err(problem)) => self.error("evaluation-value", value.span, format!("`options`: {problem}")),
                    None => {}
                },
                _ => self.unknown("a renderer", &key, &["type", "path", "options"]),
            }
        }
        let Some(kind) = target else {
            self.error("evaluation-missing", name.span, format!("the renderer `{}` has no `type`", name.value));
            return None;
        };
        let target = target_of(&kind.value);
        if formats::find(&target).is_none() {
            let known = formats::TARGETS.iter().map(|target| target.name);
            let mut finding = Finding::error(
                "evaluation-name",
                kind.span,
                format!("there is no renderer of the type `{}`", kind.value),
            );
            finding.help = near(&target, known);
            self.findings.push(finding);
        }
        let name = At::new(name.value.to_owned(), name.span);
        let target = Some(At::new(target, kind.span));
        Some(WrittenRenderer {
            name,
            target,
            path,
            options,
            command: None,
            threads: None,
            timeout: None,
            manual: false,
        })
    }

    fn case(&mut self, value: &At<Python>) -> Option<WrittenCase> {
        let (mut name, mut description, mut renderer, mut parameters) = (None, None, None, Parameters::default());
        for (key, value) in self.entries("test_cases", value) {
            match key.value {
                "name" => name = self.text("name", value),
                "description" => description = self.text("description", value),
                "renderer" => renderer = self.text("renderer", value),
                "params" => parameters = self.parameters(value),
                _ => self.unknown("a test case", &key, &["name", "description", "renderer", "params"]),
            }
        }
        for (key, missing) in [("name", name.is_none()), ("renderer", renderer.is_none())] {
            if missing && matches!(value.value, Python::Dict(_)) {
                self.error("evaluation-missing", value.span, format!("a test case has no `{key}`"));
            }
        }
        let all = Overriding { parameters, ..Overriding::default() };
        let renderers = vec![renderer?];
        Some(WrittenCase {
            name: name?,
            description,
            renderers,
            scenes: None,
            all,
            one: Vec::new(),
            reference: None,
            span: value.span,
        })
    }

    fn parameters(&mut self, value: &At<Python>) -> Parameters {
        let mut found = Parameters::default();
        for (key, value) in self.entries("a parameter set", value) {
            if key.value == "base" {
                found.base = self.list("base", value).iter().filter_map(|base| self.text("base", base)).collect();
                continue;
            }
            let list = self.list(key.value, value);
            let parameters = list.iter().filter_map(|parameter| self.parameter(key.value, parameter)).collect();
            found.statements.push((At::new(key.value.to_owned(), key.span), parameters));
        }
        found
    }

    fn parameter(&mut self, statement: &str, value: &At<Python>) -> Option<Parameter> {
        let Python::List(words) = &value.value else {
            self.findings.push(
                Finding::error(
                    "evaluation-parameter",
                    value.span,
                    format!("a parameter of `{statement}` is a list, not {}", value.value.kind()),
                )
                .help("write `[[name, type, value]]`: a list of parameters, each a list itself"),
            );
            return None;
        };
        let [name, kind, given] = words.as_slice() else {
            self.findings.push(not_three(words.len(), value.span, statement));
            return None;
        };
        let (name, kind) = (self.text("the name of a parameter", name)?, self.text("the type of a parameter", kind)?);
        let given = self.value(given)?;
        self.typed.entry((statement.to_owned(), name.value.clone())).or_default().insert(kind.value.clone());
        Some(Parameter { name: name.value, kind: Some(kind.value), value: given, span: value.span })
    }

    fn value(&mut self, value: &At<Python>) -> Option<Value> {
        Some(match &value.value {
            Python::Bool(value) => Value::Bool(*value),
            Python::Int(value) => Value::Integer(*value),
            Python::Float(value) => Value::Float(*value),
            Python::Text(text) => Value::String(text.clone()),
            Python::List(values) if !values.is_empty() => {
                let values: Vec<Option<Value>> = values.iter().map(|value| self.value(value)).collect();
                Value::List(values.into_iter().collect::<Option<_>>()?)
            }
            Python::List(_) => {
                self.error("evaluation-value", value.span, "the list is empty");
                return None;
            }
            Python::None | Python::Dict(_) => {
                self.mismatch("the value of a parameter", "a boolean, a number, a string or a list of them", value);
                return None;
            }
        })
    }
}

/// The target of a type of the thesis's tool: `mitsuba_0_5` is `mitsuba-0.5`, `pbrt_3` is `pbrt-v3`.
fn target_of(kind: &str) -> String {
    let version = |rest: &str| rest.replace('_', ".");
    if let Some(rest) = kind.strip_prefix("mitsuba_") {
        return format!("mitsuba-{}", version(rest));
    }
    if let Some(rest) = kind.strip_prefix("pbrt_") {
        return format!("pbrt-v{}", version(rest.trim_start_matches('v')));
    }
    kind.replace('_', "-")
}

/// Leaves out the types that follow from the values, where a parameter has this type everywhere.
fn untype(parameters: &mut Parameters, typed: &Typed) {
    for (statement, parameters) in &mut parameters.statements {
        for parameter in parameters {
            let key = (statement.value.clone(), parameter.name.clone());
            let one = typed.get(&key).is_some_and(|kinds| kinds.len() == 1);
            let follows = match (&parameter.value, parameter.kind.as_deref()) {
                (Value::Bool(_), Some("boolean" | "bool"))
                | (Value::Integer(_), Some("integer"))
                | (Value::Float(_), Some("float"))
                | (Value::String(_), Some("string")) => true,
                (Value::Bool(_) | Value::Integer(_) | Value::Float(_) | Value::String(_) | Value::List(_), _) => false,
            };
            if one && follows && parameter.name != "type" {
                parameter.kind = None;
            }
        }
    }
}
