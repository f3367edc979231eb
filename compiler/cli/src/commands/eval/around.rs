//! What lies around an evaluation file: the scenes of its project, and files beside it.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ltsc_core::diag::Severity;
use ltsc_core::eval::{self, Overrides};
use ltsc_core::formats::Target;
use ltsc_core::pipeline;
use ltsc_evaluation::file::Surroundings;
use ltsc_evaluation::file::model::{Evaluation, Source};
use ltsc_evaluation::reference;
use ltsc_evaluation::study::Loaded;
use rayon::prelude::*;

use crate::args;
use crate::output::{Exit, Failure};
use crate::project::{self, Project};

use super::super::shared::{CheckedFile, check, disk_of, report};

/// The project of an evaluation file.
pub struct Around<'c> {
    /// The project.
    pub project: Project,
    /// The folder of the file.
    pub base: PathBuf,
    findings: &'c args::Findings,
    /// Scenes of the project by name.
    scenes: BTreeMap<String, PathBuf>,
    /// Parameters of scenes that were asked for.
    parameters: Mutex<BTreeMap<PathBuf, Option<Vec<String>>>>,
}

impl<'c> Around<'c> {
    /// Of the evaluation file at `path`.
    pub fn of(path: &Path, findings: &'c args::Findings) -> Result<Self, Failure> {
        let base = path.parent().filter(|base| !base.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let project = Project::of(base)?;
        let files = project::scene_files(&project.scenes).map(|found| found.files).unwrap_or_default();
        let disk = disk_of(&project, findings)?;
        let limits = project::limits_with(project.limits, &findings.limits)?;
        let named = |file: &PathBuf| Some((eval::header(&disk, &disk.path_of(file)?, limits)?.0, file.clone()));
        let scenes = files.par_iter().filter_map(named).collect::<Vec<_>>().into_iter().collect();
        let base = base.to_path_buf();
        Ok(Self { project, base, findings, scenes, parameters: Mutex::default() })
    }

    fn known(&self) -> std::sync::MutexGuard<'_, BTreeMap<PathBuf, Option<Vec<String>>>> {
        self.parameters.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The file of a scene.
    fn file(&self, scene: &Source) -> Option<PathBuf> {
        match scene {
            Source::Name(name) => self.scenes.get(name).cloned(),
            Source::File(file) => Some(self.base.join(file)).filter(|file| file.is_file()),
        }
    }

    /// All conditions of an evaluation, read and made ready; what forbids to go on is printed.
    pub fn conditions(&self, evaluation: &Evaluation) -> Result<Result<Vec<Loaded>, Exit>, Failure> {
        // Files of one project are read through one door; scenes elsewhere belong to their own.
        let load = |at: usize| {
            let condition = &evaluation.conditions[at];
            let source = &evaluation.scenes[condition.scene].source;
            let missing = || Failure::new(Exit::Input, format!("the scene `{}` is not there any more", condition.name));
            self.load(&self.file(source).ok_or_else(missing)?, &condition.set)
        };
        let made: Vec<_> = (0..evaluation.conditions.len()).into_par_iter().map(load).collect();
        let (mut loaded, mut refused) = (Vec::new(), Vec::new());
        for one in made {
            match one? {
                Ok(scene) => loaded.push(scene),
                Err(file) => refused.push(*file),
            }
        }
        if refused.is_empty() {
            return Ok(Ok(loaded));
        }
        let (exit, _) = report(&refused, Vec::new(), self.findings.format, false, true);
        Ok(Err(if exit == Exit::Done { Exit::Input } else { exit }))
    }

    /// A scene with values of its parameters; its findings where they forbid to go on.
    fn load(&self, file: &Path, set: &[(String, String)]) -> Result<Result<Loaded, Box<CheckedFile>>, Failure> {
        let elsewhere;
        let real = std::fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
        let project = if self.project.declared && real.starts_with(&self.project.root) {
            &self.project
        } else {
            elsewhere = Project::of(file)?;
            &elsewhere
        };
        let overrides = Overrides { set: set.to_vec(), ..Overrides::default() };
        let files = check(project, &[file.to_path_buf()], self.findings, overrides, &[])?;
        let Some(mut checked) = files.into_iter().next() else {
            return Err(Failure::new(Exit::Fault, format!("{} was not looked at", file.display())));
        };
        if checked.checked.worst() >= Severity::Deny {
            return Ok(Err(Box::new(checked)));
        }
        let Some(scene) = checked.checked.scene.take() else {
            return Err(Failure::new(Exit::Input, format!("{} has no scene", file.display())));
        };
        match pipeline::prepare(scene) {
            Ok((scene, remarks)) => {
                let lost = checked.checked.losses().chain(&remarks).cloned().collect();
                Ok(Ok(Loaded { scene, lost, choices: project.choices.clone() }))
            }
            Err(wrong) => {
                checked.checked.findings.extend(wrong);
                Ok(Err(Box::new(checked)))
            }
        }
    }
}

impl Surroundings for Around<'_> {
    fn scenes(&self) -> Vec<String> {
        self.scenes.keys().cloned().collect()
    }

