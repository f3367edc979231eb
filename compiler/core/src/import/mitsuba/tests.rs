//! Cases of the importer: what a text means, and what is said of it.

use super::super::{Imported, Options, find, import};
use crate::diag::{Finding, Severity, Sources};
use crate::files::{MemoryFiles, VPath};
use crate::ir::{Bsdf, Camera, Color, Filter, Integrator, LightKind, Sampler, Scene, Sides};

/// A PLY file of one triangle, in the plane z = 0, facing up.
const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// What comes of files, the first of which is the scene.
fn read(files: &[(&str, &str)], defines: &[(&str, &str)]) -> (Imported, Sources) {
    let mut held = MemoryFiles::default();
    for (path, text) in files {
        held.insert(*path, text.as_bytes());
    }
    let path = VPath::resolve("", files[0].0).expect("a path");
    let mut sources = Sources::default();
    let importer = find(&path).expect("an importer");
    let defines = defines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    let options = Options { defines, ..Options::default() };
    (import(importer, &held, &mut sources, &path, &options), sources)
}

/// The scene of a text between `<scene>` and `</scene>`, beside `a.ply`, and what is said: code, line, message.
fn scene(text: &str) -> (Scene, Vec<(String, usize, String)>) {
    let text = format!("<scene version=\"0.6.0\">\n{text}\n</scene>");
    let (imported, sources) = read(&[("s.xml", &text), ("a.ply", TRIANGLE)], &[]);
    let said = imported.findings.iter().map(|finding| {
        let line = finding.origin.span().map_or(0, |span| sources.position(span.file, span.start).line);
        (finding.id.to_owned(), line, finding.message.clone())
    });
    (imported.scene.expect("a scene"), said.collect())
}

/// The material of a scene of one.
fn material(text: &str) -> (Bsdf, Vec<(String, usize, String)>) {
    let (scene, said) =
        scene(&format!("<shape type=\"ply\">\n<string name=\"filename\" value=\"a.ply\"/>\n{text}\n</shape>"));
    let bsdf = scene.materials.values().next().expect("a material").bsdf.clone();
    (bsdf, said.into_iter().filter(|(_, _, message)| !message.contains("camera")).collect())
}

#[test]
fn a_surface_without_two_sides_is_black_from_behind() {
    let sides = |text: &str| {
        let shape = "<shape type=\"ply\">\n<string name=\"filename\" value=\"a.ply\"/>\n";
        let (scene, said) = scene(&format!("{shape}{text}\n</shape>"));
        let about = said.iter().filter(|(_, _, message)| message.contains("behind")).count();
        (scene.materials.values().next().expect("a material").sides, about)
    };
    let plain = "<bsdf type=\"plastic\"/>";
    assert_eq!(sides(plain), (Sides::Front, 0));
    assert_eq!(sides(&format!("<bsdf type=\"twosided\">{plain}</bsdf>")), (Sides::Both, 0));
    assert_eq!(sides("<bsdf type=\"dielectric\"/>"), (Sides::Both, 0));
    assert_eq!(sides("<bsdf type=\"mirror\"/>"), (Sides::Both, 0));
}

fn camera(scene: &Scene) -> &Camera {
    scene.cameras.values().next().expect("a camera")
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + a.abs())
}

#[test]
fn a_camera_is_where_it_looks_from() {
    let (scene, said) = scene(
        "<integrator type=\"path\"><integer name=\"maxDepth\" value=\"3\"/></integrator>
        <sensor type=\"perspective\">
            <float name=\"fov\" value=\"90\"/><string name=\"fovAxis\" value=\"y\"/>
            <transform name=\"toWorld\"><lookAt origin=\"1,2,3\" target=\"1 2 7\" up=\"0, 1, 0\"/></transform>
            <film type=\"hdrfilm\"><integer name=\"width\" value=\"20\"/><integer name=\"height\" value=\"10\"/><rfilter type=\"box\"/></film>
            <sampler type=\"independent\"><integer name=\"sampleCount\" value=\"7\"/></sampler>
        </sensor>",
    );
    let Camera { name, eye, target, up, fov_x, near, far } = camera(&scene);
    assert_eq!((name, *eye, near, far), (&None, [1.0, 2.0, 3.0], &None, &None));
    assert!(target[2] > eye[2] && close(target[0], 1.0) && close(target[1], 2.0) && close(up[1], 1.0));
    // Twice as wide as high: tan(fov_x / 2) = 2 tan(45 degrees).
    assert!(close(*fov_x, 2.0 * libm::atan(2.0).to_degrees()));
    assert_eq!((scene.film.width, scene.film.height, &scene.film.filter), (20, 10, &Filter::Box { radius: 0.5 }));
    assert_eq!(scene.integrator, Integrator::Path { max_depth: 3 });
    assert_eq!(scene.sampler, Sampler::Independent { samples: 7, seed: 0 });
    assert!(said.is_empty(), "{said:?}");
}

