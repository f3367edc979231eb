//! What the targets need to know of a camera beyond what the Scene says: the other angle of view, axes, clipping.

use crate::ir::{Affine, Camera, Film, Instance, Scene, Shape, Vec3, dot, length, sub};

/// The vertical full angle of view in degrees, `2 atan(tan(fov_x / 2) height / width)`; exactly `fov_x` for a square.
pub fn fov_y(fov_x: f64, film: &Film) -> f64 {
    let Film { width, height, filter: _ } = film;
    if width == height {
        return fov_x;
    }
    let half = libm::tan(fov_x.to_radians() / 2.0) * f64::from(*height) / f64::from(*width);
    (2.0 * libm::atan(half)).to_degrees()
}

/// The axis that is farthest from `direction`.
pub fn across(direction: Vec3) -> Vec3 {
    let smallest = (0..3).min_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[smallest] = 1.0;
    axis
}

/// The distance from `camera`'s eye to the farthest corner of the scene's bounding box; 0 for an empty scene.
pub fn reach(scene: &Scene, camera: &Camera) -> f64 {
    let mut farthest = 0.0_f64;
    corners(scene, |corner| farthest = farthest.max(length(sub(corner, camera.eye))));
    farthest
}

/// The radius of the sphere around the box around the scene.
pub fn bounding_radius(scene: &Scene) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    corners(scene, |corner| {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    });
    let diagonal = length(sub(high, low));
    if diagonal.is_finite() { diagonal / 2.0 } else { 0.0 }
}

/// The radius in which photon mapping gathers photons first: five times what a pixel is of the bounding sphere's radius.
/// It is the choice of Mitsuba 0.6 where a file gives none (`sppm.cpp`, `preprocess`); PBRT's default is 1 whatever the
/// scene's size.
pub fn photon_radius(scene: &Scene) -> f64 {
    let Film { width, height, filter: _ } = &scene.film;
    let radius = 5.0 * bounding_radius(scene) / f64::from((*width).max(*height));
    if radius > 0.0 { radius } else { 1.0 }
}

/// The corners of the boxes around all surfaces, each box around its mesh and placed as the mesh is.
fn corners(scene: &Scene, mut visit: impl FnMut(Vec3)) {
    let mut boxes: Vec<Option<[Vec3; 2]>> = vec![None; scene.meshes.len()];
    let mut see = |shape: &Shape, outer: &Affine| {
        let Shape { name: _, mesh, transform, material: _, emission: _ } = shape;
        let slot = &mut boxes[mesh.index()];
        let [low, high] = *slot.get_or_insert_with(|| bounds(scene.meshes[*mesh].positions.as_slice()));
        let placed = transform.then(outer);
        for corner in 0..8_u8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            visit(placed.point([pick(0), pick(1), pick(2)]));
        }
    };
    scene.shapes.values().for_each(|shape| see(shape, &Affine::IDENTITY));
    for instance in scene.instances.values() {
        let Instance { name: _, group, places } = instance;
        for place in places.maps() {
            scene.groups[*group].shapes.values().for_each(|shape| see(shape, place));
        }
    }
}

/// The smallest box with its sides along the axes that holds all `positions`; an empty box around the origin for none.
pub fn bounds(positions: &[[f32; 3]]) -> [Vec3; 2] {
    let Some(first) = positions.first() else {
        return [[0.0; 3]; 2];
    };
    let (mut low, mut high) = (*first, *first);
    for position in positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    [low.map(f64::from), high.map(f64::from)]
}

/// Clipping distances for a renderer that clips at `default` unless told otherwise. What the camera gives is kept; a
/// distance that it leaves open is none (nothing to write) as long as the default cuts nothing off, else one that
/// does not: a thousandth of the reach in front, twice the reach behind.
pub fn clipping(scene: &Scene, camera: &Camera, default: (f64, f64)) -> (Option<f64>, Option<f64>) {
    let reach = match (camera.near, camera.far) {
        (Some(_), Some(_)) => return (camera.near, camera.far),
        (Some(_), None) | (None, Some(_)) | (None, None) => reach(scene, camera),
    };
    let near = camera.near.or_else(|| {
        let wanted = reach.min(camera.far.unwrap_or(reach)) * 1e-3;
        (wanted > 0.0 && wanted < default.0).then_some(wanted)
    });
    let far = camera.far.or_else(|| (reach > default.1).then_some(2.0 * reach));
    (near, far)
}

