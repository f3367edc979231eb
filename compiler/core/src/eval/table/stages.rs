//! Stages: what stands behind `|>`. Moves only change the transform, of meshes and groups; the others make new vertices.

use std::rc::Rc;

use crate::ir::{Affine, ColorOrTexture, LightKind, Places, cross, normalized};
use crate::mesh::{self, Geometry};

use super::super::value::{GroupValue, MeshValue, Ty, Value};
use super::meshes::problem;
use super::{Args, Constructor, Family, Parameter, Problem, Site};

/// What stands before `|>`.
const OF: Parameter = Parameter { name: "of", ty: Ty::Mesh, default: None, doc: "the mesh before `|>`" };

/// What stands before the `|>` of a move.
const ANY: Parameter = Parameter { name: "of", ty: Ty::Placeable, default: None, doc: "the mesh or group before `|>`" };

/// What stands before the `|>` of a stage that may be a turn.
const TURNABLE: Parameter =
    Parameter { name: "of", ty: Ty::Turnable, default: None, doc: "the mesh, group or environment before `|>`" };

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Stage,
        name: "translate",
        summary: "Moves.",
        params: &[
            ANY,
            Parameter { name: "x", ty: Ty::Number, default: Some("0"), doc: "along X" },
            Parameter { name: "y", ty: Ty::Number, default: Some("0"), doc: "along Y" },
            Parameter { name: "z", ty: Ty::Number, default: Some("0"), doc: "along Z" },
            Parameter { name: "by", ty: Ty::Vec3, default: Some(""), doc: "added to the three" },
        ],
        positional: 3,
        example: "mesh small = box(size: 30) |> translate(17, -10, 15)",
        build: |args, site| {
            let by = args.vec3("by").unwrap_or_default();
            let part = |name, axis: usize| args.number(name).unwrap_or(0.0) + by[axis];
            moved(args, site, &Affine::translation([part("x", 0), part("y", 1), part("z", 2)]))
        },
    },
    Constructor {
        family: Family::Stage,
        name: "rotate",
        summary: "Turns counter-clockwise, seen against the axis. Give exactly one of `x`, `y`, `z`, or `axis` and `angle`.",
        params: &[
            TURNABLE,
            Parameter { name: "x", ty: Ty::Angle, default: Some(""), doc: "about X" },
            Parameter { name: "y", ty: Ty::Angle, default: Some(""), doc: "about Y" },
            Parameter { name: "z", ty: Ty::Angle, default: Some(""), doc: "about Z" },
            Parameter { name: "axis", ty: Ty::Vec3, default: Some(""), doc: "about any axis" },
            Parameter { name: "angle", ty: Ty::Angle, default: Some(""), doc: "with `axis`" },
            Parameter { name: "about", ty: Ty::NumberOrVec3, default: Some("0"), doc: "a point on the axis" },
        ],
        positional: 0,
        example: "mesh small = box(size: 30) |> rotate(z: -17.5deg)",
        build: rotate,
    },
    Constructor {
        family: Family::Stage,
        name: "scale",
        summary: "Scales about the origin. A mirroring scale also turns the winding, so that the front stays the front.",
        params: &[
            ANY,
            Parameter { name: "factor", ty: Ty::Number, default: Some("1"), doc: "along all axes, not 0" },
            Parameter { name: "x", ty: Ty::Number, default: Some("1"), doc: "along X, not 0" },
            Parameter { name: "y", ty: Ty::Number, default: Some("1"), doc: "along Y, not 0" },
            Parameter { name: "z", ty: Ty::Number, default: Some("1"), doc: "along Z, not 0" },
        ],
        positional: 1,
        example: "mesh large = sphere() |> scale(9)",
        build: |args, site| {
            let factor = args.number("factor").unwrap_or(1.0);
            let by = ["x", "y", "z"].map(|name| args.number(name).unwrap_or(1.0) * factor);
            for (name, part) in ["x", "y", "z"].into_iter().zip(by) {
                if part == 0.0 {
                    let at = if factor == 0.0 { "factor" } else { name };
                    return Err(Problem::new(at, "a scale of 0 flattens the mesh"));
                }
            }
            moved(args, site, &Affine::scaling(by))
        },
    },
    Constructor {
        family: Family::Stage,
        name: "frame",
        summary: "Turns the local axes to the given ones and moves the local origin to `origin`.",
        params: &[
            ANY,
            Parameter { name: "x", ty: Ty::Vec3, default: None, doc: "where X points; made perpendicular to `z`" },
            Parameter {
                name: "z",
                ty: Ty::Vec3,
                default: None,
                doc: "where Z points, kept exactly; needs no unit length",
            },
            Parameter { name: "origin", ty: Ty::NumberOrVec3, default: Some("0"), doc: "where the origin goes" },
        ],
        positional: 0,
        example: "mesh plate = rectangle(x: -40..40, y: -7.5..7.5, z: 0, normal: Z)\n    |> frame(x: X, z: (0, -0.9845, 0.1755), origin: (0, 7.8538, 45.9912))",
        build: frame,
    },
    Constructor {
        family: Family::Stage,
        name: "matrix",
        summary: "An affine map, written as three rows of four numbers: `x' = a x + b y + c z + d`.",
        params: &[
            TURNABLE,
            Parameter { name: "row_x", ty: Ty::Row, default: None, doc: "the row that gives x" },
            Parameter { name: "row_y", ty: Ty::Row, default: None, doc: "the row that gives y" },
            Parameter { name: "row_z", ty: Ty::Row, default: None, doc: "the row that gives z" },
        ],
        positional: 3,
        example: "mesh sheared = box(size: 1) |> matrix((1, 0.5, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))",
        build: |args, site| {
            let row = |name| args.vector(name).and_then(|parts| <[f64; 4]>::try_from(parts).ok()).unwrap_or_default();
            let map = Affine { rows: [row("row_x"), row("row_y"), row("row_z")] };
            if let Some(Value::Light(kind)) = args.get("of") {
                if map.is_rotation() {
                    return turned(kind, &map, false);
                }
                return Err(Problem::new(None, "an environment is turned, and this matrix is no rotation")
                    .note("it is infinitely far away: there is nothing to move, to scale or to mirror")
                    .help("write for example `rotate(z: 20deg)`"));
            }
            if map.is_invertible() {
                return moved(args, site, &map);
            }
            Err(Problem::new(None, "the matrix cannot be inverted: it flattens the mesh"))
        },
    },
    Constructor {
        family: Family::Stage,
        name: "faceted",
        summary: "Flat shading: every face gets its own normal.",
        params: &[OF],
        positional: 0,
        example: "mesh ball = sphere() |> faceted()",
        build: |args, site| changed(args, site, true, |geometry| mesh::faceted(geometry).map(|made| made.0)),
    },
    Constructor {
        family: Family::Stage,
        name: "smooth",
        summary: "Smooth shading: angle-weighted normals, broken at edges sharper than `crease`.",
        params: &[OF, Parameter { name: "crease", ty: Ty::Angle, default: Some("180deg"), doc: "0..180 degrees" }],
        positional: 0,
        example: "mesh lid = box(size: 1) |> smooth(crease: 40deg)",
        build: |args, site| {
            let crease = args.number("crease").unwrap_or(180.0);
            changed(args, site, true, |geometry| mesh::smooth(geometry, crease).map(|made| made.0))
        },
    },
    Constructor {
        family: Family::Stage,
        name: "flip",
        summary: "Turns the front to the back: normals and winding.",
        params: &[OF],
        positional: 0,
        example: "mesh cave = sphere() |> flip()",
        build: |args, site| changed(args, site, false, |geometry| Ok(mesh::flip(geometry))),
    },
];

