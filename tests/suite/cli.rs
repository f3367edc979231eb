//! The binary as people use it: commands, exit codes, bad input.

use std::fs;
use std::path::Path;

use super::outputs::project;
use super::{files_below, ltsc, root, run};

pub const MINIMAL: &str = "lts 1\n/// A.\n///\n/// B.\nscene NAME { paths: [\"LDE\"] }\n\
    camera = perspective(eye: (0, -10, 2), target: (0, 0, 4), fov_x: 45deg)\nfilm = image(16, 8)\n\
    integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
    emitter lamp = rectangle(x: -1..1, y: -1..1, z: 5, normal: -Z) with radiance(10)\n";

/// A scene called `name` with `more` at its end, in a folder of its own.
fn scene(name: &str, more: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = folder.path().join("scenes");
    fs::create_dir(&scenes).expect("a folder");
    let path = scenes.join(format!("{name}.lts"));
    fs::write(&path, format!("{}{more}\n", MINIMAL.replace("NAME", name))).expect("a scene");
    (folder, path)
}

#[test]
fn a_second_build_does_nothing_and_says_so() {
    let (folder, path) = scene("one", "");
    let out = folder.path().join("out");
    let build = |more: &[&str]| run(ltsc().arg("build").arg(&path).arg("-o").arg(&out).args(more));
    let first = build(&[]);
    assert_eq!(first.code, Some(0), "{}", first.err);
    assert!(first.out.contains("files written"), "{}", first.out);
    let time = |name: &str| fs::metadata(out.join("one").join(name)).and_then(|meta| meta.modified()).expect("a time");
    let before = time("pbrt-v4/scene.pbrt");
    let second = build(&[]);
    assert!(second.out.is_empty() && second.err.contains("nothing to do"), "{}{}", second.out, second.err);
    assert_eq!(before, time("pbrt-v4/scene.pbrt"));
    assert_eq!(build(&["--check"]).code, Some(0));

    fs::write(out.join("one/pbrt-v4/scene.pbrt"), "edited by hand").expect("a write");
    fs::remove_file(out.join("one/meshes/lamp.ply")).expect("a removal");
    let stale = build(&["--check"]);
    assert_eq!(stale.code, Some(1));
    assert!(stale.out.contains("pbrt-v4") && stale.out.contains("lamp.ply"), "{}", stale.out);
    assert_eq!(fs::read(out.join("one/pbrt-v4/scene.pbrt")).expect("a file"), b"edited by hand");
    assert_eq!(build(&[]).code, Some(0));
    assert_eq!(build(&["--check"]).code, Some(0));
}

#[test]
fn files_that_a_scene_no_longer_has_are_removed_and_only_those() {
    let (folder, path) = scene("one", "shape extra = box(size: 1) with diffuse(0.5)");
    let out = folder.path().join("out");
    let build = |more: &[&str]| run(ltsc().arg("build").arg(&path).arg("-o").arg(&out).args(more));
    assert_eq!(build(&[]).code, Some(0));
    assert!(out.join("one/meshes/extra.ply").is_file());
    fs::write(out.join("one/notes.txt"), "mine").expect("a write");
    fs::write(&path, MINIMAL.replace("NAME", "one")).expect("a write");
    assert_eq!(build(&[]).code, Some(0));
    assert!(!out.join("one/meshes/extra.ply").exists() && out.join("one/notes.txt").is_file());
    // One target alone leaves the others as they are.
    assert_eq!(build(&["--target", "gltf"]).code, Some(0));
    assert_eq!(build(&["--check"]).code, Some(0));
}

#[test]
fn limits_are_raised_and_lowered() {
    let (folder, path) = scene(
        "one",
        "for i in 1..3 { shape ball = sphere(segments: 10, rings: 6) |> translate(3 * i) with diffuse(0.5) }",
    );
    let lint = |limits: &[&str]| {
        let mut command = ltsc();
        command.arg("lint").arg(&path).args(["--format", "short"]);
        limits.iter().for_each(|limit| {
            command.args(["--limit", limit]);
        });
        run(&mut command)
    };
    // The lamp has 2 triangles, each ball 2 * 10 * 5.
    assert_eq!(lint(&[]).code, Some(0));
    assert_eq!(lint(&["triangles=302", "instances=4", "steps=1_000", "list=3", "text=1KiB"]).code, Some(0));
    for (limit, code) in [
        ("triangles=301", "triangle-limit"),
        ("triangles=50", "triangle-limit"),
        ("instances=3", "instance-limit"),
        ("steps=2", "step-limit"),
        ("list=2", "list-limit"),
        ("text=100", "unreadable-file"),
    ] {
        let ran = lint(&[limit]);
        assert_eq!(ran.code, Some(3), "{limit}: {}{}", ran.out, ran.err);
        assert!(ran.out.contains(code), "{limit}: {}", ran.out);
    }
    for wrong in ["triangle=5", "triangles", "triangles=0", "triangles=many", "instances=99_000_000_000"] {
        let ran = lint(&[wrong]);
        assert_eq!(ran.code, Some(2), "{wrong}: {}", ran.err);
    }
    // The project's limits hold for every command, and the command line's count more.
    fs::write(folder.path().join("ltsc.toml"), "scenes = \"scenes\"\n[limits]\ntriangles = 100\ntext = \"1KiB\"\n")
        .expect("a write");
    assert_eq!(lint(&[]).code, Some(3));
    assert_eq!(lint(&["triangles=1_000"]).code, Some(0));
    let format = |more: &[&str]| run(ltsc().args(["fmt", "--check"]).arg(&path).args(more)).code;
    assert_ne!(format(&[]), Some(3));
    assert_eq!(format(&["--limit", "text=100"]), Some(3));
    fs::write(folder.path().join("ltsc.toml"), "[limits]\ntriangels = 100\n").expect("a write");
    let ran = lint(&[]);
    assert!(ran.code == Some(3) && ran.err.contains("triangles"), "{:?} {}", ran.code, ran.err);
}

