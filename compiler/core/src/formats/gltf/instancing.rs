//! EXT_mesh_gpu_instancing: one node for all uses of a mesh, whose places lie in the buffer.

use std::collections::{BTreeMap, BTreeSet};

use super::buffer::Layout;
use super::document as doc;
use crate::ir::{cross, dot, length};

/// The name of the extension.
pub const NAME: &str = "EXT_mesh_gpu_instancing";

/// A translation, a rotation as a quaternion (x, y, z, w), and scales along the axes, applied from the last to the first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trs {
    translation: [f32; 3],
    rotation: [f32; 4],
    scale: [f32; 3],
}

/// The nodes with those of a mesh that is used more than once drawn together into one, at the place of the first.
pub fn gather(nodes: Vec<doc::Node>, layout: &mut Layout<'_>) -> Vec<doc::Node> {
    let mut uses: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, node) in nodes.iter().enumerate() {
        if let Some(mesh) = node.mesh {
            uses.entry(mesh).or_default().push(at);
        }
    }
    uses.retain(|_, places| places.len() > 1);
    let mut instanced: BTreeMap<usize, doc::Node> = BTreeMap::new();
    for (mesh, places) in &uses {
        let all: Vec<Trs> = places.iter().map(|at| trs(&nodes[*at])).collect();
        let translation = layout.floats(all.iter().map(|trs| trs.translation).collect(), "VEC3");
        let turned = all.iter().any(|trs| trs.rotation != [0.0, 0.0, 0.0, 1.0]);
        let rotation = turned.then(|| layout.floats(all.iter().map(|trs| trs.rotation).collect(), "VEC4"));
        let scaled = all.iter().any(|trs| trs.scale != [1.0; 3]);
        let scale = scaled.then(|| layout.floats(all.iter().map(|trs| trs.scale).collect(), "VEC3"));
        let attributes = doc::Placement { translation, rotation, scale };
        let names = places.iter().map(|at| nodes[*at].name.clone()).collect();
        let node = doc::Node {
            name: nodes[places[0]].name.clone(),
            mesh: Some(*mesh),
            extensions: Some(doc::NodeExtensions {
                instancing: Some(doc::Instancing { attributes }),
                ..doc::NodeExtensions::default()
            }),
            extras: Some(doc::Names { names }),
            ..doc::Node::default()
        };
        instanced.insert(places[0], node);
    }
    let gone: BTreeSet<usize> = uses.values().flat_map(|places| &places[1..]).copied().collect();
    let kept = nodes.into_iter().enumerate().filter(|(at, _)| !gone.contains(at));
    kept.map(|(at, node)| instanced.remove(&at).unwrap_or(node)).collect()
}

/// The place of a node, whose matrix has orthogonal columns and does not mirror.
fn trs(node: &doc::Node) -> Trs {
    let single = |values: [f64; 3]| values.map(|x| x as f32 + 0.0);
    let Some(matrix) = node.matrix else {
        let translation = single(node.translation.unwrap_or_default());
        return Trs { translation, rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
    };
    let column = |at: usize| [matrix[at * 4], matrix[at * 4 + 1], matrix[at * 4 + 2]];
    let columns = [column(0), column(1), column(2)];
    let scale = columns.map(length);
    let axes = [0, 1, 2].map(|at| columns[at].map(|x| x / scale[at]));
    Trs { translation: single(column(3)), rotation: quaternion(axes), scale: single(scale) }
}

/// The rotation that takes the axes of coordinates to `axes` (Shepperd, "Quaternion from rotation matrix", 1978: the largest
/// of the four numbers comes from a root, the others from it).
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> [f32; 4] {
    debug_assert!(dot(cross(x, y), z) > 0.0, "a rotation does not mirror");
    let squares =
        [1.0 + x[0] - y[1] - z[2], 1.0 - x[0] + y[1] - z[2], 1.0 - x[0] - y[1] + z[2], 1.0 + x[0] + y[1] + z[2]];
    let largest = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(3);
    let products = match largest {
        0 => [squares[0], x[1] + y[0], z[0] + x[2], y[2] - z[1]],
        1 => [x[1] + y[0], squares[1], y[2] + z[1], z[0] - x[2]],
        2 => [z[0] + x[2], y[2] + z[1], squares[2], x[1] - y[0]],
        _ => [y[2] - z[1], z[0] - x[2], x[1] - y[0], squares[3]],
    };
    let size = products.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Of the two quaternions of a rotation the one with w >= 0, so that the same rotation has the same bytes.
    let sign = if products[3] < 0.0 { -1.0 } else { 1.0 };
    products.map(|x| (sign * x / size) as f32 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::names;
    use super::*;
    use crate::ir::{Affine, Vec3, normalized};

    /// What a reader does with a placement: v -> t + q (s v) q*.
    fn applied(Trs { translation, rotation, scale }: Trs, point: Vec3) -> Vec3 {
        let [x, y, z, w] = rotation.map(f64::from);
        let v = [0, 1, 2].map(|axis| point[axis] * f64::from(scale[axis]));
        let u = [x, y, z];
        let a = cross(u, v);
        let b = cross(u, [0, 1, 2].map(|axis| a[axis] + w * v[axis]));
        [0, 1, 2].map(|axis| v[axis] + 2.0 * b[axis] + f64::from(translation[axis]))
    }

    #[test]
    fn places_take_points_where_matrices_do() {
        for axis in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.5, 0.8], [-0.9, 0.1, 0.0]] {
            let axis = normalized(axis).expect("an axis");
            for degrees in [0.0, 17.5, 90.0, 120.0, 180.0, 270.0, 359.0] {
                let map = Affine::scaling([1.0, 2.5, 0.3])
                    .then(&Affine::rotation(axis, degrees))
                    .then(&Affine::translation([4.0, -5.0, 6.0]));
                let node = doc::Node { matrix: Some(names::matrix(&map)), ..doc::Node::default() };
                let place = trs(&node);
                for point in [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, -0.7, 0.9]] {
                    let (there, expected) = (applied(place, point), map.point(point));
                    let far = there.iter().zip(expected).any(|(a, b)| (a - b).abs() > 2e-6);
                    assert!(!far, "{axis:?} {degrees}: {there:?} {expected:?}");
                }
            }
        }
        let moved = doc::Node { translation: Some([1.0, 2.0, 3.0]), ..doc::Node::default() };
        assert_eq!(applied(trs(&moved), [0.5; 3]), [1.5, 2.5, 3.5]);
    }
}
