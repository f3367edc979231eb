//! What valid files hold beyond plain meshes: transforms of textures, instances, skins, morph targets, sparse accessors, colors of
//! vertices, extensions; and what files that are not valid say there.

use proptest::prelude::*;
use serde_json::{Value, json};

use super::super::model::{Model, Scatter, Surface};
use super::super::note::Fate;
use super::super::{FileError, Note, alone, read as read_file, read_parts};
use super::tests::{changed, fault, glb, near, square};
use crate::mesh::Geometry;

fn parts(bytes: &[u8]) -> (Model, Vec<Note>) {
    read_parts("glb", bytes, &mut alone).expect("a good file")
}

fn merged(bytes: &[u8]) -> Geometry {
    read_file("glb", bytes, None, &mut alone).expect("a good file").0
}

fn whole_fault(bytes: &[u8]) -> FileError {
    read_parts("glb", bytes, &mut alone).map(|_| ()).expect_err("a bad file")
}

/// The smallest and the largest corner.
fn reach(geometry: &Geometry) -> [[f32; 3]; 2] {
    let fold = |start: f32, by: fn(f32, f32) -> f32| {
        geometry.positions.iter().fold([start; 3], |all, one| [0, 1, 2].map(|axis| by(all[axis], one[axis])))
    };
    [fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max)]
}

fn area(geometry: &Geometry) -> f64 {
    geometry
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|index| geometry.positions[index as usize].map(f64::from));
            crate::ir::length(crate::ir::cross(crate::ir::sub(b, a), crate::ir::sub(c, a))) / 2.0
        })
        .sum()
}

/// Says that a note of this fate has these words.
fn says(notes: &[Note], fate: Fate, words: &str) {
    assert!(notes.iter().any(|note| note.fate == fate && note.message.contains(words)), "{words}: {notes:?}");
}

/// The square at one node without a transform, with more bytes behind its own, each in a view of its own from number 4 on.
fn with_views(views: &[Vec<u8>], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut document, mut bytes) = square();
    document["nodes"] = json!([{"mesh": 0}]);
    for view in views {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let made = json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": view.len()});
        document["bufferViews"].as_array_mut().expect("views").push(made);
        bytes.extend(view);
    }
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    change(&mut document);
    glb(&document, &bytes)
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn push(document: &mut Value, list: &str, item: Value) -> usize {
    let list = document[list].as_array_mut().expect("a list");
    list.push(item);
    list.len() - 1
}

fn painted(document: &mut Value, info: Value) {
    document["materials"][0] = json!({"name": "p", "pbrMetallicRoughness": {"baseColorTexture": info}});
    document["textures"] = json!([{"source": 0}]);
    document["images"] = json!([{"uri": "a.png"}]);
}

fn uvs(bytes: &[u8]) -> Vec<[f32; 2]> {
    merged(bytes).uvs.expect("texture coordinates")
}

#[test]
fn transforms_of_textures_are_in_their_coordinates() {
    let with = |transform: Value| {
        uvs(&with_views(&[], |document| {
            let extensions = json!({"KHR_texture_transform": transform});
            painted(document, json!({"index": 0, "extensions": extensions}));
            document["extensionsRequired"] = json!(["KHR_texture_transform"]);
        }))
    };
    // The file's are (0, 1), (1, 1), (1, 0), (0, 0), with v downwards: the upper right quarter.
    assert_eq!(
        with(json!({"offset": [0.5, 0], "scale": [0.5, 0.5]})),
        [[0.5, 0.5], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]]
    );
    // As Blender 4.5.15 reads it: (1, 0) goes to (0.577668, 0.052240), (0, 1) to (0.306864, 0.868736), downwards.
    let turned = with(json!({"offset": [0.1, 0.2], "rotation": 0.3, "scale": [0.5, 0.7]}));
    for (uv, [u, v]) in
        [(turned[2], [0.577_668, 0.052_240]), (turned[0], [0.306_864, 0.868_736]), (turned[3], [0.1, 0.2])]
    {
        assert!((uv[0] - u).abs() < 1e-5 && (uv[1] - (1.0 - v)).abs() < 1e-5, "{turned:?}");
    }
    assert_eq!(with(json!({})), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

#[test]
fn the_set_of_texture_coordinates_is_that_of_the_image() {
    let bytes = |info: Value| {
        with_views(&[floats(&[0.25; 8])], |document| {
            let uv = json!({"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC2"});
            let uv = push(document, "accessors", uv);
            document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(uv);
            painted(document, info);
        })
    };
    assert_eq!(uvs(&bytes(json!({"index": 0, "texCoord": 1})))[0], [0.25, 0.75]);
    let own = json!({"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}});
    assert_eq!(uvs(&bytes(own))[0], [0.25, 0.75]);
    assert_eq!(uvs(&bytes(json!({"index": 0})))[0], [0.0, 0.0]);
}

#[test]
fn primitives_under_other_images_have_coordinates_of_their_own() {
    let bytes = with_views(&[], |document| {
        painted(document, json!({"index": 0}));
        let info = json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}});
        push(document, "materials", json!({"pbrMetallicRoughness": {"baseColorTexture": info}}));
        let mut other = document["meshes"][0]["primitives"][0].clone();
        other["material"] = json!(1);
        document["meshes"][0]["primitives"].as_array_mut().expect("a list").push(other);
    });
    let (model, _) = parts(&bytes);
    assert_eq!((model.meshes.len(), model.parts[0].mesh, model.parts[1].mesh), (2, 0, 1));
    let last = |at: usize| model.meshes[at].1.uvs.as_ref().expect("coordinates")[1];
    assert_eq!((last(0), last(1)), ([1.0, 0.0], [2.0, -1.0]));
}

