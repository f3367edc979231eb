//! What a new user meets: a project from nothing, all errors in one run, slips of other languages, parameters.

use std::fs;
use std::path::Path;

use super::{Ran, ltsc, run};

/// A scene without findings, with `statements` behind it.
fn scene(name: &str, statements: &str) -> String {
    format!(
        "lts 1\n\n/// A block on a floor.\n///\n/// Lit from above.\nscene {name} {{\n    paths: [\"LDE\"]\n}}\n\n\
         camera = perspective(eye: (0, -10, 3), target: (0, 0, 1.5), fov_x: 40deg)\nfilm = image(16, 16)\n\
         integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
         shape floor = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(0.5)\n\
         emitter lamp = rectangle(x: -1..1, y: -1..1, z: 6, normal: -Z) with radiance(20)\n{statements}"
    )
}

/// A project with these scenes.
fn project(scenes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("ltsc.toml"), "").expect("a project");
    fs::create_dir(folder.path().join("scenes-src")).expect("a folder");
    for (name, statements) in scenes {
        let path = folder.path().join(format!("scenes-src/{name}.lts"));
        fs::write(path, scene(name, statements)).expect("a scene");
    }
    folder
}

fn at(folder: &Path, arguments: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).args(arguments))
}

#[test]
fn a_new_project_lints_and_builds() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = at(folder.path(), &["init", "suite"]);
    assert_eq!(made.code, Some(0), "{}{}", made.out, made.err);
    assert!(made.out.contains("next:") && made.out.contains("cd suite"), "{}", made.out);
    let suite = folder.path().join("suite");
    let lint = at(&suite, &["lint", "--deny", "warnings"]);
    assert_eq!((lint.code, lint.out.as_str()), (Some(0), ""), "{}", lint.err);
    assert_eq!(at(&suite, &["fmt", "--check"]).code, Some(0));
    for _ in 0..2 {
        // Also where nothing is to be done, it says where to look.
        let built = at(&suite, &["build"]);
        assert_eq!(built.code, Some(0), "{}", built.err);
        assert!(built.err.contains("generated/first/mitsuba-3/scene.xml"), "{}", built.err);
    }
    let before = fs::read_to_string(suite.join("ltsc.toml")).expect("a project");
    let again = at(&suite, &["init"]);
    assert!(again.code == Some(2) && again.err.contains("is there already"), "{}", again.err);
    assert_eq!(fs::read_to_string(suite.join("ltsc.toml")).expect("a project"), before);
}

#[test]
fn all_errors_of_all_files_come_in_one_run() {
    let folder = project(&[("a", "shape x = box(siz: 1) with diffuse(0.5)\n"), ("b", "let y = unknown\n")]);
    let scenes = folder.path().join("scenes-src");
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        let outside = tempfile::tempdir().expect("a folder");
        let other = outside.path().join("c.lts");
        fs::write(&other, scene("c", "")).expect("a scene");
        std::os::unix::fs::symlink(&other, scenes.join("c.lts")).expect("a link");
        for name in [&b"new\nline.lts"[..], b"back\\slash.lts", b"latin\xe9.lts"] {
            fs::write(scenes.join(std::ffi::OsStr::from_bytes(name)), scene("d", "")).expect("a scene");
        }
        let ran = at(folder.path(), &["lint", "--format", "short"]);
        assert_eq!(ran.code, Some(3), "{}{}", ran.out, ran.err);
        for said in
            ["no argument `siz`", "no value named `unknown`", "leads out of", "line break", "backslash", "UTF-8"]
        {
            assert_eq!(ran.out.matches(said).count(), 1, "{said}\n{}{}", ran.out, ran.err);
        }
        let built = at(folder.path(), &["build", "--format", "short"]);
        let all = built.out.clone() + &built.err;
        assert!(built.code == Some(3) && all.contains("`siz`") && all.contains("leads out of"), "{all}");
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_read_hides_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let folder = project(&[("a", "shape x = box(siz: 1) with diffuse(0.5)\n")]);
    let closed = folder.path().join("scenes-src/closed");
    fs::create_dir(&closed).expect("a folder");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o000)).expect("a mode");
    if fs::read_dir(&closed).is_ok() {
        // The superuser reads everything.
        return;
    }
    for command in ["lint", "build"] {
        let ran = at(folder.path(), &[command, "--format", "short"]);
        let all = ran.out + &ran.err;
        assert!(ran.code == Some(3) && all.contains("`siz`") && all.contains("closed cannot be read"), "{all}");
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).expect("a mode");
}

