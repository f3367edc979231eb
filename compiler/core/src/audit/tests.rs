//! Clean scenes have no finding, planted faults have one each, and whatever a file holds no reader panics.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::files::{MemoryFiles, MemorySink};
use crate::formats::shared::sample;
use crate::formats::statements::NONE;
use crate::formats::{self, Choices, Emission as Emitting, TARGETS};
use crate::ir::{Color, Encoding, Film, Filter, ImageFormat, Integrator, LightKind, LightSource};
use crate::valid::{Valid, validate};

/// All targets but the one that only tests have.
fn readable() -> impl Iterator<Item = &'static Target> {
    let readable = TARGETS.iter().filter(|target| target.import.is_some());
    assert_eq!(readable.clone().count() + 1, TARGETS.len(), "a target without a reader");
    readable
}

/// A scene as a target's folder beside the meshes that targets share.
pub(super) fn written(scene: &Valid, target: &Target) -> BTreeMap<String, Vec<u8>> {
    written_by(scene, target, &Choices::default())
}

fn written_by(scene: &Valid, target: &Target, choices: &Choices) -> BTreeMap<String, Vec<u8>> {
    let mut sink = MemorySink::default();
    formats::write_meshes(scene, "meshes/", &mut sink).expect("memory takes all");
    formats::write_textures(scene, &[target], "textures/", &mut sink).expect("memory takes all");
    let mut own = MemorySink::default();
    let emission = Emitting {
        scene,
        camera: camera(scene),
        meshes: "../meshes/",
        textures: "../textures/",
        choices,
        statements: &NONE,
    };
    (target.emit)(&emission, &mut own).expect("memory takes all");
    sink.files.extend(own.files.into_iter().map(|(path, bytes)| (format!("{}/{path}", target.name), bytes)));
    sink.files
}

pub(super) fn camera(scene: &Scene) -> Handle<Camera> {
    scene.cameras.iter().next().expect("a camera").0
}

pub(super) fn audited(scene: &Valid, target: &'static Target, files: &BTreeMap<String, Vec<u8>>) -> Audit {
    let mut memory = MemoryFiles::default();
    for (path, bytes) in files {
        memory.insert(path.clone(), bytes.clone());
    }
    let asked = Asked::new(scene, camera(scene));
    audit(&asked, target, target.name, &NONE, &mut Meshes::new(&memory))
}

pub(super) fn said(audit: &Audit) -> Vec<String> {
    let line = |finding: &Finding| format!("{} {:?} {}", finding.id, finding.origin, finding.message);
    audit.findings.iter().map(line).collect()
}

fn clean(scene: Scene) {
    let (scene, _) = crate::lower::lower(scene);
    let scene = validate(scene).expect("a valid scene");
    for target in readable() {
        let audit = audited(&scene, target, &written(&scene, target));
        assert_eq!(said(&audit), Vec::<String>::new(), "{}", target.name);
        let asked = Asked::new(&scene, camera(&scene));
        assert_eq!(audit.said.surfaces, asked.sums.surfaces, "{}", target.name);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs();
        let areas = asked.sums.area.zip(audit.said.area);
        assert!(areas.is_none_or(|(a, b)| near(a, b)), "{}: {areas:?}", target.name);
        assert!((0..3).all(|at| near(asked.sums.power[at], audit.said.power[at])), "{}", target.name);
    }
}

