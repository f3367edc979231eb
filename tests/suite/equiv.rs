//! `ltsc equiv`: the thesis's scenes in two formats, and planted differences as the command tells them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{Ran, corpus, ltsc, root, run, skip};

fn compared(folder: &Path, a: &Path, b: &Path, more: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).arg("equiv").arg(a).arg(b).args(more))
}

fn document(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}\n{}\n{}", ran.out, ran.err))
}

/// Kind, what A has and what B has, of all differences.
fn rows(document: &Value) -> Vec<[String; 3]> {
    let rows = document["differences"].as_array().expect("differences").iter();
    rows.map(|row| ["kind", "a", "b"].map(|key| row[key].as_str().expect("a word").to_owned())).collect()
}

#[test]
fn the_thesis_s_pairs_differ_in_what_only_mitsuba_says() {
    let Some(corpus) = corpus() else { return skip("the thesis's scenes", "../shared/corpus/lteval") };
    let folders = fs::read_dir(corpus).expect("a folder").map(|entry| entry.expect("an entry").path());
    let scenes: Vec<_> = folders.filter(|folder| folder.is_dir()).collect();
    assert_eq!(scenes.len(), 11);
    for folder in scenes {
        let (a, b) = (folder.join("mitsuba_0_5/scene.xml"), folder.join("pbrt_3/scene.pbrt"));
        let ran = compared(root(), &a, &b, &["--format", "json"]);
        let document = document(&ran);
        let rows = rows(&document);
        assert_eq!(rows.len(), 2, "{folder:?} {rows:#?}");
        let [reading, sides] = [&rows[0], &rows[1]];
        assert!(reading[0] == "reading" && reading[1].contains("`strictNormals`") && reading[2] == "-", "{rows:#?}");
        assert!(sides[0] == "material" && sides[1] == "the front" && sides[2] == "both", "{rows:#?}");
        assert_eq!(document["surfaces"]["a"], document["surfaces"]["found"], "{folder:?}");
        assert_eq!(document["surfaces"]["a"], document["surfaces"]["b"], "{folder:?}");
    }
}

#[test]
fn our_cornell_box_is_that_of_the_thesis() {
    let Some(corpus) = corpus() else { return skip("the thesis's cbox_classic", "../shared/corpus/lteval") };
    for name in ["cbox_classic", "cbox_empty"] {
        let ours = root().join(format!("scenes-src/{name}.lts"));
        let ran = compared(root(), &ours, &corpus.join(name).join("pbrt_3/scene.pbrt"), &[]);
        assert_eq!(ran.code, Some(0), "{}{}", ran.out, ran.err);
        assert!(ran.out.starts_with("no difference"), "{}", ran.out);
    }
}

const MITSUBA: &str = "<scene version=\"3.0.0\"><integrator type=\"path\"><integer name=\"max_depth\" value=\"5\"/></integrator>
    <sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/>
        <transform name=\"to_world\"><lookat origin=\"0, -9, 1\" target=\"0, 0, 1\" up=\"0, 0, 1\"/></transform>
        <sampler type=\"independent\"><integer name=\"sample_count\" value=\"16\"/></sampler>
        <film type=\"hdrfilm\"><integer name=\"width\" value=\"64\"/><integer name=\"height\" value=\"64\"/><rfilter type=\"box\"/></film>
    </sensor>
    <bsdf type=\"twosided\" id=\"grey\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf></bsdf>
    <shape type=\"cube\" id=\"block\"><transform name=\"to_world\"><translate x=\"2\"/></transform><ref id=\"grey\"/></shape>
    <shape type=\"rectangle\" id=\"floor\"><transform name=\"to_world\"><scale value=\"4\"/><translate z=\"-1\"/></transform><ref id=\"grey\"/></shape>
    <emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"4\"/><rgb name=\"intensity\" value=\"3\"/></emitter></scene>";

#[test]
fn planted_differences_are_told_with_their_places() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.xml"), MITSUBA).expect("written");
    // What `import` makes of it is the same.
    let ran = run(ltsc().current_dir(folder.path()).args(["import", "a.xml", "-o", "b.lts"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let ran = compared(folder.path(), &at("a.xml"), &at("b.lts"), &[]);
    assert!(ran.code == Some(0) && ran.out.starts_with("no difference"), "{}{}", ran.out, ran.err);
    let changes = [
        ("value=\"40\"", "value=\"41\"", "camera", "41"),
        ("value=\"5\"", "value=\"6\"", "integrator", "6"),
        ("value=\"16\"", "value=\"17\"", "sampler", "17"),
        ("name=\"width\" value=\"64\"", "name=\"width\" value=\"65\"", "film", "65 x 64"),
        ("value=\"0.5\"", "value=\"0.51\"", "material", "0.51"),
        ("<translate x=\"2\"/>", "<translate x=\"2.01\"/>", "surface", "around (2.01, 0, 0)"),
        ("value=\"3\"", "value=\"4\"", "light", "4"),
    ];
    for (from, to, kind, words) in changes {
        fs::write(at("c.xml"), MITSUBA.replacen(from, to, 1)).expect("written");
        let ran = compared(folder.path(), &at("a.xml"), &at("c.xml"), &["--format", "json"]);
        assert_eq!(ran.code, Some(1), "{to}: {}{}", ran.out, ran.err);
        let document = document(&ran);
        let rows = rows(&document);
        assert!(rows.iter().any(|row| row[0] == kind && row[2].contains(words)), "{to}: {rows:#?}");
        assert!(rows.len() == 1, "{to}: {rows:#?}");
        assert_eq!(document["equal"], false);
    }
    let ran = compared(folder.path(), &at("a.xml"), &at("c.xml"), &["--tolerance", "50%"]);
    assert_eq!(ran.code, Some(0), "{}", ran.out);
    let ran = compared(folder.path(), &at("a.xml"), &at("c.xml"), &["--format", "short"]);
    assert!(ran.out.contains("a.xml:10:5: light: point intensity: `point` A 3, B 4\n"), "{}", ran.out);
    let ran = compared(folder.path(), &at("a.xml"), &at("none.xml"), &[]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    let ran = compared(folder.path(), &at("a.xml"), folder.path(), &[]);
    assert_eq!(ran.code, Some(2), "{}", ran.err);
}
