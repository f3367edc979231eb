//! Texts before and after.

use proptest::prelude::*;

use super::{MAKERS, apply};
use crate::diag::{Finding, Severity, Sources};
use crate::files::{MemoryFiles, VPath};
use crate::lint::Level;
use crate::pipeline::{self, Options};

const HEADER: &str = "/// A.\n///\n/// B.\nscene a {\n    paths: [\"LDE\"]\n}\n\n\
    camera = perspective(eye: (0, -10, 2), target: (0, 0, 2), fov_x: 45deg)\nfilm = image(16, 8)\n\
    integrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
    emitter lamp = rectangle(x: -1..1, y: -1..1, z: 5, normal: -Z) with radiance(10)\n\
    shape floor = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) with diffuse(0.5)\n";

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 3\n1 0 3\n0 1 3\n3 0 2 1\n";

/// A cube whose faces look inwards.
fn inside_out_cube() -> String {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 24\nproperty float x\nproperty float y\nproperty float z\n\
                    property float nx\nproperty float ny\nproperty float nz\nelement face 6\n\
                    property list uchar int vertex_indices\nend_header\n"
        .to_owned();
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let mut corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        if side == 1 {
            corners.reverse();
        }
        for [u, v] in corners {
            let mut point = [0; 3];
            (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, u, v);
            let mut normal = [0; 3];
            normal[axis] = 1 - 2 * side;
            let numbers: Vec<String> = [point, normal].as_flattened().iter().map(ToString::to_string).collect();
            text.push_str(&(numbers.join(" ") + "\n"));
        }
    }
    for face in 0..6 {
        let at = 4 * face;
        text.push_str(&format!("4 {at} {} {} {}\n", at + 1, at + 2, at + 3));
    }
    text
}

const LIBRARY: &str = "lts 1\n\nlet p = 1\nlet q = 2\nlet r = 3\n";

fn check(text: &str) -> (Vec<Finding>, Sources) {
    let mut files = MemoryFiles::default();
    files.insert("a.lts", text);
    files.insert("mesh.ply", MESH);
    files.insert("cube.ply", inside_out_cube());
    files.insert("lib.lts", LIBRARY);
    let path = VPath::resolve("", "a.lts").expect("a path");
    let mut sources = Sources::default();
    let mut options = Options::default();
    // It is off unless asked for.
    options.levels.set("misplaced-mesh", Level::Warn).expect("a rule");
    let checked = pipeline::check(&files, &mut sources, &path, &options);
    (checked.findings, sources)
}

/// One round.
fn once(text: &str) -> (String, usize) {
    let (findings, sources) = check(text);
    let file = sources.find("a.lts").expect("the text");
    let applied = apply(text, file, findings.iter().filter_map(|finding| finding.fix.as_ref()));
    (applied.text, applied.made.len())
}

/// All rounds.
fn fixed(text: &str) -> String {
    let mut text = text.to_owned();
    for _ in 0..20 {
        let (next, fixes) = once(&text);
        assert_eq!(next == text, fixes == 0, "a fix changes something\n{text}");
        if fixes == 0 {
            return text;
        }
        text = next;
    }
    panic!("there is no end of fixes:\n{text}");
}

