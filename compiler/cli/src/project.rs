//! The project that a command works on: `ltsc.toml`, and the scenes below a folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ltsc_core::eval::{Limit, Limits};
use ltsc_core::formats::{self, ChoiceError, Choices, TARGETS, Target};
use ltsc_core::lint::{Level, LevelError, Levels};
use ltsc_render::regular;
use serde::Deserialize;
use toml::Spanned;

use crate::args;
use crate::output::{Exit, Failure, why};
use crate::trust;

/// The name of the project file.
pub const FILE: &str = "ltsc.toml";

/// What `ltsc.toml` says. Unknown keys are errors.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    scenes: Option<String>,
    generated: Option<String>,
    targets: Option<Vec<String>>,
    #[serde(default)]
    options: Vec<String>,
    #[serde(default)]
    rules: BTreeMap<Spanned<String>, Spanned<String>>,
    #[serde(default)]
    limits: BTreeMap<String, Amount>,
    #[serde(default)]
    renderers: BTreeMap<String, RendererText>,
}

/// A limit: `100_000`, or `"64MiB"`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Amount {
    Number(i64),
    Text(String),
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RendererText {
    executable: Option<PathBuf>,
}

/// A project, or what stands in for one.
pub struct Project {
    /// Scenes read files below this folder only.
    pub root: PathBuf,
    /// Whether there is an `ltsc.toml`.
    pub declared: bool,
    /// Where scenes are looked for.
    pub scenes: PathBuf,
    /// Where they are generated.
    pub generated: PathBuf,
    /// For what they are generated.
    pub targets: Vec<&'static Target>,
    /// What targets do only because it is asked for.
    pub choices: Choices,
    /// Rule levels that differ from the built-in ones.
    pub levels: Levels,
    /// How large scenes may become.
    pub limits: Limits,
    /// Programs of renderers, by the renderer's name. They are run only where the user has allowed it: [`Project::program`].
    pub programs: BTreeMap<String, PathBuf>,
}

/// Whether a folder has something called `ltsc.toml`; what is no regular file is refused when it is read.
fn has_file(folder: &Path) -> bool {
    fs::symlink_metadata(folder.join(FILE)).is_ok_and(|meta| !meta.is_dir())
}

/// The root of the project in which a file lies by its own name, wherever a link leads: the nearest folder upward with an `ltsc.toml`, else
/// the folder of the file.
pub fn around(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    folder.ancestors().find(|folder| has_file(folder)).unwrap_or(&folder).to_path_buf()
}

/// Rules for files outside of projects: a draft need not be documented. What the command line or the variables say is stronger.
fn draft_levels() -> Levels {
    let mut levels = Levels::default();
    // The rule is there, as a test shows.
    let _known = levels.set("undocumented-scene", Level::Allow);
    levels
}