#[test]
fn a_folder_of_someone_else_is_refused() {
    let (folder, path) = scene("one", "");
    let out = folder.path().join("mine");
    fs::create_dir(&out).expect("a folder");
    fs::write(out.join("thesis.tex"), "years of work").expect("a write");
    let emit = |more: &[&str]| run(ltsc().arg("emit").arg(&path).args(["--target", "pbrt", "-o"]).arg(&out).args(more));
    let refused = emit(&[]);
    assert_eq!(refused.code, Some(2), "{}", refused.err);
    assert_eq!(files_below(&out), ["thesis.tex"]);
    assert_eq!(emit(&["--force"]).code, Some(0));
    assert!(out.join("scene.pbrt").is_file() && out.join("thesis.tex").is_file());
}

#[test]
fn every_target_is_emitted_alone_with_its_meshes() {
    for target in ltsc_core::formats::TARGETS {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("out");
        let ran = run(ltsc().args(["emit", "scenes-src/cbox_classic.lts", "--target", target.name, "-o"]).arg(&out));
        assert_eq!(ran.code, Some(0), "{}: {}", target.name, ran.err);
        assert!(out.join(target.main_file_of("cbox_classic")).is_file(), "{}", target.name);
        assert_eq!(out.join("meshes/tall.ply").is_file(), target.shares_meshes, "{}", target.name);
    }
}

#[test]
fn settings_of_the_command_line_reach_the_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let ran = run(ltsc()
        .args(["emit", "scenes-src/cbox_classic.lts", "--target", "pbrt-v4", "--width", "64", "--height", "32"])
        .args(["--samples", "7", "--max-depth", "3", "-o"])
        .arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let text = fs::read_to_string(out.join("settings.pbrt")).expect("settings");
    for part in ["xresolution\" [64]", "yresolution\" [32]", "pixelsamples\" [7]", "maxdepth\" [2]"] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
}

#[test]
fn every_target_looks_through_the_camera_asked_for() {
    let (folder, path) = scene("one", "");
    let named = "camera nave = perspective(eye: (0, -10, 2), target: (0, 0, 4), fov_x: 45deg)\n\
                 camera above = perspective(eye: (0, 0, 77), target: (0, 0, 0), up: Y, fov_x: 45deg)\n";
    let text = MINIMAL.replace("NAME", "one");
    let text: String =
        text.lines().filter(|line| !line.starts_with("camera")).map(|line| format!("{line}\n")).collect();
    fs::write(&path, format!("{text}{named}")).expect("a write");
    let emit = |target: &str, camera: &[&str]| {
        let out = folder.path().join(format!("{target}-{}", camera.last().unwrap_or(&"default")));
        let ran = run(ltsc().arg("emit").arg(&path).args(["--target", target, "-o"]).arg(&out).args(camera));
        let other = |file: &String| ![".ply", ".bin", ".json"].iter().any(|ending| file.ends_with(ending));
        let files = if out.exists() { files_below(&out) } else { Vec::new() };
        let files = files.into_iter().filter(other);
        // A binary container has its document as text in it.
        let read = |file: String| String::from_utf8_lossy(&fs::read(out.join(file)).expect("a file")).into_owned();
        (ran, files.map(read).collect::<String>())
    };
    for target in ltsc_core::formats::TARGETS {
        let (_, first) = emit(target.name, &[]);
        let (_, nave) = emit(target.name, &["--camera", "nave"]);
        let (ran, above) = emit(target.name, &["--camera", "above"]);
        assert_eq!(ran.code, Some(0), "{}: {}", target.name, ran.err);
        assert!(first == nave && first != above, "{}", target.name);
        assert!(above.contains("77") && !first.contains("77"), "{}", target.name);
    }
    let (ran, text) = emit("pbrt-v4", &["--camera", "abov"]);
    assert_eq!((ran.code, text.as_str()), (Some(2), ""), "{}", ran.err);
    assert!(ran.err.contains("no camera `abov`") && ran.err.contains("did you mean `above`?"), "{}", ran.err);
    let out = folder.path().join("a.exr");
    let ran = run(ltsc().arg("render").arg(&path).args(["--renderer", "luxcore", "--camera", "x", "-o"]).arg(&out));
    assert_eq!(ran.code, Some(2), "{}", ran.err);
    assert!(ran.err.contains("it has nave, above") && !out.exists(), "{}", ran.err);
}

#[test]
fn an_algorithm_that_a_target_lacks_is_replaced_with_a_finding_and_never_rendered() {
    let (folder, path) = scene("one", "");
    let text = MINIMAL.replace("NAME", "one").replace("path(max_depth: 3)", "light_tracing(max_depth: 3)");
    fs::write(&path, text).expect("a write");
    let out = folder.path().join("out");
    let ran = run(ltsc().arg("emit").arg(&path).args(["--target", "pbrt-v3", "--format", "short", "-o"]).arg(&out));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains("loss-dropped") && ran.err.contains("light tracing"), "{}", ran.err);
    let settings = fs::read_to_string(out.join("settings.pbrt")).expect("settings");
    assert!(settings.contains("asks for `light_tracing`") && settings.contains("Integrator \"path\""), "{settings}");
    // It is refused before any renderer is looked for.
    let image = folder.path().join("a.exr");
    let ran = run(ltsc().arg("render").arg(&path).args(["--renderer", "luxcore", "-o"]).arg(&image));
    assert_eq!(ran.code, Some(2), "{}", ran.err);
    assert!(ran.err.contains("luxcore has no light tracing") && ran.err.contains("`mitsuba-3`"), "{}", ran.err);
    assert!(!image.exists());
}