#[test]
fn samplers_that_scenes_have_no_words_for_are_losses() {
    let lost = |sampler: Value, scale: f32| {
        let bytes = with_views(&[], |document| {
            painted(document, json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [scale, scale]}}}));
            document["textures"][0]["sampler"] = json!(0);
            document["samplers"] = json!([sampler]);
        });
        parts(&bytes).0.surfaces.remove(0).lost.join("; ")
    };
    assert_eq!(lost(json!({}), 2.0), "");
    assert_eq!(lost(json!({"wrapS": 10497, "wrapT": 10497, "magFilter": 9729, "minFilter": 9987}), 2.0), "");
    assert!(lost(json!({"wrapS": 33071}), 2.0).contains("does not repeat"), "{}", lost(json!({"wrapS": 33071}), 2.0));
    assert!(lost(json!({"wrapT": 33648}), 2.0).contains("does not repeat"));
    assert!(lost(json!({"wrapS": 33071}), 1.0).contains("half a pixel"));
    assert!(lost(json!({"magFilter": 9728}), 1.0).contains("not interpolated"));
}

#[test]
fn instances_stand_where_their_attributes_say() {
    let places = [floats(&[0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 20.0, 0.0, 0.0])];
    let instanced = |change: &dyn Fn(&mut Value)| {
        with_views(&places, |document| {
            let at = json!({"bufferView": 4, "componentType": 5126, "count": 3, "type": "VEC3"});
            let at = push(document, "accessors", at);
            document["nodes"][0]["extensions"] =
                json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": at}}});
            change(document);
        })
    };
    for list in ["extensionsUsed", "extensionsRequired"] {
        let bytes = instanced(&|document| document[list] = json!(["EXT_mesh_gpu_instancing"]));
        let (model, notes) = parts(&bytes);
        assert_eq!((model.parts.len(), model.meshes.len(), notes.len()), (3, 1, 0), "{notes:?}");
        let geometry = merged(&bytes);
        assert_eq!((geometry.triangles.len(), reach(&geometry)), (6, [[0.0; 3], [21.0, 0.0, 1.0]]));
    }
    // Turned by 90 degrees about z of the file and made twice as large, beside the node's own place.
    let turned = with_views(&[floats(&[0.0, 0.0, 0.707_106_77, 0.707_106_77]), floats(&[2.0, 2.0, 2.0])], |document| {
        let turn =
            push(document, "accessors", json!({"bufferView": 4, "componentType": 5126, "count": 1, "type": "VEC4"}));
        let size =
            push(document, "accessors", json!({"bufferView": 5, "componentType": 5126, "count": 1, "type": "VEC3"}));
        document["nodes"][0] = json!({"mesh": 0, "translation": [5, 0, 0],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turn, "SCALE": size}}}});
    });
    let [low, high] = reach(&merged(&turned));
    assert!(near(low, [3.0, 0.0, 0.0]) && near(high, [5.0, 0.0, 2.0]), "{low:?} {high:?}");
    // Not as many, none, and more than the file could hold.
    let uneven = instanced(&|document| {
        document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    });
    assert!(fault(&uneven).contains("as many places"), "{}", fault(&uneven));
    let zeros = instanced(&|document| {
        document["accessors"][4] = json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3"});
    });
    assert!(fault(&zeros).contains("times as large as the file"), "{}", fault(&zeros));
    let missing = instanced(&|document| {
        document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(99);
    });
    assert!(fault(&missing).contains("points to nothing"), "{}", fault(&missing));
}

