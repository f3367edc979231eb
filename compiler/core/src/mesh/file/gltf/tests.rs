//! glTF files that are good, and files that are not.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::super::model::{Picture, Scatter, Surface};
use super::super::{alone, read as read_file, read_parts};
use super::*;
use crate::files::MemorySink;

/// Two triangles of a square in the plane z = 0 of the file: positions, normals, texture coordinates, indices of 16 bits.
pub(super) fn square() -> (Value, Vec<u8>) {
    let mut bytes = Vec::new();
    let mut put = |numbers: &[f32]| bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    put(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    put(&[0.0, 0.0, 1.0].repeat(4));
    put(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|x| x.to_le_bytes()));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let view = |from: usize, size: usize| json!({"buffer": 0, "byteOffset": from, "byteLength": size});
    let document = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 140}],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 32), view(128, 12)],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.125, 1], "metallicFactor": 0},
                       "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
        "meshes": [{"name": "square", "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]}],
        "nodes": [
            {"name": "stand", "translation": [10, 0, 0], "children": [1, 2]},
            {"name": "turned", "mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 1, 1]},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]},
        ],
        "scenes": [{"nodes": [0]}],
    });
    (document, bytes)
}

pub(super) fn glb(document: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + text.len() as u32 + 8 + buffer.len() as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

pub(super) fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut document, bytes) = square();
    change(&mut document);
    glb(&document, &bytes)
}

pub(super) fn fault(bytes: &[u8]) -> String {
    read_parts("glb", bytes, &mut alone).map(|_| ()).expect_err("a bad file").to_string()
}

pub(super) fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn nodes_place_their_meshes_with_z_up() {
    let (document, bytes) = square();
    let (model, notes) = read_parts("glb", &glb(&document, &bytes), &mut alone).expect("a good file");
    assert_eq!((model.meshes.len(), notes), (1, vec![]), "both nodes share the mesh");
    let names: Vec<&str> = model.parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["turned", "square"]);
    let paint = Surface {
        name: "paint".to_owned(),
        scatter: Scatter::Diffuse([0.5, 0.25, 0.125]),
        emission: None,
        picture: None,
        factor: [1.0; 3],
        lost: vec![],
    };
    assert_eq!(model.surfaces, [paint]);
    let (whole, _) = read_file("GLB", &glb(&document, &bytes), None, &mut alone).expect("a good file");
    assert_eq!((whole.positions.len(), whole.triangles.len(), whole.check()), (8, 4, Ok(())));
    // (1, 0, 0) is stretched to (2, 0, 0), turned to (0, 2, 0), moved to (10, 2, 0), and with z up it is (10, 0, 2).
    assert!(near(whole.positions[1], [10.0, 0.0, 2.0]), "{:?}", whole.positions);
    assert!(near(whole.positions[4], [10.0, 0.0, 5.0]) && near(whole.positions[6], [11.0, 0.0, 6.0]));
    assert!(whole.normals.iter().flatten().all(|normal| near(*normal, [0.0, -1.0, 0.0])));
    assert_eq!(whole.uvs.as_ref().map(|uvs| uvs[0]), Some([0.0, 0.0]), "v grows upwards");
}

#[test]
fn parts_are_nodes_and_meshes() {
    let (document, bytes) = square();
    let bytes = glb(&document, &bytes);
    let triangles =
        |part| read_file("glb", &bytes, Some(part), &mut alone).map(|(geometry, _)| geometry.triangles.len());
    assert_eq!((triangles("turned"), triangles("square"), triangles("stand")), (Ok(2), Ok(4), Ok(4)));
    let error = triangles("sqare").expect_err("no such part");
    assert_eq!(error.help.as_deref(), Some("is `square` meant?"));
}

