//! `ltsc renderers`: which renderers there are, and private installations of them.

use ltsc_render::cache::CachePaths;
use ltsc_render::env::Env;
use ltsc_render::install::{InstallProgress, InstallRequest, Status, Step, install, status, uninstall};
use ltsc_render::run::DRIVERS;
use serde_json::json;

use crate::args::{Format, Renderers, RenderersAction};
use crate::output::{Exit, Failure};
use crate::terminal::{self, Bar};

use super::render::find_driver;

pub fn run(command: &Renderers) -> Result<Exit, Failure> {
    match &command.action {
        RenderersAction::List { format } => list(*format),
        RenderersAction::Install { names, force } => install_all(names, *force),
    }
}

fn list(format: Format) -> Result<Exit, Failure> {
    let env = Env::of_process();
    let cache = CachePaths::find(&env);
    let mut rows = Vec::new();
    let mut text = String::new();
    for driver in DRIVERS {
        let status = status(driver, cache.as_ref(), &env);
        let (word, version, path) = match &status {
            Status::NotInstalled => ("not installed", "", None),
            Status::Partial { folder } => ("incomplete", "", Some(folder)),
            Status::Installed { path, version } => ("installed", version.as_str(), Some(path)),
            Status::External { path, version } => ("found", version.as_str(), Some(path)),
        };
        rows.push(json!({
            "name": driver.name, "summary": driver.summary, "target": driver.target, "pinned_version": driver.version,
            "status": word, "version": version, "path": path,
        }));
        let detail = match &status {
            Status::NotInstalled => format!("ltsc renderers install {}", driver.name),
            Status::Partial { .. } => format!("ltsc renderers install {} continues", driver.name),
            Status::Installed { path, .. } | Status::External { path, .. } => path.display().to_string(),
        };
        let name = terminal::strong(&format!("{:<12}", driver.name), true);
        text.push_str(&format!("{name} {word:<14} {version:<10} {detail}\n"));
        text.push_str(&format!(
            "{:<12} {}; reads target {}, pinned version {}\n",
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

fn install_all(names: &[String], force: bool) -> Result<Exit, Failure> {
    let drivers = names.iter().map(|name| find_driver(name)).collect::<Result<Vec<_>, _>>()?;
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
