//! `ltsc import`: a scene of another program as a text of the language, to be edited.

use std::path::{Path, PathBuf};

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval;
use ltsc_core::files::{MemoryFiles, Sink, VPath};
use ltsc_core::import as importers;
use ltsc_core::print::{self, Options, Printed};
use ltsc_evaluation::disk::{DiskSink, unwritable, write_whole};
use ltsc_render::regular;

use super::said::plural;
use super::shared::{CheckedFile, check, report, set_of};
use crate::args::{Format, Import};
use crate::output::{Exit, Failure};
use crate::project::Project;
use crate::terminal;

pub fn run(command: &Import) -> Result<Exit, Failure> {
    let format = command.findings.format;
    if let Some(folder) = &command.survey {
        return super::survey::run(folder, &command.findings);
    }
    let Some(file) = &command.scene else {
        return Err(Failure::new(Exit::Usage, "no scene is named").help("name a file, or a folder by `--survey`"));
    };
    let known = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !importers::IMPORTERS.iter().any(|importer| importer.endings.contains(&known.as_str())) {
        let endings: Vec<&str> = importers::IMPORTERS.iter().flat_map(|importer| importer.endings).copied().collect();
        return Err(Failure::new(
            Exit::Usage,
            format!("{} is no scene of another program that can be read", file.display()),
        )
        .help(format!("files that can be read end in {}", endings.join(", "))));
    }
    let project = Project::of(file)?;
    let overrides = eval::Overrides { set: set_of(&command.set)?, ..eval::Overrides::default() };
    let files = check(&project, std::slice::from_ref(file), &command.findings, overrides, &[])?;
    let refuse = |files: &[CheckedFile]| report(files, Vec::new(), format, false, true).0;
    if files.iter().any(|file| file.checked.worst() >= Severity::Deny) {
        return Ok(refuse(&files));
    }
    let Some(mut checked) = files.into_iter().next() else { return Ok(Exit::Fault) };
    let Some(scene) = checked.checked.scene.take() else {
        return Err(Failure::new(Exit::Input, format!("{} gives no scene", file.display())));
    };
    let text = place(command.output.as_deref(), &scene.name);
    let name = text.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let origin = file.file_name().map(|name| format!("Imported from {}.", name.to_string_lossy()));
    let options = Options { name: Some(name.clone()), origin, folder: format!("{name}/") };
    let printed = print::print(&scene, &options);
    if printed.name != name {
        return Err(Failure::new(Exit::Usage, format!("a scene cannot be called `{name}`"))
            .help(format!("write for example `-o {}`", text.with_file_name(printed.file()).display())));
    }
    checked.checked.findings.extend(printed.findings.iter().cloned());
    project.levels_with(&command.findings)?.judge(&mut checked.checked.findings);
    if checked.checked.worst() >= Severity::Deny {
        return Ok(refuse(&[checked]));
    }
    read_back(&scene, &printed)?;
    if text.exists()
        && !command.force
        && regular::read(&text, regular::TEXT).ok().as_deref() != Some(printed.text.as_bytes())
    {
        return Err(Failure::new(Exit::Usage, format!("{} is there already, and is another text", text.display()))
            .help("name another place by `-o`, or write over it by `--force`"));
    }
    write(&text, &printed, command.force)?;
    // Everything that was found: this is the one time that it is told.
    let (exit, _) = report(std::slice::from_ref(&checked), Vec::new(), format, false, true);
    if format == Format::Human {
        let files = match printed.files.len() {
            0 => String::new(),
            count => format!(", {} in {}", plural(count, "file"), text.with_extension("").display()),
        };
        terminal::say(&format!("{} written{files}", text.display()));
    }
    Ok(exit)
}

/// Where the text goes: the file that was named, or one called as the scene in the folder that was named.
fn place(output: Option<&Path>, name: &str) -> PathBuf {
    match output {
        Some(path) if path.extension().is_some_and(|ending| ending == "lts") => path.to_path_buf(),
        folder => folder.unwrap_or(Path::new("")).join(format!("{name}.lts")),
    }
}

/// Evaluates what was printed, which must give the same scene.
fn read_back(scene: &ltsc_core::ir::Scene, printed: &Printed<'_>) -> Result<(), Failure> {
    let mut files = MemoryFiles::default();
    files.insert(printed.file(), printed.text.as_bytes());
    for (path, content) in &printed.files {
        files.insert(path.clone(), content.bytes());
    }
    let fault = |what: &str| {
        Failure::new(
            Exit::Fault,
            format!("the text that was made does not give the scene back (a bug in ltsc): {what}"),
        )
        .help("please report it with the file")
    };
    let path = VPath::resolve("", &printed.file()).map_err(|error| fault(&error.to_string()))?;
    let mut sources = Sources::default();
    let evaluated = eval::evaluate(&files, &mut sources, &path, &eval::Overrides::default());
    let Some(again) = evaluated.scene else {
        let first = evaluated.findings.into_iter().find(|finding| finding.severity == Severity::Error);
        return Err(fault(&first.map(|finding| finding.message).unwrap_or_default()));
    };
    // What is lost in the text was said; where nothing is, it is the same.
    match print::difference(scene, &again) {
        Some(difference) if printed.findings.is_empty() && scene.name == printed.name => Err(fault(&difference)),
        _ => Ok(()),
    }
}

fn write(text: &Path, printed: &Printed<'_>, force: bool) -> Result<(), Failure> {
    if !printed.files.is_empty() {
        let folder = text.with_extension("");
        let failed = |error: std::io::Error| unwritable(&folder, &error);
        let mut sink = DiskSink::new(&folder, &printed.name, false, force).map_err(failed)?;
        let prefix = format!("{}/", printed.name);
        for (path, content) in &printed.files {
            let path = path.strip_prefix(&prefix).unwrap_or(path);
            sink.file(path, &mut |out| content.write(out)).map_err(failed)?;
        }
        sink.finish().map_err(failed)?;
    }
    write_whole(text, &mut |out| out.write_all(printed.text.as_bytes())).map_err(|error| unwritable(text, &error))
}
