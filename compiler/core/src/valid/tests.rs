//! Each fault is found where it is, and a good scene has none.

use std::sync::Arc;

use super::*;
use crate::diag::Origin;
use crate::ir::*;
use crate::mesh::boxed;

fn good() -> Scene {
    let mut meshes = Arena::default();
    let mut materials = Arena::default();
    let mut shapes = Arena::default();
    let mut cameras = Arena::default();
    let at = |place: &str| Origin::File { path: "a".to_owned(), place: place.to_owned() };
    let mesh = meshes.push(boxed([0.0; 3], [1.0; 3]).expect("a good box").into_mesh("cube"), at("mesh"));
    let bsdf = Bsdf::Diffuse { reflectance: Color::Grey(1.0).into() };
    let material = materials.push(Material::new("white", bsdf), at("material"));
    for emission in [None, Some(Emission { radiance: Color::Grey(3.0) })] {
        // A shape and an emitter may share a name.
        let transform = Affine::IDENTITY;
        shapes.push(Shape { name: "a".to_owned(), mesh, transform, material, emission }, at("shape"));
    }
    let camera = Camera {
        name: None,
        eye: [0.0, -5.0, 0.0],
        target: [0.0; 3],
        up: [0.0, 0.0, 1.0],
        fov_x: 45.0,
        near: Some(0.1),
        far: None,
    };
    cameras.push(camera, at("camera"));
    Scene {
        name: "test".to_owned(),
        origin: at("scene"),
        documentation: Documentation::default(),
        meshes,
        materials,
        shapes,
        lights: Arena::default(),
        textures: Arena::default(),
        groups: Arena::default(),
        instances: Arena::default(),
        cameras,
        film: Film { width: 512, height: 512, filter: Filter::Box { radius: 0.5 } },
        integrator: Integrator::Path { max_depth: 10 },
        sampler: Sampler::Independent { samples: 32, seed: 0 },
    }
}

fn with(change: impl FnOnce(&mut Scene)) -> Vec<Finding> {
    let mut scene = good();
    change(&mut scene);
    validate(scene).err().unwrap_or_default()
}

/// The only finding's id and the place it points at.
#[track_caller]
fn only(change: impl FnOnce(&mut Scene)) -> (&'static str, String) {
    let findings = with(change);
    let [finding] = &findings[..] else { panic!("one finding, not {findings:#?}") };
    let Origin::File { place, .. } = &finding.origin else { panic!("{finding:?} has no place") };
    (finding.id, place.clone())
}

fn mesh(change: impl FnOnce(&mut Mesh)) -> impl FnOnce(&mut Scene) {
    |scene| change(scene.meshes.iter_mut().next().expect("one mesh").1)
}

fn bsdf(bsdf: Bsdf) -> impl FnOnce(&mut Scene) {
    |scene| scene.materials.iter_mut().next().expect("one material").1.bsdf = bsdf
}

fn shape(change: impl FnOnce(&mut Shape)) -> impl FnOnce(&mut Scene) {
    |scene| change(scene.shapes.iter_mut().last().expect("two shapes").1)
}

fn camera(change: impl FnOnce(&mut Camera)) -> impl FnOnce(&mut Scene) {
    |scene| change(scene.cameras.iter_mut().next().expect("one camera").1)
}

#[test]
fn a_good_scene_has_no_findings() {
    assert_eq!(with(|_| {}), []);
    // Missing normals are portability's business.
    assert_eq!(with(mesh(|mesh| mesh.normals = None)), []);
}

#[test]
fn meshes() {
    let at = ("invalid-mesh", "mesh".to_owned());
    assert_eq!(only(mesh(|mesh| mesh.triangles = Arc::default())), at);
    assert_eq!(only(mesh(|mesh| Arc::make_mut(&mut mesh.triangles)[3][1] = 24)), at);
    assert_eq!(only(mesh(|mesh| Arc::make_mut(&mut mesh.positions)[3][1] = f32::NAN)), at);
    assert_eq!(only(mesh(|mesh| mesh.normals = Some(Arc::new(vec![[0.0, 0.0, 1.0]; 23])))), at);
    assert_eq!(only(mesh(|mesh| mesh.normals = Some(Arc::new(vec![[0.0, 0.0, 1.002]; 24])))), at);
    assert_eq!(only(mesh(|mesh| mesh.normals = Some(Arc::new(vec![[f32::NAN; 3]; 24])))), at);
    assert_eq!(only(mesh(|mesh| mesh.uvs = Some(Arc::new(vec![[0.0; 2]; 25])))), at);
    assert_eq!(only(mesh(|mesh| mesh.uvs = Some(Arc::new(vec![[f32::INFINITY; 2]; 24])))), at);
    let findings = with(mesh(|mesh| mesh.triangles = Arc::new(vec![[0, 1, 24], [0, 1, 2], [25, 1, 2]])));
    assert!(findings[0].message.contains("triangle 0 uses a vertex that is not there, and 1 more (there are 24)"));
}