/// A room with a metal block, two glass ones, a mirror, plastic, and every light.
pub(super) fn full() -> Scene {
    let mut scene = sample::room();
    let bsdfs = [
        Bsdf::Conductor { eta: Color::Rgb([0.2, 0.924, 1.102]), k: Color::Rgb([3.913, 2.453, 2.142]), alpha: 0.2 },
        Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.0 },
        Bsdf::Dielectric { interior: 1.8, exterior: 1.33, alpha: 0.15 },
        Bsdf::Mirror { reflectance: Color::Rgb([0.9, 0.8, 0.7]) },
        Bsdf::Plastic { reflectance: Color::Rgb([0.6, 0.4, 0.2]).into(), ior: 1.5, alpha: 0.1 },
        Bsdf::Principled { base: Color::Rgb([0.6, 0.4, 0.2]).into(), metallic: 0.3, roughness: 0.4, ior: 1.6 },
        Bsdf::Principled { base: Color::Grey(0.4).into(), metallic: 1.0, roughness: 0.4, ior: 1.6 },
        Bsdf::Conductor { eta: Color::Grey(1.3), k: Color::Grey(2.5), alpha: 0.0 },
    ];
    for (at, bsdf) in bsdfs.into_iter().enumerate() {
        let name = format!("extra {at}");
        let material = sample::material(&mut scene, &name, bsdf);
        let mesh = sample::block(&mut scene, &name, [5.0; 3], [0.0, 0.0, 10.0 + 7.0 * at as f64], 10.0);
        let shape = sample::shape(&mut scene, &name, mesh, material, None);
        scene.shapes[shape].transform = Affine::rotation([0.0, 0.6, 0.8], 20.0);
    }
    let lights = [
        LightKind::environment(Color::Rgb([0.1, 0.2, 0.3]).into()),
        LightKind::Point { position: [1.0, 2.0, 3.0], intensity: Color::Rgb([4.0, 5.0, 6.0]) },
        LightKind::Directional { direction: [0.48, 0.6, -0.64], irradiance: Color::Grey(2.0) },
        LightKind::Spot {
            position: [0.0, 1.0, 90.0],
            target: [3.0, 2.0, 1.0],
            intensity: Color::Rgb([7.0, 8.0, 9.0]),
            angle: 30.0,
            inner: 22.0,
        },
    ];
    for (at, kind) in lights.into_iter().enumerate() {
        scene.lights.push(LightSource { name: format!("light {at}"), kind }, Origin::Made);
    }
    scene.film = Film { width: 96, height: 64, filter: Filter::Gaussian { stddev: 0.5, radius: 2.0 } };
    scene
}

#[test]
fn scenes_that_are_written_are_read_back_the_same() {
    clean(sample::room());
    clean(sample::grid());
    clean(full());
}

#[test]
fn every_shape_of_image_and_algorithm_is_read_back() {
    for (width, height) in [(200, 100), (100, 200)] {
        let mut scene = sample::room();
        scene.film = Film { width, height, filter: Filter::Box { radius: 1.5 } };
        clean(scene);
    }
    for max_depth in [1, 2, 3] {
        for integrator in [
            Integrator::Path { max_depth },
            Integrator::Bidirectional { max_depth },
            Integrator::LightTracing { max_depth },
            Integrator::Metropolis { max_depth },
            Integrator::PhotonMap { max_depth },
        ] {
            clean(Scene { integrator, ..sample::room() });
        }
    }
}

#[test]
fn filters_are_read_back() {
    for filter in [
        Filter::Box { radius: 0.5 },
        Filter::Box { radius: 1.5 },
        Filter::Gaussian { stddev: 0.5, radius: 2.0 },
        Filter::Gaussian { stddev: 1.0, radius: 2.0 },
        Filter::Gaussian { stddev: 3.0, radius: 12.0 },
    ] {
        let mut scene = sample::room();
        scene.film.filter = filter;
        clean(scene);
    }
}

/// Whatever writes them, a wrong number of a filter is found without a renderer.
#[test]
fn a_filter_of_another_width_is_named() {
    let mut scene = sample::room();
    scene.film.filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 };
    let scene = validate(scene).expect("a valid scene");
    let faults = [
        fault("mitsuba-3", "settings.xml", "stddev\" value=\"0.5\"", "stddev\" value=\"1\""),
        fault("mitsuba-0.6", "settings.xml", "stddev\" value=\"0.5\"", "stddev\" value=\"1\""),
        fault("mitsuba-0.5", "settings.xml", "stddev\" value=\"0.5\"", "stddev\" value=\"1\""),
        fault("pbrt-v4", "settings.pbrt", "sigma\" [0.5]", "sigma\" [1]"),
        fault("pbrt-v4", "settings.pbrt", "yradius\" [2]", "yradius\" [1]"),
        fault("pbrt-v3", "settings.pbrt", "alpha\" [2]", "alpha\" [4]"),
        fault("pbrt-v3", "settings.pbrt", "ywidth\" [2]", "ywidth\" [1]"),
        fault("luxcore", "scene.cfg", "gaussian.alpha = 2", "gaussian.alpha = 4"),
        fault("luxcore", "scene.cfg", "filter.width = 2", "filter.width = 4"),
        fault("luxcore", "scene.cfg", "GAUSSIAN", "BOX"),
        fault("cycles", "scene.py", "gaussian=2", "gaussian=6"),
    ];
    for Fault { target, file, from, to } in faults {
        let target = formats::find(target).expect("a target");
        let mut files = written(&scene, target);
        let path = format!("{}/{file}", target.name);
        let other = replaced(&files[&path], from, to);
        files.insert(path, other);
        let all = said(&audited(&scene, target, &files));
        assert!(all.iter().any(|line| line.contains("filter")), "{} {to}: {all:?}", target.name);
    }
}