#[test]
fn settings_of_the_command_line_reach_every_algorithm() {
    for (algorithm, depth, samples) in [
        ("bidirectional", "\"bdpt\" \"integer maxdepth\" [4]", "pixelsamples\" [9]"),
        ("light_tracing", "\"lightpath\" \"integer maxdepth\" [4]", "pixelsamples\" [9]"),
        ("metropolis", "\"mlt\" \"integer maxdepth\" [4]", "mutationsperpixel\" [9]"),
        ("photon_map", "\"sppm\" \"integer maxdepth\" [4]", "pixelsamples\" [9]"),
    ] {
        let (folder, path) = scene("one", "");
        let text = MINIMAL.replace("NAME", "one").replace("path(max", &format!("{algorithm}(max"));
        fs::write(&path, text.replace("independent", "sobol")).expect("a write");
        let out = folder.path().join("out");
        let ran = run(ltsc()
            .arg("emit")
            .arg(&path)
            .args(["--target", "pbrt-v4", "--max-depth", "5", "--samples", "9", "--seed", "6", "-o"])
            .arg(&out));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        let settings = fs::read_to_string(out.join("settings.pbrt")).expect("settings");
        for part in [depth, samples, "--seed 6", "Sampler \"sobol\""] {
            assert!(settings.contains(part), "{algorithm}: {part}\n{settings}");
        }
    }
}

#[test]
fn parameters_are_set_from_outside() {
    let (folder, path) = scene("one", "param size: number = 1 in 0.5..2\nshape a = box(size: size) with diffuse(0.5)");
    let out = folder.path().join("out");
    let emit = |set: &[&str]| {
        let mut command = ltsc();
        command.arg("emit").arg(&path).args(["--target", "pbrt", "-o"]).arg(&out);
        run(set.iter().fold(&mut command, |command, set| command.args(["--set", set])))
    };
    let mesh = || fs::read(out.join("meshes/a.ply")).expect("a mesh");
    assert_eq!(emit(&[]).code, Some(0));
    let before = mesh();
    assert_eq!(emit(&["size=3 / 2"]).code, Some(0));
    assert_ne!(before, mesh());
    for (set, code, words) in [
        ("size=5", 3, "parameter-range"),
        ("size=45deg", 3, "type-mismatch"),
        ("size=1 let x = 2", 3, "syntax-error"),
        ("sise=1", 3, "did you mean `size`?"),
        ("size", 2, "has no value"),
    ] {
        let ran = emit(&[set]);
        assert!(ran.code == Some(code) && ran.err.contains(words), "{set}: {:?} {}", ran.code, ran.err);
    }
}

#[test]
fn loops_and_functions_make_named_things() {
    let more = "let far(i: number) = 10 * i\nmaterial grey(x: number) = diffuse(x)\nmesh ball = sphere(segments: 8, rings: 4)\n\
        for i in 1..2, j in [5, 6] {\n    shape s = ball |> translate(far(i), j) with grey(0.5)\n}\n";
    let mut files = ltsc_core::files::MemoryFiles::default();
    files.insert("one.lts", format!("{}{more}", MINIMAL.replace("NAME", "one")));
    let path = ltsc_core::files::VPath::resolve("", "one.lts").expect("a path");
    let mut sources = ltsc_core::diag::Sources::default();
    let checked = ltsc_core::pipeline::check(&files, &mut sources, &path, &ltsc_core::pipeline::Options::default());
    let scene = checked.scene.unwrap_or_else(|| panic!("{:#?}", checked.findings));
    let names: Vec<&str> = scene.shapes.values().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["lamp", "s[1,0]", "s[1,1]", "s[2,0]", "s[2,1]"]);
    let place = scene.shapes.values().last().expect("a shape").transform.rows.map(|row| row[3]);
    assert_eq!(place, [20.0, 6.0, 0.0]);
    assert_eq!((scene.meshes.len(), scene.materials.len()), (2, 2), "meshes and equal materials are shared");
}

/// Bad input: a finding or message, the documented exit code, no panic, nothing written.
fn refused(text: &[u8], code: i32, words: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = folder.path().join("scenes");
    fs::create_dir(&scenes).expect("a folder");
    fs::write(scenes.join("bad.lts"), text).expect("a write");
    refused_in(&scenes, code, words);
}

fn refused_in(scenes: &Path, code: i32, words: &str) {
    let out = scenes.join("out");
    let lint = run(ltsc().arg("lint").arg(scenes.join("bad.lts")).args(["--format", "short"]));
    assert_eq!(lint.code, Some(code), "lint: {}{}", lint.out, lint.err);
    assert!(lint.out.contains(words), "{words} is missing in\n{}{}", lint.out, lint.err);
    let build = run(ltsc().arg("build").arg(scenes.join("bad.lts")).arg("-o").arg(&out));
    assert_eq!(build.code, Some(code), "build: {}", build.err);
    assert!(!out.exists(), "something was written");
    let emit = run(ltsc().arg("emit").arg(scenes.join("bad.lts")).args(["--target", "gltf", "-o"]).arg(&out));
    assert_eq!(emit.code, Some(code), "emit: {}", emit.err);
    assert!(!out.exists(), "something was written");
}

