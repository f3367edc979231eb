//! What surfaces are made of, in every target.

use super::tests::{emitted, text};
use super::*;
use crate::diag::Origin;
use crate::files::MemorySink;
use crate::ir::{
    Affine, Bsdf, Color, ColorOrTexture, Emission as Light, Encoding, Handle, ImageFormat, LightKind, LightSource,
    Meaning, Spectrum, Texture,
};
use shared::sample;

/// A square whose color is an image of `format`, called "old oak".
pub(super) fn textured(format: ImageFormat, encoding: Encoding) -> Scene {
    let mut scene = sample::empty("s");
    let texture = texture(&mut scene, "old oak", format, encoding);
    let bsdf = Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(texture) };
    square(&mut scene, bsdf);
    scene
}

pub(super) fn texture(scene: &mut Scene, name: &str, format: ImageFormat, encoding: Encoding) -> Handle<Texture> {
    scene.textures.push(sample::image(name, format, encoding), Origin::Made)
}

/// A square with texture coordinates.
fn square(scene: &mut Scene, bsdf: Bsdf) {
    let material = sample::material(scene, "table", bsdf);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = sample::quads(scene, "square", &[corners]);
    scene.meshes[mesh].uvs = Some(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into());
    let name = format!("square {}", scene.shapes.len());
    sample::shape(scene, &name, mesh, material, None);
}

/// All text that a target writes.
fn all_text(target: &str, scene: Scene) -> String {
    let sink: MemorySink = emitted(target, scene);
    let texts = sink.files.iter().filter(|(name, _)| {
        [".bin", ".png", ".exr", ".pfm", ".jpg", ".hdr"].iter().all(|ending| !name.ends_with(ending))
    });
    texts.map(|(_, bytes)| String::from_utf8_lossy(bytes).into_owned()).collect()
}

