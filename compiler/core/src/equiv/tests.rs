//! Each kind of difference is seen where one number is changed, and nothing where the scene is only written otherwise.

use std::sync::Arc;

use super::*;
use crate::diag::{Finding, Origin, Severity};
use crate::formats::shared::sample;
use crate::ir::{
    Affine, Arena, Bsdf, Color, Emission, Filter, Group, Instance, Integrator, LightKind, LightSource, Mesh, Places,
    Sampler, Shape, Sides,
};

fn compared(a: &Scene, b: &Scene) -> Comparison {
    let side = |scene| Side { scene, findings: &[] };
    compare(side(a), side(b), TOLERANCE)
}

/// What differs: kind, words, number of places.
fn told(a: &Scene, b: &Scene) -> Vec<(Kind, String, usize)> {
    let rows = compared(a, b).differences.into_iter();
    rows.map(|difference| (difference.kind, difference.what, difference.places.len())).collect()
}

/// The only difference of the room and a changed one.
fn planted(change: impl FnOnce(&mut Scene)) -> (Kind, String) {
    let room = sample::room();
    let mut other = room.clone();
    change(&mut other);
    let mut all = told(&room, &other);
    assert_eq!(all.len(), 1, "{all:#?}");
    let back = told(&other, &room);
    assert_eq!(back.len(), 1, "{back:#?}");
    let (kind, what, places) = all.remove(0);
    assert_eq!(places, 1);
    (kind, what)
}

fn shape<'s>(scene: &'s mut Scene, name: &str) -> &'s mut Shape {
    scene.shapes.iter_mut().map(|(_, shape)| shape).find(|shape| shape.name == name).expect("a shape")
}

fn mesh<'s>(scene: &'s mut Scene, name: &str) -> &'s mut Mesh {
    let handle = shape(scene, name).mesh;
    &mut scene.meshes[handle]
}

fn camera(scene: &mut Scene) -> &mut crate::ir::Camera {
    scene.cameras.iter_mut().map(|(_, camera)| camera).next().expect("a camera")
}

#[test]
fn a_scene_is_as_itself() {
    for scene in [sample::room(), sample::grid()] {
        let comparison = compared(&scene, &scene);
        assert!(comparison.equal(), "{comparison:#?}");
        assert_eq!(comparison.surfaces, [comparison.found; 2]);
    }
}

/// What differs where a scene is changed.
type Planted = (&'static str, fn(&mut Scene));

#[test]
fn settings_are_seen() {
    let cases: [Planted; 11] = [
        ("camera position", |scene| {
            camera(scene).eye[0] += 0.2;
            camera(scene).target[0] += 0.2;
        }),
        ("camera horizontal field of view", |scene| camera(scene).fov_x = 45.1),
        ("camera up", |scene| camera(scene).up = [0.01, 0.0, 1.0]),
        ("near clipping", |scene| camera(scene).near = Some(150.0)),
        ("image size", |scene| scene.film.width += 1),
        ("box radius", |scene| scene.film.filter = Filter::Box { radius: 0.6 }),
        ("kind", |scene| scene.film.filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 }),
        ("integrator max_depth", |scene| scene.integrator = Integrator::Path { max_depth: 11 }),
        ("integrator algorithm", |scene| scene.integrator = Integrator::LightTracing { max_depth: 10 }),
        ("sampler samples", |scene| scene.sampler = Sampler::Independent { samples: 33, seed: 0 }),
        ("sampler kind", |scene| scene.sampler = Sampler::Sobol { samples: 32, seed: 0 }),
    ];
    for (what, change) in cases {
        assert_eq!(planted(change).1, what);
    }
    // The target may lie anywhere on the axis, and the direction up needs no unit length; a clipping plane that cuts nothing is none.
    let (room, mut other) = (sample::room(), sample::room());
    camera(&mut other).target = [0.0, 40.0, 50.0];
    camera(&mut other).up = [0.0, 0.5, 7.0];
    camera(&mut other).near = Some(1.0);
    camera(&mut other).far = Some(1e4);
    camera(&mut other).name = Some("main".to_owned());
    assert_eq!(told(&room, &other), []);
}