impl Project {
    /// The project of `path`: the nearest folder upward with an `ltsc.toml`; without one, the folder itself, or for a
    /// file the parent of its folder.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        let real = fs::canonicalize(path).map_err(|error| {
            Failure::new(Exit::Input, format!("{} cannot be read: {}", path.display(), why(&error)))
        })?;
        if let Some(folder) = real.ancestors().find(|folder| has_file(folder)) {
            return Self::load(folder);
        }
        let folder = if real.is_dir() { real.as_path() } else { real.parent().unwrap_or(Path::new("/")) };
        let root = if real.is_dir() { folder } else { folder.parent().unwrap_or(folder) };
        // A folder of scenes is left to them; beside one scene there is room.
        let beside = if real.is_dir() { folder.parent().unwrap_or(folder) } else { folder }.join("generated");
        Ok(Self {
            root: root.to_path_buf(),
            declared: false,
            scenes: folder.to_path_buf(),
            generated: beside,
            targets: TARGETS.iter().collect(),
            choices: Choices::default(),
            levels: draft_levels(),
            limits: Limits::default(),
            programs: BTreeMap::new(),
        })
    }

    /// The project that the current folder belongs to; it must have an `ltsc.toml`.
    pub fn here() -> Result<Self, Failure> {
        let current = std::env::current_dir()
            .map_err(|error| Failure::new(Exit::Environment, format!("the current folder is not there: {error}")))?;
        match current.ancestors().find(|folder| has_file(folder)) {
            Some(folder) => Self::load(folder),
            None => Err(Failure::new(Exit::Usage, format!("there is no `{FILE}` in this folder or above it"))
                .help("name a scene or a folder of scenes, or make a project with `ltsc init`; an empty `ltsc.toml` looks for scenes in `scenes-src`, one that says `scenes = \".\"` beside it")),
        }
    }

    fn load(folder: &Path) -> Result<Self, Failure> {
        let file = folder.join(FILE);
        let bad = |message: String| Failure::new(Exit::Input, format!("{}: {message}", file.display()));
        let text = regular::read_text(&file, regular::TEXT).map_err(|error| bad(error.to_string()))?;
        let here = |problem: Failure| Failure { help: problem.help, ..bad(problem.message) };
        let Text { scenes, generated, targets, options, rules, limits: given, renderers } =
            toml::from_str(&text).map_err(|error| bad(error.to_string().trim_end().to_owned()))?;
        let inside = |key: &str, value: Option<String>, default: &str| {
            let value = value.unwrap_or_else(|| default.to_owned());
            if value == "." {
                return Ok(folder.to_path_buf());
            }
            let path = ltsc_core::files::VPath::resolve("", value.trim_end_matches('/'));
            path.map(|path| folder.join(path.as_str())).map_err(|error| bad(format!("`{key}`: {error}")))
        };
        let targets = match targets {
            None => TARGETS.iter().collect(),
            Some(names) => {
                let mut known: Vec<&'static Target> = Vec::new();
                for name in &names {
                    let target = target(name).map_err(here)?;
                    if !known.iter().any(|other| other.name == target.name) {
                        known.push(target);
                    }
                }
                if known.is_empty() {
                    return Err(bad("`targets` is empty".to_owned()).help("leave it out for all targets"));
                }
                known
            }
        };
        let mut choices = Choices::default();
        for option in &options {
            choices
                .add(option)
                .map_err(|ChoiceError { message, help }| bad(format!("`options`: {message}")).help(help))?;
        }
        let levels = levels_of(&rules).map_err(|(at, problem)| {
            let before = text.get(..at).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
            Failure::new(Exit::Input, format!("{}:{line}:{column}: {}", file.display(), problem.message))
                .help(problem.help)
        })?;
        let mut limits = Limits::default();
        for (name, amount) in given {
            let amount = match amount {
                Amount::Number(number) => number.to_string(),
                Amount::Text(text) => text,
            };
            set_limit(&mut limits, &name, &amount).map_err(here)?;
        }
        let mut programs = BTreeMap::new();
        for (name, RendererText { executable }) in renderers {
            let driver =
                ltsc_render::run::driver(&name).ok_or_else(|| bad(format!("there is no renderer `{name}`")))?;
            if let Some(executable) = executable {
                // A bare name is looked up on PATH by the system; a path is seen from the project's folder.
                let plain = executable.components().count() == 1;
                programs.insert(driver.name.to_owned(), if plain { executable } else { folder.join(executable) });
            }
        }
        Ok(Self {
            root: folder.to_path_buf(),
            declared: true,
            scenes: inside("scenes", scenes, "scenes-src")?,
            generated: inside("generated", generated, "generated")?,
            targets,
            choices,
            levels,
            limits,
            programs,
        })
    }

    /// The program that the project names for a renderer, if the user allows that it is run.
    pub fn program(&self, renderer: &str) -> Result<Option<&Path>, Failure> {
        let Some(program) = self.programs.get(renderer) else { return Ok(None) };
        if trust::is_trusted(&self.root, program) {
            return Ok(Some(program));
        }
        let file = self.root.join(FILE);
        let message = format!("{} names {} for {renderer}, and it was not run", file.display(), program.display());
        Err(Failure::new(Exit::Environment, message).help(format!(
            "if you trust this project, run `ltsc renderers trust` in it, or set LTSC_TRUST={}",
            self.root.display()
        )))
    }

    /// The choices with those of the command line, each of which must be one of a target that is written.
    pub fn choices_with(&self, options: &[String], targets: &[&'static Target]) -> Result<Choices, Failure> {
        let mut choices = self.choices.clone();
        for option in options {
            let wrong =
                |ChoiceError { message, help }| Failure::new(Exit::Usage, format!("--option: {message}")).help(help);
            let target = choices.add(option).map_err(wrong)?;
            if !targets.iter().any(|written| written.name == target.name) {
                let message = format!("--option: `{option}` is one of `{}`, which is not written", target.name);
                return Err(Failure::new(Exit::Usage, message)
                    .help(format!("leave it out, or write with `--target {}`", target.name)));
            }
        }
        Ok(choices)
    }

    /// The levels with what the variables `LTSC_ALLOW`, `LTSC_WARN`, `LTSC_DENY` and, stronger, the command line say.
    pub fn levels_with(&self, findings: &args::Findings) -> Result<Levels, Failure> {
        let mut levels = self.levels.clone();
        let of = |variable: &str| std::env::var(variable).unwrap_or_default();
        let variables = ["LTSC_ALLOW", "LTSC_WARN", "LTSC_DENY"].map(|name| (name, of(name)));
        let split = |text: &str| -> Vec<String> {
            text.split(',').map(str::trim).filter(|word| !word.is_empty()).map(str::to_owned).collect()
        };
        let [allow, warn, deny] = variables.each_ref().map(|(_, text)| split(text));
        set(&mut levels, [&allow, &warn, &deny]).map_err(|(at, problem)| usage(variables[at].0, problem))?;
        set(&mut levels, [&findings.allow, &findings.warn, &findings.deny])
            .map_err(|(at, problem)| usage(["--allow", "--warn", "--deny"][at], problem))?;
        Ok(levels)
    }
}

