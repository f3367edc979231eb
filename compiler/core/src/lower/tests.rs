//! Lowering keeps what is seen: the triangles in scene space, to single precision, with their fronts.

use proptest::prelude::*;

use super::*;
use crate::diag::Origin;
use crate::ir::*;
use crate::mesh::{Geometry, boxed, largest_normal_deviation, signed_volume, transform_normals};

fn scene() -> Scene {
    Scene {
        name: "test".to_owned(),
        origin: Origin::Made,
        documentation: Documentation::default(),
        meshes: Arena::default(),
        materials: Arena::default(),
        shapes: Arena::default(),
        lights: Arena::default(),
        textures: Arena::default(),
        groups: Arena::default(),
        instances: Arena::default(),
        cameras: Arena::default(),
        film: Film { width: 1, height: 1, filter: Filter::Box { radius: 0.5 } },
        integrator: Integrator::Path { max_depth: 1 },
        sampler: Sampler::Independent { samples: 1, seed: 0 },
    }
}

fn cube() -> Geometry {
    boxed([0.0; 3], [1.0, 2.0, 3.0]).expect("a good box")
}

fn material(scene: &mut Scene, name: &str) -> Handle<Material> {
    let bsdf = Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() };
    scene.materials.push(Material::new(name, bsdf), Origin::Made)
}

fn place(scene: &mut Scene, mesh: Handle<Mesh>, transform: Affine) {
    let name = format!("shape {}", scene.shapes.len());
    let first = scene.materials.iter().next().map(|(handle, _)| handle);
    let material = first.unwrap_or_else(|| material(scene, "white"));
    scene.shapes.push(Shape { name, mesh, transform, material, emission: None }, Origin::Made);
}

/// The triangles of each shape in scene space with the normals of their corners, each triangle from its smallest corner.
fn seen(scene: &Scene) -> Vec<Vec<[[f64; 6]; 3]>> {
    let of = |shape: &Shape| {
        let mesh = &scene.meshes[shape.mesh];
        let normals = mesh.normals.as_ref().expect("normals");
        let normals = transform_normals(normals, &shape.transform);
        let mirrors = shape.transform.determinant() < 0.0;
        let triangle = |corners: &[u32; 3]| {
            let mut corners = corners.map(|index| {
                let [x, y, z] = shape.transform.point(mesh.positions[index as usize].map(f64::from));
                let [a, b, c] = normals[index as usize].map(f64::from);
                [x, y, z, a, b, c]
            });
            if mirrors {
                corners.swap(1, 2);
            }
            corners
        };
        mesh.triangles.iter().map(triangle).collect()
    };
    scene.shapes.values().map(of).collect()
}

fn assert_same_picture(before: &Scene, after: &Scene) {
    let (before, after) = (seen(before), seen(after));
    assert_eq!(before.len(), after.len());
    for (one, other) in before.iter().flatten().flatten().zip(after.iter().flatten().flatten()) {
        for (a, b) in one.iter().zip(other) {
            assert!((a - b).abs() <= 1e-5 * (1.0 + a.abs()), "{one:?} {other:?}");
        }
    }
}

fn turned() -> Affine {
    Affine::rotation([0.0, 0.6, 0.8], 30.0).then(&Affine::translation([1.0, 2.0, 3.0]))
}

#[test]
fn one_use_is_baked_and_several_keep_their_transforms() {
    let mut before = scene();
    let alone = before.meshes.push(cube().into_mesh("alone"), Origin::Made);
    let shared = before.meshes.push(boxed([0.0; 3], [1.0; 3]).expect("a good box").into_mesh("shared"), Origin::Made);
    place(&mut before, alone, turned());
    place(&mut before, shared, turned());
    place(&mut before, shared, Affine::IDENTITY);
    let (after, findings) = lower(before.clone());
    assert_same_picture(&before, &after);
    let transforms: Vec<_> = after.shapes.values().map(|shape| shape.transform).collect();
    assert_eq!(transforms, [Affine::IDENTITY, turned(), Affine::IDENTITY]);
    assert_eq!((after.meshes.len(), findings.len(), findings[0].id), (2, 1, "loss-baked"));
    let (again, findings) = lower(after.clone());
    assert_eq!((again, findings.len()), (after, 0));
}

