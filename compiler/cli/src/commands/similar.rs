//! `ltsc similar`: which scenes of the project are near one, and what follows from it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ltsc_core::eval::Overrides;
use ltsc_core::ir::Scene;
use ltsc_core::similar::{Near, Nearness, Profile, rank};
use serde_json::{Value, json};

use crate::args::{Format, Similar};
use crate::output::{Exit, Failure};
use crate::project::{self, Project};
use crate::terminal;
use ltsc_evaluation::disk::Changed;

use super::shared::{check, check_each, disk_of, report};

/// Scenes shown where none is near.
const SHOWN: usize = 3;

/// Near scenes that are shown and advised on, unless all are asked for.
const NEAREST: usize = 10;

/// A scene that was compared, and what is said of it.
struct Row {
    near: Near,
    /// Why the scene stands beside it, where the scene says so.
    argued: Option<String>,
}

pub fn run(command: &Similar) -> Result<Exit, Failure> {
    let project = Project::of(&command.scene)?;
    if command.scene.is_dir() {
        return Err(
            Failure::new(Exit::Usage, format!("{} is a folder", command.scene.display())).help("name one scene")
        );
    }
    // Findings of the scene itself are lint's business, except for what keeps it from being a scene.
    let unlinted = command.findings.unlinted();
    let mut own = check(&project, std::slice::from_ref(&command.scene), &unlinted, Overrides::default(), &[])?;
    let Some(scene) = own.first_mut().and_then(|file| file.checked.scene.take()) else {
        let (exit, _) = report(&own, Vec::new(), command.findings.format, false, true);
        if exit != Exit::Done {
            return Ok(exit);
        }
        return Err(Failure::new(Exit::Input, format!("{} is a library: it has no `scene`", command.scene.display()))
            .help("name a scene that uses it"));
    };
    let (others, unread) = others(&project, command, &scene)?;
    let argued = |name: &str| {
        let similar = scene.documentation.similar.iter().find(|similar| similar.scene == name);
        similar.map(|similar| similar.reason.clone())
    };
    let rows: Vec<Row> =
        rank(&Profile::of(&scene), &others).into_iter().map(|near| Row { argued: argued(&near.name), near }).collect();
    match command.findings.format {
        Format::Json => {
            let document = json!({
                "scene": scene.name,
                "verdict": word(worst(&rows)),
                "scenes": rows.iter().map(row_json).collect::<Vec<_>>(),
                "not_compared": unread,
            });
            terminal::print(&format!("{document:#}\n"));
        }
        Format::Human | Format::Short | Format::Sarif | Format::Github => {
            let text = text(&scene, &rows, command.all);
            // The rows alone, without what follows from them.
            let rows = text.split("\n\n").next().unwrap_or_default();
            terminal::print(&if command.findings.format == Format::Short {
                format!("{}\n", rows.trim_end())
            } else {
                text
            });
            if !unread.is_empty() {
                terminal::say(&format!("not compared, since they cannot be read: {}", unread.join(", ")));
            }
        }
    }
    Ok(Exit::Done)
}

/// The project's other scenes, and the files that could not be read.
fn others(project: &Project, command: &Similar, scene: &Scene) -> Result<(Vec<Profile>, Vec<String>), Failure> {
    let own = std::fs::canonicalize(&command.scene).ok();
    let files: Vec<PathBuf> = project::scene_files(&project.scenes)?
        .files
        .into_iter()
        .filter(|file| std::fs::canonicalize(file).ok() != own)
        .collect();
    let disk = disk_of(project, &command.findings)?;
    let from = Changed { disk: &disk, texts: &BTreeMap::new() };
    let unlinted = command.findings.unlinted();
    // Of ten thousand scenes nothing but what is compared is kept.
    let all =
        check_each(project, &files, &unlinted, Overrides::default(), &[], &from, |file| match &file.checked.scene {
            // A draft of a scene that is there already takes its place.
            Some(other) if other.name == scene.name => (None, None),
            Some(other) => (Some(Profile::of(other)), None),
            None if file.checked.library => (None, None),
            None => (None, Some(file.path.to_string())),
        })?;
    let (profiles, unread): (Vec<_>, Vec<_>) = all.into_iter().unzip();
    Ok((profiles.into_iter().flatten().collect(), unread.into_iter().flatten().collect()))
}

