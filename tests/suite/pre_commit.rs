//! The hooks of `.pre-commit-hooks.yaml` in a repository of scenes, with the real `pre-commit`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::outputs::project;
use super::{Ran, ltsc, root, run, skip};

/// The program: the one that `.ci/run` installs, or the user's.
fn pre_commit() -> Option<PathBuf> {
    let own = root().join("target/validators/python/bin/pre-commit");
    let runs =
        |program: &PathBuf| Command::new(program).arg("--version").output().is_ok_and(|ran| ran.status.success());
    [own, PathBuf::from("pre-commit")].into_iter().find(runs)
}

/// A repository with nobody's settings, in which `ltsc` is the binary under test.
struct Repository {
    folder: PathBuf,
    home: PathBuf,
}

impl Repository {
    fn command(&self, program: &Path) -> Command {
        let bin = Path::new(env!("CARGO_BIN_EXE_ltsc")).parent().expect("a folder");
        let mut paths = vec![bin.to_path_buf()];
        paths.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
        let mut command = Command::new(program);
        command
            .current_dir(&self.folder)
            .env("PATH", std::env::join_paths(paths).expect("a search path"))
            .env("HOME", &self.home)
            .env("PRE_COMMIT_HOME", self.home.join("pre-commit"))
            .env("GIT_CONFIG_GLOBAL", self.home.join("gitconfig"))
            .env("GIT_CONFIG_NOSYSTEM", "1")
            .envs([("NO_COLOR", "1"), ("PRE_COMMIT_COLOR", "never"), ("COLUMNS", "100"), ("LC_ALL", "C.UTF-8")]);
        for name in [
            "GIT_DIR",
            "GIT_INDEX_FILE",
            "GIT_WORK_TREE",
            "SKIP",
            "LTSC_FORMAT",
            "LTSC_DENY",
            "LTSC_ALLOW",
            "LTSC_WARN",
        ] {
            command.env_remove(name);
        }
        command
    }

    fn git(&self, args: &[&str]) -> Ran {
        run(self.command(Path::new("git")).args(args))
    }

    fn init(folder: PathBuf, home: &Path) -> Self {
        fs::create_dir_all(&folder).expect("a folder");
        let repository = Self { folder, home: home.to_path_buf() };
        let ran = repository.git(&["init", "--quiet", "--initial-branch", "main"]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        repository
    }

    /// Commits everything; where a hook refuses, its words come back.
    fn commit(&self, more: &[&str]) -> Result<(), String> {
        assert_eq!(self.git(&["add", "--all"]).code, Some(0));
        let ran = self.git(&[&["commit", "--quiet", "--message", "one"], more].concat());
        if ran.code == Some(0) { Ok(()) } else { Err(format!("{}{}", ran.out, ran.err)) }
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.join(name), text).expect("a write");
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.folder.join(name)).expect("a file")
    }
}

/// A repository with a project of one clean scene in which all three hooks are installed.
fn repository(home: &Path, pre_commit: &Path) -> Repository {
    fs::write(
        home.join("gitconfig"),
        "[user]\n    name = A\n    email = a@example.org\n[protocol \"file\"]\n    allow = always\n",
    )
    .expect("a write");
    let hooks = Repository::init(home.join("hooks"), home);
    fs::copy(root().join(".pre-commit-hooks.yaml"), hooks.folder.join(".pre-commit-hooks.yaml")).expect("the hooks");
    hooks.commit(&[]).expect("a commit");
    let revision = hooks.git(&["rev-parse", "HEAD"]).out;

    let scenes = Repository::init(home.join("scenes-repository"), home);
    project(&scenes.folder, &[("one", "")]);
    // The binary under test stands in for the one that `language: rust` would build.
    let hooks_of =
        ["ltsc-lint", "ltsc-fmt", "ltsc-build-check"].map(|id| format!("      - {{id: {id}, language: system}}\n"));
    let config = format!(
        "repos:\n  - repo: {}\n    rev: {}\n    hooks:\n{}",
        hooks.folder.display(),
        revision.trim(),
        hooks_of.concat()
    );
    scenes.write(".pre-commit-config.yaml", &config);
    let built = run(ltsc().arg("build").current_dir(&scenes.folder));
    assert_eq!(built.code, Some(0), "{}", built.err);
    let ran = run(scenes.command(pre_commit).arg("install"));
    assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
    scenes
}

