//! Cases of the importer: what a file means, and what is said of it.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::diag::{Finding, Origin, Severity, Sources};
use crate::files::{MemoryFiles, VPath};
use crate::import::{Imported, Options, find, import};
use crate::ir::{Bsdf, LightKind, Places, Scene, Sides, cross, dot, sub};

/// A triangle in the plane z = 0 of the file, facing +z there, which is -y here; as text.
fn document(more: Value) -> Value {
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut document = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 60, "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes))}],
        "bufferViews": [{"buffer": 0, "byteLength": 60}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "VEC3"},
        ],
        "meshes": [{"name": "sail", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"doubleSided": true}],
        "nodes": [{"name": "boat", "mesh": 0}],
        "scenes": [{"nodes": [0]}],
    });
    for (key, value) in more.as_object().expect("an object") {
        document[key] = value.clone();
    }
    document
}

fn import_bytes(bytes: &[u8]) -> Imported {
    let mut files = MemoryFiles::default();
    files.insert("a/boat.gltf", bytes.to_vec());
    let path = VPath::resolve("", "a/boat.gltf").expect("a path");
    let mut sources = Sources::default();
    import(find(&path).expect("an importer"), &files, &mut sources, &path, &Options::default())
}

/// The scene of a document, which is valid, and what is said.
fn read(more: Value) -> (Scene, Vec<Finding>) {
    let Imported { scene, findings, .. } = import_bytes(document(more).to_string().as_bytes());
    let scene = scene.unwrap_or_else(|| panic!("{findings:?}"));
    is_valid(&scene).unwrap_or_else(|message| panic!("{message}"));
    (scene, findings)
}

/// Whether a scene is valid, but for having nothing in it, which is said behind the importer.
fn is_valid(scene: &Scene) -> Result<(), String> {
    match crate::pipeline::prepare(scene.clone()) {
        Err(findings) if !(scene.shapes.is_empty() && scene.instances.is_empty()) => Err(format!("{findings:?}")),
        Ok(_) | Err(_) => Ok(()),
    }
}

fn says(findings: &[Finding], id: &str, at: &str, words: &str) -> bool {
    findings.iter().any(|finding| {
        let here = matches!(&finding.origin, Origin::File { path: _, place } if place == at);
        here && finding.id == id && finding.message.contains(words)
    })
}

fn material(own: Value) -> (Bsdf, Vec<Finding>) {
    let (scene, findings) = read(json!({"materials": [own]}));
    (scene.materials.values().next().expect("a material").bsdf.clone(), findings)
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn gold_is_a_metal() {
    let gold = json!({"metallicFactor": 1, "roughnessFactor": 0.3, "baseColorFactor": [1.0, 0.766, 0.336, 1]});
    let (bsdf, findings) = material(json!({"doubleSided": true, "pbrMetallicRoughness": gold}));
    let Bsdf::Conductor { eta, k, alpha } = bsdf else { panic!("{bsdf:?}") };
    assert!((alpha - 0.09).abs() < 1e-12);
    let (eta, k) = (eta.rgb(), k.rgb());
    for (channel, share) in [0.9999, 0.766, 0.336].into_iter().enumerate() {
        let head_on = crate::formats::shared::fresnel::head_on(eta[channel], k[channel]);
        assert!((head_on - share).abs() < 1e-6, "{channel} {head_on}");
    }
    assert!(findings.iter().all(|finding| finding.id != "loss-dropped" || finding.message.contains("camera")));
    // A black channel is none of a metal: the model that can have it stands for it. What has both parts is a blend.
    let red = json!({"metallicFactor": 1, "roughnessFactor": 0.3, "baseColorFactor": [1, 0, 0, 1]});
    assert!(matches!(material(json!({"pbrMetallicRoughness": red})).0, Bsdf::Principled { metallic: 1.0, .. }));
    let half = json!({"metallicFactor": 0.5, "roughnessFactor": 0.3});
    assert!(matches!(material(json!({"pbrMetallicRoughness": half})).0, Bsdf::Principled { metallic: 0.5, .. }));
}

#[test]
fn glass_lets_light_through() {
    let glass = |volume: Value| {
        material(json!({
            "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_ior": {"ior": 1.33},
                "KHR_materials_volume": volume,
            },
        }))
    };
    let (bsdf, findings) = glass(json!({"thicknessFactor": 1}));
    assert_eq!(bsdf, Bsdf::Dielectric { interior: 1.33, exterior: 1.0, alpha: 0.0 });
    assert!(!findings.iter().any(|finding| finding.message.contains("glass")), "{findings:?}");
    let (_, findings) = glass(json!({}));
    assert!(says(&findings, "loss-dropped", "/materials/0", "thin"), "{findings:?}");
}

