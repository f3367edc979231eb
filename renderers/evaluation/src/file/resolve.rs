//! From what a file says to what is rendered: names are looked up, bases merged, sweeps and the matrix multiplied out.

use std::collections::{BTreeMap, BTreeSet};

use ltsc_core::diag::{FileId, Finding, Severity, Span};

use super::compare;
use super::model::{
    At, Case, Condition, Evaluation, Output, ParameterSet, Reference, Renderer, Run, SceneRef, Settings, Source,
    Statement, Variant,
};
use super::reader::near;
use super::renderer::Renderers;
use super::statement::merge_statements;
use super::surroundings::Surroundings;
use super::translate;
use super::written::{MOST_RUNS, Parameters, Written, WrittenCase, WrittenScene};

/// With fewer chunks the variance of an image is not known well enough for a verdict.
pub const LEAST_CHUNKS: u32 = 4;

/// The most parameters that sets and cases may have, with all that they inherit.
const MOST_PARAMETERS: usize = 1_000_000;

/// Where findings go while names are looked up.
pub(super) struct Findings {
    /// What was found.
    pub found: Vec<Finding>,
}

impl Findings {
    /// Says what is wrong.
    pub fn error(&mut self, id: &'static str, span: Span, message: impl Into<String>) -> &mut Finding {
        self.push(Finding::error(id, span, message))
    }

    /// Says what should be looked at.
    pub fn warn(&mut self, id: &'static str, span: Span, message: impl Into<String>) -> &mut Finding {
        self.push(Finding::warn(id, span, message))
    }

    fn push(&mut self, finding: Finding) -> &mut Finding {
        // What several renderers or scenes have in common is said once.
        let known = self.found.iter().position(|other| *other == finding);
        let at = known.unwrap_or(self.found.len());
        if known.is_none() {
            self.found.push(finding);
        }
        &mut self.found[at]
    }

    /// Says that there is nothing of this name.
    pub fn unknown<'a>(&mut self, what: &str, name: &At<String>, known: impl IntoIterator<Item = &'a str>) {
        let help = near(&name.value, known);
        self.error("evaluation-name", name.span, format!("there is no {what} `{}`", name.value)).help = help;
    }
}

/// Resolves what a file says, `whole` if reading it found no error. There is an evaluation only if nothing is wrong.
#[must_use]
pub fn resolve(
    written: &Written,
    file: FileId,
    stem: &str,
    surroundings: &dyn Surroundings,
    whole: bool,
) -> (Option<Evaluation>, Vec<Finding>) {
    let findings = &mut Findings { found: Vec::new() };
    let start = Span::new(file, 0, 0);
    let scenes = scenes(written, surroundings, findings);
    let mut renderers = Renderers::declared(&written.renderers, findings);
    let mut sets = Sets::resolve(&written.sets, findings);
    let cases: Vec<Option<Case>> =
        written.cases.iter().map(|case| self::case(case, written, &mut renderers, &mut sets, findings)).collect();
    duplicates(written.cases.iter().map(|case| &case.name), "case", findings);
    sets.unused(findings);
    let renderers = renderers.finish(findings);
    let conditions = conditions(written, &scenes, surroundings, findings);
    let complete = cases.iter().all(Option::is_some);
    let cases: Vec<Case> = cases.into_iter().flatten().collect();
    let mut evaluation = Evaluation {
        name: written.name.as_ref().map_or_else(|| stem.to_owned(), |name| name.value.clone()),
        description: written.description.as_ref().map(|text| text.value.clone()).unwrap_or_default(),
        output: output(written),
        scenes,
        conditions,
        renderers,
        parameters: sets.finish(),
        cases,
        runs: Vec::new(),
        pairs: Vec::new(),
        tolerance: compare::tolerance(&written.compare),
        tiles: written.compare.tiles.map_or(8, |tiles| tiles.value),
    };
    let broken = |findings: &Findings| findings.found.iter().any(|finding| finding.severity == Severity::Error);
    matrix_names(&evaluation, written, findings);
    if complete {
        let sound = whole && !broken(findings);
        runs(&mut evaluation, written, start, sound, findings);
    }
    checks(&evaluation, surroundings, findings);
    compare::names(&evaluation, written, findings);
    if complete && whole && !broken(findings) {
        evaluation.pairs = compare::pairs(&evaluation, written, surroundings, findings);
    }
    let mut found = std::mem::take(&mut findings.found);
    found.sort_by_key(|finding| finding.origin.span());
    let fine = found.iter().all(|finding| finding.severity != Severity::Error);
    (fine.then_some(evaluation), found)
}