#[test]
fn textures_are_read_back_where_they_can_be_and_a_grey_stands_for_them_elsewhere() {
    use crate::ir::ColorOrTexture;
    let formats = [
        (ImageFormat::Png, Encoding::Srgb),
        (ImageFormat::Png, Encoding::Linear),
        (ImageFormat::Jpeg, Encoding::Srgb),
        (ImageFormat::Jpeg, Encoding::Linear),
        (ImageFormat::Exr, Encoding::Linear),
        (ImageFormat::Hdr, Encoding::Linear),
    ];
    for (format, encoding) in formats {
        let mut scene = sample::room();
        let texture = scene.textures.push(sample::image("tiles", format, encoding), Origin::Made);
        let paint = || ColorOrTexture::Texture(texture);
        let bsdfs = [
            Bsdf::Diffuse { reflectance: paint() },
            Bsdf::Plastic { reflectance: paint(), ior: 1.5, alpha: 0.1 },
            Bsdf::Principled { base: paint(), metallic: 0.3, roughness: 0.4, ior: 1.6 },
        ];
        let mesh = crate::mesh::sphere(5.0, [0.0, 0.0, 50.0], 8, 4).expect("a good sphere").into_mesh("ball");
        let mesh = scene.meshes.push(mesh, Origin::Made);
        for (at, bsdf) in bsdfs.into_iter().enumerate() {
            let name = format!("painted {at}");
            let material = sample::material(&mut scene, &name, bsdf);
            sample::shape(&mut scene, &name, mesh, material, None);
        }
        clean(scene);
    }
}

#[test]
fn images_of_the_environment_are_read_back() {
    for format in [ImageFormat::Exr, ImageFormat::Hdr, ImageFormat::Pfm] {
        let mut scene = sample::room();
        let texture = scene.textures.push(sample::image("sky", format, Encoding::Linear), Origin::Made);
        let radiance = crate::ir::ColorOrTexture::Texture(texture);
        let turned = LightKind::Environment {
            radiance: radiance.clone(),
            tint: Color::Rgb([0.5, 3.0, 1.0]),
            turn: Affine::rotation(crate::ir::normalized([1.0, 2.0, 3.0]).expect("an axis"), 70.0),
        };
        for kind in [LightKind::environment(radiance), turned] {
            let mut scene = scene.clone();
            scene.lights.push(LightSource { name: "sky".to_owned(), kind }, Origin::Made);
            // The image of the sky colors a surface too.
            let bsdf = Bsdf::Diffuse { reflectance: crate::ir::ColorOrTexture::Texture(texture) };
            let mesh = crate::mesh::sphere(5.0, [0.0, 0.0, 50.0], 8, 4).expect("a good sphere").into_mesh("ball");
            let mesh = scene.meshes.push(mesh, Origin::Made);
            let material = sample::material(&mut scene, "painted", bsdf);
            sample::shape(&mut scene, "painted", mesh, material, None);
            clean(scene);
        }
    }
}