#[test]
fn bad_text_is_refused() {
    let with = |more: &str| format!("{}{more}\n", MINIMAL.replace("NAME", "bad"));
    refused(with("shape a = bunnny with diffuse(1)").as_bytes(), 3, "unknown-name");
    refused(with("shape a = box(size: \"big\") with diffuse(1)").as_bytes(), 3, "type-mismatch");
    refused(with("shape a = box(size: 1) |> rotate(z: 20) with diffuse(1)").as_bytes(), 3, "missing-unit");
    refused(with("group g {\n shape a = box(size: 1) with diffuse(1)").as_bytes(), 3, "syntax-error");
    refused(b"\x7fELF\x02\x01\x01\x00\xff\xfe\x00", 3, "not-text");
    refused("(".repeat(10 << 20).as_bytes(), 3, "nesting-limit");
    refused(
        with("material m = conductor(eta: 1.5, k: 3, alpha: 0.001)\nshape a = box(size: 1) with m").as_bytes(),
        1,
        "rough-too-small",
    );
    refused(with("let a = 0 / 0").as_bytes(), 3, "division by zero");
    refused(with("let a = nan").as_bytes(), 3, "unknown-name");
    refused(MINIMAL.replace("NAME", "bad").replace("16, 8", "0, 8").as_bytes(), 3, "invalid-argument");
    refused(with("shape a = file(\"missing.ply\") with diffuse(1)").as_bytes(), 3, "unreadable-file");
    refused(with("use a from \"../../x.lts\"").as_bytes(), 3, "bad-path");
    refused(with("use a from \"/etc/passwd\"").as_bytes(), 3, "bad-path");
}

/// A scene whose evaluation would not end in years.
fn stopped(more: &str) {
    let (_folder, path) = scene("bad", more);
    let ran = run(ltsc().arg("lint").arg(&path).args(["--format", "short"]));
    assert!(ran.code == Some(3) && ran.out.contains("step-limit"), "{:?}: {}", ran.code, ran.out);
}

#[test]
fn loops_without_end_are_stopped() {
    stopped("let a = [for i in 0..999999: [for j in 0..999999: 1]]");
}

#[test]
fn calls_without_end_are_stopped() {
    let doubled: String = (1..100).map(|i| format!("let f{i}(x: number) = f{0}(x) + f{0}(x)\n", i - 1)).collect();
    stopped(&format!("let f0(x: number) = x\n{doubled}let a = f99(1)"));
}

#[test]
fn an_empty_file_is_a_library_and_cannot_be_emitted() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("empty.lts");
    fs::write(&path, "").expect("a write");
    let lint = run(ltsc().arg("lint").arg(&path).args(["--format", "short"]));
    assert_eq!(lint.code, Some(0));
    assert!(lint.out.contains("missing-version"), "{}", lint.out);
    let emit = run(ltsc().arg("emit").arg(&path).args(["--target", "gltf", "-o"]).arg(folder.path().join("out")));
    assert_eq!(emit.code, Some(3), "{}", emit.err);
    assert!(emit.err.contains("library") && !folder.path().join("out").exists());
}