fn output(written: &Written) -> Output {
    let folder = written.output.folder.as_ref().map_or_else(|| "results".to_owned(), |folder| folder.value.clone());
    let display = written.output.display.unwrap_or(false);
    Output { folder, dated: written.output.dated.unwrap_or(true), page: written.output.page.unwrap_or(false), display }
}

/// Says which names stand twice.
fn duplicates<'a>(names: impl Iterator<Item = &'a At<String>>, what: &str, findings: &mut Findings) {
    let mut known: BTreeMap<&str, Span> = BTreeMap::new();
    for name in names {
        match known.get(name.value.as_str()) {
            Some(first) => {
                let message = format!("there are two {what}s `{}`", name.value);
                let first = ltsc_core::diag::Label { span: *first, text: "the first one".to_owned() };
                findings.error("evaluation-duplicate", name.span, message).labels = vec![first];
            }
            None => {
                known.insert(&name.value, name.span);
            }
        }
    }
}

/// The name of a file without folders and ending.
fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    name.rsplit_once('.').map_or(name, |(stem, _)| if stem.is_empty() { name } else { stem })
}

fn scenes(written: &Written, around: &dyn Surroundings, findings: &mut Findings) -> Vec<SceneRef> {
    let Some(list) = &written.scenes else { return Vec::new() };
    let mut found = Vec::new();
    let mut names = Vec::new();
    for WrittenScene { source, name, set, camera, reference } in &list.value {
        let own = match &source.value {
            Source::Name(name) => name.clone(),
            Source::File(path) => stem(path).to_owned(),
        };
        let name = name.clone().unwrap_or_else(|| At::new(own, source.span));
        if let Some(why) = around.missing(&source.value) {
            let known = around.scenes();
            let (Source::Name(text) | Source::File(text)) = &source.value;
            let help = near(text, known.iter().map(String::as_str));
            findings.error("evaluation-scene", source.span, why).help = help;
        } else if let Some(known) = around.parameters(&source.value) {
            for (parameter, _) in set.iter().filter(|(parameter, _)| !known.contains(&parameter.value)) {
                findings.unknown(
                    &format!("parameter of `{}` called", name.value),
                    parameter,
                    known.iter().map(String::as_str),
                );
            }
        }
        duplicates(set.iter().map(|(parameter, _)| parameter), "value", findings);
        found.push(SceneRef {
            name: name.value.clone(),
            source: source.value.clone(),
            set: set.iter().map(|(parameter, value)| (parameter.value.clone(), value.clone())).collect(),
            camera: camera.as_ref().map(|camera| camera.value.clone()),
            reference: reference.clone(),
            span: source.span,
        });
        names.push(name);
    }
    duplicates(names.iter(), "scene", findings);
    found
}

