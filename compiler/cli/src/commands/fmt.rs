//! `ltsc fmt`.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ltsc_core::diag::{Finding, Severity, Sources};
use ltsc_core::eval::Limits;
use ltsc_core::format::{FormatError, format, unformatted};
use ltsc_render::regular;
use rayon::prelude::*;
use similar::TextDiff;

use crate::args::{Fmt, Format};
use crate::output::{self, Exit, Failure, Located, show, why};
use crate::project::{self, limits_with};
use crate::terminal;
use ltsc_evaluation::disk::{self, DiskFiles};

use super::shared::files_of;

/// What came of a file.
enum Done {
    /// The text.
    Unchanged(String),
    /// The text before and after.
    Changed(String, String),
    /// What is wrong with it, and the text that this is about.
    Refused(Vec<Finding>, Sources),
}

/// A file that was asked for.
struct Asked {
    file: PathBuf,
    /// Its path below the project's root.
    path: String,
    /// Where the project lies in its repository.
    prefix: Arc<str>,
    /// The most bytes that are read.
    most: u64,
}

pub fn run(command: &Fmt) -> Result<Exit, Failure> {
    if command.paths.iter().any(|path| path == Path::new("-")) {
        if command.paths.len() > 1 {
            return Err(Failure::new(Exit::Usage, "`-` is standard input, and stands alone"));
        }
        return input(command);
    }
    let mut files = Vec::new();
    let (groups, problems) = files_of(&command.paths)?;
    for (project, paths) in groups {
        let most = limits_with(project.limits, &command.limits)?.text;
        let prefix: Arc<str> = project::prefix(&project.root).into();
        let disk = DiskFiles::new(&project.root).ok();
        let path = |file: &Path| disk.as_ref().and_then(|disk| disk.path_of(file)).map(|path| path.to_string());
        files.extend(paths.into_iter().map(|file| Asked {
            path: path(&file).unwrap_or_else(|| file.display().to_string()),
            file,
            prefix: Arc::clone(&prefix),
            most,
        }));
    }
    let done: Vec<Result<Done, Failure>> = files.par_iter().map(|asked| one(asked, command)).collect();
    // A diff is for people, and the output of the command.
    let format = if command.diff { Format::Human } else { command.format };
    let people = matches!(format, Format::Human | Format::Short);
    let nowhere: Arc<str> = "".into();
    let mut found: Vec<(Vec<Finding>, Sources, Arc<str>)> = Vec::new();
    let mut failed = |failure: Failure| {
        let exit = if people { show(&failure) } else { failure.exit };
        if !people {
            found.push((vec![failure.into_finding()], Sources::default(), Arc::clone(&nowhere)));
        }
        exit
    };
    let mut worst = Exit::Done;
    for problem in problems {
        worst = worst.max(failed(problem));
    }
    let (mut rest, mut changed, mut refused) = (Vec::new(), 0, 0);
    for (asked, done) in files.iter().zip(done) {
        let exit = match done {
            Ok(Done::Unchanged(_)) => Exit::Done,
            Ok(Done::Changed(before, after)) => {
                changed += 1;
                let name = asked.file.display();
                if command.diff {
                    terminal::print(&difference(&name.to_string(), &before, &after));
                }
                let only_said = command.check || command.diff;
                let what = if only_said { "would be formatted" } else { "formatted" };
                terminal::say(&format!("{name} {what}"));
                if command.check && !people {
                    let mut sources = Sources::default();
                    let file = sources.add(asked.path.as_str(), before.as_str());
                    rest.push((vec![unformatted(file, &before, &after)], sources, Arc::clone(&asked.prefix)));
                }
                if only_said { Exit::No } else { Exit::Done }
            }
            Ok(Done::Refused(findings, sources)) => {
                refused += 1;
                rest.push((findings, sources, Arc::clone(&asked.prefix)));
                Exit::Input
            }
            Err(failure) => failed(failure),
        };
        worst = worst.max(exit);
    }
    found.extend(rest);
    report(&found, format);
    let count = files.len();
    let plural = if count == 1 { "" } else { "s" };
    let what = if command.check || command.diff { "not formatted" } else { "changed" };
    let refused = if refused > 0 { format!(", {refused} with errors left as they are") } else { String::new() };
    terminal::say(&format!("{count} file{plural}, {changed} {what}{refused}"));
    Ok(worst)
}

