//! `ltsc reference`: images that are kept with their error.

use std::path::{Path, PathBuf};
use std::time::Duration;

use ltsc_core::formats::Choices;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::job::{Job, Runner, Writing, driver_called, target_of};
use ltsc_evaluation::reference::{self, About, Declared, Entry, Goal, Kept, Left, Measure, State, Wanted};
use serde_json::{Value, json};

use crate::args::{Findings, Format, Reference, ReferenceAction, ReferenceAdd, ReferenceList, Settings};
use crate::output::{Exit, Failure, show};
use crate::project::Project;
use crate::terminal::{self, Watcher};

use super::said::plural;
use super::shared::{One, Shown, all_files_of, check, one, report_as};

pub fn run(command: &Reference) -> Result<Exit, Failure> {
    match (&command.action, &command.scene, &command.renderer) {
        (Some(ReferenceAction::List(list)), ..) => list_all(list),
        (Some(ReferenceAction::Add(add)), ..) => add_one(add),
        (None, Some(scene), Some(renderer)) => render(command, scene, renderer),
        // Clap asks for them.
        (None, ..) => Err(Failure::new(Exit::Usage, "a scene and `--renderer` are needed")),
    }
}

/// The scene as it is, which its reference has other settings of.
fn plain(scene: &Path, findings: &Findings) -> Result<Result<One, Exit>, Failure> {
    let settings = Settings {
        width: None,
        height: None,
        samples: None,
        max_depth: None,
        seed: None,
        set: Vec::new(),
        camera: None,
    };
    one(scene, findings, &settings)
}

fn folder(given: Option<&PathBuf>, project: &Project) -> PathBuf {
    given.cloned().unwrap_or_else(|| reference::folder(&project.root))
}

fn render(command: &Reference, scene: &Path, renderer: &str) -> Result<Exit, Failure> {
    let driver = driver_called(renderer)?;
    let target = target_of(driver);
    let json = command.findings.format == Format::Json;
    let mut one = match plain(scene, &command.findings)? {
        Ok(one) => one,
        Err(exit) => return Ok(exit),
    };
    one.scene = reference::prepared(one.scene, Some(command.size), command.integrator, command.max_depth)?;
    reference::check(driver, &one.scene)?;
    let exit = one.report(target, &command.findings, json)?;
    if exit != Exit::Done {
        return Ok(exit);
    }
    let given = command.executable.as_deref();
    let configured = if given.is_none() { one.project.program(driver.name)? } else { None };
    let found = Runner::find(driver, given, configured, command.timeout.map(Duration::from_secs))?;
    let runner = Runner { threads: command.threads.map(|threads| threads as usize), ..found };
    let Some(cache) = &runner.cache else {
        return Err(Failure::new(Exit::Environment, "the system names no cache folder, where chunks are kept")
            .help("set LTSC_CACHE to a folder"));
    };
    let writing = Writing { choices: one.project.choices.clone(), ..Writing::default() };
    let job = Job::written(&one.scene, &runner, &writing)?;
    let goal = Goal { measure: Measure::Tiles, error: command.error, budget: command.budget };
    let references = folder(command.output.as_ref(), &one.project);
    let wanted = Wanted { references: &references, goal, force: command.force };
    let kept = wanted.render(&Store::of(cache), &job, &one.scene, &mut Watcher::default())?;
    if json {
        terminal::print(&format!("{:#}\n", document(&kept)));
    } else {
        tell(&kept, command.error);
    }
    match (kept.failed, kept.left) {
        // The document has it: one is all that there is.
        (Some(failure), _) if json => Ok(show(&failure)),
        (Some(failure), _) => Err(failure),
        (None, Some(_)) => Ok(Exit::No),
        (None, None) => Ok(Exit::Done),
    }
}

fn document(kept: &Kept) -> Value {
    let Kept { file, about, chunks: (chunks, samples), written, replaced, left, failed } = kept;
    let left = left
        .map(|Left { chunks, samples, seconds }| json!({ "chunks": chunks, "samples": samples, "seconds": seconds }));
    json!({
        "file": about.as_ref().map(|_| file), "written": written, "replaced": replaced, "reached": left.is_none(), "chunks": chunks,
        "chunk_samples": samples, "left": left, "about": about,
        "error": failed.as_ref().map(|failure| json!({ "message": failure.message, "help": failure.help })),
    })
}

fn tell(kept: &Kept, goal: f64) {
    let (chunks, samples) = kept.chunks;
    if let Some(replaced) = kept.replaced.as_ref().filter(|_| kept.written) {
        terminal::say(&format!("it takes the place of another one: {replaced}"));
    }
    match &kept.about {
        Some(about) if kept.written => terminal::say(&format!("{} written: {}", kept.file.display(), described(about))),
        Some(about) => {
            terminal::say(&format!("{} stays, it has as many samples: {}", kept.file.display(), described(about)));
        }
        None => terminal::say(&format!(
            "{} of {samples} samples: too few to tell their error, nothing is written yet",
            plural(chunks as usize, "chunk")
        )),
    }
    if let Some(left) = &kept.left {
        let time = left
            .seconds
            .map(|seconds| format!(", {} on this machine as it is now", lasting(seconds)))
            .unwrap_or_default();
        terminal::say(&format!(
            "not yet {}: about {} samples more{time}; the same command goes on",
            percent(goal),
            left.samples
        ));
    }
}

