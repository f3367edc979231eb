//! No text runs without end or takes all memory: each built-in with large arguments in a long loop, texts that once did not
//! end, and random programs.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::{Constructor, Evaluated, Family, Overrides, Ty, evaluate, table};
use ltsc_core::files::{MemoryFiles, VPath};
use proptest::prelude::*;

use super::run;

/// How long a text of this file may take in a build without optimization, on a machine that does other things too. Those that
/// do not end took hours.
const PATIENCE: Duration = Duration::from_secs(60);

/// What ends a text that would take too much.
const BOUNDS: [&str; 5] = ["step-limit", "memory-limit", "triangle-limit", "list-limit", "nesting-limit"];

/// What the text means within small limits, and the codes of its errors.
fn evaluated(text: &str) -> (Evaluated, Vec<&'static str>) {
    evaluated_in(text, 20_000)
}

fn evaluated_in(text: &str, steps: u64) -> (Evaluated, Vec<&'static str>) {
    let mut files = MemoryFiles::default();
    files.insert("a.lts", text.as_bytes());
    files.insert("oak.png", include_bytes!("../cases/textures/quads.png"));
    files.insert("table.glb", include_bytes!("../cases/meshes/table.glb"));
    files.insert("many.npy", npy("(20000, 3)", 60_000));
    let mut overrides = Overrides::default();
    overrides.limits.steps = steps;
    overrides.limits.memory = 64 << 20;
    overrides.limits.triangles = 200_000;
    let before = Instant::now();
    let path = VPath::resolve("", "a.lts").expect("a path");
    let found = evaluate(&files, &mut Sources::default(), &path, &overrides);
    assert!(before.elapsed() < PATIENCE, "{:?} for\n{}", before.elapsed(), &text[..text.len().min(500)]);
    let errors = found.findings.iter().filter(|finding| finding.severity == Severity::Error);
    let errors = errors.map(|finding| finding.id).collect();
    (found, errors)
}

/// A file as `numpy.save` writes it.
fn npy(shape: &str, count: usize) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend((0..count).flat_map(|at| (at as f64).to_le_bytes()));
    bytes
}

/// Values that calls are made with: lists of thousands, a mesh of thousands of triangles, a group at 20 000 places.
const VALUES: &str = "lts 1
let b = [for i in 0..3999: i]
let p2 = [for i in b: (300 + i, 1 + i)]
let p3 = [for i in b: (i, mod(i, 7), mod(i, 3))]
let f3 = [(0, 1, 3)]
let hill(x: number, y: number) = sum([for w in b: sin(w * x * 1deg)]) + y
mesh m = sphere(segments: 60, rings: 60)
material d = diffuse(0.5)
group g { shape s = box(size: 1) with d }
";

/// An argument of a type that makes much work.
fn argument(ty: Ty) -> &'static str {
    match ty {
        Ty::Number | Ty::NumberOrVec3 => "0.5",
        Ty::Whole => "60",
        Ty::Angle | Ty::NumberOrAngle => "30deg",
        Ty::Bool => "true",
        Ty::String => "\"#e1c657\"",
        Ty::Color | Ty::ColorOrTexture => "spectrum(p2)",
        Ty::Vec2 => "(60, 60)",
        Ty::Vec3 | Ty::NumberOrVector => "(1, 2, 3)",
        Ty::Extent | Ty::Range => "0..1",
        Ty::Cells => "(2..6, 2..6)",
        Ty::Axis => "Z",
        Ty::Row => "(1, 0, 0, 0)",
        Ty::Points => "p3",
        Ty::Points2 => "p2",
        Ty::Faces => "f3",
        Ty::Numbers | Ty::List => "b",
        Ty::Mesh => "m",
        Ty::Placeable | Ty::Turnable => "(g |> scatter(\"many.npy\"))",
        Ty::Material => "d",
        Ty::Filter => "box()",
        Ty::Height => "hill",
    }
}