#[test]
fn bad_mesh_files_are_refused() {
    let header = |count: &str| {
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    for (bytes, words) in [
        (header("1000000000").into_bytes(), "invalid-mesh-file"),
        ([header("3").as_bytes(), &[0; 20]].concat(), "invalid-mesh-file"),
        (b"ply\nformat ascii 1.0\nelement vertex 3\n".to_vec(), "invalid-mesh-file"),
        (Vec::new(), "invalid-mesh-file"),
    ] {
        let (folder, path) = scene("bad", "shape a = file(\"a.ply\") |> faceted() with diffuse(1)");
        let scenes = path.parent().expect("a folder");
        fs::write(scenes.join("a.ply"), bytes).expect("a write");
        refused_in(scenes, 3, words);
        drop(folder);
    }
}

#[test]
fn files_that_use_each_other_are_refused() {
    let (folder, path) = scene("bad", "use a from \"a.lts\"");
    let scenes = path.parent().expect("a folder");
    fs::write(scenes.join("a.lts"), "lts 1\nuse b from \"b.lts\"\nlet a = b").expect("a write");
    fs::write(scenes.join("b.lts"), "lts 1\nuse a from \"a.lts\"\nlet b = a").expect("a write");
    refused_in(scenes, 3, "use-cycle");
    drop(folder);
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_project_is_refused() {
    let (folder, path) = scene("bad", "shape a = file(\"a.ply\") with diffuse(1)");
    let scenes = path.parent().expect("a folder");
    let outside = tempfile::tempdir().expect("a folder");
    fs::write(outside.path().join("a.ply"), "ply\n").expect("a write");
    std::os::unix::fs::symlink(outside.path().join("a.ply"), scenes.join("a.ply")).expect("a link");
    refused_in(scenes, 3, "unreadable-file");
    drop(folder);
}

#[test]
fn a_scene_without_shapes_is_refused_when_it_is_built() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.lts");
    let text = MINIMAL
        .replace("NAME", "bad")
        .lines()
        .filter(|line| !line.starts_with("emitter"))
        .collect::<Vec<_>>()
        .join("\n");
    fs::write(&path, text).expect("a write");
    let out = folder.path().join("out");
    let build = |more: &[&str]| run(ltsc().arg("build").arg(&path).arg("-o").arg(&out).args(more));
    // Rules say so first, and the answer is no; without them the scene is still invalid.
    assert_eq!(build(&[]).code, Some(1));
    let ran = build(&["--allow", "unlit-scene", "--allow", "nothing-in-view"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("invalid-scene") && !folder.path().join("out").exists(), "{}", ran.err);
}

#[test]
fn a_wrong_project_file_is_refused() {
    for (text, words) in [
        ("scnes = \"a\"", "unknown field"),
        ("targets = [\"mitsubishi\"]", "mitsubishi"),
        ("generated = \"../../elsewhere\"", "generated"),
        ("[rules]\nsmooth-emiter = \"warn\"", "smooth-emiter"),
        ("[rules]\nsmooth-emitter = \"loud\"", "loud"),
        ("= 3", "ltsc.toml"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("ltsc.toml"), text).expect("a write");
        let ran = run(ltsc().current_dir(folder.path()).arg("build"));
        assert_eq!(ran.code, Some(3), "{text}: {}", ran.err);
        assert!(ran.err.contains(words), "{text}: {}", ran.err);
    }
}

#[test]
fn suppressions_and_levels_decide() {
    let bulb = "emitter bulb = sphere() |> translate(z: 3) with radiance(1)";
    let (_folder, path) = scene("one", bulb);
    let lint = |path: &Path, more: &[&str]| run(ltsc().arg("lint").arg(path).args(["--format", "short"]).args(more));
    assert_eq!(lint(&path, &[]).code, Some(1));
    assert_eq!(lint(&path, &["--warn", "smooth-emitter"]).code, Some(0));
    assert_eq!(lint(&path, &["--allow", "smooth-emitter"]).out, "");
    assert_eq!(lint(&path, &["--allow", "smooth-emiter"]).code, Some(2));
    let (_folder, path) = scene("one", &format!("allow smooth-emitter \"it is the point\"\n{bulb}"));
    assert_eq!(lint(&path, &[]).code, Some(0));
    assert_eq!(lint(&path, &["--no-allow"]).code, Some(1));
}

/// Writes a small image of one color in each half.
fn image(path: &Path, left: [f32; 3], right: [f32; 3]) {
    let pixels = (0..64).map(|at| if at % 8 < 4 { left } else { right }).collect();
    let image = ltsc_render::image::Image { width: 8, height: 8, pixels };
    ltsc_render::image::write_exr(path, &image, &ltsc_render::image::Provenance::default()).expect("an image");
}

#[test]
fn a_tolerance_sees_light_where_the_reference_is_black() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    image(&at("black.exr"), [0.0; 3], [0.0; 3]);
    image(&at("half.exr"), [0.0; 3], [1.0; 3]);
    image(&at("blue.exr"), [0.0, 0.0, 5.0], [1.0; 3]);
    image(&at("near.exr"), [0.0; 3], [1.01; 3]);
    image(&at("grey.exr"), [0.5; 3], [0.5; 3]);
    image(&at("leaning.exr"), [0.6; 3], [0.4; 3]);
    image(&at("tinted.exr"), [0.6, 0.4, 0.5], [0.6, 0.4, 0.5]);
    let code = |a: &str, b: &str, tolerance: &str| {
        run(ltsc().arg("diff").arg(at(a)).arg(at(b)).args(["--tolerance", tolerance])).code
    };
    assert_eq!(code("black.exr", "black.exr", "0.01"), Some(0));
    assert_eq!(code("black.exr", "half.exr", "0.01"), Some(1));
    assert_eq!(code("half.exr", "blue.exr", "0.01"), Some(1));
    assert_eq!(code("half.exr", "near.exr", "0.02"), Some(0));
    assert_eq!(code("half.exr", "near.exr", "0.005"), Some(1));
    // The means are equal, the tiles are not; the luminance nearly is, the channels are not.
    assert_eq!((code("grey.exr", "leaning.exr", "0.1"), code("grey.exr", "leaning.exr", "0.25")), (Some(1), Some(0)));
    assert_eq!((code("grey.exr", "tinted.exr", "0.1"), code("grey.exr", "tinted.exr", "0.25")), (Some(1), Some(0)));

    let out = at("out");
    let diff = |more: &[&str]| {
        run(ltsc().arg("diff").arg(at("half.exr")).arg(at("near.exr")).arg("-o").arg(&out).args(more)).code
    };
    assert_eq!((diff(&[]), diff(&[])), (Some(0), Some(0)));
    assert!(out.join("difference.png").is_file() && out.join("diff.json").is_file());
    fs::remove_file(out.join("manifest.json")).expect("a removal");
    assert_eq!((diff(&[]), diff(&["--force"])), (Some(2), Some(0)), "a folder of someone else");
}

/// One folder where the system does not tell capitals from small letters.
#[test]
fn scenes_whose_names_differ_by_case_only_are_not_built() {
    let (folder, path) = scene("one", "");
    fs::write(path.with_file_name("other.lts"), MINIMAL.replace("NAME", "One")).expect("a scene");
    let out = folder.path().join("out");
    let ran = run(ltsc().arg("build").arg(path.parent().expect("a folder")).arg("-o").arg(&out));
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("scene-name") && ran.err.contains("`One` lies in `other.lts`"), "{}", ran.err);
    assert!(!out.exists(), "nothing is written");
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_links_or_names() {
    let (folder, path) = scene("one", "shape a = box(size: 1) with diffuse(0.5)");
    let (out, victim) = (folder.path().join("out"), folder.path().join("victim"));
    fs::create_dir(&victim).expect("a folder");
    let emit = || run(ltsc().arg("emit").arg(&path).args(["--target", "pbrt", "-o"]).arg(&out));
    assert_eq!(emit().code, Some(0));
    fs::remove_dir_all(out.join("meshes")).expect("a removal");
    std::os::unix::fs::symlink(&victim, out.join("meshes")).expect("a link");
    assert_eq!(emit().code, Some(2));
    assert!(files_below(&victim).is_empty());

    let sly = path.with_file_name("...lts");
    fs::write(&sly, MINIMAL.replace("NAME", "`..`")).expect("a scene");
    let ran = run(ltsc().arg("build").arg(&sly).arg("-o").arg(folder.path().join("gen")));
    assert!(ran.code == Some(3) && ran.err.contains("scene-name"), "{:?} {}", ran.code, ran.err);
}

#[cfg(target_os = "linux")]
#[test]
fn an_answer_that_cannot_be_written_is_no_yes() {
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let lint = |scene: &str| {
        ltsc().args(["lint", scene, "--format", "json"]).stdout(full()).output().expect("a run").status.code()
    };
    assert_eq!(lint("scenes-src/cbox_classic.lts"), Some(4));
    assert_eq!(lint("tests/cases/names/unknown.lts"), Some(3));
}

#[test]
fn columns_count_characters_in_every_form() {
    let (_folder, path) = scene("one", "let a = (\"é\", nope)");
    for format in ["human", "short"] {
        let ran = run(ltsc().arg("lint").arg(&path).args(["--format", format]));
        assert!(ran.out.contains("one.lts:11:15"), "{}", ran.out);
    }
}

#[test]
fn terminals_are_not_obeyed() {
    let (_folder, path) = scene("one", "let a = nope // \u{1b}]0;title\u{7}");
    for format in ["human", "short"] {
        let ran = run(ltsc().arg("lint").arg(&path).args(["--format", format]));
        assert!(ran.code == Some(3) && !ran.out.contains(['\u{1b}', '\u{7}']), "{:?}", ran.out);
    }
}

#[test]
fn numbers_beyond_single_precision_are_refused() {
    for more in [
        "emitter a = box(size: 1) with radiance(1e300)",
        "shape a = box(size: 1) with dielectric(ior: 1e308)",
        "shape a = sphere() |> scale(1e-60) with diffuse(0.5)",
        "shape a = sphere() |> scale(1e60) with diffuse(0.5)",
        "camera above = perspective(eye: (0, -1e200, 4), target: (0, 0, 0), fov_x: 3e1deg)",
    ] {
        let (folder, path) = scene("one", more);
        let out = folder.path().join("out");
        let ran = run(ltsc().arg("emit").arg(&path).args(["--target", "pbrt", "-o"]).arg(&out));
        assert!(ran.code == Some(3) && !out.exists(), "{more}: {:?} {}", ran.code, ran.err);
    }
}

#[test]
fn thousands_of_errors_take_no_minutes() {
    let many: String = (0..5000).map(|i| format!("let n{i} = nope{i}\n")).collect();
    let (_folder, path) = scene("one", &many);
    let start = std::time::Instant::now();
    let ran = run(ltsc().arg("lint").arg(&path).args(["--format", "short"]));
    assert_eq!((ran.code, ran.out.lines().count()), (Some(3), 5000));
    // It takes a second or two without optimization; the quadratic way took minutes.
    assert!(start.elapsed().as_secs() < 60, "{:?}", start.elapsed());
}

#[test]
fn a_library_is_checked_with_the_scenes_that_use_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let uses = "use stone from \"lib/outer.lts\"\nshape s = box(size: 1) |> translate(z: 2) with stone\n";
    let also = "use bulb from \"lib/inner.lts\"\nemitter bulb = bulb |> translate(z: 3) with radiance(1)\n";
    project(folder, &[("one", uses), ("second", also), ("nothing", "")]);
    fs::create_dir(folder.join("scenes/lib")).expect("a folder");
    let inner = "lts 1\n\n/// A light.\nmesh bulb = box(size: 1)\n\n/// Its reflectance.\nlet albedo = 0.5\n";
    let outer = "lts 1\n\nuse albedo from \"inner.lts\"\n\n/// Grey.\nmaterial stone = diffuse(albedo)\n";
    let write = |name: &str, text: &str| fs::write(folder.join("scenes/lib").join(name), text).expect("a library");
    write("inner.lts", inner);
    write("outer.lts", outer);
    let lint = |args: &[&str]| run(ltsc().current_dir(folder).arg("lint").args(args));
    let clean = lint(&["scenes/lib/inner.lts"]);
    assert_eq!(clean.code, Some(0), "{}{}", clean.out, clean.err);
    assert!(clean.err.contains("1 file checked with 2 scenes that use a library: 0 errors"), "{}", clean.err);

    // What a library breaks shows where it is used: directly, and through another library; once, if it is its own.
    write(
        "inner.lts",
        &inner.replace("box(size: 1)", "sphere(segments: 8, rings: 4)").replace("0.5", "1.5").replace("lts 1\n\n", ""),
    );
    let broken = lint(&["scenes/lib/inner.lts", "--format", "short"]);
    assert_eq!(broken.code, Some(1), "{}{}", broken.out, broken.err);
    let once = |words: &str| assert_eq!(broken.out.matches(words).count(), 1, "{words}\n{}", broken.out);
    once("scenes/second.lts:");
    once("[smooth-emitter]");
    once("[reflectance-over-one]");
    once("scenes/lib/inner.lts:2:1: warning[missing-version]");
    // `nothing` has no part in it; a scene that is named is not looked at twice; one alone brings no other.
    let both = lint(&["scenes/lib/outer.lts", "scenes/one.lts", "scenes/nothing.lts"]);
    assert!(both.err.contains("3 files checked: "), "{}", both.err);
    let alone = lint(&["scenes/nothing.lts"]);
    assert!(alone.code == Some(0) && alone.err.contains("1 file checked: "), "{}", alone.err);

    // Nothing but what was asked for is mended.
    let fixed = lint(&["scenes/lib/inner.lts", "--fix", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&fixed.out).expect("JSON");
    let ids: Vec<&str> =
        json["fixed"].as_array().expect("a list").iter().filter_map(|one| one["id"].as_str()).collect();
    assert_eq!(ids, ["missing-version"], "{json:#}");
    assert!(fs::read_to_string(folder.join("scenes/second.lts")).expect("a scene").ends_with(also));
}

#[test]
fn json_is_one_document() {
    let one = |args: &[&str]| {
        let ran = run(ltsc().args(args).args(["--format", "json"]));
        serde_json::from_str::<serde_json::Value>(&ran.out)
            .unwrap_or_else(|error| panic!("{args:?}: {error}\n{}", ran.out))
    };
    let bad = "tests/cases/names/unknown.lts";
    assert!(one(&["build", bad])["findings"].is_array());
    assert!(one(&["build", "scenes-src", "--check"])["scenes"].is_array());
    assert!(one(&["emit", bad, "--target", "pbrt"])["findings"].is_array());
    assert!(one(&["render", bad, "--renderer", "luxcore", "-o", "never.exr"])["findings"].is_array());
    assert!(one(&["lint", "nowhere.lts"])["error"]["message"].is_string());
    assert!(one(&["diff", "nowhere.exr", "nowhere.exr"])["error"]["message"].is_string());

    let (_folder, path) = scene("one", "emitter bulb = sphere() |> translate(z: 3) with radiance(1)");
    let ran = run(ltsc().arg("lint").arg(&path).args(["--format", "json"]));
    let document: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let finding = &document["findings"][0];
    assert_eq!(finding["id"], "smooth-emitter");
    assert_eq!((finding["place"]["line"].as_u64(), finding["place"]["column"].as_u64()), (Some(11), Some(1)));
    assert_eq!(document["counts"]["errors"], 1);
    let list = run(ltsc().args(["renderers", "list", "--format", "json"]));
    let document: serde_json::Value = serde_json::from_str(&list.out).expect("JSON");
    assert_eq!(document["renderers"].as_array().map(Vec::len), Some(ltsc_render::run::DRIVERS.len()));
}

#[test]
fn usage_is_explained() {
    assert_eq!(run(&mut ltsc()).code, Some(2));
    assert_eq!(run(ltsc().arg("--help")).code, Some(0));
    assert_eq!(run(ltsc().args(["emit", "scenes-src/cbox_classic.lts"])).code, Some(2));
    let wrong = run(ltsc().args(["emit", "scenes-src/cbox_classic.lts", "--target", "mitsuab"]));
    assert!(wrong.code == Some(2) && wrong.err.contains("did you mean `mitsuba`?"), "{}", wrong.err);
    assert_eq!(run(ltsc().args(["lint", "no-such-file.lts"])).code, Some(3));
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let words = run(ltsc().args(["completions", shell])).out;
        let there = ["lint", "similar", "sarif", "github", "fix", "deny"].iter().all(|word| words.contains(word));
        assert!(words.contains("ltsc") && there, "{shell}: {words}");
    }
    for what in ["smooth-emitter", "syntax-error", "diffuse", "rotate"] {
        let ran = run(ltsc().args(["explain", what]));
        assert!(ran.code == Some(0) && ran.out.contains(what), "{what}: {}", ran.err);
    }
    let target = run(ltsc().args(["explain", "--target", "pbrt"]));
    assert!(target.code == Some(0) && target.out.contains("approximate"), "{}", target.out);
    assert!(run(ltsc().args(["explain", "smoth-emitter"])).err.contains("smooth-emitter"));
}

