//! The height field: a function of x and y as a surface.

use super::smooth::Face;
use super::{Geometry, MAX_TRIANGLES, MeshError};
use crate::ir::{Vec3, normalized};

/// The most vertices along a side; rounding of their places stays far below their distance.
const MOST: u64 = 1 << 20;

/// The places of the vertices of a height field, row by row from low `y` to high, each from low `x` to high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    x: (f64, f64),
    y: (f64, f64),
    counts: (u64, u64),
}

impl Field {
    /// A field over the rectangle `x` by `y` with `counts` vertices along each, the borders included.
    ///
    /// # Errors
    /// Borders that are not finite or not in order, fewer than 2 vertices along a side, more than
    /// [`super::MAX_TRIANGLES`], vertices that fall together in single precision.
    pub fn new(x: (f64, f64), y: (f64, f64), counts: (u64, u64)) -> Result<Self, MeshError> {
        for (name, (lo, hi), count) in [("x", x, counts.0), ("y", y, counts.1)] {
            if !(lo.is_finite() && hi.is_finite() && lo < hi) {
                return Err(MeshError::new(name, format!("`{name}` runs from {lo} to {hi}")));
            }
            if !(2..=MOST).contains(&count) {
                return Err(MeshError::new("vertices", format!("{count} vertices along {name}"))
                    .help(format!("write from 2 to {MOST}")));
            }
            let size = lo.abs().max(hi.abs());
            // Four steps of a single precision number of that size.
            if (hi - lo) / (count - 1) as f64 <= size * f64::from(f32::EPSILON) * 4.0 || !(size as f32).is_finite() {
                return Err(MeshError::new(name, "the vertices fall together in single precision")
                    .help("move the field nearer to the origin, or take fewer vertices"));
            }
        }
        let triangles = 2 * (counts.0 - 1) * (counts.1 - 1);
        if triangles > MAX_TRIANGLES {
            return Err(MeshError::new("vertices", format!("the field has {triangles} triangles"))
                .help(format!("write fewer vertices: at most {MAX_TRIANGLES} triangles have 32-bit indices")));
        }
        Ok(Self { x, y, counts })
    }

    /// The places in their order.
    pub fn places(self) -> impl Iterator<Item = (f64, f64)> {
        let Self { x, y, counts: (columns, rows) } = self;
        // Both ends are exact.
        let at = |(lo, hi): (f64, f64), step: u64, count: u64| {
            if step + 1 == count { hi } else { lo + (hi - lo) * step as f64 / (count - 1) as f64 }
        };
        (0..rows).flat_map(move |row| (0..columns).map(move |column| (at(x, column, columns), at(y, row, rows))))
    }
}