#[test]
fn emission_has_its_strength() {
    let (scene, findings) = read(json!({"materials": [{
        "emissiveFactor": [1, 0.5, 0.25],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 12}},
    }]}));
    let emission = scene.shapes.values().next().and_then(|shape| shape.emission.clone()).expect("an emission");
    assert_eq!(emission.radiance.rgb(), [12.0, 6.0, 3.0]);
    assert!(scene.lights.is_empty() && says(&findings, "loss-approximated", "/materials/0", "W/(m2 sr)"));
}

#[test]
fn lights_stand_where_their_nodes_do() {
    let lights = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0], "intensity": 8, "range": 3},
        {"type": "spot", "intensity": 2, "spot": {"outerConeAngle": 0.5, "innerConeAngle": 0.25}},
        {"type": "directional"},
        {"type": "lamp"},
    ]}});
    let node =
        |light: usize| json!({"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": light}}});
    let (scene, findings) = read(json!({
        "extensions": lights, "nodes": [node(0), node(1), node(2), node(3), node(9)], "scenes": [{"nodes": [0, 1, 2, 3, 4]}],
    }));
    let kinds: Vec<&LightKind> = scene.lights.values().map(|light| &light.kind).collect();
    let [
        LightKind::Point { position, intensity },
        LightKind::Spot { target, angle, inner, .. },
        LightKind::Directional { direction, irradiance },
    ] = kinds.as_slice()
    else {
        panic!("{kinds:?}")
    };
    // (x, y, z) of the file is (x, -z, y); lights shine along -z, which is +y.
    assert!(close(position, &[1.0, -3.0, 2.0]) && intensity.rgb() == [8.0, 4.0, 0.0]);
    assert!(
        close(target, &[1.0, -2.0, 2.0]) && close(&[*angle, *inner], &[0.5_f64.to_degrees(), 0.25_f64.to_degrees()])
    );
    assert!(close(direction, &[0.0, 1.0, 0.0]) && irradiance.rgb() == [1.0; 3]);
    let list = "/extensions/KHR_lights_punctual/lights";
    assert!(says(&findings, "loss-dropped", &format!("{list}/0"), "range"), "{findings:?}");
    assert!(says(&findings, "loss-approximated", &format!("{list}/1"), "linearly"));
    assert!(says(&findings, "loss-dropped", &format!("{list}/3"), "`lamp`"));
    assert!(says(&findings, "loss-dropped", "/nodes/4", "points to nothing"));
    assert!(says(&findings, "loss-approximated", "/nodes/0", "candela"));
}

#[test]
fn a_camera_keeps_its_angle_and_its_ratio() {
    let camera = |own: Value| {
        read(json!({
            "cameras": [own], "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 1, 5]}], "scenes": [{"nodes": [0, 1]}],
        }))
    };
    let (scene, findings) = camera(json!({
        "type": "perspective", "perspective": {"yfov": std::f64::consts::FRAC_PI_2, "aspectRatio": 2, "znear": 0.1},
    }));
    let own = scene.cameras.values().next().expect("a camera");
    assert_eq!((scene.film.width, scene.film.height), (512, 256));
    assert!(close(&own.eye, &[0.0, -5.0, 1.0]) && close(&sub(own.target, own.eye), &[0.0, 1.0, 0.0]));
    assert!(close(&own.up, &[0.0, 0.0, 1.0]) && close(&[own.fov_x], &[2.0 * libm::atan(2.0).to_degrees()]));
    assert_eq!((own.near, own.far), (Some(0.1), None));
    assert!(!says(&findings, "loss-dropped", "", "camera"), "{findings:?}");
    let flat = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}});
    let (scene, findings) = camera(flat);
    assert_eq!(scene.cameras.len(), 1);
    assert!(says(&findings, "loss-dropped", "/cameras/0", "45 degrees"), "{findings:?}");
}

