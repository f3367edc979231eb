//! Equal meshes become one, and so do equal textures; meshes, textures and materials that no shape uses go.
//!
//! What is written then depends on what is seen only, not on how the scene came to be.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;

use super::Pass;
use crate::diag::Finding;
use crate::ir::{Arena, ColorOrTexture, Handle, LightKind, LightSource, Material, Mesh, Scene, Shape, Texture};

pub(super) const PASS: Pass = Pass {
    name: "merge",
    summary: "equal meshes and textures become one; unused meshes, textures and materials go",
    run,
};

fn run(mut scene: Scene) -> (Scene, Vec<Finding>) {
    let old_meshes = std::mem::take(&mut scene.meshes);
    let old_materials = std::mem::take(&mut scene.materials);
    let same = representatives(&old_meshes);
    let mut used_meshes = vec![false; old_meshes.len()];
    let mut used_materials = vec![false; old_materials.len()];
    for (_, Shape { name: _, mesh, transform: _, material, emission: _ }) in scene.surfaces() {
        used_meshes[same[mesh.index()]] = true;
        used_materials[material.index()] = true;
    }
    let (meshes, mesh_handles) = kept(&old_meshes, &used_meshes);
    let (mut materials, material_handles) = kept(&old_materials, &used_materials);
    for Shape { name: _, mesh, transform: _, material, emission: _ } in scene.surfaces_mut() {
        if let (Some(new_mesh), Some(new_material)) =
            (mesh_handles[same[mesh.index()]], material_handles[material.index()])
        {
            (*mesh, *material) = (new_mesh, new_material);
        }
    }
    scene.textures = merged_textures(&std::mem::take(&mut scene.textures), &mut materials, &mut scene.lights);
    (scene.meshes, scene.materials) = (meshes, materials);
    (scene, Vec::new())
}

/// The textures that materials and lights use, equal ones once; these are given the new handles.
fn merged_textures(
    old: &Arena<Texture>,
    materials: &mut Arena<Material>,
    lights: &mut Arena<LightSource>,
) -> Arena<Texture> {
    let equal = |one: &Texture, other: &Texture| {
        let Texture { name: _, file, image, encoding, peak: _, factor } = one;
        *factor == other.factor && *encoding == other.encoding && *image == other.image && *file == other.file
    };
    let all: Vec<&Texture> = old.values().collect();
    let same: Vec<usize> = all
        .iter()
        .enumerate()
        .map(|(at, one)| all[..at].iter().position(|other| equal(one, other)).unwrap_or(at))
        .collect();
    let mut used = vec![false; all.len()];
    for Material { name: _, bsdf, sides: _ } in materials.values() {
        if let Some(texture) = bsdf.texture() {
            used[same[texture.index()]] = true;
        }
    }
    for texture in lights.values().filter_map(|light| light.kind.texture()) {
        used[same[texture.index()]] = true;
    }
    let (textures, handles) = kept(old, &used);
    for (_, Material { name: _, bsdf, sides: _ }) in materials.iter_mut() {
        if let Some(new) = bsdf.texture().and_then(|texture| handles[same[texture.index()]]) {
            *bsdf = bsdf.with_texture(new);
        }
    }
    for (_, LightSource { name: _, kind }) in lights.iter_mut() {
        let new = kind.texture().and_then(|texture| handles[same[texture.index()]]);
        if let (Some(new), LightKind::Environment { radiance, tint: _, turn: _ }) = (new, kind) {
            *radiance = ColorOrTexture::Texture(new);
        }
    }
    textures
}

/// The marked items in their order, and for each old position the new handle.
fn kept<T: Clone>(old: &Arena<T>, used: &[bool]) -> (Arena<T>, Vec<Option<Handle<T>>>) {
    let mut new = Arena::default();
    let handles = old
        .iter()
        .map(|(handle, item)| used[handle.index()].then(|| new.push(item.clone(), old.origin(handle).clone())))
        .collect();
    (new, handles)
}

/// For each mesh the position of the first one that is equal to it.
fn representatives(meshes: &Arena<Mesh>) -> Vec<usize> {
    let all: Vec<&Mesh> = meshes.values().collect();
    let mut by_counts: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (at, mesh) in all.iter().enumerate() {
        by_counts.entry([mesh.positions.len(), mesh.triangles.len()]).or_default().push(at);
    }
    let mut same: Vec<usize> = (0..all.len()).collect();
    for candidates in by_counts.values().filter(|candidates| candidates.len() > 1) {
        // The hash only chooses what is compared; the result does not depend on it.
        let mut by_hash: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        for at in candidates {
            let firsts = by_hash.entry(hash(all[*at])).or_default();
            match firsts.iter().find(|first| equal(all[**first], all[*at])) {
                Some(first) => same[*at] = *first,
                None => firsts.push(*at),
            }
        }
    }
    same
}

fn hash(mesh: &Mesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    for coordinate in mesh.positions.as_flattened() {
        hasher.write_u32(coordinate.to_bits());
    }
    for index in mesh.triangles.as_flattened() {
        hasher.write_u32(*index);
    }
    hasher.finish()
}

/// Whether all arrays are equal to the bit. Names do not count.
fn equal(one: &Mesh, other: &Mesh) -> bool {
    let Mesh { name: _, positions, normals, uvs, triangles } = one;
    same_bits(positions, &other.positions)
        && match (normals, &other.normals) {
            (Some(one), Some(other)) => same_bits(one, other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        }
        && match (uvs, &other.uvs) {
            (Some(one), Some(other)) => same_bits(one, other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        }
        && (Arc::ptr_eq(triangles, &other.triangles) || triangles == &other.triangles)
}

fn same_bits<const N: usize>(one: &Arc<Vec<[f32; N]>>, other: &Arc<Vec<[f32; N]>>) -> bool {
    let bits = |all: &Arc<Vec<[f32; N]>>| all.as_flattened().len();
    Arc::ptr_eq(one, other)
        || (bits(one) == bits(other)
            && one.as_flattened().iter().zip(other.as_flattened()).all(|(a, b)| a.to_bits() == b.to_bits()))
}