#[test]
fn steps_of_transforms_come_one_after_the_other() {
    let (scene, _) = scene(
        "<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/><transform name=\"to_world\">
        <scale value=\"2\"/><rotate z=\"1\" angle=\"90\"/><translate x=\"5\"/>
        <matrix value=\"1 0 0 0  0 1 0 0  0 0 1 9  0 0 0 1\"/></transform></shape>",
    );
    let map = scene.shapes.values().next().expect("a shape").transform;
    let place = map.point([1.0, 0.0, 0.0]);
    assert!(close(place[0], 5.0) && close(place[1], 2.0) && close(place[2], 9.0), "{place:?}");
}

#[test]
fn materials_mean_what_mitsuba_means() {
    let grey = |value: f64| Color::Grey(value);
    let plain = |text: &str| {
        let (bsdf, said) = material(text);
        assert!(said.iter().all(|(id, ..)| id != "loss-dropped" && id != "loss-approximated"), "{said:?}");
        bsdf
    };
    assert_eq!(plain("<bsdf type=\"diffuse\"/>"), Bsdf::Diffuse { reflectance: grey(0.5).into() });
    assert_eq!(
        plain(
            "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"><srgb name=\"reflectance\" value=\"#ff0000\"/></bsdf></bsdf>"
        ),
        Bsdf::Diffuse { reflectance: Color::Rgb([1.0, 0.0, 0.0]).into() }
    );
    assert_eq!(
        plain(
            "<bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"water\"/><float name=\"extIOR\" value=\"1\"/></bsdf>"
        ),
        Bsdf::Dielectric { interior: 1.333, exterior: 1.0, alpha: 0.0 }
    );
    assert_eq!(
        plain("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>"),
        Bsdf::Mirror { reflectance: grey(1.0) }
    );
    let gold = plain(
        "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/><string name=\"distribution\" value=\"ggx\"/>
        <float name=\"alpha\" value=\"0.2\"/></bsdf>",
    );
    assert!(matches!(gold, Bsdf::Conductor { eta: Color::Rgb([r, ..]), k: _, alpha } if r == 0.143036 && alpha == 0.2));
    // Without `nonlinear` as much is seen of the base as share / (1 - F) of Mitsuba's formula says.
    let Bsdf::Plastic { reflectance, ior, alpha: _ } = plain("<bsdf type=\"plastic\"/>") else { panic!("no plastic") };
    let base = reflectance.color().expect("a color").rgb()[0];
    let inner = -1.4399 / (ior * ior) + 0.7099 / ior + 0.6681 + 0.0636 * ior;
    assert!(close(base / (1.0 - base * inner), 0.5 / (1.0 - inner)), "{base}");
    let Bsdf::Principled { metallic, roughness, ior, .. } = plain(
        "<bsdf type=\"principled\"><float name=\"metallic\" value=\"0.7\"/><float name=\"roughness\" value=\"0.2\"/></bsdf>",
    ) else {
        panic!("not principled")
    };
    assert!(metallic == 0.7 && roughness == 0.2 && close(ior, 1.5));
}

#[test]
fn names_of_a_renderer_that_reads_these_files_are_known() {
    assert_eq!(material("<bsdf type=\"mirror\"/>"), (Bsdf::Mirror { reflectance: Color::Grey(1.0) }, vec![]));
    let water = "<bsdf type=\"glass\"><float name=\"intIOR\" value=\"1.33\"/></bsdf>";
    assert_eq!(material(water), (Bsdf::Dielectric { interior: 1.33, exterior: 1.0, alpha: 0.0 }, vec![]));
    let tinted = material("<bsdf type=\"glass\"><rgb name=\"transmission\" value=\"1 0 0\"/></bsdf>").1;
    assert!(tinted.iter().any(|(code, _, message)| code == "loss-dropped" && message.contains("`transmission`")));
    let shape = "<shape type=\"cube\"/>";
    assert_eq!(scene(&format!("<mode type=\"final\"/>{shape}")).1, scene(shape).1);
    assert_eq!(material("<bsdf type=\"glass\"><rgb name=\"transmission\" value=\"1\"/></bsdf>").1, vec![]);
}

