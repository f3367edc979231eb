//! Runs made ready: each scene with the settings and statements of its case, written for its renderer and read back, and divided into
//! chunks. Everything that can be known before the first ray is told here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use ltsc_core::capability::algorithm;
use ltsc_core::capability::{Feature, Support};
use ltsc_core::diag::{Finding, Origin, Severity};
use ltsc_core::formats::Choices;
use ltsc_core::formats::statements::{Parameter, Statement, Statements};
use ltsc_core::ir::Documentation;
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_render::run::Driver;
use rayon::prelude::*;

use crate::chunk::Plan;
use crate::compare::verdict::Stated;
use crate::failure::Failure;
use crate::file::model::{Condition, Run, Side, Variant};
use crate::file::{Evaluation, LEAST_CHUNKS};
use crate::job::{Job, Runner, Writing, stated, target_of};
use crate::reference;

use super::manual::Manual;
use super::names::Places;
use super::runners::Runners;

/// The code of a finding that a case cannot be rendered.
pub const CANNOT: &str = "evaluation-render";

/// A condition's scene as it was read.
pub struct Loaded {
    /// The scene with the values of its parameters, lowered and valid.
    pub scene: Valid,
    /// What was lost before any target was asked.
    pub lost: Vec<Finding>,
    /// What targets do only because it is asked for.
    pub choices: Choices,
}

/// A run that can be rendered.
pub struct Ready {
    /// Of [`Prepared::jobs`].
    pub job: usize,
    /// Its chunks, without those of a budget.
    pub plan: Plan,
    /// The seed of the first one.
    pub first_seed: u32,
    /// Whether there can be several chunks.
    pub seeded: bool,
    /// What the target states of the scene.
    pub stated: Vec<Stated>,
    /// Where its files and images lie, if they are made by hand.
    pub manual: Option<Manual>,
}

/// All runs of an evaluation.
pub struct Prepared<'r> {
    /// Scenes as they were written for renderers; runs that are the same share one.
    pub jobs: Vec<Job<'r>>,
    /// In the order of [`Evaluation::runs`].
    pub runs: Vec<Ready>,
    /// What the files of scenes say of them, in the order of [`Evaluation::conditions`].
    pub documentation: Vec<String>,
    /// What people should know, none of which forbids to go on.
    pub findings: Vec<Finding>,
}

/// Writes all runs for their renderers; `conditions` are in the order of [`Evaluation::conditions`], and `base` is the folder of its file.
///
/// # Errors
/// Everything that forbids to go on, with what else was found.
pub fn prepare<'r>(
    evaluation: &Evaluation,
    conditions: &[Loaded],
    runners: &'r Runners,
    base: &Path,
) -> Result<Prepared<'r>, Vec<Finding>> {
    let places = Places::of(evaluation);
    let one = |(at, run): (usize, &Run)| {
        let runner = runners.get(evaluation.variant(*run).renderer)?;
        let mut findings = Vec::new();
        let manual = evaluation.renderer(*run).manual.then(|| Manual::of(evaluation, at, &places, base));
        let made = ready(evaluation, *run, &conditions[run.condition], runner, manual, &mut findings);
        Some((made, findings))
    };
    let made: Vec<_> = evaluation.runs.par_iter().enumerate().map(one).collect();
    let documentation = conditions.iter().map(|condition| words(&condition.scene.documentation)).collect();
    let mut prepared = Prepared { jobs: Vec::new(), runs: Vec::new(), documentation, findings: Vec::new() };
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for made in made {
        let Some((made, findings)) = made else { continue };
        for finding in findings {
            // One case in many scenes says the same of each.
            if !prepared.findings.contains(&finding) {
                prepared.findings.push(finding);
            }
        }
        let Some((job, mut ready)) = made else { continue };
        ready.job = *known.entry(job.identity()).or_insert_with(|| {
            prepared.jobs.push(job);
            prepared.jobs.len() - 1
        });
        prepared.runs.push(ready);
    }
    let wrong = prepared.findings.iter().any(|finding| finding.severity >= Severity::Deny);
    if !wrong && prepared.runs.len() == evaluation.runs.len() {
        apart(evaluation, &mut prepared);
        stale(evaluation, conditions, base, &mut prepared.findings);
    }
    if wrong || prepared.runs.len() < evaluation.runs.len() { Err(prepared.findings) } else { Ok(prepared) }
}