/// The surface through `heights` (z, one for each of [`Field::places`]), facing up, with angle-weighted smooth normals. Every
/// cell is cut from its corner of low x and y to that of high. Texture coordinates run from 0 to 1 along x (`u`) and y (`v`).
///
/// # Errors
/// Another number of heights than places; heights that are not finite in single precision.
pub fn height_field(field: Field, heights: &[f64]) -> Result<Geometry, MeshError> {
    let Field { x, y, counts: (columns, rows) } = field;
    if heights.len() as u64 != columns * rows {
        let message = format!("the field has {} vertices and {} heights", columns * rows, heights.len());
        return Err(MeshError::new("height", message));
    }
    if let Some(((x, y), z)) = field.places().zip(heights).find(|(_, z)| !(**z as f32).is_finite()) {
        return Err(MeshError::new("height", format!("the height at ({x}, {y}) is {z}")));
    }
    let share = |value: f64, (lo, hi): (f64, f64)| ((value - lo) / (hi - lo)) as f32;
    let mut triangles = Vec::with_capacity(2 * ((columns - 1) * (rows - 1)) as usize);
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            // Below MAX_TRIANGLES, hence below 2^32.
            let corner = (row * columns + column) as u32;
            let (right, above) = (corner + 1, corner + columns as u32);
            triangles.push([corner, right, above + 1]);
            triangles.push([corner, above + 1, above]);
        }
    }
    let mut geometry = Geometry {
        positions: field.places().zip(heights).map(|((x, y), z)| [x as f32, y as f32, *z as f32 + 0.0]).collect(),
        normals: None,
        uvs: Some(field.places().map(|(px, py)| [share(px, x), share(py, y)]).collect()),
        triangles,
    };
    let mut sums: Vec<Vec3> = vec![[0.0; 3]; geometry.positions.len()];
    for triangle in &geometry.triangles {
        // No face of a height field is without area: its projection is half a cell.
        let Some(face) = Face::new(*triangle, &geometry) else { continue };
        for (corner, angle) in triangle.iter().zip(face.angles) {
            for (sum, x) in sums[*corner as usize].iter_mut().zip(face.normal) {
                *sum += angle * x;
            }
        }
    }
    let up = [0.0, 0.0, 1.0];
    let unit = |sum: Vec3| normalized(sum).unwrap_or(up).map(|x| x as f32 + 0.0);
    geometry.normals = Some(sums.into_iter().map(unit).collect());
    Ok(geometry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{cross, dot, length};
    use crate::mesh::{area, bounds, is_closed};

    fn made(x: (f64, f64), y: (f64, f64), counts: (u64, u64), height: impl Fn(f64, f64) -> f64) -> Geometry {
        let field = Field::new(x, y, counts).expect("a good field");
        let heights: Vec<f64> = field.places().map(|(x, y)| height(x, y)).collect();
        height_field(field, &heights).expect("good heights")
    }

    #[test]
    fn a_plane_has_its_area_bounds_and_normal() {
        let g = made((-1.0, 3.0), (2.0, 4.0), (5, 3), |x, y| 0.5 * x - 0.25 * y + 7.0);
        assert_eq!((g.positions.len(), g.triangles.len(), g.check()), (15, 16, Ok(())));
        let stretch = (1.0_f64 + 0.25 + 0.0625).sqrt();
        assert!((area((&g).into()) - 8.0 * stretch).abs() < 1e-5);
        assert_eq!(bounds((&g).into()), Some([[-1.0, 2.0, 5.5], [3.0, 4.0, 8.0]]));
        let normal = normalized([-0.5, 0.25, 1.0]).expect("a direction");
        for found in g.normals.iter().flatten() {
            assert!(dot(found.map(f64::from), normal) > 1.0 - 1e-6, "{found:?}");
        }
        assert!(!is_closed((&g).into()));
        let uvs = g.uvs.as_ref().expect("texture coordinates");
        assert_eq!((uvs[0], uvs[4], uvs[14]), ([0.0, 0.0], [1.0, 0.0], [1.0, 1.0]));
    }

    #[test]
    fn normals_of_a_paraboloid_converge_with_the_square_of_the_step() {
        let worst = |count| {
            let g = made((-1.0, 1.0), (-1.0, 1.0), (count, count), |x, y| 0.3 * (x * x + y * y));
            let pairs = g.positions.iter().zip(g.normals.iter().flatten());
            // The border averages over one side only.
            let inner = pairs.filter(|(p, _)| p[0].abs() < 0.9 && p[1].abs() < 0.9);
            inner.fold(0.0_f64, |worst, (p, n)| {
                let [x, y, _] = p.map(f64::from);
                let exact = normalized([-0.6 * x, -0.6 * y, 1.0]).expect("a direction");
                worst.max(length(cross(n.map(f64::from), exact)))
            })
        };
        let (coarse, fine) = (worst(17), worst(65));
        assert!(coarse < 0.02 && fine < coarse / 8.0, "{coarse} {fine}");
    }

    #[test]
    fn faces_look_up() {
        let g = made((0.0, 1.0), (0.0, 1.0), (4, 3), |x, y| libm::sin(9.0 * x) * libm::cos(7.0 * y));
        for triangle in &g.triangles {
            let [a, b, c] = triangle.map(|index| g.positions[index as usize]);
            assert!((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0);
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        let fault = |x, y, counts| Field::new(x, y, counts).expect_err("bad").argument;
        let unit = (0.0, 1.0);
        assert_eq!(fault((1.0, 0.0), unit, (2, 2)), "x");
        assert_eq!(fault(unit, (0.0, f64::INFINITY), (2, 2)), "y");
        assert_eq!(fault((1e9, 1e9 + 1.0), unit, (2, 2)), "x");
        for counts in [(1, 2), (2, 0), (u64::MAX, 2), (100_000, 100_000)] {
            assert_eq!(fault(unit, unit, counts), "vertices", "{counts:?}");
        }
        let field = Field::new(unit, unit, (2, 2)).expect("a good field");
        assert_eq!(height_field(field, &[0.0; 3]).expect_err("too few").argument, "height");
        let error = height_field(field, &[0.0, 1e300, 0.0, 0.0]).expect_err("too high");
        assert!(error.message.contains("(1, 0)"), "{}", error.message);
    }
}