#[test]
fn mirrored_uses_get_their_own_mesh_and_keep_their_front() {
    let mirror = Affine::scaling([-1.0, 1.0, 1.0]).then(&turned());
    for others in 0..2 {
        let mut before = scene();
        let mesh = before.meshes.push(cube().into_mesh("cube"), Origin::Made);
        place(&mut before, mesh, mirror);
        for _ in 0..others {
            place(&mut before, mesh, turned());
        }
        let (after, _) = lower(before.clone());
        assert_same_picture(&before, &after);
        assert!(after.shapes.values().all(|shape| shape.transform.determinant() > 0.0));
        for mesh in after.meshes.values() {
            assert!((signed_volume(mesh.into()) - 6.0).abs() < 1e-4);
            assert!(largest_normal_deviation(mesh.into()).expect("normals") < 1e-3);
        }
    }
}

#[test]
fn missing_normals_are_those_of_the_faces() {
    let mut before = scene();
    let mut geometry = cube();
    geometry.normals = None;
    geometry.triangles.push([0, 0, 1]);
    let mesh = before.meshes.push(geometry.into_mesh("bare"), Origin::Made);
    place(&mut before, mesh, Affine::IDENTITY);
    let (after, findings) = lower(before);
    let mesh = after.meshes.values().next().expect("one mesh");
    assert_eq!((mesh.name.as_str(), mesh.triangles.len()), ("bare", 12));
    assert_eq!(largest_normal_deviation(mesh.into()), Some(0.0));
    assert_eq!((findings.len(), findings[0].id), (1, "loss-baked"));
    assert!(findings[0].message.contains("`bare`") && findings[0].notes[0].starts_with("1 triangle"));
}

#[test]
fn equal_meshes_become_one_and_unused_things_go() {
    let mut before = scene();
    let unused = before.meshes.push(boxed([0.0; 3], [9.0; 3]).expect("a good box").into_mesh("unused"), Origin::Made);
    let one = before.meshes.push(cube().into_mesh("one"), Origin::Made);
    let two = before.meshes.push(cube().into_mesh("two"), Origin::Made);
    let mut other = cube();
    other.uvs = None;
    let other = before.meshes.push(other.into_mesh("other"), Origin::Made);
    assert_eq!(unused.index(), 0);
    material(&mut before, "first");
    material(&mut before, "unused");
    for mesh in [two, one, other] {
        place(&mut before, mesh, Affine::IDENTITY);
    }
    let (after, findings) = lower(before.clone());
    assert_same_picture(&before, &after);
    let names: Vec<_> = after.meshes.values().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["one", "other"]);
    let meshes: Vec<_> = after.shapes.values().map(|shape| shape.mesh.index()).collect();
    assert_eq!(meshes, [0, 0, 1]);
    assert_eq!((after.materials.len(), findings.len()), (1, 0));
}

#[test]
fn zero_and_minus_zero_are_different_bits() {
    let mut before = scene();
    let flat = |z: f32| Geometry {
        positions: vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]],
        normals: Some(vec![[0.0, 0.0, 1.0]; 3]),
        uvs: None,
        triangles: vec![[0, 1, 2]],
    };
    for z in [0.0, -0.0] {
        let mesh = before.meshes.push(flat(z).into_mesh("flat"), Origin::Made);
        place(&mut before, mesh, Affine::IDENTITY);
    }
    assert_eq!(lower(before).0.meshes.len(), 2);
}

#[test]
fn broken_scenes_pass_through() {
    let mut other = scene();
    other.meshes.push(cube().into_mesh("a"), Origin::Made);
    let beyond = other.meshes.push(cube().into_mesh("b"), Origin::Made);
    let mut broken = scene();
    place(&mut broken, beyond, turned());
    assert_eq!(lower(broken.clone()), (broken, vec![]));

    let mut singular = scene();
    let mesh = singular.meshes.push(cube().into_mesh("a"), Origin::Made);
    place(&mut singular, mesh, Affine::scaling([1.0, 0.0, 1.0]));
    assert_eq!(lower(singular.clone()), (singular, vec![]));

    let mut indices = scene();
    let bad = Geometry { triangles: vec![[0, 1, 2]], ..Geometry::default() };
    let mesh = indices.meshes.push(bad.into_mesh("a"), Origin::Made);
    place(&mut indices, mesh, Affine::IDENTITY);
    assert_eq!(lower(indices.clone()), (indices, vec![]));
}

