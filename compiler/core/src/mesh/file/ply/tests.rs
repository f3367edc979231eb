//! PLY: round trips in all encodings and types, the paths against each other and against ply-rs-bw, faults, noise.

use std::fmt::Write as _;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::DefaultElement;
use proptest::prelude::*;

use super::header::Scalar;
use super::*;
use crate::diag::Severity;

/// A value with its type, for writing.
#[derive(Clone, Debug)]
enum Field {
    One(Scalar, f64),
    List(Scalar, Scalar, Vec<f64>),
}

/// An element: its name, the names of its properties, its items.
#[derive(Clone, Debug)]
struct Table {
    name: &'static str,
    properties: Vec<&'static str>,
    /// One item that shows the types, for elements without items.
    shape: Vec<Field>,
    items: Vec<Vec<Field>>,
}

fn type_name(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::I8 => "char",
        Scalar::U8 => "uint8",
        Scalar::I16 => "short",
        Scalar::U16 => "ushort",
        Scalar::I32 => "int32",
        Scalar::U32 => "uint",
        Scalar::F32 => "float",
        Scalar::F64 => "double",
    }
}

fn put(out: &mut Vec<u8>, encoding: Encoding, scalar: Scalar, value: f64) {
    macro_rules! number {
        ($type:ty) => {{
            let value = value as $type;
            match encoding {
                Encoding::Ascii => out.extend(format!("{value} ").bytes()),
                Encoding::Little => out.extend(value.to_le_bytes()),
                Encoding::Big => out.extend(value.to_be_bytes()),
            }
        }};
    }
    match scalar {
        Scalar::I8 => number!(i8),
        Scalar::U8 => number!(u8),
        Scalar::I16 => number!(i16),
        Scalar::U16 => number!(u16),
        Scalar::I32 => number!(i32),
        Scalar::U32 => number!(u32),
        Scalar::F32 => number!(f32),
        Scalar::F64 => number!(f64),
    }
}

fn write(encoding: Encoding, tables: &[Table], newline: &str) -> Vec<u8> {
    let name = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut header = format!("ply\nformat {name} 1.0\ncomment made by a test\n");
    for table in tables {
        writeln!(header, "element {} {}", table.name, table.items.len()).expect("text");
        for (name, field) in table.properties.iter().zip(&table.shape) {
            match field {
                Field::One(scalar, _) => writeln!(header, "property {} {name}", type_name(*scalar)),
                Field::List(count, item, _) => {
                    writeln!(header, "property list {} {} {name}", type_name(*count), type_name(*item))
                }
            }
            .expect("text");
        }
    }
    header.push_str("end_header\n");
    let mut out = header.replace('\n', newline).into_bytes();
    for item in tables.iter().flat_map(|table| &table.items) {
        for field in item {
            match field {
                Field::One(scalar, value) => put(&mut out, encoding, *scalar, *value),
                Field::List(count, scalar, values) => {
                    put(&mut out, encoding, *count, values.len() as f64);
                    for value in values {
                        put(&mut out, encoding, *scalar, *value);
                    }
                }
            }
        }
        if encoding == Encoding::Ascii {
            out.extend(newline.bytes());
        }
    }
    out
}

/// The triangles of faces, which is not what is tested here.
fn cut(positions: &[[f32; 3]], faces: impl Iterator<Item = Vec<u32>>) -> Vec<[u32; 3]> {
    let mut all = Faces::default();
    faces.for_each(|face| all.push(&face, String::new));
    all.finish(|vertex| positions[vertex as usize], &mut Vec::new()).expect("triangles").triangles
}

/// A mesh and the ways to write it.
#[derive(Clone, Debug)]
struct Sample {
    positions: Vec<[f32; 3]>,
    normals: bool,
    uvs: Option<[&'static str; 2]>,
    faces: Vec<Vec<u32>>,
    float: Scalar,
    length: Scalar,
    index: Scalar,
    extra: bool,
    faces_first: bool,
}

impl Sample {
    fn normal(at: usize) -> [f32; 3] {
        [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8]][at % 3]
    }

