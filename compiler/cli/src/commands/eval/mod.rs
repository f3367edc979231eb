//! `ltsc eval`: an evaluation file, carried out.

mod around;
mod show;

use std::path::{Path, PathBuf};

use ltsc_core::diag::{Finding, Severity, Sources};
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::executor::{self, Resources};
use ltsc_evaluation::file::model::Renderer;
use ltsc_evaluation::file::{self, Evaluation};
use ltsc_evaluation::study::{Clean, Estimate, Folder, Options, Study, prepare, runners};
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::regular;
use ltsc_render::run::Driver;
use serde_json::json;

use crate::args::{CleanWhen, Eval, Format};
use crate::output::{self, Exit, Failure, Located, why};
use crate::terminal::{self, Watcher};
use crate::trust;

use around::Around;

pub fn run(command: &Eval) -> Result<Exit, Failure> {
    if let Some(configuration) = &command.from_lteval {
        return from_lteval(configuration, command);
    }
    let path = command.file.as_deref().unwrap_or(Path::new(""));
    let text = text_of(path)?;
    let around = Around::of(path, &command.findings)?;
    let mut sources = Sources::default();
    let id = sources.add(path.to_string_lossy(), text.as_str());
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let (evaluation, found) = file::load_swept(id, &text, &stem, &sweeps(&command.set)?, &around);
    let said = Said { sources: &sources, format: command.findings.format };
    let Some(evaluation) = evaluation else { return Ok(said.refuse(found)) };
    said.remark(found);
    let untrusted = untrusted(&evaluation, &around, command)?;
    let executor = executor::find(&command.executor)?;
    let threads = threads(command);
    let configured = |driver: &'static Driver| Ok(around.project.program(driver.name)?.map(Path::to_path_buf));
    let (found, conditions) = match untrusted {
        Some(failure) => return Err(failure),
        None => (runners(&evaluation, &around.base, &configured, threads), around.conditions(&evaluation)?),
    };
    let conditions = match conditions {
        Ok(conditions) => conditions,
        Err(exit) => {
            // What is missing besides is told at the same time.
            return Ok(found.err().map_or(exit, |missing| said.refuse(missing).max(exit)));
        }
    };
    let runners = match found {
        Ok(runners) => runners,
        Err(missing) => return Ok(said.refuse(missing)),
    };
    let prepared = match prepare(&evaluation, &conditions, &runners, &around.base) {
        Ok(prepared) => prepared,
        Err(found) => return Ok(said.refuse(found)),
    };
    said.remark(prepared.findings.clone());
    let store = store(command)?;
    if command.dry_run {
        return Ok(show::dry(&Estimate::of(&evaluation, &prepared, &store), command.findings.format));
    }
    let folder = folder(command, &evaluation, &around)?;
    let executor = (executor.make)(&resources(command))?;
    let study = Study {
        evaluation: &evaluation,
        conditions: &conditions,
        text: &text,
        base: &around.base,
        store: &store,
        executor: executor.as_ref(),
        options: Options { keep_going: command.keep_going },
    };
    let done = study.carry_out(&prepared, &folder, &mut Watcher::default())?;
    // A page that is there from an earlier run would show what is no longer so.
    let output = &evaluation.output;
    let stale = ltsc_evaluation::page::is_page(&folder.path.join(ltsc_evaluation::page::FOLDER));
    let wanted = command.page || output.page || output.display || stale;
    let page = if wanted { super::page::beside(&folder.path, command.force, output.display) } else { None };
    Ok(show::done(&done, &folder, page.as_deref(), command))
}

