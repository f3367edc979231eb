//! The rectangle along the axes.

use super::error::{finite, round};
use super::{Geometry, MeshError};

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl Axis {
    /// All three in order.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// The position of its coordinate in a vector.
    pub fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }

    /// As the language spells its extents: `x`, `y`, `z`.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// One of the six directions along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignedAxis {
    /// Along which axis.
    pub axis: Axis,
    /// Whether it points to smaller coordinates.
    pub negative: bool,
}

impl SignedAxis {
    /// The unit vector.
    pub fn vector(self) -> [f64; 3] {
        let mut vector = [0.0; 3];
        vector[self.axis.index()] = if self.negative { -1.0 } else { 1.0 };
        vector
    }

    /// The direction that is `vector`, if it is one of the six; the length does not matter.
    pub fn from_vector(vector: [f64; 3]) -> Option<Self> {
        let mut axes = Axis::ALL.into_iter().filter(|axis| vector[axis.index()] != 0.0);
        let axis = axes.next()?;
        let only = axes.next().is_none() && vector[axis.index()].is_finite();
        only.then(|| Self { axis, negative: vector[axis.index()] < 0.0 })
    }
}

/// Where a rectangle lies along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// In the plane at this coordinate.
    At(f64),
    /// From the first to the second coordinate, the first below the second.
    Range(f64, f64),
}

/// Two triangles over two ranges, in the plane at the third coordinate, with the given normal.
///
/// Texture coordinates go from 0 to 1 and stand upright and unmirrored for someone who looks at the front: `v` grows
/// along the later of the two axes (upwards on a wall), `u` to the right.
///
/// # Errors
/// Not exactly one number among the extents, a normal along one of the ranges, a range that is empty, reversed or
/// vanishes in single precision, a number that is not finite.
pub fn rectangle(extents: [Extent; 3], normal: SignedAxis) -> Result<Geometry, MeshError> {
    let mut lo = [0.0; 3];
    let mut hi = [0.0; 3];
    let mut flat = None;
    for axis in Axis::ALL {
        let i = axis.index();
        match extents[i] {
            Extent::At(at) => {
                (lo[i], hi[i]) = (finite(axis.name(), at)?, at);
                if let Some(first) = flat.replace(axis) {
                    let (first, second) = (Axis::name(first), axis.name());
                    let message = format!("`{first}` and `{second}` are both numbers, the rectangle would be a line");
                    return Err(MeshError::new(second, message).help("give two ranges and one number"));
                }
            }
            Extent::Range(from, to) => (lo[i], hi[i]) = range(axis, from, to)?,
        }
    }
    let Some(flat) = flat else {
        let message = "`x`, `y` and `z` are all ranges, a rectangle has no thickness";
        return Err(MeshError::new("x", message).help("give two ranges and one number, or use `box`"));
    };
    if normal.axis != flat {
        let name = flat.name();
        let message = format!("the normal lies in the plane of the rectangle, which is perpendicular to {name}");
        let upper = name.to_ascii_uppercase();
        return Err(MeshError::new("normal", message).help(format!("write `normal: {upper}` or `normal: -{upper}`")));
    }
    let mut geometry = Geometry { normals: Some(Vec::new()), uvs: Some(Vec::new()), ..Geometry::default() };
    side(&mut geometry, lo, hi, normal)?;
    Ok(geometry)
}

/// A checked range of coordinates along `axis`.
pub(super) fn range(axis: Axis, lo: f64, hi: f64) -> Result<(f64, f64), MeshError> {
    let name = axis.name();
    finite(name, lo)?;
    finite(name, hi)?;
    if lo > hi {
        return Err(MeshError::new(name, format!("the range of `{name}` is reversed"))
            .help(format!("write `{name}: {hi}..{lo}`")));
    }
    if lo == hi {
        return Err(MeshError::new(name, format!("the range of `{name}` is empty")));
    }
    if lo as f32 == hi as f32 {
        let message = format!("both ends of `{name}` are {} in single precision", lo as f32);
        return Err(MeshError::new(name, message).help("make the range larger, or move the scene to the origin"));
    }
    Ok((lo, hi))
}