/// Prints what keeps files from being formatted.
fn report(found: &[(Vec<Finding>, Sources, Arc<str>)], format: Format) {
    let all = found.iter().flat_map(|(findings, sources, prefix)| {
        findings.iter().map(move |finding| Located { finding: finding.clone(), sources, prefix })
    });
    output::findings(&all.collect::<Vec<_>>(), None, format, false, true);
}

/// Standard input to standard output.
fn input(command: &Fmt) -> Result<Exit, Failure> {
    let most = limits_with(Limits::default(), &command.limits)?.text;
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().take(most.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| Failure::new(Exit::Input, format!("standard input cannot be read: {error}")))?;
    let text = text("standard input", bytes, most)?;
    let done = formatted("<stdin>", text)?;
    let (before, after) = match done {
        Done::Refused(findings, sources) => {
            report(&[(findings, sources, "".into())], command.format);
            return Ok(Exit::Input);
        }
        Done::Unchanged(text) => (text.clone(), text),
        Done::Changed(before, after) => (before, after),
    };
    if command.diff {
        terminal::print(&difference("<stdin>", &before, &after));
    } else if !command.check {
        terminal::print(&after);
    }
    Ok(if (command.check || command.diff) && before != after { Exit::No } else { Exit::Done })
}

fn one(asked: &Asked, command: &Fmt) -> Result<Done, Failure> {
    let Asked { file, path, prefix: _, most } = asked;
    let (name, most) = (file.display().to_string(), *most);
    let unreadable =
        |error: std::io::Error| Failure::new(Exit::Input, format!("{name} cannot be read: {}", why(&error)));
    let bytes = match regular::read(file, most) {
        Err(error) if error.kind() == std::io::ErrorKind::FileTooLarge => return Err(too_large(&name, most)),
        other => other.map_err(unreadable)?,
    };
    let text = text(&name, bytes, most)?;
    let done = formatted(path, text)?;
    if let Done::Changed(_, after) = &done
        && !command.check
        && !command.diff
    {
        let written = disk::rewrite(file, &project::around(file), after.as_bytes());
        written.map_err(|error| disk::unwritable(file, &error))?;
    }
    Ok(done)
}

fn too_large(name: &str, most: u64) -> Failure {
    Failure::new(Exit::Input, format!("{name} has more than {most} bytes"))
        .help("if this is meant, raise the limit by `--limit text=N`")
}

fn text(name: &str, bytes: Vec<u8>, most: u64) -> Result<String, Failure> {
    if bytes.len() as u64 > most {
        return Err(too_large(name, most));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Failure::new(Exit::Input, format!("{name} is not a text in UTF-8: the first bad byte is at {at}"))
    })?;
    if text.contains('\0') {
        return Err(Failure::new(Exit::Input, format!("{name} contains a zero byte")).help("is this a binary file?"));
    }
    Ok(text)
}

fn formatted(name: &str, text: String) -> Result<Done, Failure> {
    let mut sources = Sources::default();
    match format(&mut sources, name, &text) {
        Ok(after) if after == text => Ok(Done::Unchanged(text)),
        Ok(after) => Ok(Done::Changed(text, after)),
        Err(FormatError::Malformed(findings)) => {
            let shown = findings.into_iter().filter(|finding| finding.severity >= Severity::Error);
            Ok(Done::Refused(shown.collect(), sources))
        }
        Err(FormatError::Fault(difference)) => {
            let message = format!(
                "an internal error (a bug in ltsc): formatting {name} would change it ({difference}); it stays as it is"
            );
            Err(Failure::new(Exit::Fault, message).help("please report it with the file"))
        }
    }
}

/// A unified diff.
fn difference(name: &str, before: &str, after: &str) -> String {
    TextDiff::from_lines(before, after)
        .unified_diff()
        .context_radius(3)
        .header(name, &format!("{name}, formatted"))
        .to_string()
}