/// The square bound to one joint at (0, 0, 7), under a node that is made small, which is not to be seen (glTF 2.0, 3.7.3.3).
fn bound(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut matrix = [0.0; 16];
    for at in [0, 5, 10, 15] {
        matrix[at] = 1.0;
    }
    let views = [vec![0; 16], floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)), floats(&matrix)];
    with_views(&views, |document| {
        let joints =
            push(document, "accessors", json!({"bufferView": 4, "componentType": 5121, "count": 4, "type": "VEC4"}));
        let shares =
            push(document, "accessors", json!({"bufferView": 5, "componentType": 5126, "count": 4, "type": "VEC4"}));
        let inverse =
            push(document, "accessors", json!({"bufferView": 6, "componentType": 5126, "count": 1, "type": "MAT4"}));
        let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(shares);
        document["skins"] = json!([{"joints": [2], "inverseBindMatrices": inverse}]);
        document["nodes"] = json!([
            {"children": [1, 2]},
            {"mesh": 0, "skin": 0, "scale": [0.01, 0.01, 0.01], "translation": [50, 0, 0]},
            {"translation": [0, 0, 7], "name": "j"},
        ]);
        change(document);
    })
}

#[test]
fn skins_hang_on_their_joints() {
    let geometry = merged(&bound(|_| {}));
    assert_eq!(reach(&geometry), [[0.0, -7.0, 0.0], [1.0, -7.0, 1.0]]);
    assert!((area(&geometry) - 1.0).abs() < 1e-6);
    assert!(geometry.normals.iter().flatten().all(|normal| near(*normal, [0.0, -1.0, 0.0])));
    // Without matrices joints are bound at the origin; the joint turns what hangs on it.
    let turned = bound(|document| {
        document["skins"][0].as_object_mut().expect("an object").remove("inverseBindMatrices");
        document["nodes"][2] = json!({"rotation": [0, 0, 1, 0]});
    });
    let [low, high] = reach(&merged(&turned));
    assert!(near(low, [-1.0, 0.0, -1.0]) && near(high, [0.0; 3]), "{low:?} {high:?}");
    // A joint that mirrors keeps the front in front.
    let mirrored = merged(&bound(|document| document["nodes"][2] = json!({"scale": [-1, 1, 1]})));
    let normals = crate::mesh::faceted(mirrored.clone()).expect("a good mesh").0.normals.expect("normals");
    assert!(normals.iter().all(|normal| near(*normal, [0.0, -1.0, 0.0])), "{normals:?}");
    assert!(mirrored.normals.iter().flatten().all(|normal| near(*normal, [0.0, -1.0, 0.0])));
}

#[test]
fn broken_skins_are_told() {
    let words = |change: &dyn Fn(&mut Value), place: &str, words: &str| {
        let error = whole_fault(&bound(change));
        assert!(error.place == place && error.message.contains(words), "{words}: {error:?}");
    };
    words(&|d| d["skins"][0]["joints"] = json!([9]), "/skins/0", "node 9, which is not there");
    words(&|d| d["skins"][0]["joints"] = json!([2, 2]), "/skins/0", "2 joints and 1 inverse bind matrices");
    words(&|d| d["nodes"][1]["skin"] = json!(3), "/nodes/1/skin", "points to nothing");
    words(&|d| d["skins"][0]["joints"] = json!([]), "/meshes/0/primitives/0", "hangs on joint 0, but the skin has 0");
    words(
        &|d| d["accessors"][5]["count"] = json!(3),
        "/meshes/0/primitives/0",
        "4 positions and 4 joints with 3 weights",
    );
    words(&|d| d["accessors"][6]["type"] = json!("VEC4"), "/accessors/6", "VEC4, not MAT4");
    // Joints in a circle stand nowhere.
    words(
        &|d| {
            d["nodes"][2]["children"] = json!([3]);
            push(d, "nodes", json!({"children": [2]}));
            d["nodes"][0]["children"] = json!([1]);
        },
        "/skins/0",
        "node 2, which is not there",
    );
    // A skin without joints at the vertices is no skin.
    let bare = bound(|document| {
        document["meshes"][0]["primitives"][0]["attributes"].as_object_mut().expect("an object").remove("WEIGHTS_0");
    });
    let (model, notes) = parts(&bare);
    assert!((model.parts[0].transform.rows[0][0] - 0.01).abs() < 1e-12);
    says(&notes, Fate::Dropped, "skins of meshes without joints are not read");
}