    fn uv(at: usize) -> [f32; 2] {
        [at as f32 / 7.0, 1.0 - at as f32 / 5.0]
    }

    fn tables(&self) -> Vec<Table> {
        let vertex = |at: usize, position: [f32; 3]| {
            let mut item = Vec::new();
            let mut floats = |values: &[f32]| item.extend(values.iter().map(|x| Field::One(self.float, f64::from(*x))));
            floats(&position);
            if self.normals {
                floats(&Self::normal(at));
            }
            if self.uvs.is_some() {
                floats(&Self::uv(at));
            }
            if self.extra {
                item.insert(1, Field::One(Scalar::U8, at as f64));
                item.push(Field::One(Scalar::F64, -1.5));
            }
            item
        };
        let face = |corners: &[u32]| {
            let corners = corners.iter().map(|corner| f64::from(*corner)).collect();
            let mut item = vec![Field::List(self.length, self.index, corners)];
            if self.extra {
                item.insert(0, Field::One(Scalar::I16, -7.0));
                item.push(Field::One(Scalar::U8, 200.0));
            }
            item
        };
        let mut names = vec!["x", "y", "z"];
        if self.normals {
            names.extend(["nx", "ny", "nz"]);
        }
        names.extend(self.uvs.into_iter().flatten());
        if self.extra {
            names.insert(1, "red");
            names.push("quality");
        }
        let items = self.positions.iter().enumerate().map(|(at, position)| vertex(at, *position)).collect();
        let vertices = Table { name: "vertex", properties: names, shape: vertex(0, [0.0; 3]), items };
        let names = if self.extra { vec!["flags", "vertex_indices", "group"] } else { vec!["vertex_index"] };
        let items = self.faces.iter().map(|corners| face(corners)).collect();
        let faces = Table { name: "face", properties: names, shape: face(&[]), items };
        let mut tables = if self.faces_first { vec![faces, vertices] } else { vec![vertices, faces] };
        if self.extra {
            let edge =
                |n: usize| vec![Field::List(Scalar::U8, Scalar::F64, vec![0.5; n]), Field::One(Scalar::I8, -1.0)];
            let items = (0..3).map(edge).collect();
            tables.insert(1, Table { name: "edge", properties: vec!["w", "k"], shape: edge(0), items });
        }
        tables
    }

    fn geometry(&self) -> Geometry {
        let count = self.positions.len();
        Geometry {
            positions: self.positions.clone(),
            normals: self.normals.then(|| (0..count).map(Self::normal).collect()),
            uvs: self.uvs.map(|_| (0..count).map(Self::uv).collect()),
            triangles: cut(&self.positions, self.faces.iter().cloned()),
        }
    }
}

fn sample() -> impl Strategy<Value = Sample> {
    let coordinate = prop_oneof![(-1e6_f32..1e6), Just(0.0), any::<f32>().prop_filter("finite", |x| x.is_finite())];
    let positions = prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 3..20);
    positions.prop_flat_map(|positions| {
        let corner = 0..positions.len() as u32;
        let triangle = prop::collection::vec(corner.clone(), 3..4);
        let polygon = prop::collection::vec(corner, 0..6);
        let first = triangle.clone();
        let rest = prop_oneof![prop::collection::vec(triangle, 0..20), prop::collection::vec(polygon, 0..20)];
        let uvs =
            prop::sample::select(vec![None, Some(["s", "t"]), Some(["u", "v"]), Some(["texture_u", "texture_v"])]);
        let float = prop::sample::select(vec![Scalar::F32, Scalar::F32, Scalar::F64]);
        let length =
            prop::sample::select(vec![Scalar::U8, Scalar::U8, Scalar::I8, Scalar::U16, Scalar::I32, Scalar::U32]);
        let index = prop::sample::select(vec![
            Scalar::I32,
            Scalar::I32,
            Scalar::U32,
            Scalar::U16,
            Scalar::I16,
            Scalar::I8,
            Scalar::U8,
        ]);
        (Just(positions), any::<[bool; 3]>(), uvs, (first, rest), float, length, index).prop_map(
            |(positions, [normals, extra, faces_first], uvs, (first, mut faces), float, length, index)| {
                faces.insert(0, first);
                Sample { positions, normals, uvs, faces, float, length, index, extra, faces_first }
            },
        )
    })
}