/// Scenes with the values of their sweeps.
fn conditions(
    written: &Written,
    scenes: &[SceneRef],
    around: &dyn Surroundings,
    findings: &mut Findings,
) -> Vec<Condition> {
    for sweep in &written.sweeps {
        for name in sweep.scenes.iter().flatten().filter(|name| !scenes.iter().any(|scene| scene.name == name.value)) {
            findings.unknown("scene", name, scenes.iter().map(|scene| scene.name.as_str()));
        }
    }
    let mut found = Vec::new();
    for (at, scene) in scenes.iter().enumerate() {
        let own = |names: &Option<Vec<At<String>>>| {
            names.as_ref().is_none_or(|names| names.iter().any(|name| name.value == scene.name))
        };
        let sweeps: Vec<_> = written.sweeps.iter().filter(|sweep| own(&sweep.scenes)).collect();
        duplicates(sweeps.iter().map(|sweep| &sweep.parameter), "sweep of the same scene over", findings);
        let known = around.parameters(&scene.source);
        let mut made =
            vec![Condition { name: scene.name.clone(), scene: at, set: scene.set.clone(), swept: Vec::new() }];
        for sweep in sweeps {
            if let Some(known) = known.as_ref().filter(|known| !known.contains(&sweep.parameter.value)) {
                let what = format!("parameter of `{}` called", scene.name);
                findings.unknown(&what, &sweep.parameter, known.iter().map(String::as_str));
            }
            if found.len() + made.len().saturating_mul(sweep.values.len()) > MOST_RUNS {
                findings.error(
                    "evaluation-value",
                    sweep.span,
                    format!("the sweeps have more than {MOST_RUNS} conditions"),
                );
                return Vec::new();
            }
            let parameter = &sweep.parameter.value;
            let with = |condition: Condition, value: &String| {
                let Condition { name, scene, mut set, mut swept } = condition;
                set.retain(|(name, _)| name != parameter);
                set.push((parameter.clone(), value.clone()));
                swept.push((parameter.clone(), value.clone()));
                Condition { name: format!("{name}, {parameter}={value}"), scene, set, swept }
            };
            made = made
                .into_iter()
                .flat_map(|condition| sweep.values.iter().map(move |value| with(condition.clone(), value)))
                .collect();
        }
        found.extend(made);
    }
    found
}

/// Parameter sets with what they inherit.
struct Sets {
    names: Vec<At<String>>,
    by_name: BTreeMap<String, usize>,
    statements: Vec<Vec<Statement>>,
    used: BTreeSet<usize>,
    size: usize,
}

/// The statements of a set itself, those of one name merged.
fn own(parameters: &Parameters) -> Vec<Statement> {
    let mut merged = Vec::new();
    for (name, parameters) in &parameters.statements {
        merge_statements(&mut merged, &[Statement { name: name.clone(), parameters: parameters.clone() }]);
    }
    merged
}

impl Sets {
    fn resolve(written: &[(At<String>, Parameters)], findings: &mut Findings) -> Self {
        let names: Vec<At<String>> = written.iter().map(|(name, _)| name.clone()).collect();
        duplicates(names.iter(), "parameter set", findings);
        let by_name = names.iter().enumerate().map(|(at, name)| (name.value.clone(), at)).collect();
        let mut sets =
            Self { names, by_name, statements: vec![Vec::new(); written.len()], used: BTreeSet::new(), size: 0 };
        let mut waiting: Vec<usize> = (0..written.len()).collect();
        let mut done = vec![false; written.len()];
        let bases: Vec<Vec<usize>> = written.iter().map(|(_, set)| sets.bases(set, findings)).collect();
        // Those whose bases are there, until none is left, or those that wait for each other.
        loop {
            let (ready, rest): (Vec<usize>, Vec<usize>) =
                waiting.iter().partition(|at| bases[**at].iter().all(|base| done[*base]));
            if ready.is_empty() {
                waiting = rest;
                break;
            }
            for at in ready {
                sets.statements[at] = sets.merged(&bases[at], &written[at].1, sets.names[at].span, findings);
                done[at] = true;
            }
            waiting = rest;
        }
        sets.cycles(&waiting, &bases, written, findings);
        sets
    }

