//! Shipped scenes, the style of texts, and what the language cannot say.

use std::sync::Arc;

use super::read_tests::{evaluated, read};
use super::*;
use crate::files::{MemoryFiles, MemorySink};
use crate::ir::{
    Arena, Bsdf, Color, Instance, LightKind, LightSource, Material, Meaning, ParameterValue, Places, Shape, Spectrum,
};

/// A small scene with most of what there is.
pub(super) const BALL: &str = "lts 1\n\n/// A ball.\nscene a {\n    paths: [\"LDE\"]\n}\n
camera = perspective(eye: (0, -10, 4), target: (0, 0, 1), fov_x: 30deg)
film = image(64, 32)
integrator = path(max_depth: 8)
sampler = independent(samples: 64)
shape ball = sphere(segments: 8, rings: 4) |> translate(z: 1.5) with dielectric(ior: 1.5)
emitter lamp = rectangle(x: -1..1, y: -1..1, z: 6, normal: -Z) with radiance(20)
";

/// Everything in `scenes-src`.
pub(super) fn shipped() -> MemoryFiles {
    macro_rules! files {
        ($($name:literal),* $(,)?) => {
            [$(($name, &include_bytes!(concat!("../../../../scenes-src/", $name))[..])),*]
        };
    }
    let all = files![
        "lib/cboxm.lts",
        "lib/cornell.lts",
        "lib/metals.lts",
        "lib/water.lts",
        "textures/tiles.png",
        "cbox_classic.lts",
        "cbox_empty.lts",
        "cbox_indirect.lts",
        "cboxm_diffuse_lsame.lts",
        "cboxm_diffuse_lvar.lts",
        "cboxm_glossy_lsame.lts",
        "cboxm_glossy_lvar.lts",
        "pool_classic.lts",
        "pool_simple.lts",
        "ring.lts",
        "surfaces.lts",
        "veach_mis.lts",
    ];
    let mut files = MemoryFiles::default();
    all.into_iter().for_each(|(name, bytes)| files.insert(name, bytes));
    files
}

pub(super) const SCENES: [&str; 12] = [
    "cbox_classic",
    "cbox_empty",
    "cbox_indirect",
    "cboxm_diffuse_lsame",
    "cboxm_diffuse_lvar",
    "cboxm_glossy_lsame",
    "cboxm_glossy_lvar",
    "pool_classic",
    "pool_simple",
    "ring",
    "surfaces",
    "veach_mis",
];

/// The text as the formatter has it.
fn formatted(text: &str) -> String {
    format::format(&mut Sources::default(), "a.lts", text).expect("a good text")
}

fn of(text: &str) -> Scene {
    let mut files = MemoryFiles::default();
    files.insert("a.lts", text);
    evaluated(&files, "a.lts")
}

/// The ball with another body.
fn with(statements: &str) -> String {
    format!("{BALL}{statements}\n")
}

#[test]
fn every_shipped_scene_is_itself_after_printing() {
    let files = shipped();
    for name in SCENES {
        let scene = evaluated(&files, &format!("{name}.lts"));
        let printed = print(&scene, &Options::default());
        let lost: Vec<_> = printed.findings.iter().map(|finding| finding.message.as_str()).collect();
        let parameters = lost.iter().all(|message| message.starts_with("the parameters"));
        assert!(parameters, "{name}: {lost:?}");
        assert_eq!(lost.len(), usize::from(!scene.documentation.parameters.is_empty()), "{name}");
        assert_eq!(printed.file(), format!("{name}.lts"));
        assert_eq!(formatted(&printed.text), printed.text, "{name}");
        let again = read(&printed);
        assert_eq!(difference(&scene, &again), None, "{name}:\n{}", printed.text);
        // What is printed of it is the same text and the same files.
        let second = print(&again, &Options::default());
        let paths = |printed: &Printed<'_>| printed.files.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>();
        assert_eq!(second.text, printed.text, "{name}");
        assert_eq!(paths(&second), paths(&printed), "{name}");
    }
}