#[test]
fn instances_in_the_buffer_are_read_back_in_the_order_of_their_names() {
    let mut scene = sample::grid();
    let first = scene.shapes.values().next().expect("a lamp").clone();
    // Lamps of two radiances in turns, each of which is gathered.
    for at in 0..9 {
        let transform =
            Affine::rotation([0.0, 0.6, 0.8], 31.0 * f64::from(at)).then(&Affine::translation([0.1, 2.0, 3.3]));
        let emission = Some(Emission { radiance: Color::Grey(if at % 2 == 0 { 30.0 } else { 20.0 }) });
        scene.shapes.push(Shape { name: format!("lamp[{at}]"), transform, emission, ..first.clone() }, Origin::Made);
    }
    let (scene, _) = crate::lower::lower(scene);
    let scene = validate(scene).expect("a valid scene");
    for name in ["gltf", "glb"] {
        let target = formats::find(name).expect("a target");
        let mut choices = Choices::default();
        choices.add(&format!("{name}.instancing")).expect("an option");
        let files = written_by(&scene, target, &choices);
        let audit = audited(&scene, target, &files);
        assert_eq!(said(&audit), Vec::<String>::new(), "{name}");
        assert_eq!(audit.said.emitters, 10);
        let other: Vec<(String, Vec<u8>)> = files
            .iter()
            .map(|(path, bytes)| {
                let text = String::from_utf8_lossy(bytes).contains("lamp[3]");
                let edited = |bytes: &[u8]| replaced(bytes, "\"lamp[3]\"", "\"lamp[4]\"");
                (path.clone(), if text { edited(bytes) } else { bytes.clone() })
            })
            .collect();
        let all = said(&audited(&scene, target, &other.into_iter().collect()));
        assert!(all.iter().any(|line| line.contains("`lamp[4]`")), "{name}: {all:?}");
    }
}

/// An edit of the text of one file.
struct Fault {
    target: &'static str,
    file: &'static str,
    from: &'static str,
    to: &'static str,
}

const fn fault(target: &'static str, file: &'static str, from: &'static str, to: &'static str) -> Fault {
    Fault { target, file, from, to }
}

/// A lamp, a metal of alpha 0.2, paths of ten segments.
pub(super) fn metal() -> Scene {
    let mut scene = sample::room();
    let bsdf = Bsdf::Conductor { eta: Color::Grey(1.3), k: Color::Grey(2.5), alpha: 0.2 };
    let material = sample::material(&mut scene, "metal", bsdf);
    let mesh = sample::block(&mut scene, "metal", [5.0; 3], [0.0, 0.0, 10.0], 10.0);
    sample::shape(&mut scene, "metal", mesh, material, None);
    scene
}

/// The bytes with every `from` replaced, of which there is one; binary files hold text, too.
fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let mut rest = bytes;
    let mut made = Vec::with_capacity(bytes.len());
    while let Some(at) = rest.windows(from.len()).position(|window| window == from.as_bytes()) {
        made.extend_from_slice(&rest[..at]);
        made.extend_from_slice(to.as_bytes());
        rest = &rest[at + from.len()..];
    }
    assert!(!made.is_empty(), "{from} in {}", String::from_utf8_lossy(bytes));
    made.extend_from_slice(rest);
    made
}

/// Plants each fault and looks for what names it.
fn planted(faults: &[Fault], names: &[&str]) {
    let scene = validate(metal()).expect("a valid scene");
    let mut left: Vec<&str> = readable().map(|target| target.name).collect();
    for Fault { target, file, from, to } in faults {
        let found = formats::find(target).expect("a target");
        let mut files = written(&scene, found);
        let path = format!("{target}/{file}");
        let edited = replaced(&files[&path], from, to);
        files.insert(path, edited);
        let audit = audited(&scene, found, &files);
        let all = said(&audit);
        assert!(all.iter().all(|line| line.starts_with(MISMATCH)), "{target}: {all:?}");
        assert!(all.iter().any(|line| names.iter().all(|name| line.contains(name))), "{target}: {all:?}");
        left.retain(|name| name != target);
    }
    assert_eq!(left, Vec::<&str>::new(), "targets without a fault");
}

