//! OBJ against tobj, its parts, its faults, noise; and what both formats share.

use std::fmt::Write as _;

use proptest::prelude::*;

use super::*;

const SQUARES: &str = "# two squares
mtllib a.mtl
o left
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 1
vn 0 0 1
f 1/1/1 2/2/1 3/1/1 4/2/1
o right
g up front
v 5 0 0
v 6 0 0
v 6 1 0
f -3/1/1 -2/1/1 -1/1/1
";

fn obj(text: &str) -> (Geometry, Vec<Note>) {
    read("obj", text.as_bytes(), None, &mut alone).expect("a good file")
}

fn fault(text: &str, part: Option<&str>) -> FileError {
    read("OBJ", text.as_bytes(), part, &mut alone).map(|_| ()).expect_err("a bad file")
}

#[test]
fn squares_are_read() {
    let (g, notes) = obj(SQUARES);
    assert_eq!((g.positions.len(), g.check()), (7, Ok(())));
    assert_eq!(g.triangles, [[0, 1, 2], [0, 2, 3], [4, 5, 6]]);
    assert_eq!(g.positions[4..], [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 1.0, 0.0]]);
    assert_eq!(g.uvs.as_ref().map(|uvs| uvs[1]), Some([1.0, 1.0]));
    assert_eq!(g.normals, Some(vec![[0.0, 0.0, 1.0]; 7]));
    let said: Vec<_> = notes.iter().map(|note| (note.message.as_str(), note.place.as_str())).collect();
    let polygons = "1 face with more than 3 corners cut into triangles";
    assert_eq!(said, [("materials are not read: a shape gets its own by `with`", "line 2"), (polygons, "")]);
    let windows = SQUARES.replace('\n', "\r\n").replace("f -3/1/1 ", "f -3/1/1 \\\r\n ");
    assert_eq!(obj(&windows).0, g);
}

#[test]
fn parts_are_objects_and_groups() {
    let part = |name| {
        read("obj", SQUARES.as_bytes(), Some(name), &mut alone).map(|(g, _)| (g.positions.len(), g.triangles.len()))
    };
    assert_eq!(part("left"), Ok((4, 2)));
    for name in ["right", "up", "front", "up front"] {
        assert_eq!(part(name), Ok((3, 1)), "{name}");
    }
    assert_eq!(parts("obj", SQUARES.as_bytes()), Ok(["left", "right", "up", "front"].map(str::to_owned).to_vec()));
    assert_eq!(fault(SQUARES, Some("rigth")).help.as_deref(), Some("is `right` meant?"));
    let other = fault(SQUARES, Some("something else"));
    assert_eq!(other.help.as_deref(), Some("its parts are `left`, `right`, `up`, `front`"));
    assert!(read("ply", b"ply", Some("left"), &mut alone).is_err());
}

#[test]
fn vertices_split_where_normals_or_textures_differ_and_only_there() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 -2 0\nf 1//1 2//1 3//1\nf 1//2 4//2 2//2\nf 3//1 2//1 1//1\n";
    let (g, notes) = obj(text);
    assert_eq!(g.triangles, [[0, 1, 2], [3, 4, 5], [2, 1, 0]]);
    assert_eq!(g.normals.as_ref().map(|normals| normals[4]), Some([0.0, -1.0, 0.0]));
    assert_eq!(notes.len(), 1);
    assert_eq!((notes[0].message.as_str(), notes[0].place.as_str()), ("3 normals brought to unit length", "line 6"));
}

#[test]
fn normals_that_only_some_corners_have_are_dropped_with_a_note() {
    let (g, notes) = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 0\nf 1//1 2//1 3\nf 1 2 3\n");
    assert_eq!((g.normals, g.positions.len()), (None, 3));
    assert_eq!(notes[0].message, "2 normals left out, since other corners of the same part have none");
    assert_eq!(notes.len(), 1);
}