const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::Little, Encoding::Big];

/// What may be said of any result: it is consistent, and no larger than the file allows.
fn sane(bytes: &[u8], result: &Result<(Geometry, Vec<Note>), FileError>) {
    match result {
        Ok((geometry, _)) => {
            assert_eq!(geometry.check(), Ok(()));
            assert!(!geometry.triangles.is_empty());
            assert!(geometry.positions.len() <= bytes.len() && geometry.triangles.len() <= bytes.len());
        }
        Err(error) => assert!(!error.message.is_empty() && error.message.len() < 1000, "{error:?}"),
    }
}

fn damage(bytes: &mut Vec<u8>, changes: &[(prop::sample::Index, u8, u8)]) {
    for (at, what, byte) in changes {
        if bytes.is_empty() {
            return;
        }
        let at = at.index(bytes.len());
        match what % 8 {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, *byte),
            2 => drop(bytes.remove(at)),
            // Digits and signs hit the header and ascii numbers where it hurts.
            3 => bytes[at] = b"0123456789-.ne \n"[usize::from(byte % 16)],
            4 => bytes.insert(at, b"0123456789-.ne \n"[usize::from(byte % 16)]),
            _ => bytes[at] = *byte,
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn round_trips_in_all_encodings(sample in sample(), newline in prop::sample::select(vec!["\n", "\r\n"])) {
        let expected = sample.geometry();
        for encoding in ENCODINGS {
            let bytes = write(encoding, &sample.tables(), newline);
            for fast in [true, false] {
                let (geometry, _) = read_by(&bytes, fast).expect("a good file");
                prop_assert_eq!(&geometry, &expected, "{:?} {}", encoding, fast);
            }
        }
    }

    #[test]
    fn ply_rs_reads_the_same_numbers(sample in sample()) {
        for encoding in ENCODINGS {
            let bytes = write(encoding, &sample.tables(), "\n");
            let (geometry, _) = read(&bytes).expect("a good file");
            // The library takes no number in the form `1e30`, which the writer above does not use, so it reads all.
            let theirs = Parser::<DefaultElement>::new().read_ply(&mut &bytes[..]).expect("a good file");
            for (vertex, position) in theirs.payload["vertex"].iter().zip(&geometry.positions) {
                let [x, y, z] = ["x", "y", "z"].map(|name| vertex[name].to_f32_lossy().expect("a number"));
                prop_assert_eq!([x, y, z].map(f32::to_bits), position.map(f32::to_bits));
            }
            let faces = theirs.payload["face"].iter().map(|face| {
                let name = if sample.extra { "vertex_indices" } else { "vertex_index" };
                face[name].to_u32_list().expect("integers")
            });
            prop_assert_eq!(cut(&geometry.positions, faces), geometry.triangles);
        }
    }

    #[test]
    fn damaged_files_do_no_harm(
        sample in sample(),
        encoding in prop::sample::select(ENCODINGS.to_vec()),
        changes in prop::collection::vec(any::<(prop::sample::Index, u8, u8)>(), 1..6),
    ) {
        let mut bytes = write(encoding, &sample.tables(), "\n");
        damage(&mut bytes, &changes);
        let fast = read_by(&bytes, true);
        sane(&bytes, &fast);
        let general = read_by(&bytes, false);
        prop_assert_eq!(fast.is_ok(), general.is_ok(), "{:?} {:?}", &fast, &general);
        if let (Ok(fast), Ok(general)) = (fast, general) {
            prop_assert_eq!(fast.0, general.0);
        }
    }

    #[test]
    fn noise_does_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        sane(&bytes, &read(&bytes));
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let mut whole = format!(
                "ply\nformat {encoding} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 2\nproperty list uchar int vertex_indices\nend_header\n"
            ).into_bytes();
            whole.extend(&bytes);
            sane(&whole, &read(&whole));
        }
    }
}

const TRIANGLE: &str = "ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
";

