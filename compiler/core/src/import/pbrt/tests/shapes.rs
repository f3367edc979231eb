//! Meshes and bodies with a formula.

use super::*;
use crate::mesh::{area, signed_volume};

fn mesh(read: &Read) -> &crate::ir::Mesh {
    &read.scene().meshes[read.shape(0).mesh]
}

fn only(shape: &str) -> Read {
    read(&format!("{HEAD}{shape}"))
}

#[test]
fn inline_meshes_keep_their_arrays() {
    let read = only(
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 2 0 0 2 2 0 0 2 0] \"point2 uv\" [0 0 1 0 1 1 0 1] \"normal N\" [0 0 2 0 0 2 0 0 2 0 0 2] \"integer indices\" [0 1 2 0 2 3]",
    );
    assert_eq!(read.said(), []);
    let mesh = mesh(&read);
    assert_eq!((mesh.positions.len(), mesh.triangles.as_slice()), (4, &[[0, 1, 2], [0, 2, 3]][..]));
    assert_eq!(mesh.normals.as_ref().map(|normals| normals[0]), Some([0.0, 0.0, 1.0]));
    assert_eq!(mesh.uvs.as_ref().map(|uvs| uvs[2]), Some([1.0, 1.0]));
    let read = only(
        "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"float st\" [0 0 1 0] \"normal N\" [0 0 1] \"integer indices\" [0 1 2]",
    );
    assert!(read.says(3, "loss-dropped", "`st` is left out") && read.says(3, "loss-dropped", "`N` is left out"));
    assert_eq!(only("Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0]").scene().shapes.len(), 1);
}

#[test]
fn alpha_is_a_finding_unless_it_is_1() {
    let text = |alpha: &str| {
        format!("Texture \"one\" \"float\" \"constant\" Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] {alpha}")
    };
    assert_eq!(only(&text("\"float alpha\" 1")).said(), []);
    assert_eq!(only(&text("\"texture alpha\" \"one\"")).said(), []);
    assert!(only(&text("\"float alpha\" 0")).says(3, "loss-dropped", "no holes"));
}

#[test]
fn files_of_meshes() {
    let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let text = |before: &str| format!("{HEAD}{before} Shape \"plymesh\" \"string filename\" \"m/t.ply\"");
    let read = read_with(&text(""), &[("a/m/t.ply", ply)]);
    assert_eq!(read.said(), []);
    assert_eq!((read.shape(0).name.as_str(), read.front(0)), ("t", [0.0, 0.0, 1.0]));
    let read = read_with(&text("ReverseOrientation"), &[("a/m/t.ply", ply)]);
    assert_eq!(read.front(0), [0.0, 0.0, -1.0]);
}

#[test]
fn spheres_whole_and_in_part() {
    let volume = |read: &Read| signed_volume(mesh(read).into());
    let read = only("Shape \"sphere\" \"float radius\" 2");
    assert!(read.says(3, "loss-approximated", "a mesh of 96 segments"));
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
    assert!((volume(&read) / ball - 1.0).abs() < 4e-3, "{}", volume(&read));
    // Its normals are those of the sphere, outwards.
    let found = mesh(&read);
    let normals = found.normals.as_ref().expect("normals");
    let along = |(position, normal): (&[f32; 3], &[f32; 3])| {
        let length: f32 = position.iter().zip(normal).map(|(a, b)| a * b).sum();
        (length - 2.0).abs() < 1e-4
    };
    assert!(found.positions.iter().zip(normals.iter()).all(along));
    // u along the turn from +x, v upwards.
    let uvs = found.uvs.as_ref().expect("coordinates");
    let equator = found.positions.iter().zip(uvs.iter()).find(|(position, _)| position[1] > 1.999).expect("+y");
    assert_eq!(equator.1, &[0.25, 0.5]);
    assert!(volume(&only("ReverseOrientation Shape \"sphere\"")) < 0.0);
    // A zone has the area 2 pi r h, a quarter of it a quarter.
    let read = only("Shape \"sphere\" \"float zmin\" 0 \"float zmax\" .5 \"float phimax\" 90");
    assert!((area(mesh(&read).into()) / (std::f64::consts::PI / 4.0) - 1.0).abs() < 3e-3);
}