/// How a reference was made and how good it is, in a line.
fn described(about: &About) -> String {
    let mut words = vec![about.maker()];
    words.push(format!("{}x{}", about.settings.width, about.settings.height));
    words.extend(about.samples.map(|samples| format!("{samples} samples")));
    words.push(match &about.error {
        Some(error) => format!("error {} (worst tile {})", percent(error.tiles), percent(error.worst)),
        None => "error not known".to_owned(),
    });
    words.extend(about.caution());
    words.join(", ")
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 10.0 { format!("{percent:.2} %") } else { format!("{percent:.0} %") }
}

fn lasting(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        120.0..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

fn add_one(command: &ReferenceAdd) -> Result<Exit, Failure> {
    let one = match plain(&command.scene, &command.findings())? {
        Ok(one) => one,
        Err(exit) => return Ok(exit),
    };
    let references = folder(command.output.as_ref(), &one.project);
    let declared = Declared {
        file: &command.file,
        variance: command.variance.as_deref(),
        name: &command.renderer,
        by: &command.by,
        algorithm: command.algorithm.as_deref(),
        samples: command.samples,
        max_depth: command.max_depth,
    };
    let (file, about) = reference::add(&references, one.scene, &one.project.choices, &declared, command.force)?;
    if command.answer.format == Format::Json {
        terminal::print(&format!("{:#}\n", json!({ "file": file, "about": about })));
    } else {
        terminal::say(&format!("{} written: {}", file.display(), described(&about)));
    }
    Ok(Exit::Done)
}

fn list_all(command: &ReferenceList) -> Result<Exit, Failure> {
    let mut entries = Vec::new();
    for (project, files) in all_files_of(&command.scenes, &command.findings())? {
        let checked = check(&project, &files, &command.findings(), ltsc_core::eval::Overrides::default(), &[])?;
        let (exit, _) = report_as(&checked, Vec::new(), None, Format::Human, false, Shown::Refusals);
        if exit != Exit::Done {
            return Ok(exit);
        }
        let mut scenes: Vec<Valid> = Vec::new();
        for scene in checked.into_iter().filter_map(|file| file.checked.scene) {
            let name = scene.name.clone();
            let (scene, _) = pipeline::prepare(scene)
                .map_err(|_| Failure::new(Exit::Input, format!("the scene `{name}` cannot be rendered")))?;
            scenes.push(scene);
        }
        let all: Vec<(&Valid, &Choices)> = scenes.iter().map(|scene| (scene, &project.choices)).collect();
        let references = folder(command.output.as_ref(), &project);
        entries.extend(reference::list(&references, &all, &command.renderer, command.scenes.is_empty())?);
    }
    entries.sort_by(|a, b| (&a.scene, &a.name).cmp(&(&b.scene, &b.name)));
    match command.answer.format {
        Format::Json => {
            let rows: Vec<Value> = entries.iter().map(row).collect();
            terminal::print(&format!("{:#}\n", json!({ "references": rows })));
        }
        Format::Human | Format::Short | Format::Sarif | Format::Github => {
            entries.iter().for_each(|entry| terminal::print(&line(entry)));
        }
    }
    let bad = |entry: &&Entry| match entry.state {
        State::Fresh(_) => false,
        State::Missing => !command.renderer.is_empty(),
        State::Stale(..) | State::Orphan | State::Damaged(_) => true,
    };
    Ok(if command.check && entries.iter().any(|entry| bad(&entry)) { Exit::No } else { Exit::Done })
}

/// Why it stands as it does, for people.
fn why(state: &State) -> String {
    match state {
        State::Fresh(about) => described(about),
        State::Stale(about, why) => format!("{why}: {}", described(about)),
        State::Orphan => "the project has no scene of this name".to_owned(),
        State::Damaged(why) => why.clone(),
        State::Missing => String::new(),
    }
}

fn line(entry: &Entry) -> String {
    let text = format!("{:<22} {:<12} {:<8} {}", entry.scene, entry.name, entry.state.word(), why(&entry.state));
    format!("{}\n", text.trim_end())
}

fn row(entry: &Entry) -> Value {
    let about = match &entry.state {
        State::Fresh(about) | State::Stale(about, _) => Some(about),
        State::Orphan | State::Damaged(_) | State::Missing => None,
    };
    let reason = match &entry.state {
        State::Stale(_, stale) => Some(stale.to_string()),
        State::Damaged(why) => Some(why.clone()),
        State::Fresh(_) | State::Orphan | State::Missing => None,
    };
    json!({
        "scene": entry.scene, "name": entry.name, "file": entry.file, "state": entry.state.word(), "why": reason, "about": about,
    })
}