    /// Each circle of sets, once.
    fn cycles(
        &self,
        waiting: &[usize],
        bases: &[Vec<usize>],
        written: &[(At<String>, Parameters)],
        findings: &mut Findings,
    ) {
        let mut seen = BTreeSet::new();
        for &start in waiting {
            let mut way: Vec<usize> = Vec::new();
            let mut at = start;
            while seen.insert(at) {
                way.push(at);
                let Some(next) = bases[at].iter().find(|base| waiting.contains(base)) else { break };
                at = *next;
            }
            let Some(from) = way.iter().position(|step| *step == at) else { continue };
            let circle: Vec<String> =
                way[from..].iter().chain([&at]).map(|step| format!("`{}`", self.names[*step].value)).collect();
            let base = written[at].1.base.first().map_or(self.names[at].span, |base| base.span);
            let message = format!("parameter sets are each other's `base` in a circle: {}", circle.join(", "));
            findings.error("evaluation-cycle", base, message);
        }
    }

    /// The sets that are named as bases; unknown ones are findings.
    fn bases(&mut self, parameters: &Parameters, findings: &mut Findings) -> Vec<usize> {
        let mut found = Vec::new();
        for base in &parameters.base {
            match self.by_name.get(&base.value) {
                Some(at) => {
                    self.used.insert(*at);
                    found.push(*at);
                }
                None => findings.unknown("parameter set", base, self.names.iter().map(|name| name.value.as_str())),
            }
        }
        found
    }

    /// The statements of bases and of a set itself, in this order.
    fn merged(
        &mut self,
        bases: &[usize],
        parameters: &Parameters,
        place: Span,
        findings: &mut Findings,
    ) -> Vec<Statement> {
        let mut merged = Vec::new();
        for base in bases {
            merge_statements(&mut merged, &self.statements[*base]);
        }
        merge_statements(&mut merged, &own(parameters));
        self.size += merged.iter().map(|statement| 1 + statement.parameters.len()).sum::<usize>();
        if self.size > MOST_PARAMETERS {
            let message = "parameter sets and cases have more than a million parameters with all that they inherit";
            findings.error("evaluation-value", place, message);
            return Vec::new();
        }
        merged
    }

    fn unused(&self, findings: &mut Findings) {
        for (at, name) in self.names.iter().enumerate().filter(|(at, _)| !self.used.contains(at)) {
            // A name that stands twice is an error of its own.
            if self.by_name.get(&name.value) == Some(&at) {
                let message = format!("the parameter set `{}` is not used", name.value);
                findings.warn("evaluation-unused", name.span, message);
            }
        }
    }

    fn finish(self) -> Vec<ParameterSet> {
        let sets = self.names.into_iter().zip(self.statements);
        sets.map(|(name, statements)| ParameterSet { name: name.value, statements, span: name.span }).collect()
    }
}

