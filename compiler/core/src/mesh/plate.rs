//! The plate with a hole.

use super::error::round;
use super::rectangle::{range, side};
use super::{Axis, Geometry, MeshError, SignedAxis};

/// How much thicker, relatively, than the thin axis the others must be: more than the rounding errors of coordinates.
const THINNER: f64 = 1e-6;

/// A hole in a plate, in cells of a raster that divides its face evenly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hole {
    /// Columns and rows of the raster.
    pub raster: [u64; 2],
    /// The first and the last column of the hole, counted from 0 at the low coordinate; both belong to it.
    pub columns: (u64, u64),
    /// The first and the last row of the hole.
    pub rows: (u64, u64),
}

/// The box from `lo` to `hi` with a hole through its thinnest axis. Columns run along the first of the two other axes,
/// rows along the second. Closed: the rim of the hole is modeled. Faceted normals, 48 vertices and 32 triangles, which
/// is the least for a body with a hole and 16 corners.
///
/// Texture coordinates go from 0 to 1 over each whole side, laid as on [`super::rectangle`], and over each side of the
/// rim.
///
/// # Errors
/// A number that is not finite, a side that is empty, reversed or vanishes in single precision, no axis thinner than
/// both others, a hole that leaves no border or lies outside of the raster, and one that vanishes in single precision.
pub fn plate(lo: [f64; 3], hi: [f64; 3], hole: Hole) -> Result<Geometry, MeshError> {
    for axis in Axis::ALL {
        let (lo, hi) = range(axis, lo[axis.index()], hi[axis.index()])?;
        round(axis.name(), [lo, hi, 0.0])?;
    }
    let thin = thinnest(lo, hi)?;
    let [across, along] = match thin {
        Axis::X => [Axis::Y, Axis::Z],
        Axis::Y => [Axis::X, Axis::Z],
        Axis::Z => [Axis::X, Axis::Y],
    };
    let mut inner_lo = lo;
    let mut inner_hi = hi;
    let both = [("column", across, hole.columns), ("row", along, hole.rows)];
    for ((word, axis, (first, last)), count) in both.into_iter().zip(hole.raster) {
        check_cells(word, count, first, last)?;
        let i = axis.index();
        let edge = |cells: u64| lo[i] + (hi[i] - lo[i]) * (cells as f64 / count as f64);
        (inner_lo[i], inner_hi[i]) = (edge(first), edge(last + 1));
        let edges = [lo[i], inner_lo[i], inner_hi[i], hi[i]].map(|x| x as f32);
        if edges.windows(2).any(|pair| pair[0] >= pair[1]) {
            let message = format!("the hole or its border along `{}` vanishes in single precision", axis.name());
            return Err(MeshError::new("raster", message).help("write a coarser raster, or make the plate larger"));
        }
    }

    let mut geometry = Geometry { normals: Some(Vec::new()), uvs: Some(Vec::new()), ..Geometry::default() };
    for negative in [true, false] {
        let normal = SignedAxis { axis: thin, negative };
        frame(&mut geometry, [lo, inner_lo], [hi, inner_hi], normal, [across.index(), along.index()])?;
    }
    for axis in [across, along] {
        let i = axis.index();
        for negative in [true, false] {
            side(&mut geometry, lo, hi, SignedAxis { axis, negative })?;
            // The rim faces into the hole: its side at the low end has its normal along the axis.
            let (mut from, mut to) = (inner_lo, inner_hi);
            (from[i], to[i]) = (inner_hi[i], inner_lo[i]);
            side(&mut geometry, from, to, SignedAxis { axis, negative })?;
        }
    }
    Ok(geometry)
}

fn thinnest(lo: [f64; 3], hi: [f64; 3]) -> Result<Axis, MeshError> {
    let mut axes = Axis::ALL.map(|axis| (hi[axis.index()] - lo[axis.index()], axis));
    axes.sort_by(|one, other| one.0.total_cmp(&other.0));
    let [(thickness, thin), (next, other), _] = axes;
    if next > thickness * (1.0 + THINNER) {
        return Ok(thin);
    }
    let message =
        format!("`{}` and `{}` are equally thin, the hole could go through either", thin.name(), other.name());
    Err(MeshError::new(thin.name(), message).help("make the plate thinner along the axis of the hole"))
}