#[test]
fn what_is_not_read_is_said_at_its_place() {
    let said = |text: &str, id: &str, line: usize, words: &str| {
        let (_, said) = material(text);
        let found = said.iter().any(|(code, at, message)| code == id && *at == line && message.contains(words));
        assert!(found, "{text}: {said:?}");
    };
    said("<bsdf type=\"hair\"/>", "loss-dropped", 4, "`hair`");
    said("<bsdf type=\"diffuse\">\n<float name=\"shine\" value=\"1\"/></bsdf>", "loss-dropped", 5, "shine");
    said("<bsdf type=\"roughconductor\"/>", "loss-approximated", 4, "beckmann");
    said(
        "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.4\"/><bsdf type=\"diffuse\"/></bsdf>",
        "loss-dropped",
        4,
        "opacity",
    );
    said("<bsdf type=\"bumpmap\"><bsdf type=\"diffuse\"/></bsdf>", "loss-dropped", 4, "bump");
    said("<ref id=\"nobody\"/>", "unknown-name", 4, "nobody");
    said("<medium name=\"interior\" type=\"homogeneous\"/>", "loss-dropped", 4, "medium");
    said("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"2\"/></bsdf>", "loss-approximated", 4, "cut");
    said("<bsdf type=\"conductor\"><string name=\"material\" value=\"Gold\"/></bsdf>", "loss-dropped", 4, "Gold");
}

#[test]
fn a_surface_that_is_not_there_is_left_out() {
    let (scene, said) = scene("<shape type=\"rectangle\"><bsdf type=\"null\"/></shape><shape type=\"rectangle\"/>");
    assert_eq!(scene.shapes.len(), 1);
    assert!(said.iter().all(|(_, _, message)| !message.contains("null")), "{said:?}");
}

#[test]
fn lights_are_what_they_are() {
    let (scene, said) = scene(
        "<shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/><float name=\"radius\" value=\"0.5\"/>
        <emitter type=\"area\"><rgb name=\"radiance\" value=\"1 2 3\"/></emitter></shape>
        <emitter type=\"point\"><point name=\"position\" x=\"1\"/><rgb name=\"intensity\" value=\"4\"/></emitter>
        <emitter type=\"spot\"><transform name=\"toWorld\"><lookat origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/></transform>
        <spectrum name=\"intensity\" value=\"2\"/><float name=\"cutoffAngle\" value=\"30\"/></emitter>
        <emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0\" z=\"-2\"/></emitter>
        <emitter type=\"constant\"><float name=\"radiance\" value=\"0.25\"/></emitter>
        <emitter type=\"constant\"/>",
    );
    let ball = scene.shapes.values().next().expect("a shape");
    assert_eq!(ball.emission.as_ref().expect("light").radiance, Color::Rgb([1.0, 2.0, 3.0]));
    assert!(scene.materials[ball.material].bsdf.is_black());
    let pole = ball.transform.point([0.0, 0.0, 1.0]);
    assert!(close(pole[2], 3.5) && close(pole[0], 1.0));
    let kinds: Vec<&LightKind> = scene.lights.values().map(|light| &light.kind).collect();
    assert_eq!(kinds[0], &LightKind::Point { position: [1.0, 0.0, 0.0], intensity: Color::Grey(4.0) });
    let LightKind::Spot { position, target, angle, inner, .. } = kinds[1] else { panic!("no spot") };
    assert!(close(position[2], 5.0) && target[2] < 5.0 && *angle == 30.0 && *inner == 22.5);
    let LightKind::Directional { direction, irradiance } = kinds[2] else { panic!("no direction") };
    assert_eq!((direction, irradiance), (&[0.0, 0.0, -1.0], &Color::Grey(1.0)));
    assert_eq!(kinds[3], &LightKind::environment(Color::Grey(0.25).into()));
    assert_eq!(kinds.len(), 4);
    assert!(said.iter().any(|(_, _, message)| message.contains("second environment")));
}