#[test]
fn every_example_of_the_table_compiles() {
    for row in ltsc_core::eval::table() {
        let mut text = MINIMAL.replace("NAME", "example");
        for kind in ["camera =", "film =", "integrator =", "sampler ="] {
            if row.example.starts_with(kind) {
                text = text.lines().filter(|line| !line.starts_with(kind)).collect::<Vec<_>>().join("\n") + "\n";
            }
        }
        if row.example.contains("emitter lamp") {
            text = text.lines().filter(|line| !line.starts_with("emitter lamp")).collect::<Vec<_>>().join("\n") + "\n";
        }
        let mut files = ltsc_core::files::MemoryFiles::default();
        files.insert("example.lts", format!("{text}{}\n", row.example));
        let mesh = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        files.insert("meshes/bunny.ply", mesh);
        files.insert("textures/oak.png", include_bytes!("../cases/textures/quads.png"));
        files.insert("sky.exr", include_bytes!("../../renderers/evaluation/conventions/images/sky.exr"));
        let array = std::fs::read(root().join("tests/cases/arrays/positions.npy")).expect("an array");
        files.insert("forest.npy", array.clone());
        files.insert("heights.npy", array);
        let path = ltsc_core::files::VPath::resolve("", "example.lts").expect("a path");
        let mut sources = ltsc_core::diag::Sources::default();
        let checked = ltsc_core::pipeline::check(&files, &mut sources, &path, &ltsc_core::pipeline::Options::default());
        assert!(checked.scene.is_some(), "the example of `{}`: {:#?}", row.name, checked.findings);
    }
}

