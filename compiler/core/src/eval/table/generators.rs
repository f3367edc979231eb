//! Generators of round meshes and of the plate with a hole.

use crate::mesh::{self, Hole};

use super::super::numeric::LANES;
use super::super::value::{Ty, Value};
use super::meshes::{finish, points, problem};
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Mesh,
        name: "plate",
        summary: "A box with a hole through its thinnest axis, faceted, its normals outward, the rim of the hole closed.",
        params: &[
            Parameter { name: "x", ty: Ty::Range, default: None, doc: "from one side to the other" },
            Parameter { name: "y", ty: Ty::Range, default: None, doc: "from front to back" },
            Parameter { name: "z", ty: Ty::Range, default: None, doc: "from bottom to top" },
            Parameter {
                name: "raster",
                ty: Ty::Vec2,
                default: None,
                doc: "columns along the first of the two axes that are not thin, and rows along the second, \
                      that divide the plate evenly; at least 3 each",
            },
            Parameter {
                name: "hole",
                ty: Ty::Cells,
                default: None,
                doc: "columns and rows that are left out, from 0 at the low coordinate, both ends included; \
                      at least one remains on each side",
            },
        ],
        positional: 0,
        example: "mesh window = plate(x: -5..5, y: 4.95..5, z: 0..10, raster: (9, 9), hole: (2..6, 3..3))",
        build: plate,
    },
    Constructor {
        family: Family::Mesh,
        name: "disk",
        summary: "A flat disk or ring about the z axis at z = 0, its normal up.",
        params: &[
            Parameter { name: "radius", ty: Ty::Number, default: None, doc: "> 0" },
            Parameter { name: "inner", ty: Ty::Number, default: Some("0"), doc: "radius of the hole, below `radius`" },
            SEGMENTS,
        ],
        positional: 0,
        example: "mesh washer = disk(radius: 2, inner: 1) |> translate(z: 3)",
        build: |args, site| {
            let inner = args.number("inner").unwrap_or_default();
            around(args, site, if inner == 0.0 { 1 } else { 2 })?;
            finish(mesh::disk(number(args, "radius")?, inner, segments(args)), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "cylinder",
        summary: "A cylinder about the z axis with smooth normals outward.",
        params: &[
            Parameter { name: "radius", ty: Ty::Number, default: None, doc: "> 0" },
            Parameter { name: "z", ty: Ty::Range, default: None, doc: "from bottom to top" },
            SEGMENTS,
            CAPS,
        ],
        positional: 0,
        example: "mesh shaft = cylinder(radius: 0.3, z: 0..4, caps: false)",
        build: |args, site| {
            around(args, site, if caps(args) { 4 } else { 2 })?;
            let made = mesh::cylinder(number(args, "radius")?, interval(args, "z")?, segments(args), caps(args));
            finish(made, site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "cone",
        summary: "A cone or truncated cone about the z axis with smooth normals outward.",
        params: &[
            Parameter { name: "radius", ty: Ty::Number, default: None, doc: "at the bottom, at least 0" },
            Parameter { name: "top", ty: Ty::Number, default: Some("0"), doc: "radius at the top, at least 0" },
            Parameter { name: "z", ty: Ty::Range, default: None, doc: "from bottom to top" },
            SEGMENTS,
            CAPS,
        ],
        positional: 0,
        example: "mesh roof = cone(radius: 3, top: 1, z: 4..6)",
        build: |args, site| {
            let top = args.number("top").unwrap_or_default();
            let z = interval(args, "z")?;
            let radius = number(args, "radius")?;
            // An end of no radius is a point: half the triangles, and no cap.
            let ends = [radius, top].into_iter().filter(|radius| *radius > 0.0).count() as u64;
            around(args, site, if caps(args) { 2 * ends } else { ends })?;
            finish(mesh::cone(radius, top, z, segments(args), caps(args)), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "torus",
        summary: "A torus about the z axis round the origin, of 2 segments rings triangles with smooth normals outward.",
        params: &[
            Parameter { name: "major", ty: Ty::Number, default: None, doc: "radius of the circle in the tube, > 0" },
            Parameter { name: "minor", ty: Ty::Number, default: None, doc: "radius of the tube, below `major`" },
            SEGMENTS,
            Parameter { name: "rings", ty: Ty::Whole, default: Some("32"), doc: "around the tube, at least 3" },
        ],
        positional: 0,
        example: "mesh ring = torus(major: 9, minor: 0.5, segments: 128)",
        build: |args, site| {
            let rings = args.whole("rings").unwrap_or(32);
            around(args, site, u64::from(rings) * 2)?;
            let (major, minor) = (number(args, "major")?, number(args, "minor")?);
            finish(mesh::torus(major, minor, segments(args), rings.into()), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "lathe",
        summary: "A profile turned about the z axis; outside is on the right hand of its direction.",
        params: &[
            Parameter {
                name: "profile",
                ty: Ty::Points2,
                default: None,
                doc: "points (distance from the axis, z); a profile that runs upwards faces away from the axis. \
                      The normal at a point is the mean of those of both neighboring stretches",
            },
            SEGMENTS,
            Parameter { name: "closed", ty: Ty::Bool, default: Some("false"), doc: "join the last point to the first" },
        ],
        positional: 1,
        example: "mesh bowl = lathe([(0, 0), (3, 1), (4, 5)], segments: 96)",
        build: |args, site| {
            let profile: Vec<[f64; 2]> = points(args, "profile").unwrap_or_default();
            around(args, site, 2 * profile.len().saturating_sub(1) as u64)?;
            finish(mesh::lathe(&profile, segments(args), flag(args, "closed", false)), site)
        },
    },
    Constructor {
        family: Family::Mesh,
        name: "height_field",
        summary: "The surface z = height(x, y) over a rectangle, facing up, with smooth normals.",
        params: &[
            Parameter {
                name: "height",
                ty: Ty::Height,
                default: None,
                doc: "the name of a function `let height(x: number, y: number) = ...` that gives a number",
            },
            Parameter { name: "x", ty: Ty::Range, default: None, doc: "from one side to the other" },
            Parameter { name: "y", ty: Ty::Range, default: None, doc: "from front to back" },
            Parameter {
                name: "vertices",
                ty: Ty::Vec2,
                default: None,
                doc: "along x and along y, the borders included, at least 2 each; \
                      2 (vertices.x - 1) (vertices.y - 1) triangles",
            },
        ],
        positional: 1,
        example: "let hill(x: number, y: number) = exp(0 - x * x - y * y)\n\
                  mesh hill_top = height_field(hill, x: -2..2, y: -2..2, vertices: (65, 65))",
        build: field,
    },
];

const SEGMENTS: Parameter =
    Parameter { name: "segments", ty: Ty::Whole, default: Some("64"), doc: "around the z axis, at least 3" };

const CAPS: Parameter =
    Parameter { name: "caps", ty: Ty::Bool, default: Some("true"), doc: "close the ends with flat disks" };

/// A required number.
fn number(args: &Args, name: &'static str) -> Result<f64, Problem> {
    args.number(name).ok_or_else(|| Problem::new(name, format!("`{name}` is missing")))
}

/// A required range.
fn interval(args: &Args, name: &'static str) -> Result<(f64, f64), Problem> {
    match args.get(name) {
        Some(Value::Range(lo, hi)) => Ok((*lo, *hi)),
        _ => Err(Problem::new(name, format!("`{name}` is missing"))),
    }
}

fn segments(args: &Args) -> u64 {
    args.whole("segments").unwrap_or(64).into()
}

/// Whether the scene may make a mesh of `slice` triangles in each segment.
fn around(args: &Args, site: &Site<'_>, slice: u64) -> Result<(), Problem> {
    site.afford("segments", u128::from(segments(args)) * u128::from(slice))
}

fn caps(args: &Args) -> bool {
    flag(args, "caps", true)
}

fn flag(args: &Args, name: &str, default: bool) -> bool {
    if let Some(Value::Bool(flag)) = args.get(name) { *flag } else { default }
}

fn plate(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let [x, y, z] = [interval(args, "x")?, interval(args, "y")?, interval(args, "z")?];
    let raster = match args.vector("raster") {
        Some([columns, rows]) => [count("raster", *columns)?, count("raster", *rows)?],
        _ => return Err(Problem::new("raster", "`raster` is missing")),
    };
    let (columns, rows) = match args.get("hole") {
        Some(Value::Tuple(parts)) => match &parts[..] {
            [Value::Range(a, b), Value::Range(c, d)] => ((*a, *b), (*c, *d)),
            _ => return Err(Problem::new("hole", "`hole` is no pair of ranges")),
        },
        _ => return Err(Problem::new("hole", "`hole` is missing")),
    };
    let cells = |(first, last)| Ok::<_, Problem>((count("hole", first)?, count("hole", last)?));
    let hole = Hole { raster, columns: cells(columns)?, rows: cells(rows)? };
    finish(mesh::plate([x.0, y.0, z.0], [x.1, y.1, z.1], hole), site)
}

fn field(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let Some(Value::Function(function)) = args.get("height") else {
        return Err(Problem::new("height", "`height` is no function"));
    };
    let counts = match args.vector("vertices") {
        Some([nx, ny]) => (count("vertices", *nx)?, count("vertices", *ny)?),
        _ => return Err(Problem::new("vertices", "`vertices` is missing")),
    };
    let field = mesh::Field::new(interval(args, "x")?, interval(args, "y")?, counts).map_err(problem)?;
    site.afford("vertices", 2 * u128::from(counts.0 - 1) * u128::from(counts.1 - 1))?;
    let mut heights = Vec::new();
    let mut places = field.places().map(|(x, y)| [x, y]);
    loop {
        let some: Vec<[f64; 2]> = places.by_ref().take(LANES).collect();
        if some.is_empty() {
            break;
        }
        if let Some(many) = site.host.apply_many(function, &some) {
            heights.extend(many);
            continue;
        }
        for place in some {
            match site.host.apply(function, place.map(Value::Number).to_vec(), site.span) {
                Ok(Value::Number(z)) => heights.push(z),
                Ok(other) => {
                    let message = format!("the function gives {}, not a number", other.kind());
                    return Err(Problem::new("height", message).id("type-mismatch"));
                }
                Err(_) => return Err(Problem::reported()),
            }
        }
    }
    finish(mesh::height_field(field, &heights), site)
}

/// A number of cells or the number of a cell.
fn count(name: &'static str, number: f64) -> Result<u64, Problem> {
    // Numbers of this size are exact.
    if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
        return Ok(number as u64);
    }
    let message = format!("`{name}` takes whole numbers from 0 to {}, not {number}", u32::MAX);
    Err(Problem::new(name, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_whole_and_not_negative() {
        assert_eq!(count("hole", 7.0).ok(), Some(7));
        for bad in [0.5, -1.0, 1e10, f64::NAN] {
            assert!(count("hole", bad).is_err_and(|problem| problem.0.at == Some("hole")), "{bad}");
        }
    }
}
