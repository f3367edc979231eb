//! What surfaces are made of, in every target.

use super::tests::{emitted, text};
use super::*;
use crate::diag::Origin;
use crate::files::MemorySink;
use crate::ir::{Bsdf, ColorOrTexture, Encoding, Handle, ImageFile, ImageFormat, ImageInfo, Texture};
use shared::sample;

/// A square whose color is an image of `format`, called "old oak".
fn textured(format: ImageFormat, encoding: Encoding) -> Scene {
    let mut scene = sample::empty("s");
    let texture = texture(&mut scene, "old oak", format, encoding);
    let bsdf = Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(texture) };
    square(&mut scene, bsdf);
    scene
}

fn texture(scene: &mut Scene, name: &str, format: ImageFormat, encoding: Encoding) -> Handle<Texture> {
    let bits = if format.is_float() { 32 } else { 8 };
    let image = ImageInfo { format, width: 8, height: 8, channels: 3, bits };
    let file = ImageFile::new(b"as it is");
    scene.textures.push(Texture { name: name.to_owned(), file, image, encoding }, Origin::Made)
}

/// A square with texture coordinates.
fn square(scene: &mut Scene, bsdf: Bsdf) {
    let material = sample::material(scene, "table", bsdf);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = sample::quads(scene, "square", &[corners]);
    scene.meshes[mesh].uvs = Some(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into());
    sample::shape(scene, "square", mesh, material, None);
}

/// All text that a target writes.
fn all_text(target: &str, scene: Scene) -> String {
    let sink: MemorySink = emitted(target, scene);
    let texts = sink.files.iter().filter(|(name, _)| !name.ends_with(".bin") && !name.starts_with("textures/"));
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
    assert_eq!(sink.files["textures/old_oak.png"], b"as it is", "glTF has its own copy");
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

#[test]
fn images_are_written_once_under_safe_names() {
    let mut scene = textured(ImageFormat::Png, Encoding::Srgb);
    texture(&mut scene, "Old Oak", ImageFormat::Jpeg, Encoding::Srgb);
    texture(&mut scene, "../up", ImageFormat::Exr, Encoding::Linear);
    assert_eq!(texture_files(&scene), ["old_oak.png", "Old_Oak_2.jpg", "_up.exr"]);
    let mut sink = MemorySink::default();
    write_textures(&scene, "textures/", &mut sink).expect("memory takes all");
    assert_eq!(sink.files.len(), 3);
    assert_eq!(sink.files["textures/_up.exr"], b"as it is");
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
            let named = written.contains(&format!("old_oak.{}", format.ending()));
            assert_eq!(named, !refused, "{} {format:?} {encoding:?}\n{written}", target.name);
            let dense: String = written.split_whitespace().collect();
            let grey = dense.contains("[0.50.50.5]") || dense.contains("[0.5,0.5,0.5");
            assert_eq!(grey, refused, "{} {format:?} {encoding:?}\n{written}", target.name);
            lost += usize::from(refused);
        }
    }
    assert_eq!(lost, 1 + 3 + 5, "v4: linear JPEG; v3: JPEG twice and HDR; glTF: what is linear");
}