#[test]
fn faults_have_their_line() {
    let text = |line: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\nf 1 2 3\n");
    for (line, message) in [
        ("v 1 2", "the position has too few numbers"),
        ("v 1 2 x", "`x` is no number"),
        ("v 1 2 nan", "the position is not finite"),
        ("v 1 2 1e39", "the position is not finite"),
        ("vt", "the texture coordinate has too few numbers"),
        ("vn 1 2", "the normal has too few numbers"),
        ("f 1 2 4", "a face uses position (`v`) 4, but there are 3"),
        ("f 1 2 0", "the corner `0` has the index 0"),
        ("f 1 2 -4", "uses a position (`v`) that is not there"),
        ("f 1/2 2/1 3/1\nvt 0 0", "a face uses texture coordinate (`vt`) 2, but there are 1"),
        ("f 1//2 2//1 3//1\nvn 0 0 1", "a face uses normal (`vn`) 2, but there are 1"),
        ("f 1/-5 2 3", "uses a texture coordinate (`vt`) that is not there"),
        ("f 1 2 /3", "`/3` is no corner"),
        ("f 1 2 3.0", "`3.0` is no corner"),
        ("f 1/1/1/1 2 3", "has more than three indices"),
        ("f 1 2 9999999999999999999", "is no corner"),
        ("f 1 2 4294967296", "is not there"),
        ("f 1 2 -9223372036854775808", "is not there"),
    ] {
        let error = fault(&text(line), None);
        assert!(error.place == "line 4" && error.message.contains(message), "{line}: {error:?}");
    }
    assert_eq!(fault("", None).message, "the file is empty");
    assert_eq!(fault("v 0 0 0\nf 1 1\n", None).message, "the file has no triangles");
    assert_eq!(fault("V 0 0 0\nF 1 1 1\n", None).help.as_deref(), Some("line 1 begins with `V`: is this an OBJ file?"));
    // A face may stand before its vertices.
    assert_eq!(obj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").0.triangles, [[0, 1, 2]]);
    let notes = obj(&text("v 1 1 1 0.5 0.5 0.5\nbogus\nbogus\nl 1 2\nv 1 1 1 2")).1;
    assert!(notes.iter().any(|note| note.message == "2 lines not understood, the first is `bogus`"), "{notes:?}");
    assert_eq!(notes.len(), 4, "{notes:?}");
    assert!(read("3ds", b"", None, &mut alone).is_err());
}

/// The messages of notes with their places and codes.
fn said(notes: &[Note]) -> Vec<String> {
    notes.iter().map(|note| format!("{} {}: {}", note.fate.code(), note.place, note.message)).collect()
}

#[test]
fn marks_and_line_ends_make_no_difference() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n";
    let expected = obj(text);
    assert_eq!(expected.0.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    for other in [format!("\u{feff}{text}"), text.replace('\n', "\r\n"), text.replace('\n', "\r")] {
        assert_eq!(obj(&other), expected);
    }
    assert_eq!(parts("obj", b"\xef\xbb\xbfo a\rv 0 0 0\rf 1 1 1\r"), Ok(vec!["a".to_owned()]));
    let wide: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let error = read("obj", &wide, None, &mut alone).map(|_| ()).expect_err("UTF-16");
    assert_eq!(error.message, "the file is text in UTF-16");
}

#[test]
fn normals_and_texture_coordinates_that_cannot_be_used_do_not_refuse_the_mesh() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 0\nf 1//1 2//1 3//2\n";
    let (g, notes) = obj(text);
    assert_eq!((g.normals.as_deref(), g.check()), (Some(&[[0.0, 0.0, 1.0]; 3][..]), Ok(())));
    let computed = "1 normal that cannot be used, zero or not finite, computed from the faces around it";
    assert_eq!(said(&notes), [format!("mesh-file line 5: {computed}")]);
    for bad in ["nan nan nan", "-nan(ind) 0 0", "-1.#IND -1.#IND -1.#IND # none", "1.#QNAN00 0 0"] {
        assert_eq!(obj(&text.replace("vn 0 0 0", &format!("vn {bad}"))), (g.clone(), notes.clone()), "{bad}");
    }
    let (g, notes) = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt nan 0\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\n");
    assert_eq!(g.uvs, Some(vec![[0.0, 1.0], [0.0, 0.0], [0.0, 1.0]]));
    assert_eq!(said(&notes), ["loss-dropped line 5: 1 texture coordinate not finite set to (0, 0)"]);
}