#[test]
fn morph_targets_have_the_weights_of_their_node_or_mesh() {
    let low = |change: &dyn Fn(&mut Value)| {
        let bytes = with_views(&[floats(&[0.0, 0.0, 4.0].repeat(4))], |document| {
            let by = push(
                document,
                "accessors",
                json!({"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC3"}),
            );
            document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": by}]);
            change(document);
        });
        reach(&merged(&bytes))[0]
    };
    assert_eq!(low(&|_| {}), [0.0; 3]);
    assert_eq!(low(&|d| d["meshes"][0]["weights"] = json!([0.5])), [0.0, -2.0, 0.0]);
    let both = |d: &mut Value| {
        d["meshes"][0]["weights"] = json!([0.5]);
        d["nodes"][0]["weights"] = json!([0.25]);
    };
    assert_eq!(low(&both), [0.0, -1.0, 0.0]);
    let error = whole_fault(&with_views(&[], |document| {
        let by = push(document, "accessors", json!({"componentType": 5126, "count": 3, "type": "VEC3"}));
        document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": by}]);
        document["meshes"][0]["weights"] = json!([1]);
    }));
    assert!(error.message.contains("4 positions and a morph target of 3"), "{error:?}");
}

fn sparse(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let views = [vec![2, 0], floats(&[5.0, 5.0, 0.0])];
    with_views(&views, |document| {
        document["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": 4, "componentType": 5123}, "values": {"bufferView": 5}});
        change(document);
    })
}