#[test]
fn buffers_lie_inside_or_beside() {
    let (mut document, buffer) = square();
    let (expected, _) = read_parts("glb", &glb(&document, &buffer), &mut alone).expect("a good file");
    document["buffers"][0]["uri"] = json!("a%20b.bin");
    let text = document.to_string().into_bytes();
    let mut beside = |path: &str| {
        assert_eq!(path, "a b.bin");
        Ok(Box::new(buffer.clone()) as Box<dyn AsRef<[u8]>>)
    };
    assert_eq!(read_parts("gltf", &text, &mut beside).expect("a good file").0, expected);
    assert!(fault(&text).contains("only the mesh file itself is there"));
    let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&buffer));
    document["buffers"][0]["uri"] = json!(data);
    assert_eq!(read_parts("gltf", document.to_string().as_bytes(), &mut alone).expect("a good file").0, expected);
    document["buffers"][0]["uri"] = json!("data:application/octet-stream;base64,???");
    assert!(fault(document.to_string().as_bytes()).contains("malformed"));
}

#[test]
fn strips_and_fans_are_triangles() {
    let triangles = |mode: u32| {
        let bytes = changed(|document| {
            document["meshes"][0]["primitives"][0]["mode"] = json!(mode);
            document["accessors"][3]["count"] = json!(4);
            document["bufferViews"][3]["byteOffset"] = json!(132);
            document["bufferViews"][3]["byteLength"] = json!(8);
        });
        read_parts("glb", &bytes, &mut alone).map(|(model, _)| model.meshes[0].1.triangles.clone())
    };
    // Indices 2, 0, 2, 3.
    assert_eq!(triangles(5), Ok(vec![[2, 0, 2], [0, 3, 2]]));
    assert_eq!(triangles(6), Ok(vec![[2, 0, 2], [2, 2, 3]]));
    assert!(triangles(1).expect_err("lines").message.contains("no triangles"));
}

#[test]
fn materials_are_told() {
    let surface = |material: Value| {
        let bytes = changed(|document| document["materials"][0] = material);
        let (model, _) = read_parts("glb", &bytes, &mut alone).expect("a good file");
        model.surfaces.into_iter().next().expect("a material")
    };
    let clear = |metallic: f64| {
        surface(json!({"name": "g", "pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicFactor": metallic},
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.33}}}))
    };
    assert_eq!(clear(0.0).scatter, Scatter::Glass { ior: 1.33, alpha: 0.25 });
    // Only what is no metal transmits (KHR_materials_transmission), and a metal has no index of its own.
    assert!(matches!(clear(1.0).scatter, Scatter::MetallicRoughness { metallic: 1.0, roughness: 0.5, .. }));
    let metal = surface(json!({"pbrMetallicRoughness": {"roughnessFactor": 0, "baseColorFactor": [1, 0.5, 0, 1]}}));
    assert_eq!(metal.scatter, Scatter::Mirror([1.0, 0.5, 0.0]));
    let lamp = surface(json!({"emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK",
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 30}}}));
    assert_eq!(lamp.emission, Some([30.0, 15.0, 0.0]));
    let base = [1.0; 3];
    assert_eq!(lamp.scatter, Scatter::MetallicRoughness { base, metallic: 1.0, roughness: 1.0, ior: 1.5 });
    assert_eq!(lamp.lost.len(), 1, "{:?}", lamp.lost);
}

#[test]
fn an_image_is_multiplied_by_the_factor_of_its_color() {
    let bytes = changed(|document| {
        document["materials"][0] = json!({"name": "p", "pbrMetallicRoughness":
            {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.25, 1, 1]}});
        document["textures"] = json!([{"source": 0}]);
        document["images"] = json!([{"uri": "oak.png"}]);
    });
    let (model, _) = read_parts("glb", &bytes, &mut alone).expect("a good file");
    let surface = &model.surfaces[0];
    assert_eq!(
        (surface.factor, surface.picture.is_some(), surface.lost.len()),
        ([0.5, 0.25, 1.0], true, 0),
        "{surface:?}"
    );
}