#[test]
fn one_number_of_a_spectrum_means_what_its_version_means() {
    let of = |version: &str| {
        let text = format!(
            "<scene version=\"{version}\"><emitter type=\"constant\"><spectrum name=\"radiance\" value=\"2\"/></emitter></scene>"
        );
        let (imported, _) = read(&[("s.xml", &text)], &[]);
        let scene = imported.scene.expect("a scene");
        scene.lights.values().next().expect("a light").kind.color().rgb()
    };
    assert_eq!(of("0.5.0"), [2.0; 3]);
    // Light of equal energy in sRGB: 1.2048, 0.9483, 0.9088 (CIE 1931).
    let [r, g, b] = of("3.0.0");
    assert!((r - 2.4096).abs() < 0.01 && (g - 1.8966).abs() < 0.01 && (b - 1.8176).abs() < 0.01, "{r} {g} {b}");
}

#[test]
fn groups_are_placed_and_shared() {
    let (scene, said) = scene(
        "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"toWorld\"><translate x=\"3\"/></transform></shape>
        <shape type=\"shapegroup\" id=\"g\"><shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/></shape></shape>
        <shape type=\"instance\"><ref id=\"g\"/></shape><shape type=\"instance\"><ref id=\"h\"/></shape>",
    );
    assert_eq!((scene.groups.len(), scene.instances.len(), scene.shapes.len(), scene.meshes.len()), (1, 2, 0, 1));
    assert!(said.iter().any(|(id, ..)| id == "unknown-name"));
}

#[test]
fn a_mirroring_transform_turns_the_front_of_a_mesh_without_normals() {
    let front = |scale: &str, more: &str| {
        let (scene, _) = scene(&format!(
            "<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/>{more}<transform name=\"toWorld\"><scale x=\"{scale}\"/></transform></shape>"
        ));
        let (lowered, _) = crate::lower::lower(scene);
        let mesh = lowered.meshes.values().next().expect("a mesh").clone();
        let [a, b, c] = mesh.corners(mesh.triangles[0]);
        crate::ir::cross(crate::ir::sub(b, a), crate::ir::sub(c, a))[2] > 0.0
    };
    let flipped = "<boolean name=\"flipNormals\" value=\"true\"/>";
    assert!(front("1", "") && !front("-1", "") && !front("1", flipped) && front("-1", flipped));
}

#[test]
fn a_sky_of_eight_bits_becomes_one_of_floats() {
    let pixels = crate::image::Pixels { width: 2, height: 1, channels: 3, values: vec![0.5; 6] };
    let mut held = MemoryFiles::default();
    held.insert("a.png", crate::image::write::png(&pixels, 8).expect("a PNG file"));
    let text = "<scene version=\"3.0.0\"><shape type=\"cube\"/><emitter type=\"envmap\"><string name=\"filename\" value=\"a.png\"/></emitter></scene>";
    held.insert("a.xml", text.as_bytes());
    let path = VPath::resolve("", "a.xml").expect("a path");
    let importer = find(&path).expect("an importer");
    let imported = import(importer, &held, &mut Sources::default(), &path, &Options::default());
    let scene = imported.scene.expect("a scene");
    let sky = scene.lights.values().find_map(|light| light.kind.texture()).expect("an image");
    let linear = crate::image::linear(&scene.textures[sky]).expect("pixels");
    // 128 by the curve of sRGB.
    assert!(scene.textures[sky].image.format.is_float() && (linear.values[0] - 0.2158).abs() < 2e-4, "{linear:?}");
    crate::pipeline::prepare(scene).expect("a valid scene");
}