/// A scene's documentation as one text.
fn words(of: &Documentation) -> String {
    let paths = if of.paths.is_empty() { String::new() } else { format!("Light paths: {}", of.paths.join(", ")) };
    let source = if of.source.is_empty() { String::new() } else { format!("Source: {}", of.source) };
    let parts = [&of.brief, &of.full, &paths, &of.comments, &source];
    parts.into_iter().filter(|part| !part.is_empty()).cloned().collect::<Vec<_>>().join("\n\n")
}

/// Says which comparisons are of images that are not the same, whatever their noise.
fn apart(evaluation: &Evaluation, prepared: &mut Prepared<'_>) {
    for pair in &evaluation.pairs {
        let Side::Run(a) = pair.a else { continue };
        let effective = |run: usize| prepared.jobs[prepared.runs[run].job].effective();
        let Some((one, other)) = effective(a).zip(effective(pair.b)) else { continue };
        let label = |run: usize| evaluation.label(evaluation.runs[run]);
        let place = pair.span.unwrap_or(evaluation.variant(evaluation.runs[pair.b]).span);
        for why in one.apart(other).differs {
            let message = format!("`{}` and `{}` are compared, and {why}", label(a), label(pair.b));
            let finding = Finding::warn("not-comparable", place, message)
                .note("their images differ for that alone; the comparison is made, and says so")
                .help("give both the same settings, or compare others: `[compare] pairs`");
            if !prepared.findings.contains(&finding) {
                prepared.findings.push(finding);
            }
        }
    }
}

/// Says which references that ltsc has made are of scenes as they were once.
fn stale(evaluation: &Evaluation, conditions: &[Loaded], base: &Path, findings: &mut Vec<Finding>) {
    let mut seen = BTreeSet::new();
    for pair in &evaluation.pairs {
        let Side::File(file) = &pair.a else { continue };
        let run = evaluation.runs[pair.b];
        if !seen.insert((file, run.condition)) {
            continue;
        }
        let loaded = &conditions[run.condition];
        let variant = evaluation.variant(run);
        let Ok(scene) = pipeline::override_settings(loaded.scene.clone(), &variant.settings.overrides()) else {
            continue;
        };
        // One that cannot be read is told with the comparison.
        if let Ok(Some(why)) = reference::stale(&base.join(file), &scene, &loaded.choices) {
            let place = pair.span.unwrap_or(variant.span);
            let message = format!("the reference `{file}` is not of the scene as it is now: {why}");
            findings.push(
                Finding::warn("stale-reference", place, message)
                    .help("render it again by `ltsc reference`, or set the depth that it has"),
            );
        }
    }
}

/// Statements of a file in the words of the core.
fn statements(variant: &Variant) -> Statements {
    let parameter = |one: &crate::file::model::Parameter| Parameter {
        name: one.name.clone(),
        kind: one.kind.clone(),
        value: one.value.clone(),
    };
    let all = variant.statements.iter().map(|one| Statement {
        name: one.name.value.clone(),
        parameters: one.parameters.iter().map(parameter).collect(),
        origin: Origin::Text(one.name.span),
    });
    all.collect()
}

