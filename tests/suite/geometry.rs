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
    file::read("ply", &bytes, None, &mut file::alone).unwrap_or_else(|error| panic!("{}: {error}", path.display())).0
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

/// The water has the statistics of the thesis's surface: mean height 75, deviation 0.056, range 74.73 to 75.25, mean slope 2.7
/// degrees and at most 13.9; power per wave, against that of waves of which fewer than 14 fit into the room: 0.7 (14 to 16),
/// 0.45 (18 to 20), 0.3 (22 to 24), 0.2 (26 to 28), 0.11 (30 to 32).
#[test]
fn the_water_is_as_rough_as_that_of_the_thesis() {
    let surface = load(&root().join("generated/pool_simple/meshes/surface.ply"));
    assert_eq!((surface.positions.len(), surface.triangles.len()), (129 * 129, 32_768));
    let heights: Vec<f64> = surface.positions.iter().map(|p| f64::from(p[2])).collect();
    let count = heights.len() as f64;
    let mean = heights.iter().sum::<f64>() / count;
    let deviation = (heights.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / count).sqrt();
    assert!((mean - 75.0).abs() < 0.002 && (deviation - 0.056).abs() < 0.002, "{mean} {deviation}");
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((74.7..74.85).contains(&low) && (75.15..75.3).contains(&high), "{low} {high}");
    let normals = surface.normals.as_ref().expect("normals");
    let slopes: Vec<f64> = normals.iter().map(|n| f64::from(n[2]).min(1.0).acos().to_degrees()).collect();
    let slope = slopes.iter().sum::<f64>() / count;
    let steepest = slopes.iter().copied().fold(0.0, f64::max);
    assert!((slope - 2.7).abs() < 0.2 && (7.0..14.0).contains(&steepest), "{slope} {steepest}");
    assert!(surface.positions.iter().all(|p| p[1] != -50.0 || p[2] == 75.0), "the water does not meet the pane");

    // The power of the wave (u, v) by a Fourier transform along x and then along y; the last row and column repeat the first.
    let n = 128;
    let turn = |k: usize| (-std::f64::consts::TAU * (k % n) as f64 / n as f64).sin_cos();
    let table: Vec<(f64, f64)> = (0..n).map(turn).collect();
    let transform = |line: &[(f64, f64)]| -> Vec<(f64, f64)> {
        let one = |u: usize| {
            line.iter().enumerate().fold((0.0, 0.0), |(re, im), (at, (a, b))| {
                let (sine, cosine) = table[u * at % n];
                (re + a * cosine - b * sine, im + a * sine + b * cosine)
            })
        };
        (0..n).map(one).collect()
    };
    let rows: Vec<Vec<(f64, f64)>> = (0..n)
        .map(|row| transform(&heights[row * 129..row * 129 + n].iter().map(|z| (z - mean, 0.0)).collect::<Vec<_>>()))
        .collect();
    let columns: Vec<Vec<(f64, f64)>> =
        (0..n).map(|u| transform(&rows.iter().map(|row| row[u]).collect::<Vec<_>>())).collect();
    let frequency = |k: usize| if k > n / 2 { n as f64 - k as f64 } else { k as f64 };
    let power = |from: f64, to: f64| {
        let (mut sum, mut waves) = (0.0, 0.0);
        for (u, column) in columns.iter().enumerate() {
            for (v, (re, im)) in column.iter().enumerate() {
                let radius = frequency(u).hypot(frequency(v));
                if radius >= from && radius < to {
                    sum += re * re + im * im;
                    waves += 1.0;
                }
            }
        }
        sum / waves
    };
    let flat = power(1.0, 14.0);
    for (from, to, wanted) in [(14.0, 20.0, 0.57), (20.0, 26.0, 0.32), (26.0, 32.5, 0.15)] {
        let share = power(from, to) / flat;
        assert!((share / wanted - 1.0).abs() < 0.1, "{from}..{to}: {share} instead of {wanted}");
    }
    assert!(power(34.0, 64.0) / flat < 0.01, "there are shorter waves");
}