#[test]
fn pictures_lie_inside_or_beside() {
    let picture = |image: Value| {
        let bytes = changed(|document| {
            let info = json!({"index": 0});
            document["materials"][0] = json!({"name": "p", "pbrMetallicRoughness": {"baseColorTexture": info}});
            document["textures"] = json!([{"source": 0}]);
            document["images"] = json!([image]);
        });
        let (model, _) = read_parts("glb", &bytes, &mut alone).expect("a good file");
        model.surfaces.into_iter().next().expect("a material").picture
    };
    assert_eq!(picture(json!({"uri": "wood%20grain.png"})), Some(Picture::Beside("wood grain.png".to_owned())));
    let inside = Some(Picture::Inside { image: 0, ending: "jpg", bytes: [1, 2, 3].into() });
    assert_eq!(picture(json!({"uri": "data:image/jpeg;base64,AQID"})), inside);
    let view = picture(json!({"bufferView": 3, "mimeType": "image/png"}));
    assert!(matches!(view, Some(Picture::Inside { image: 0, ending: "png", bytes }) if bytes.len() == 12));
    assert_eq!(picture(json!({"bufferView": 3, "mimeType": "image/ktx2"})), None);
}

#[test]
fn what_our_own_writer_writes_is_read_back() {
    let scene = crate::valid::validate(crate::formats::shared::sample::room()).expect("a valid scene");
    let (camera, _) = scene.cameras.iter().next().expect("a camera");
    let choices = crate::formats::Choices::default();
    let emission = crate::formats::Emission {
        scene: &scene,
        camera,
        meshes: "meshes/",
        textures: "textures/",
        choices: &choices,
        statements: &crate::formats::statements::NONE,
    };
    for name in ["gltf", "glb"] {
        let mut sink = MemorySink::default();
        let target = crate::formats::find(name).expect("a target");
        (target.emit)(&emission, &mut sink).expect("memory takes all");
        let file = sink.files[&target.main_file_of(&scene.name)].clone();
        let mut beside = |path: &str| Ok(Box::new(sink.files[path].clone()) as Box<dyn AsRef<[u8]>>);
        let (model, _) = read_parts(name, &file, &mut beside).expect("a good file");
        let names: Vec<&str> = model.parts.iter().map(|part| part.name.as_str()).collect();
        let shapes: Vec<&str> = scene.shapes.values().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, shapes);
        for (part, shape) in model.parts.iter().zip(scene.shapes.values()) {
            let (mesh, own) = (&scene.meshes[shape.mesh], &model.meshes[part.mesh].1);
            assert_eq!(own.triangles.len(), mesh.triangles.len());
            for (a, b) in own.positions.iter().zip(mesh.positions.iter()) {
                let place = |point: &[f32; 3], map: &Affine| map.point(point.map(f64::from)).map(|x| x as f32);
                assert!(near(
                    place(a, &part.transform).map(|x| x / 100.0),
                    place(b, &shape.transform).map(|x| x / 100.0)
                ));
            }
            let Surface { scatter, emission, .. } = &model.surfaces[part.surface.expect("a material")];
            assert!(matches!(scene.materials[shape.material].bsdf, crate::ir::Bsdf::Diffuse { .. }));
            assert!(matches!(scatter, Scatter::Diffuse(_)), "{scatter:?}");
            assert_eq!(emission.is_some(), shape.emission.is_some());
        }
    }
}