/// Calls whose arguments depend on each other.
fn special(row: &Constructor) -> Option<&'static str> {
    Some(match (row.family, row.name) {
        (Family::Light, "environment") => "environment(radiance: spectrum(p2))",
        (Family::Light, "spot") => {
            "spot(position: (0, 0, 1), target: (0, 0, 0), intensity: spectrum(p2), angle: 40deg)"
        }
        (Family::Mesh, "rectangle") => "rectangle(x: 0..1, y: 0..1, z: 0, normal: Z)",
        (Family::Filter, "box") => "image(8, 8, filter: box())",
        (Family::Mesh, "box") => "box(size: 1)",
        (Family::Mesh, "plate") => "plate(x: -5..5, y: 4.95..5, z: 0..10, raster: (60, 60), hole: (2..6, 2..6))",
        (Family::Mesh, "disk") => "disk(radius: 1, segments: 3000)",
        (Family::Mesh, "torus") => "torus(major: 2, minor: 0.5, segments: 100)",
        (Family::Mesh, "cone") => "cone(radius: 1, top: 0.5, z: 0..1, segments: 3000)",
        (Family::Mesh, "triangles") => "triangles(positions: p3, faces: f3)",
        (Family::Mesh | Family::Group, "file") => "file(\"table.glb\")",
        (Family::Mesh, "height_field") => "height_field(hill, x: 0..1, y: 0..1, vertices: (60, 60))",
        (Family::Stage, "translate") => "g |> scatter(\"many.npy\") |> translate(1, 2, 3)",
        (Family::Stage, "rotate") => "g |> scatter(\"many.npy\") |> rotate(z: 30deg)",
        (Family::Stage, "scale") => "g |> scatter(\"many.npy\") |> scale(2)",
        (Family::Stage, "frame") => "g |> scatter(\"many.npy\") |> frame(x: X, z: Z)",
        (Family::Stage, "matrix") => "g |> scatter(\"many.npy\") |> matrix((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))",
        (Family::Stage, "scatter") => "g |> scale(2) |> scatter(\"many.npy\")",
        (Family::Camera, _) => "perspective(eye: (0, -1, 0), target: (0, 0, 0), fov_x: 30deg)",
        (Family::Texture, "bitmap") => "bitmap(\"oak.png\")",
        (Family::Function, "table") => "table(\"many.npy\")",
        (Family::Function, "random") => "random(i, i + 1)",
        (Family::Film, _) => "image(60, 60)",
        _ => return None,
    })
}

fn call(row: &Constructor) -> String {
    if let Some(text) = special(row) {
        return text.to_owned();
    }
    let large = |ty| matches!(ty, Ty::Whole | Ty::Points | Ty::Points2 | Ty::Faces | Ty::Numbers | Ty::List);
    let params = row.params.iter().filter(|param| param.default.is_none() || large(param.ty));
    let args: Vec<String> = params.map(|param| format!("{}: {}", param.name, argument(param.ty))).collect();
    match (row.family, args.split_first()) {
        (Family::Stage, Some((first, rest))) => {
            let before = first.split_once(": ").map_or("m", |(_, value)| value);
            format!("{before} |> {}({})", row.name, rest.join(", "))
        }
        _ => format!("{}({})", row.name, args.join(", ")),
    }
}

/// Each built-in in a loop of values and in one of statements, or by turns in one of the two.
fn loops_end(values: &str, steps: u64, both: bool) {
    let mut wrong = Vec::new();
    for (at, row) in table().enumerate() {
        let call = call(row);
        let loops = [
            format!("{values}let all = [for i in 0..999999: {call}]\n"),
            format!(
                "{values}let f(i: number) = {call}\nfor i in 0..999, j in 0..999 {{\n    let a = f(j)\n    let c = {call}\n}}\n"
            ),
        ];
        for (_, text) in loops.iter().enumerate().filter(|(which, _)| both || at % 2 == *which) {
            let (_, errors) = evaluated_in(text, steps);
            if errors.is_empty() || !errors.iter().all(|one| BOUNDS.contains(one)) {
                wrong.push(format!("`{call}` of {} ends by {errors:?}", row.family.words()));
            }
        }
    }
    assert!(wrong.is_empty(), "does `special` need a call of one of these?\n{}", wrong.join("\n"));
}

/// With values and bounds a quarter as long as in the long run.
#[test]
fn no_built_in_runs_without_end() {
    let values = VALUES.replace("0..3999", "0..999");
    assert_ne!(values, VALUES);
    loops_end(&values, 2_000, false);
}

#[test]
#[ignore = "long: each built-in in both loops, with long values"]
fn no_built_in_runs_without_end_in_either_loop() {
    loops_end(VALUES, 20_000, true);
}