fn place_and_message(text: &str) -> (String, String) {
    let error = read(text.as_bytes()).map(|_| ()).expect_err("a bad file");
    (error.place, error.message)
}

#[track_caller]
fn assert_fault(from: &str, to: &str, place: &str, message: &str) {
    assert!(TRIANGLE.contains(from), "{from} is not in the sample");
    let found = place_and_message(&TRIANGLE.replacen(from, to, 1));
    assert!(found.0 == place && found.1.contains(message), "{found:?}");
}

#[test]
fn the_sample_is_good() {
    let (geometry, notes) = read(TRIANGLE.as_bytes()).expect("a good file");
    assert_eq!((geometry.triangles, notes), (vec![[0, 1, 2]], vec![]));
    // The last line need not end, a carriage return alone ends lines on old machines, numbers have several forms.
    assert!(read(TRIANGLE.trim_end().as_bytes()).is_ok());
    assert!(read(TRIANGLE.replace('\n', "\r").as_bytes()).is_ok());
    assert!(read(TRIANGLE.replace("1 0 0", " 1. +.5\t-1E-2 ").as_bytes()).is_ok());
    assert!(read(TRIANGLE.replace("0 0 0\n", "\n0 0 0\n\n").as_bytes()).is_ok());
}

#[test]
fn faults_of_the_header_have_their_line() {
    assert_eq!(place_and_message(""), (String::new(), "the file is empty".to_owned()));
    assert_fault("ply", "obj", "line 1", "begins with the line `ply`");
    assert_fault("ascii", "asci", "line 2", "unknown format `asci`");
    assert_fault("1.0", "2.0", "line 2", "PLY version `2.0`");
    assert_fault("format ascii 1.0", "comment", "line 9", "no `format` line");
    assert_fault("format ascii 1.0", "format ascii 1.0\nformat binary_big_endian 1.0", "line 3", "two different");
    assert_fault("vertex 3", "vertex -3", "line 3", "count `-3`");
    assert_fault("vertex 3", "vertex 99999999999999999999", "line 3", "is not a whole number");
    assert_fault("element vertex 3", "comment", "line 4", "property `x` stands before the first element");
    assert_fault("float y", "flaot y", "line 5", "unknown type `flaot`");
    assert_fault("float y", "float x", "line 5", "property `x` of element `vertex` is declared twice");
    assert_fault("float y", "float w", "line 3", "no property `y`");
    assert_fault(
        "property float y",
        "property list uchar float y",
        "line 3",
        "property `y` of element `vertex` is a list",
    );
    assert_fault("face 1", "vertex 1", "line 7", "element `vertex` is declared twice");
    assert_fault("list uchar int", "list float int", "line 8", "length of list `vertex_indices` has the type `float`");
    assert_fault("list uchar int", "list uchar float", "line 7", "no integers");
    assert_fault("property list uchar int", "property int", "line 7", "no list");
    assert_fault("vertex_indices", "a\nproperty list uchar int b", "line 7", "no property `vertex_indices`");
    assert_fault("property list uchar int vertex_indices", "comment", "line 7", "no property `vertex_indices`");
    assert_fault("end_header", "end", "line 9", "`end` is no line of a PLY header");
    assert_fault("element face 1", "element face 1\n\u{1}\u{2}", "line 8", "\\u{1}\\u{2}");
    let header = TRIANGLE.split_inclusive("end_header").next().expect("a header").replace("end_header", "");
    assert_eq!(place_and_message(&header), ("line 9".to_owned(), "the header ends without `end_header`".to_owned()));
    let help = |text: &str| read(text.as_bytes()).map(|_| ()).expect_err("a bad file").help.unwrap_or_default();
    assert_eq!(help(&TRIANGLE.replace("element face", "element faces")), "is `faces` meant?");
    assert!(help(&TRIANGLE.replace("element face", "element edge")).contains("holds points"));
    let binary = [b"ply\nformat ascii 1.0\n\xff\xfe\n", TRIANGLE.as_bytes()].concat();
    assert_eq!(read(&binary).map(|_| ()).expect_err("no text").place, "line 3");
    let comment = [b"ply\ncomment caf\xe9\n", &TRIANGLE.as_bytes()[4..]].concat();
    assert!(read(&comment).is_ok());
}