/// Shapes by their names, each with its triangles as [`seen`] gives them.
type Seen = std::collections::BTreeMap<String, (Shape, Vec<[[f64; 6]; 3]>)>;

/// What is seen with the instances multiplied out.
fn multiplied(scene: &Scene) -> Seen {
    fn add(scene: &Scene, group: &Group, path: &str, outer: &Affine, all: &mut Vec<Shape>) {
        for shape in group.shapes.values() {
            let name = format!("{path}/{}", shape.name);
            all.push(Shape { name, transform: shape.transform.then(outer), ..shape.clone() });
        }
        for instance in group.instances.values() {
            for (name, map) in instance.named() {
                add(scene, &scene.groups[instance.group], &format!("{path}/{name}"), &map.then(outer), all);
            }
        }
    }
    let mut all: Vec<Shape> = scene.shapes.values().cloned().collect();
    for instance in scene.instances.values() {
        for (name, map) in instance.named() {
            add(scene, &scene.groups[instance.group], &name, map, &mut all);
        }
    }
    let mut flat = Scene { shapes: Arena::default(), groups: Arena::default(), ..scene.clone() };
    for shape in &all {
        flat.shapes.push(shape.clone(), Origin::Made);
    }
    all.into_iter().zip(seen(&flat)).map(|(shape, seen)| (shape.name.clone(), (shape, seen))).collect()
}

/// A transform from small numbers; negative ones mirror.
fn transform([sx, sy, sz, ax, ay, degrees, tx, ty, tz]: [i8; 9]) -> Affine {
    let scale = [sx, sy, sz].map(|s| if s == 0 { 1.0 } else { f64::from(s) / 32.0 });
    let axis = normalized([f64::from(ax), f64::from(ay), 1.0]).expect("not zero");
    Affine::scaling(scale)
        .then(&Affine::rotation(axis, f64::from(degrees)))
        .then(&Affine::translation([tx, ty, tz].map(f64::from)))
}

/// A single place, or many.
fn places(maps: &[[i8; 9]]) -> Places {
    match maps {
        [only] => Places::One(transform(*only)),
        maps => Places::Many(maps.iter().map(|map| transform(*map)).collect()),
    }
}

fn group(scene: &mut Scene, name: &str, shapes: Vec<Shape>, inner: &[(Handle<Group>, Places)]) -> Handle<Group> {
    let mut group = Group { name: name.to_owned(), ..Group::default() };
    for shape in shapes {
        group.shapes.push(shape, Origin::Made);
    }
    for (at, (handle, places)) in inner.iter().enumerate() {
        let instance = Instance { name: format!("inner {at}"), group: *handle, places: places.clone() };
        group.instances.push(instance, Origin::Made);
    }
    scene.groups.push(group, Origin::Made)
}

/// A group of a cube and an emitting one, and an instance of it for each transform.
fn lanterns(transforms: &[Affine]) -> Scene {
    let mut scene = scene();
    let mesh = scene.meshes.push(cube().into_mesh("cube"), Origin::Made);
    let white = material(&mut scene, "white");
    let emission = Some(Emission { radiance: Color::Grey(2.0) });
    let shape = |name: &str, emission| {
        let transform = Affine::translation([0.0, 0.0, 5.0]);
        Shape { name: name.to_owned(), mesh, transform, material: white, emission }
    };
    let lantern = group(&mut scene, "lantern", vec![shape("glass", None), shape("lamp", emission)], &[]);
    for (at, transform) in transforms.iter().enumerate() {
        let instance = Instance { name: format!("lantern[{at}]"), group: lantern, places: Places::One(*transform) };
        scene.instances.push(instance, Origin::Made);
    }
    scene
}

#[test]
fn a_group_seen_once_becomes_shapes() {
    let before = lanterns(&[turned()]);
    let (after, _) = lower(before.clone());
    assert!(after.groups.is_empty() && after.instances.is_empty());
    let names: Vec<_> = after.shapes.values().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["lantern[0]/glass", "lantern[0]/lamp"]);
}