const XML: &str = "description.xml";
const PBRT: &str = "description.pbrt";
#[test]
fn a_verdict_names_what_was_lost() {
    let mut scene = sample::room();
    let kind = LightKind::environment(Color::Grey(1.0).into());
    scene.lights.push(LightSource { name: "sky".to_owned(), kind }, Origin::Made);
    let bright = Bsdf::Diffuse { reflectance: Color::Grey(1.2).into() };
    let bright = sample::material(&mut scene, "bright", bright);
    let block = sample::block(&mut scene, "bright", [1.0; 3], [0.0, 0.0, 30.0], 0.0);
    sample::shape(&mut scene, "bright", block, bright, None);
    let (scene, _) = crate::lower::lower(scene);
    let scene = validate(scene).expect("a valid scene");
    for target in readable() {
        let audit = audited(&scene, target, &written(&scene, target));
        assert_eq!(said(&audit), Vec::<String>::new(), "{}", target.name);
        let verdict = audit.whole_verdict();
        let gltf = ["gltf", "glb"].contains(&target.name);
        for lost in ["a constant environment", "a reflectance above 1"] {
            assert_eq!(verdict.contains(lost), gltf, "{}: {verdict}", target.name);
        }
        let begin = if audit.lost.is_empty() {
            "agrees".to_owned()
        } else {
            format!("agrees, but for {} loss", audit.lost.len())
        };
        assert!(verdict.starts_with(&begin), "{}: {verdict}", target.name);
        let ledger = crate::formats::TARGETS.iter().find(|one| one.name == target.name).expect("a target");
        let all = features(&scene).into_iter().filter(|(feature, _)| unsupported(&(ledger.supports)(*feature))).count();
        assert_eq!(audit.lost.len(), all + usize::from(gltf), "{}", target.name);
    }
    let dark = audited(&scene, formats::find("gltf").expect("a target"), &BTreeMap::new());
    assert_eq!(dark.whole_verdict(), "DIFFERS");
}

const GLTF: &str = "cbox_classic.gltf";
const GLB: &str = "cbox_classic.glb";

#[test]
fn a_radiance_that_is_doubled_is_named() {
    let rgb = |target| fault(target, XML, "value=\"30, 30, 30\"", "value=\"60, 60, 60\"");
    let pbrt = |target| fault(target, PBRT, "\"rgb L\" [30 30 30]", "\"rgb L\" [60 60 60]");
    planted(
        &[
            rgb("mitsuba-3"),
            rgb("mitsuba-0.6"),
            rgb("mitsuba-0.5"),
            pbrt("pbrt-v4"),
            pbrt("pbrt-v3"),
            fault("luxcore", "scene.scn", ".emission = 30 30 30", ".emission = 60 60 60"),
            fault("cycles", "scene.py", "radiance=(30, 30, 30)", "radiance=(60, 60, 60)"),
            fault("gltf", GLTF, "\"emissiveStrength\": 30.0", "\"emissiveStrength\": 60.0"),
            fault("glb", GLB, "\"emissiveStrength\":30.0", "\"emissiveStrength\":60.0"),
        ],
        &["`lamp`", " W instead of "],
    );
}

#[test]
fn an_alpha_that_is_squared_is_named() {
    let xml = |target| fault(target, XML, "name=\"alpha\" value=\"0.2\"", "name=\"alpha\" value=\"0.04\"");
    let pbrt = |target| fault(target, PBRT, "\"float roughness\" [0.2]", "\"float roughness\" [0.04]");
    planted(
        &[
            xml("mitsuba-3"),
            xml("mitsuba-0.6"),
            xml("mitsuba-0.5"),
            pbrt("pbrt-v4"),
            pbrt("pbrt-v3"),
            fault("luxcore", "scene.scn", "roughness = 0.2", "roughness = 0.04"),
            fault("cycles", "scene.py", "alpha=0.2", "alpha=0.04"),
            fault("gltf", GLTF, "\"roughnessFactor\": 0.4472135954999579", "\"roughnessFactor\": 0.2"),
            // Lengths of a binary file's parts stand before them.
            fault("glb", GLB, "\"roughnessFactor\":0.4472135954999579", "\"roughnessFactor\":0.2000000000000000"),
        ],
        &["`metal`", "`alpha` 0.04"],
    );
}

#[test]
fn a_depth_of_one_more_is_named() {
    let xml = |target, name| fault(target, "settings.xml", name, "value=\"11\"");
    let pbrt = |target| fault(target, "settings.pbrt", "\"integer maxdepth\" [9]", "\"integer maxdepth\" [10]");
    planted(
        &[
            xml("mitsuba-3", "value=\"10\""),
            xml("mitsuba-0.6", "value=\"10\""),
            xml("mitsuba-0.5", "value=\"10\""),
            pbrt("pbrt-v4"),
            pbrt("pbrt-v3"),
            fault("luxcore", "scene.cfg", " = 10\n", " = 11\n"),
            fault("cycles", "scene.py", "path(max_depth=10)", "path(max_depth=11)"),
            fault("gltf", GLTF, "\"max_depth\": 10", "\"max_depth\": 11"),
            fault("glb", GLB, "\"max_depth\":10", "\"max_depth\":11"),
        ],
        &["paths have 11 segments instead of 10"],
    );
}