#[test]
fn lists_that_are_not_there_at_all_are_not_needed() {
    let (g, notes) = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2/2/1 3/3/1\n");
    assert_eq!((g.triangles, g.normals, g.uvs), (vec![[0, 1, 2]], None, None));
    let none = |what: &str| format!("loss-dropped line 4: 3 {what}s used by faces, but the file has none");
    assert_eq!(said(&notes), [none("texture coordinate"), none("normal")]);
}

#[test]
fn smoothing_groups_become_normals() {
    // A roof of two slopes, an end each; `s` says which faces are one surface.
    let roof = |s: [&str; 2]| {
        let points = "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 1 0\nv 1 1 1\nv 2 1 0\n";
        obj(&format!("{points}{}f 1 2 5 4\n{}f 2 3 6 5\n", s[0], s[1]))
    };
    let half = 0.5_f32.sqrt();
    let (left, right) = ([-half, 0.0, half], [half, 0.0, half]);
    let (g, notes) = roof(["s 1\n", ""]);
    let normals = g.normals.expect("normals");
    assert_eq!((normals.len(), g.positions.len()), (6, 6));
    assert!(normals.contains(&[0.0, 0.0, 1.0]) && !normals.contains(&[0.0, 0.0, -1.0]));
    let computed = "loss-baked line 7: normals are computed from smoothing groups";
    assert_eq!(said(&notes), ["loss-baked : 2 faces with more than 3 corners cut into triangles", computed]);
    let turned = |normal: [f32; 3], to: [f32; 3]| normal.iter().zip(to).all(|(a, b)| (a.abs() - b.abs()).abs() < 1e-6);
    for s in [["s 1\n", "s 2\n"], ["s 1\n", "s off\n"], ["s on\n", "s 0\n"]] {
        let (g, _) = roof(s);
        let normals = g.normals.expect("normals");
        assert_eq!(normals.len(), 8, "{s:?}");
        assert!(normals.iter().all(|normal| turned(*normal, left) || turned(*normal, right)), "{s:?} {normals:?}");
    }
    assert_eq!(roof(["s off\n", ""]).0.normals, None);
    // Normals of the file come before.
    let (g, _) = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1 0\ns 1\nf 1//1 2//1 3//1\n");
    assert_eq!(g.normals, Some(vec![[0.0, 1.0, 0.0]; 3]));
    // As a group too; without smoothing groups it becomes flat, and says so.
    let group = |text: &str| read_parts("obj", text.as_bytes(), &mut alone).expect("a good file");
    let pyramid = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.5\ns 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    let (model, notes) = group(pyramid);
    assert_eq!(model.meshes[0].1.positions.len(), 5);
    assert_eq!(said(&notes), ["loss-baked line 6: normals are computed from smoothing groups"]);
    let (model, notes) = group(&pyramid.replace("s 1", "s off"));
    assert_eq!(model.meshes[0].1.positions.len(), 12);
    assert_eq!(said(&notes), ["loss-baked : 1 part without normals shaded flat"]);
}

#[test]
fn what_is_not_read_is_told_once_for_each_kind() {
    let notes = obj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1 1\nf 1 2 3\nl 1 2\nl 2 3\nsurf 0 1 0 1 1 2\n").1;
    assert_eq!(
        said(&notes),
        [
            "loss-dropped line 1: 3 vertex colors not read",
            "loss-dropped line 7: 1 free-form surface not read",
            "loss-dropped line 5: points and lines are not read",
        ]
    );
    let severe: Vec<bool> = notes.iter().map(|note| note.severity == crate::diag::Severity::Warn).collect();
    assert_eq!(severe, [true, true, false]);
    let painted = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ff804020\nf 1 2 3\n").1;
    assert_eq!(said(&painted), ["loss-dropped line 4: 1 vertex color not read"]);
}