#[test]
fn faults_are_found() {
    let (document, bytes) = square();
    let good = glb(&document, &bytes);
    for cut in [6, 14, 18, 40, good.len() - 1] {
        assert!(
            fault(&good[..cut]).contains("cut off") || fault(&good[..cut]).contains("ends within"),
            "{cut}: {}",
            fault(&good[..cut])
        );
    }
    let mut old = good.clone();
    old[4] = 1;
    assert!(fault(&old).contains("version 1"));
    let mut length = good.clone();
    length[8..12].copy_from_slice(&[0; 4]);
    assert!(read_parts("glb", &length, &mut alone).is_ok(), "the length of the whole says nothing that is needed");
    assert_eq!(fault(b""), "the file is empty");
    for garbage in [&b"PK\x03\x04zip"[..], b"\xff\xd8\xff", b"[1]", b"\xef\xbb\xbf \n<xml>", b"glt"] {
        assert!(fault(garbage).contains("begins neither with `glTF`"), "{}", fault(garbage));
    }
    assert!(fault(b"\xef\xbb\xbf \n{").contains("the JSON is malformed"), "{}", fault(b"{"));
    assert!(fault(b"{}").contains("missing") || fault(b"{}").contains("malformed"), "{}", fault(b"{}"));
    let words = |change: &dyn Fn(&mut Value), words: &str| {
        let message = fault(&changed(change));
        assert!(message.contains(words), "{words}: {message}");
    };
    words(&|d| d["buffers"][0]["byteLength"] = json!(141), "has 140 bytes, and the file says 141");
    words(&|d| d["accessors"][0]["count"] = json!(5), "its 5 elements do not lie within its buffer");
    words(&|d| d["accessors"][0]["count"] = json!(4_000_000_000_u32), "times as large as the file");
    words(&|d| d["accessors"][0]["count"] = json!(u64::MAX), "times as large as the file");
    words(&|d| d["accessors"][0]["byteOffset"] = json!(u64::MAX), "do not lie within its buffer");
    words(&|d| d["bufferViews"][0]["byteOffset"] = json!(u64::MAX), "do not lie within its buffer");
    words(&|d| d["bufferViews"][0]["byteStride"] = json!(4), "lie within each other");
    words(&|d| d["accessors"][1]["type"] = json!("VEC2"), "VEC2, not VEC3");
    words(&|d| d["accessors"][1]["count"] = json!(3), "it has 4 positions and 3 normals");
    words(&|d| d["accessors"][3]["componentType"] = json!(5122), "whole numbers");
    words(&|d| d["meshes"][0]["primitives"][0]["indices"] = json!(9), "points to nothing");
    words(&|d| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99), "points to nothing");
    words(&|d| d["nodes"][1]["children"] = json!([0]), "within itself");
    words(&|d| d["nodes"][0]["children"] = json!([1, 1]), "in two places");
    words(&|d| d["nodes"][0]["scale"] = json!([0, 0, 0]), "no triangles");
    words(
        &|d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        "requires the extension `KHR_draco_mesh_compression`",
    );
    words(&|d| d["scenes"][0]["nodes"] = json!([]), "no triangles");
    let index = changed(|d| d["bufferViews"][3]["byteOffset"] = json!(8));
    assert!(fault(&index).contains("uses vertex"), "{}", fault(&index));
}

#[test]
fn shared_bytes_do_not_multiply() {
    let (mut document, bytes) = square();
    // 10 000 meshes over the same positions, each with indices of its own.
    let accessors: Vec<Value> = (0..10_000)
        .map(|at| json!({"bufferView": 3, "componentType": 5121, "count": 3, "type": "SCALAR", "byteOffset": at % 9}))
        .collect();
    document["accessors"].as_array_mut().expect("a list").extend(accessors);
    document["meshes"][0]["primitives"] =
        (0..10_000).map(|at| json!({"attributes": {"POSITION": 0}, "indices": 4 + at})).collect();
    // The text pays for them.
    assert!(read_parts("glb", &glb(&document, &bytes), &mut alone).is_ok());
    let many: Vec<Value> = (0..40_000).map(|at| json!({"mesh": 0, "translation": [at, 0, 0]})).collect();
    let (mut document, bytes) = square();
    document["nodes"] = json!(many);
    document["scenes"] = json!([{"nodes": (0..40_000).collect::<Vec<u32>>()}]);
    let (model, _) = read_parts("glb", &glb(&document, &bytes), &mut alone).expect("a good file");
    assert_eq!((model.parts.len(), model.meshes.len(), model.parts[39_999].name.as_str()), (40_000, 1, "square_40000"));
}

proptest! {
    #[test]
    fn noise_does_no_harm(at in any::<prop::sample::Index>(), byte: u8, cut in any::<prop::sample::Index>()) {
        let (document, bytes) = square();
        let mut file = glb(&document, &bytes);
        let at = at.index(file.len());
        file[at] = byte;
        let cut = if cut.index(3) == 0 { cut.index(file.len()) } else { file.len() };
        if let Ok((model, _)) = read_parts("glb", &file[..cut], &mut alone) {
            prop_assert!(model.meshes.iter().all(|(_, geometry)| geometry.check().is_ok()));
        }
    }
}