/// The files of a target with the lamp's mesh turned over, as it is and by its normals.
fn turned(scene: &Valid, target: &Target) -> BTreeMap<String, Vec<u8>> {
    let mut other: Scene = (**scene).clone();
    let lamp = scene.shapes.values().find(|shape| shape.emission.is_some()).expect("a lamp").mesh;
    let mesh = &other.meshes[lamp];
    let flipped = crate::mesh::flip(mesh::Geometry::from_mesh(mesh)).into_mesh(mesh.name.clone());
    other.meshes[lamp] = flipped;
    let other = written(&validate(other).expect("a valid scene"), target);
    let mut files = written(scene, target);
    // The texts stay, and only the numbers of the mesh are other ones.
    for (path, bytes) in
        other.into_iter().filter(|(path, _)| [".ply", ".bin", ".glb"].iter().any(|end| path.ends_with(end)))
    {
        files.insert(path, bytes);
    }
    files
}

#[test]
fn an_emitter_that_is_turned_over_is_named() {
    let scene = validate(metal()).expect("a valid scene");
    for target in readable() {
        let all = said(&audited(&scene, target, &turned(&scene, target)));
        assert!(all.iter().all(|line| line.starts_with(MISMATCH)), "{}: {all:?}", target.name);
        assert!(all.iter().any(|line| line.contains("emitter `lamp` faces")), "{}: {all:?}", target.name);
    }
    // A closed one has no side that it faces.
    let mut ball = metal();
    let mesh = crate::mesh::sphere(5.0, [0.0, 0.0, 50.0], 12, 6).expect("a good sphere").into_mesh("ball");
    let lamp = ball.shapes.iter().find(|(_, shape)| shape.emission.is_some()).expect("a lamp").0;
    ball.shapes[lamp].mesh = ball.meshes.push(mesh, Origin::Made);
    let scene = validate(ball).expect("a valid scene");
    for target in readable() {
        let all = said(&audited(&scene, target, &turned(&scene, target)));
        assert!(
            all.iter().any(|line| line.contains("`lamp` has faces towards the outside")),
            "{}: {all:?}",
            target.name
        );
    }
}

#[test]
fn an_emitter_that_emits_on_the_wrong_side_or_on_both_is_named() {
    let scene = validate(metal()).expect("a valid scene");
    let cases = [
        (
            "pbrt-v3",
            PBRT,
            "\"rgb L\" [30 30 30]",
            "\"rgb L\" [30 30 30] \"bool twosided\" [\"true\"]",
            "`lamp` emits on both",
        ),
        (
            "pbrt-v4",
            PBRT,
            "\"rgb L\" [30 30 30]",
            "\"rgb L\" [30 30 30] \"bool twosided\" true",
            "`lamp` emits on both",
        ),
        ("pbrt-v3", PBRT, "\tAreaLightSource", "\tReverseOrientation\n\tAreaLightSource", "`lamp` faces"),
        ("pbrt-v4", PBRT, "\tAreaLightSource", "\tReverseOrientation\n\tAreaLightSource", "`lamp` faces"),
        ("gltf", GLTF, "\"emissiveFactor\"", "\"doubleSided\": true, \"emissiveFactor\"", "`lamp` emits on both"),
        ("luxcore", "scene.scn", ".emission.theta = 90", ".emission.theta = 45", "`emission.theta` other than 90"),
        ("luxcore", "scene.scn", ".emission.power = 0", ".emission.power = 7", "`emission.power` other than 0"),
        ("cycles", "ltsc_blender.py", "Backfacing", "Frontfacing", "the functions are not those"),
    ];
    for (target, file, from, to, name) in cases {
        let found = formats::find(target).expect("a target");
        let mut files = written(&scene, found);
        let path = format!("{target}/{file}");
        let text = String::from_utf8(files[&path].clone()).expect("text");
        assert!(text.contains(from), "{target}: {from} in {text}");
        files.insert(path, text.replace(from, to).into_bytes());
        let all = said(&audited(&scene, found, &files));
        assert!(all.len() <= 2 && all[0].contains(name), "{target}: {all:?}");
    }
}

