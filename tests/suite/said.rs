//! How much a command says: each thing once, what is as it was in a number, and every form for programs whole.

use std::fs;
use std::path::Path;

use super::outputs::{CLEAN, project};
use super::{Ran, files_below, ltsc, root, run};

const GLOSS: &str = "material gloss = plastic(reflectance: 0.5, alpha: 0.2)\n\
    shape a = box(size: 1) |> translate(z: 1) with gloss\n";

fn at(folder: &Path, words: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).args(words))
}

fn lines(ran: &Ran) -> usize {
    ran.err.lines().count() + ran.out.lines().count()
}

#[test]
fn a_first_build_fits_on_a_screen_and_a_second_one_in_three_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let scenes = root().join("scenes-src");
    fs::write(folder.join("ltsc.toml"), "").expect("a project");
    // Those that take no time, with all that targets approximate.
    let slow = |name: &&String| ["pool_", "veach_", "cboxm_"].iter().any(|slow| name.starts_with(slow));
    for name in files_below(&scenes).iter().filter(|name| !slow(name)) {
        let to = folder.join("scenes-src").join(name);
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        fs::copy(scenes.join(name), to).expect("a copy");
    }
    let build = |more: &[&str]| at(folder, &[&["build"], more].concat());
    let first = build(&[]);
    assert_eq!(first.code, Some(0), "{}", first.err);
    assert!(lines(&first) < 25, "{}{}", first.out, first.err);
    for word in
        ["mitsuba-3/scene.xml", "glb/cbox_classic.glb", "4 more scenes", "ltsc render", "all scenes", "by up to"]
    {
        assert!(first.err.contains(word), "{word}: {}", first.err);
    }
    let second = build(&[]);
    assert!(lines(&second) <= 3 && second.err.contains("--verbose"), "{}{}", second.out, second.err);
    let verbose = build(&["--verbose"]);
    let losses = |ran: &Ran| ran.err.lines().filter(|line| line.contains("approximated:")).count();
    assert!(
        losses(&first) > 3 && losses(&verbose) == losses(&first) && !verbose.err.contains(" more\n"),
        "{}",
        verbose.err
    );
}

#[test]
fn a_build_shows_what_is_new_and_counts_what_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(folder, &[("one", GLOSS), ("four", GLOSS)]);
    let warning = "warning[non-basic-material]";
    let first = at(folder, &["build"]);
    assert_eq!(first.err.matches(warning).count(), 1, "{}", first.err);
    assert!(first.err.contains("(and 1 more like it)") && first.err.contains("`ltsc lint`"), "{}", first.err);
    let second = at(folder, &["build"]);
    assert!(!second.err.contains(warning) && second.err.contains("2 warnings (`ltsc lint`)"), "{}", second.err);
    // One scene changes: its warnings, and only those of its losses that it did not have.
    let scene = folder.join("scenes/four.lts");
    let text = fs::read_to_string(&scene).expect("a scene");
    fs::write(&scene, text + "shape b = box(size: 1) |> translate(z: 3) with mirror()\n").expect("a scene");
    let third = at(folder, &["build"]);
    assert!(third.err.contains("scenes/four.lts") && !third.err.contains("scenes/one.lts:"), "{}", third.err);
    assert!(third.err.contains("1 warning (`ltsc lint`)"), "{}", third.err);
    assert!(!third.err.contains("plastic ("), "{}", third.err);
    // Programs get everything each time.
    let short = || at(folder, &["build", "--format", "short"]).err.matches("warning[").count();
    assert!(short() > 2 && short() == short());
    // What refuses is shown in full, and the warnings beside it are counted.
    fs::write(folder.join("scenes/four.lts"), "lts 1\nlet a = nowhere\n").expect("a scene");
    let refused = at(folder, &["build"]);
    assert!(refused.code == Some(3) && !refused.err.contains(warning), "{}", refused.err);
    assert!(refused.err.contains("1 warning: `ltsc lint` shows them"), "{}", refused.err);
}