/// One run; what is wrong with it is among the findings.
fn ready<'r>(
    evaluation: &Evaluation,
    run: Run,
    loaded: &Loaded,
    runner: &'r Runner,
    manual: Option<Manual>,
    findings: &mut Vec<Finding>,
) -> Option<(Job<'r>, Ready)> {
    let variant = evaluation.variant(run);
    let Condition { scene: scene_at, .. } = &evaluation.conditions[run.condition];
    let asked = &evaluation.scenes[*scene_at];
    let target = target_of(runner.driver);
    let label = evaluation.label(run);
    let before = findings.len();
    let scene = match pipeline::override_settings(loaded.scene.clone(), &variant.settings.overrides()) {
        Ok(scene) => scene,
        Err(wrong) => {
            findings.extend(wrong.into_iter().map(|finding| placed(finding, variant)));
            return None;
        }
    };
    let (feature, _) = algorithm(&scene.integrator);
    let given = statements(variant);
    let silent = matches!((target.supports)(Feature::Path), Support::Unsupported { why: _ });
    // Statements may name another algorithm; files without any have the scene's, or have no word for one.
    if silent {
        // What reads them has settings of its own.
    } else if let (Support::Unsupported { why }, true) = ((target.supports)(feature), given.is_empty()) {
        let message = format!("`{}` has no {}, which `{}` asks for: {why}", target.name, feature.name(), asked.name);
        let finding = Finding::error(CANNOT, variant.span, message);
        findings.push(finding.help("say another integrator in the `settings` of the case, or leave the scene out"));
        return None;
    }
    let camera = pipeline::camera(&scene, asked.camera.as_deref());
    let Some(camera) = camera else {
        let name = asked.camera.as_deref().unwrap_or_default();
        findings.push(Finding::error(CANNOT, asked.span, format!("the scene has no camera `{name}`")));
        return None;
    };
    let total = scene.sampler.samples();
    let driver = runner.driver;
    let mut plan = plan(driver, variant.chunks, u64::from(total));
    let mut scene = match pipeline::take_statements(scene, target, &given) {
        Ok((scene, remarks)) => {
            findings.extend(remarks);
            scene
        }
        Err(wrong) => {
            findings.extend(wrong.into_iter().map(|finding| placed(finding, variant)));
            return None;
        }
    };
    let ledger = Ledger::of(&scene, target, &loaded.lost);
    let mut written = |scene: &Valid| {
        let choices = loaded.choices.clone();
        let writing = Writing { camera: Some(camera), choices, ledger: Some(&ledger), statements: &given };
        Job::written(scene, runner, &writing).map_err(|failure| findings.push(cannot(&label, variant, failure))).ok()
    };
    // Statements may say another number of samples than the scene, which its files then have instead of the scene's.
    let own = if given.is_empty() { None } else { Some(written(&scene)?) };
    let said = own.as_ref().and_then(|job| job.effective()?.samples).filter(|said| *said != total);
    let job = match (own, said) {
        (Some(job), Some(said)) => {
            plan = self::plan(driver, variant.chunks, u64::from(said));
            job
        }
        _ => {
            scene.set_sampling(plan.samples, 0);
            written(&scene)?
        }
    };
    let first_seed = variant.settings.seed.map_or(0, |seed| seed.value);
    let seeded = match &manual {
        // The plan has what the files say; how many images there are is seen later.
        Some(_) => {
            plan = Plan::whole(plan.total());
            false
        }
        None => seeded(&job, &label, variant, &mut plan, first_seed, findings)?,
    };
    let asked = variant.settings.samples.filter(|_| said.is_none());
    if let Some(samples) = asked.filter(|samples| plan.total() != u64::from(samples.value)) {
        let Plan { samples: of, count } = plan;
        let message =
            format!("{} samples are rendered as {count} chunks of {of}: {} in all", samples.value, plan.total());
        findings.push(Finding::warn("evaluation-chunks", samples.span, message));
    }
    few(driver, &label, variant, plan, findings);
    let stated = stated(&scene, driver);
    let wrong = findings[before..].iter().any(|finding| finding.severity >= Severity::Deny);
    (!wrong).then_some((job, Ready { job: 0, plan, first_seed, seeded, stated, manual }))
}

/// How samples are divided: into as many chunks as are asked for, or into chunks whose size depends on the samples alone, so that more
/// samples need only the rest.
fn plan(driver: &Driver, chunks: Option<u32>, samples: u64) -> Plan {
    let Some(chunks) = chunks else { return Plan::for_driver(driver, samples) };
    let size = samples.div_ceil(u64::from(chunks.max(1))).max(1);
    Plan::with(samples, u32::try_from(size).unwrap_or(u32::MAX))
}