    fn missing(&self, scene: &Source) -> Option<String> {
        if self.file(scene).is_some() {
            return None;
        }
        Some(match scene {
            Source::Name(name) => format!("the project has no scene `{name}`"),
            Source::File(file) => format!("there is no file `{file}`"),
        })
    }

    fn lacks(&self, _scene: &Source, _target: &'static Target) -> Option<String> {
        // What a scene asks for is known when it is written for the target, with the settings of each case.
        None
    }

    fn parameters(&self, scene: &Source) -> Option<Vec<String>> {
        let file = self.file(scene)?;
        if let Some(known) = self.known().get(&file) {
            return known.clone();
        }
        let project = Project::of(&file).ok()?;
        let files = check(&project, std::slice::from_ref(&file), self.findings, Overrides::default(), &[]).ok();
        let found = files.and_then(|files| files.into_iter().next()).filter(|one| one.checked.scene.is_some());
        let names = found.map(|one| one.checked.parameters.into_iter().map(|parameter| parameter.name).collect());
        self.known().insert(file, names.clone());
        names
    }

    fn has_file(&self, path: &str) -> bool {
        self.base.join(path).is_file()
    }

    fn reference(&self, scene: &Source, target: &'static Target) -> Option<String> {
        let (Source::Name(name) | Source::File(name)) = scene;
        let stem = Path::new(name).file_stem()?.to_str()?;
        let file = reference::file_of(&reference::folder(&self.project.root), stem, target.name)?;
        relative(&self.base, &file)
    }
}

/// A file as it is seen from a folder.
fn relative(folder: &Path, file: &Path) -> Option<String> {
    let (folder, file) = (std::fs::canonicalize(folder).ok()?, std::fs::canonicalize(file).ok()?);
    let parts = |path: &Path| path.components().map(|part| part.as_os_str().to_owned()).collect::<Vec<_>>();
    let (from, to) = (parts(&folder), parts(&file));
    let same = from.iter().zip(&to).take_while(|(one, other)| one == other).count();
    let up = std::iter::repeat_n(Component::ParentDir.as_os_str().to_owned(), from.len() - same);
    let path: PathBuf = up.chain(to[same..].iter().cloned()).collect();
    path.to_str().map(|text| text.replace(std::path::MAIN_SEPARATOR, "/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_seen_from_a_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |path: &str| folder.path().join(path);
        std::fs::create_dir_all(path("scenes/eval")).expect("folders");
        std::fs::write(path("a.exr"), "").expect("a file");
        assert_eq!(relative(&path("scenes/eval"), &path("a.exr")).as_deref(), Some("../../a.exr"));
        assert_eq!(relative(folder.path(), &path("a.exr")).as_deref(), Some("a.exr"));
        assert_eq!(relative(folder.path(), &path("b.exr")), None);
    }
}
