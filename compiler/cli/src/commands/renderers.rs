//! `ltsc renderers`: which renderers there are, and private installations of them.

use ltsc_evaluation::job::driver_called;
use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::install::{InstallProgress, InstallRequest, Status, Step, install, status, uninstall};
use ltsc_render::run::{DRIVERS, Driver, Installation, Search, find};
use serde_json::json;

use crate::args::{Format, Renderers, RenderersAction};
use crate::output::{Exit, Failure};
use crate::project::{FILE, Project};
use crate::terminal::{self, Bar};
use crate::trust;

pub fn run(command: &Renderers) -> Result<Exit, Failure> {
    match &command.action {
        RenderersAction::List { answer } => list(answer.format),
        RenderersAction::Trust => trust_named(),
        RenderersAction::Install { names, force } => install_all(names, *force),
    }
}

fn list(format: Format) -> Result<Exit, Failure> {
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let mut rows = Vec::new();
    let mut text = String::new();
    // What the project names comes before what there is without it.
    let here = project()?;
    for driver in DRIVERS {
        let named = here.as_ref().and_then(|project| Some((project, project.programs.get(driver.name)?)));
        let (word, version, path, detail) = match named {
            Some((project, path)) if !trust::is_trusted(&project.root, path) => {
                let detail =
                    format!("{}, named by {FILE} and not run: `ltsc renderers trust` allows it", path.display());
                ("not trusted", String::new(), Some(path.clone()), detail)
            }
            Some((_, path)) => {
                let (cache, configured) = (cache.as_ref(), Some(path.as_path()));
                let search = Search { env: &env, cache, given: None, configured, until: None };
                match find(driver, &search) {
                    Ok(found) => ("configured", found.version, Some(found.path), String::new()),
                    Err(error) => ("not working", String::new(), Some(path.clone()), error.tail().join("; ")),
                }
            }
            None => match status(driver, cache.as_ref(), &env) {
                Status::NotInstalled => ("not installed", String::new(), None, advice(driver)),
                Status::Partial { folder } => (
                    "incomplete",
                    String::new(),
                    Some(folder),
                    format!("ltsc renderers install {} continues", driver.name),
                ),
                Status::Installed { path, version } => {
                    // Its files may have been removed or changed since.
                    let (cache, given) = (cache.as_ref(), Some(path.as_path()));
                    let search = Search { env: &env, cache, given, configured: None, until: None };
                    match find(driver, &search) {
                        Ok(_) => ("installed", version, Some(path), String::new()),
                        Err(_) => {
                            let repair = format!("does not start; ltsc renderers install {} repairs it", driver.name);
                            ("broken", version, Some(path), repair)
                        }
                    }
                }
                Status::External { path, version } => ("found", version, Some(path), String::new()),
            },
        };
        rows.push(json!({
            "name": driver.name, "summary": driver.summary, "target": driver.target, "pinned_version": driver.version,
            "installable": installable(driver), "status": word, "version": version, "path": path,
        }));
        let shown = path.filter(|_| detail.is_empty()).map_or(detail, |path| path.display().to_string());
        let name = terminal::strong(&format!("{:<12}", driver.name), true);
        text.push_str(&format!("{name} {word:<14} {version:<10} {shown}\n"));
        if format == Format::Short {
            continue;
        }
        let which = if installable(driver) { "pinned version" } else { "version" };
        text.push_str(&format!(
            "{:<12} {}; reads target {}, {which} {}\n",
            "", driver.summary, driver.target, driver.version
        ));
    }
    if format == Format::Json {
        terminal::print(&format!("{:#}\n", json!({ "renderers": rows })));
    } else {
        terminal::print(&text);
    }
    Ok(Exit::Done)
}

/// The project of the current folder, if it is one. One that cannot be read is an error.
fn project() -> Result<Option<Project>, Failure> {
    match Project::here() {
        Ok(project) => Ok(Some(project)),
        Err(failure) if failure.exit == Exit::Usage => Ok(None),
        Err(failure) => Err(failure),
    }
}

/// Lets the programs that the project names be run from now on.
fn trust_named() -> Result<Exit, Failure> {
    let project = Project::here()?;
    let file = project.root.join(FILE);
    if project.programs.is_empty() {
        terminal::say(&format!("{} names no program", file.display()));
        return Ok(Exit::Done);
    }
    trust::trust(&project.root, project.programs.values().cloned())
        .map_err(|error| Failure::new(Exit::Environment, format!("this cannot be remembered: {error}")))
        .map_err(|failure| {
            failure.help("set LTSC_CACHE to a folder that can be written, or name the project in LTSC_TRUST")
        })?;
    for (name, program) in &project.programs {
        terminal::say(&format!("{name}: {} is run from now on where {} names it", program.display(), file.display()));
    }
    Ok(Exit::Done)
}

fn installable(driver: &Driver) -> bool {
    !matches!(driver.installation, Installation::User { .. })
}

/// How to come by a renderer, in a few words.
pub fn advice(driver: &Driver) -> String {
    match &driver.installation {
        Installation::Python(_) | Installation::Cargo(_) => format!("ltsc renderers install {}", driver.name),
        Installation::User { source } => {
            format!("by its executable (--executable, ltsc.toml, PATH), built from {source}")
        }
    }
}

fn install_all(names: &[String], force: bool) -> Result<Exit, Failure> {
    let drivers = names.iter().map(|name| driver_called(name)).collect::<Result<Vec<_>, _>>()?;
    let env = Env::of_process();
    let cache = CachePaths::find(&env).ok_or_else(|| {
        Failure::new(Exit::Environment, "there is no cache folder: the system names no home")
            .help("set LTSC_CACHE to a folder")
    })?;
    for driver in drivers {
        let failed = |error: ltsc_render::install::InstallError| {
            let mut message = format!("{}: {error}", driver.name);
            for line in error.tail() {
                message.push_str("\n    ");
                message.push_str(line);
            }
            Failure::new(Exit::Environment, message).help(error.hint())
        };
        if force {
            uninstall(driver, &cache).map_err(failed)?;
        }
        let request = InstallRequest { driver, cache: cache.clone(), env: env.clone(), python: None, cancel: None };
        let mut bar = Bar::new(0, driver.name);
        let installed = install(&request, &mut |progress| match progress {
            InstallProgress::Step(step) => {
                let words = match step {
                    Step::Python => "looking for a Python",
                    Step::Environment => "making a private Python environment",
                    Step::Packages => "downloading and unpacking packages",
                    Step::Cargo => "looking for a cargo",
                    Step::Build => "downloading and building its sources",
                    Step::Verification => "rendering a test image",
                };
                bar.say(&format!("{}: {words}", driver.name));
                terminal::say(&format!("{}: {words}", driver.name));
            }
            InstallProgress::Line(line) => bar.say(&format!("{}: {}", driver.name, line.trim())),
        });
        bar.finish();
        let installed = installed.map_err(failed)?;
        let words = if installed.already { "is there" } else { "installed and verified" };
        terminal::say(&format!("{} {} {words}: {}", driver.name, installed.version, installed.folder.display()));
    }
    Ok(Exit::Done)
}
