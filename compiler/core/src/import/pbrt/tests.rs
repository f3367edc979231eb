//! Cases of each construct, worked out by hand.

mod lights;
mod settings;
mod shapes;
mod surfaces;
mod text;

use crate::diag::{Finding, Origin, Severity, Sources};
use crate::files::{MemoryFiles, VPath};
use crate::image::{Pixels, write};
use crate::import::{Options, find, import};
use crate::ir::{Bsdf, Camera, Material, Scene, Shape};

/// What came of a text.
struct Read {
    scene: Option<Scene>,
    findings: Vec<Finding>,
    sources: Sources,
}

impl Read {
    fn scene(&self) -> &Scene {
        self.scene.as_ref().expect("a scene")
    }

    /// Line, code and message of each finding.
    fn said(&self) -> Vec<(usize, &'static str, String)> {
        let place = |finding: &Finding| match &finding.origin {
            Origin::Text(span) => self.sources.position(span.file, span.start).line,
            Origin::File { .. } | Origin::Made => 0,
        };
        self.findings.iter().map(|finding| (place(finding), finding.id, finding.message.clone())).collect()
    }

    /// Whether something with these words was said of a line.
    fn says(&self, line: usize, id: &str, words: &str) -> bool {
        self.said().iter().any(|(at, code, message)| *at == line && *code == id && message.contains(words))
    }

    fn camera(&self) -> &Camera {
        self.scene().cameras.values().next().expect("a camera")
    }

    fn shape(&self, at: usize) -> &Shape {
        self.scene().shapes.values().nth(at).expect("a shape")
    }

    fn material(&self) -> &Material {
        &self.scene().materials[self.shape(0).material]
    }

    fn bsdf(&self) -> &Bsdf {
        &self.material().bsdf
    }

    /// The side from which the corners of a shape's first triangle run counter-clockwise, in the scene as it is written out.
    fn front(&self, at: usize) -> [f64; 3] {
        let (scene, _) = crate::pipeline::prepare(self.scene().clone()).expect("a valid scene");
        let shape = scene.shapes.values().nth(at).expect("a shape");
        let mesh = &scene.meshes[shape.mesh];
        let [a, b, c] = mesh.corners(mesh.triangles[0]).map(|corner| shape.transform.point(corner));
        assert!(shape.transform.determinant() > 0.0);
        if let Some(normals) = &mesh.normals {
            let normal = shape
                .transform
                .cofactors()
                .map(|row| crate::ir::dot(row, normals[mesh.triangles[0][0] as usize].map(f64::from)));
            let along = crate::ir::dot(normal, crate::ir::cross(crate::ir::sub(b, a), crate::ir::sub(c, a)));
            assert!(along > 0.0, "normals and corners agree");
        }
        crate::ir::normalized(crate::ir::cross(crate::ir::sub(b, a), crate::ir::sub(c, a))).expect("an area")
    }
}

fn read(text: &str) -> Read {
    read_with(text, &[])
}

fn read_with(text: &str, others: &[(&str, &[u8])]) -> Read {
    let mut files = MemoryFiles::default();
    files.insert("a/scene.pbrt", text.as_bytes().to_vec());
    for (name, bytes) in others {
        files.insert(*name, bytes.to_vec());
    }
    let path = VPath::resolve("", "a/scene.pbrt").expect("a path");
    let mut sources = Sources::default();
    let importer = find(&path).expect("an importer");
    let imported = import(importer, &files, &mut sources, &path, &Options::default());
    Read { scene: imported.scene, findings: imported.findings, sources }
}

/// A triangle whose front is +z, and a camera that does not mirror anything.
const HEAD: &str = "Scale -1 1 1 LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 45\nWorldBegin\n";
const TRIANGLE: &str = "\nShape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n";

/// A world of this text, which begins in line 3, with a triangle behind it.
fn world(text: &str) -> Read {
    read(&format!("{HEAD}{text}{TRIANGLE}WorldEnd\n"))
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// An image of 2 x 2 pixels: red and green above, blue and white below.
fn image() -> Vec<u8> {
    let values = vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    write::png(&Pixels { width: 2, height: 2, channels: 3, values }, 8).expect("an image")
}

#[test]
fn errors_are_none_where_all_is_said() {
    let read = world("");
    assert_eq!(read.said(), []);
    assert!(read.findings.iter().all(|finding| finding.severity < Severity::Error));
    assert_eq!(read.scene().name, "a");
}