/// Additions to a clean scene, before and after, with the code that each is about.
const CASES: &[(&str, &str, &str)] = &[
    (
        "smooth-emitter",
        "emitter b = sphere(segments: 8, rings: 4) with radiance(1)",
        "emitter b = sphere(segments: 8, rings: 4) |> faceted() with radiance(1)",
    ),
    (
        "smooth-emitter",
        "for i in 0..1 {\n    emitter b = if i == 0 then sphere(segments: 8, rings: 4) else sphere(radius: 2, segments: 8, rings: 4)  // two\n        with radiance(1)\n}",
        "for i in 0..1 {\n    emitter b = (if i == 0 then sphere(segments: 8, rings: 4) else sphere(radius: 2, segments: 8, rings: 4)) |> faceted()  // two\n        with radiance(1)\n}",
    ),
    (
        "smooth-emitter",
        "mesh ball = sphere(segments: 8, rings: 4)\nshape s = ball with diffuse(0.5)\nemitter b = ball with radiance(1)",
        "mesh ball = sphere(segments: 8, rings: 4)\nshape s = ball with diffuse(0.5)\nemitter b = ball |> faceted() with radiance(1)",
    ),
    (
        "inside-out-mesh",
        "shape b = box(size: 1) |> flip() |> translate(z: 2) with diffuse(0.5)",
        "shape b = box(size: 1) |> flip() |> translate(z: 2) |> flip() with diffuse(0.5)",
    ),
    (
        "inside-out-mesh",
        "group room { shape b = file(\"cube.ply\") with diffuse(0.5) }\ninstance r = room",
        "group room { shape b = file(\"cube.ply\") |> flip() with diffuse(0.5) }\ninstance r = room",
    ),
    (
        "inside-out-mesh",
        "for i in 0..1 { shape b = if i == 0 then box(size: 1) else file(\"cube.ply\") with diffuse(0.5) }",
        "for i in 0..1 { shape b = if i == 0 then box(size: 1) else file(\"cube.ply\") with diffuse(0.5) }",
    ),
    (
        "emitter-facing-away",
        "emitter b = rectangle(x: 0..1, y: 0..1, z: 9, normal: Z) with radiance(1)  // up",
        "emitter b = rectangle(x: 0..1, y: 0..1, z: 9, normal: Z) |> flip() with radiance(1)  // up",
    ),
    (
        "emitter-facing-away",
        "for i in 0..1 { emitter b = rectangle(x: 0..1, y: 0..1, z: 9 + i, normal: Z) with radiance(1) }",
        "for i in 0..1 { emitter b = rectangle(x: 0..1, y: 0..1, z: 9 + i, normal: Z) with radiance(1) }",
    ),
    (
        "emitter-facing-away",
        "emitter b = spot(position: (0, 0, 9), target: (0, 0, 10), intensity: 1, angle: 20deg)",
        "emitter b = spot(position: (0, 0, 9), target: (0, 0, 10), intensity: 1, angle: 20deg)",
    ),
    (
        "emitter-facing-away",
        "emitter b = rectangle(x: 0..1, y: 0..1, z: 9, normal: Z) with radiance(1)\nshape far = box(size: 100, center: (0, 0, -10000000)) with diffuse(0.5)",
        "emitter b = rectangle(x: 0..1, y: 0..1, z: 9, normal: Z) |> flip() with radiance(1)\nshape far = box(size: 100, center: (0, 0, -10000000)) with diffuse(0.5)",
    ),
    // What its author means is another matter.
    (
        "missing-normals",
        "shape b = file(\"mesh.ply\") with diffuse(0.5)",
        "shape b = file(\"mesh.ply\") with diffuse(0.5)",
    ),
    (
        "rough-too-small",
        "shape b = box(size: 1) with conductor(eta: 3.2, k: 3.3, alpha: 1e-3)",
        "shape b = box(size: 1) with conductor(eta: 3.2, k: 3.3, alpha: 1e-3)",
    ),
    (
        "inside-out-mesh",
        "emitter b = box(size: 1) |> flip() with radiance(1)",
        "emitter b = box(size: 1) |> flip() with radiance(1)",
    ),
    (
        "smooth-emitter",
        "material m = diffuse(0.5)\nemitter b = sphere(segments: 8, rings: 4) with radiance(1, over: m)",
        "material m = diffuse(0.5)\nemitter b = sphere(segments: 8, rings: 4) with radiance(1, over: m)",
    ),
    (
        "misplaced-mesh",
        "let up = 2\nshape b = box(size: 1) |> translate(0.5, z: 3 * up) with diffuse(0.5)",
        "let up = 2\nshape b = box(size: 1, center: (0.5, 0, 3 * up)) with diffuse(0.5)",
    ),
    (
        "misplaced-mesh",
        "shape b = sphere()\n    |> translate(y: 4)  // behind\n    with mirror(0.9)",
        "shape b = sphere(center: (0, 4, 0))  // behind\n    with mirror(0.9)",
    ),
    (
        "misplaced-mesh",
        "shape b = box(size: 1) |> translate(by: (0, 0, 3)) with diffuse(0.5)",
        "shape b = box(size: 1) |> translate(by: (0, 0, 3)) with diffuse(0.5)",
    ),
    (
        "misplaced-mesh",
        "shape b = box(size: 1, center: (0, 1, 0)) |> translate(z: 3) with diffuse(0.5)",
        "shape b = box(size: 1, center: (0, 1, 0)) |> translate(z: 3) with diffuse(0.5)",
    ),
    (
        "misplaced-mesh",
        "shape b = box(\n    size: 1,  // one\n) |> translate(z: 3) with diffuse(0.5)",
        "shape b = box(\n    size: 1,  // one\n) |> translate(z: 3) with diffuse(0.5)",
    ),
    (
        "reversed-range",
        "shape b = rectangle(x: 5..-5, y: -1 .. -2.50, z: 0, normal: Z) with diffuse(0.5)",
        "shape b = rectangle(x: -5..5, y: -2.50 .. -1, z: 0, normal: Z) with diffuse(0.5)",
    ),
    ("reversed-range", "let l = [for i in 3..0: i]\nlet n = len(l)", "let l = [for i in 3..0: i]\nlet n = len(l)"),
    (
        "unused-name",
        "use p from \"lib.lts\"\n\nshape b = box(size: 1) with diffuse(0.5)",
        "\nshape b = box(size: 1) with diffuse(0.5)",
    ),
    (
        "unused-name",
        "use p, q as s,  r from \"lib.lts\"  // three\nshape b = box(size: p) with diffuse(0.5)",
        "use p from \"lib.lts\"  // three\nshape b = box(size: p) with diffuse(0.5)",
    ),
    (
        "unused-name",
        "use p, q as s,  r from \"lib.lts\"\nshape b = box(size: r) with diffuse(0.5)",
        "use r from \"lib.lts\"\nshape b = box(size: r) with diffuse(0.5)",
    ),
    (
        "unused-name",
        "// Numbers.\nuse p from \"lib.lts\"\nuse q from \"lib.lts\"  // not used\nshape b = box(size: 1) with diffuse(0.5)",
        "// Numbers.\nuse p from \"lib.lts\"\nuse q from \"lib.lts\"  // not used\nshape b = box(size: 1) with diffuse(0.5)",
    ),
    (
        "unused-allow",
        "shape c = box(size: 2) with diffuse(0.5)\n\nallow smooth-emitter \"none\"\nshape b = box(size: 1) with diffuse(0.5)",
        "shape c = box(size: 2) with diffuse(0.5)\n\nshape b = box(size: 1) with diffuse(0.5)",
    ),
    ("unused-allow", "allow smooth-emitter \"nothing follows\"", "allow smooth-emitter \"nothing follows\""),
];