fn light(kind: LightKind) -> impl FnOnce(&mut Scene) {
    move |scene| {
        let name = "l".to_owned();
        scene.lights.push(LightSource { name, kind }, Origin::File { path: "a".to_owned(), place: "light".to_owned() });
    }
}

#[test]
fn lights() {
    let at = ("invalid-light", "light".to_owned());
    let grey = Color::Grey;
    let point = |position, intensity| light(LightKind::Point { position, intensity });
    let directional = |direction, irradiance| light(LightKind::Directional { direction, irradiance });
    let environment = |radiance: Color| light(LightKind::environment(radiance.into()));
    assert_eq!(only(point([f64::NAN, 0.0, 0.0], grey(1.0))), at);
    assert_eq!(only(point([0.0; 3], Color::Rgb([1.0, -1.0, 1.0]))), at);
    assert_eq!(only(directional([0.0, 0.0, 2.0], grey(1.0))), at);
    assert_eq!(only(directional([f64::NAN, 0.0, 1.0], grey(1.0))), at);
    assert_eq!(only(environment(grey(f64::INFINITY))), at);
    let spot = |target, angle, inner| {
        light(LightKind::Spot { position: [0.0; 3], target, intensity: grey(1.0), angle, inner })
    };
    assert_eq!(only(spot([0.0; 3], 20.0, 20.0)), at);
    assert_eq!(only(spot([0.0, f64::NAN, 0.0], 20.0, 20.0)), at);
    assert_eq!(only(spot([0.0, 0.0, 1.0], 20.0, 21.0)), at);
    assert_eq!(only(spot([0.0, 0.0, 1.0], 91.0, 20.0)), at);
    assert_eq!(only(spot([0.0, 0.0, 1.0], f64::NAN, 20.0)), at);
    assert_eq!(with(spot([0.0, 0.0, 1.0], 90.0, 0.0)), []);
    assert_eq!(with(point([0.0; 3], Color::BLACK)), []);
    let twice = |scene: &mut Scene| {
        environment(grey(1.0))(scene);
        environment(grey(2.0))(scene);
        let (_, second) = scene.lights.iter_mut().last().expect("two");
        second.name = "m".to_owned();
    };
    assert_eq!(only(twice).0, "second-environment");
    // The good scene has an emitter called `a`.
    let same = |scene: &mut Scene| {
        environment(grey(1.0))(scene);
        scene.lights.iter_mut().next().expect("one").1.name = "a".to_owned();
    };
    assert_eq!(only(same).0, "invalid-name");
}

#[test]
fn materials() {
    let at = ("invalid-material", "material".to_owned());
    let grey = Color::Grey;
    let conductor = |eta, k, alpha| bsdf(Bsdf::Conductor { eta: grey(eta), k: grey(k), alpha });
    let dielectric = |interior, exterior, alpha| bsdf(Bsdf::Dielectric { interior, exterior, alpha });
    assert_eq!(only(bsdf(Bsdf::Diffuse { reflectance: Color::Rgb([0.5, -0.1, 0.5]).into() })), at);
    assert_eq!(only(bsdf(Bsdf::Mirror { reflectance: grey(f64::NAN) })), at);
    assert_eq!(only(conductor(0.0, 1.0, 0.1)), at);
    assert_eq!(only(conductor(1.0, -1.0, 0.1)), at);
    assert_eq!(only(conductor(1.0, 1.0, f64::INFINITY)), at);
    assert_eq!(only(dielectric(0.0, 1.0, 0.0)), at);
    assert_eq!(only(dielectric(1.5, -1.0, 0.0)), at);
    assert_eq!(only(dielectric(1.5, 1.0, -0.5)), at);
    assert_eq!(with(conductor(0.2, 0.0, 0.0)), []);
}

#[test]
fn shapes() {
    let at = |id| (id, "shape".to_owned());
    let scaled = |x, y, z| shape(move |shape| shape.transform = Affine::scaling([x, y, z]));
    assert_eq!(only(scaled(1.0, 0.0, 1.0)), at("invalid-transform"));
    assert_eq!(only(scaled(1.0, f64::NAN, 1.0)), at("invalid-transform"));
    assert_eq!(only(scaled(1.0, -1.0, 1.0)), at("invalid-transform"));
    assert_eq!(only(scaled(1e39, 1.0, 1.0)), at("invalid-transform"));
    assert_eq!(with(scaled(-1.0, -1.0, 1e30)), []);
    let radiance = |value| shape(move |shape| shape.emission = Some(Emission { radiance: Color::Grey(value) }));
    assert_eq!(only(radiance(-1.0)), at("invalid-emission"));
    assert_eq!(only(radiance(f64::INFINITY)), at("invalid-emission"));
    assert_eq!(with(radiance(0.0)), []);
    let mut other = good();
    let mesh = other.meshes.iter().next().expect("one mesh").1.clone();
    let beyond = other.meshes.push(mesh, Origin::Made);
    assert_eq!(only(shape(|shape| shape.mesh = beyond)), at("invalid-shape"));
    assert_eq!(only(|scene| scene.shapes = Arena::default()).0, "invalid-scene");
}