#[test]
fn a_scene_is_written_as_a_person_would() {
    let text = with(
        "material wood = diffuse(rgb(0.5, 0.4, 0.3))\nmesh brick = box(size: 1)
shape low = brick |> rotate(z: 15deg) with wood
shape high = brick |> scale(0.5) |> translate(z: 1) with wood
group pair {\n    shape one = brick with wood\n    emitter two = brick |> translate(z: 2) with radiance(3, over: mirror(0.5))\n}
instance first = pair |> scale(2)
instance second = pair |> rotate(x: 90deg) |> translate(1, 2, 3)
emitter bulb = point(position: (0, 0, 3), intensity: 40)
emitter sky = environment(radiance: rgb(0.1, 0.2, 0.3))",
    );
    let scene = of(&text);
    let options = Options { origin: Some("Imported from a.xml.".to_owned()), ..Options::default() };
    let printed = print(&scene, &options);
    assert!(printed.findings.is_empty() && printed.files.is_empty());
    assert_eq!(
        printed.text,
        "lts 1

// Imported from a.xml.

/// A ball.
scene a {
    paths: [\"LDE\"]
}

camera = perspective(eye: (0, -10, 4), target: (0, 0, 1), fov_x: 30deg)
film = image(64, 32)
integrator = path(max_depth: 8)
sampler = independent(samples: 64)

material wood = diffuse(rgb(0.5, 0.4, 0.3))

mesh brick = box(size: 1)

emitter bulb = point(position: (0, 0, 3), intensity: 40)
emitter sky = environment(radiance: rgb(0.1, 0.2, 0.3))

group pair {
    shape one = brick with wood
    emitter two = brick |> translate(z: 2) with radiance(3, over: mirror(0.5))
}

shape ball = sphere(segments: 8, rings: 4) |> translate(z: 1.5) with dielectric(ior: 1.5)
emitter lamp = rectangle(x: -1..1, y: -1..1, z: 6, normal: -Z) with radiance(20)
shape low = brick |> rotate(z: 15deg) with wood
shape high = brick |> scale(0.5) |> translate(z: 1) with wood

instance first = pair |> scale(2)
instance second = pair |> rotate(x: 90deg) |> translate(1, 2, 3)
"
    );
    assert_eq!(difference(&scene, &read(&printed)), None);
}

#[test]
fn files_lie_in_the_folder_asked_for_and_go_through_a_sink() {
    let mut scene = of(&with("shape cone = cone(radius: 1, z: 0..2, segments: 5) with mirror()"));
    let options = Options { folder: "parts/".to_owned(), name: Some("my scene".to_owned()), ..Options::default() };
    scene.name = "other".to_owned();
    let printed = print(&scene, &options);
    assert!(printed.text.contains("shape cone = file(\"parts/meshes/cone.ply\") with mirror(1)"), "{}", printed.text);
    assert_eq!(printed.findings.iter().map(|finding| finding.id).collect::<Vec<_>>(), ["print-renamed"]);
    let mut sink = MemorySink::default();
    printed.write(&mut sink).expect("memory takes all");
    assert_eq!(sink.files.keys().collect::<Vec<_>>(), ["my_scene.lts", "parts/meshes/cone.ply"]);
    read(&printed);
}

#[test]
fn names_that_are_no_words_stay() {
    let mut scene = of(BALL);
    for (at, (_, shape)) in scene.shapes.iter_mut().enumerate() {
        shape.name = ["column[3]/leg {// \"x\"", "Größe; |> scatter("][at].to_owned();
    }
    for (at, (_, mesh)) in scene.meshes.iter_mut().enumerate() {
        mesh.name = ["mesh", "a b"][at].to_owned();
    }
    scene.materials.iter_mut().for_each(|(_, material)| material.name = format!("{} ´", material.name));
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty(), "{:?}", printed.findings);
    assert_eq!(difference(&scene, &read(&printed)), None);
    assert_eq!(formatted(&printed.text), printed.text);
}

