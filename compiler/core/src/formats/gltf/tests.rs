//! The two forms of glTF are one document, and instances are where nodes are.

use serde_json::Value;

use crate::files::{MemorySink, Sink};
use crate::formats::shared::sample;
use crate::formats::surface_tests::{texture, textured};
use crate::formats::tests::{emitted, emitted_with, lit, text};
use crate::formats::{Choices, Emission, find};
use crate::ir::{Encoding, ImageFile, ImageFormat, Scene};
use crate::valid::validate;

/// The document and the buffer of a container.
pub(super) fn opened(bytes: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json = word(12);
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let document = serde_json::from_slice(&bytes[20..20 + json]).expect("JSON");
    let rest = &bytes[20 + json..];
    if rest.is_empty() {
        return (document, rest);
    }
    let (head, buffer) = rest.split_at(8);
    let length = u32::from_le_bytes(head[..4].try_into().expect("four bytes")) as usize;
    assert_eq!((length, length % 4, &head[4..]), (buffer.len(), 0, &b"BIN\0"[..]));
    (document, buffer)
}

/// The only file of the target `glb`.
pub(super) fn only(sink: &MemorySink) -> (Value, &[u8]) {
    assert_eq!(sink.files.len(), 1, "{:?}", sink.files.keys());
    opened(sink.files.values().next().expect("a file"))
}

#[test]
fn a_container_holds_the_same_document_and_the_same_bytes() {
    let mut both = textured(ImageFormat::Png, Encoding::Srgb);
    texture(&mut both, "Brick", ImageFormat::Jpeg, Encoding::Srgb);
    texture(&mut both, "sky", ImageFormat::Exr, Encoding::Linear);
    for scene in [sample::grid(), lit(), both] {
        let name = scene.name.clone();
        let images: Vec<(String, Vec<u8>)> = crate::formats::texture_files(&scene)
            .into_iter()
            .zip(scene.textures.values().map(|texture| texture.file.to_vec()))
            .collect();
        let separate = emitted("gltf", scene.clone());
        let whole = emitted("glb", scene);
        let (mut document, buffer) = only(&whole);
        let mut other: Value = serde_json::from_str(&text(&separate, &format!("{name}.gltf"))).expect("JSON");
        let geometry = separate.files.get(&format!("{name}.bin")).map_or(&[][..], Vec::as_slice);
        assert_eq!(&buffer[..geometry.len()], geometry, "the buffer begins with the geometry");
        assert_eq!(document["buffers"][0]["byteLength"].as_u64().unwrap_or(0), buffer.len() as u64);
        assert!(document["buffers"][0]["uri"].is_null(), "the buffer is the container's own");
        let listed = document["images"].as_array().cloned().unwrap_or_default();
        for (index, image) in listed.iter().enumerate() {
            let view = &document["bufferViews"][image["bufferView"].as_u64().expect("a view") as usize];
            let [offset, length] =
                ["byteOffset", "byteLength"].map(|key| view[key].as_u64().expect("a number") as usize);
            assert_eq!((offset % 4, view["target"].is_null()), (0, true));
            let uri = other["images"][index]["uri"].as_str().expect("a way").to_owned();
            let (file, bytes) = images.iter().find(|(file, _)| uri.ends_with(file.as_str())).expect("its file");
            assert_eq!(&buffer[offset..offset + length], bytes.as_slice());
            let mime = if file.ends_with(".png") { "image/png" } else { "image/jpeg" };
            assert_eq!(image["mimeType"], mime);
        }
        // But for where bytes lie, and the target's name, both are the same.
        let views = other["bufferViews"].as_array().map_or(0, Vec::len);
        for value in [&mut document, &mut other] {
            value["asset"]["extras"] = Value::Null;
            value["buffers"] = Value::Null;
            if let Some(list) = value["bufferViews"].as_array_mut() {
                list.truncate(views);
            }
            for image in value["images"].as_array_mut().into_iter().flatten() {
                *image = image["name"].clone();
            }
        }
        assert_eq!(document, other, "{name}");
        let two = usize::from(name == "s") * 2;
        assert_eq!(listed.len(), two, "OpenEXR stays outside");
    }
}

/// What takes space here are images of which each is the same bytes in memory.
fn huge() -> Scene {
    let mut scene = textured(ImageFormat::Png, Encoding::Srgb);
    let file = ImageFile::new(&vec![0; 1 << 26]);
    for index in 0..64 {
        let handle = texture(&mut scene, &format!("t{index}"), ImageFormat::Png, Encoding::Srgb);
        scene.textures[handle].file = file.clone();
    }
    scene
}