/// A case for each of its renderers; none where a renderer is unknown.
fn case(
    case: &WrittenCase,
    written: &Written,
    renderers: &mut Renderers,
    sets: &mut Sets,
    findings: &mut Findings,
) -> Option<Case> {
    let bases = sets.bases(&case.all.parameters, findings);
    let shared = sets.merged(&bases, &case.all.parameters, case.name.span, findings);
    let mut variants = Vec::new();
    let mut complete = true;
    duplicates(case.renderers.iter(), "renderer", findings);
    for (name, _) in case.one.iter().filter(|(name, _)| !case.renderers.iter().any(|own| own.value == name.value)) {
        let what = format!("renderer of the case `{}` called", case.name.value);
        findings.unknown(&what, name, case.renderers.iter().map(|own| own.value.as_str()));
    }
    for name in &case.renderers {
        let Some(renderer) = renderers.named(name, findings) else {
            complete = false;
            continue;
        };
        let over =
            case.one.iter().find(|(own, _)| own.value == name.value).map(|(_, over)| over.clone()).unwrap_or_default();
        let mut statements = shared.clone();
        let bases = sets.bases(&over.parameters, findings);
        merge_statements(&mut statements, &sets.merged(&bases, &over.parameters, name.span, findings));
        let settings: Settings = over.settings.over(&case.all.settings).over(&written.all.settings);
        let chunks = over.chunks.or(case.all.chunks).or(written.all.chunks);
        let budget = over.budget.over(&case.all.budget).over(&written.all.budget);
        if let Some(chunks) = chunks.filter(|chunks| chunks.value < LEAST_CHUNKS) {
            let message = format!("{} are too few for a verdict", counted(chunks.value));
            findings.warn("evaluation-chunks", chunks.span, message).help =
                Some(format!("a verdict takes at least {LEAST_CHUNKS}, and 8 if nothing is said"));
        }
        match (settings.samples, chunks) {
            (Some(samples), Some(chunks)) if samples.value < chunks.value => {
                let (samples_word, count) = (samples_text(samples.value), counted(chunks.value));
                let message = format!("{samples_word} per pixel cannot be divided among {count}");
                findings.error("evaluation-value", samples.span, message).help =
                    Some(format!("take at least {} samples, or fewer `chunks`", chunks.value));
            }
            (Some(samples), None) if samples.value < LEAST_CHUNKS => {
                let message = format!("{} per pixel are too few for a verdict", samples_text(samples.value));
                findings.warn("evaluation-chunks", samples.span, message).help =
                    Some(format!("a verdict takes at least {LEAST_CHUNKS} chunks of 1 sample"));
            }
            _ => {}
        }
        if let (Some(most), Some(samples)) = (budget.samples, settings.samples)
            && most.value < samples.value
        {
            let message = format!(
                "the budget of {} is smaller than the {} of the image",
                samples_text(most.value),
                samples.value
            );
            findings.error("evaluation-value", most.span, message).help = Some(
                "a budget is what is rendered beyond `samples` where there is time, all chunks together".to_owned(),
            );
        }
        variants.push(Variant {
            renderer,
            statements,
            settings,
            budget,
            chunks: chunks.map(|chunks| chunks.value),
            span: name.span,
        });
    }
    (complete && !variants.is_empty()).then(|| Case {
        name: case.name.clone(),
        description: case.description.as_ref().map(|text| text.value.clone()).unwrap_or_default(),
        variants,
        reference: case.reference.clone(),
        span: case.span,
    })
}

fn samples_text(count: u32) -> String {
    if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") }
}

fn counted(chunks: u32) -> String {
    if chunks == 1 { "1 chunk".to_owned() } else { format!("{chunks} chunks") }
}

/// Says which scenes, cases and renderers are not there that cases and excludes name.
fn matrix_names(evaluation: &Evaluation, written: &Written, findings: &mut Findings) {
    let scenes: Vec<&str> = evaluation.scenes.iter().map(|scene| scene.name.as_str()).collect();
    let conditions: Vec<&str> = evaluation.conditions.iter().map(|condition| condition.name.as_str()).collect();
    // What is wrong itself is not unknown.
    let cases: Vec<&str> = written.cases.iter().map(|case| case.name.value.as_str()).collect();
    let declared = written.renderers.iter().map(|renderer| renderer.name.value.as_str());
    let named = written.cases.iter().flat_map(|case| &case.renderers).map(|name| name.value.as_str());
    let renderers: Vec<&str> = declared.chain(named).collect();
    for exclude in &written.excludes {
        for name in exclude.scenes.iter().flatten().filter(|name| !conditions.contains(&name.value.as_str())) {
            if !scenes.contains(&name.value.as_str()) {
                findings.unknown("scene", name, scenes.iter().copied());
            }
        }
        for name in exclude.cases.iter().flatten().filter(|name| !cases.contains(&name.value.as_str())) {
            findings.unknown("case", name, cases.iter().copied());
        }
        for name in exclude.renderers.iter().flatten().filter(|name| !renderers.contains(&name.value.as_str())) {
            findings.unknown("renderer", name, renderers.iter().copied());
        }
    }
    for name in written.cases.iter().flat_map(|case| case.scenes.iter().flatten()) {
        if !scenes.contains(&name.value.as_str()) {
            findings.unknown("scene", name, scenes.iter().copied());
        }
    }
}