#[test]
fn sparse_accessors_are_read() {
    let geometry = merged(&sparse(|_| {}));
    assert_eq!((reach(&geometry), area(&geometry)), ([[0.0; 3], [5.0, 0.0, 5.0]], 5.0));
    let zeros = merged(&sparse(|document| {
        document["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
    }));
    assert_eq!(zeros.positions, [[0.0; 3], [0.0; 3], [5.0, 0.0, 5.0], [0.0; 3]]);
    let words = |change: &dyn Fn(&mut Value), words: &str| {
        let error = whole_fault(&sparse(change));
        assert!(error.place == "/accessors/0" && error.message.contains(words), "{words}: {error:?}");
    };
    words(&|d| d["accessors"][0]["sparse"]["count"] = json!(2), "its other 2 elements do not lie within");
    words(&|d| d["accessors"][0]["sparse"]["count"] = json!(4_000_000_000_u64), "times as large as the file");
    words(&|d| d["accessors"][0]["sparse"]["indices"]["byteOffset"] = json!(1), "do not lie within");
    words(&|d| d["accessors"][0]["sparse"]["indices"]["componentType"] = json!(5126), "unsigned whole numbers");
    let behind = json!({"bufferView": 5, "byteOffset": 2, "componentType": 5123});
    words(&|d| d["accessors"][0]["sparse"]["indices"] = behind.clone(), "element 16544 has another value");
}

#[test]
fn an_accessor_without_a_view_is_zeros() {
    let bytes = with_views(&[], |document| {
        document["accessors"][2] = json!({"componentType": 5126, "count": 4, "type": "VEC2"})
    });
    assert_eq!(uvs(&bytes), [[0.0, 1.0]; 4]);
    let huge = with_views(&[], |document| {
        document["accessors"][0] = json!({"componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3"});
    });
    assert!(fault(&huge).contains("times as large as the file"));
}

#[test]
fn valid_files_are_read_whatever_else_they_hold() {
    let (plain, _) = parts(&with_views(&[], |_| {}));
    let same = |change: &dyn Fn(&mut Value), words: &str| {
        let (model, notes) = parts(&with_views(&[], change));
        assert_eq!(model, plain, "{words}");
        match words {
            "" => assert_eq!(notes, []),
            words => says(&notes, Fate::Dropped, words),
        }
    };
    same(
        &|d| {
            let by = push(d, "accessors", json!({"componentType": 5126, "count": 4, "type": "SCALAR"}));
            d["meshes"][0]["primitives"][0]["attributes"]["_TEMPERATURE"] = json!(by);
        },
        "attributes of applications",
    );
    same(&|d| d["scenes"] = json!([{"nodes": [0]}, {"name": "empty"}]), "");
    same(
        &|d| {
            let target =
                json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/scale"}}});
            d["animations"] =
                json!([{"samplers": [{"input": 0, "output": 1}], "channels": [{"sampler": 0, "target": target}]}]);
        },
        "animations are not read",
    );
    for extras in [json!(null), json!([1, "a", {}]), json!("word"), json!(4), json!({"a": {"b": [null]}})] {
        same(
            &|d| {
                for path in
                    ["/asset", "/buffers/0", "/bufferViews/0", "/accessors/0", "/materials/0", "/meshes/0", "/nodes/0"]
                {
                    d.pointer_mut(path).expect("an object")["extras"] = extras.clone();
                }
                d["extras"] = extras.clone();
                d["meshes"][0]["primitives"][0]["extras"] = extras.clone();
            },
            "",
        );
        same(
            &|d| {
                for path in ["/asset", "/buffers/0", "/accessors/0", "/meshes/0", "/nodes/0", "/materials/0"] {
                    d.pointer_mut(path).expect("an object")["extensions"]["ACME_thing"] = extras.clone();
                }
                d["extensionsUsed"] = json!(["ACME_thing"]);
            },
            "the extension `ACME_thing` of glTF is not read",
        );
    }
    let deep = (0..500).fold(json!(1), |inner, at| if at % 2 == 0 { json!([inner]) } else { json!({ "a": inner }) });
    same(&|d| d["nodes"][0]["extras"] = deep.clone(), "");
    same(
        &|d| {
            d["meshes"][0]["extensions"] = json!({"ACME_deep": deep.clone()});
            d["extensionsUsed"] = json!(["ACME_deep"]);
        },
        "the extension `ACME_deep` of glTF is not read",
    );
    assert!(fault(&changed(|d| d["nodes"][0]["children"] = deep.clone())).contains("recursion limit"));
    same(&|d| d["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]), "");
    same(
        &|d| {
            d["cameras"] =
                json!([{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}]);
            d["nodes"][0]["camera"] = json!(0);
        },
        "cameras are not read",
    );
    same(
        &|d| {
            d["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
            d["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        },
        "lights (`KHR_lights_punctual`) are not read",
    );
    // Numbers that some programs write for whole ones.
    same(&|d| d["accessors"][0]["count"] = json!(4.0), "");
    // A scene that is empty has no triangles, and is not malformed.
    let empty = with_views(&[], |document| document["scenes"] = json!([{}]));
    assert_eq!(fault(&empty), "the file has no triangles in its scene");
    let hidden = with_views(&[], |document| {
        document["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    });
    assert_eq!(fault(&hidden), "the file has no triangles in its scene");
}

#[test]
fn images_without_a_core_source_are_losses() {
    let lost = |texture: Value| {
        let bytes = with_views(&[], |document| {
            painted(document, json!({"index": 0}));
            document["images"] = json!([{"uri": "a.png"}, {"uri": "a.ktx2"}]);
            document["textures"] = json!([texture]);
        });
        let surface = parts(&bytes).0.surfaces.remove(0);
        (surface.picture.is_some(), surface.lost.join("; "))
    };
    let basis = lost(json!({"extensions": {"KHR_texture_basisu": {"source": 1}}}));
    assert!(!basis.0 && basis.1.contains("KHR_texture_basisu"), "{basis:?}");
    let webp = lost(json!({"extensions": {"EXT_texture_webp": {"source": 1}}}));
    assert!(!webp.0 && webp.1.contains("EXT_texture_webp"), "{webp:?}");
    assert_eq!(lost(json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}})), (true, String::new()));
    assert!(lost(json!({})).1.contains("neither PNG nor JPEG"));
}

#[test]
fn what_is_required_is_read_or_named() {
    let error = |name: &str| whole_fault(&changed(|document| document["extensionsRequired"] = json!([name])));
    for name in [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "KHR_texture_basisu",
        "KHR_materials_clearcoat",
        "ACME_x",
    ] {
        let error = error(name);
        assert_eq!(error.message, format!("the file requires the extension `{name}` of glTF, which is not read"));
        assert_eq!((error.place.as_str(), error.help.is_some()), ("/extensionsRequired/0", true));
    }
    assert!(error("KHR_draco_mesh_compression").help.expect("help").contains("gltf-transform"));
    // The accessors of a compressed file have no bytes, which is not what is said.
    let draco = changed(|document| {
        document["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        document["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
    });
    assert!(fault(&draco).contains("KHR_draco_mesh_compression"));
    for name in ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit", "EXT_mesh_gpu_instancing"] {
        parts(&changed(|document| document["extensionsRequired"] = json!([name])));
    }
}

#[test]
fn colors_of_vertices_multiply_the_base_color() {
    let colored = |colors: &[f32], material: Value| {
        let bytes = with_views(&[floats(colors)], |document| {
            let kind = if colors.len() == 16 { "VEC4" } else { "VEC3" };
            let by =
                push(document, "accessors", json!({"bufferView": 4, "componentType": 5126, "count": 4, "type": kind}));
            document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(by);
            if material.is_null() {
                document["meshes"][0]["primitives"][0].as_object_mut().expect("an object").remove("material");
            } else {
                document["materials"][0] = material;
            }
        });
        let (model, _) = parts(&bytes);
        model.surfaces[model.parts[0].surface.expect("a material")].clone()
    };
    let plain = json!({"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 1, 1, 1]}});
    let red = [1.0, 0.0, 0.0].repeat(4);
    let Surface { scatter, lost, .. } = colored(&red, plain.clone());
    let base = [0.5, 0.0, 0.0];
    assert_eq!(scatter, Scatter::MetallicRoughness { base, metallic: 0.0, roughness: 1.0, ior: 1.5 });
    assert!(lost.is_empty(), "{lost:?}");
    assert_eq!(colored(&[1.0, 0.0, 0.0, 0.5].repeat(4), plain.clone()).scatter, scatter, "alpha is none of it");
    assert!(colored(&[1.0; 12], plain.clone()).lost.is_empty());
    // Corners 0 and 2 belong to both triangles: a third of 1, 0 and 0.5 twice over.
    let vary = colored(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0], plain);
    assert!(
        matches!(vary.scatter, Scatter::MetallicRoughness { base, .. } if (base[1] - 0.5).abs() < 1e-6),
        "{vary:?}"
    );
    assert!(vary.lost.iter().any(|lost| lost.contains("their mean stands for them")), "{vary:?}");
    let bare = colored(&red, Value::Null);
    assert_eq!(bare.scatter, Scatter::Diffuse([1.0, 0.0, 0.0]));
    let image = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let bytes = with_views(&[floats(&red)], |document| {
        painted(document, json!({"index": 0}));
        document["materials"][0] = image;
        let by =
            push(document, "accessors", json!({"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC3"}));
        document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(by);
    });
    let (model, _) = parts(&bytes);
    assert!(model.surfaces[1].lost.contains(&"colors of vertices over an image"), "{:?}", model.surfaces);
}

fn surface(material: Value) -> Surface {
    parts(&with_views(&[], |document| document["materials"][0] = material)).0.surfaces.remove(0)
}

#[test]
fn extensions_of_materials_are_read_or_lost() {
    let glossy = |own: Value| surface(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": own}}));
    let diffuse =
        glossy(json!({"diffuseFactor": [0.1, 0.2, 0.7, 1], "specularFactor": [0, 0, 0], "glossinessFactor": 0}));
    assert_eq!((diffuse.scatter, diffuse.lost), (Scatter::Diffuse([0.1, 0.2, 0.7]), vec![]));
    let metal =
        glossy(json!({"diffuseFactor": [0, 0, 0, 1], "specularFactor": [1, 0.8, 0.3], "glossinessFactor": 0.75}));
    let base = [1.0, 0.8, 0.3];
    assert_eq!(metal.scatter, Scatter::MetallicRoughness { base, metallic: 1.0, roughness: 0.25, ior: 1.5 });
    // A coat of 0.04 head-on is one of index 1.5.
    let coat = glossy(
        json!({"diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 1}),
    );
    assert!(
        matches!(coat.scatter, Scatter::MetallicRoughness { base, metallic: 0.0, roughness: 0.0, ior }
        if (ior - 1.5).abs() < 1e-12 && (base[0] - 0.5).abs() < 1e-12),
        "{coat:?}"
    );
    assert!(coat.lost.is_empty());
    let mixed = glossy(json!({"diffuseFactor": [0.5, 0.5, 0.5, 1], "specularFactor": [0.5, 0.2, 0.1]}));
    assert!(mixed.lost[0].contains("the color of specular reflection"), "{mixed:?}");

    let unlit = surface(json!({"pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.7, 1]},
        "extensions": {"KHR_materials_unlit": {}}}));
    assert_eq!(unlit.scatter, Scatter::Diffuse([0.1, 0.2, 0.7]));
    assert!(unlit.lost[0].contains("KHR_materials_unlit"), "{unlit:?}");

    let all = [
        ("KHR_materials_clearcoat", json!({"clearcoatFactor": 1.0})),
        ("KHR_materials_sheen", json!({"sheenColorFactor": [1, 0, 1]})),
        ("KHR_materials_anisotropy", json!({"anisotropyStrength": 1.0})),
        ("KHR_materials_iridescence", json!({"iridescenceFactor": 1.0})),
        ("KHR_materials_diffuse_transmission", json!({"diffuseTransmissionFactor": 1.0})),
        ("KHR_materials_dispersion", json!({"dispersion": 0.1})),
    ];
    for (name, own) in &all {
        let one = surface(json!({"extensions": {*name: own}}));
        assert!(one.lost.len() == 1 && one.lost[0].contains(name), "{name}: {:?}", one.lost);
        // What is switched off is not lost.
        for off in [json!({}), json!({"clearcoatFactor": 0, "sheenColorFactor": [0, 0, 0], "anisotropyStrength": 0.0})]
        {
            assert_eq!(surface(json!({"extensions": {*name: off}})).lost, Vec::<&str>::new(), "{name}");
        }
    }
    let glass = |extensions: Value| {
        surface(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions})).lost
    };
    let thin = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 1}}));
    assert!(thin.len() == 1 && thin[0].contains("thin"), "{thin:?}");
    let through = json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 2}});
    assert!(glass(through.clone()).is_empty());
    let mut tinted = through;
    tinted["KHR_materials_volume"] =
        json!({"thicknessFactor": 2, "attenuationDistance": 1, "attenuationColor": [1, 0, 0]});
    assert!(glass(tinted)[0].contains("absorption"));
}

#[test]
fn specular_reflection_is_an_index_of_refraction_where_it_can_be() {
    let read =
        |extensions: Value| surface(json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}));
    let ior = |surface: &Surface| match surface.scatter {
        Scatter::MetallicRoughness { ior, .. } | Scatter::Glass { ior, .. } => ior,
        Scatter::Diffuse(_) | Scatter::Mirror(_) => 0.0,
    };
    let doubled = read(json!({"KHR_materials_specular": {"specularColorFactor": [2, 2, 2]}}));
    // 0.08 head-on.
    assert!(
        (ior(&doubled) - (1.0 + 0.08_f64.sqrt()) / (1.0 - 0.08_f64.sqrt())).abs() < 1e-12 && doubled.lost.is_empty()
    );
    let none = read(
        json!({"KHR_materials_ior": {"ior": 0}, "KHR_materials_specular": {"specularColorFactor": [0.04, 0.04, 0.04]}}),
    );
    assert!((ior(&none) - 1.5).abs() < 1e-12 && none.lost.is_empty(), "{none:?}");
    for lost in [
        json!({"specularFactor": 0.5}),
        json!({"specularColorFactor": [1, 0.5, 1]}),
        json!({"specularColorFactor": [30, 30, 30]}),
    ] {
        let surface = read(json!({"KHR_materials_specular": lost}));
        assert_eq!((ior(&surface), surface.lost.len()), (1.5, 1), "{surface:?}");
    }
}