/// Adds the side with outward normal `normal` of the box from `lo` to `hi`.
pub(super) fn side(geometry: &mut Geometry, lo: [f64; 3], hi: [f64; 3], normal: SignedAxis) -> Result<(), MeshError> {
    let flat = normal.axis.index();
    // u is the earlier and v the later of the two other axes; u runs backwards where u x v would be against the normal.
    let (u, v) = match normal.axis {
        Axis::X => (1, 2),
        Axis::Y => (0, 2),
        Axis::Z => (0, 1),
    };
    // y x z = x and x x y = z, but x x z = -y.
    let backwards = normal.negative != (normal.axis == Axis::Y);
    let (u0, u1) = if backwards { (hi[u], lo[u]) } else { (lo[u], hi[u]) };
    let start = geometry.positions.len() as u32;
    for [s, t] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0_f32, 1.0]] {
        let mut point = [0.0; 3];
        point[flat] = if normal.negative { lo[flat] } else { hi[flat] };
        point[u] = if s == 0.0 { u0 } else { u1 };
        point[v] = if t == 0.0 { lo[v] } else { hi[v] };
        geometry.positions.push(round(normal.axis.name(), point)?);
        if let Some(normals) = &mut geometry.normals {
            normals.push(normal.vector().map(|x| x as f32));
        }
        if let Some(uvs) = &mut geometry.uvs {
            uvs.push([s, t]);
        }
    }
    geometry.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners: [u32; 3]| corners.map(|corner| start + corner)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::{cross, dot, sub};
    use crate::mesh::{area, largest_normal_deviation};

    fn every_direction() -> impl Iterator<Item = SignedAxis> {
        Axis::ALL.into_iter().flat_map(|axis| [false, true].map(|negative| SignedAxis { axis, negative }))
    }

    fn made(normal: SignedAxis) -> Geometry {
        let mut extents = [Extent::Range(-1.0, 2.0), Extent::Range(3.0, 8.0), Extent::Range(0.5, 4.5)];
        extents[normal.axis.index()] = Extent::At(7.0);
        rectangle(extents, normal).expect("a good rectangle")
    }

    #[test]
    fn winding_normal_and_texture_agree_on_all_six_sides() {
        for normal in every_direction() {
            let g = made(normal);
            assert_eq!((g.positions.len(), g.triangles.len(), g.check()), (4, 2, Ok(())));
            assert_eq!(largest_normal_deviation((&g).into()), Some(0.0), "{normal:?}");
            let sides = [3.0, 5.0, 4.0];
            let expected: f64 = Axis::ALL.into_iter().filter(|a| *a != normal.axis).map(|a| sides[a.index()]).product();
            assert_eq!(area((&g).into()), expected);
            let p = |i: usize| g.positions[i].map(f64::from);
            let (u, v) = (sub(p(1), p(0)), sub(p(3), p(0)));
            assert!(dot(cross(u, v), normal.vector()) > 0.0, "u x v points against {normal:?}");
            let up = if normal.axis == Axis::Z { 1 } else { 2 };
            assert!(v[up] > 0.0, "v runs downwards for {normal:?}");
            assert_eq!(g.uvs.as_deref(), Some(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][..]));
        }
    }

    #[test]
    fn bad_arguments_are_named() {
        use Extent::{At, Range};
        let z = SignedAxis { axis: Axis::Z, negative: false };
        let fault = |extents| rectangle(extents, z).expect_err("bad extents").argument;
        assert_eq!(fault([Range(0.0, 1.0), Range(0.0, 1.0), Range(0.0, 1.0)]), "x");
        assert_eq!(fault([Range(0.0, 1.0), At(0.0), At(0.0)]), "z");
        assert_eq!(fault([Range(0.0, 1.0), At(0.0), Range(0.0, 1.0)]), "normal");
        assert_eq!(fault([Range(1.0, 0.0), Range(0.0, 1.0), At(0.0)]), "x");
        assert_eq!(fault([Range(0.0, 1.0), Range(1e9, 1e9 + 1.0), At(0.0)]), "y");
        assert_eq!(fault([Range(0.0, f64::NAN), Range(0.0, 1.0), At(0.0)]), "x");
        assert_eq!(fault([Range(0.0, 1.0), Range(0.0, 1.0), At(1e200)]), "z");
    }

    #[test]
    fn directions_come_from_vectors() {
        assert_eq!(SignedAxis::from_vector([0.0, -1.0, 0.0]), Some(SignedAxis { axis: Axis::Y, negative: true }));
        assert_eq!(SignedAxis::from_vector([0.0, -1.0, 1e-9]), None);
        assert_eq!(SignedAxis::from_vector([0.0; 3]), None);
        assert_eq!(SignedAxis::from_vector([f64::NAN, 0.0, 0.0]), None);
    }
}