#[test]
fn camera_size_matter_and_place_are_compared() {
    let scene = validate(full()).expect("a valid scene");
    let cases = [
        ("mitsuba-3", "settings.xml", "name=\"fov\" value=\"45\"", "name=\"fov\" value=\"46\"", "`fov_x` is 46"),
        ("mitsuba-3", "settings.xml", "up=\"0, 0, 1\"", "up=\"0, 0, -1\"", "the image is turned"),
        (
            "mitsuba-3",
            XML,
            "\t<bsdf type=\"twosided\" id=\"white\">\n\t\t<bsdf type=\"diffuse\">",
            "\t<bsdf type=\"diffuse\" id=\"white\">",
            "this is no XML",
        ),
        ("mitsuba-3", XML, "<matrix value", "<matrx value", "there is no transform `matrx`"),
        ("pbrt-v4", "settings.pbrt", "Scale -1 1 1\n", "", "the image is mirrored"),
        ("pbrt-v3", "settings.pbrt", "xresolution\" [96]", "xresolution\" [95]", "95 x 64 pixels instead of 96 x 64"),
        ("pbrt-v3", PBRT, "\"float coneangle\" [30]", "\"float coneangle\" [31]", "`light 3` has the angles 31"),
        (
            "pbrt-v3",
            PBRT,
            "\"rgb Kd\" [0.882 0.776 0.341]",
            "\"rgb Kd\" [0.882 0.776 0.342]",
            "material `ochre` reflects",
        ),
        (
            "pbrt-v4",
            PBRT,
            "ConcatTransform [0.9396926207859084 ",
            "ConcatTransform [0.94 ",
            "shape `extra 0` has another transform",
        ),
        (
            "pbrt-v4",
            PBRT,
            "AttributeBegin\n\tNamedMaterial \"red\"",
            "AttributeBegin\n\tNamedMaterial \"green\"",
            "material `red` (`green`) reflects",
        ),
        ("luxcore", "scene.scn", "screenwindow = -1 1 ", "screenwindow = -1 1.1 ", "`fov_x`"),
        ("luxcore", "scene.scn", "extra_0_fresnel.k = ", "extra_0_fresnel.k = 1", "`extra 0`"),
        ("cycles", "scene.py", "light 1\", (1, 2, 3)", "light 1\", (1, 2, 4)", "`light 1` is at"),
        ("gltf", GLTF, "\"ior\": 1.5\n", "\"ior\": 1.4\n", "index of refraction 1.4"),
        ("gltf", GLTF, "\"doubleSided\": true", "\"doubleSided\": false", "scatters on one side only"),
    ];
    for (target, file, from, to, name) in cases {
        let found = formats::find(target).expect("a target");
        let mut files = written(&scene, found);
        let path = format!("{target}/{file}");
        let text = String::from_utf8(files[&path].clone()).expect("text");
        assert!(text.contains(from), "{target}: {from} in {text}");
        files.insert(path, text.replace(from, to).into_bytes());
        let all = said(&audited(&scene, found, &files));
        assert!(all.iter().any(|line| line.contains(name)), "{target}: {from} -> {to}: {all:?}");
    }
}

#[test]
fn files_that_are_gone_or_name_others_are_found() {
    let scene = validate(metal()).expect("a valid scene");
    for target in readable() {
        let whole = written(&scene, target);
        let own = whole.keys().filter(|path| path.starts_with(target.name) || path.ends_with("lamp.ply"));
        for path in own.cloned().collect::<Vec<_>>() {
            let mut files = whole.clone();
            files.remove(&path);
            let shared = path.ends_with(".ply") && !target.shares_meshes;
            let found = said(&audited(&scene, target, &files));
            assert_eq!(found.is_empty(), shared, "{}: {path}: {found:?}", target.name);
        }
        // A binary container names no other files.
        if target.name == "glb" {
            continue;
        }
        let mut files = whole.clone();
        for bytes in files.iter_mut().filter(|(path, _)| path.starts_with(target.name)).map(|(_, bytes)| bytes) {
            if let Ok(text) = std::str::from_utf8(bytes) {
                *bytes =
                    text.replace("../meshes/", "../../meshes/").replace(".bin\"", ".bin/../../../b\"").into_bytes();
            }
        }
        let found = said(&audited(&scene, target, &files));
        assert!(found.iter().any(|line| line.contains("leads out of the project")), "{}: {found:?}", target.name);
    }
}