/// The parts of an OBJ file with files beside it.
fn with_files(text: &str, files: &[(&str, &str)]) -> (Model, Vec<String>) {
    let mut beside = |path: &str| -> Result<Box<dyn AsRef<[u8]>>, String> {
        let found = files.iter().find(|(name, _)| *name == path);
        found.map(|(_, text)| Box::new(text.as_bytes().to_vec()) as _).ok_or_else(|| format!("no `{path}`"))
    };
    let (model, notes) = read_parts("obj", text.as_bytes(), &mut beside).expect("a good file");
    (model, said(&notes))
}

#[test]
fn libraries_are_found_by_all_their_names() {
    let text = |lib: &str| {
        format!("\u{feff}mtllib {lib}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nusemtl red # x\nf 1//1 2//1 3//1\n")
    };
    let files = [
        ("a.mtl", "\u{feff}newmtl red\nKd 1 0 0\n"),
        ("b.mtl", "newmtl blue\n"),
        ("my lib.mtl", "newmtl red\nKd 1 0 0"),
    ];
    for lib in ["a.mtl", "\"a.mtl\"", "my lib.mtl", "b.mtl a.mtl", "a.mtl # the library"] {
        let (model, notes) = with_files(&text(lib), &files);
        let surface = model.parts[0].surface.map(|at| model.surfaces[at].scatter.clone());
        assert_eq!((surface, notes), (Some(Scatter::Diffuse([1.0, 0.0, 0.0])), vec![]), "{lib}");
    }
    let (model, notes) = with_files(&text("C:\\x\\a.mtl"), &files);
    assert!(model.parts[0].surface.is_some());
    assert_eq!(notes, ["mesh-file line 1: of an absolute path only `a.mtl` is looked for"]);
    let (model, notes) = with_files(&text("c.mtl"), &files);
    assert_eq!(model.parts[0].surface, None);
    let missing = [
        "loss-dropped line 1: materials are not read: no `c.mtl`",
        "loss-dropped : 1 material in no library, the first is `red # x`",
    ];
    assert_eq!(notes, missing);
    // Nothing that a library says refuses the mesh.
    let (_, notes) = with_files(&text("bad.mtl"), &[("bad.mtl", "newmtl red\nKd spectral x.rfl\nKs 1 2\n")]);
    assert_eq!(notes.len(), 2, "{notes:?}");
}

#[test]
fn textures_are_scaled_and_moved_by_their_options() {
    let text =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1/1 2/2/1 3/3/1\n";
    let (model, notes) = with_files(text, &[("a.mtl", "newmtl a\nmap_Kd -s 2 3 1 -o 0.5 0 0 oak.png\n")]);
    assert_eq!(model.meshes[0].1.uvs, Some(vec![[0.5, 0.0], [2.5, 0.0], [0.5, 3.0]]));
    assert_eq!(model.surfaces[0].picture, Some(Picture::Beside("oak.png".to_owned())));
    assert_eq!(notes, ["loss-baked : the options `-s` and `-o` of a texture are in the texture coordinates"]);
}