/// Statements with mistakes, and what is said of each of them.
const SLIPS: &[(&str, &[&str])] = &[
    ("material m = conductor(eta: 0, k: -1, alpha: 7)", &["`eta` must be", "`k` must be", "`alpha` is 7"]),
    ("material m = principled(0.5, metallic: 2, roughness: -1, ior: 0.5)", &["`metallic`", "`roughness`", "`ior`"]),
    ("let a = foo\nimport \"x\"\nlet b = bar", &["`foo`", "starts with `import`", "`bar`"]),
    ("shape x = box(size: 1) with diffuse(0.5) |> translate(z: 3)", &["stages stand before `with`"]),
    ("allow saturated-albedo\nlet a = 1", &["`allow saturated-albedo` gives no reason"]),
    ("let a = b ? 1 : 2", &["there is no `? :`"]),
    ("let a = 2 ** 3", &["there is no `**`"]),
    ("x = 5", &["no statement starts with `x`"]),
    ("let a = range(10)", &["there is no `range`"]),
    ("mesh a = box(size: 1).translate(z: 1)", &["there are no methods"]),
    ("let a = True", &["no value named `True`"]),
    ("material a = diffuse(\"#ff0000\")", &["takes a color or a texture"]),
    ("shape a = box(size: 1) |> with diffuse(0.5)", &["`with` needs no `|>`"]),
    ("for i in 0.5..2.5 { }", &["has whole ends"]),
    ("let a = 0deg..90deg", &["numbers at its ends, not angles"]),
    (
        "/* hi */ material odd = diffuse(0.5)\nshape a = box(size: 1) |> translate(z: 2) with odd",
        &["no block comments"],
    ),
    ("param t: angle = 1deg in 2deg..90deg", &["`t` is 1deg, and allowed is 2deg..90deg"]),
    ("param w: string = \"x\" in [\"dull\", \"shiny\"]", &["allowed is \"dull\", \"shiny\""]),
];

#[test]
fn slips_are_said_once_and_do_not_hide_others() {
    for (statements, expected) in SLIPS {
        let folder = project(&[("a", &format!("{statements}\n"))]);
        let ran = at(folder.path(), &["lint", "--format", "short"]);
        let errors: Vec<&str> = ran.out.lines().filter(|line| line.contains("error[")).collect();
        assert_eq!(errors.len(), expected.len(), "{statements}: {errors:#?}");
        for (line, part) in errors.iter().zip(*expected) {
            assert!(line.contains(part), "{statements}: {part}\n{errors:#?}");
        }
    }
}

#[test]
fn files_of_other_formats_get_one_message() {
    let folder = project(&[]);
    for (name, text) in
        [("gen.py", "import sys\nfor x in range(3): pass\n"), ("b.lts", "<?xml version=\"1.0\"?>\n<scene/>\n")]
    {
        fs::write(folder.path().join("scenes-src").join(name), text).expect("a file");
        let ran = at(folder.path(), &["lint", "--format", "short", &format!("scenes-src/{name}")]);
        assert_eq!((ran.code, ran.out.matches("error[").count()), (Some(3), 1), "{}", ran.out);
        assert!(ran.out.contains("foreign-file"), "{}", ran.out);
    }
}

#[test]
fn parameters_are_set_and_kept() {
    let statements = "param finish: string = \"dull\" in [\"dull\", \"shiny\"]\nparam turn: angle = 10deg in 0deg..90deg\n\
                      shape b = box(size: 1) |> rotate(z: turn) |> translate(z: 2) with diffuse(if finish == \"dull\" then 0.5 else 0.6)\n";
    let folder = project(&[("a", statements), ("b", "")]);
    let scene = "scenes-src/a.lts";
    let lint = at(folder.path(), &["lint", "--format", "short", scene, "--set", "finish=shiny", "--set", "turn=20deg"]);
    assert_eq!(lint.code, Some(0), "{}", lint.out);
    let wrong = at(folder.path(), &["lint", "--format", "short", scene, "--set", "finish=blue"]);
    assert!(wrong.code == Some(3) && wrong.out.contains("allowed is \"dull\", \"shiny\""), "{}", wrong.out);
    let twice = at(folder.path(), &["lint", scene, "--set", "turn=1deg", "--set", "turn=2deg"]);
    assert!(twice.code == Some(2) && twice.err.contains("two values"), "{}", twice.err);
    assert_eq!(at(folder.path(), &["build", "--set", "turn=1deg"]).code, Some(2), "it goes with one scene");
    let built = at(folder.path(), &["build", scene, "--target", "mitsuba-3", "--set", "turn=20deg"]);
    assert_eq!(built.code, Some(0), "{}", built.err);
    let ledger = fs::read_to_string(folder.path().join("generated/a/mitsuba-3/ledger.json")).expect("a ledger");
    let ledger: serde_json::Value = serde_json::from_str(&ledger).expect("JSON");
    assert_eq!(ledger["parameters"], serde_json::json!({ "finish": "\"dull\"", "turn": "20deg" }));
    assert_eq!(at(folder.path(), &["doc"]).code, Some(0));
    let page = fs::read_to_string(folder.path().join("docs/scenes/a.md")).expect("a page");
    assert!(page.contains("| `turn` | `10deg` | `0deg..90deg` | an angle |"), "{page}");
}