#[test]
fn texts_that_did_not_end_do() {
    let long = |count: usize, line: &dyn Fn(usize) -> String| (1..count).map(line).collect::<String>();
    let mut nested = "let l0 = b\n".to_owned();
    for at in 1..6 {
        let _ = writeln!(nested, "let l{at} = [for i in 0..999: l{}]", at - 1);
    }
    let deep = "[".repeat(6) + "number" + &"]".repeat(6);
    let texts = [
        "let a = [for i in 0..999999: sum(b)]".to_owned(),
        "let a = [for i in 0..999999: b[0..3998]]".to_owned(),
        "let f(x: [number]) = x[0]\nlet a = [for i in 0..999999: f(b)]".to_owned(),
        "let f(x: [color]) = x[0]\nlet a = [for i in 0..999999: f(b)]".to_owned(),
        "let a = [for i in 0..999999: [for j in b: j]]".to_owned(),
        "let a = [for i in 0..999999: b == [for j in b: j]]".to_owned(),
        "let a = [for i in 0..999999: spectrum(p2) * 2]".to_owned(),
        "group h(x: [number], y: number) { shape s = box(size: 1 + y) with d }\nfor i in 0..999999 { instance a = h(b, i) }"
            .to_owned(),
        "group h(x: mesh, y: number) { shape s = x |> scale(1 + y) with d }\nfor i in 0..999999 { instance a = h(m, i) }"
            .to_owned(),
        format!("let a = [for i in 0..999999: [{}1]]", "1, ".repeat(10_000)),
        format!("let a = [for i in 0..999999: ({}1)]", "1, ".repeat(10_000)),
        format!("let a = [for i in 0..999999: \"{}\"]", "x".repeat(100_000)),
        format!("for i in 0..999999 {{ let f(x: number) = len([{}1]) }}", "x, ".repeat(10_000)),
        format!("{nested}let f(x: {deep}) = 1\nlet y = f(l5)"),
        format!("{nested}let y = l5 == l5"),
        format!("{nested}group h(x: {deep}) {{ shape s = box(size: 1) with d }}\ninstance i = h(l5)"),
        format!("let a0 = [1]\n{}", long(3000, &|at| format!("let a{at} = [a{}]\n", at - 1))),
        format!("let a0 = (1, \"\")\n{}", long(3000, &|at| format!("let a{at} = (a{}, 1)\n", at - 1))),
        format!(
            "let k0(x: number) = x\n{}",
            long(3000, &|at| format!("let k{at}(x: number) = if x > 0 then 0 else k{}(x)\n", at - 1))
        ),
    ];
    for text in texts {
        let (_, errors) = evaluated(&format!("{VALUES}{text}\n"));
        let ended = !errors.is_empty() && errors.iter().all(|one| BOUNDS.contains(one));
        assert!(ended, "{errors:?}\n{}", &text[..text.len().min(300)]);
    }
    // Long texts, each part of which looked at all others: they end, and nothing is wrong with the first two.
    let lets = long(20_000, &|at| format!("    let a{at} = {at}\n"));
    assert_eq!(
        evaluated(&format!("lts 1\ngroup g {{\n{lets}    shape s = box(size: a1) with diffuse(1)\n}}\n")).1,
        [""; 0]
    );
    assert_eq!(evaluated(&format!("lts 1\ngroup g(a: number) {{\n{lets}}}\n")).1, [""; 0]);
    let unknown = long(20_000, &|at| format!("let a{at} = b{at}\n"));
    assert_eq!(evaluated(&format!("lts 1\n{unknown}")).1.len(), 19_999);
}

#[test]
fn lists_are_shared_and_let_go() {
    // A slice and an argument take no room, and what a loop leaves is counted no more.
    let text = "for i in 0..199 {\n    let c = reverse(b[0..199])\n    let d2 = concat(c, c)\n}\n\
                let f(x: [number]) = x[0]\nlet a = [for i in 0..49: f(b)]\nlet s = [for i in 0..999: b[1..3000]]\n";
    assert_eq!(evaluated(&format!("{VALUES}{text}")).1, [""; 0]);
}

#[test]
fn the_command_ends_within_time_and_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let texts = [
        ("sum", "let a = [for i in 0..999999: sum(b)]", "step-limit"),
        ("reverse", "let a = [for i in 0..9999: reverse(b)]", "memory-limit"),
    ];
    for (name, text, code) in texts {
        let path = folder.path().join(format!("{name}.lts"));
        std::fs::write(&path, format!("lts 1\nlet b = [for i in 0..99999: i]\n{text}\n")).expect("a scene");
        // 2 GiB of addresses, which is more than all that may be held.
        let script =
            "ulimit -v 2097152; exec \"$0\" lint --limit steps=200000 --limit memory=256MiB --format short \"$1\"";
        let mut command = std::process::Command::new("sh");
        command.args(["-c", script, env!("CARGO_BIN_EXE_ltsc")]).arg(&path);
        let ran = run(&mut command);
        assert_eq!(ran.code, Some(3), "{}{}", ran.out, ran.err);
        assert!(ran.out.contains(&format!("{name}.lts:3:")) && ran.out.contains(code), "{}", ran.out);
    }
}

/// A random expression that gives a list.
fn list() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec!["b", "p2", "[1, 2]", "[for i in 0..999: i]"]).prop_map(str::to_owned);
    leaf.prop_recursive(5, 40, 3, |inner| {
        prop_oneof![
            inner.clone().prop_map(|of| format!("reverse({of})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("concat({a}, {b})")),
            inner.clone().prop_map(|of| format!("{of}[0..1]")),
            (inner.clone(), 0..4_usize).prop_map(|(of, at)| format!("[for q{at} in {of}: [q{at}, {at}]]")),
            (inner.clone(), inner.clone(), 4..8_usize)
                .prop_map(|(over, of, at)| format!("[for r{at} in {over}: {of}]")),
            (inner.clone(), inner).prop_map(|(a, b)| format!("(if len({a}) > 2 then {b} else [])")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_programs_end(expressions in prop::collection::vec(list(), 1..4)) {
        let lines: String = expressions.iter().enumerate().map(|(at, text)| format!("let v{at} = {text}\n")).collect();
        evaluated(&format!("{VALUES}{lines}"));
    }
}
