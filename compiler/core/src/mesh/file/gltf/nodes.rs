//! The tree of nodes: what holds what, and where it stands.

use super::super::FileError;
use super::document::Item;
use crate::ir::{Affine, normalized};

/// From y up to z up.
pub const UPRIGHT: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]] };

/// Goes through all nodes below `roots`, parents first. `visit` is given a node, its map to the file's coordinates turned to z up,
/// and what it returned for the parent (`start` for roots); none of it passes over a node's children.
///
/// # Errors
/// What `visit` returns, a node that is not there, and one that lies in two places.
pub fn walk<'v, S: Clone>(
    nodes: &[Item<'v>],
    roots: &[usize],
    start: S,
    mut visit: impl FnMut(Item<'v>, &Affine, S) -> Result<Option<S>, FileError>,
) -> Result<(), FileError> {
    let mut seen = vec![false; nodes.len()];
    // A stack: trees may be deep.
    let mut open: Vec<(usize, Affine, S)> = roots.iter().rev().map(|at| (*at, UPRIGHT, start.clone())).collect();
    while let Some((at, outer, state)) = open.pop() {
        let (Some(node), Some(seen)) = (nodes.get(at), seen.get_mut(at)) else {
            return Err(FileError::new(format!("/nodes/{at}"), "the node is not there: an index points to nothing"));
        };
        if std::mem::replace(seen, true) {
            return Err(FileError::new(format!("/nodes/{at}"), "it lies in two places, or within itself"));
        }
        let map = local(*node).then(&outer);
        if let Some(state) = visit(*node, &map, state)? {
            open.extend(node.counts("children").into_iter().rev().map(|child| (child, map, state.clone())));
        }
    }
    Ok(())
}

/// The maps of all nodes to the file's coordinates turned to z up, whatever scene they are in; none of those in a circle.
pub fn maps(nodes: &[Item<'_>]) -> Vec<Option<Affine>> {
    let mut parents = vec![None; nodes.len()];
    for (at, node) in nodes.iter().enumerate() {
        for child in node.counts("children") {
            if let Some(parent) = parents.get_mut(child) {
                *parent = Some(at);
            }
        }
    }
    let mut maps: Vec<Option<Affine>> = vec![None; nodes.len()];
    let mut children = vec![Vec::new(); nodes.len()];
    let mut open = Vec::new();
    for (at, parent) in parents.iter().enumerate() {
        match parent {
            Some(parent) => children[*parent].push(at),
            None => open.push((at, UPRIGHT)),
        }
    }
    while let Some((at, outer)) = open.pop() {
        let map = local(nodes[at]).then(&outer);
        maps[at] = Some(map);
        open.extend(children[at].iter().map(|child| (*child, map)));
    }
    maps
}

/// The map of a node: a matrix by columns, or scale, rotation and translation in this order.
pub fn local(node: Item<'_>) -> Affine {
    if let Some(all) = node.row::<16>("matrix") {
        return Affine { rows: [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]]) };
    }
    let scale = node.row::<3>("scale").map_or(Affine::IDENTITY, Affine::scaling);
    let turn = node.row::<4>("rotation").map_or(Affine::IDENTITY, turned_by);
    let offset = node.row::<3>("translation").map_or(Affine::IDENTITY, Affine::translation);
    scale.then(&turn).then(&offset)
}

/// The rotation of a quaternion (x, y, z, w), whatever its length.
pub fn turned_by(quaternion: [f64; 4]) -> Affine {
    let size = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    if normalized([quaternion[0], quaternion[1], quaternion[2]]).is_none() || !size.is_finite() {
        return Affine::IDENTITY;
    }
    let [x, y, z, w] = quaternion.map(|part| part / size);
    Affine {
        rows: [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), 0.0],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), 0.0],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), 0.0],
        ],
    }
}

/// The places of EXT_mesh_gpu_instancing, in the coordinates of the node.
pub fn instances(extension: Item<'_>, buffers: &super::accessor::Buffers<'_, '_>) -> Result<Vec<Affine>, FileError> {
    let wrong =
        |message: &str| FileError::new(format!("{}/extensions/EXT_mesh_gpu_instancing", extension.place()), message);
    let attributes = extension.inner("attributes").ok_or_else(|| wrong("the instances have no attributes"))?;
    let (mut moved, mut scaled, mut turned) = (None, None, None);
    let mut counts = Vec::new();
    for name in attributes.keys() {
        let at = attributes.count(name).ok_or_else(|| wrong("an index points to nothing"))?;
        match name {
            "TRANSLATION" => moved = Some(buffers.vectors::<3>(at)?),
            "SCALE" => scaled = Some(buffers.vectors::<3>(at)?),
            "ROTATION" => turned = Some(buffers.vectors::<4>(at)?),
            // Attributes of applications, such as colors.
            _ => {}
        }
        counts.push(buffers.count(at));
    }
    let count = counts.first().copied().unwrap_or(0);
    if counts.iter().any(|other| *other != count) {
        return Err(wrong("the instances have not as many places as turns and scales"));
    }
    buffers.afford(96 * count as u64)?;
    let place = |at: usize| {
        let single = |all: &Option<Vec<[f32; 3]>>, default: f64| {
            all.as_ref().and_then(|all| all.get(at)).map_or([default; 3], |row| row.map(f64::from))
        };
        let turn =
            turned.as_ref().and_then(|all| all.get(at)).map_or(Affine::IDENTITY, |row| turned_by(row.map(f64::from)));
        Affine::scaling(single(&scaled, 1.0)).then(&turn).then(&Affine::translation(single(&moved, 0.0)))
    };
    Ok((0..count).map(place).collect())
}