#[test]
fn fmt_diff_changes_nothing_and_says_so() {
    let folder = project(&[("a", "let   x = 1\n")]);
    let path = folder.path().join("scenes-src/a.lts");
    let before = fs::read(&path).expect("a scene");
    let ran = at(folder.path(), &["fmt", "--diff"]);
    assert_eq!((ran.code, fs::read(&path).expect("a scene")), (Some(1), before));
    assert!(ran.err.contains("would be formatted") && ran.err.contains("1 not formatted"), "{}", ran.err);
}

#[test]
fn drafts_outside_of_projects_need_no_documentation() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = scene("a", "").replace("///", "//");
    fs::write(folder.path().join("a.lts"), &text).expect("a scene");
    let codes =
        |arguments: &[&str]| at(folder.path(), &[&["lint", "--format", "short", "a.lts"], arguments].concat()).out;
    assert!(!codes(&[]).contains("undocumented-scene"));
    assert!(codes(&["--warn", "undocumented-scene"]).contains("undocumented-scene"));
    fs::create_dir(folder.path().join("scenes-src")).expect("a folder");
    fs::write(folder.path().join("scenes-src/a.lts"), text).expect("a scene");
    fs::write(folder.path().join("ltsc.toml"), "").expect("a project");
    assert!(at(folder.path(), &["lint", "--format", "short"]).out.contains("undocumented-scene"));
}

#[test]
fn usage_says_what_can_be_done() {
    let said = |arguments: &[&str]| {
        let ran = run(ltsc().args(arguments));
        assert_eq!(ran.code, Some(2), "{arguments:?}: {}{}", ran.out, ran.err);
        ran.err
    };
    let scene = "scenes-src/ring.lts";
    assert!(said(&["emit", scene]).contains("mitsuba-3, mitsuba-0.6"));
    assert!(said(&["render", scene, "--renderer", "mitsuba-3,luxcore", "-o", "a.exr"]).contains("ltsc agree"));
    let negative = said(&["render", scene, "--renderer", "luxcore", "--samples", "-3", "-o", "a.exr"]);
    assert!(negative.contains("invalid value '-3'"), "{negative}");
    assert!(!said(&["agree", "--crop", "3"]).contains("-- --crop"));
    for (word, part) in
        [("glass", "dielectric"), ("for", "a statement"), ("with", "material"), ("approximated", "ledger.json")]
    {
        let ran = run(ltsc().args(["explain", word]));
        assert!(ran.code == Some(0) && ran.out.contains(part), "{word}: {}", ran.out);
    }
}

#[test]
fn many_scenes_with_equal_paths_are_each_said_once() {
    let scenes: Vec<String> = (0..300).map(|at| format!("s{at:03}")).collect();
    let folder = project(&scenes.iter().map(|name| (name.as_str(), "")).collect::<Vec<_>>());
    let ran = at(folder.path(), &["lint", "--format", "short"]);
    assert_eq!(ran.out.matches("same-paths").count(), 300);
    assert!(
        ran.out.contains("`s100` tests the same light paths as `s098`, `s099`, `s101` and 296 more scenes"),
        "{}",
        ran.out
    );
    let near = at(folder.path(), &["similar", "scenes-src/s100.lts"]);
    assert!(near.code == Some(0) && near.out.lines().count() < 40, "{}", near.out);
    assert!(near.out.contains("... and 289 more that are near"), "{}", near.out);
}