fn of(args: &Args) -> Result<&MeshValue, Problem> {
    match args.get("of") {
        Some(Value::Mesh(mesh)) => Ok(mesh),
        _ => Err(Problem::new(None, "there is no mesh before `|>`")),
    }
}

/// The mesh or group behind one more move; vertices stay shared.
fn moved(args: &Args, site: &mut Site<'_>, map: &Affine) -> Result<Value, Problem> {
    let further = |before: &Affine| {
        let transform = before.then(map);
        if transform.rows.iter().flatten().all(|entry| entry.is_finite()) {
            return Ok(transform);
        }
        Err(Problem::new(None, "it leaves the range of numbers"))
    };
    match args.get("of") {
        Some(Value::Group(GroupValue { body, places })) => {
            let places = match places {
                Places::One(map) => Places::One(further(map)?),
                Places::Many(maps) => {
                    site.hold(size_of_val(&**maps))?;
                    Places::Many(maps.iter().map(further).collect::<Result<_, _>>()?)
                }
            };
            Ok(Value::Group(GroupValue { body: Rc::clone(body), places }))
        }
        _ => {
            let MeshValue { mesh, transform, span } = of(args)?;
            Ok(Value::Mesh(MeshValue { mesh: Rc::clone(mesh), transform: further(transform)?, span: *span }))
        }
    }
}