#[test]
fn each_fix_gives_what_is_expected_and_nothing_else() {
    for (id, before, after) in CASES {
        let text = |part: &str| format!("lts 1\n\n{HEADER}{part}\n");
        let (findings, _) = check(&text(before));
        assert!(findings.iter().any(|finding| finding.id == *id), "no {id} in\n{before}\n{findings:#?}");
        assert_eq!(fixed(&text(before)), text(after));
    }
    let covered = |id: &str| {
        id == "missing-version" || CASES.iter().any(|(known, before, after)| *known == id && before != after)
    };
    for (id, _) in MAKERS {
        assert!(covered(id), "no case of the fix of {id}");
    }
    assert!(MAKERS.is_sorted_by(|a, b| a.0 < b.0));
}

#[test]
fn a_version_is_written_with_the_line_ends_of_the_file() {
    assert_eq!(fixed(HEADER), format!("lts 1\n\n{HEADER}"));
    let windows = HEADER.replace('\n', "\r\n");
    assert_eq!(fixed(&windows), format!("lts 1\r\n\r\n{windows}"));
    assert_eq!(fixed(&format!("// mine\n{HEADER}")), format!("lts 1\n\n// mine\n{HEADER}"));
}

#[test]
fn fixes_that_meet_wait_for_each_other() {
    use crate::diag::{Edit, Fix, Span};
    let mut sources = Sources::default();
    let (file, other) = (sources.add("a", "abcdef"), sources.add("b", "abcdef"));
    let of = |file, start, end, text: &str| Edit { span: Span::new(file, start, end), text: text.to_owned() };
    let fix = |edits: Vec<Edit>| Fix { title: String::new(), edits };
    let fixes = [
        fix(vec![of(file, 4, 5, "E"), of(file, 0, 0, "<")]),
        fix(vec![of(file, 3, 4, "D")]),
        fix(vec![of(file, 2, 3, "C"), of(file, 4, 4, "!")]),
        fix(vec![of(other, 1, 2, "B")]),
        fix(vec![of(file, 2, 3, "")]),
        fix(vec![of(file, 4, 5, "E"), of(file, 0, 0, "<")]),
    ];
    let applied = apply("abcdef", file, fixes.iter());
    assert_eq!((applied.text.as_str(), applied.made), ("<abdEf", vec![0, 4]));
}