fn worst(rows: &[Row]) -> Nearness {
    rows.iter().map(|row| row.near.nearness).max().unwrap_or(Nearness::Far)
}

/// What follows, in a word for programs.
fn word(nearness: Nearness) -> &'static str {
    match nearness {
        Nearness::Far => "new",
        Nearness::Near => "argue",
        Nearness::VeryNear => "consider-replacing",
    }
}

fn row_json(row: &Row) -> Value {
    let Row { near: Near { name, score, paths, materials, brief, nearness }, argued } = row;
    json!({
        "name": name, "score": score, "paths": paths, "materials": materials, "brief": brief,
        "verdict": word(*nearness), "argued": argued,
    })
}

fn text(scene: &Scene, rows: &[Row], all: bool) -> String {
    if rows.is_empty() {
        return format!("there is no other scene that `{}` could be near to\n", scene.name);
    }
    // Those that are near or named, and the nearest ones.
    let told = |at: usize, row: &Row| {
        all || at < SHOWN || at < NEAREST && row.near.nearness > Nearness::Far || row.argued.is_some()
    };
    let shown: Vec<&Row> = rows.iter().enumerate().filter(|(at, row)| told(*at, row)).map(|(_, row)| row).collect();
    let mut text = format!("{:<6} {:<6} {:<10} {:<6} scene\n", "score", "paths", "materials", "brief");
    let share = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    for Row { near, argued } in &shown {
        let word = match (near.nearness, argued) {
            (Nearness::Far, None) => "",
            (Nearness::Far, Some(_)) => "  argued",
            (Nearness::Near, None) => "  near",
            (Nearness::VeryNear, None) => "  very near",
            (Nearness::Near, Some(_)) => "  near, argued",
            (Nearness::VeryNear, Some(_)) => "  very near, argued",
        };
        let (paths, materials, brief) = (share(near.paths), share(near.materials), share(near.brief));
        text.push_str(&format!("{:<6.2} {paths:<6} {materials:<10} {brief:<6} {}{word}\n", near.score, near.name));
    }
    if shown.len() < rows.len() {
        let rest = rows.len() - shown.len();
        let near = |row: &&Row| row.near.nearness > Nearness::Far;
        let hidden = rows.iter().filter(near).count() - shown.iter().copied().filter(near).count();
        let be = |count| if count == 1 { "is" } else { "are" };
        if hidden > 0 {
            text.push_str(&format!("... and {hidden} more that {} near; `--all` shows them\n", be(hidden)));
        }
        if rest > hidden {
            let far = rest - hidden;
            text.push_str(&format!("... and {far} that {} not near\n", be(far)));
        }
    }
    text.push('\n');
    text.push_str(&advice(scene, rows, all));
    text
}

/// What to do.
fn advice(scene: &Scene, rows: &[Row], all: bool) -> String {
    let name = &scene.name;
    let mut text = String::new();
    if scene.documentation.paths.is_empty() {
        text.push_str("the scene names no light paths: materials and words alone were compared\n");
    }
    let most = if all { usize::MAX } else { NEAREST };
    let near = || rows.iter().filter(|row| row.near.nearness > Nearness::Far).take(most);
    if near().next().is_none() {
        text.push_str(&format!("no scene is near: `{name}` is new\n"));
        return text;
    }
    for Row { near, argued } in near() {
        let other = &near.name;
        match (near.nearness, argued) {
            (Nearness::Far, _) => {}
            (_, Some(reason)) => text.push_str(&format!("`{other}`: argued by \"{reason}\"\n")),
            (Nearness::VeryNear, None) => text.push_str(&format!(
                "`{other}`: consider replacing it by `{name}`, or leaving `{name}` out; where both are needed, say why\n"
            )),
            (Nearness::Near, None) => text.push_str(&format!("`{other}`: say why `{name}` stands beside it\n")),
        }
    }
    let open: Vec<String> =
        near().filter(|row| row.argued.is_none()).map(|row| format!("(\"{}\", \"...\")", row.near.name)).collect();
    if !open.is_empty() {
        let open = open.join(", ");
        text.push_str(&format!("\nin `{name}`: similar: [{open}]\nand in each of them: (\"{name}\", \"...\")\n"));
    }
    text
}