#[test]
fn disks_cylinders_and_cones() {
    use std::f64::consts::PI;
    let of = |text: &str| {
        let read = only(text);
        assert_eq!(read.said().len(), 1, "{text}: {:?}", read.said());
        (area(mesh(&read).into()), read.front(0))
    };
    let (disk, front) = of("Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1 \"float height\" 3");
    assert!((disk / (3.0 * PI) - 1.0).abs() < 1e-3 && close(&front, &[0.0, 0.0, 1.0]));
    let (half, _) = of("Shape \"disk\" \"float phimax\" 180");
    assert!((half / (PI / 2.0) - 1.0).abs() < 1e-3);
    let (tube, front) = of("Shape \"cylinder\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 2");
    assert!((tube / (12.0 * PI) - 1.0).abs() < 1e-3 && front[0] > 0.9);
    let (cone, front) = of("Shape \"cone\" \"float radius\" 1 \"float height\" 1");
    assert!((cone / (PI * 2.0_f64.sqrt()) - 1.0).abs() < 1e-3 && front[0] > 0.0 && front[2] > 0.0);
    let (bowl, front) = of("Shape \"paraboloid\"");
    // pi / 6 (5^(3/2) - 1)
    assert!((bowl / (PI / 6.0 * (libm::pow(5.0, 1.5) - 1.0)) - 1.0).abs() < 5e-3 && front[2] < 0.0);
}

#[test]
fn a_mirrored_body_says_what_is_not_agreed_upon() {
    let read = only("Scale -1 1 1 Material \"glass\" Shape \"sphere\"");
    assert!(read.says(3, "loss-approximated", "front outside"));
    assert!(!only("Scale -1 1 1 Shape \"sphere\"").says(3, "loss-approximated", "front outside"));
}

#[test]
fn other_meshes() {
    let read =
        only("Shape \"loopsubdiv\" \"integer nlevels\" 3 \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]");
    assert!(read.says(3, "loss-approximated", "control mesh"));
    assert!(mesh(&read).normals.is_some());
    let read = only("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]");
    assert_eq!((read.said(), read.front(0)), (vec![], [0.0, 0.0, 1.0]));
    assert!((area(mesh(&read).into()) - 1.0).abs() < 1e-6);
    assert!(only("Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 1]").says(
        3,
        "loss-approximated",
        "curved"
    ));
    let read = only("Shape \"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 0 0 0 0 0]");
    assert_eq!((read.said(), read.front(0)), (vec![], [0.0, 0.0, 1.0]));
    assert_eq!(mesh(&read).triangles.len(), 4);
    assert!(only("Shape \"heightfield\" \"integer nu\" 3 \"integer nv\" 3 \"float Pz\" [0]").says(
        3,
        "loss-dropped",
        "heights"
    ));
}

#[test]
fn attributes_of_v4_are_defaults() {
    let read = super::read(&format!(
        "{HEAD}AttributeBegin Attribute \"shape\" \"float radius\" 3 Shape \"sphere\" Shape \"sphere\" \"float radius\" 1 AttributeEnd Shape \"sphere\""
    ));
    let size = |at: usize| mesh_size(&read, at);
    assert_eq!([size(0), size(1), size(2)], [3.0, 1.0, 1.0]);
}

fn mesh_size(read: &Read, at: usize) -> f32 {
    let mesh = &read.scene().meshes[read.shape(at).mesh];
    mesh.positions.iter().flatten().fold(0.0, |most: f32, x| most.max(*x))
}

#[test]
fn what_lies_out_of_range_is_left_out() {
    let triangle = "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0]";
    let text = format!(
        "{triangle} AttributeBegin Translate 4e38 0 0 {triangle} AttributeEnd ObjectBegin \"o\" {triangle} ObjectEnd \
         AttributeBegin Scale 1e30 1e30 1e30 Scale 1e30 1e30 1e30 ObjectInstance \"o\" AttributeEnd ObjectInstance \"o\""
    );
    let read = only(&text);
    let out = "it lies out of the range of single precision";
    assert!(read.says(3, "loss-dropped", &format!("a shape is left out: {out}")), "{:?}", read.said());
    assert!(read.says(3, "loss-dropped", &format!("an instance is left out: {out}")), "{:?}", read.said());
    assert_eq!((read.scene().shapes.len(), read.scene().instances.len()), (1, 1));
}
