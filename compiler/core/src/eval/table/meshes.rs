//! Mesh generators and mesh files.

use std::rc::Rc;

use crate::diag::Finding;
use crate::files::{Bytes, VPath};
use crate::ir::Affine;
use crate::mesh::file::{Fate, Note};
use crate::mesh::{self, Extent, Geometry, MeshError, SignedAxis};

use super::super::module::beside_help;
use super::super::value::{MeshValue, Ty, Value};
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Mesh,
        name: "rectangle",
        summary: "A rectangle along the axes.",
        params: &[
            Parameter { name: "x", ty: Ty::Extent, default: None, doc: "a range, or a number for the flat axis" },
            Parameter { name: "y", ty: Ty::Extent, default: None, doc: "a range, or a number for the flat axis" },
            Parameter { name: "z", ty: Ty::Extent, default: None, doc: "a range, or a number for the flat axis" },
            Parameter { name: "normal", ty: Ty::Axis, default: None, doc: "`X`, `-X`, `Y`, `-Y`, `Z` or `-Z`" },
        ],
        positional: 0,
        example: "mesh floor = rectangle(x: -50..50, y: -50..50, z: 0, normal: Z)",
        build: |args, site| {
            let normal = args.vec3("normal").and_then(SignedAxis::from_vector);
            let normal = normal.ok_or_else(|| Problem::new("normal", "the normal is no axis"))?;
            let extents = [extent(args, "x"), extent(args, "y"), extent(args, "z")];
            finish(mesh::rectangle(extents, normal), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "box",
        summary: "A box along the axes, faceted, its normals outward. Give `x`, `y` and `z`, or `size`.",
        params: &[
            Parameter { name: "x", ty: Ty::Range, default: Some(""), doc: "from one side to the other" },
            Parameter { name: "y", ty: Ty::Range, default: Some(""), doc: "from front to back" },
            Parameter { name: "z", ty: Ty::Range, default: Some(""), doc: "from bottom to top" },
            Parameter {
                name: "size",
                ty: Ty::NumberOrVec3,
                default: Some(""),
                doc: "edge length, or one for each axis",
            },
            Parameter {
                name: "center",
                ty: Ty::Vec3,
                default: Some(""),
                doc: "with `size`: the middle, else the origin",
            },
        ],
        positional: 0,
        example: "mesh tall = box(size: (30, 30, 60)) |> translate(z: 30)",
        build: boxed,
    },
    Constructor {
        family: Family::Mesh,
        name: "sphere",
        summary: "A sphere of 2 segments (rings - 1) triangles with smooth normals.",
        params: &[
            Parameter { name: "radius", ty: Ty::Number, default: Some("1"), doc: "> 0" },
            Parameter { name: "center", ty: Ty::NumberOrVec3, default: Some("0"), doc: "the middle" },
            Parameter { name: "segments", ty: Ty::Whole, default: Some("64"), doc: "around the z axis, at least 3" },
            Parameter { name: "rings", ty: Ty::Whole, default: Some("32"), doc: "from pole to pole, at least 2" },
        ],
        positional: 0,
        example: "mesh ball = sphere(segments: 200, rings: 100) |> faceted()",
        build: |args, site| {
            let radius = args.number("radius").unwrap_or(1.0);
            let center = args.vec3("center").unwrap_or_default();
            let segments = args.whole("segments").unwrap_or(64);
            let rings = args.whole("rings").unwrap_or(32);
            let slice = 2 * u64::from(rings).saturating_sub(1);
            site.afford("segments", u128::from(segments) * u128::from(slice))?;
            finish(mesh::sphere(radius, center, segments.into(), rings.into()), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "triangles",
        summary: "A mesh written out in numbers.",
        params: &[
            Parameter { name: "positions", ty: Ty::Points, default: None, doc: "vertices" },
            Parameter {
                name: "faces",
                ty: Ty::Faces,
                default: None,
                doc: "three indices from 0 each, counter-clockwise seen from the front",
            },
            Parameter { name: "normals", ty: Ty::Points, default: Some(""), doc: "unit normals, else by face" },
            Parameter { name: "uvs", ty: Ty::Points2, default: Some(""), doc: "texture coordinates" },
        ],
        positional: 0,
        example: "mesh sail = triangles(positions: [(0, 0, 0), (1, 0, 0), (0, 0, 2)], faces: [(0, 1, 2)])",
        build: triangles,
    },
    Constructor {
        family: Family::Mesh,
        name: "file",
        summary: "A mesh file, PLY, OBJ, STL or glTF, below the project's root; of glTF all nodes as one mesh, z up.",
        params: &[
            Parameter { name: "path", ty: Ty::String, default: None, doc: "from the folder of this file, with `/`" },
            Parameter {
                name: "part",
                ty: Ty::String,
                default: Some(""),
                doc: "an object or group of an OBJ file, a solid of an STL text",
            },
        ],
        positional: 1,
        example: "mesh bunny = file(\"meshes/bunny.ply\")",
        build: file,
    },
];

fn extent(args: &Args, name: &str) -> Extent {
    match args.get(name) {
        Some(Value::Range(lo, hi)) => Extent::Range(*lo, *hi),
        other => Extent::At(if let Some(Value::Number(at)) = other { *at } else { 0.0 }),
    }
}

pub(super) fn finish(made: Result<Geometry, MeshError>, site: &Site<'_>) -> Result<Value, Problem> {
    Ok(value(made.map_err(problem)?, site))
}

pub(super) fn value(geometry: Geometry, site: &Site<'_>) -> Value {
    let mesh = Rc::new(geometry.into_mesh(""));
    Value::Mesh(MeshValue { mesh, transform: Affine::IDENTITY, span: site.span })
}

/// A problem of the mesh arithmetic, at its argument.
pub(super) fn problem(error: MeshError) -> Problem {
    let MeshError { argument, message, help } = error;
    let at = if argument.is_empty() { None } else { Some(argument) };
    Problem::new(at, message).id("invalid-mesh").maybe_help(help)
}

fn boxed(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let ranges = ["x", "y", "z"].map(|name| match args.get(name) {
        Some(Value::Range(lo, hi)) => Some((*lo, *hi)),
        _ => None,
    });
    let (lo, hi) = match (ranges, args.vec3("size")) {
        ([Some(x), Some(y), Some(z)], None) => {
            if args.get("center").is_some() {
                return Err(Problem::new("center", "`center` goes with `size`")
                    .help("remove it: the ranges say where the box is"));
            }
            ([x.0, y.0, z.0], [x.1, y.1, z.1])
        }
        ([None, None, None], Some(size)) => {
            let center = args.vec3("center").unwrap_or_default();
            if size.iter().any(|side| *side <= 0.0) {
                return Err(Problem::new("size", "every side of a box must be greater than 0"));
            }
            let at = |sign: f64| [0, 1, 2].map(|axis| center[axis] + sign * size[axis] / 2.0);
            (at(-1.0), at(1.0))
        }
        (_, Some(_)) => {
            return Err(
                Problem::new("size", "`size` and ranges are both given").help("give `x`, `y` and `z`, or `size`")
            );
        }
        (_, None) => {
            return Err(
                Problem::new(None, "a box needs `x`, `y` and `z`, or `size`").help("write for example `box(size: 30)`")
            );
        }
    };
    finish(mesh::boxed(lo, hi), site)
}

fn triangles(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let positions = points(args, "positions").unwrap_or_default();
    let faces: Vec<[f64; 3]> = points(args, "faces").unwrap_or_default();
    site.afford("faces", faces.len() as u128)?;
    let whole = |face: &[f64; 3]| face.iter().all(|index| index.fract() == 0.0 && index.abs() < 1e15);
    if let Some(at) = faces.iter().position(|face| !whole(face)) {
        return Err(Problem::new("faces", format!("face {at} has an index that is no whole number")));
    }
    let faces: Vec<[i64; 3]> = faces.into_iter().map(|face| face.map(|index| index as i64)).collect();
    let normals = points(args, "normals");
    let uvs: Option<Vec<[f64; 2]>> = points(args, "uvs");
    finish(mesh::triangles(&positions, &faces, normals.as_deref(), uvs.as_deref()), site)
}

/// The vectors of a list; their type has been checked.
pub(super) fn points<const N: usize>(args: &Args, name: &str) -> Option<Vec<[f64; N]>> {
    let items = args.list(name)?.iter();
    let one = |item: &Value| match item {
        Value::Vector(parts) => <[f64; N]>::try_from(&parts[..]).ok(),
        _ => None,
    };
    Some(items.filter_map(one).collect())
}

/// The file that the argument `path` names.
pub(super) fn read(args: &Args, site: &mut Site<'_>) -> Result<(VPath, Bytes), Problem> {
    let path = resolved(args, site)?;
    let bytes = site.host.read(&path).map_err(|error| {
        Problem::new("path", format!("`{path}` cannot be read: {error}"))
            .id("unreadable-file")
            .maybe_help(beside_help(&path, &error))
    })?;
    Ok((path, bytes))
}

/// The path that the argument `path` says, seen from the file in which it is written.
pub(super) fn resolved(args: &Args, site: &Site<'_>) -> Result<VPath, Problem> {
    let written = if let Some(Value::String(written)) = args.get("path") { written } else { "" };
    VPath::resolve(site.folder, written).map_err(|error| {
        let finding = super::super::module::path_problem(site.span, &error);
        let found = Problem::new("path", finding.message).id("bad-path").maybe_help(finding.help);
        match finding.notes.into_iter().next() {
            Some(note) => found.note(note),
            None => found,
        }
    })
}

fn file(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let part = match args.get("part") {
        Some(Value::String(part)) => Some(Rc::clone(part)),
        _ => None,
    };
    let (path, bytes) = read(args, site)?;
    let (geometry, notes) = {
        let mut beside = beside(&path, site);
        mesh::file::read(&path.extension(), &bytes, part.as_deref(), &mut beside)
    }
    .map_err(|error| broken(&path, error))?;
    remark(&path, notes, site);
    Ok(value(geometry, site))
}

/// Reads files that a mesh file names.
pub(super) fn beside<'s>(
    path: &VPath,
    site: &'s mut Site<'_>,
) -> impl FnMut(&str) -> Result<Box<dyn AsRef<[u8]>>, String> + 's {
    let folder = path.folder().to_owned();
    let host = &mut *site.host;
    move |written| {
        // Some programs write the backslashes of Windows.
        let other = VPath::resolve(&folder, &written.replace('\\', "/"));
        let other = other.map_err(|error| format!("it names another file, and {error}"))?;
        match host.read(&other) {
            Ok(bytes) => Ok(Box::new(bytes)),
            Err(error) => Err(format!("`{other}` cannot be read: {error}")),
        }
    }
}

pub(super) fn broken(path: &VPath, error: mesh::file::FileError) -> Problem {
    let place = if error.place.is_empty() { path.to_string() } else { format!("{path}, {}", error.place) };
    Problem::new("path", error.message).id("invalid-mesh-file").label(place).maybe_help(error.help)
}

/// Makes a finding of each note.
pub(super) fn remark(path: &VPath, notes: Vec<Note>, site: &mut Site<'_>) {
    for note in notes {
        let place = if note.place.is_empty() { String::new() } else { format!(", {}", note.place) };
        let message = format!("`{path}`{place}: {}", note.message);
        if note.fate == Fate::Lengths {
            site.lengthened.push(message);
        } else {
            let finding = Finding::new(note.fate.code(), note.severity, site.span, message);
            site.findings.push(finding.maybe_help(note.help));
        }
    }
}
