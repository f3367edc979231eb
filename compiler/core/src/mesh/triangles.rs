//! The mesh written out in numbers.

use super::error::round;
use super::{Geometry, MAX_TRIANGLES, MeshError, UNIT_TOLERANCE, faceted};
use crate::ir::{Vec3, length, normalized};

/// The mesh with these positions and faces (indices from 0, counter-clockwise seen from the front).
///
/// Without `normals` every face gets its own (vertices are split); a face without area is then an error. Given normals
/// are normalized.
///
/// # Errors
/// No face, an index out of range, arrays of different lengths, a number that is not finite, a normal whose length
/// differs from 1 by more than [`UNIT_TOLERANCE`], more than [`MAX_TRIANGLES`] faces.
pub fn triangles(
    positions: &[Vec3],
    faces: &[[i64; 3]],
    normals: Option<&[Vec3]>,
    uvs: Option<&[[f64; 2]]>,
) -> Result<Geometry, MeshError> {
    let count = positions.len();
    if faces.is_empty() {
        return Err(MeshError::new("faces", "the mesh has no faces"));
    }
    if faces.len() as u64 > MAX_TRIANGLES || count as u64 > 3 * MAX_TRIANGLES {
        let message = format!("the mesh has {} faces, more than the limit of {MAX_TRIANGLES}", faces.len());
        return Err(MeshError::new("faces", message));
    }
    for (name, length) in [("normals", normals.map(<[_]>::len)), ("uvs", uvs.map(<[_]>::len))] {
        if let Some(length) = length.filter(|length| *length != count) {
            return Err(MeshError::new(name, format!("there are {count} positions but {length} {name}"))
                .help(format!("give one of `{name}` for each position")));
        }
    }
    let mut geometry = Geometry::default();
    for (at, point) in positions.iter().enumerate() {
        let rounded = round("positions", *point).map_err(|error| MeshError {
            message: format!("position {at} ({}): {}", words(point), error.message),
            ..error
        })?;
        geometry.positions.push(rounded);
    }
    for (at, face) in faces.iter().enumerate() {
        if let Some(index) = face.iter().find(|index| usize::try_from(**index).map_or(true, |index| index >= count)) {
            let message = format!("face {at} uses vertex {index}, but there are {count} positions");
            let help = match count {
                0 => "give positions".to_owned(),
                _ => format!("indices go from 0 to {}", count - 1),
            };
            return Err(MeshError::new("faces", message).help(help));
        }
        geometry.triangles.push(face.map(|index| index as u32));
    }
    if let Some(uvs) = uvs {
        if let Some(at) = uvs.iter().position(|uv| !uv.iter().all(|x| (*x as f32).is_finite())) {
            return Err(MeshError::new("uvs", format!("texture coordinate {at} is not finite in single precision")));
        }
        geometry.uvs = Some(uvs.iter().map(|uv| uv.map(|x| x as f32)).collect());
    }
    let Some(normals) = normals else {
        let (geometry, dropped) = faceted(geometry.clone()).map(|made| match made.1 {
            0 => (made.0, None),
            _ => (made.0, geometry.triangles.iter().position(|face| has_no_area(&geometry, *face))),
        })?;
        return match dropped {
            None => Ok(geometry),
            Some(at) => Err(MeshError::new("faces", format!("face {at} has no area, so it has no normal"))
                .help("remove the face, or give `normals`")),
        };
    };
    let mut made = Vec::with_capacity(count);
    for (at, normal) in normals.iter().enumerate() {
        let size = length(*normal);
        match normalized(*normal) {
            Some(unit) if (size - 1.0).abs() <= UNIT_TOLERANCE => made.push(unit.map(|x| x as f32)),
            unit => {
                let error = MeshError::new("normals", format!("normal {at} has length {size}"));
                return Err(match unit {
                    Some(unit) => error.help(format!("normalize it: ({})", words(&unit))),
                    None => error.help("a normal must have length 1"),
                });
            }
        }
    }
    geometry.normals = Some(made);
    Ok(geometry)
}

fn has_no_area(geometry: &Geometry, face: [u32; 3]) -> bool {
    super::face_normal(face.map(|index| geometry.positions[index as usize].map(f64::from))).is_none()
}

fn words([x, y, z]: &Vec3) -> String {
    format!("{x}, {y}, {z}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::largest_normal_deviation;

    const SQUARE: [Vec3; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn without_normals_it_is_faceted() {
        let g = triangles(&SQUARE, &[[0, 1, 2], [0, 2, 3]], None, Some(&[[0.0, 0.5]; 4])).expect("a good square");
        assert_eq!((g.positions.len(), g.check(), g.uvs.as_ref().map(Vec::len)), (4, Ok(()), Some(4)));
        assert_eq!(largest_normal_deviation((&g).into()), Some(0.0));
    }

    #[test]
    fn faults_are_named() {
        let up = [[0.0, 0.0, 1.0]; 4];
        let fault = |faces: &[[i64; 3]], normals: Option<&[Vec3]>| {
            triangles(&SQUARE, faces, normals, None).map_err(|error| (error.argument, error.message)).expect_err("bad")
        };
        assert_eq!(fault(&[], None).0, "faces");
        assert_eq!(fault(&[[0, 1, 4]], None).1, "face 0 uses vertex 4, but there are 4 positions");
        assert_eq!(fault(&[[0, 1, -1]], None).0, "faces");
        assert_eq!(fault(&[[0, 1, i64::MAX]], None).0, "faces");
        assert_eq!(fault(&[[0, 1, 2], [1, 1, 2]], None).1, "face 1 has no area, so it has no normal");
        assert_eq!(fault(&[[0, 1, 2]], Some(&up[..3])).0, "normals");
        assert_eq!(fault(&[[0, 1, 2]], Some(&[[0.0, 0.0, 1.1]; 4])).0, "normals");
        assert_eq!(fault(&[[0, 1, 2]], Some(&[[0.0; 3]; 4])).0, "normals");
        assert_eq!(fault(&[[0, 1, 2]], Some(&[[f64::NAN; 3]; 4])).0, "normals");
        assert!(triangles(&SQUARE, &[[1, 1, 2]], Some(&up), None).is_ok());
        let far = [[1e300, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(triangles(&far, &[[0, 1, 2]], None, None).expect_err("too far").argument, "positions");
    }
}