#[test]
fn materials_and_light_are_seen() {
    let first = |scene: &mut Scene, bsdf| scene.materials.iter_mut().next().expect("a material").1.bsdf = bsdf;
    let room = sample::room();
    let mut other = room.clone();
    first(&mut other, sample::diffuse([0.99, 1.0, 1.0]));
    assert_eq!(told(&room, &other), [(Kind::Material, "diffuse reflectance".to_owned(), 3)], "floor, ceiling, back");
    first(&mut other, Bsdf::Mirror { reflectance: Color::Grey(1.0) });
    assert_eq!(told(&room, &other), [(Kind::Material, "kind".to_owned(), 3)]);
    let mut glass = room.clone();
    first(&mut glass, Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.0 });
    first(&mut other, Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.01 });
    assert_eq!(told(&glass, &other), [(Kind::Material, "dielectric alpha".to_owned(), 3)]);
    // Another spelling of one color, and a black of another kind.
    first(&mut other, Bsdf::Diffuse { reflectance: Color::Rgb([1.0, 0.99999, 1.0]).into() });
    let black = other.materials.iter_mut().last().expect("black").1;
    black.bsdf = Bsdf::Mirror { reflectance: Color::BLACK };
    assert_eq!(told(&room, &other), []);

    let lamp = |radiance| move |scene: &mut Scene| shape(scene, "lamp").emission = radiance;
    let radiance = (Kind::Emission, "radiance".to_owned());
    assert_eq!(planted(lamp(Some(Emission { radiance: Color::Grey(30.1) }))), radiance);
    assert_eq!(planted(lamp(None)), radiance);
    assert_eq!(planted(|scene| turn(mesh(scene, "lamp"))).1, "side");
    assert_eq!(planted(|scene| turn(mesh(scene, "lamp"))).0, Kind::Emission);
}

/// Turns a surface over, its normals too.
fn turn(mesh: &mut Mesh) {
    let turned = mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]);
    mesh.triangles = Arc::new(turned.collect());
    let normals = mesh.normals.as_ref().map(|all| all.iter().map(|normal| normal.map(|x| -x)).collect());
    mesh.normals = normals.map(Arc::new);
}

#[test]
fn what_scatters_on_both_sides_has_no_side_but_glass_has() {
    let (mut room, mut other) = (sample::room(), sample::room());
    turn(mesh(&mut other, "floor"));
    assert_eq!(told(&room, &other), []);
    let glass = Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.0 };
    for scene in [&mut room, &mut other] {
        scene.materials.iter_mut().next().expect("a material").1.bsdf = glass.clone();
    }
    assert_eq!(told(&room, &other), [(Kind::Material, "dielectric side of the inside".to_owned(), 1)]);
    // Turned over, and inside out.
    let inside_out = Bsdf::Dielectric { interior: 1.0, exterior: 1.5, alpha: 0.0 };
    let material = sample::material(&mut other, "other glass", inside_out);
    shape(&mut other, "floor").material = material;
    assert_eq!(told(&room, &other), []);
}

#[test]
fn places_are_seen() {
    let moved = |scene: &mut Scene| shape(scene, "small").transform = Affine::translation([0.0, 0.0, 0.1]);
    assert_eq!(planted(moved), (Kind::Surface, "moved by (0, 0, 0.1)".to_owned()));
    let place = Affine::translation([-17.0, 10.0, 0.0])
        .then(&Affine::rotation([0.0, 0.0, 1.0], 10.0))
        .then(&Affine::translation([17.0, -10.0, 0.0]));
    let turned = |scene: &mut Scene| shape(scene, "small").transform = place;
    assert_eq!(planted(turned).1, "turned, or another form");
    let larger = |scene: &mut Scene| shape(scene, "small").transform = Affine::scaling([1.0, 1.0, 1.1]);
    assert_eq!(planted(larger).1, "another form");
    let corner = |scene: &mut Scene| {
        let mesh = mesh(scene, "tall");
        let mut positions = mesh.positions.to_vec();
        positions[0][0] += 0.5;
        mesh.positions = Arc::new(positions);
    };
    assert_eq!(planted(corner).1, "corners up to 0.5 apart");
    let smooth = |scene: &mut Scene| mesh(scene, "tall").normals = Some(Arc::new(vec![[0.0, 0.0, 1.0]; 24]));
    assert_eq!(planted(smooth), (Kind::Surface, "shading normals".to_owned()));
    let flat = |scene: &mut Scene| mesh(scene, "tall").normals = None;
    assert_eq!(
        told(&sample::room(), &{
            let mut other = sample::room();
            flat(&mut other);
            other
        }),
        []
    );
    let (room, mut other) = (sample::room(), sample::room());
    let material = shape(&mut other, "small").material;
    let more = sample::block(&mut other, "more", [1.0; 3], [0.0, 0.0, 50.0], 0.0);
    sample::shape(&mut other, "more", more, material, None);
    assert_eq!(told(&room, &other), [(Kind::Surface, "only in B".to_owned(), 1)]);
    assert_eq!(told(&other, &room), [(Kind::Surface, "only in A".to_owned(), 1)]);
}