#[test]
fn names_that_are_taken_or_cannot_be_written_are_told() {
    let mut scene = of(BALL);
    let long = "x".repeat(300);
    for (at, (_, mesh)) in scene.meshes.iter_mut().enumerate() {
        mesh.name = ["X", &long][at].to_owned();
    }
    scene.materials.iter_mut().for_each(|(_, material)| material.name = "a`b\n".to_owned());
    scene.shapes.iter_mut().for_each(|(_, shape)| shape.name = String::new());
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.iter().all(|finding| finding.id == "print-renamed"));
    // Two meshes, two materials, a shape, an emitter.
    assert_eq!(printed.findings.len(), 6, "{:#?}\n{}", printed.findings, printed.text);
    assert!(
        printed.text.contains("mesh X_2 =") && printed.text.contains("material ab =") && printed.text.contains("ab_2")
    );
    read(&printed);
}

#[test]
fn a_mesh_and_a_material_of_one_name_are_told_apart() {
    let text = with("mesh stone = box(size: 1)\nshape one = stone with mirror()\nshape two = stone with mirror()");
    let mut scene = of(&text);
    let made = Material::new("stone", Bsdf::Mirror { reflectance: Color::Grey(1.0) });
    let handle = scene.materials.push(made, crate::diag::Origin::Made);
    scene.shapes.iter_mut().filter(|(_, shape)| shape.name.len() == 3).for_each(|(_, shape)| shape.material = handle);
    let printed = print(&scene, &Options::default());
    let messages: Vec<_> = printed.findings.iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(messages, ["the mesh `stone` is called `stone_2` in the text"]);
    let again = read(&printed);
    assert_eq!(difference(&scene, &again).as_deref(), Some("shape one: mesh: \"stone\" is \"stone_2\""));
}

/// A light of the scene.
fn lit(kinds: Vec<LightKind>) -> Scene {
    let mut scene = of(BALL);
    for (at, kind) in kinds.into_iter().enumerate() {
        scene.lights.push(LightSource { name: format!("light_{at}"), kind }, crate::diag::Origin::Made);
    }
    scene
}

#[test]
fn what_the_language_cannot_say_is_told_and_the_rest_is_still_a_scene() {
    let grey = || Color::Grey(1.0);
    let color = |color: Color| lit(vec![LightKind::Point { position: [0.0; 3], intensity: color }]);
    let sky = || LightKind::environment(Color::Grey(1.0).into());
    let light = |points: &[(f64, f64)], meaning| Color::Spectrum(Spectrum::new(points, meaning));
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = of(BALL);
        change(&mut scene);
        scene
    };
    let surface =
        |bsdf: Bsdf| changed(&|scene| scene.materials.iter_mut().for_each(|(_, made)| made.bsdf = bsdf.clone()));
    let first = of(BALL).shapes.iter().next().expect("a shape").0;
    let parameter = || ParameterValue {
        name: "size".to_owned(),
        ty: "a number".to_owned(),
        value: "1".to_owned(),
        allowed: String::new(),
    };
    let cases: Vec<(&str, Scene)> = vec![
        ("loss-dropped", lit(vec![sky(), sky()])),
        ("loss-approximated", lit(vec![LightKind::Directional { direction: [0.0, 0.0, -2.0], irradiance: grey() }])),
        ("loss-dropped", lit(vec![LightKind::Directional { direction: [0.0; 3], irradiance: grey() }])),
        ("loss-approximated", color(Color::Grey(-1.0))),
        ("loss-approximated", color(Color::Rgb([1.0, f64::NAN, f64::INFINITY]))),
        ("loss-approximated", color(light(&[(500.0, 1.0)], Meaning::Light))),
        ("loss-approximated", color(light(&[(400.0, 0.1), (700.0, 0.2)], Meaning::Index))),
        ("loss-approximated", surface(Bsdf::Conductor { eta: grey(), k: grey(), alpha: 2.0 })),
        ("loss-approximated", surface(Bsdf::Plastic { reflectance: grey().into(), ior: 1.0, alpha: 0.0 })),
        ("loss-approximated", surface(Bsdf::Dielectric { interior: 0.0, exterior: 1.0, alpha: 0.0 })),
        ("loss-dropped", changed(&|scene| scene.documentation.parameters.push(parameter()))),
        ("loss-dropped", changed(&|scene| scene.documentation.paths.push("LXE".to_owned()))),
        ("loss-approximated", changed(&|scene| scene.documentation.full = " indented".to_owned())),
        ("loss-approximated", changed(&|scene| scene.documentation.brief = "two\n\nparagraphs".to_owned())),
        ("loss-approximated", changed(&|scene| scene.film.width = 0)),
        ("print-renamed", changed(&|scene| scene.name = "a.b".to_owned())),
        ("loss-dropped", changed(&|scene| scene.shapes[first].transform = Affine { rows: [[0.0; 4]; 3] })),
        ("loss-dropped", changed(&|scene| scene.cameras.iter_mut().for_each(|(_, camera)| camera.near = Some(-1.0)))),
    ];
    for (at, (id, scene)) in cases.into_iter().enumerate() {
        let printed = print(&scene, &Options::default());
        let found: Vec<_> = printed.findings.iter().map(|finding| finding.id).collect();
        assert!(!found.is_empty() && found.iter().all(|found| *found == id), "{at}: {:?}", printed.findings);
        read(&printed);
    }
}

