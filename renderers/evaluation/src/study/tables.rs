//! Results for people: Markdown to read, and CSV for programs that make tables.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::compare::METRICS;
use crate::compare::blame::Blame;
use crate::compare::verdict::{Outcome, Told};

use super::results::{Condition, Pair, Results, Run, Status};
use super::timing::{self, Timing};

/// Times by condition and label.
type Times<'t> = BTreeMap<(&'t str, &'t str), &'t timing::Run>;

/// Metrics that are in the Markdown; the CSV has all.
const SHOWN: &[&str] = &["ratio", "rmse", "relative-mse", "ssim", "flip"];

/// Everything to read.
pub(super) fn markdown(results: &Results, timing: &Timing) -> String {
    let mut text = format!("# {}\n\n", plain(&results.name));
    if !results.description.is_empty() {
        let _written = writeln!(text, "{}\n", plain(&results.description));
    }
    let [agree, differ, undecided, none] = results.outcomes();
    let _written = writeln!(
        text,
        "{} images, {} comparisons: {agree} agree, {differ} differ, {undecided} undecided, {none} without a verdict. A is the \
         reference: ratios are B / A.\n",
        results.runs().count(),
        agree + differ + undecided + none
    );
    let by_name = timing.by_name();
    for condition in &results.conditions {
        let _written = writeln!(text, "## {}\n", plain(&condition.name));
        images_of(&mut text, condition, &by_name);
        if !condition.pairs.is_empty() {
            pairs_of(&mut text, condition);
        }
    }
    times(&mut text, results, timing);
    text
}

fn images_of(text: &mut String, condition: &Condition, times: &Times<'_>) {
    text.push_str(
        "| image | renderer | samples | chunks | noise of a pixel | seconds | |\n|---|---|---|---|---|---|---|\n",
    );
    for run in &condition.runs {
        let time = times.get(&(condition.name.as_str(), run.label.as_str()));
        let seconds = time.map_or("-".to_owned(), |time| format!("{:.1}", time.cost.seconds));
        let noise = run.noise.map_or("-".to_owned(), |noise| format!("{:.2} %", 100.0 * noise));
        let _written = writeln!(
            text,
            "| {} | {} {} | {} | {} | {noise} | {seconds} | {} |",
            cell(&run.label),
            run.driver,
            run.version,
            run.samples,
            run.chunks,
            cell(&remarks(run).join("; "))
        );
    }
    text.push('\n');
}

/// What is to be known of an image.
fn remarks(run: &Run) -> Vec<String> {
    let mut all = Vec::new();
    match run.status {
        Status::Done => {}
        Status::Failed => {
            let why = run.failure.as_deref().and_then(|text| text.lines().next()).unwrap_or_default();
            all.push(format!("**failed**: {why}"));
        }
        Status::Skipped => all.push("not rendered".to_owned()),
        Status::Awaited => all.push(format!("awaited as `{}`", run.expected.as_deref().unwrap_or_default())),
    }
    if let Some(files) = &run.files {
        all.push(format!("its files are in `{files}`"));
    }
    all.extend(run.defects.iter().cloned());
    if run.non_finite > 0 {
        all.push(format!("{} pixels are infinite or not a number", run.non_finite));
    }
    if let Some(settings) = &run.settings {
        match (&settings.algorithm, &settings.convergence) {
            (Some(algorithm), Some(convergence)) => all.push(format!("`{algorithm}`, {convergence}")),
            (Some(algorithm), None) => all.push(format!("`{algorithm}`")),
            _ => {}
        }
        if let Some(limit) = settings.clamped {
            all.push(format!("samples clamped to {limit}"));
        }
    }
    all
}

fn pairs_of(text: &mut String, condition: &Condition) {
    let shown: Vec<&str> =
        SHOWN.iter().copied().filter(|name| METRICS.iter().any(|metric| metric.name == *name)).collect();
    let _written = writeln!(text, "| A | B | verdict | {} | |", shown.join(" | "));
    let _written = writeln!(text, "|---|---|---|{}---|", "---|".repeat(shown.len()));
    for pair in &condition.pairs {
        let metrics: Vec<String> = shown.iter().map(|name| metric(pair, name)).collect();
        let word = pair.verdict.as_ref().map_or("-", |verdict| verdict.outcome.word());
        let _written = writeln!(
            text,
            "| {} | {} | **{word}** | {} | {} |",
            cell(&pair.a),
            cell(&pair.b),
            metrics.join(" | "),
            cell(&proof(pair).join("; "))
        );
    }
    text.push('\n');
}

/// What stands behind a verdict, and beside it.
pub fn proof(pair: &Pair) -> Vec<String> {
    let mut all = Vec::new();
    if !pair.not_comparable.is_empty() {
        all.push(format!("not comparable: {}", pair.not_comparable.join(", ")));
    }
    if let Some(verdict) = &pair.verdict {
        let told = Told { verdict, stated: &pair.stated, excused: pair.excused };
        all.push(told.proof());
        all.push(format!("B / A {}", told.channels()));
        all.extend(told.notes());
        all.extend(pair.blame.iter().map(Blame::text));
    }
    all.extend(pair.refused.iter().map(|why| format!("no verdict: {why}")));
    if !pair.unknown.is_empty() {
        all.push(format!("not known whether they are alike: {}", pair.unknown.join(", ")));
    }
    all
}

fn metric(pair: &Pair, name: &str) -> String {
    let value = pair.metrics.iter().find(|measure| measure.name == name).and_then(|measure| measure.value.overall);
    value.map_or("-".to_owned(), |value| format!("{value:.4}"))
}