/// A change of the bytes of a file.
#[derive(Clone, Debug)]
enum Change {
    Cut(usize),
    Byte(usize, u8),
    Remove(usize, usize),
    Repeat(usize, usize, usize),
    Put(usize, &'static str),
}

fn change() -> impl Strategy<Value = Change> {
    let words = prop::sample::select(vec![
        "-1",
        "1e999",
        "nan",
        "\"",
        "[",
        "(",
        "{",
        "<",
        "</scene>",
        "\n",
        "\\",
        "4294967296",
        "é",
        "AttributeBegin ",
        "Include \"scene.pbrt\"\n",
        "<include filename=\"scene.xml\"/>",
        "null",
        "0.0000000000000001",
        "= ",
        "with group(\"a\"):\n",
    ]);
    prop_oneof![
        any::<usize>().prop_map(Change::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        (any::<usize>(), 1_usize..200).prop_map(|(at, size)| Change::Remove(at, size)),
        (any::<usize>(), 1_usize..200, 1_usize..20).prop_map(|(at, size, times)| Change::Repeat(at, size, times)),
        (any::<usize>(), words).prop_map(|(at, word)| Change::Put(at, word)),
    ]
}

fn changed(bytes: &[u8], change: &Change) -> Vec<u8> {
    let place = |at: usize| at % (bytes.len() + 1);
    let end = |at: usize, size: usize| (place(at) + size).min(bytes.len());
    match *change {
        Change::Cut(at) => bytes[..place(at)].to_vec(),
        Change::Byte(at, byte) => {
            let mut bytes = bytes.to_vec();
            if let Some(there) = bytes.get_mut(place(at)) {
                *there = byte;
            }
            bytes
        }
        Change::Remove(at, size) => [&bytes[..place(at)], &bytes[end(at, size)..]].concat(),
        Change::Repeat(at, size, times) => {
            let part = &bytes[place(at)..end(at, size)];
            [&bytes[..place(at)], &part.repeat(times), &bytes[place(at)..]].concat()
        }
        Change::Put(at, word) => [&bytes[..place(at)], word.as_bytes(), &bytes[place(at)..]].concat(),
    }
}

/// A scene with the files of every target.
type Written = (Valid, Vec<BTreeMap<String, Vec<u8>>>);

/// The files of every target, made once.
fn all_written() -> &'static Written {
    static ALL: std::sync::LazyLock<Written> = std::sync::LazyLock::new(|| {
        let mut scene = full();
        let grid = sample::grid();
        // A group, in its own scene's words.
        let mesh = scene.meshes.push(grid.meshes.values().next().expect("a mesh").clone(), Origin::Made);
        let material = scene.materials.iter().next().expect("a material").0;
        let mut group = Group { name: "pair".to_owned(), ..Group::default() };
        let shape = Shape { name: "one".to_owned(), mesh, transform: Affine::IDENTITY, material, emission: None };
        group.shapes.push(shape, Origin::Made);
        let group = scene.groups.push(group, Origin::Made);
        for instance in grid.instances.values() {
            scene.instances.push(Instance { group, ..instance.clone() }, Origin::Made);
        }
        let scene = validate(scene).expect("a valid scene");
        let files = readable().map(|target| written(&scene, target)).collect();
        (scene, files)
    });
    &ALL
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Every reader takes whatever it is given, and what it takes for the scene has the scene's numbers.
    #[test]
    fn no_text_makes_a_reader_panic(
        target in 0..readable().count(), file in any::<prop::sample::Index>(), changes in prop::collection::vec(change(), 1..4)
    ) {
        let (scene, all) = all_written();
        let (target, whole) = readable().zip(all).nth(target).expect("a target");
        let own: Vec<&String> = whole.keys().filter(|path| path.starts_with(target.name)).collect();
        let path = file.get(&own);
        let mut files = whole.clone();
        let bytes = changes.iter().fold(whole[*path].clone(), |bytes, change| changed(&bytes, change));
        files.insert((*path).clone(), bytes);
        let audit = audited(scene, target, &files);
        if audit.findings.is_empty() {
            let asked = Asked::new(scene, camera(scene));
            prop_assert!((0..3).all(|at| (asked.sums.power[at] - audit.said.power[at]).abs() <= 1e-5 * asked.sums.power[at]));
            prop_assert_eq!(asked.sums.surfaces, audit.said.surfaces);
        }
    }
}