/// Limits with what the command line says about them.
pub fn limits_with(mut limits: Limits, given: &args::Limits) -> Result<Limits, Failure> {
    for text in &given.limit {
        let Some((name, amount)) = text.split_once('=') else {
            return Err(Failure::new(Exit::Usage, format!("`--limit {text}` has no number"))
                .help("write for example `--limit triangles=100_000_000`"));
        };
        set_limit(&mut limits, name.trim(), amount.trim())?;
    }
    Ok(limits)
}

fn set_limit(limits: &mut Limits, name: &str, amount: &str) -> Result<(), Failure> {
    let wrong = |message: String| Failure::new(Exit::Usage, message);
    let Some(limit) = Limit::find(name) else {
        let known: Vec<&str> = Limit::ALL.iter().map(|limit| limit.name).collect();
        let failure = wrong(format!("there is no limit `{name}`"));
        return Err(match ltsc_core::diag::nearest(name, known.iter().copied()) {
            Some(similar) => failure.help(format!("did you mean `{similar}`?")),
            None => failure.help(format!("known: {}", known.join(", "))),
        });
    };
    let value = ltsc_core::eval::parse_amount(amount).ok_or_else(|| {
        wrong(format!("the limit `{name}` is a number of {}, not `{amount}`", limit.what))
            .help("write for example 100_000_000 or 64MiB")
    })?;
    limit.set(limits, value).map_err(wrong)
}

fn usage(place: &str, LevelError { message, help }: LevelError) -> Failure {
    Failure::new(Exit::Usage, format!("{place}: {message}")).help(help)
}

/// Sets what one source says, groups before codes; a problem comes with the level's place in `Level`'s order.
fn set(levels: &mut Levels, said: [&[String]; 3]) -> Result<(), (usize, LevelError)> {
    let order = [Level::Allow, Level::Warn, Level::Deny];
    let group = |name: &str| Levels::GROUPS.iter().any(|(group, _)| *group == name);
    for groups in [true, false] {
        for (at, (level, names)) in order.into_iter().zip(said).enumerate() {
            for name in names.iter().filter(|name| group(name) == groups) {
                levels.set(name, level).map_err(|problem| (at, problem))?;
            }
        }
    }
    Ok(())
}