#[test]
fn a_texture_in_every_target() {
    let scene = || textured(ImageFormat::Png, Encoding::Srgb);
    let xml = all_text("mitsuba-3", scene());
    assert!(xml.contains("<texture type=\"bitmap\" id=\"old_oak\">"), "{xml}");
    assert!(xml.contains("name=\"filename\" value=\"../textures/old_oak.png\"/>"));
    assert!(xml.contains("<scale x=\"1\" y=\"-1\"/>\n\t\t\t<translate x=\"0\" y=\"1\"/>") && !xml.contains("\"raw\""));
    assert!(xml.contains("<ref name=\"reflectance\" id=\"old_oak\"/>"));
    assert!(
        all_text("mitsuba-3", textured(ImageFormat::Png, Encoding::Linear)).contains("name=\"raw\" value=\"true\"")
    );
    for target in ["mitsuba-0.5", "mitsuba-0.6"] {
        let xml = all_text(target, scene());
        for (name, value) in [("gamma", "-1"), ("vscale", "-1"), ("voffset", "1")] {
            assert!(xml.contains(&format!("<float name=\"{name}\" value=\"{value}\"/>")), "{target} {name}");
        }
        let linear = all_text(target, textured(ImageFormat::Exr, Encoding::Linear));
        assert!(linear.contains("<float name=\"gamma\" value=\"1\"/>") && linear.contains("old_oak.exr"), "{target}");
    }
    for (target, name, more) in
        [("pbrt-v3", "Kd", "\"bool gamma\" [\"true\"]"), ("pbrt-v4", "reflectance", "\"string encoding\" [\"sRGB\"]")]
    {
        let pbrt = all_text(target, scene());
        let file = "\"imagemap\" \"string filename\" [\"../textures/old_oak.png\"]";
        assert!(pbrt.contains(&format!("Texture \"old_oak\" \"spectrum\" {file}")) && pbrt.contains(more), "{pbrt}");
        assert!(pbrt.contains(&format!("\"texture {name}\" [\"old_oak\"]")), "{pbrt}");
        assert!(pbrt.find("Texture \"old_oak\"") < pbrt.find("MakeNamedMaterial"), "declared before use");
    }
    let sink = emitted("luxcore", scene());
    let scn = text(&sink, "scene.scn");
    assert!(scn.contains("scene.materials.table.kd = \"old_oak_image\"\n"));
    assert!(scn.contains("scene.textures.old_oak_image.file = \"../textures/old_oak.png\"\n"));
    assert!(scn.contains("old_oak_image.colorspace.config = \"srgb.ocio\"\n") && sink.files.contains_key("srgb.ocio"));
    let linear = emitted("luxcore", textured(ImageFormat::Png, Encoding::Linear));
    assert!(
        text(&linear, "scene.scn").contains("old_oak_image.gamma = 1\n") && !linear.files.contains_key("srgb.ocio")
    );
    let sink = emitted("gltf", scene());
    let own = sample::image("", ImageFormat::Png, Encoding::Srgb).file;
    assert_eq!(sink.files["textures/old_oak.png"], *own, "glTF has its own copy");
    let gltf: serde_json::Value = serde_json::from_str(&text(&sink, "s.gltf")).expect("JSON");
    let base = &gltf["materials"][0]["pbrMetallicRoughness"];
    assert_eq!((&base["baseColorTexture"]["index"], &base["baseColorFactor"][0]), (&0.into(), &1.0.into()));
    assert_eq!(
        gltf["images"][gltf["textures"][0]["source"].as_u64().expect("a source") as usize]["uri"],
        "textures/old_oak.png"
    );
    assert_eq!(gltf["samplers"][0]["wrapS"], 10497);
    assert!(gltf["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].is_u64());
}

/// glTF has a word for the factor; all others get an image that holds it, of floats.
#[test]
fn a_factor_of_an_image_is_in_the_file_or_beside_it() {
    let scene = || {
        let mut scene = textured(ImageFormat::Png, Encoding::Srgb);
        let texture = scene.textures.iter().next().expect("a texture").0;
        scene.textures[texture].factor = [0.5, 0.25, 1.0];
        scene
    };
    let own = scene().textures.values().next().expect("a texture").clone();
    let wanted = crate::image::linear(&own).expect("an image").colored().times(own.factor);
    for target in ["mitsuba-3", "mitsuba-0.6", "pbrt-v3", "pbrt-v4", "luxcore", "cycles"] {
        let sink = emitted(target, scene());
        let bytes = sink.files.get("images/old_oak.exr").unwrap_or_else(|| panic!("{target}: {:?}", sink.files.keys()));
        let found = crate::image::load("exr", bytes, 1 << 20).expect("an image");
        let found = Texture { file: found.file, image: found.info, encoding: Encoding::Linear, ..own.clone() };
        let found = crate::image::linear(&found).expect("pixels");
        assert_eq!(found.values, wanted.values, "{target}");
        let text = all_text(target, scene());
        assert!(text.contains("images/old_oak.exr") && !text.contains("old_oak.png"), "{target}");
        let decoded = ["<float name=\"gamma\" value=\"-1\"/>", "\"bool gamma\" [\"true\"]", "[\"sRGB\"]", "srgb.ocio"];
        assert!(!decoded.iter().any(|word| text.contains(word)), "{target}: {text}");
    }
    let mut sink = MemorySink::default();
    write_textures(&scene(), &[find("mitsuba-3").expect("a target")], "textures/", &mut sink)
        .expect("memory takes all");
    assert!(sink.files.is_empty(), "nobody needs the image without its factor");
    let gltf: serde_json::Value = serde_json::from_str(&text(&emitted("gltf", scene()), "s.gltf")).expect("JSON");
    let base = &gltf["materials"][0]["pbrMetallicRoughness"];
    assert_eq!(base["baseColorFactor"], serde_json::json!([0.5, 0.25, 1.0, 1.0]));
}

#[test]
fn images_are_written_once_under_safe_names() {
    let mut scene = textured(ImageFormat::Png, Encoding::Srgb);
    texture(&mut scene, "Old Oak", ImageFormat::Jpeg, Encoding::Srgb);
    texture(&mut scene, "../up", ImageFormat::Exr, Encoding::Linear);
    assert_eq!(texture_files(&scene), ["old_oak.png", "Old_Oak_2.jpg", "_up.exr"]);
    let mut sink = MemorySink::default();
    for at in 1..3 {
        let texture = scene.textures.iter().nth(at).expect("a texture").0;
        square(&mut scene, Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(texture) });
    }
    write_textures(&scene, &[find("mitsuba-3").expect("a target")], "textures/", &mut sink).expect("memory takes all");
    assert_eq!(sink.files.len(), 3);
    assert_eq!(sink.files["textures/_up.exr"], *scene.textures.values().nth(2).expect("a texture").file);
    let mut sink = MemorySink::default();
    write_textures(&scene, &[find("cycles").expect("a target")], "textures/", &mut sink).expect("memory takes all");
    assert_eq!(sink.files.keys().collect::<Vec<_>>(), ["textures/_up.exr"], "the others it has decoded");
}

/// What a target answers and what it writes are one: a texture that it cannot read becomes a grey, and is said to be lost.
#[test]
fn an_image_that_a_target_cannot_read_is_a_grey_and_a_finding() {
    let kinds = [
        (ImageFormat::Png, Encoding::Srgb),
        (ImageFormat::Png, Encoding::Linear),
        (ImageFormat::Jpeg, Encoding::Srgb),
        (ImageFormat::Jpeg, Encoding::Linear),
        (ImageFormat::Exr, Encoding::Linear),
        (ImageFormat::Pfm, Encoding::Linear),
        (ImageFormat::Hdr, Encoding::Linear),
    ];
    let mut lost = 0;
    for target in TARGETS {
        for (format, encoding) in kinds {
            let scene = textured(format, encoding);
            let asked = crate::capability::features(&scene);
            let refused = asked.iter().any(|(feature, _)| {
                *feature >= Feature::Texture
                    && *feature <= Feature::HdrTexture
                    && matches!((target.supports)(*feature), Support::Unsupported { why: _ })
            });
            let written = all_text(target.name, scene);
            // A binary container holds the file's bytes instead of naming it.
            let names = ["png", "exr", "pfm", format.ending()].map(|ending| format!("old_oak.{ending}"));
            let named = names.iter().any(|name| written.contains(name)) || written.contains("image/");
            assert_eq!(named, !refused, "{} {format:?} {encoding:?}\n{written}", target.name);
            let dense: String = written.split_whitespace().collect();
            let grey = dense.contains("[0.50.50.5]") || dense.contains("[0.5,0.5,0.5");
            assert_eq!(grey, refused, "{} {format:?} {encoding:?}\n{written}", target.name);
            lost += usize::from(refused);
        }
    }
    let all = kinds.len();
    assert_eq!(lost, 2 * 5 + all, "glTF, in both its forms: what is linear; the list: all");
}

/// A square of `bsdf`, as `target` writes it, on one line.
fn surface(target: &str, bsdf: Bsdf) -> String {
    let mut scene = sample::empty("s");
    square(&mut scene, bsdf);
    all_text(target, scene).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn plastic_in_every_target() {
    let plastic = |alpha| Bsdf::Plastic { reflectance: Color::Grey(0.5).into(), ior: 1.5, alpha };
    let xml = surface("mitsuba-3", plastic(0.1));
    assert!(xml.contains("<bsdf type=\"twosided\" id=\"table\"> <bsdf type=\"roughplastic\">"), "{xml}");
    for part in [
        "\"alpha\" value=\"0.1\"",
        "\"int_ior\" value=\"1.5\"",
        "\"ext_ior\" value=\"1\"",
        "\"nonlinear\" value=\"true\"",
    ] {
        assert!(xml.contains(part), "{part} in {xml}");
    }
    assert!(surface("mitsuba-3", plastic(0.0)).contains("<bsdf type=\"plastic\"> <rgb name=\"diffuse_reflectance\""));
    assert!(surface("mitsuba-0.6", plastic(0.1)).contains("name=\"diffuseReflectance\" value=\"0.5, 0.5, 0.5\""));
    let pbrt = surface("pbrt-v4", plastic(0.1));
    assert!(
        pbrt.contains(
            "[\"coateddiffuse\"] \"rgb reflectance\" [0.5 0.5 0.5] \"float eta\" [1.5] \"float roughness\" [0.1]"
        ),
        "{pbrt}"
    );
    // Its layer absorbs light where it is thicker (measured).
    assert!(pbrt.contains("\"bool remaproughness\" [false] \"float thickness\" [1e-6]"), "{pbrt}");
    // 0.5 (1 - 0.5968) / (1 - 0.5 0.5968) is seen of the base, and 0.04 is the coat's.
    let pbrt = surface("pbrt-v3", plastic(0.1));
    let (_, rest) = pbrt.split_once("[\"substrate\"] \"rgb Kd\" [").expect("a substrate");
    let seen: f64 = rest.split(' ').next().expect("a number").parse().expect("a number");
    assert!((seen - 0.2873).abs() < 1e-3 && rest.contains("\"rgb Ks\" [0.04"), "{pbrt}");
    let scn = surface("luxcore", plastic(0.1));
    assert!(scn.contains("type = \"glossy2\"") && scn.contains("ks = 0.04") && scn.contains("kd = 0.287"), "{scn}");
    let gltf = surface("gltf", plastic(0.25));
    assert!(gltf.contains("\"roughnessFactor\": 0.5") && gltf.contains("\"ior\": 1.5"), "{gltf}");
}

#[test]
fn principled_materials_in_every_target() {
    let principled = |metallic| Bsdf::Principled { base: Color::Grey(0.5).into(), metallic, roughness: 0.5, ior: 1.5 };
    let xml = surface("mitsuba-3", principled(0.25));
    for part in
        ["type=\"principled\"", "\"metallic\" value=\"0.25\"", "\"roughness\" value=\"0.5\"", "\"eta\" value=\"1.5\""]
    {
        assert!(xml.contains(part), "{part} in {xml}");
    }
    let xml = surface("mitsuba-0.6", principled(0.25));
    assert!(
        xml.contains("<bsdf type=\"blendbsdf\"> <float name=\"weight\" value=\"0.25\"/> <bsdf type=\"roughplastic\">"),
        "{xml}"
    );
    assert!(xml.contains("<bsdf type=\"roughconductor\">") && xml.contains("\"alpha\" value=\"0.25\""), "{xml}");
    assert!(xml.contains("name=\"nonlinear\" value=\"false\""));
    assert_eq!(xml.matches("<bsdf ").count(), xml.matches("</bsdf>").count());
    let metal = surface("mitsuba-0.6", principled(1.0));
    assert!(!metal.contains("blendbsdf") && !metal.contains("plastic") && metal.contains("roughconductor"), "{metal}");
    let plain = surface("mitsuba-0.6", principled(0.0));
    assert!(!plain.contains("blendbsdf") && plain.contains("plastic") && !plain.contains("conductor"), "{plain}");
    let pbrt = surface("pbrt-v4", principled(0.25));
    assert!(pbrt.contains("\"string materials\" [\"table coat\" \"table metal\"] \"float amount\" [0.25]"), "{pbrt}");
    // The base of which 0.5 is seen: 0.5 / (1 - 0.5968 + 0.5 0.5968).
    assert!(pbrt.contains("\"table coat\" \"string type\" [\"coateddiffuse\"] \"rgb reflectance\" [0.712"), "{pbrt}");
    assert!(pbrt.contains(
        "\"table metal\" \"string type\" [\"conductor\"] \"rgb reflectance\" [0.5 0.5 0.5] \"float roughness\" [0.25]"
    ));
    assert!(!surface("pbrt-v4", principled(1.0)).contains("coateddiffuse"));
    let pbrt = surface("pbrt-v3", principled(0.25));
    assert!(
        pbrt.contains("[\"disney\"] \"rgb color\" [0.5 0.5 0.5] \"float metallic\" [0.25] \"float roughness\" [0.5]"),
        "{pbrt}"
    );
    let scn = surface("luxcore", principled(0.25));
    assert!(
        scn.contains("type = \"disney\"") && scn.contains("metallic = 0.25") && scn.contains("specular = 0.5"),
        "{scn}"
    );
    let gltf = surface("gltf", principled(0.25));
    assert!(gltf.contains("\"metallicFactor\": 0.25") && gltf.contains("\"roughnessFactor\": 0.5"), "{gltf}");
}

/// A texture under a coat takes the factor that is right for a grey of 0.5.
#[test]
fn textures_under_coats_are_scaled() {
    let scene = |principled: bool| {
        let mut scene = sample::empty("s");
        let oak = ColorOrTexture::Texture(texture(&mut scene, "oak", ImageFormat::Png, Encoding::Srgb));
        let bsdf = if principled {
            Bsdf::Principled { base: oak, metallic: 0.0, roughness: 0.5, ior: 1.5 }
        } else {
            Bsdf::Plastic { reflectance: oak, ior: 1.5, alpha: 0.1 }
        };
        square(&mut scene, bsdf);
        scene
    };
    let scn = all_text("luxcore", scene(false));
    assert!(
        scn.contains("scene.textures.table_base.texture1 = \"oak_image\"") && scn.contains("texture2 = 0.574"),
        "{scn}"
    );
    assert!(scn.contains("scene.materials.table.kd = \"table_base\""), "{scn}");
    let pbrt = all_text("pbrt-v3", scene(false));
    assert!(
        pbrt.contains("Texture \"table base\" \"spectrum\" \"scale\" \"texture tex1\" [\"oak\"] \"rgb tex2\" [0.574"),
        "{pbrt}"
    );
    let pbrt = all_text("pbrt-v4", scene(true));
    assert!(pbrt.contains("\"scale\" \"texture tex\" [\"oak\"] \"float scale\" [1.42"), "{pbrt}");
    assert!(pbrt.contains("\"texture reflectance\" [\"table base\"]"), "{pbrt}");
    assert!(
        all_text("pbrt-v4", scene(false)).contains("\"texture reflectance\" [\"oak\"]"),
        "v4 darkens the base itself"
    );
    let xml = all_text("mitsuba-0.6", scene(true));
    assert!(xml.contains("<ref name=\"diffuseReflectance\" id=\"oak\"/>"), "{xml}");
    let gltf: serde_json::Value = serde_json::from_str(&text(&emitted("gltf", scene(false)), "s.gltf")).expect("JSON");
    let base = &gltf["materials"][0]["pbrMetallicRoughness"];
    let factor = base["baseColorFactor"][0].as_f64().expect("a number");
    assert!((factor - 0.5745).abs() < 1e-3 && base["baseColorTexture"]["index"] == 0, "{base}");
}

#[test]
fn spectra_are_kept_by_one_target_and_are_rgb_for_the_others() {
    let points = [(400.0, 0.2), (700.0, 0.6)];
    let of = |meaning| Color::Spectrum(Spectrum::new(&points, meaning));
    let scene = || {
        let mut scene = sample::empty("s");
        square(&mut scene, Bsdf::Diffuse { reflectance: of(Meaning::Share).into() });
        for (_, shape) in scene.shapes.iter_mut() {
            shape.emission = Some(Light { radiance: of(Meaning::Light) });
        }
        let kind = LightKind::Point { position: [0.0; 3], intensity: of(Meaning::Light) };
        scene.lights.push(LightSource { name: "l".to_owned(), kind }, Origin::Made);
        scene
    };
    let pbrt = all_text("pbrt-v4", scene());
    // Constant beyond its ends, which pbrt would take for 0.
    let samples = "[360 0.2 400 0.2 700 0.6 830 0.6]";
    assert!(pbrt.contains(&format!("\"spectrum reflectance\" {samples}")), "{pbrt}");
    let scale = of(Meaning::Light).spectrum().expect("a spectrum").luminance();
    let light = |name: &str| format!("\"spectrum {name}\" {samples} \"float scale\" [{scale}]");
    assert!(pbrt.contains(&light("L")) && pbrt.contains(&light("I")), "{pbrt}");
    // The ramp has 0.4 in its middle, 550 nm, next to the eye's 555.
    assert!((scale - 0.41).abs() < 0.01, "{scale}");
    for target in TARGETS.iter().filter(|target| target.name != "pbrt-v4") {
        let text = all_text(target.name, scene());
        assert!(!text.contains("spectrum L") && !text.contains("spectrum reflectance"), "{}", target.name);
        let asked = crate::capability::features(&scene());
        assert!(asked.iter().any(|(feature, _)| *feature == Feature::Spectrum));
        assert!(matches!((target.supports)(Feature::Spectrum), Support::Approximate { why: _, bound: _ }));
    }
    // Light and reflectance of one spectrum have different colors in RGB.
    assert_ne!(of(Meaning::Light).rgb(), of(Meaning::Share).rgb());
    let scn = text(&emitted("luxcore", scene()), "scene.scn");
    let kd = scn.lines().find_map(|line| line.strip_prefix("scene.materials.table.kd = ")).expect("kd");
    let emission = scn.lines().find_map(|line| line.split_once(".emission = ")).expect("an emission").1;
    assert_ne!(kd, emission);
}

/// A square under an image of the sky.
fn under(format: ImageFormat, tint: Color, turn: Affine) -> Scene {
    let mut scene = sample::empty("s");
    square(&mut scene, sample::diffuse([0.25; 3]));
    let sky = texture(&mut scene, "sky", format, Encoding::Linear);
    let kind = LightKind::Environment { radiance: ColorOrTexture::Texture(sky), tint, turn };
    scene.lights.push(LightSource { name: "sky".to_owned(), kind }, Origin::Made);
    scene
}

#[test]
fn an_image_of_the_environment_in_every_target() {
    let scene = |format| under(format, Color::Grey(1.0), Affine::IDENTITY);
    for (target, matrix, file) in
        [("mitsuba-3", "to_world", "environment.exr"), ("mitsuba-0.6", "toWorld", "../textures/sky.exr")]
    {
        let xml = all_text(target, scene(ImageFormat::Exr));
        assert!(xml.contains("<emitter type=\"envmap\"") && xml.contains(&format!("value=\"{file}\"/>")), "{xml}");
        assert!(xml.contains(&format!("<transform name=\"{matrix}\">")) && !xml.contains("<texture"), "{xml}");
        assert!(xml.contains("<matrix value=\"-1 0 0 0 0 0 1 0 0 1 0 0 0 0 0 1\"/>"), "{xml}");
    }
    let scn = all_text("luxcore", scene(ImageFormat::Exr));
    assert!(
        scn.contains("scene.lights.sky.type = \"infinite\"\nscene.lights.sky.file = \"../textures/sky.exr\"\n"),
        "{scn}"
    );
    assert!(
        scn.contains("scene.lights.sky.transformation = 0 -1 0 0 -1 0 0 0 0 0 1 0 0 0 0 1\n")
            && !scn.contains("imagemap")
    );
    for (format, file) in [(ImageFormat::Exr, "../textures/sky.exr"), (ImageFormat::Hdr, "environment.pfm")] {
        let pbrt = all_text("pbrt-v3", scene(format));
        assert!(pbrt.contains(&format!("LightSource \"infinite\" \"string mapname\" [\"{file}\"]\n")), "{pbrt}");
        assert!(pbrt.contains("\tConcatTransform [0 -1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1]"), "{pbrt}");
    }
    let pbrt = all_text("pbrt-v4", scene(ImageFormat::Hdr));
    assert!(pbrt.contains("\tLightSource \"infinite\" \"string filename\" [\"environment.exr\"]\n"), "{pbrt}");
    let python = all_text("cycles", scene(ImageFormat::Exr));
    assert!(python.contains("texture(\"sky\", \"../textures/sky.exr\", linear=True)\n"), "{python}");
    assert!(python.contains("environment(\"sky\")\n"), "{python}");
    let gltf = find("gltf").expect("a target");
    assert!(matches!((gltf.supports)(Feature::EnvironmentImage), Support::Unsupported { why: _ }));
    assert!(!all_text("gltf", scene(ImageFormat::Exr)).contains("punctual"));
}

#[test]
fn a_tinted_and_turned_environment_in_every_target() {
    // A third of a turn about the diagonal: x goes to y, y to z, z to x.
    let turn = Affine { rows: [[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]] };
    let scene = || under(ImageFormat::Exr, Color::Rgb([0.5, 1.0, 2.0]), turn);
    let xml = all_text("mitsuba-3", scene());
    assert!(xml.contains("name=\"scale\" value=\"2\"/>"), "{xml}");
    // Its y, which is up, goes where z goes; its z, in the middle, where y goes; its -x, to the right of that, where x goes.
    assert!(xml.contains("<matrix value=\"0 1 0 0 -1 0 0 0 0 0 1 0 0 0 0 1\"/>"), "{xml}");
    let scn = all_text("luxcore", scene());
    assert!(scn.contains("scene.lights.sky.gain = 0.5 1 2\n"), "{scn}");
    // By columns: where its x goes, its y, its z.
    assert!(scn.contains("transformation = 0 0 -1 0 0 -1 0 0 1 0 0 0 0 0 0 1\n"), "{scn}");
    let pbrt = all_text("pbrt-v3", scene());
    assert!(pbrt.contains("\"string mapname\" [\"../textures/sky.exr\"] \"rgb L\" [0.5 1 2]\n"), "{pbrt}");
    assert!(pbrt.contains("\tConcatTransform [0 0 -1 0  0 -1 0 0  1 0 0 0  0 0 0 1]"), "{pbrt}");
    let pbrt = all_text("pbrt-v4", scene());
    assert!(pbrt.contains("[\"environment.exr\"] \"float scale\" [2]\n"), "{pbrt}");
    assert!(pbrt.contains("\tConcatTransform [0 1 0 0  0 0 1 0  1 0 0 0  0 0 0 1]"), "{pbrt}");
    let python = all_text("cycles", scene());
    let turned = "environment(\"sky\", tint=(0.5, 1, 2), turn=((0, 0, 1, 0), (1, 0, 0, 0), (0, 1, 0, 0)))\n";
    assert!(python.contains(turned), "{python}");
    // The part of the tint that is no number is in the image.
    let own = |target| {
        let sink = emitted(target, scene());
        let loaded = crate::image::load("exr", &sink.files["environment.exr"], 1 << 20).expect("an image");
        (loaded.info.width, loaded.info.height, loaded.peak)
    };
    // The last pixel of the image has 21/32, 22/32, 23/32.
    assert_eq!(own("mitsuba-3"), (4, 5, 23.0 / 32.0));
    let (width, height, peak) = own("pbrt-v4");
    assert!((width, height) == (128, 128) && (peak - 23.0 / 32.0).abs() < 0.02, "{width} {height} {peak}");
}

#[test]
fn images_of_cycles_are_decoded_before_it_interpolates_them() {
    let sink = emitted("cycles", textured(ImageFormat::Png, Encoding::Srgb));
    assert!(text(&sink, "scene.py").contains("texture(\"old_oak\", \"images/old_oak.exr\", linear=True)\n"));
    let loaded = crate::image::load("exr", &sink.files["images/old_oak.exr"], 1 << 20).expect("an image");
    // The largest code is 23/32 of 255, rounded; half floats are within 2^-11.
    let code = (23.0_f64 / 32.0 * 255.0).round() / 255.0;
    assert!((loaded.peak / crate::image::decoded(code) - 1.0).abs() < 1.0 / 2048.0, "{}", loaded.peak);
    assert_eq!((loaded.info.bits, loaded.info.channels), (16, 3));
    let linear = emitted("cycles", textured(ImageFormat::Png, Encoding::Linear));
    assert!(text(&linear, "scene.py").contains("texture(\"old_oak\", \"../textures/old_oak.png\", linear=True)\n"));
    assert!(!linear.files.keys().any(|file| file.contains("images/")));
}

#[test]
fn one_image_may_have_two_encodings_and_be_a_sky_too() {
    let mut scene = under(ImageFormat::Exr, Color::Rgb([0.5, 1.0, 2.0]), Affine::IDENTITY);
    let sky = scene.textures.iter().next().expect("the sky").0;
    square(&mut scene, Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(sky) });
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        let oak = texture(&mut scene, "oak", ImageFormat::Png, encoding);
        square(&mut scene, Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(oak) });
    }
    let python = all_text("cycles", scene.clone());
    for line in [
        "texture(\"sky\", \"../textures/sky.exr\", linear=True)",
        "texture(\"oak\", \"images/oak.exr\", linear=True)",
        "texture(\"oak_2\", \"../textures/oak_2.png\", linear=True)",
    ] {
        assert!(python.contains(line), "{line} in {python}");
    }
    let xml = all_text("mitsuba-3", scene.clone());
    assert!(xml.contains("<texture type=\"bitmap\" id=\"sky\">") && xml.contains("value=\"environment.exr\""), "{xml}");
    assert!(all_text("pbrt-v4", scene.clone()).contains("Texture \"sky\" \"spectrum\" \"imagemap\""));
    let scn = all_text("luxcore", scene);
    assert!(scn.contains("scene.textures.sky_image.file = \"../textures/sky.exr\""), "{scn}");
}