/// Says where chunks are too few, or too small.
fn few(driver: &Driver, label: &str, variant: &Variant, plan: Plan, findings: &mut Vec<Finding>) {
    let least = driver.least_samples;
    let place = variant.settings.samples.map_or(variant.span, |samples| samples.span);
    if plan.count > 1 && plan.samples < least {
        let message =
            format!("images of {} have an error in common with chunks of {} samples", driver.name, plan.samples);
        let finding = Finding::warn("evaluation-chunks", place, message);
        findings.push(
            finding
                .note("their scatter does not tell it, so that a verdict may take it for a difference")
                .help(format!("ask for {least} samples for each chunk at least, or leave `chunks` out")),
        );
    } else if plan.count < LEAST_CHUNKS && least > 1 && variant.chunks.is_none() {
        let message = format!("{} samples of the case `{label}` are too few for a verdict", plan.total());
        let finding = Finding::warn("evaluation-chunks", place, message);
        findings.push(finding.help(format!(
            "a verdict takes {LEAST_CHUNKS} chunks, of {least} samples each in {}: {} samples",
            driver.name,
            LEAST_CHUNKS * least
        )));
    }
}

/// Whether the renderer renders independent images of the job; where it has one only, the plan becomes that one. None where it renders
/// nothing of it.
fn seeded(
    job: &Job<'_>,
    label: &str,
    variant: &Variant,
    plan: &mut Plan,
    first_seed: u32,
    findings: &mut Vec<Finding>,
) -> Option<bool> {
    if let Err(error) = job.refuse(plan.samples, first_seed) {
        findings.push(cannot(label, variant, Failure::of_renderer(&error)));
        return None;
    }
    let further = plan.count.max(2) - 1;
    let Some(last) = first_seed.checked_add(further) else {
        if plan.count == 1 {
            return Some(false);
        }
        let message = format!("the {} chunks of the case `{label}` take more seeds than there are", plan.count);
        let place = variant.settings.seed.map_or(variant.span, |seed| seed.span);
        let finding = Finding::error("evaluation-seeds", place, message);
        findings.push(finding.help(format!("say {} at most", u32::MAX - further)));
        return None;
    };
    let Err(error) = job.refuse(plan.samples, last) else { return Some(true) };
    if plan.count > 1 {
        let name = job.runner().driver.name;
        let message =
            format!("{name} renders one image of the case `{label}`, so that its noise is not known: {error}");
        let finding = Finding::warn("evaluation-seeds", variant.span, message);
        findings.push(finding.note("its comparisons have metrics, and no verdict").help(error.hint()));
    }
    *plan = Plan::whole(plan.total());
    Some(false)
}

/// A finding of a scene, whose place is not in the evaluation's file, at the place of its case.
fn placed(finding: Finding, variant: &Variant) -> Finding {
    if matches!(finding.origin, Origin::Made) {
        Finding { origin: Origin::Text(variant.span), ..finding }
    } else {
        finding
    }
}

fn cannot(label: &str, variant: &Variant, failure: Failure) -> Finding {
    let message = format!("the case `{label}` cannot be rendered: {}", failure.message);
    Finding { help: failure.help, ..Finding::error(CANNOT, variant.span, message) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_divided_as_asked_or_so_that_more_need_only_the_rest() {
        let driver = |name| ltsc_render::run::driver(name).expect("a driver");
        let mitsuba = driver("mitsuba-3");
        let of = |chunks, samples| (plan(mitsuba, chunks, samples).samples, plan(mitsuba, chunks, samples).count);
        assert_eq!(of(Some(4), 64), (16, 4));
        assert_eq!(of(Some(8), 100), (13, 8));
        assert_eq!(of(Some(8), 3), (1, 3));
        assert_eq!(of(None, 64), (8, 8));
        assert_eq!((of(None, 512), of(None, 1024)), ((64, 8), (64, 16)));
        // Cycles has few independent images of few samples.
        let cycles = plan(driver("cycles"), None, 256);
        assert_eq!((cycles.samples, cycles.count), (64, 4));
    }
}