#[test]
fn without_camera_and_light_both_are_put_there() {
    let (scene, findings) = read(json!({}));
    assert_eq!((scene.name.as_str(), scene.shapes.len(), scene.lights.len(), scene.cameras.len()), ("boat", 1, 1, 1));
    assert!(
        says(&findings, "loss-approximated", "", "no camera") && says(&findings, "loss-approximated", "", "no light")
    );
    let camera = scene.cameras.values().next().expect("a camera");
    assert!(camera.eye[1] < 0.0 && camera.target[1] > camera.eye[1], "before the model, which faces -y");
}

#[test]
fn places_of_one_node_are_one_instance() {
    let placed = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}});
    let (scene, _) = read(json!({"nodes": [{"name": "fleet", "mesh": 0, "extensions": placed}]}));
    let instance = scene.instances.values().next().expect("an instance");
    let Places::Many(places) = &instance.places else { panic!("{instance:?}") };
    assert_eq!((scene.shapes.len(), scene.groups.len(), places.len()), (0, 1, 2));
    assert!(close(&sub(places[1].point([0.0; 3]), places[0].point([0.0; 3])), &[2.0, 0.0, 0.0]));
    // A mesh of two primitives at two nodes is a group; one of a single primitive stays two shapes that share it.
    let twice = json!([{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 4]}]);
    let scenes = json!([{"nodes": [0, 1]}]);
    let (scene, _) = read(json!({"nodes": twice, "scenes": scenes}));
    assert_eq!((scene.shapes.len(), scene.meshes.len(), scene.groups.len()), (2, 1, 0));
    let pair =
        json!([{"primitives": [{"attributes": {"POSITION": 0}}, {"attributes": {"POSITION": 0}, "material": 0}]}]);
    let (scene, _) = read(json!({"nodes": twice, "scenes": scenes, "meshes": pair}));
    assert_eq!((scene.shapes.len(), scene.groups.len(), scene.instances.len()), (0, 1, 2));
}

#[test]
fn a_mirrored_lamp_shines_where_the_file_says() {
    for (scale, front) in [(json!([1, 1, 1]), -1.0), (json!([-1, 1, 1]), -1.0), (json!([1, 1, -1]), 1.0)] {
        let (scene, _) = read(json!({
            "materials": [{"emissiveFactor": [1, 1, 1]}], "nodes": [{"mesh": 0, "scale": scale}],
        }));
        let (scene, _) = crate::pipeline::prepare(scene).expect("a valid scene");
        let shape = scene.shapes.values().next().expect("a shape");
        let mesh = &scene.meshes[shape.mesh];
        let [a, b, c] = mesh.corners(mesh.triangles[0]).map(|corner| shape.transform.point(corner));
        // A front is the same side of the surface after a mirror (glTF 2.0, 3.7.4): the normal goes with it.
        assert!(dot(cross(sub(b, a), sub(c, a)), [0.0, front, 0.0]) > 0.0, "{scale}");
    }
}