#[test]
fn the_scene_of_the_readme_is_clean() {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    let section = text.split("## A scene").nth(1).expect("a scene");
    let lines = section.lines().skip(1).take_while(|line| line.is_empty() || line.starts_with("    "));
    let scene: Vec<&str> = lines.map(|line| line.get(4..).unwrap_or_default()).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ball.lts");
    fs::write(&path, scene.join("\n")).expect("a write");
    let ran = run(ltsc().arg("lint").arg(&path).args(["--format", "short", "--deny", "undocumented-scene"]));
    assert_eq!((ran.code, ran.out.as_str()), (Some(0), ""), "{}", ran.err);
}

#[test]
fn the_readme_names_what_there_is() {
    let text = fs::read_to_string(root().join("README.md")).expect("README.md");
    for target in ltsc_core::formats::TARGETS {
        assert!(text.contains(&format!("`{}`", target.name)), "README.md does not name {}", target.name);
    }
    for driver in ltsc_render::run::DRIVERS {
        assert!(text.contains(driver.name), "README.md does not name {}", driver.name);
    }
}

#[test]
fn the_manual_is_printed_written_and_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("docs");
    let manual = |more: &[&str]| run(ltsc().arg("manual").args(more));
    let written = |more: &[&str]| run(ltsc().args(["manual", "-o"]).arg(&out).args(more));
    assert_eq!(written(&["--check"]).code, Some(1));
    assert!(!out.exists());
    assert_eq!(written(&[]).code, Some(0));
    assert_eq!(files_below(&out), [".ltsc-pages.json", "findings.md", "reference.md", "targets.md"]);
    assert_eq!(manual(&["targets"]).out, fs::read_to_string(out.join("targets.md")).expect("a page"));
    assert_eq!(written(&["--check"]).code, Some(0));
    fs::write(out.join("targets.md"), "mine").expect("a write");
    let stale = written(&["--check"]);
    assert!(stale.code == Some(1) && stale.out.contains("targets.md") && !stale.out.contains("findings.md"));
    let unknown = manual(&["refrence"]);
    assert!(unknown.code == Some(2) && unknown.err.contains("did you mean `reference`?"), "{}", unknown.err);
    assert!(manual(&[]).out.contains("reference"));
    assert_eq!(manual(&["reference", "-o", "x"]).code, Some(2));
}