/// The near distance for a format that requires one: a thousandth of the way to the farthest surface keeps a depth buffer precise.
pub fn must_near(scene: &Scene, camera: &Camera) -> f64 {
    let reach = reach(scene, camera);
    let open = if reach > 0.0 { reach * 1e-3 } else { 1e-2 };
    camera.near.unwrap_or_else(|| camera.far.map_or(open, |far| open.min(far * 1e-3)))
}

/// Whether a map is a rotation after scales along the axes: the columns of its linear part are orthogonal, to 1e-6 of
/// their lengths.
pub fn has_orthogonal_columns(map: &Affine) -> bool {
    let Affine { rows } = map;
    let [x, y, z] = [0, 1, 2].map(|at| rows.map(|row| row[at]));
    let right = |a: Vec3, b: Vec3| dot(a, b).abs() <= 1e-6 * length(a) * length(b);
    right(x, y) && right(y, z) && right(x, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Filter;

    fn film(width: u32, height: u32) -> Film {
        Film { width, height, filter: Filter::Box { radius: 0.5 } }
    }

    fn camera() -> Camera {
        Camera {
            name: None,
            eye: [0.0, -160.0, 50.0],
            target: [0.0, 0.0, 50.0],
            up: [0.0, 0.0, 1.0],
            fov_x: 90.0,
            near: None,
            far: None,
        }
    }

    #[test]
    fn the_vertical_angle_follows_the_tangent() {
        // tan 45 degrees is 1: half of it and twice of it, by hand.
        assert!((fov_y(90.0, &film(200, 100)) - 53.130_102_354).abs() < 1e-8);
        assert_eq!(fov_y(90.0, &film(100, 100)), 90.0);
        assert!((fov_y(90.0, &film(100, 200)) - 126.869_897_645).abs() < 1e-8);
    }

    #[test]
    fn the_axes_are_right_handed() {
        let axes = camera().axes().expect("a regular camera");
        assert_eq!(axes.right, [1.0, 0.0, 0.0]);
        assert_eq!((axes.up, axes.forward), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]));
        assert!(Camera { up: [0.0, 3.0, 0.0], ..camera() }.axes().is_none());
    }

    #[test]
    fn clipping_is_written_only_where_the_default_would_cut() {
        let mut scene = crate::formats::shared::sample::room();
        let looking = camera();
        let defaults = (1e-2, 1e4);
        assert_eq!(clipping(&scene, &looking, defaults), (None, None));
        let given = Camera { near: Some(2.0), far: Some(9.0), ..camera() };
        assert_eq!(clipping(&scene, &given, defaults), (Some(2.0), Some(9.0)));
        for (_, shape) in scene.shapes.iter_mut() {
            shape.transform = Affine::scaling([1000.0; 3]);
        }
        let (near, far) = clipping(&scene, &looking, defaults);
        assert!(near.is_none() && far.is_some_and(|far| far > 1.5 * 100_000.0));
        let close = Camera { eye: [0.0, -1.0, 0.5], ..camera() };
        for (_, shape) in scene.shapes.iter_mut() {
            shape.transform = Affine::scaling([0.001; 3]);
        }
        let (near, far) = clipping(&scene, &close, defaults);
        assert!(near.is_some_and(|near| near < 2e-3) && far.is_none());
    }

    #[test]
    fn photons_are_gathered_within_some_pixels() {
        let mut scene = crate::formats::shared::sample::room();
        // The room is a cube of side 100: half its diagonal is 50 times the root of 3.
        assert!((bounding_radius(&scene) - 50.0 * 3.0_f64.sqrt()).abs() < 1e-9);
        scene.film = film(100, 50);
        assert!((photon_radius(&scene) - 2.5 * 3.0_f64.sqrt()).abs() < 1e-9);
        scene.shapes = crate::ir::Arena::default();
        assert_eq!(photon_radius(&scene), 1.0);
    }

    #[test]
    fn shears_are_seen() {
        let shear = Affine { rows: [[1.0, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        assert!(!has_orthogonal_columns(&shear));
        let turned = Affine::scaling([1.0, 2.0, 3.0]).then(&Affine::rotation([0.0, 0.0, 1.0], 30.0));
        assert!(has_orthogonal_columns(&turned));
        // Scales after a rotation shear.
        let other = Affine::rotation([0.0, 0.0, 1.0], 30.0).then(&Affine::scaling([1.0, 2.0, 3.0]));
        assert!(!has_orthogonal_columns(&other));
    }
}