#[test]
fn places_of_many_come_from_one_file() {
    let mut scene = of(&with("group tree {\n    shape trunk = box(size: 1) with mirror()\n}\ninstance tree = tree"));
    let maps: Arc<[Affine]> = (1..5).map(|at| Affine::scaling([f64::from(at) / 3.0; 3])).collect();
    let group = scene.instances.values().next().expect("an instance").group;
    scene.instances = Arena::default();
    for name in ["oak", "elm"] {
        let instance = Instance { name: name.to_owned(), group, places: Places::Many(Arc::clone(&maps)) };
        scene.instances.push(instance, crate::diag::Origin::Made);
    }
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty());
    assert_eq!(printed.files.iter().map(|(path, _)| path.as_str()).collect::<Vec<_>>(), ["places/oak.npy"]);
    assert_eq!(difference(&scene, &read(&printed)), None);
}

#[test]
fn what_nothing_uses_is_left_out() {
    let mut scene = of(&with("group tree {\n    shape trunk = box(size: 1) with mirror()\n}\ninstance tree = tree"));
    scene.instances = Arena::default();
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty() && !printed.text.contains("tree") && !printed.text.contains("trunk"));
}

#[test]
fn many_shapes_of_one_name_take_linear_time() {
    let mut scene = of(BALL);
    let shape = scene.shapes.values().next().expect("a shape").clone();
    for _ in 0..3_000 {
        scene.shapes.push(Shape { name: "ball".to_owned(), ..shape.clone() }, crate::diag::Origin::Made);
    }
    let printed = print(&scene, &Options::default());
    // The mesh has another name too: the material has its own.
    assert_eq!(printed.findings.len(), 3_001);
    assert!(printed.text.contains("shape ball_3001 = ball_2 |>"), "{}", &printed.text[..2000]);
    read(&printed);
}

#[test]
fn numbers_of_all_sizes_are_read_as_they_were() {
    for number in [1e-300, 5e-324, f64::MAX / 8.0, 0.1, 1.0 / 3.0, 123_456_789.25, 1e15, 1e-5, 2e-4, 1e9] {
        let mut scene = of(BALL);
        let position = [number, -number, 4.0];
        let kind = LightKind::Point { position, intensity: Color::Grey(number) };
        scene.lights.push(LightSource { name: "bulb".to_owned(), kind }, crate::diag::Origin::Made);
        scene.cameras.iter_mut().for_each(|(_, camera)| camera.fov_x = 10.0 + 1.0 / 3.0);
        let printed = print(&scene, &Options::default());
        assert!(printed.findings.is_empty());
        assert_eq!(difference(&scene, &read(&printed)), None, "{number}");
    }
    let texts = [1.0, 0.1, 1e-5, 1e15, -2.5e-10, 1_000_000.0, 123_456_789_012.0].map(number::number);
    assert_eq!(texts, ["1", "0.1", "1e-5", "1e15", "-2.5e-10", "1000000", "123456789012"]);
}