#[test]
fn concave_faces_keep_their_area_in_all_formats() {
    let area_of = |extension: &str, bytes: &[u8]| {
        let (geometry, _) = read(extension, bytes, None, &mut alone).expect("a good file");
        crate::mesh::area((&geometry).into())
    };
    let area = |extension: &str, text: &str| area_of(extension, text.as_bytes());
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let corners = [[4.0_f32, -2.0, 0.0], [1.0, 0.0, 0.0], [4.0, 2.0, 0.0], [0.0; 3]];
    assert_eq!(area("ply", &format!("{}4 -2 0\n1 0 0\n4 2 0\n0 0 0\n4 0 1 2 3\n", header("ascii"))), 2.0);
    for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut bytes = header(format).into_bytes();
        let put = |x: [u8; 4]| if big { [x[3], x[2], x[1], x[0]] } else { x };
        bytes.extend(corners.as_flattened().iter().flat_map(|x| put(x.to_le_bytes())));
        bytes.push(4);
        bytes.extend((0..4_i32).flat_map(|x| put(x.to_le_bytes())));
        assert_eq!(area_of("ply", &bytes), 2.0, "{format}");
    }
    let dart = "v 4 -2 0\nv 1 0 0\nv 4 2 0\nv 0 0 0\n";
    assert_eq!(area("obj", &format!("{dart}f 1 2 3 4\n")), 2.0);
    // Before its corners.
    assert_eq!(area("obj", &format!("f 1 2 3 4\n{dart}")), 2.0);
    let loops = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\nf 1 2 3 4 1 5 6 7 8 5\n";
    assert_eq!(area("obj", loops), 12.0);
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 4 -2 0\nvertex 1 0 0\nvertex 4 2 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid a\n";
    assert_eq!(area("stl", stl), 2.0);
    // Parts stay apart where a face falls into fewer triangles than its fan has.
    let parts = "v 0 0 0\nv 1 0 0\nv 0 1 0\no a\nf 1 1 2 3\no b\nf 1 2 3\no c\nf 1 3 2\nf 1 2 3\n";
    let (model, _) = read_parts("obj", parts.as_bytes(), &mut alone).expect("a good file");
    let counts: Vec<(&str, usize)> =
        model.parts.iter().map(|part| (part.name.as_str(), model.meshes[part.mesh].1.triangles.len())).collect();
    assert_eq!(counts, [("a", 1), ("b", 1), ("c", 2)]);
}

#[test]
fn a_tip_with_a_million_normals_is_not_quadratic() {
    let mut text = "v 0 0 1\nv 1 0 0\nv 0 1 0\n".to_owned();
    for i in 0..200_000 {
        write!(text, "vn 0 {i} 1\nf 1//-1 2//1 3//1\n").expect("text");
    }
    let (g, _) = obj(&text);
    assert_eq!((g.triangles.len(), g.positions.len()), (200_000, 200_002));
}