fn times(text: &mut String, results: &Results, timing: &Timing) {
    if timing.runs.is_empty() {
        return;
    }
    text.push_str(
        "## Times\n\nTimes compare within one renderer, machine and number of threads only: within a group. Efficiency is 1 / (variance x \
         seconds); the last column is the time in which an image would have the error of the first one of its group.\n\n\
         | condition | image | group | seconds | CPU seconds | memory | efficiency | seconds to equal error |\n|---|---|---|---|---|---|---|---|\n",
    );
    let mut groups: Vec<&str> = Vec::new();
    for run in &timing.runs {
        let at = groups.iter().position(|known| *known == run.group).unwrap_or_else(|| {
            groups.push(&run.group);
            groups.len() - 1
        });
        let number =
            |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
        let memory = run.cost.peak_memory.map_or("-".to_owned(), |bytes| format!("{:.0} MB", bytes as f64 / 1e6));
        let _written = writeln!(
            text,
            "| {} | {} | {} | {:.1} | {} | {memory} | {} | {} |",
            cell(&run.condition),
            cell(&run.label),
            at + 1,
            run.cost.seconds,
            number(run.cost.cpu_seconds, 1),
            number(run.efficiency, 2),
            number(run.equal_error_seconds, 1)
        );
    }
    text.push('\n');
    for (at, group) in groups.iter().enumerate() {
        let _written = writeln!(text, "{}. {}", at + 1, plain(group));
    }
    let _written = writeln!(text, "\n{} {}.", results.generator, timing.date);
}

/// One line for each image.
pub(super) fn images(results: &Results, timing: &Timing) -> String {
    let mut rows = vec![
        "condition,scene,image,case,renderer,driver,version,status,width,height,samples,chunks,noise,non_finite,seconds,cpu_seconds,\
         peak_memory,efficiency,equal_error_seconds,group,parameters"
            .to_owned(),
    ];
    let times = timing.by_name();
    for (condition, run) in results.runs() {
        let time = times.get(&(condition.name.as_str(), run.label.as_str()));
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let status = match run.status {
            Status::Done => "done",
            Status::Failed => "failed",
            Status::Skipped => "skipped",
            Status::Awaited => "awaited",
        };
        let parameters: Vec<String> =
            condition.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let fields = [
            condition.name.clone(),
            condition.scene.clone(),
            run.label.clone(),
            run.case.clone(),
            run.renderer.clone(),
            run.driver.clone(),
            run.version.clone(),
            status.to_owned(),
            run.width.to_string(),
            run.height.to_string(),
            run.samples.to_string(),
            run.chunks.to_string(),
            number(run.noise),
            run.non_finite.to_string(),
            number(time.map(|time| time.cost.seconds)),
            number(time.and_then(|time| time.cost.cpu_seconds)),
            time.and_then(|time| time.cost.peak_memory).map_or(String::new(), |bytes| bytes.to_string()),
            number(time.and_then(|time| time.efficiency)),
            number(time.and_then(|time| time.equal_error_seconds)),
            time.map_or(String::new(), |time| time.group.clone()),
            parameters.join(" "),
        ];
        rows.push(line(&fields));
    }
    rows.join("\n") + "\n"
}

/// One line for each comparison, with all metrics.
pub(super) fn comparisons(results: &Results) -> String {
    let names: Vec<&str> = METRICS.iter().map(|metric| metric.name).collect();
    let mut rows = vec![format!(
        "condition,scene,a,b,verdict,tiles_that_agree,tiles,red,red_error,green,green_error,blue,blue_error,samples_needed,{},\
         not_comparable,refused,parameters",
        names.join(",")
    )];
    for condition in &results.conditions {
        for pair in &condition.pairs {
            let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let verdict = pair.verdict.as_ref();
            let mut fields = vec![
                condition.name.clone(),
                condition.scene.clone(),
                pair.a.clone(),
                pair.b.clone(),
                verdict.map_or(String::new(), |verdict| verdict.outcome.word().to_owned()),
                verdict.map_or(String::new(), |verdict| {
                    verdict.tiles.iter().filter(|tile| **tile == Outcome::Agree).count().to_string()
                }),
                verdict.map_or(String::new(), |verdict| verdict.tiles.len().to_string()),
            ];
            for channel in 0..3 {
                let of = verdict.map(|verdict| verdict.channels[channel]);
                fields.push(number(of.and_then(|of| of.ratio)));
                fields.push(number(of.map(|of| of.error)));
            }
            fields.push(number(verdict.and_then(|verdict| verdict.needed).and_then(|needed| needed.half)));
            for name in &names {
                let value = pair.metrics.iter().find(|measure| measure.name == *name);
                fields.push(number(value.and_then(|measure| measure.value.overall)));
            }
            fields.push(pair.not_comparable.join("; "));
            fields.push(pair.refused.clone().unwrap_or_default());
            let parameters: Vec<String> =
                condition.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
            fields.push(parameters.join(" "));
            rows.push(line(&fields));
        }
    }
    rows.join("\n") + "\n"
}

/// A line of CSV (RFC 4180).
fn line(fields: &[String]) -> String {
    let quoted = fields.iter().map(|field| {
        if field.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", field.replace('"', "\"\""))
        } else {
            field.clone()
        }
    });
    quoted.collect::<Vec<_>>().join(",")
}

/// A text within a line of Markdown.
fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text within a cell of a table.
fn cell(text: &str) -> String {
    plain(text).replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_and_quotes_are_quoted() {
        let fields = ["a", "b,c", "say \"d\"", ""].map(str::to_owned);
        assert_eq!(line(&fields), "a,\"b,c\",\"say \"\"d\"\"\",");
        assert_eq!(cell(" a |\n b "), "a \\| b");
    }
}
