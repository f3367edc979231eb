//! `ltsc audit`: generated files, read back from their text, beside the scene.

use std::path::{Path, PathBuf};

use ltsc_core::audit::{Audit, Audited, Emits, Lost, Sums};
use ltsc_core::diag::{Finding, Origin, Severity};
use ltsc_core::files::{Files, VPath};
use ltsc_core::formats::Target;
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;
use serde_json::{Value, json};

use crate::args::{self, Format};
use crate::output::{self, Exit, Failure, Located, why};
use crate::project::{self, Project};
use crate::terminal;
use ltsc_evaluation::disk::DiskFiles;

use super::shared::{CheckedFile, all_files_of, check, overrides, report};

/// A scene with what its files say.
struct Answer<'f> {
    file: &'f CheckedFile,
    scene: Valid,
    audited: Audited,
}

pub fn run(command: &args::Audit) -> Result<Exit, Failure> {
    let only: Vec<&'static Target> =
        command.target.iter().map(|name| project::target(name)).collect::<Result<_, _>>()?;
    let groups = all_files_of(&command.paths, &command.findings)?;
    if command.folder.is_some() && (only.len() != 1 || groups.iter().map(|(_, files)| files.len()).sum::<usize>() != 1)
    {
        return Err(Failure::new(Exit::Usage, "`--folder` goes with one scene and one target")
            .help("for example `ltsc audit ring.lts --target pbrt --folder ring-pbrt-v4`"));
    }
    let mut exit = Exit::Done;
    let mut documents = Vec::new();
    for (project, files) in groups {
        exit = exit.max(one(command, &project, &files, &only, &mut documents)?);
    }
    if command.findings.format == Format::Json && exit <= Exit::No {
        terminal::print(&format!("{:#}\n", json!({ "scenes": documents })));
    }
    Ok(exit)
}