#[test]
fn the_catalogue_is_written_checked_and_cleared() {
    let (folder, path) = scene("one", "shape a = box(size: 1) with diffuse(0.5)");
    let out = folder.path().join("out");
    let scenes = path.parent().expect("a folder").to_owned();
    let doc = |more: &[&str]| run(ltsc().arg("doc").arg(&scenes).arg("-o").arg(&out).args(more));
    assert_eq!(doc(&["--check"]).code, Some(1));
    assert!(!out.exists());
    assert_eq!(doc(&[]).code, Some(0));
    assert_eq!(files_below(&out), [".ltsc-pages.json", "README.md", "one.md", "pictures/one.svg"]);
    assert_eq!(doc(&["--check"]).code, Some(0));
    // A page of a scene that is gone goes, and files of someone else stay, also one that looks like ours.
    fs::write(scenes.join("gone.lts"), fs::read_to_string(&path).expect("a scene").replace("scene one", "scene gone"))
        .expect("a write");
    assert_eq!(doc(&[]).code, Some(0));
    assert!(out.join("gone.md").exists());
    fs::remove_file(scenes.join("gone.lts")).expect("removed");
    fs::copy(out.join("one.md"), out.join("copy.md")).expect("a copy");
    fs::write(out.join("notes.md"), "mine").expect("a write");
    let stale = doc(&["--check"]);
    assert!(stale.code == Some(1) && stale.out.contains("left over") && stale.out.contains("gone.md"), "{}", stale.out);
    assert_eq!(doc(&[]).code, Some(0));
    assert!(!out.join("gone.md").exists() && out.join("notes.md").exists() && out.join("copy.md").exists());
    assert!(!out.join("pictures/gone.svg").exists());

    assert_eq!(doc(&["--format", "html"]).code, Some(0));
    let html = fs::read_to_string(out.join("one.html")).expect("a page");
    assert!(html.contains("<td>triangles</td><td>14</td>") && html.contains("<h1>one</h1>"), "{html}");
    assert!(fs::read_to_string(out.join("index.html")).expect("a page").contains("href=\"one.html\""));

    // A library has no page, and a scene with errors none either.
    fs::write(&path, "lts 1\nlet a = 1\n").expect("a write");
    assert_eq!(doc(&[]).code, Some(2));
    fs::write(&path, "lts 1\nscene one {}\n").expect("a write");
    let broken = doc(&[]);
    assert!(broken.code == Some(3) && broken.err.contains("nothing was written"), "{}", broken.err);
}

#[test]
fn statistics_of_a_build_are_a_table() {
    let (folder, path) = scene("one", "shape a = box(size: 1) with diffuse(0.5)");
    let ran = run(ltsc().arg("build").arg(&path).args(["--stats", "--target", "pbrt-v4,gltf"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines[0], "| scene | time | triangles | instances | bytes: meshes, images | `pbrt-v4` | `gltf` |");
    assert!(lines[2].starts_with("| `one` | ") && lines[2].contains(" ms | 14 | 0 | "), "{}", lines[2]);
    // The bytes are those of the files that a build writes, but for the ledger.
    let out = folder.path().join("out");
    assert_eq!(run(ltsc().arg("build").arg(&path).arg("-o").arg(&out)).code, Some(0));
    let size = |below: &str| -> u64 {
        let folder = out.join("one").join(below);
        let files = files_below(&folder).into_iter().filter(|file| file != "ledger.json");
        files.map(|file| fs::metadata(folder.join(file)).expect("a file").len()).sum()
    };
    let cells: Vec<u64> = lines[2].split('|').skip(5).filter_map(|cell| cell.replace(' ', "").parse().ok()).collect();
    assert_eq!(cells, [size("meshes"), size("pbrt-v4"), size("gltf")]);
}