#[test]
fn places_of_instances_are_seen_and_groups_are_not() {
    let grid = sample::grid();
    let mut other = grid.clone();
    let (_, instance) = other.instances.iter_mut().nth(1).expect("an instance");
    instance.places = Places::One(instance.places.maps()[0].then(&Affine::translation([0.0, 0.25, 0.0])));
    assert_eq!(told(&grid, &other), [(Kind::Surface, "moved by (0, 0.25, 0)".to_owned(), 2)]);
    assert_eq!(told(&grid, &flattened(&grid)), []);
    assert_eq!(told(&flattened(&other), &grid), [(Kind::Surface, "moved by (0, -0.25, 0)".to_owned(), 2)]);
}

/// The same without groups, each mesh baked in its place, its triangles and vertices in the reverse order, all under other names, and all
/// shapes in the reverse order.
fn flattened(scene: &Scene) -> Scene {
    let survey = Survey::of(scene);
    let mut other = Scene { shapes: Arena::default(), instances: Arena::default(), ..scene.clone() };
    other.name = "renamed".to_owned();
    for (at, placed) in survey.placed.iter().enumerate().rev() {
        let mut mesh = scene.meshes[placed.shape.mesh].clone();
        let last = mesh.positions.len() as u32 - 1;
        let point = |p: &[f32; 3]| placed.transform.point(p.map(f64::from)).map(|x| x as f32);
        mesh.positions = Arc::new(mesh.positions.iter().rev().map(point).collect());
        // What is flat has the normals of its triangles.
        mesh.normals = None;
        mesh.triangles =
            Arc::new(mesh.triangles.iter().rev().map(|t| [t[1], t[2], t[0]].map(|at| last - at)).collect());
        let mesh = other.meshes.push(mesh, Origin::Made);
        let copy = scene.materials[placed.shape.material].clone();
        let material = sample::material(&mut other, &format!("m{at}"), copy.bsdf);
        sample::shape(&mut other, &format!("s{at}"), mesh, material, placed.shape.emission.clone());
    }
    other
}

#[test]
fn order_names_and_shares_mean_nothing() {
    let room = sample::room();
    assert_eq!(told(&room, &flattened(&room)), []);
    // One shape for each triangle.
    let mut other = Scene { shapes: Arena::default(), ..room.clone() };
    for (_, shape) in room.shapes.iter() {
        let whole = &room.meshes[shape.mesh];
        for triangle in whole.triangles.iter() {
            let mesh = other.meshes.push(Mesh { triangles: Arc::new(vec![*triangle]), ..whole.clone() }, Origin::Made);
            other.shapes.push(Shape { mesh, ..shape.clone() }, Origin::Made);
        }
    }
    let comparison = compared(&room, &other);
    assert!(comparison.equal(), "{comparison:#?}");
    assert_eq!((comparison.surfaces, comparison.found), ([8, 36], 8));
    assert_eq!(told(&other, &room), []);
    // A quadrilateral cut along the other diagonal.
    let mut cut = room.clone();
    mesh(&mut cut, "floor").triangles = Arc::new(vec![[0, 1, 3], [1, 2, 3]]);
    assert_eq!(told(&room, &cut), []);
    // In a group, at its place.
    let mut grouped = room.clone();
    let mut group = Group { name: "all".to_owned(), ..Group::default() };
    for (_, shape) in room.shapes.iter() {
        let transform = Affine::translation([1.0, 2.0, 3.0]);
        group.shapes.push(Shape { transform, ..shape.clone() }, Origin::Made);
    }
    grouped.shapes = Arena::default();
    let group = grouped.groups.push(group, Origin::Made);
    let places = Places::One(Affine::translation([-1.0, -2.0, -3.0]));
    grouped.instances.push(Instance { name: "i".to_owned(), group, places }, Origin::Made);
    assert_eq!(told(&room, &grouped), []);
}

#[test]
fn other_triangles_of_a_round_surface_are_a_difference_of_tessellation() {
    let ring = |segments: u32| {
        let mut scene = sample::empty("ring");
        let white = sample::material(&mut scene, "white", sample::diffuse([1.0; 3]));
        let corner = |step: u32| {
            let degrees = 360.0 * f64::from(step) / f64::from(segments);
            Affine::rotation([0.0, 0.0, 1.0], degrees).point([1.0, 0.0, 0.0])
        };
        let quad = |at: u32| {
            let (a, b) = (corner(at), corner(at + 1));
            [a, b, [b[0], b[1], 1.0], [a[0], a[1], 1.0]]
        };
        let mesh = sample::quads(&mut scene, "ring", &(0..segments).map(quad).collect::<Vec<_>>());
        sample::shape(&mut scene, "ring", mesh, white, None);
        scene
    };
    assert_eq!(told(&ring(64), &ring(96)), [(Kind::Surface, "tessellation".to_owned(), 1)]);
    assert_eq!(told(&ring(64), &ring(64)), []);
}