/// Counts what is written, and fails where anything would be.
struct Refusing;

impl Sink for Refusing {
    fn file(
        &mut self,
        path: &str,
        _: &mut dyn FnMut(&mut dyn std::io::Write) -> std::io::Result<()>,
    ) -> std::io::Result<()> {
        panic!("{path} is begun")
    }
}

#[test]
fn a_scene_of_four_gibibytes_is_refused_before_a_byte_is_written() {
    let scene = validate(huge()).expect("a valid scene");
    let (camera, _) = scene.cameras.iter().next().expect("a camera");
    let choices = Choices::default();
    let emission = Emission {
        scene: &scene,
        camera,
        meshes: "../meshes/",
        textures: "../textures/",
        choices: &choices,
        statements: &crate::formats::statements::NONE,
    };
    let target = find("gltf-binary").expect("a target by its other name");
    let error = (target.emit)(&emission, &mut Refusing).expect_err("too large");
    assert_eq!(error.kind(), std::io::ErrorKind::FileTooLarge);
    assert!(error.to_string().contains("the target `gltf` has no such limit"), "{error}");
}

/// The numbers of an accessor of floats, `N` together.
fn floats<const N: usize>(document: &Value, buffer: &[u8], accessor: &Value) -> Vec<[f32; N]> {
    let accessor = &document["accessors"][accessor.as_u64().expect("an accessor") as usize];
    let view = &document["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
    let [offset, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().expect("a number") as usize);
    let kind = if N == 4 { "VEC4" } else { "VEC3" };
    assert_eq!((&accessor["type"], &accessor["componentType"]), (&kind.into(), &5126.into()));
    let bytes = &buffer[offset..offset + length];
    let words = bytes.chunks_exact(4).map(|word| f32::from_le_bytes(word.try_into().expect("four bytes")));
    let items: Vec<[f32; N]> = words.collect::<Vec<_>>().as_chunks().0.to_vec();
    assert_eq!(accessor["count"], items.len());
    items
}

#[test]
fn instances_are_one_node_where_it_is_asked_for() {
    let plain = emitted("glb", sample::grid());
    let with = emitted_with("glb", sample::grid(), &["glb.instancing"]);
    assert_eq!(emitted_with("glb", sample::grid(), &["gltf.instancing"]), plain, "the other form was asked for it");
    let ((before, _), (document, buffer)) = (only(&plain), only(&with));
    assert!(before["extensionsRequired"].is_null());
    assert_eq!(document["extensionsRequired"], serde_json::json!(["EXT_mesh_gpu_instancing"]));
    let used = document["extensionsUsed"].as_array().expect("extensions");
    assert!(used.contains(&"EXT_mesh_gpu_instancing".into()));
    let nodes = document["nodes"].as_array().expect("nodes");
    // The root, the camera, the lamp, the pair twice in one, and the sheared one.
    assert_eq!((before["nodes"].as_array().map(Vec::len), nodes.len()), (Some(6), 5));
    assert_eq!(nodes[0]["children"], serde_json::json!([1, 2, 3, 4]));
    let node = nodes.iter().find(|node| node["extensions"].is_object()).expect("instances");
    assert_eq!(node["extras"]["names"], serde_json::json!(["pair[0]", "pair[1]"]));
    assert!(node["matrix"].is_null() && node["translation"].is_null());
    let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    assert_eq!(floats::<3>(&document, buffer, &attributes["TRANSLATION"]), [[0.0; 3], [0.0, 0.0, 5.0]]);
    let rotations = floats::<4>(&document, buffer, &attributes["ROTATION"]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_eq!(rotations[0], [0.0, 0.0, 0.0, 1.0]);
    assert!(rotations[1].iter().zip([0.0, 0.0, half, half]).all(|(a, b)| (a - b).abs() < 1e-7), "{rotations:?}");
    assert!(attributes["SCALE"].is_null(), "all are 1");
    let sheared = nodes.iter().find(|node| node["name"] == "pair[2]").expect("a node of its own");
    assert_ne!(sheared["mesh"], node["mesh"]);
    let comment = document["asset"]["extras"]["comment"].as_str().expect("a comment");
    assert!(comment.contains("1 sheared uses"), "{comment}");
    // A scene without a mesh that is used twice asks nothing of its readers.
    assert_eq!(emitted_with("glb", sample::room(), &["glb.instancing"]), emitted("glb", sample::room()));
}