#[test]
fn faults_of_ascii_items_have_their_line() {
    assert_fault("1 0 0", "1 0", "line 11", "ends before property `z`");
    assert_fault("1 0 0", "1 0 0 0", "line 11", "more numbers than element `vertex`");
    assert_fault("1 0 0", "1 0 zero", "line 11", "`zero` is no number");
    assert_fault("1 0 0", "1 nan 0", "line 11", "position of vertex 1 is not finite");
    assert_fault("1 0 0", "1 0 1e39", "line 11", "position of vertex 1 is not finite");
    assert_fault("3 0 1 2", "3 0 1 3", "line 13", "vertex 3, but the file has 3 vertices");
    assert_fault("3 0 1 2", "3 0 1 -1", "line 13", "vertex -1");
    assert_fault("3 0 1 2", "-3 0 1 2", "line 13", "length -3");
    assert_fault("3 0 1 2", "4 0 1 2", "line 13", "the line is shorter");
    assert_fault("3 0 1 2", "3 0 1", "line 13", "the line is shorter");
    assert_fault("3 0 1 2", "2 0 1", "", "the file has no triangles");
    assert_fault("3 0 1 2\n", "", "line 7", "element `face` declares 1 items");
    assert_fault("vertex 3", "vertex 1000000000", "line 3", "declares 1000000000 items");
    assert_fault("vertex 3", "vertex 18446744073709551615", "line 3", "more than 32-bit");
    assert_fault("face 1", "face 18446744073709551615", "line 7", "declares 18446744073709551615 items");
    assert_fault("face 1", "face 0", "", "the file has no triangles");
    assert_fault("face 1", "face 2", "line 13", "ends after 1 of 2 items");
    let notes = read(TRIANGLE.replace("3 0 1 2", "4 0 1 2 0\n3 2 1 0").replace("face 1", "face 2").as_bytes());
    assert_eq!(notes.expect("a good file").1[0].message, "1 face with more than 3 corners cut into triangles");
    let more = read(format!("{TRIANGLE}\n9 9\n").as_bytes()).expect("a good file").1;
    assert_eq!((more[0].severity, more[0].place.as_str()), (Severity::Warn, "line 15"));
}

fn binary(extra: &[&str]) -> Vec<u8> {
    let uvs = None;
    let sample = Sample {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: extra.contains(&"normals"),
        uvs,
        faces: vec![vec![0, 1, 2], if extra.contains(&"quad") { vec![0, 1, 2, 0] } else { vec![0, 2, 1] }],
        float: Scalar::F32,
        length: Scalar::U8,
        index: Scalar::I32,
        extra: false,
        faces_first: false,
    };
    write(Encoding::Little, &sample.tables(), "\n")
}

#[test]
fn every_cut_of_a_binary_file_is_an_error() {
    for extra in [&[][..], &["quad"], &["normals"]] {
        let bytes = binary(extra);
        for length in 0..bytes.len() {
            for fast in [true, false] {
                let error = read_by(&bytes[..length], fast).map(|_| ()).expect_err("it is cut");
                assert!(
                    error.place.starts_with("line ") || error.place.starts_with("byte ") || length == 0,
                    "{error:?}"
                );
            }
        }
    }
}

#[test]
fn faults_of_binary_items_have_their_byte() {
    let bytes = binary(&["normals"]);
    let payload = Header::parse(&bytes).expect("a good header").payload;
    let fault = |at: usize, value: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        let [fast, general] = [true, false].map(|fast| read_by(&bytes, fast).map(|_| ()).expect_err("a bad file"));
        assert_eq!(fast.place, general.place);
        assert_eq!(fast.message, general.message);
        (fast.place, fast.message)
    };
    let (vertex, face) = (payload + 24, payload + 72 + 13);
    let (place, message) = fault(vertex + 4, &f32::NAN.to_le_bytes());
    assert_eq!((place, message.contains("position of vertex 1")), (format!("byte {vertex}"), true));
    for (index, shown) in [(3_i32, "vertex 3,"), (-1, "vertex -1,"), (i32::MIN, "vertex -2147483648,")] {
        let (place, message) = fault(face + 5, &index.to_le_bytes());
        assert_eq!((place, message.contains(shown)), (format!("byte {face}"), true), "{message}");
    }
    let mut longer = bytes.clone();
    longer.extend([0; 5]);
    let notes = read(&longer).expect("a good file").1;
    assert_eq!(notes[0].message, "5 bytes after the last element are not read");
}