#[test]
fn cameras() {
    let at = ("invalid-camera", "camera".to_owned());
    assert_eq!(only(camera(|camera| camera.target = camera.eye)), at);
    assert_eq!(only(camera(|camera| camera.up = [0.0, -3.0, 0.0])), at);
    assert_eq!(only(camera(|camera| camera.up = [0.0; 3])), at);
    assert_eq!(only(camera(|camera| camera.eye[0] = f64::NAN)), at);
    for fov in [0.0, -1.0, 180.0, f64::NAN, f64::INFINITY] {
        assert_eq!(only(camera(|camera| camera.fov_x = fov)), at);
    }
    assert_eq!(only(camera(|camera| camera.near = Some(0.0))), at);
    assert_eq!(only(camera(|camera| camera.far = Some(0.1))), at);
    assert_eq!(only(camera(|camera| camera.far = Some(f64::INFINITY))), at);
    assert_eq!(only(|scene| scene.cameras = Arena::default()).0, "invalid-scene");
}

#[test]
fn settings() {
    assert_eq!(only(|scene| scene.film.width = 0), ("invalid-film", "scene".to_owned()));
    assert_eq!(only(|scene| scene.film.height = 65_537).0, "invalid-film");
    assert_eq!(only(|scene| scene.film.filter = Filter::Box { radius: 0.0 }).0, "invalid-film");
    let gaussian = Filter::Gaussian { stddev: f64::NAN, radius: 2.0 };
    assert_eq!(only(|scene| scene.film.filter = gaussian).0, "invalid-film");
    assert_eq!(only(|scene| scene.integrator = Integrator::Path { max_depth: 0 }).0, "invalid-integrator");
    assert_eq!(only(|scene| scene.sampler = Sampler::Independent { samples: 0, seed: 0 }).0, "invalid-sampler");
}

#[test]
fn names() {
    assert_eq!(only(|scene| scene.name = String::new()), ("invalid-name", "scene".to_owned()));
    assert_eq!(only(mesh(|mesh| mesh.name = "a\nb".to_owned())), ("invalid-name", "mesh".to_owned()));
    assert_eq!(only(shape(|shape| shape.emission = None)), ("invalid-name", "shape".to_owned()));
    let twice = |names: [Option<&str>; 2]| {
        with(|scene| {
            let mut one = scene.cameras.values().next().expect("one camera").clone();
            one.name = names[1].map(str::to_owned);
            scene.cameras.iter_mut().next().expect("one camera").1.name = names[0].map(str::to_owned);
            scene.cameras.push(one, Origin::Made);
        })
    };
    assert_eq!(twice([Some("a"), Some("b")]), []);
    assert_eq!(twice([Some("a"), Some("a")]).len(), 1);
    assert_eq!(twice([None, Some("a")]).len(), 1);
}

#[test]
fn all_faults_are_reported_at_once() {
    let findings = with(|scene| {
        scene.film.width = 0;
        scene.sampler = Sampler::Independent { samples: 0, seed: 0 };
        scene.cameras.iter_mut().next().expect("one camera").1.fov_x = 0.0;
        scene.name = String::new();
    });
    assert_eq!(findings.len(), 4);
}

#[test]
fn textures_need_pixels_a_fitting_encoding_and_texture_coordinates() {
    let add = |scene: &mut Scene, image: ImageInfo, encoding: Encoding| {
        let texture = Texture {
            name: "oak".to_owned(),
            file: ImageFile::new(b"a"),
            image,
            encoding,
            peak: 1.0,
            factor: [1.0; 3],
        };
        let place = Origin::File { path: "a".to_owned(), place: "texture".to_owned() };
        scene.textures.push(texture, place)
    };
    let png = ImageInfo { format: ImageFormat::Png, width: 2, height: 2, channels: 3, bits: 8 };
    let at = ("invalid-texture", "texture".to_owned());
    let bad = |image: ImageInfo, encoding| {
        only(|scene| {
            add(scene, image, encoding);
        })
    };
    assert_eq!(bad(ImageInfo { width: 0, ..png }, Encoding::Srgb), at);
    assert_eq!(bad(ImageInfo { channels: 5, ..png }, Encoding::Srgb), at);
    assert_eq!(bad(ImageInfo { format: ImageFormat::Exr, bits: 32, ..png }, Encoding::Srgb), at);
    let laid = |uvs: bool| {
        with(|scene| {
            let texture = add(scene, png, Encoding::Srgb);
            for (_, material) in scene.materials.iter_mut() {
                material.bsdf = Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(texture) };
            }
            for (_, mesh) in scene.meshes.iter_mut().filter(|_| !uvs) {
                mesh.uvs = None;
            }
        })
    };
    assert!(laid(true).is_empty());
    assert!(laid(false).iter().all(|finding| finding.id == "missing-uvs") && laid(false).len() == 2);
}
