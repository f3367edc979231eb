//! What an evaluation says: its plan, and its outcome.

use std::fmt::Write as _;
use std::path::Path;

use ltsc_evaluation::compare::verdict::{Outcome, Told};
use ltsc_evaluation::study::results::{Condition, Pair, Results, Status};
use ltsc_evaluation::study::{Done, Estimate, Folder};
use serde_json::json;

use crate::args::{Eval, Format};
use crate::output::Exit;
use crate::terminal;

use super::super::said::{from_here, plural};

/// The plan.
pub fn dry(estimate: &Estimate, format: Format) -> Exit {
    if format == Format::Json {
        terminal::print(&format!("{:#}\n", json!(estimate)));
        return Exit::Done;
    }
    let mut condition = "";
    let mut text = String::new();
    for run in &estimate.runs {
        if run.condition != condition {
            condition = &run.condition;
            let _written = writeln!(text, "{condition}");
        }
        let (width, height) = run.size;
        let kept = if run.kept > 0 { format!(", {} there", run.kept) } else { String::new() };
        let _written = writeln!(
            text,
            "    {:<32} {:<20} {width} x {height}, {} chunks of {} samples{kept}",
            run.label, run.renderer, run.chunks, run.samples
        );
    }
    terminal::print(&text);
    let open = estimate.chunks - estimate.kept;
    let known = match (open - estimate.unknown, estimate.unknown) {
        (0, 0) => String::new(),
        (0, _) => ": nothing like them was rendered before, so that their time is not known".to_owned(),
        (_, 0) => format!(": about {} of rendering", duration(estimate.seconds)),
        (_, unknown) => format!(": about {} of rendering, and {unknown} of unknown time", duration(estimate.seconds)),
    };
    terminal::say(&format!("{open} of {} chunks to render{known}", estimate.chunks));
    Exit::Done
}

/// Seconds in words.
fn duration(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        120.0..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

/// The outcome.
pub fn done(done: &Done, folder: &Folder, page: Option<&Path>, command: &Eval) -> Exit {
    let results = &done.results;
    let exit = exit(results, command.require_agree);
    match command.findings.format {
        Format::Json => {
            let (folder, page) = (folder.path.to_string_lossy(), page.map(Path::to_string_lossy));
            let document = json!({ "folder": folder, "page": page, "results": results, "timing": done.timing });
            terminal::print(&format!("{document:#}\n"));
            return exit;
        }
        Format::Short => {
            for (condition, pair) in pairs(results) {
                terminal::print(&format!("{condition}: {}\n", line(pair)));
            }
        }
        Format::Human | Format::Sarif | Format::Github => terminal::print(&text(results)),
    }
    for (condition, run) in results.runs().filter(|(_, run)| run.status == Status::Failed) {
        let why = run.failure.as_deref().unwrap_or_default();
        terminal::error(&format!("{}: {} failed: {why}", condition.name, run.label));
        if let Some(files) = &run.files {
            terminal::help(&format!("the files that it was given are in {}", from_here(&folder.path.join(files))));
        }
    }
    for (condition, run) in results.runs().filter(|(_, run)| run.status == Status::Awaited) {
        let expected = run.expected.as_deref().unwrap_or_default();
        terminal::say(&format!(
            "{}: {} is made by hand: render what lies in {} to {expected}",
            condition.name,
            run.label,
            expected.trim_end_matches(".exr")
        ));
    }
    let skipped = results.runs().filter(|(_, run)| run.status == Status::Skipped).count();
    if skipped > 0 {
        terminal::say(&format!("{skipped} images were not rendered; `--keep-going` goes on where one fails"));
    }
    let [agree, differ, undecided, none] = results.outcomes();
    let none = if none > 0 { format!(", {none} without a verdict") } else { String::new() };
    let total = pairs(results).count();
    let images = results.runs().filter(|(_, run)| run.status == Status::Done).count();
    if total == 0 {
        terminal::say(&format!(
            "{}, and nothing to compare: a second case, or a `reference`, is compared with it",
            plural(images, "image")
        ));
    } else {
        let words = plural(total, "comparison");
        terminal::say(&format!("{words}: {agree} agree, {differ} differ, {undecided} undecided{none}"));
    }
    terminal::say(&format!("{} written: begin with summary.md", from_here(&folder.path)));
    if let Some(page) = page {
        terminal::say(&format!("open {} in a browser", from_here(page)));
    }
    exit
}

fn exit(results: &Results, require_agree: bool) -> Exit {
    let [_, differ, undecided, none] = results.outcomes();
    if results.runs().any(|(_, run)| matches!(run.status, Status::Failed | Status::Skipped)) {
        return Exit::Environment;
    }
    let no = differ > 0 || require_agree && undecided + none > 0;
    if no { Exit::No } else { Exit::Done }
}

fn pairs(results: &Results) -> impl Iterator<Item = (&str, &Pair)> {
    results.conditions.iter().flat_map(|condition| condition.pairs.iter().map(|pair| (condition.name.as_str(), pair)))
}

fn told(pair: &Pair) -> Option<Told<'_>> {
    pair.verdict.as_ref().map(|verdict| Told { verdict, stated: &pair.stated, excused: pair.excused })
}

/// A comparison in a line.
fn line(pair: &Pair) -> String {
    let apart = if pair.not_comparable.is_empty() { "" } else { ", not comparable" };
    match told(pair) {
        Some(told) => format!("{} and {}: {}{apart}: {}", pair.a, pair.b, told.verdict.outcome.word(), told.proof()),
        None => format!("{} and {}{apart}: {}", pair.a, pair.b, pair.refused.as_deref().unwrap_or("no verdict")),
    }
}

/// All comparisons, for people.
fn text(results: &Results) -> String {
    let mut text = String::new();
    let defects = |condition: &Condition, pair: &Pair| -> Vec<String> {
        let of = condition.runs.iter().filter(|run| run.label == pair.b || !pair.reference && run.label == pair.a);
        of.flat_map(|run| run.defects.iter().map(|what| format!("{}: {what}", run.driver))).collect()
    };
    for condition in results.conditions.iter().filter(|condition| !condition.pairs.is_empty()) {
        let _written = writeln!(text, "{}", terminal::strong(&condition.name, true));
        for pair in &condition.pairs {
            let _written = writeln!(text, "    {}", line(pair));
            for why in &pair.not_comparable {
                let _written = writeln!(text, "        not-comparable: {why}, so that the images are not the same");
            }
            if !pair.unknown.is_empty() {
                let _written = writeln!(text, "        not known whether alike: {}", pair.unknown.join(", "));
            }
            let Some(told) = told(pair) else { continue };
            let _written = writeln!(text, "        B / A {}", told.channels());
            for note in told.notes() {
                let _written = writeln!(text, "        {note}");
            }
            for what in defects(condition, pair) {
                let _written = writeln!(text, "        {what}");
            }
            for blame in &pair.blame {
                let _written = writeln!(text, "        {}", blame.text());
            }
            if told.verdict.outcome != Outcome::Agree
                && let Some(shift) = pair.shift.filter(|shift| (shift.dx, shift.dy) != (0, 0))
            {
                let _written = writeln!(text, "        B lies {}, {} pixels off A", shift.dx, shift.dy);
            }
        }
    }
    text
}