fn noisy_line() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        any::<i8>().prop_map(|x| x.to_string()),
        any::<f32>().prop_map(|x| x.to_string()),
        any::<i64>().prop_map(|x| x.to_string()),
        "[-+.0-9e/]{0,6}",
        (1..9_i32).prop_map(|x| x.to_string()),
    ];
    let corner = prop::collection::vec((-9..9_i32).prop_map(|x| x.to_string()), 1..4).prop_map(|all| all.join("/"));
    let keyword = prop::sample::select(vec![
        "v", "v", "vt", "vn", "f", "f", "f", "o", "g", "s", "l", "mtllib", "usemtl", "#", "\\", "",
    ]);
    let word = prop_oneof![3 => number, 3 => corner, 1 => "\\PC{0,4}"];
    (keyword, prop::collection::vec(word, 0..6)).prop_map(|(keyword, words)| format!("{keyword} {}", words.join(" ")))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn noise_does_no_harm(lines in prop::collection::vec(noisy_line(), 0..30), bytes in any::<Vec<u8>>()) {
        for bytes in [&lines.join("\n").into_bytes(), &bytes] {
            let result = read("obj", bytes, None, &mut alone);
            if let Ok((geometry, _)) = &result {
                prop_assert_eq!(geometry.check(), Ok(()));
                prop_assert!(!geometry.triangles.is_empty());
                prop_assert!(geometry.triangles.len() <= bytes.len());
            }
            let _ = read("obj", bytes, Some("1"), &mut alone);
            // The text stands for its library too.
            let library = [b"newmtl 1\nmap_Kd -s 2 2 a.png\n", &bytes[..]].concat();
            let mut beside = |_: &str| -> Result<Box<dyn AsRef<[u8]>>, String> { Ok(Box::new(library.clone())) };
            if let Ok((model, _)) = read_parts("obj", bytes, &mut beside) {
                for (_, mesh) in &model.meshes {
                    prop_assert_eq!(mesh.check(), Ok(()));
                    prop_assert!(mesh.normals.is_some());
                }
            }
            let _ = parts("obj", bytes);
        }
    }

    #[test]
    fn tobj_reads_the_same_triangles(
        positions in prop::collection::vec(any::<[i16; 3]>(), 3..20),
        uvs in prop::collection::vec(any::<[i16; 2]>(), 1..9),
        faces in prop::collection::vec(prop::collection::vec(any::<[prop::sample::Index; 3]>(), 3..7), 1..20),
        with_uvs: bool,
        with_normals: bool,
        backwards: bool,
    ) {
        let normals = [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8]];
        let mut text = String::new();
        for [x, y, z] in &positions {
            writeln!(text, "v {} {} {}", f32::from(*x) / 3.0, f32::from(*y) / 3.0, z).expect("text");
        }
        for [u, v] in &uvs {
            writeln!(text, "vt {} {}", f32::from(*u) / 7.0, f32::from(*v) / 7.0).expect("text");
        }
        for [x, y, z] in normals {
            writeln!(text, "vn {x} {y} {z}").expect("text");
        }
        let counts = [positions.len(), uvs.len(), normals.len()];
        for face in &faces {
            text.push('f');
            for corner in face {
                let [v, t, n] = [0, 1, 2].map(|list| {
                    let at = corner[list].index(counts[list]) as i64;
                    if backwards { at - counts[list] as i64 } else { at + 1 }
                });
                match (with_uvs, with_normals) {
                    (true, true) => write!(text, " {v}/{t}/{n}"),
                    (true, false) => write!(text, " {v}/{t}"),
                    (false, true) => write!(text, " {v}//{n}"),
                    (false, false) => write!(text, " {v}"),
                }
                .expect("text");
            }
            text.push('\n');
        }
        let (ours, _) = obj(&text);
        let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
        let no_materials = |_: &std::path::Path| Ok(Default::default());
        let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).expect("a good file");
        prop_assert_eq!(models.len(), 1);
        let theirs = &models[0].mesh;
        prop_assert_eq!(ours.normals.is_some(), with_normals);
        prop_assert_eq!(ours.uvs.is_some(), with_uvs);
        // How polygons are cut is not what is tested here.
        let mut polygons = finish::Faces::default();
        let mut rest = &theirs.indices[..];
        for at in 0..faces.len() {
            let (face, after) = rest.split_at(theirs.face_arities.get(at).map_or(3, |arity| *arity as usize));
            polygons.push(face, String::new);
            rest = after;
        }
        let position = |at: u32| [0, 1, 2].map(|axis| theirs.positions[3 * at as usize + axis]);
        let cut = polygons.finish(position, &mut Vec::new()).expect("triangles").triangles;
        prop_assert_eq!(cut.len(), ours.triangles.len());
        for (ours_at, theirs_at) in ours.triangles.as_flattened().iter().zip(cut.as_flattened()) {
            let (o, t) = (*ours_at as usize, *theirs_at as usize);
            prop_assert_eq!(&ours.positions[o][..], &theirs.positions[3 * t..][..3]);
            if let Some(uvs) = &ours.uvs {
                prop_assert_eq!(&uvs[o][..], &theirs.texcoords[2 * t..][..2]);
            }
            if let Some(normals) = &ours.normals {
                prop_assert_eq!(&normals[o][..], &theirs.normals[3 * t..][..3]);
            }
        }
        let used: std::collections::BTreeSet<&u32> = cut.as_flattened().iter().collect();
        prop_assert_eq!(ours.positions.len(), used.len());
    }
}