/// Conditions by cases by renderers, without what is excluded. Where something else is wrong, nothing is said of what is left.
fn runs(evaluation: &mut Evaluation, written: &Written, start: Span, sound: bool, findings: &mut Findings) {
    let variants: usize = evaluation.cases.iter().map(|case| case.variants.len()).sum();
    if evaluation.conditions.len().saturating_mul(variants) > MOST_RUNS {
        findings.error("evaluation-value", start, format!("the evaluation has more than {MOST_RUNS} images"));
        return;
    }
    let among = |names: &Option<Vec<At<String>>>, of: &[&str]| {
        names.as_ref().is_none_or(|names| names.iter().any(|name| of.contains(&name.value.as_str())))
    };
    let mut used = vec![false; written.excludes.len()];
    let mut found = Vec::new();
    for (condition, Condition { name, scene, .. }) in evaluation.conditions.iter().enumerate() {
        let scene = evaluation.scenes[*scene].name.as_str();
        for (case, own) in evaluation.cases.iter().enumerate() {
            if !among(&written.cases[case].scenes, &[scene]) {
                continue;
            }
            for (variant, of) in own.variants.iter().enumerate() {
                let renderer = evaluation.renderers[of.renderer].name.as_str();
                let mut kept = true;
                for (exclude, used) in written.excludes.iter().zip(&mut used) {
                    let covers = among(&exclude.scenes, &[scene, name.as_str()])
                        && among(&exclude.cases, &[own.name.value.as_str()])
                        && among(&exclude.renderers, &[renderer]);
                    *used |= covers;
                    kept &= !covers;
                }
                if kept {
                    found.push(Run { condition, case, variant });
                }
            }
        }
    }
    for (exclude, _) in written.excludes.iter().zip(used).filter(|(_, used)| sound && !used) {
        findings.warn("evaluation-unused", exclude.span, "the `[[exclude]]` excludes nothing");
    }
    if sound && found.is_empty() {
        findings.error("evaluation-value", start, "all images are excluded");
    }
    evaluation.runs = found;
}

/// What can only be said of scenes and renderers together.
fn checks(evaluation: &Evaluation, around: &dyn Surroundings, findings: &mut Findings) {
    for variant in evaluation.cases.iter().flat_map(|case| &case.variants) {
        translate::check(variant, &evaluation.renderers[variant.renderer], findings);
    }
    let mut asked: BTreeSet<(usize, &str)> = BTreeSet::new();
    let mut lacking = |scene: usize, renderer: &Renderer, findings: &mut Findings| {
        let SceneRef { name, source, span, .. } = &evaluation.scenes[scene];
        if !asked.insert((scene, renderer.target.name)) || around.missing(source).is_some() {
            return;
        }
        if let Some(why) = around.lacks(source, renderer.target) {
            let message = format!("the scene `{name}` cannot be rendered for `{}`: {why}", renderer.target.name);
            let renderer =
                ltsc_core::diag::Label { span: renderer.span, text: "its files are for this one".to_owned() };
            findings.error("evaluation-scene", *span, message).labels = vec![renderer];
        }
    };
    for run in &evaluation.runs {
        lacking(evaluation.conditions[run.condition].scene, evaluation.renderer(*run), findings);
    }
}

/// The reference that counts for a run: that of its case, of its scene, of the file.
pub(super) fn reference_of<'e>(
    evaluation: &'e Evaluation,
    written: &'e Written,
    run: Run,
) -> Option<&'e At<Reference>> {
    let scene = evaluation.conditions[run.condition].scene;
    let own = evaluation.cases[run.case].reference.as_ref();
    own.or(evaluation.scenes[scene].reference.as_ref()).or(written.reference.as_ref())
}
