//! Meshes that move, at rest: morph targets with the weights of their node, skins with their joints where nodes stand.

use super::super::FileError;
use super::accessor::Buffers;
use super::document::Item;
use crate::ir::{Affine, normalized};

/// The displacements of a primitive by its morph targets.
#[derive(Default)]
pub struct Morph {
    pub positions: Option<Vec<[f32; 3]>>,
    pub normals: Option<Vec<[f32; 3]>>,
    pub uvs: Option<Vec<[f32; 2]>>,
}

/// The weights of the morph targets of a mesh at a node (glTF 2.0, 3.7.2.2): the node's, else the mesh's, else zeros.
pub fn weights(node: Item<'_>, mesh: Item<'_>) -> Vec<f64> {
    let own = [node, mesh].into_iter().find_map(|item| item.get("weights")?.as_array());
    own.into_iter().flatten().map(|weight| weight.as_f64().unwrap_or(0.0)).collect()
}

/// What the targets of a primitive add to its vertices; none where no weight is other than 0.
pub fn morph(
    primitive: Item<'_>,
    weights: &[f64],
    uv: &str,
    count: usize,
    buffers: &Buffers<'_, '_>,
) -> Result<Option<Morph>, FileError> {
    let mut made = Morph::default();
    let mut any = false;
    for (target, weight) in primitive.objects("targets").zip(weights).filter(|(_, weight)| **weight != 0.0) {
        any = true;
        if let Some(at) = target.count("POSITION") {
            add(&mut made.positions, buffers.vectors::<3>(at)?, *weight, count)?;
        }
        if let Some(at) = target.count("NORMAL") {
            add(&mut made.normals, buffers.vectors::<3>(at)?, *weight, count)?;
        }
        if let Some(at) = target.count(uv) {
            add(&mut made.uvs, buffers.vectors::<2>(at)?, *weight, count)?;
        }
    }
    Ok(any.then_some(made))
}

fn add<const N: usize>(
    sum: &mut Option<Vec<[f32; N]>>,
    by: Vec<[f32; N]>,
    weight: f64,
    count: usize,
) -> Result<(), FileError> {
    if by.len() != count {
        return Err(FileError::new("", format!("it has {count} positions and a morph target of {}", by.len())));
    }
    let sum = sum.get_or_insert_with(|| vec![[0.0; N]; count]);
    for (sum, by) in sum.iter_mut().zip(by) {
        for (sum, by) in sum.iter_mut().zip(by) {
            *sum = (f64::from(*sum) + weight * f64::from(by)) as f32;
        }
    }
    Ok(())
}

/// Adds what a morph says.
pub fn displace<const N: usize>(all: &mut [[f32; N]], by: Option<&Vec<[f32; N]>>) {
    for (one, by) in all.iter_mut().zip(by.into_iter().flatten()) {
        for (one, by) in one.iter_mut().zip(by) {
            *one += by;
        }
    }
}

/// Brings vectors to unit length that have one.
pub fn straighten(all: &mut [[f32; 3]]) {
    for one in all {
        if let Some(unit) = normalized(one.map(f64::from)) {
            *one = unit.map(|x| x as f32);
        }
    }
}

/// The maps of a skin's joints, from the mesh as it was bound to the file's coordinates turned to z up.
///
/// # Errors
/// Joints that are not there, and too few matrices.
pub fn joints(skin: Item<'_>, maps: &[Option<Affine>], buffers: &Buffers<'_, '_>) -> Result<Vec<Affine>, FileError> {
    let wrong = |message: String| FileError::new(skin.place(), message);
    let joints = skin.counts("joints");
    let bound = match skin.get("inverseBindMatrices") {
        None => None,
        Some(_) => {
            let at = skin.count("inverseBindMatrices").ok_or_else(|| wrong("an index points to nothing".to_owned()))?;
            Some(buffers.vectors::<16>(at)?)
        }
    };
    if let Some(bound) = bound.as_ref().filter(|bound| bound.len() < joints.len()) {
        return Err(wrong(format!("it has {} joints and {} inverse bind matrices", joints.len(), bound.len())));
    }
    buffers.afford(96 * joints.len() as u64)?;
    let map = |(place, joint): (usize, usize)| {
        let stands = maps.get(joint).copied().flatten();
        let stands = stands.ok_or_else(|| wrong(format!("its joint is node {joint}, which is not there")))?;
        let inverse = bound.as_ref().map_or(Affine::IDENTITY, |bound| {
            let all = bound[place].map(f64::from);
            Affine { rows: [0, 1, 2].map(|row| [all[row], all[4 + row], all[8 + row], all[12 + row]]) }
        });
        Ok(inverse.then(&stands))
    };
    joints.into_iter().enumerate().map(map).collect()
}

/// Sets of joints and weights of a primitive that are read: four joints for each.
const SETS: usize = 8;

/// Moves vertices and normals by the joints that they hang on, and says whether those mirror; none where the primitive names none.
pub fn skinned(
    primitive: Item<'_>,
    joints: &[Affine],
    positions: &mut [[f32; 3]],
    normals: Option<&mut Vec<[f32; 3]>>,
    buffers: &Buffers<'_, '_>,
) -> Result<Option<bool>, FileError> {
    let Some(attributes) = primitive.inner("attributes") else { return Ok(None) };
    let mut sets = Vec::new();
    for set in 0..SETS {
        let at = |name: &str| attributes.count(&format!("{name}_{set}"));
        let (Some(bones), Some(shares)) = (at("JOINTS"), at("WEIGHTS")) else { break };
        let (bones, shares) = (buffers.whole::<4>(bones)?, buffers.vectors::<4>(shares)?);
        if bones.len() != positions.len() || shares.len() != positions.len() {
            let message = format!(
                "it has {} positions and {} joints with {} weights",
                positions.len(),
                bones.len(),
                shares.len()
            );
            return Err(FileError::new("", message));
        }
        sets.push((bones, shares));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let mut normals = normals;
    let mut mirrored = 0_usize;
    for (at, position) in positions.iter_mut().enumerate() {
        let mut rows = [[0.0; 4]; 3];
        let mut sum = 0.0;
        for (bones, shares) in &sets {
            for (bone, share) in bones[at].iter().zip(shares[at]).filter(|(_, share)| *share != 0.0) {
                let Some(joint) = joints.get(*bone as usize) else {
                    let message = format!("vertex {at} hangs on joint {bone}, but the skin has {}", joints.len());
                    return Err(FileError::new("", message));
                };
                let share = f64::from(share);
                sum += share;
                for (row, own) in rows.iter_mut().zip(joint.rows) {
                    for (sum, own) in row.iter_mut().zip(own) {
                        *sum += share * own;
                    }
                }
            }
        }
        // Weights that were rounded do not add up to 1 exactly; a vertex without any stays with the first joint.
        let map = if sum != 0.0 {
            Affine { rows: rows.map(|row| row.map(|x| x / sum)) }
        } else {
            joints.first().copied().unwrap_or(Affine::IDENTITY)
        };
        let sign = if map.determinant() < 0.0 { -1.0 } else { 1.0 };
        mirrored += usize::from(sign < 0.0);
        *position = map.point(position.map(f64::from)).map(|x| x as f32);
        if let Some(normal) = normals.as_mut().and_then(|normals| normals.get_mut(at)) {
            let cofactors = map.cofactors();
            let turned = cofactors.map(|row| crate::ir::dot(row, normal.map(f64::from)));
            if let Some(unit) = normalized(turned.map(|x| sign * x)) {
                *normal = unit.map(|x| x as f32);
            }
        }
    }
    Ok(Some(2 * mirrored > positions.len()))
}
