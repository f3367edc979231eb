//! Our meshes against the thesis's own, where they are beside the checkout: area within a relative 1e-3, bounds within 2e-3
//! units, and normals that lean by at most half a degree where vertices meet.

use ltsc_core::mesh::{Geometry, area, bounds, file};

use super::{corpus, root, skip};

/// Scene, our mesh, the thesis's mesh.
const PAIRS: &[(&str, &str, &str)] = &[
    ("cbox_classic", "floor", "WallFloor"),
    ("cbox_classic", "ceiling", "WallCeiling"),
    ("cbox_classic", "back", "WallBack"),
    ("cbox_classic", "left", "WallLeft"),
    ("cbox_classic", "right", "WallRight"),
    ("cbox_classic", "small", "BoxSmall"),
    ("cbox_classic", "tall", "BoxTall"),
    ("cbox_classic", "lamp", "AreaLight"),
    ("cbox_indirect", "wall", "WallVertical"),
    ("cbox_indirect", "shelf", "WallHorizontal"),
    ("cbox_indirect", "big", "BoxBig"),
    ("cbox_indirect", "medium", "BoxMedium"),
    ("cbox_indirect", "small", "BoxSmall"),
    ("cbox_indirect", "lamp", "AreaLight"),
    ("cboxm_diffuse_lsame", "floor", "PlaneFloor"),
    ("cboxm_diffuse_lsame", "ceiling", "PlaneCeiling"),
    ("cboxm_diffuse_lsame", "back", "PlaneBack"),
    ("cboxm_diffuse_lsame", "left", "PlaneLeft"),
    ("cboxm_diffuse_lsame", "right", "PlaneRight"),
    ("cboxm_diffuse_lsame", "floor_2", "WallFloor"),
    ("cboxm_diffuse_lsame", "ceiling_2", "WallCeiling"),
    ("cboxm_diffuse_lsame", "back_2", "WallBack"),
    ("cboxm_diffuse_lsame", "left_2", "WallLeft"),
    ("cboxm_diffuse_lsame", "right_2", "WallRight"),
    ("cboxm_diffuse_lsame", "small", "BoxSmall"),
    ("cboxm_diffuse_lsame", "tall", "BoxTall"),
    ("cboxm_diffuse_lsame", "lamp", "AreaLight"),
    ("ring", "floor", "Floor"),
    ("ring", "ring", "Ring"),
    ("ring", "lamp", "AreaLight"),
    ("veach_mis", "floor", "Floor"),
    ("veach_mis", "wall", "Wall"),
    ("veach_mis", "ball", "UnitSphere"),
];

fn load(path: &std::path::Path) -> Geometry {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    file::read("ply", &bytes, None).unwrap_or_else(|error| panic!("{}: {error}", path.display())).0
}

/// The largest angle in degrees between a normal of `ours` and the best one among those of `theirs` at the same place.
fn lean(ours: &Geometry, theirs: &Geometry) -> f64 {
    let (Some(our_normals), Some(their_normals)) = (&ours.normals, &theirs.normals) else {
        panic!("normals are missing")
    };
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 5e-3);
    let mut worst = 0.0_f64;
    for (place, normal) in ours.positions.iter().zip(our_normals) {
        let here = theirs.positions.iter().zip(their_normals).filter(|(other, _)| near(*place, **other));
        let unit = |n: &[f32; 3]| ltsc_core::ir::normalized(n.map(f64::from)).expect("a normal");
        let cosines = here.map(|(_, other)| ltsc_core::ir::dot(unit(normal), unit(other)));
        if let Some(best) = cosines.reduce(f64::max) {
            worst = worst.max(best.clamp(-1.0, 1.0).acos().to_degrees());
        }
    }
    worst
}

#[test]
fn meshes_are_those_of_the_thesis() {
    let Some(corpus) = corpus() else { return skip("the thesis's meshes", "../shared/corpus/lteval") };
    for (scene, ours, theirs) in PAIRS {
        let mine = load(&root().join(format!("generated/{scene}/meshes/{ours}.ply")));
        let reference = load(&corpus.join(format!("{scene}/meshes/{theirs}.ply")));
        let (a, b) = (area((&mine).into()), area((&reference).into()));
        assert!((a / b - 1.0).abs() < 1e-3, "{scene}/{ours}: area {a} against {b}");
        let (a, b) = (bounds((&mine).into()).expect("bounds"), bounds((&reference).into()).expect("bounds"));
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((a - b).abs() < 2e-3, "{scene}/{ours}: bounds {a} against {b}");
        }
        // The sphere's normals are those of its faces in ours, and nearly so in the thesis's.
        if *ours != "ball" {
            let lean = lean(&mine, &reference);
            assert!(lean < 0.5, "{scene}/{ours}: normals lean by {lean} degrees");
        }
    }
}