#[test]
fn documentation_without_a_brief_stays_so() {
    let mut scene = of(BALL);
    (scene.documentation.brief, scene.documentation.full) = (String::new(), "No brief.\n\nMore.".to_owned());
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty() && printed.text.contains("///\n/// No brief.\n///\n/// More.\nscene a"));
    assert_eq!(difference(&scene, &read(&printed)), None);
}

/// A Cornell box as Mitsuba has it.
const BOX: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="20"/>
        <transform name="to_world"><lookat origin="0, 1, 7" target="0, 1, 0" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
        <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/></film>
    </sensor>
    <bsdf type="twosided" id="Left Wall"><bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.1, 0.05"/></bsdf></bsdf>
    <shape type="rectangle" id="left">
        <transform name="to_world"><rotate y="1" angle="90"/><translate x="-1" y="1"/></transform>
        <ref id="Left Wall"/>
    </shape>
    <shape type="cube" id="low"><transform name="to_world"><scale value="0.3"/></transform><ref id="Left Wall"/></shape>
    <shape type="rectangle" id="lamp">
        <transform name="to_world"><scale value="0.2"/><rotate x="1" angle="90"/><translate y="1.99"/></transform>
        <emitter type="area"><rgb name="radiance" value="18.4, 15.6, 8"/></emitter>
    </shape>
    <emitter type="directional"><vector name="direction" x="0.2" y="-1" z="0.3"/><float name="irradiance" value="1"/></emitter>
</scene>"#;

#[test]
fn an_imported_scene_is_itself_after_printing() {
    let mut files = MemoryFiles::default();
    files.insert("box.xml", BOX);
    let path = crate::files::VPath::resolve("", "box.xml").expect("a path");
    let importer = crate::import::find(&path).expect("an importer");
    let imported =
        crate::import::import(importer, &files, &mut Sources::default(), &path, &crate::import::Options::default());
    let scene = imported.scene.expect("a scene");
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty(), "{:?}", printed.findings);
    assert_eq!(difference(&scene, &read(&printed)), None, "{}", printed.text);
    for line in
        ["material `Left Wall` = diffuse(rgb(0.6, 0.1, 0.05))", "with radiance(rgb(18.4, 15.6, 8), over: default)"]
    {
        assert!(printed.text.contains(line), "{line} in\n{}", printed.text);
    }
}

#[test]
fn a_group_may_hold_nothing() {
    let scene = of(&with("group a {}\ninstance a = a"));
    let printed = print(&scene, &Options::default());
    assert!(printed.findings.is_empty());
    assert_eq!(difference(&scene, &read(&printed)), None);
}

#[test]
fn an_environment_is_turned_by_a_matrix_that_turns() {
    let found = |stage: &str| {
        let mut files = MemoryFiles::default();
        files.insert("sky.pfm", [b"PF\n2 1\n-1.0\n".to_vec(), vec![0; 24]].concat());
        let text = with(&format!("emitter sky = environment(radiance: bitmap(\"sky.pfm\")) |> {stage}"));
        files.insert("a.lts", text);
        let path = crate::files::VPath::resolve("", "a.lts").expect("a path");
        let made = crate::eval::evaluate(&files, &mut Sources::default(), &path, &crate::eval::Overrides::default());
        let errors = made.findings.iter().filter(|finding| finding.severity >= Severity::Error);
        errors.map(|finding| finding.message.clone()).collect::<Vec<_>>()
    };
    assert!(found("matrix((0, -1, 0, 0), (1, 0, 0, 0), (0, 0, 1, 0))").is_empty());
    for wrong in
        ["matrix((2, 0, 0, 0), (0, 2, 0, 0), (0, 0, 2, 0))", "matrix((1, 0, 0, 5), (0, 1, 0, 0), (0, 0, 1, 0))"]
    {
        assert_eq!(found(wrong), ["an environment is turned, and this matrix is no rotation"]);
    }
}