#[test]
fn what_cannot_be_is_an_error_or_a_finding() {
    let refused = |more: Value, place: &str| {
        let Imported { scene, findings, .. } = import_bytes(document(more).to_string().as_bytes());
        let error = findings.iter().find(|finding| finding.severity == Severity::Error).expect("an error");
        assert!(
            scene.is_none() && matches!(&error.origin, Origin::File { path: _, place: at } if at.starts_with(place))
        );
    };
    refused(json!({"nodes": [{"mesh": 0, "children": [0]}]}), "/nodes/0");
    refused(json!({"asset": {"version": "3.0"}}), "/asset");
    refused(json!({"extensionsRequired": ["KHR_draco_mesh_compression"]}), "/extensionsRequired/0");
    refused(json!({"buffers": [{"byteLength": 60, "uri": "../../../etc/passwd"}]}), "/buffers/0");
    refused(json!({"buffers": [{"byteLength": 60, "uri": "data:;base64,!!"}]}), "/buffers/0");
    // A broken primitive leaves the others.
    let (scene, findings) = read(json!({"meshes": [{"primitives": [
        {"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {"POSITION": 77}}, {"attributes": {"POSITION": 0}},
    ]}]}));
    assert_eq!(scene.shapes.len(), 1);
    assert!(says(&findings, "loss-dropped", "/meshes/0/primitives/1", "left out"), "{findings:?}");
    // More than the file can hold.
    let endless = json!([{"bufferView": 0, "componentType": 5126, "count": 4_000_000_000_u32, "type": "VEC3"}]);
    let (scene, findings) = read(json!({"accessors": endless}));
    assert!(scene.shapes.is_empty() && findings.iter().any(|finding| finding.id == "loss-dropped"));
}

#[test]
fn what_is_never_seen_is_no_loss() {
    let known = json!({"extensionsUsed": ["EXT_mesh_features", "EXT_structural_metadata", "EXT_instance_features"]});
    assert!(read(known).1.iter().all(|finding| finding.id != "loss-dropped"));
    let own = json!({"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "_PART": 0}, "material": 0}]}]});
    let found = read(own).1;
    assert!(
        says(&found, "loss-baked", "/meshes/0", "`_`") && found.iter().all(|finding| finding.id != "loss-dropped"),
        "{found:?}"
    );
    // Profiles of colors are to be ignored (glTF 2.0, 5.19); how a picture is turned is another thing.
    let files: [(&[u8], bool); 2] = [
        (include_bytes!("../../../../../tests/cases/images/profile.jpg"), false),
        (include_bytes!("../../../../../tests/cases/images/turned.jpg"), true),
    ];
    for (jpeg, lost) in files {
        let painted = json!({
            "images": [{"uri": format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg))}],
            "textures": [{"source": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "VEC3"},
                {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2"},
            ],
        });
        let (scene, found) = read(painted);
        assert_eq!(scene.textures.len(), 1, "{found:?}");
        assert_eq!(found.iter().any(|finding| finding.id == "loss-dropped"), lost, "{found:?}");
    }
    let unknown = json!({"extensionsUsed": ["ACME_gizmo"]});
    assert!(says(&read(unknown).1, "loss-dropped", "/extensionsUsed/0", "ACME_gizmo"));
}

#[test]
fn a_deep_tree_is_no_deep_stack() {
    let deep = 100_000;
    let nodes: Vec<Value> = (0..deep).map(|at| json!({"children": [at + 1]})).chain([json!({"mesh": 0})]).collect();
    assert_eq!(read(json!({"nodes": nodes})).0.shapes.len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn no_text_makes_the_reader_panic(at in any::<prop::sample::Index>(), length in 0_usize..20, new in "[ -~]{0,12}") {
        let light = json!({"KHR_lights_punctual": {"light": 0}});
        let whole = document(json!({
            "materials": [{
                "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0.5}, "emissiveFactor": [1, 2, 3],
                "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_transmission": {"transmissionFactor": 0}},
            }],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 2, "spot": {"outerConeAngle": 0.5}}]}},
            "cameras": [{"type": "perspective", "perspective": {"yfov": 1.5, "aspectRatio": 2, "znear": 0.1, "zfar": 9}}],
            "nodes": [
                {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}},
                {"camera": 0, "scale": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8]},
                {"extensions": light, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], "children": [0]},
            ],
            "scenes": [{"nodes": [1, 2], "extras": {"film": {"width": 20, "height": 10}, "sampler": {"samples": 7}}}],
        })).to_string();
        let at = at.index(whole.len());
        let end = (at + length).min(whole.len());
        let Imported { scene, findings, .. } = import_bytes(format!("{}{new}{}", &whole[..at], &whole[end..]).as_bytes());
        match scene {
            Some(scene) => {
                let valid = is_valid(&scene);
                prop_assert!(valid.is_ok(), "{valid:?}");
            }
            None => prop_assert!(findings.iter().any(|finding| finding.severity == Severity::Error)),
        }
    }
}

#[test]
fn what_ltsc_writes_without_a_back_is_black_from_behind() {
    let sides = |generator: &str| {
        let asset = json!({"version": "2.0", "generator": generator});
        let (scene, findings) = read(json!({"asset": asset, "materials": [{"doubleSided": false}]}));
        let told = says(&findings, "loss-approximated", "/materials/0", "not drawn from behind");
        (scene.materials.values().next().expect("a material").sides, told)
    };
    assert_eq!(sides("ltsc"), (Sides::Front, false));
    // Elsewhere it is not drawn at all, which no scene says.
    assert_eq!(sides("a program"), (Sides::Both, true));
}