#[test]
fn emission_that_an_image_gives_is_not_that_of_its_factor() {
    let lamp = surface(json!({"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}));
    assert!(lamp.emission.is_none() && lamp.lost.iter().any(|lost| lost.contains("emissiveTexture")), "{lamp:?}");
    let both = surface(json!({"emissiveFactor": [1, 1, 1], "doubleSided": true}));
    assert!(both.emission.is_some() && both.lost.iter().any(|lost| lost.contains("back")), "{both:?}");
}

#[test]
fn numbers_out_of_range_are_said_with_their_place() {
    let bytes = changed(|document| {
        document["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(1.5);
        document["nodes"][1]["rotation"] = json!([0, 0, 1, 1]);
    });
    let (_, notes) = parts(&bytes);
    let found: Vec<(&str, &str)> = notes.iter().map(|note| (note.place.as_str(), note.message.as_str())).collect();
    assert_eq!(
        found,
        [
            ("/materials/0/pbrMetallicRoughness/roughnessFactor", "`roughnessFactor` is 1.5, and glTF asks for 0 to 1"),
            ("/nodes/1/rotation", "the rotation [0,0,1,1] is no unit quaternion"),
        ]
    );
}

#[test]
fn many_nodes_over_many_primitives_are_bounded() {
    let (mut document, bytes) = square();
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"] = json!(vec![primitive; 3000]);
    let nodes: Vec<Value> = (0..3000).map(|_| json!({"mesh": 0})).collect();
    document["nodes"] = json!(nodes);
    document["scenes"] = json!([{"nodes": (0..3000).collect::<Vec<u32>>()}]);
    let error = whole_fault(&glb(&document, &bytes));
    assert!(error.message.contains("times as large as the file"), "{error:?}");
}

/// What the crate gltf says of the primitives of a file: positions, normals, texture coordinates, corners.
type Told = Vec<(Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<u32>)>;

fn by_crate(bytes: &[u8]) -> Told {
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(bytes).expect("a file that the crate reads");
    let blob = blob.expect("a buffer");
    let primitives = document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
    primitives
        .map(|primitive| {
            let reader = primitive.reader(|_| Some(&blob));
            (
                reader.read_positions().expect("positions").collect(),
                reader.read_normals().expect("normals").collect(),
                reader.read_tex_coords(0).expect("coordinates").into_f32().collect(),
                reader.read_indices().expect("indices").into_u32().collect(),
            )
        })
        .collect()
}

#[test]
fn numbers_are_those_that_the_crate_gltf_reads() {
    let halves: Vec<u8> =
        [0_u16, 65_535, 65_535, 65_535, 65_535, 0, 13_107, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let strided = [floats(&[0.0, 0.0, 1.0]), vec![7; 8]].concat().repeat(4);
    let files = [
        with_views(&[], |_| {}),
        sparse(|_| {}),
        sparse(|document| {
            document["accessors"][0].as_object_mut().expect("an object").remove("bufferView");
        }),
        with_views(&[halves, strided], |document| {
            document["accessors"][2] =
                json!({"bufferView": 4, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC2"});
            document["bufferViews"][5]["byteStride"] = json!(20);
            document["accessors"][1]["bufferView"] = json!(5);
        }),
    ];
    for file in files {
        let (told, (model, _)) = (by_crate(&file), parts(&file));
        assert_eq!(told.len(), model.parts.len());
        for ((positions, normals, uvs, corners), part) in told.iter().zip(&model.parts) {
            let own = &model.meshes[part.mesh].1;
            assert_eq!((&own.positions, own.normals.as_ref()), (positions, Some(normals)));
            let downwards: Vec<[f32; 2]> = own.uvs.iter().flatten().map(|[u, v]| [*u, 1.0 - v]).collect();
            let near = |(a, b): (&[f32; 2], &[f32; 2])| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
            assert!(downwards.iter().zip(uvs).all(near), "{downwards:?} {uvs:?}");
            assert_eq!(own.triangles.as_flattened(), corners.as_slice());
        }
    }
}

#[test]
fn many_numbers_out_of_range_are_not_said_one_by_one() {
    let bytes = changed(|document| {
        let wrong = json!({"pbrMetallicRoughness": {"roughnessFactor": 7}});
        document["materials"].as_array_mut().expect("a list").extend(vec![wrong; 100]);
    });
    let (_, notes) = parts(&bytes);
    let found: Vec<(&str, &str)> = notes.iter().map(|note| (note.place.as_str(), note.message.as_str())).collect();
    let place = "/materials/1/pbrMetallicRoughness/roughnessFactor";
    assert_eq!(found, [(place, "`roughnessFactor` is 7, and glTF asks for 0 to 1 (100 times)")]);
}

/// Skin, morph target, sparse accessor, instances, colors and an image in one file.
fn everything() -> (Value, Vec<u8>) {
    let file = bound(|document| {
        document["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 1}});
        painted(
            document,
            json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 3], "rotation": 1}}}),
        );
        document["textures"][0]["sampler"] = json!(0);
        document["samplers"] = json!([{"wrapS": 33071}]);
        let primitive = &mut document["meshes"][0]["primitives"][0];
        primitive["targets"] = json!([{"POSITION": 1, "NORMAL": 1, "TEXCOORD_0": 2}]);
        primitive["attributes"]["COLOR_0"] = json!(1);
        document["meshes"][0]["weights"] = json!([0.5]);
        document["nodes"][2]["mesh"] = json!(0);
        document["nodes"][2]["extensions"] =
            json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0, "SCALE": 1, "ROTATION": 5}}});
    });
    let (text, chunk) = super::document::split(&file).expect("a good file");
    (serde_json::from_slice(text).expect("JSON"), file[chunk.expect("a chunk")].to_vec())
}