#[test]
fn a_draft_is_not_asked_for_documentation() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("draft.lts");
    let (_, settings) = CLEAN.split_once("}\n").expect("a header");
    fs::write(&scene, format!("lts 1\n\nscene draft {{}}\n{settings}")).expect("a scene");
    for command in ["lint", "build"] {
        let ran = run(ltsc().arg(command).arg(&scene));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        assert!(!ran.err.contains("undocumented") && !ran.out.contains("undocumented"), "{}{}", ran.out, ran.err);
    }
}

/// Each command with each form and level: it works, or the command line is refused with 2.
#[test]
fn a_form_that_a_command_does_not_have_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(folder, &[("one", "")]);
    let has: [(&[&str], &[&str]); 12] = [
        (&["build"], &["human", "short", "json", "sarif", "github"]),
        (&["build", "--stats"], &["human"]),
        (&["lint"], &["human", "short", "json", "sarif", "github"]),
        (&["lint", "--diff"], &["human"]),
        (&["fmt", "--check"], &["human", "short", "json", "sarif", "github"]),
        (&["fmt", "--diff"], &["human"]),
        (&["similar", "scenes/one.lts"], &["human", "short", "json"]),
        (&["emit", "scenes/one.lts", "--target", "gltf"], &["human", "short", "json", "sarif", "github"]),
        (&["audit"], &["human", "short", "json", "sarif", "github"]),
        (&["conventions", "--list"], &["human", "short", "json"]),
        (&["init"], &[]),
        (&["explain"], &[]),
    ];
    for (words, forms) in has {
        for form in ["human", "short", "json", "sarif", "github"] {
            let ran = at(folder, &[words, &["--format", form]].concat());
            assert_eq!(ran.code == Some(2), !forms.contains(&form), "{words:?} {form}: {:?} {}", ran.code, ran.err);
            if form == "json" && forms.contains(&form) {
                let read = serde_json::from_str::<serde_json::Value>(&ran.out);
                assert!(read.is_ok(), "{words:?}: {}", ran.out);
            }
        }
        // The variable is for all commands, and leaves those alone that do not have its form.
        let ran = run(ltsc().current_dir(folder).env("LTSC_FORMAT", "sarif").args(words));
        assert!(ran.code != Some(2) || words == ["init"], "{words:?}: {}", ran.err);
    }
    for words in [&["diff", "a.exr", "b.exr"][..], &["agree"], &["renderers", "list"]] {
        for form in ["sarif", "github"] {
            let ran = at(folder, &[words, &["--format", form]].concat());
            assert!(ran.code == Some(2) && ran.err.contains("is for findings"), "{words:?} {form}: {}", ran.err);
        }
    }
}

/// Levels do the same in every command that checks scenes.
#[test]
fn levels_are_the_same_in_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    project(folder, &[("one", GLOSS)]);
    fs::write(folder.join("a.lts"), "").expect("a file");
    let one = "scenes/one.lts";
    let commands: [&[&str]; 6] = [
        &["build", one],
        &["lint", one],
        &["emit", one, "--target", "gltf"],
        &["audit", one],
        &["render", one, "--renderer", "mitsuba-3", "-o", "a.exr"],
        &["agree", one, "--renderer", "mitsuba-3,luxcore", "--samples", "1", "--size", "8"],
    ];
    for words in commands {
        let denied = at(folder, &[words, &["--deny", "non-basic-material"]].concat());
        let said = format!("{}{}", denied.out, denied.err);
        assert!(denied.code == Some(1) && said.contains("non-basic-material"), "{words:?}: {said}");
        let unknown = at(folder, &[words, &["--allow", "no-such-rule"]].concat());
        assert!(unknown.code == Some(2) && unknown.err.contains("no-such-rule"), "{words:?}: {}", unknown.err);
    }
    for words in
        [&["fmt"][..], &["doc"], &["manual"], &["explain"], &["init"], &["diff", "a", "b"], &["conventions", "--list"]]
    {
        let ran = at(folder, &[words, &["--deny", "all"]].concat());
        assert_eq!(ran.code, Some(2), "{words:?}: {}", ran.err);
    }
}