fn one(
    command: &args::Audit,
    project: &Project,
    files: &[PathBuf],
    only: &[&'static Target],
    documents: &mut Vec<Value>,
) -> Result<Exit, Failure> {
    let checked = check(project, files, &command.findings, overrides(&command.settings)?, &[])?;
    let format = command.findings.format;
    if checked.iter().any(|file| file.checked.worst() >= Severity::Deny) {
        return Ok(report(&checked, Vec::new(), format, false, true).0);
    }
    let mut answers = Vec::new();
    for file in &checked {
        let Some(scene) = file.checked.scene.clone() else { continue };
        let Ok((scene, _)) = pipeline::prepare(scene) else {
            let what = format!("{} is not valid", file.path);
            return Err(Failure::new(Exit::Input, what).help("`ltsc build` says why"));
        };
        let audited = audited(command, project, &scene, only)?;
        answers.push(Answer { file, scene, audited });
    }
    let found: Vec<Located<'_>> = answers
        .iter()
        .flat_map(|answer| answer.audited.findings().map(|finding| answer.file.located(finding.clone())))
        .collect();
    let exit = found.iter().map(|located| Exit::of_finding(&located.finding)).max().unwrap_or(Exit::Done);
    if format == Format::Json && exit <= Exit::No {
        documents.extend(answers.iter().map(document));
        return Ok(exit);
    }
    if format == Format::Human {
        terminal::print(&answers.iter().map(table).collect::<Vec<_>>().join("\n"));
    }
    output::findings(&found, None, format, format != Format::Human, true);
    Ok(exit)
}

fn audited(
    command: &args::Audit,
    project: &Project,
    scene: &Valid,
    only: &[&'static Target],
) -> Result<Audited, Failure> {
    let camera = pipeline::camera(scene, command.settings.camera.as_deref())
        .ok_or_else(|| Failure::new(Exit::Usage, format!("the scene `{}` has no such camera", scene.name)))?;
    let open = |folder: &Path| {
        DiskFiles::new(folder)
            .map_err(|error| Failure::new(Exit::Input, format!("{} cannot be read: {}", folder.display(), why(&error))))
    };
    if let Some(folder) = &command.folder {
        let files = Named { files: open(folder)?, folder: folder.clone() };
        let mut audited = pipeline::audit(scene, camera, only, &files, |_| String::new());
        files.name(&mut audited);
        return Ok(audited);
    }
    let folder = command.output.as_deref().unwrap_or(&project.generated).join(&scene.name);
    let there = |target: &&&'static Target| folder.join(target.name).join(target.main_file_of(&scene.name)).is_file();
    let targets: Vec<&'static Target> =
        if only.is_empty() { project.targets.iter().filter(there).copied().collect() } else { only.to_vec() };
    if targets.is_empty() {
        return Err(Failure::new(
            Exit::Input,
            format!("nothing was generated of `{}` in {}", scene.name, folder.display()),
        )
        .help("`ltsc build` writes it"));
    }
    let files = Named { files: open(&folder)?, folder };
    let mut audited = pipeline::audit(scene, camera, &targets, &files, |target| target.name.to_owned());
    files.name(&mut audited);
    Ok(audited)
}

/// Files of a folder, whose paths are shown with the folder.
struct Named {
    files: DiskFiles,
    folder: PathBuf,
}

impl Named {
    fn name(&self, audited: &mut Audited) {
        let name = |finding: &mut Finding| {
            if let Origin::File { path, place: _ } = &mut finding.origin {
                *path = self.folder.join(path.as_str()).display().to_string();
            }
        };
        audited.targets.iter_mut().flat_map(|audit| &mut audit.findings).for_each(name);
    }
}

impl Files for Named {
    fn read(&self, path: &VPath, limit: u64) -> Result<ltsc_core::files::Bytes, ltsc_core::files::ReadError> {
        self.files.read(path, limit)
    }
}

fn document(answer: &Answer<'_>) -> Value {
    let Answer { file, scene, audited } = answer;
    let shapes: Vec<&str> = scene.shapes.values().map(|shape| shape.name.as_str()).collect();
    let emitters = |all: &[(usize, Emits)]| -> Vec<Value> {
        let one = |(at, Emits { power, area, facing, center }): &(usize, Emits)| json!({ "name": shapes.get(*at), "power": power, "area": area, "facing": facing, "center": center });
        all.iter().map(one).collect()
    };
    let sums = |sums: &Sums| {
        let Sums { surfaces, instances, area, emitters, emitting_area, power, lights } = sums;
        json!({
            "surfaces": surfaces, "instances": instances, "area": area, "emitters": emitters,
            "emitting_area": emitting_area, "power": power, "lights": lights,
        })
    };
    let target = |audit: &Audit| {
        let findings: Vec<Value> = audit.findings.iter().map(|finding| file.located(finding.clone()).json()).collect();
        let lost: Vec<Value> =
            audit.lost.iter().map(|Lost { what, why }| json!({ "what": what, "why": why })).collect();
        json!({
            "target": audit.target, "agrees": audit.agrees(), "verdict": audit.whole_verdict(), "lost": lost, "said": sums(&audit.said),
            "emitters": emitters(&audit.emitters), "materials": audit.materials, "angles": audit.angles,
            "max_depth": audit.max_depth, "fov_x": audit.fov_x, "film": audit.film, "findings": findings,
        })
    };
    json!({
        "scene": scene.name,
        "asked": sums(&audited.asked),
        "emitters": emitters(&audited.emitters),
        "targets": audited.targets.iter().map(target).collect::<Vec<_>>(),
    })
}

/// A row for the scene and one for each target.
fn table(answer: &Answer<'_>) -> String {
    let Answer { file: _, scene, audited } = answer;
    let head = [
        "surfaces",
        "instances",
        "area",
        "emitters",
        "emitted power in W (R, G, B)",
        "lights",
        "materials",
        "depth",
        "fov_x",
        "image",
    ];
    let mut rows = vec![std::iter::once(scene.name.as_str()).chain(head).map(str::to_owned).collect::<Vec<_>>()];
    // Seven digits are what single precision holds; what is compared are all of them.
    let number = |value: f64| format!("{value:.6e}").parse().unwrap_or(value).to_string();
    let open = "-".to_owned();
    let sums = |name: &str, sums: &Sums| {
        let Sums { surfaces, instances, area, emitters, emitting_area: _, power, lights } = sums;
        let power = power.map(number).join(", ");
        let area = area.map_or(open.clone(), number);
        vec![
            name.to_owned(),
            surfaces.to_string(),
            instances.to_string(),
            area,
            emitters.to_string(),
            power,
            lights.to_string(),
        ]
    };
    let camera = pipeline::camera(scene, None).map(|camera| scene.cameras[camera].fov_x);
    let mut asked = sums("scene", &audited.asked);
    asked.extend([
        open.clone(),
        scene.integrator.max_depth().to_string(),
        camera.map_or(open.clone(), number),
        format!("{} x {}", scene.film.width, scene.film.height),
    ]);
    rows.push(asked);
    for audit in &audited.targets {
        let mut row = sums(audit.target, &audit.said);
        row.extend([
            audit.materials.to_string(),
            audit.max_depth.map_or(open.clone(), |depth| depth.to_string()),
            audit.fov_x.map_or(open.clone(), number),
            audit.film.map_or(open.clone(), |[width, height]| format!("{width} x {height}")),
            audit.verdict(),
        ]);
        rows.push(row);
    }
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let padded = cells
            .map(|(at, (cell, width))| if at == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") });
        padded.collect::<Vec<_>>().join("  ") + "\n"
    };
    rows.iter().map(line).chain(losses(&audited.targets)).collect()
}

/// A line for each different list of what was lost, with the targets that have it.
fn losses(targets: &[Audit]) -> Vec<String> {
    let mut lists: Vec<(String, Vec<&str>)> = Vec::new();
    for audit in targets.iter().filter(|audit| audit.agrees() && !audit.lost.is_empty()) {
        let verdict = audit.whole_verdict();
        match lists.iter_mut().find(|(known, _)| *known == verdict) {
            Some((_, names)) => names.push(audit.target),
            None => lists.push((verdict, vec![audit.target])),
        }
    }
    lists.iter().map(|(verdict, names)| format!("{}: {verdict}\n", names.join(", "))).collect()
}