/// The text of an evaluation file.
fn text_of(path: &Path) -> Result<String, Failure> {
    if path.extension().is_none_or(|ending| ending != "toml") {
        let failure = Failure::new(Exit::Usage, format!("{} is no evaluation file", path.display()));
        return Err(match path.extension().and_then(|ending| ending.to_str()) {
            Some("lts") => failure.help(format!(
                "render a scene by `ltsc render {}`, or write an evaluation file: see docs/evaluation.md",
                path.display()
            )),
            Some("py") => failure.help(format!("`ltsc eval --from-lteval {}` makes one of it", path.display())),
            _ => failure.help("its name ends in `.toml`"),
        });
    }
    regular::read_text(path, regular::TEXT)
        .map_err(|error| Failure::new(Exit::Input, format!("{}: {}", path.display(), why(&error))))
}

/// Findings of the evaluation file, said.
struct Said<'s> {
    sources: &'s Sources,
    format: Format,
}

impl Said<'_> {
    fn located(&self, found: Vec<Finding>) -> Vec<Located<'_>> {
        found.into_iter().map(|finding| Located { finding, sources: self.sources, prefix: "" }).collect()
    }

    /// All of them, where they forbid to go on.
    fn refuse(&self, found: Vec<Finding>) -> Exit {
        let missing = |finding: &Finding| finding.id == "evaluation-renderer";
        let exit = found.iter().filter(|finding| finding.severity >= Severity::Deny);
        let exit = exit.map(|finding| if missing(finding) { Exit::Environment } else { Exit::of_finding(finding) });
        // What is malformed comes first: a renderer that is missing may not be needed then.
        let worst = exit.min().unwrap_or(Exit::Input);
        output::findings(&self.located(found), None, self.format, false, true);
        worst
    }

    /// Those that do not; programs that read a document do not get them in its place.
    fn remark(&self, found: Vec<Finding>) {
        if !found.is_empty() && self.format != Format::Json {
            output::findings(&self.located(found), None, self.format, false, true);
        }
    }
}

/// Values of `--set`, parted at the commas that stand in no bracket.
fn sweeps(set: &[String]) -> Result<Vec<(String, Vec<String>)>, Failure> {
    let pairs = super::shared::set_of(set)?;
    let mut found = Vec::new();
    for (name, text) in pairs {
        let mut values = vec![String::new()];
        let mut depth = 0_i32;
        for letter in text.chars() {
            match letter {
                '(' | '[' => depth += 1,
                ')' | ']' => depth -= 1,
                _ => {}
            }
            match values.last_mut() {
                Some(last) if letter != ',' || depth > 0 => last.push(letter),
                _ => values.push(String::new()),
            }
        }
        let values: Vec<String> = values.iter().map(|value| value.trim().to_owned()).collect();
        if values.iter().any(String::is_empty) {
            return Err(Failure::new(Exit::Usage, format!("`--set {name}={text}` has an empty value"))
                .help("write for example `--set alpha=0.1,0.2,0.4`"));
        }
        found.push((name, values));
    }
    Ok(found)
}

/// What a renderer of the file has run that the file names itself: a program, or a whole command.
fn named(renderer: &Renderer, base: &Path) -> Option<PathBuf> {
    let path = renderer.path.as_ref().map(|path| base.join(&path.value));
    match &renderer.command {
        None => path,
        Some(command) => {
            let words = command.value.texts().join(" ");
            Some(path.map_or_else(|| PathBuf::from(&words), |path| path.join(&words)))
        }
    }
}

/// Why the programs that the file names must not run, unless the user has said yes to them.
fn untrusted(evaluation: &Evaluation, around: &Around, command: &Eval) -> Result<Option<Failure>, Failure> {
    let all = || evaluation.renderers.iter().filter_map(|renderer| named(renderer, &around.base));
    let root = &around.project.root;
    if command.trust {
        trust::trust(root, all())
            .map_err(|error| Failure::new(Exit::Environment, format!("nothing was remembered: {}", why(&error))))?;
        return Ok(None);
    }
    let foreign = all().find(|program| !trust::is_trusted(root, program));
    Ok(foreign.map(|program| {
        let message = format!("the evaluation names a program, `{}`, and it was not run", program.display());
        Failure::new(Exit::Environment, message)
            .help(format!("if you trust this file, add `--trust`, or set LTSC_TRUST={}", root.display()))
    }))
}