#[test]
fn normals_are_brought_to_unit_length_with_a_note() {
    let normals = |text: &str| {
        let text = TRIANGLE
            .replace("property float z", "property float z\nproperty float nx\nproperty float ny\nproperty float nz")
            .replace("vertex 3", "vertex 4")
            .replace("0 0 0\n1 0 0\n0 1 0\n", text);
        read(text.as_bytes())
    };
    let (geometry, notes) =
        normals("0 0 0 0 0 2\n1 0 0 0 0 1.0005\n0 1 0 0 0 -1e-30\n9 9 9 0 0 0\n").expect("a good file");
    let expected = vec![[0.0, 0.0, 1.0], [0.0, 0.0, 1.0005], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
    assert_eq!(geometry.normals, Some(expected));
    let said: Vec<_> = notes.iter().map(|note| (note.severity, note.message.as_str(), note.place.as_str())).collect();
    let unused = "1 normal that cannot be used set to +z, at vertices without faces";
    assert_eq!(
        said,
        [(Severity::Warn, "2 normals brought to unit length", "line 13"), (Severity::Info, unused, "line 16"),]
    );
}

#[test]
fn normals_that_cannot_be_used_come_from_the_faces() {
    let normals = |first: &str, rest: &str| {
        let text = TRIANGLE
            .replace("property float z", "property float z\nproperty float nx\nproperty float ny\nproperty float nz")
            .replace("0 0 0\n1 0 0\n0 1 0\n", &format!("0 0 0 {first}\n1 0 0 {rest}\n0 1 0 {rest}\n"));
        let (geometry, notes) = read(text.as_bytes()).expect("a good file");
        let said: Vec<String> = notes.into_iter().map(|note| format!("{}: {}", note.place, note.message)).collect();
        (geometry.normals, said)
    };
    let computed = "line 13: 1 normal that cannot be used, zero or not finite, computed from the faces around it";
    for bad in ["0 0 0", "nan nan nan", "nan 1 0", "0 inf 0"] {
        let (found, said) = normals(bad, "0.6 0 0.8");
        assert_eq!(found, Some(vec![[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.6, 0.0, 0.8]]), "{bad}");
        assert_eq!(said, [computed], "{bad}");
    }
    let none = "line 13: 3 normals that are zero or not finite left out, and no others are there";
    assert_eq!(normals("0 0 0", "nan 0 0"), (None, vec![none.to_owned()]));
}

#[test]
fn strips_are_triangles_of_alternate_winding() {
    let flat = |list: &str| {
        TRIANGLE
            .replace("vertex 3", "vertex 5")
            .replace("0 1 0\n", "0 1 0\n1 1 0\n0 2 0\n")
            .replace("element face", "element tristrips")
            .replace("uchar int", "int int")
            .replace("3 0 1 2", list)
    };
    // After a restart the first triangle is wound as it stands; two of that strip have a corner twice.
    for (list, expected) in
        [("5 0 1 2 3 4", &[[0, 1, 2], [1, 3, 2], [2, 3, 4]][..]), ("9 0 1 2 -1 2 1 1 3 4", &[[0, 1, 2], [1, 3, 4]])]
    {
        let (geometry, notes) = read(flat(list).as_bytes()).expect("a good file");
        assert_eq!((geometry.triangles.as_slice(), notes), (expected, vec![]), "{list}");
    }
    assert_eq!(place_and_message(&flat("4 0 1 2 5")).0, "line 15");
    // Binary, before faces and with a mark of 32 bits without sign.
    let table = |name: &'static str, scalar: Scalar, items: &[&[f64]]| {
        let items: Vec<Vec<Field>> =
            items.iter().map(|item| vec![Field::List(Scalar::U8, scalar, item.to_vec())]).collect();
        Table { name, properties: vec!["vertex_indices"], shape: items[0].clone(), items }
    };
    let corner =
        |x: f64, y: f64| vec![Field::One(Scalar::F32, x), Field::One(Scalar::F32, y), Field::One(Scalar::F32, 0.0)];
    let items: Vec<Vec<Field>> = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| corner(x.into(), y.into())).into();
    let vertices = Table { name: "vertex", properties: vec!["x", "y", "z"], shape: items[0].clone(), items };
    let strips = table("tristrips", Scalar::U32, &[&[0.0, 1.0, 2.0, f64::from(u32::MAX), 1.0, 3.0, 2.0]]);
    let faces = table("face", Scalar::I32, &[&[2.0, 1.0, 0.0]]);
    for encoding in ENCODINGS {
        let bytes = write(encoding, &[vertices.clone(), strips.clone(), faces.clone()], "\n");
        for fast in [true, false] {
            let (geometry, notes) = read_by(&bytes, fast).expect("a good file");
            assert_eq!((geometry.triangles, notes), (vec![[0, 1, 2], [1, 3, 2], [2, 1, 0]], vec![]), "{encoding:?}");
        }
    }
}