#[test]
fn emitters_leave_groups_and_mirrors_get_their_own() {
    let mirror = Affine::scaling([1.0, -1.0, 1.0]);
    let before = lanterns(&[turned(), mirror, Affine::IDENTITY, mirror.then(&turned())]);
    let (after, findings) = lower(before.clone());
    let names: Vec<_> = after.groups.values().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["lantern", "lantern mirrored"]);
    assert_eq!((after.instances.len(), after.shapes.len()), (4, 4));
    assert!(after.shapes.values().all(|shape| shape.emission.is_some()));
    assert!(after.instances.values().all(|instance| instance.places.maps().iter().all(|map| map.determinant() > 0.0)));
    let told: Vec<&str> = findings.iter().map(|finding| finding.message.as_str()).collect();
    assert!(told[0].starts_with("4 emitters") && told[1].starts_with("2 mirroring"), "{told:?}");
}

#[test]
fn many_places_stay_one_instance() {
    let mut before = lanterns(&[]);
    let lantern = before.groups.iter().next().expect("a group").0;
    let maps: Vec<Affine> = (0..5).map(|at| turned().then(&Affine::translation([f64::from(at), 0.0, 0.0]))).collect();
    let places = Places::Many(maps.into());
    let instance = Instance { name: "lantern".to_owned(), group: lantern, places: places.clone() };
    before.instances.push(instance, Origin::Made);
    let (after, _) = lower(before.clone());
    let kept: Vec<_> = after.instances.values().collect();
    assert_eq!((kept.len(), kept[0].name.as_str(), &kept[0].places), (1, "lantern", &places));
    let lamps: Vec<_> = after.shapes.values().map(|shape| shape.name.as_str()).collect();
    assert_eq!(lamps[..2], ["lantern[0]/lamp", "lantern[1]/lamp"]);
    assert_eq!(lamps.len(), 5);
    // One that mirrors among others that do not: each keeps its number.
    let mut mixed = before;
    let one = Affine::scaling([-1.0, 1.0, 1.0]);
    let many = Places::Many([Affine::IDENTITY, one, turned()].into());
    mixed.instances.push(Instance { name: "mixed".to_owned(), group: lantern, places: many }, Origin::Made);
    let (after, _) = lower(mixed);
    let names: Vec<_> = after.instances.values().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["lantern", "mixed[0]", "mixed[2]"], "the mirrored one is seen once and becomes shapes");
}

#[test]
fn too_many_instances_and_broken_groups_pass_through() {
    let mut scene = lanterns(&[turned(), turned()]);
    for _ in 0..10 {
        let last = scene.groups.iter().last().expect("a group").0;
        group(&mut scene, "ten", Vec::new(), &[(last, Places::Many([Affine::IDENTITY; 10].into()))]);
    }
    let last = scene.groups.iter().last().expect("a group").0;
    scene
        .instances
        .push(Instance { name: "all".to_owned(), group: last, places: Places::One(Affine::IDENTITY) }, Origin::Made);
    assert_eq!(lower(scene.clone()), (scene.clone(), vec![]));
    // A group that holds itself.
    let mut circle = lanterns(&[turned(), turned()]);
    let first = circle.groups.iter().next().expect("a group").0;
    let inner = Instance { name: "again".to_owned(), group: first, places: Places::One(Affine::IDENTITY) };
    circle.groups[first].instances.push(inner, Origin::Made);
    assert_eq!(lower(circle.clone()), (circle, vec![]));
}