/// Pointers to all values within a value.
fn pointers(value: &Value, place: &str, all: &mut Vec<String>) {
    all.push(place.to_owned());
    match value {
        Value::Object(map) => map.iter().for_each(|(key, one)| pointers(one, &format!("{place}/{key}"), all)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(at, one)| pointers(one, &format!("{place}/{at}"), all))
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[test]
fn everything_at_once_is_read() {
    let (mut document, bytes) = everything();
    // Scales of 0 along an axis flatten; the normals are none.
    document["nodes"][2]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
        json!({"TRANSLATION": 0, "ROTATION": 5});
    let (model, notes) = parts(&glb(&document, &bytes));
    assert_eq!((model.parts.len(), model.meshes.len()), (5, 2), "{notes:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    /// One value of a file is another one: that is an error or a model that is consistent.
    #[test]
    fn any_value_anywhere_does_no_harm(at in any::<prop::sample::Index>(), what in 0..14_usize) {
        let (mut document, bytes) = everything();
        let mut all = Vec::new();
        pointers(&document, "", &mut all);
        let values = [
            json!(null), json!(-1), json!(0), json!(1), json!(2), json!(99), json!(1e300), json!(u64::MAX), json!(4_000_000_000_u64),
            json!("x"), json!([]), json!({}), json!([0, 0, 0, 0]), json!([1e30, -1e30, 0.5]),
        ];
        *document.pointer_mut(&all[at.index(all.len())]).expect("a value") = values[what].clone();
        let file = glb(&document, &bytes);
        if let Ok((model, _)) = read_parts("glb", &file, &mut alone) {
            prop_assert!(model.meshes.iter().all(|(_, geometry)| geometry.check().is_ok()));
            for part in &model.parts {
                prop_assert!(part.mesh < model.meshes.len() && part.surface.is_none_or(|at| at < model.surfaces.len()));
            }
        }
        if let Ok((geometry, _)) = read_file("glb", &file, None, &mut alone) {
            prop_assert!(geometry.check().is_ok());
        }
    }
}