#[test]
fn lights_are_seen_whatever_their_order() {
    let point = |x: f64, intensity: f64| LightSource {
        name: format!("p{x}"),
        kind: LightKind::Point { position: [x, 0.0, 90.0], intensity: Color::Grey(intensity) },
    };
    let lit = |lights: &[LightSource]| {
        let mut scene = sample::room();
        for light in lights {
            scene.lights.push(light.clone(), Origin::Made);
        }
        scene
    };
    let sky = |value| LightSource { name: "sky".to_owned(), kind: LightKind::environment(Color::Grey(value).into()) };
    let one = lit(&[point(0.0, 1.0), point(5.0, 2.0), sky(0.5)]);
    assert_eq!(told(&one, &lit(&[sky(0.5), point(5.0, 2.0), point(0.0, 1.0), point(3.0, 0.0)])), []);
    let changed = lit(&[point(0.0, 1.0), point(5.0, 2.1), sky(0.5)]);
    assert_eq!(told(&one, &changed), [(Kind::Light, "point intensity".to_owned(), 1)]);
    let moved = lit(&[point(0.0, 1.0), point(6.0, 2.0), sky(0.5)]);
    assert_eq!(told(&one, &moved), [(Kind::Light, "point position".to_owned(), 1)]);
    let darker = lit(&[point(0.0, 1.0), point(5.0, 2.0), sky(0.4)]);
    assert_eq!(told(&one, &darker), [(Kind::Light, "environment radiance".to_owned(), 1)]);
    let fewer = lit(&[point(0.0, 1.0), sky(0.5)]);
    assert_eq!(told(&one, &fewer), [(Kind::Light, "only in A".to_owned(), 1)]);
}

#[test]
fn what_only_one_reader_lost_is_a_difference() {
    let room = sample::room();
    let lost = |message: &str| Finding::new("loss-dropped", Severity::Warn, Origin::Made, message);
    let both = [lost("`fog` is left out")];
    let more = [lost("`fog` is left out"), lost("`strict` is left out")];
    let side = |findings| Side { scene: &room, findings };
    assert!(compare(side(&both), side(&both), TOLERANCE).equal());
    let comparison = compare(side(&both), side(&more), TOLERANCE);
    let [only] = &comparison.differences[..] else { panic!("{comparison:#?}") };
    assert_eq!((only.kind, only.b.as_str()), (Kind::Reading, "`strict` is left out"));
}

#[test]
fn the_tolerance_is_what_is_asked_for() {
    let (room, mut other) = (sample::room(), sample::room());
    camera(&mut other).fov_x = 45.4;
    shape(&mut other, "small").transform = Affine::translation([0.0, 0.0, 0.2]);
    let side = |scene| Side { scene, findings: &[] };
    assert_eq!(compare(side(&room), side(&other), TOLERANCE).differences.len(), 2);
    assert!(compare(side(&room), side(&other), 0.01).equal());
}

/// A thousand equal boxes, and a thousand in one place: neither is tried with all the others.
#[test]
fn many_shapes_are_compared_in_time() {
    let rows = |count: u32, apart: f64| {
        let mut scene = sample::room();
        let mesh = sample::block(&mut scene, "one", [0.1; 3], [0.0, 0.0, 10.0], 0.0);
        let white = sample::material(&mut scene, "grey", sample::diffuse([0.5; 3]));
        for at in 0..count {
            let handle = sample::shape(&mut scene, &format!("b{at}"), mesh, white, None);
            scene.shapes[handle].transform = Affine::translation([apart * f64::from(at), 0.0, 0.0]);
        }
        scene
    };
    for apart in [0.01, 0.0] {
        let scene = rows(20_000, apart);
        assert_eq!(told(&scene, &scene), []);
        let mut moved = scene.clone();
        shape(&mut moved, "b777").transform = Affine::translation([0.0, 3.0, 0.0]);
        let all = told(&scene, &moved);
        assert_eq!((all.len(), all[0].0), (1, Kind::Surface), "{all:#?}");
    }
}

#[test]
fn sides_that_scatter_light_are_told_wherever_the_normals_lie() {
    let (mut room, mut other) = (sample::room(), sample::room());
    let one_sided = |scene: &mut Scene| scene.materials.iter_mut().for_each(|(_, one)| one.sides = Sides::Front);
    one_sided(&mut other);
    let all = told(&room, &other);
    assert!(!all.is_empty() && all.iter().all(|(_, what, _)| what == "sides that scatter light"), "{all:#?}");
    one_sided(&mut room);
    assert_eq!(told(&room, &other), []);
}