/// Whether the cells leave a border on both sides.
fn check_cells(word: &str, count: u64, first: u64, last: u64) -> Result<(), MeshError> {
    if count < 3 {
        return Err(MeshError::new("raster", format!("the raster has {count} {word}s, a hole and its border need 3"))
            .help("write a raster of at least (3, 3)"));
    }
    let inside = format!("the {word}s that a border leaves are 1..{}", count - 2);
    if first > last {
        return Err(MeshError::new("hole", format!("the {word}s of the hole are reversed"))
            .help(format!("write `{last}..{first}`")));
    }
    if last >= count {
        return Err(MeshError::new("hole", format!("the raster has no {word} {last}")).help(inside));
    }
    if first == 0 || last == count - 1 {
        let at = if first == 0 { 0 } else { last };
        return Err(MeshError::new("hole", format!("the hole leaves no border at {word} {at}")).help(inside));
    }
    Ok(())
}

/// The face on the side of `normal`: four trapezoids between the outer rectangle (the first of `lo` and `hi`) and the
/// hole (the second), so that no corner lies on an edge.
fn frame(
    geometry: &mut Geometry,
    lo: [[f64; 3]; 2],
    hi: [[f64; 3]; 2],
    normal: SignedAxis,
    [u, v]: [usize; 2],
) -> Result<(), MeshError> {
    let flat = normal.axis.index();
    // As in `side`: u runs backwards where u x v would be against the normal.
    let backwards = normal.negative != (normal.axis == Axis::Y);
    let start = geometry.positions.len() as u32;
    let whole = [hi[0][u] - lo[0][u], hi[0][v] - lo[0][v]];
    for (lo, hi, outer) in [(lo[0], hi[0], lo[0]), (lo[1], hi[1], lo[0])] {
        for [right, upper] in [[false, false], [true, false], [true, true], [false, true]] {
            let mut point = [0.0; 3];
            point[flat] = if normal.negative { lo[flat] } else { hi[flat] };
            point[u] = if right != backwards { hi[u] } else { lo[u] };
            point[v] = if upper { hi[v] } else { lo[v] };
            geometry.positions.push(round(normal.axis.name(), point)?);
            geometry.normals.get_or_insert_default().push(normal.vector().map(|x| x as f32));
            let s = (point[u] - outer[u]) / whole[0];
            let t = (point[v] - outer[v]) / whole[1];
            geometry.uvs.get_or_insert_default().push([if backwards { 1.0 - s } else { s } as f32, t as f32]);
        }
    }
    for at in 0..4 {
        let next = (at + 1) % 4;
        let corners = [[at, next, next + 4], [at, next + 4, at + 4]];
        geometry.triangles.extend(corners.map(|corners: [u32; 3]| corners.map(|corner| start + corner)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{area, bounds, degenerate_triangles, is_closed, largest_normal_deviation, signed_volume};

    const HOLE: Hole = Hole { raster: [8, 5], columns: (1, 4), rows: (2, 2) };

    /// A plate 16 x 10 x 0.5, thin along `thin`, as [`plate`] orders the other two.
    fn made(thin: Axis) -> ([f64; 3], [f64; 3], Geometry) {
        let sizes = match thin {
            Axis::X => [0.5, 16.0, 10.0],
            Axis::Y => [16.0, 0.5, 10.0],
            Axis::Z => [16.0, 10.0, 0.5],
        };
        let lo = [1.0, -2.0, 3.0];
        let hi = [0, 1, 2].map(|axis| lo[axis] + sizes[axis]);
        (lo, hi, plate(lo, hi, HOLE).expect("a good plate"))
    }

    #[test]
    fn measures_are_those_of_a_box_less_the_hole() {
        for thin in Axis::ALL {
            let (lo, hi, g) = made(thin);
            assert_eq!((g.positions.len(), g.triangles.len(), g.check()), (48, 32, Ok(())));
            let view = (&g).into();
            // The hole is 8 x 2.
            let expected = 2.0 * (160.0 - 16.0) + 0.5 * 2.0 * (16.0 + 10.0) + 0.5 * 2.0 * (8.0 + 2.0);
            assert!((area(view) - expected).abs() < 1e-9, "{thin:?}: {} {expected}", area(view));
            assert!((signed_volume(view) - 144.0 * 0.5).abs() < 1e-9, "{thin:?}");
            assert_eq!(bounds(view), Some([lo, hi]));
            assert!(is_closed(view) && degenerate_triangles(view) == 0, "{thin:?}");
            assert_eq!(largest_normal_deviation(view), Some(0.0), "{thin:?}");
        }
    }

    #[test]
    fn the_hole_is_where_the_raster_says() {
        for thin in Axis::ALL {
            let (lo, _, g) = made(thin);
            let [u, v] = [0, 1, 2].into_iter().filter(|axis| *axis != thin.index()).collect::<Vec<_>>()[..] else {
                panic!("two axes are left")
            };
            // Columns 1..4 of 8 over 16 and row 2 of 5 over 10.
            let corners = [[2.0, 4.0], [10.0, 4.0], [10.0, 6.0], [2.0, 6.0]];
            for corner in corners {
                let found = g
                    .positions
                    .iter()
                    .filter(|p| f64::from(p[u]) - lo[u] == corner[0] && f64::from(p[v]) - lo[v] == corner[1]);
                // Both ends of the rim, each in one frame and two sides of the rim.
                assert_eq!(found.count(), 6, "{thin:?} {corner:?}");
            }
        }
    }

    #[test]
    fn the_texture_is_upright_and_unmirrored() {
        use crate::ir::{cross, dot, sub};
        for thin in Axis::ALL {
            let (_, _, g) = made(thin);
            let uvs = g.uvs.as_ref().expect("it has texture coordinates");
            assert!(uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
            for triangle in &g.triangles {
                let p = triangle.map(|index| g.positions[index as usize].map(f64::from));
                let t = triangle.map(|index| uvs[index as usize].map(f64::from));
                let turn = (t[1][0] - t[0][0]) * (t[2][1] - t[0][1]) - (t[1][1] - t[0][1]) * (t[2][0] - t[0][0]);
                assert!(turn > 0.0, "{thin:?} {triangle:?} is mirrored");
                // The texture is not sheared on the frames: u is the fraction along the first axis.
                let normal = cross(sub(p[1], p[0]), sub(p[2], p[0]));
                let face = thin.index();
                if dot(normal, normal) > 0.0 && normal[face] != 0.0 {
                    let lengths = [16.0, 10.0];
                    let area = normal[face].abs() / (lengths[0] * lengths[1]);
                    assert!((turn - area).abs() < 1e-6, "{thin:?} {triangle:?}");
                }
            }
        }
    }

    #[test]
    fn bad_arguments_are_explained() {
        let lo = [0.0; 3];
        let hi = [9.0, 9.0, 0.5];
        let fault = |hole: Hole| plate(lo, hi, hole).expect_err("a bad plate");
        let cells = |columns, rows| fault(Hole { raster: [9, 9], columns, rows });
        assert!(cells((0, 3), (2, 3)).message.contains("no border at column 0"));
        assert!(cells((1, 8), (2, 3)).message.contains("no border at column 8"));
        assert!(cells((1, 7), (1, 8)).message.contains("no border at row 8"));
        assert!(cells((1, 9), (2, 3)).message.contains("no column 9"));
        assert!(cells((1, u64::MAX), (2, 3)).message.contains("no column"));
        assert!(cells((5, 3), (2, 3)).help.expect("a way out").contains("3..5"));
        assert_eq!(fault(Hole { raster: [9, 2], columns: (1, 1), rows: (1, 1) }).argument, "raster");
        assert_eq!(fault(Hole { raster: [0, 0], columns: (0, 0), rows: (0, 0) }).argument, "raster");
        // The border beside the last column of so many is lost in rounding.
        let fine = Hole { raster: [1 << 40, 9], columns: (1, (1 << 40) - 2), rows: (2, 3) };
        assert_eq!(fault(fine).argument, "raster");
        let at = |lo, hi| plate(lo, hi, HOLE).expect_err("a bad plate").argument;
        assert_eq!(at([0.0; 3], [1.0, 1.0, 9.0]), "x");
        assert_eq!(at([0.0, 4.9, 0.0], [9.0, 5.0, 0.1]), "y");
        assert_eq!(at([0.0; 3], [9.0, 0.0, 1.0]), "y");
        assert_eq!(at([0.0; 3], [9.0, 9.0, f64::NAN]), "z");
        assert_eq!(at([0.0; 3], [1e300, 9.0, 1.0]), "x");
    }
}