/// Threads of renderers that say nothing: all, or a share where several run at once.
fn threads(command: &Eval) -> Option<usize> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (command.jobs > 1).then(|| (cores / command.jobs as usize).max(1))
}

fn resources(command: &Eval) -> Resources {
    Resources {
        jobs: command.jobs as usize,
        memory: command
            .memory
            .map(|gigabytes| gigabytes * 1_000_000_000)
            .or_else(|| ltsc_evaluation::chunk::Machine::here().memory),
        shared: command.shared.clone(),
        options: command.option.clone(),
    }
}

/// Where chunks are kept.
fn store(command: &Eval) -> Result<Store, Failure> {
    let store = match &command.shared {
        Some(shared) => {
            // A misspelt one would be made.
            if !shared.is_dir() {
                return Err(Failure::new(Exit::Usage, format!("{}: there is no such folder", shared.display()))
                    .help("make it where all machines of the cluster see it"));
            }
            Store::at(shared.join("chunks"))
        }
        None => {
            let cache = CachePaths::find(&Env::of_process()).ok_or_else(|| {
                Failure::new(Exit::Environment, "the system names no cache folder").help("set LTSC_CACHE to a folder")
            })?;
            Store::of(&cache)
        }
    };
    Ok(match command.executor.as_str() {
        "local" if command.timing => store.alone(),
        "local" => store.at_once(command.jobs as usize),
        _ => store,
    })
}

/// Where results go; refused before anything is rendered.
fn folder(command: &Eval, evaluation: &Evaluation, around: &Around) -> Result<Folder, Failure> {
    let date = Folder::date();
    let path = command.output.clone().unwrap_or_else(|| Folder::of(evaluation, &around.base, &date));
    let clean = match command.clean {
        CleanWhen::Success => Clean::Success,
        CleanWhen::Always => Clean::Always,
        CleanWhen::Never => Clean::Never,
    };
    let folder = Folder { path, force: command.force, clean };
    folder.check()?;
    Ok(folder)
}

/// Prints a configuration of the thesis's tool as an evaluation file.
fn from_lteval(path: &Path, command: &Eval) -> Result<Exit, Failure> {
    let text = regular::read_text(path, regular::TEXT)
        .map_err(|error| Failure::new(Exit::Input, format!("{}: {}", path.display(), why(&error))))?;
    let mut sources = Sources::default();
    let id = sources.add(path.to_string_lossy(), text.as_str());
    let (written, found) = file::lteval::read(id, &text);
    let said = Said { sources: &sources, format: command.findings.format };
    let wrong = found.iter().any(|finding| finding.severity >= Severity::Deny);
    let text = file::print(&written);
    if command.findings.format == Format::Json {
        let list: Vec<_> = said.located(found).iter().map(Located::json).collect();
        terminal::print(&format!("{:#}\n", json!({ "evaluation": text, "findings": list })));
    } else {
        said.remark(found);
        terminal::print(&text);
    }
    // What could not be read is in the findings, and the rest is of use.
    Ok(if wrong { Exit::Input } else { Exit::Done })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_parted_at_commas_outside_of_brackets() {
        let of = |text: &str| sweeps(&[text.to_owned()]).expect("values");
        let values = |values: &[&str]| values.iter().map(|value| (*value).to_owned()).collect::<Vec<_>>();
        assert_eq!(of("alpha=0.1, 0.2,0.4"), [("alpha".to_owned(), values(&["0.1", "0.2", "0.4"]))]);
        assert_eq!(of("c=rgb(1, 2, 3),rgb(0,0,0)"), [("c".to_owned(), values(&["rgb(1, 2, 3)", "rgb(0,0,0)"]))]);
        assert_eq!(sweeps(&["a=1,,2".to_owned()]).expect_err("an empty one").exit, Exit::Usage);
    }
}
