//! The renderers of an evaluation: those that are declared, and drivers and targets by their own names.

use ltsc_core::diag::Span;
use ltsc_core::formats::{self, TARGETS, Target};
use ltsc_render::run::{DRIVERS, Driver, driver};

use super::model::{At, Renderer};
use super::reader::near;
use super::resolve::Findings;
use super::written::WrittenRenderer;
use crate::command::Command;

/// The renderers so far.
pub(super) struct Renderers {
    /// Each with whether a case names it; none for one that is declared wrongly.
    known: Vec<(At<String>, Option<Renderer>, bool)>,
}

/// What a name stands for: a driver, or a target with the driver that reads it, if one does.
fn find(name: &str) -> Option<(&'static Target, Option<&'static Driver>)> {
    if let Some(driver) = driver(name) {
        return formats::find(driver.target).map(|target| (target, Some(driver)));
    }
    let target = formats::find(name)?;
    let of_target = DRIVERS.iter().copied().find(|driver| driver.target == target.name);
    Some((target, of_target))
}

fn names<'a>() -> impl Iterator<Item = &'a str> {
    let targets = TARGETS.iter().map(|target| -> &'a str { target.name });
    DRIVERS.iter().map(|driver| -> &'a str { driver.name }).chain(targets.filter(|name| driver(name).is_none()))
}

impl Renderers {
    /// Those that the file declares.
    pub fn declared(written: &[WrittenRenderer], findings: &mut Findings) -> Self {
        let mut known: Vec<(At<String>, Option<Renderer>, bool)> = Vec::new();
        for renderer in written {
            if let Some((first, _, _)) = known.iter().find(|(name, _, _)| *name == renderer.name) {
                let first = ltsc_core::diag::Label { span: first.span, text: "the first one".to_owned() };
                let message = format!("there are two renderers `{}`", renderer.name.value);
                findings.error("evaluation-duplicate", renderer.name.span, message).labels = vec![first];
                continue;
            }
            known.push((renderer.name.clone(), declare(renderer, findings), false));
        }
        Self { known }
    }

    /// The number of the renderer that a case names; one that is not declared has the name of a driver or target.
    pub fn named(&mut self, name: &At<String>, findings: &mut Findings) -> Option<usize> {
        if let Some(at) = self.known.iter().position(|(known, _, _)| known == name) {
            self.known[at].2 = true;
            return self.known[at].1.is_some().then_some(at);
        }
        if find(&name.value).is_none() {
            let declared: Vec<String> = self.known.iter().map(|(name, _, _)| name.value.clone()).collect();
            let help = near(&name.value, declared.iter().map(String::as_str).chain(names()));
            let message = format!("there is no renderer `{}`", name.value);
            findings.error("evaluation-name", name.span, message).help = help;
            return None;
        }
        let written = WrittenRenderer {
            name: name.clone(),
            target: None,
            path: None,
            options: Vec::new(),
            command: None,
            threads: None,
            timeout: None,
            manual: false,
        };
        let made = declare(&written, findings);
        let there = made.is_some();
        self.known.push((name.clone(), made, true));
        there.then(|| self.known.len() - 1)
    }

    /// All of them; those that no case names are said. The numbers stay where all are well.
    pub fn finish(self, findings: &mut Findings) -> Vec<Renderer> {
        for (name, _, used) in &self.known {
            if !used {
                let message = format!("no case names the renderer `{}`", name.value);
                findings.warn("evaluation-unused", name.span, message);
            }
        }
        // A wrong one is an error, so that nothing is rendered; a stand-in keeps the numbers of the others.
        self.known.into_iter().map(|(name, made, _)| made.unwrap_or_else(|| stand_in(name.span))).collect()
    }
}

/// A renderer in the place of one that is declared wrongly.
fn stand_in(span: Span) -> Renderer {
    Renderer {
        name: String::new(),
        target: &TARGETS[0],
        driver: None,
        path: None,
        options: Vec::new(),
        command: None,
        threads: None,
        timeout: None,
        manual: false,
        span,
    }
}

fn declare(written: &WrittenRenderer, findings: &mut Findings) -> Option<Renderer> {
    let WrittenRenderer { name, target: asked, path, options, command, threads, timeout, manual } = written;
    let Some((target, driver)) = find(&asked.as_ref().unwrap_or(name).value) else {
        match asked {
            Some(asked) => findings.unknown("target or renderer", asked, names()),
            None => {
                let message = format!("the renderer `{}` has no `target`", name.value);
                findings.error("evaluation-missing", name.span, message).help = Some(format!(
                    "write for example `target = \"mitsuba-3\"`; known: {}",
                    names().collect::<Vec<_>>().join(", ")
                ));
            }
        }
        return None;
    };
    let place = asked.as_ref().unwrap_or(name).span;
    let command = match command {
        None => None,
        Some(words) => match Command::new(&words.value) {
            Ok(command) => Some(At::new(command, words.span)),
            Err((message, help)) => {
                findings.error("evaluation-value", words.span, message).help = help;
                return None;
            }
        },
    };
    if *manual && (path.is_some() || command.is_some() || !options.is_empty()) {
        let message = format!("the renderer `{}` is `manual`, so that no program of it is run", name.value);
        findings.error("evaluation-value", name.span, message).help =
            Some("leave out `path`, `options` and `command`, or `manual`".to_owned());
        return None;
    }
    match (&command, driver) {
        (None, None) if *manual => {}
        (None, None) => {
            let message = format!("no renderer of ltsc reads `{}`", target.name);
            findings.error("evaluation-name", place, message).help = Some(
                "say how a program is called: `command = \"{exe} {options} -o {out} {scene}\"`, or `manual = true`"
                    .to_owned(),
            );
            return None;
        }
        (Some(command), None) if command.value.uses("exe") && path.is_none() => {
            let message = format!("the renderer `{}` has no `path` for the `{{exe}}` of its command", name.value);
            findings.error("evaluation-missing", command.span, message);
            return None;
        }
        (Some(command), _) if !options.is_empty() && !command.value.uses("options") => {
            findings.error("evaluation-value", command.span, "the command has no `{options}`, and there are some");
            return None;
        }
        _ => {}
    }
    Some(Renderer {
        name: name.value.clone(),
        target,
        driver,
        path: path.clone(),
        options: options.clone(),
        command,
        threads: threads.map(|threads| threads.value),
        timeout: timeout.map(|timeout| timeout.value),
        manual: *manual,
        span: name.span,
    })
}
