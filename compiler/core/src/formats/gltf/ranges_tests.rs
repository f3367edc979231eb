//! Every number that is written holds what glTF asks of it, and what does not hold it is found by the reader.

use std::collections::BTreeMap;

use proptest::prelude::*;
use serde_json::{Value, json};

use super::super::tests::{emitted, lit};
use super::tests::only;
use crate::diag::Origin;
use crate::files::{MemoryFiles, VPath};
use crate::formats::find;
use crate::formats::shared::sample;
use crate::formats::shared::source::Source;
use crate::ir::{Affine, Bsdf, Color, Emission, LightKind, LightSource, Meaning, Scene, Spectrum};

/// What the reader says of the files of the target `gltf`, after `change` of the document.
fn faults(scene: Scene, change: impl FnOnce(&mut Value)) -> Vec<String> {
    let name = scene.name.clone();
    let mut sink = emitted("gltf", scene).files;
    let main = format!("{name}.gltf");
    let mut document: Value = serde_json::from_slice(&sink[&main]).expect("JSON");
    change(&mut document);
    sink.insert(main.clone(), document.to_string().into_bytes());
    read(&sink, &main)
}

fn read(files: &BTreeMap<String, Vec<u8>>, main: &str) -> Vec<String> {
    let mut memory = MemoryFiles::default();
    for (path, bytes) in files {
        memory.insert(path.clone(), bytes.clone());
    }
    let mut source = Source::new(&memory);
    let import = find("gltf").expect("a target").import.expect("a reader");
    import(&VPath::resolve("", main).expect("a path"), &mut source);
    let line = |finding: crate::diag::Finding| format!("{:?} {}", finding.origin, finding.message);
    source.finish().into_iter().map(line).collect()
}

fn light(points: &[(f64, f64)]) -> Color {
    Color::Spectrum(Spectrum::new(points, Meaning::Light))
}

fn add(scene: &mut Scene, name: &str, bsdf: Bsdf, radiance: Option<Color>) {
    let block = sample::block(scene, name, [2.0, 3.0, 4.0], [20.0, 20.0, 20.0], 0.0);
    let material = sample::material(scene, name, bsdf);
    sample::shape(scene, name, block, material, radiance.map(|radiance| Emission { radiance }));
}

#[test]
fn emitters_and_lights_of_spectra_have_factors_up_to_1() {
    let reddish = [(400.0, 2.0), (700.0, 2.0)];
    let mut scene = lit();
    add(&mut scene, "flat", Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() }, Some(light(&reddish)));
    let kind = LightKind::Point { position: [0.0; 3], intensity: light(&reddish) };
    scene.lights.push(LightSource { name: "spectral".to_owned(), kind }, Origin::Made);
    let sink = emitted("glb", scene.clone());
    let (document, _) = only(&sink);
    let rgb = light(&reddish).rgb();
    let find = |list: &Value, name: &str| {
        list.as_array().expect("a list").iter().find(|one| one["name"] == name).expect("a thing of that name").clone()
    };
    let flat = find(&document["materials"], "flat");
    let near = |value: &Value, to: f64| (value.as_f64().expect("a number") - to).abs() < 1e-12 * to;
    let strength = &flat["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
    assert!(near(&flat["emissiveFactor"][0], 1.0) && near(strength, rgb[0]), "{flat}");
    assert!(near(&flat["emissiveFactor"][1], rgb[1] / rgb[0]));
    let point = find(&document["extensions"]["KHR_lights_punctual"]["lights"], "spectral");
    assert!(near(&point["color"][0], 1.0) && near(&point["intensity"], rgb[0]), "{point}");
    assert_eq!(faults(scene, |_| {}), Vec::<String>::new());
}

#[test]
fn glass_has_the_thickness_of_each_mesh() {
    let mut scene = sample::room();
    let glass = sample::material(&mut scene, "glass", Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.0 });
    for (name, size) in [("thin", 1.0), ("thick", 3.0), ("other", 3.0)] {
        let block = sample::block(&mut scene, name, [size; 3], [0.0, 0.0, 30.0], 0.0);
        sample::shape(&mut scene, name, block, glass, None);
    }
    // Sheared, so that its vertices are moved.
    let shear = Affine { rows: [[2.0, 0.0, 2.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]] };
    let block = sample::block(&mut scene, "skew", [1.0; 3], [0.0, 0.0, 30.0], 0.0);
    let skew = sample::shape(&mut scene, "skew", block, glass, None);
    scene.shapes[skew].transform = shear;
    let sink = emitted("glb", scene);
    let (document, _) = only(&sink);
    let nodes = document["nodes"].as_array().expect("nodes");
    let thickness = |name: &str| {
        let node = nodes.iter().find(|node| node["name"] == name).expect("a node");
        let mesh = &document["meshes"][node["mesh"].as_u64().expect("a mesh") as usize];
        let material = mesh["primitives"][0]["material"].as_u64().expect("a material") as usize;
        let volume = &document["materials"][material]["extensions"]["KHR_materials_volume"];
        (volume["thicknessFactor"].as_f64().expect("a thickness"), material)
    };
    assert_eq!((thickness("thin").0, thickness("thick").0, thickness("skew").0), (1.0, 3.0, 2.0));
    assert_eq!(thickness("thick"), thickness("other"));
}