#[test]
fn unusual_headers_are_understood() {
    let same = |text: &str| {
        let (geometry, notes) = read(text.as_bytes()).expect("a good file");
        assert_eq!(geometry, read(TRIANGLE.as_bytes()).expect("a good file").0);
        notes.into_iter().map(|note| (note.severity, note.place, note.message)).collect::<Vec<_>>()
    };
    assert_eq!(same(&format!("\u{feff}{TRIANGLE}")), []);
    assert_eq!(same(&format!("\u{feff}{}", TRIANGLE.replace('\n', "\r\n"))), []);
    for name in ["vertex_index", "vertexIndices", "indices"] {
        assert_eq!(same(&TRIANGLE.replace("vertex_indices", name)), []);
    }
    let textured = TRIANGLE
        .replace("element face", "comment TextureFile oak.png\nelement face")
        .replace("vertex_indices", "vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber")
        .replace("3 0 1 2", "3 0 1 2 6 0 0 1 0 0 1 0");
    let said = same(&textured);
    let texture = "the texture `oak.png`, which a comment names, is not read";
    assert_eq!(said[0], (Severity::Info, "line 7".to_owned(), texture.to_owned()));
    let corners = "the properties `texcoord`, `texnumber` of element `face` are not read";
    assert_eq!(said[1], (Severity::Warn, "line 8".to_owned(), corners.to_owned()));
}

#[test]
fn what_is_not_read_is_said() {
    let text = TRIANGLE.replace("property float z", "property float z\nproperty uchar red\nproperty uchar green");
    let text = text.replace("0 0 0\n1 0 0\n0 1 0\n", "0 0 0 1 2\n1 0 0 3 4\n0 1 0 5 6\n");
    let notes = read(text.as_bytes()).expect("a good file").1;
    assert_eq!(notes[0].message, "the properties `red`, `green` of element `vertex` are not read");
    assert_eq!(
        (notes[0].fate.code(), notes[0].severity, notes[0].place.as_str()),
        ("loss-dropped", Severity::Warn, "line 3")
    );
    let text = TRIANGLE.replace("property list", "property uchar flags\nproperty list").replace("\n3 0", "\n9 3 0");
    let notes = read(text.as_bytes()).expect("a good file").1;
    assert_eq!(
        (notes[0].message.as_str(), notes[0].severity),
        ("the property `flags` of element `face` is not read", Severity::Info)
    );
}

#[test]
fn items_without_bytes_cost_nothing() {
    let bytes = binary(&[]);
    let at = bytes.windows(14).position(|window| window == b"element vertex").expect("a vertex element");
    let mut many = bytes[..at].to_vec();
    many.extend(b"element nothing 18446744073709551615\n");
    many.extend(&bytes[at..]);
    assert_eq!(read(&many).expect("a good file").0, read(&bytes).expect("a good file").0);
}
