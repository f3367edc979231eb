//! Reading mesh files of 2 million triangles with normals and texture coordinates, against the libraries that others use.
//!
//! Run on demand: `cargo bench -p ltsc-core --bench mesh`. Times are those of the machine; compare them as ratios.

use std::fmt::Write as _;
use std::hint::black_box;
use std::sync::LazyLock;

use divan::Bencher;
use divan::counter::BytesCount;
use ltsc_core::mesh::file::{alone, read};
use ltsc_core::mesh::{Geometry, faceted, is_closed, largest_normal_deviation, smooth, sphere};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{BeginList, PropertyAccess, PropertyAccessResult};

fn main() {
    divan::main();
}

static MESH: LazyLock<Geometry> = LazyLock::new(|| sphere(1.0, [0.0; 3], 2000, 501).expect("a good sphere"));

const PROPERTIES: [&str; 8] = ["x", "y", "z", "nx", "ny", "nz", "u", "v"];

fn vertices() -> impl Iterator<Item = [f32; 8]> {
    let mesh = &*MESH;
    let normals = mesh.normals.iter().flatten();
    let uvs = mesh.uvs.iter().flatten();
    let all = mesh.positions.iter().zip(normals).zip(uvs);
    all.map(|(([x, y, z], [nx, ny, nz]), [u, v])| [*x, *y, *z, *nx, *ny, *nz, *u, *v])
}

fn ply_header(format: &str) -> Vec<u8> {
    let mut text = format!("ply\nformat {format} 1.0\nelement vertex {}\n", MESH.positions.len());
    for name in PROPERTIES {
        writeln!(text, "property float {name}").expect("text");
    }
    let faces = MESH.triangles.len();
    write!(text, "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n").expect("text");
    text.into_bytes()
}

static PLY_BINARY: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut out = ply_header("binary_little_endian");
    for x in vertices().flatten() {
        out.extend(x.to_le_bytes());
    }
    for triangle in &MESH.triangles {
        out.push(3);
        out.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    out
});

static PLY_ASCII: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut text = String::from_utf8(ply_header("ascii")).expect("text");
    for [x, y, z, nx, ny, nz, u, v] in vertices() {
        writeln!(text, "{x} {y} {z} {nx} {ny} {nz} {u} {v}").expect("text");
    }
    for [a, b, c] in &MESH.triangles {
        writeln!(text, "3 {a} {b} {c}").expect("text");
    }
    text.into_bytes()
});

static OBJ: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut text = String::new();
    for [x, y, z, nx, ny, nz, u, v] in vertices() {
        write!(text, "v {x} {y} {z}\nvt {u} {v}\nvn {nx} {ny} {nz}\n").expect("text");
    }
    for triangle in &MESH.triangles {
        let [a, b, c] = triangle.map(|index| index + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("text");
    }
    text.into_bytes()
});

static STL: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut out = vec![b' '; 80];
    out.extend((MESH.triangles.len() as u32).to_le_bytes());
    for triangle in &MESH.triangles {
        out.extend([0; 12]);
        let corners = triangle.map(|index| MESH.positions[index as usize]);
        out.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
});

static GLB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let (vertices, faces) = (MESH.positions.len(), MESH.triangles.len());
    let mut bytes: Vec<u8> = Vec::new();
    for numbers in [MESH.positions.as_flattened(), MESH.normals.as_deref().unwrap_or_default().as_flattened()] {
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes.extend(MESH.uvs.as_deref().unwrap_or_default().as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend(MESH.triangles.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
    let view = |from: usize, size: usize| format!(r#"{{"buffer":0,"byteOffset":{from},"byteLength":{size}}}"#);
    let accessor = |view: u32, kind: u32, count: usize, shape: &str| {
        format!(
            r#"{{"bufferView":{view},"componentType":{kind},"count":{count},"type":"{shape}","min":[-1,-1,-1],"max":[1,1,1]}}"#
        )
    };
    let mut text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}}}],"bufferViews":[{},{},{},{}],"accessors":[{},{},{},{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3}}]}}],"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]}}"#,
        bytes.len(),
        view(0, vertices * 12),
        view(vertices * 12, vertices * 12),
        view(vertices * 24, vertices * 8),
        view(vertices * 32, faces * 12),
        accessor(0, 5126, vertices, "VEC3"),
        accessor(1, 5126, vertices, "VEC3"),
        accessor(2, 5126, vertices, "VEC2"),
        accessor(3, 5125, faces * 3, "SCALAR"),
    )
    .into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + text.len() as u32 + bytes.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bytes)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
});