/// The levels of a project file; a problem comes with its byte.
fn levels_of(rules: &BTreeMap<Spanned<String>, Spanned<String>>) -> Result<Levels, (usize, LevelError)> {
    let mut levels = Levels::default();
    let group = |name: &str| Levels::GROUPS.iter().any(|(group, _)| *group == name);
    for groups in [true, false] {
        for (name, word) in rules.iter().filter(|(name, _)| group(name.get_ref()) == groups) {
            let level = Level::from_word(word.get_ref()).ok_or_else(|| {
                let message = format!("`{}` is no level", word.get_ref());
                (word.span().start, LevelError { message, help: "a level is `allow`, `warn` or `deny`".to_owned() })
            })?;
            levels.set(name.get_ref(), level).map_err(|problem| (name.span().start, problem))?;
        }
    }
    Ok(levels)
}

/// Where a folder lies in its repository, the nearest one upward with a `.git`: empty, or with a `/` at its end. A folder in no
/// repository is its own.
pub fn prefix(folder: &Path) -> String {
    let Ok(folder) = fs::canonicalize(folder) else { return String::new() };
    let repository = folder.ancestors().find(|folder| folder.join(".git").exists()).unwrap_or(&folder);
    let Ok(below) = folder.strip_prefix(repository) else { return String::new() };
    below.components().map(|part| format!("{}/", part.as_os_str().to_string_lossy())).collect()
}

/// The target called `name`.
pub fn target(name: &str) -> Result<&'static Target, Failure> {
    if let Some(target) = formats::find(name) {
        return Ok(target);
    }
    let names = TARGETS.iter().flat_map(|target| std::iter::once(target.name).chain(target.aliases.iter().copied()));
    let failure = Failure::new(Exit::Usage, format!("there is no target `{name}`"));
    Err(match ltsc_core::diag::nearest(name, names.clone()) {
        Some(similar) => failure.help(format!("did you mean `{similar}`?")),
        None => failure.help(format!("known: {}", names.collect::<Vec<_>>().join(", "))),
    })
}

/// Scene files that were looked for.
#[derive(Default)]
pub struct Found {
    /// In the order of their paths.
    pub files: Vec<PathBuf>,
    /// Folders that cannot be read: they do not hide what lies beside them.
    pub problems: Vec<Failure>,
}

/// The scene files that `path` stands for: itself, or all `.lts` files below it, sorted. Hidden folders and links to
/// folders are passed over.
pub fn scene_files(path: &Path) -> Result<Found, Failure> {
    files_ending(path, &["lts"])
}

/// The file that `path` stands for, or all files below it whose names end in one of `endings` (in small letters, without the dot),
/// as [`scene_files`] finds them.
pub fn files_ending(path: &Path, endings: &[&str]) -> Result<Found, Failure> {
    let unreadable = |path: &Path, error: std::io::Error| {
        Failure::new(Exit::Input, format!("{} cannot be read: {}", path.display(), why(&error)))
    };
    let ends = |path: &Path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        ending.is_some_and(|ending| endings.contains(&ending.as_str()))
    };
    let meta = fs::metadata(path).map_err(|error| unreadable(path, error))?;
    if !meta.is_dir() {
        return Ok(Found { files: vec![path.to_path_buf()], problems: Vec::new() });
    }
    let Found { files: mut found, mut problems } = Found::default();
    let mut folders = vec![path.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) => {
                problems.push(unreadable(&folder, error));
                continue;
            }
        };
        for entry in entries {
            let kind = entry.and_then(|entry| Ok((entry.file_type()?, entry)));
            let (kind, entry) = match kind {
                Ok(both) => both,
                Err(error) => {
                    problems.push(unreadable(&folder, error));
                    continue;
                }
            };
            if entry.file_name().as_encoded_bytes().starts_with(b".") {
                continue;
            }
            if kind.is_dir() {
                folders.push(entry.path());
            } else if ends(&entry.path()) {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    problems.sort_by(|a, b| a.message.cmp(&b.message));
    if found.is_empty() && problems.is_empty() {
        return Err(Failure::new(Exit::Usage, format!("there is no scene below {}", path.display()))
            .help(format!("scenes are files ending in `.{}`", endings.join("`, `."))));
    }
    Ok(Found { files: found, problems })
}