#[test]
fn many_fixes_are_one_round() {
    let lamps: String = (0..2000)
        .map(|at| format!("emitter b{at} = rectangle(x: 2..1, y: 0..1, z: {at}, normal: Z) with radiance(1)\n"))
        .collect();
    let text = format!("{HEADER}{lamps}");
    let (findings, sources) = check(&text);
    let file = sources.find("a.lts").expect("the text");
    let applied = apply(&text, file, findings.iter().filter_map(|finding| finding.fix.as_ref()));
    assert_eq!((applied.made.len(), applied.text), (2001, format!("lts 1\n\n{}", text.replace("2..1", "1..2"))));
}

/// Statements that may stand in any order.
fn statements() -> impl Strategy<Value = Vec<String>> {
    let cases = CASES
        .iter()
        .map(|(_, before, _)| *before)
        .filter(|before| !before.contains("use ") && !before.contains("let "));
    let mut lines: Vec<String> = cases.map(str::to_owned).collect();
    lines
        .extend(["// a remark", "", "shape b = box(size: 1) with diffuse(0.5)  // b", "let p2 = 1"].map(str::to_owned));
    lines.extend([
        "allow smooth-emitter \"wanted\"\nemitter b = sphere(segments: 8, rings: 4) with radiance(1)".to_owned()
    ]);
    prop::collection::vec(prop::sample::select(lines), 0..8)
}

/// Mends a text of these parts, again and again.
fn mended(parts: &[String], version: bool) -> Result<(), TestCaseError> {
    // Names are told apart by their place.
    let named: Vec<String> = parts
        .iter()
        .enumerate()
        .map(|(at, part)| {
            part.replace(" b = ", &format!(" b{at} = "))
                .replace(" c = ", &format!(" c{at} = "))
                .replace("ball", &format!("ball{at}"))
                .replace("p2", &format!("p{at}"))
        })
        .collect();
    let text = format!("{}{HEADER}{}\n", if version { "lts 1\n\n" } else { "" }, named.join("\n"));
    let done = fixed(&text);
    prop_assert_eq!(&fixed(&done), &done);
    let (before, _) = check(&text);
    let (after, _) = check(&done);
    let errors = |findings: &[Finding]| findings.iter().filter(|finding| finding.severity == Severity::Error).count();
    prop_assert!(errors(&after) <= errors(&before), "{}\n{:#?}", done, after);
    prop_assert!(after.iter().all(|finding| finding.fix.is_none()), "{}\n{:#?}", done, after);
    // Comments, and every line without a finding, are there in their order.
    let touched = |line: &&str| {
        [
            "sphere(",
            "ball",
            "mesh.ply",
            "alpha:",
            "-2.50",
            "allow ",
            "lts 1",
            "normal: Z) with radiance",
            "translate(",
            "flip()",
            "cube.ply",
            "part",
        ]
        .iter()
        .any(|part| line.contains(part))
            || line.is_empty()
    };
    let rest = |text: &str| text.lines().filter(|line| !touched(line)).map(str::to_owned).collect::<Vec<_>>();
    prop_assert_eq!(rest(&text), rest(&done));
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn fixes_end_and_keep_the_rest(parts in statements(), version: bool) {
        mended(&parts, version)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    #[ignore = "long: 24 texts"]
    fn fixes_of_more_texts_end_and_keep_the_rest(parts in statements(), version: bool) {
        mended(&parts, version)?;
    }
}