#[test]
fn what_is_out_of_range_is_found() {
    let found = |words: &str, change: fn(&mut Value)| {
        let faults = faults(lit(), change);
        assert!(faults.iter().any(|line| line.contains(words)), "{words}: {faults:?}");
    };
    assert_eq!(faults(lit(), |_| {}), Vec::<String>::new());
    found("`emissiveFactor` is 1.2, and glTF asks for 0 to 1", |d| {
        for material in d["materials"].as_array_mut().expect("a list") {
            material["emissiveFactor"] = json!([0, 1.2, 0]);
        }
    });
    found("/materials/0/pbrMetallicRoughness/baseColorFactor", |d| {
        d["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([-0.1, 0, 0, 1]);
    });
    found("`roughnessFactor` is 2", |d| d["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(2));
    found("`ior` is 0.5, and glTF asks for 0 or at least 1", |d| {
        d["materials"][0]["extensions"]["KHR_materials_ior"] = json!({"ior": 0.5});
    });
    found("`color` is 1.5", |d| d["extensions"]["KHR_lights_punctual"]["lights"][0]["color"] = json!([1.5, 0, 0]));
    found("`intensity` is -1", |d| d["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(-1));
    found("`innerConeAngle` is not less", |d| {
        d["extensions"]["KHR_lights_punctual"]["lights"][2]["spot"]["innerConeAngle"] = json!(1.2);
    });
    found("`yfov` is 4", |d| d["cameras"][0]["perspective"]["yfov"] = json!(4));
    found("/accessors/0/max", |d| d["accessors"][0]["max"][1] = json!(1e6));
    found("positions have no `min` and `max`", |d| {
        d["accessors"][0].as_object_mut().expect("an object").remove("min");
    });
    found("the index 99 points to nothing", |d| d["meshes"][0]["primitives"][0]["material"] = json!(99));
    found("the index 98 points to nothing", |d| d["nodes"][0]["children"] = json!([98]));
    found("the index 97 points to nothing", |d| d["accessors"][0]["bufferView"] = json!(97));
    found("the matrix is not affine", |d| d["nodes"][0]["matrix"][3] = json!(1));
    let textured = || super::super::surface_tests::textured(crate::ir::ImageFormat::Png, crate::ir::Encoding::Srgb);
    for (path, words) in [("sampler", "/textures/0/sampler"), ("source", "/textures/0/source")] {
        let faults = faults(textured(), |d| d["textures"][0][path] = json!(7));
        assert!(faults.iter().any(|line| line.contains(words)), "{faults:?}");
    }
}

fn spectrum(high: f64) -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec(0.0..high, 4).prop_map(|values| {
        let at = [400.0, 480.0, 560.0, 700.0];
        at.into_iter().zip(values).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn every_number_holds_its_range(
        emitted in spectrum(50.0), reflected in spectrum(1.0), rgb in prop::array::uniform3(0.0..1.5_f64),
        alpha in 0.0..1.0_f64, ior in 1.01..2.5_f64, k in 0.1..5.0_f64, angle in 1.0..90.0_f64, share in 0.0..1.0_f64
    ) {
        let mut scene = lit();
        let color = Color::Spectrum(Spectrum::new(&reflected, Meaning::Share));
        let bright = Color::Rgb(rgb);
        let bsdfs = [
            Bsdf::Diffuse { reflectance: color.clone().into() },
            Bsdf::Diffuse { reflectance: bright.clone().into() },
            Bsdf::Mirror { reflectance: bright.clone() },
            Bsdf::Plastic { reflectance: bright.clone().into(), ior, alpha },
            Bsdf::Principled { base: bright.into(), metallic: share, roughness: alpha, ior },
            Bsdf::Conductor { eta: Color::Rgb([ior, k, 0.2]), k: Color::Grey(k), alpha },
            Bsdf::Dielectric { interior: ior, exterior: 1.0, alpha },
            Bsdf::Dielectric { interior: 1.0, exterior: ior, alpha },
        ];
        for (at, bsdf) in bsdfs.into_iter().enumerate() {
            add(&mut scene, &format!("block {at}"), bsdf, None);
        }
        add(&mut scene, "lamp of a spectrum", Bsdf::Diffuse { reflectance: color.into() }, Some(light(&emitted)));
        let kinds = [
            LightKind::Directional { direction: [0.0, 0.6, -0.8], irradiance: light(&emitted) },
            LightKind::Spot { position: [1.0; 3], target: [0.0; 3], intensity: light(&emitted), angle, inner: angle * share },
        ];
        for kind in kinds {
            scene.lights.push(LightSource { name: format!("a {}", kind.word()), kind }, Origin::Made);
        }
        prop_assert_eq!(faults(scene, |_| {}), Vec::<String>::new());
    }
}