/// The mesh with other vertices. `angles` says that the change depends on angles: then a map that bends them is applied
/// first.
fn changed(
    args: &Args,
    site: &Site<'_>,
    angles: bool,
    change: impl FnOnce(Geometry) -> Result<Geometry, mesh::MeshError>,
) -> Result<Value, Problem> {
    let MeshValue { mesh, transform, span: _ } = of(args)?;
    let mut geometry = Geometry::from_mesh(mesh);
    let mut transform = *transform;
    if angles && !transform.is_similarity() {
        geometry = mesh::transform(geometry, &transform).map_err(problem)?;
        transform = Affine::IDENTITY;
    }
    let made = change(geometry).map_err(problem)?;
    let mesh = Rc::new(made.into_mesh(mesh.name.as_str()));
    Ok(Value::Mesh(MeshValue { mesh, transform, span: site.span }))
}

fn rotate(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let turns: Vec<(&'static str, [f64; 3])> = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])]
        .into_iter()
        .filter(|(name, _)| args.get(name).is_some())
        .collect();
    let axis = args.vec3("axis");
    let (axis, angle) = match (turns.as_slice(), axis, args.number("angle")) {
        ([(name, axis)], None, None) => (*axis, args.number(name).unwrap_or(0.0)),
        ([], Some(axis), Some(angle)) => {
            let unit = normalized(axis).ok_or_else(|| Problem::new("axis", "the zero vector is no axis"))?;
            (unit, angle)
        }
        ([], Some(_), None) => return Err(Problem::new("axis", "`axis` needs `angle`")),
        ([], None, _) => {
            return Err(Problem::new(None, "`rotate` needs an axis").help("write for example `rotate(z: 20deg)`"));
        }
        ([_, (second, _), ..], _, _) => {
            return Err(Problem::new(*second, "`rotate` takes one axis")
                .note("the order of several turns would have to be guessed")
                .help("write several stages: `|> rotate(x: ...) |> rotate(y: ...)`"));
        }
        ([(name, _)], _, _) => return Err(Problem::new(*name, format!("`{name}` and `axis` are both given"))),
    };
    let about = args.vec3("about").unwrap_or_default();
    let back = about.map(|part| 0.0 - part);
    let turn = Affine::rotation(axis, angle);
    if let Some(Value::Light(kind)) = args.get("of") {
        return turned(kind, &turn, args.get("about").is_some_and(|_| about != [0.0; 3]));
    }
    moved(args, site, &Affine::translation(back).then(&turn).then(&Affine::translation(about)))
}

/// An environment behind one more turn. It is infinitely far away, so that there is no place to turn it about.
fn turned(kind: &LightKind, by: &Affine, about: bool) -> Result<Value, Problem> {
    if about {
        return Err(Problem::new("about", "an environment is turned about no place: it is infinitely far away")
            .help("leave `about` out"));
    }
    let mut kind = kind.clone();
    if let LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint: _, turn } = &mut kind {
        *turn = turn.then(by);
    }
    // The same radiance from all directions looks the same however it is turned.
    Ok(Value::Light(Rc::new(kind)))
}

fn frame(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let z = args.vec3("z").and_then(normalized).ok_or_else(|| Problem::new("z", "the zero vector has no direction"))?;
    let wanted = args.vec3("x").unwrap_or_default();
    let parallel = || Problem::new("x", "`x` is parallel to `z`, or zero");
    let wanted = normalized(wanted).ok_or_else(parallel)?;
    let y = normalized(cross(z, wanted)).filter(|_| crate::ir::length(cross(z, wanted)) > 1e-9).ok_or_else(parallel)?;
    let x = cross(y, z);
    let origin = args.vec3("origin").unwrap_or_default();
    let rows = [0, 1, 2].map(|at| [x[at], y[at], z[at], origin[at]]);
    moved(args, site, &Affine { rows })
}