#[test]
fn hooks_let_good_scenes_pass_and_hold_bad_ones_back() {
    let name = "hooks_let_good_scenes_pass_and_hold_bad_ones_back";
    let Some(pre_commit) = pre_commit() else { return skip(name, "pre-commit") };
    if Command::new("git").arg("--version").output().is_err() {
        return skip(name, "git");
    }
    let home = tempfile::tempdir().expect("a folder");
    let scenes = repository(home.path(), &pre_commit);
    let build = || {
        let ran = run(ltsc().arg("build").current_dir(&scenes.folder));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
    };
    scenes.commit(&[]).unwrap_or_else(|words| panic!("a clean project is refused:\n{words}"));
    let clean = scenes.read("scenes/one.lts");

    // A scene that renderers do not agree on.
    let bulb = "emitter bulb = sphere(segments: 8, rings: 4) |> translate(z: 3) with radiance(1)\n";
    scenes.write("scenes/one.lts", &format!("{clean}{bulb}"));
    let words = scenes.commit(&[]).expect_err("a smooth emitter is committed");
    assert!(words.contains("smooth-emitter") && words.contains("scenes/one.lts:"), "{words}");
    assert_eq!(scenes.git(&["rev-list", "--count", "HEAD"]).out.trim(), "1", "nothing was committed");

    // Mended, but what is generated from it is old.
    let ran = run(ltsc().args(["lint", "--fix"]).current_dir(&scenes.folder));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let words = scenes.commit(&[]).expect_err("stale files are committed");
    assert!(
        words.contains("stale: ") && words.contains("bulb.ply") && !words.contains("error[smooth-emitter]"),
        "{words}"
    );
    build();
    scenes.commit(&[]).unwrap_or_else(|words| panic!("the mended scene is refused:\n{words}"));

    // Another form: the hook writes the canonical one and stops; what it wrote passes.
    let formatted = scenes.read("scenes/one.lts");
    scenes.write("scenes/one.lts", &format!("{}\n\n", formatted.replace("film = ", "film   =   ")));
    let words = scenes.commit(&[]).expect_err("another form is committed");
    assert!(words.contains("files were modified by this hook"), "{words}");
    assert_eq!(scenes.read("scenes/one.lts"), formatted);

    // A bad scene that came past the hooks is none of the next commit's business, which checks what changed.
    project(&scenes.folder, &[("broken", "shape a = nothing with diffuse(0.5)\n")]);
    scenes.commit(&["--no-verify"]).expect("a commit past the hooks");
    let files = |names: &[&str]| {
        let ran = run(scenes.command(&pre_commit).args(["run", "ltsc-lint", "--files"]).args(names));
        (ran.code, ran.out)
    };
    let (code, words) = files(&["scenes/one.lts"]);
    assert!(code == Some(0) && words.contains("Passed"), "{words}");
    let (code, words) = files(&["scenes/one.lts", "scenes/broken.lts"]);
    assert!(code == Some(1) && words.contains("broken.lts:") && !words.contains("one.lts:"), "{words}");
    let (code, words) = files(&["ltsc.toml", "generated/one/manifest.json"]);
    assert!(code == Some(0) && words.contains("no files to check"), "{words}");
    let (code, words) = files(&["scenes/one.lts", "ltsc.toml"]);
    assert_eq!(code, Some(0), "{words}");

    // A library is checked with the scenes that use it, and no others.
    fs::create_dir(scenes.folder.join("scenes/lib")).expect("a folder");
    let lamp = "use bulb from \"lib/lamps.lts\"\nemitter bulb = bulb |> translate(z: 3) with radiance(1)\n";
    project(&scenes.folder, &[("lamp", lamp)]);
    scenes.write("scenes/lib/lamps.lts", "lts 1\n\nmesh bulb = box(size: 1)\n");
    let (code, words) = files(&["scenes/lib/lamps.lts"]);
    assert_eq!(code, Some(0), "{words}");
    scenes.write("scenes/lib/lamps.lts", "lts 1\n\nmesh bulb = sphere(segments: 8, rings: 4)\n");
    let (code, words) = files(&["scenes/lib/lamps.lts"]);
    assert!(code == Some(1) && words.contains("smooth-emitter") && words.contains("scenes/lamp.lts:"), "{words}");
    assert!(!words.contains("broken.lts"), "{words}");

    project(&scenes.folder, &[("another", "")]);
    assert_eq!(scenes.git(&["add", "scenes/another.lts"]).code, Some(0));
    let ran = run(scenes.command(&pre_commit).args(["run", "ltsc-lint"]));
    assert!(ran.code == Some(0) && ran.out.contains("Passed"), "{}", ran.out);
}

#[test]
fn documented_hooks_are_those_that_there_are() {
    let hooks = fs::read_to_string(root().join(".pre-commit-hooks.yaml")).expect("the hooks");
    let page = fs::read_to_string(root().join("docs/repository.md")).expect("the page");
    let ids: Vec<&str> = hooks.lines().filter_map(|line| line.strip_prefix("- id: ")).collect();
    assert_eq!(ids, ["ltsc-lint", "ltsc-fmt", "ltsc-build-check"]);
    for id in ids {
        assert!(page.contains(&format!("- id: {id}")), "docs/repository.md does not show {id}");
    }
}
