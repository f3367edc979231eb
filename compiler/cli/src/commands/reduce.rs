//! `ltsc reduce`: the smallest scene on which two renderers still differ.

use std::path::PathBuf;

use ltsc_core::eval::Overrides;
use ltsc_core::pipeline;
use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::compare::verdict::Tolerance;
use ltsc_evaluation::job::{Runner, driver_called};
use ltsc_evaluation::reduce::{Question, check, write};
use serde_json::json;

use crate::args::{Format, Reduce};
use crate::output::{Exit, Failure};
use crate::terminal::{self, Watcher};

use super::said::from_here;
use super::shared::one;

pub fn run(command: &Reduce) -> Result<Exit, Failure> {
    let [a, b] = command.renderer.as_slice() else {
        return Err(Failure::new(Exit::Usage, "two renderers differ, or one from itself")
            .help("write for example `--renderer mitsuba-3,luxcore`; the first is the reference"));
    };
    let scene = match one(&command.scene, &command.findings, &command.settings)? {
        Ok(scene) => scene,
        Err(exit) => return Ok(exit),
    };
    let name = scene.scene.name.clone();
    let folder = command.output.clone().unwrap_or_else(|| PathBuf::from(format!("./{name}-reduced")));
    check(&name, &folder, command.force)?;
    let find = |name: &str| {
        let driver = driver_called(name)?;
        Runner::find(driver, None, scene.project.program(driver.name)?, None)
    };
    let (a, b) = (find(a)?, find(b)?);
    let cache = a.cache.clone().ok_or_else(|| {
        Failure::new(Exit::Environment, "the system names no cache folder").help("set LTSC_CACHE to a folder")
    })?;
    let size = Overrides {
        width: command.settings.width.or(Some(command.size)),
        height: command.settings.height.or(Some(command.size)),
        ..Overrides::default()
    };
    let scene = pipeline::override_settings(scene.scene, &size).map_err(|wrong| {
        let first = wrong.first().map(|finding| finding.message.clone()).unwrap_or_default();
        Failure::new(Exit::Input, format!("the scene `{name}` cannot be rendered so: {first}"))
    })?;
    let question = Question {
        a: &a,
        b: &b,
        samples: command.settings.samples.unwrap_or(1024),
        tolerance: Tolerance { tiles: command.tolerance, whole: command.mean_tolerance },
        tiles: command.tiles as usize,
        store: &Store::of(&cache),
    };
    let reduced = question.reduce(scene.into_inner(), &mut Watcher::default())?;
    write(&reduced, &folder, command.force)?;
    let (before, after) = reduced.things;
    if command.findings.format == Format::Json {
        terminal::print(&format!(
            "{:#}\n",
            json!({
                "folder": folder, "things_before": before, "things_after": after, "scenes_rendered": reduced.tried,
                "steps": reduced.steps, "verdict": reduced.shown.verdict,
            })
        ));
        return Ok(Exit::Done);
    }
    for step in &reduced.steps {
        terminal::print(&format!("{step}\n"));
    }
    terminal::say(&format!(
        "{} written: {after} of {before} surfaces, instances and lights; begin with report.md",
        from_here(&folder)
    ));
    Ok(Exit::Done)
}