fn ltsc(bencher: Bencher<'_, '_>, extension: &str, bytes: &'static [u8]) {
    let (geometry, _) = read(extension, bytes, None, &mut alone).expect("a good file");
    assert_eq!(geometry.triangles.len(), MESH.triangles.len());
    bencher.counter(BytesCount::of_slice(bytes)).bench(|| read(extension, black_box(bytes), None, &mut alone));
}

#[divan::bench(sample_count = 10)]
fn ply_binary_ltsc(bencher: Bencher<'_, '_>) {
    ltsc(bencher, "ply", &PLY_BINARY);
}

#[divan::bench(sample_count = 5)]
fn ply_ascii_ltsc(bencher: Bencher<'_, '_>) {
    ltsc(bencher, "ply", &PLY_ASCII);
}

#[divan::bench(sample_count = 5)]
fn obj_ltsc(bencher: Bencher<'_, '_>) {
    ltsc(bencher, "obj", &OBJ);
}

#[divan::bench(sample_count = 10)]
fn stl_ltsc(bencher: Bencher<'_, '_>) {
    ltsc(bencher, "stl", &STL);
}

#[divan::bench(sample_count = 10)]
fn stl_copy(bencher: Bencher<'_, '_>) {
    bencher.counter(BytesCount::of_slice(&*STL)).bench(|| black_box(&*STL).clone());
}

#[divan::bench(sample_count = 10)]
fn glb_ltsc(bencher: Bencher<'_, '_>) {
    ltsc(bencher, "glb", &GLB);
}

#[divan::bench(sample_count = 10)]
fn glb_copy(bencher: Bencher<'_, '_>) {
    bencher.counter(BytesCount::of_slice(&*GLB)).bench(|| black_box(&*GLB).clone());
}

/// A vertex as ply-rs-bw fills it.
struct Vertex([f32; 8]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 8])
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        match PROPERTIES.iter().position(|property| *property == name) {
            Some(at) => {
                self.0[at] = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::Ignored,
        }
    }
}

/// A face as ply-rs-bw fills it.
struct Face(Vec<i32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn begin_list_int(&mut self, _name: &str, _length: usize) -> BeginList<'_, i32> {
        BeginList::Fill(&mut self.0)
    }
}

fn ply_rs(bencher: Bencher<'_, '_>, bytes: &'static [u8]) {
    bencher.counter(BytesCount::of_slice(bytes)).bench(|| {
        let mut reader = ply_rs_bw::parser::Reader::new(black_box(bytes));
        let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
        let header = vertices.read_header(&mut reader).expect("a good file");
        let vertex = vertices.read_payload_for_element(&mut reader, &header.elements["vertex"], &header);
        let face = faces.read_payload_for_element(&mut reader, &header.elements["face"], &header);
        (vertex.expect("a good file"), face.expect("a good file"))
    });
}

#[divan::bench(sample_count = 5)]
fn ply_binary_ply_rs_bw(bencher: Bencher<'_, '_>) {
    ply_rs(bencher, &PLY_BINARY);
}

#[divan::bench(sample_count = 3)]
fn ply_ascii_ply_rs_bw(bencher: Bencher<'_, '_>) {
    ply_rs(bencher, &PLY_ASCII);
}

#[divan::bench(sample_count = 3)]
fn obj_tobj(bencher: Bencher<'_, '_>) {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..tobj::LoadOptions::default() };
    bencher.counter(BytesCount::of_slice(&*OBJ)).bench(|| {
        tobj::load_obj_buf(&mut black_box(&OBJ[..]), &options, |_| Ok(Default::default())).expect("a good file")
    });
}

/// The bytes copied: a bound on what reading can reach.
#[divan::bench(sample_count = 10)]
fn ply_binary_copy(bencher: Bencher<'_, '_>) {
    bencher.counter(BytesCount::of_slice(&*PLY_BINARY)).bench(|| black_box(&*PLY_BINARY).clone());
}

#[divan::bench(sample_count = 5)]
fn stage_faceted(bencher: Bencher<'_, '_>) {
    bencher.with_inputs(|| MESH.clone()).bench_values(faceted);
}

#[divan::bench(sample_count = 3)]
fn stage_smooth(bencher: Bencher<'_, '_>) {
    bencher.with_inputs(|| MESH.clone()).bench_values(|mesh| smooth(mesh, 30.0));
}

#[divan::bench(sample_count = 3)]
fn measure_closed(bencher: Bencher<'_, '_>) {
    bencher.bench(|| is_closed((&*MESH).into()));
}

#[divan::bench(sample_count = 3)]
fn measure_normal_deviation(bencher: Bencher<'_, '_>) {
    bencher.bench(|| largest_normal_deviation((&*MESH).into()));
}