#[test]
fn materials_of_a_mesh_file_count_where_the_shape_has_none() {
    let obj = "mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let all = |owns: &[&str]| {
        let shape =
            |own: &&str| format!("<shape type=\"obj\"><string name=\"filename\" value=\"a.obj\"/>{own}</shape>");
        let shapes: String = owns.iter().map(shape).collect();
        let text = format!(
            "<scene version=\"0.6.0\"><medium id=\"fog\" type=\"homogeneous\"/><bsdf id=\"grey\" type=\"diffuse\"/>{shapes}</scene>"
        );
        let (imported, _) = read(&[("a.xml", &text), ("a.obj", obj)], &[]);
        let told = |finding: &&Finding| finding.message.contains("materials are not read");
        let codes: Vec<&str> = imported.findings.iter().filter(told).map(|finding| finding.id).collect();
        (codes, imported.scene.expect("a scene").meshes.len())
    };
    let own = "<bsdf type=\"diffuse\"/>";
    assert_eq!(all(&[own]), (vec![], 1));
    assert_eq!(all(&["<ref id=\"grey\"/>"]), (vec![], 1));
    assert_eq!(all(&[""]), (vec!["loss-dropped"], 1));
    assert_eq!(all(&["<ref name=\"interior\" id=\"fog\"/>"]), (vec!["loss-dropped"], 1));
    // The mesh is one, whatever its shapes are made of, and it is said once.
    assert_eq!(all(&[own, "", own, ""]), (vec!["loss-dropped"], 1));
}

#[test]
fn included_files_and_values_are_put_in_place() {
    let main =
        "<scene version=\"0.5.0\"><default name=\"depth\" value=\"4\"/><include filename=\"parts/more.xml\"/></scene>";
    let more =
        "<scene version=\"0.5.0\"><integrator type=\"$kind\"><integer name=\"maxDepth\" value=\"$depth\"/></integrator>
        <bsdf type=\"diffuse\" id=\"a\"/><alias id=\"a\" as=\"b\"/>
        <shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/><ref id=\"b\"/></shape></scene>";
    let files = [("s.xml", main), ("parts/more.xml", more), ("a.ply", TRIANGLE)];
    let (imported, _) = read(&files, &[("kind", "bdpt")]);
    let scene = imported.scene.expect("a scene");
    assert_eq!(scene.integrator, Integrator::Bidirectional { max_depth: 4 });
    assert_eq!((scene.shapes.len(), imported.inputs.len()), (1, 3));
    let (imported, _) = read(&files, &[("kind", "path"), ("depth", "9")]);
    assert_eq!(imported.scene.expect("a scene").integrator, Integrator::Path { max_depth: 9 });
    let (imported, _) = read(&files, &[("kind", "path"), ("dept", "9")]);
    assert!(
        imported.findings.iter().any(|finding| finding.id == "unknown-parameter" && finding.message.contains("dept"))
    );
    // What has no value, a circle, and a file that is not there.
    let (imported, _) = read(&files, &[]);
    assert!(imported.findings.iter().any(|finding| finding.id == "unknown-name"));
    for text in
        ["<include filename=\"s.xml\"/>", "<include filename=\"none.xml\"/>", "<include filename=\"../../x.xml\"/>"]
    {
        let (imported, _) = read(&[("s.xml", &format!("<scene version=\"3.0.0\">{text}</scene>"))], &[]);
        assert!(imported.findings.iter().any(|finding| finding.severity == Severity::Error), "{text}");
    }
}

#[test]
fn what_is_no_scene_is_an_error_at_its_place() {
    for text in
        ["", "nothing", "<scene", "<scene><a></scene>", "<other/>", "<scene></scene><scene/>", &"<a>".repeat(100)]
    {
        let (imported, _) = read(&[("s.xml", text)], &[]);
        assert!(imported.findings.iter().any(|finding| finding.severity == Severity::Error), "{text}");
    }
}

#[test]
fn no_text_makes_the_reader_panic() {
    use proptest::prelude::*;
    let whole = "<scene version=\"0.5.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"45\"/></sensor>\
        <bsdf type=\"roughplastic\" id=\"m\"><texture name=\"diffuseReflectance\" type=\"checkerboard\"/></bsdf>\
        <shape type=\"cylinder\"><ref id=\"m\"/><transform name=\"toWorld\"><scale x=\"2\"/></transform></shape>\
        <shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/><emitter type=\"area\"><blackbody name=\"radiance\" temperature=\"5000\"/></emitter></shape></scene>";
    let runs = ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() };
    proptest!(runs, |(at in 0..whole.len(), length in 0_usize..20, new in "[ -~]{0,12}")| {
        let end = (at + length).min(whole.len());
        let text = format!("{}{new}{}", &whole[..at], &whole[end..]);
        let (imported, _) = read(&[("s.xml", &text), ("a.ply", TRIANGLE)], &[]);
        prop_assert!(imported.scene.is_some() || imported.findings.iter().any(|finding| finding.severity == Severity::Error));
    });
}