proptest! {
    #[test]
    fn any_groups_look_the_same(
        shapes in prop::collection::vec((0_usize..4, any::<[i8; 9]>(), any::<bool>()), 4..8),
        inner in prop::collection::vec((0_usize..4, 0_usize..4, prop::collection::vec(any::<[i8; 9]>(), 1..4)), 0..4),
        outer in prop::collection::vec((0_usize..4, prop::collection::vec(any::<[i8; 9]>(), 1..4)), 1..4),
    ) {
        let mut before = scene();
        let mesh = before.meshes.push(cube().into_mesh("cube"), Origin::Made);
        let white = material(&mut before, "white");
        for at in 0..4 {
            let mut own = Vec::new();
            for (n, (_, map, emits)) in shapes.iter().enumerate().filter(|(_, (group, _, _))| *group == at) {
                let emission = emits.then_some(Emission { radiance: Color::Grey(1.0) });
                own.push(Shape { name: format!("s{n}"), mesh, transform: transform(*map), material: white, emission });
            }
            let handles: Vec<_> = before.groups.iter().map(|(handle, _)| handle).collect();
            let held = inner.iter().filter(|(holder, held, _)| *holder == at && *held < at);
            let held: Vec<_> = held.map(|(_, held, maps)| (handles[*held], places(maps))).collect();
            group(&mut before, "g", own, &held);
        }
        let handles: Vec<_> = before.groups.iter().map(|(handle, _)| handle).collect();
        for (n, (at, maps)) in outer.iter().enumerate() {
            let instance = Instance { name: format!("i{n}"), group: handles[*at], places: places(maps) };
            before.instances.push(instance, Origin::Made);
        }
        let (after, _) = lower(before.clone());
        let (expected, found) = (multiplied(&before), multiplied(&after));
        prop_assert_eq!(expected.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
        for (name, (shape, triangles)) in &expected {
            let (other, others) = &found[name];
            prop_assert_eq!(&shape.emission, &other.emission);
            for (a, b) in triangles.as_flattened().as_flattened().iter().zip(others.as_flattened().as_flattened()) {
                prop_assert!((a - b).abs() <= 1e-4 * (1.0 + a.abs()), "{}: {} {}", name, a, b);
            }
        }
        for group in after.groups.values() {
            prop_assert!(group.instances.is_empty() && group.shapes.values().all(|shape| shape.emission.is_none()));
        }
        prop_assert!(after.instances.values().all(|instance| instance.places.maps().iter().all(|map| map.determinant() > 0.0)));
        prop_assert_eq!(lower(after.clone()).0, after);
    }

    #[test]
    fn any_scene_looks_the_same(uses in prop::collection::vec((0_usize..3, any::<[i8; 9]>()), 1..12)) {
        let mut before = scene();
        let meshes: Vec<_> = (1..4).map(|size| {
            // The last two are equal.
            let hi = f64::from(i32::min(size, 2));
            before.meshes.push(boxed([0.0; 3], [hi; 3]).expect("a good box").into_mesh("m"), Origin::Made)
        }).collect();
        for (mesh, map) in uses {
            place(&mut before, meshes[mesh], transform(map));
        }
        let (after, _) = lower(before.clone());
        assert_same_picture(&before, &after);
        for shape in after.shapes.values() {
            prop_assert!(shape.transform.determinant() > 0.0);
        }
        prop_assert_eq!(lower(after.clone()).0, after);
    }
}

#[test]
fn equal_textures_become_one_and_unused_ones_go() {
    let mut scene = scene();
    let mesh = scene.meshes.push(cube().into_mesh("cube"), Origin::Made);
    place(&mut scene, mesh, Affine::IDENTITY);
    let image = ImageInfo { format: ImageFormat::Png, width: 2, height: 2, channels: 3, bits: 8 };
    let mut add = |name: &str, bytes: &[u8], encoding| {
        let texture = Texture {
            name: name.to_owned(),
            file: ImageFile::new(bytes),
            image,
            encoding,
            peak: 1.0,
            factor: [1.0; 3],
        };
        scene.textures.push(texture, Origin::Made)
    };
    let unused = add("unused", b"a", Encoding::Srgb);
    let first = add("first", b"b", Encoding::Srgb);
    let same = add("same", b"b", Encoding::Srgb);
    let linear = add("linear", b"b", Encoding::Linear);
    let scaled = add("scaled", b"b", Encoding::Srgb);
    scene.textures[scaled].factor = [0.5, 1.0, 1.0];
    assert_eq!(unused.index(), 0);
    let (_, shape) = scene.shapes.iter().next().expect("a shape");
    let shape = shape.clone();
    for texture in [first, same, linear, scaled] {
        let bsdf = Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(texture) };
        let material = scene.materials.push(Material::new("m", bsdf), Origin::Made);
        let name = format!("shape {}", texture.index());
        scene.shapes.push(Shape { name, material, ..shape.clone() }, Origin::Made);
    }
    let (lowered, _) = lower(scene);
    let names: Vec<&str> = lowered.textures.values().map(|texture| texture.name.as_str()).collect();
    assert_eq!(names, ["first", "linear", "scaled"]);
    let used: Vec<usize> = lowered
        .materials
        .values()
        .filter_map(|material| material.bsdf.texture())
        .map(|texture| texture.index())
        .collect();
    assert_eq!(used, [0, 0, 1, 2]);
}
