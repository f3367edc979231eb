//! Words, arrays, includes, blocks, and whatever is wrong with them.

use proptest::prelude::*;

use super::*;
use crate::import::pbrt::tokens::{Token, Tokens};

fn words(text: &str) -> Vec<Token> {
    let file = Sources::default().add("a", text);
    let mut tokens = Tokens::new(text, 0, file);
    std::iter::from_fn(|| tokens.next().map(|(token, _)| token)).collect()
}

#[test]
fn text_is_cut_into_words() {
    use Token::{Broken, Close, Number, Open, Quoted, Word};
    let all = words("# a \"b\"\nShape \"x\\\"y\"[1,-2.5 .5 1e3]#c\r\ntrue");
    let known = vec![
        Word("Shape".to_owned()),
        Quoted("x\"y".to_owned()),
        Open,
        Number(1.0),
        Number(-2.5),
        Number(0.5),
        Number(1000.0),
        Close,
        Word("true".to_owned()),
    ];
    assert_eq!(all, known);
    assert_eq!(words("\"a\nb"), [Broken, Word("b".to_owned())]);
    assert_eq!(words("nan inf 1e999"), ["nan", "inf", "1e999"].map(|word| Word(word.to_owned())));
    assert_eq!(
        words("0.1 123456789012345678 4503599627370497.5"),
        [0.1, 123456789012345680.0, 4503599627370497.5].map(Number)
    );
}

#[test]
fn commas_single_values_and_both_kinds_of_booleans_are_read() {
    let read =
        world("Material \"glass\" \"float eta\" 1.25 \"bool remaproughness\" [\"false\"]\n\"float roughness\" [0.5,]");
    assert_eq!(read.said(), []);
    assert_eq!(read.bsdf(), &Bsdf::Dielectric { interior: 1.25, exterior: 1.0, alpha: 0.5 });
    let read = world("Material \"glass\" \"bool remaproughness\" false \"float roughness\" [ 0.5 ]");
    assert_eq!(read.bsdf(), &Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.5 });
}

#[test]
fn what_is_wrong_is_said_at_its_line() {
    let cases = [
        ("Foo 1 2", "`Foo` is left out"),
        ("Translate 1 2", "three numbers must follow"),
        ("Material \"matte\" \"float\" [1]", "no type with a name"),
        ("Material \"matte\" \"rgb Kd\" [1 nan 0]", "neither a finite number"),
        ("Material \"matte\" \"rgb Kd\" [1 0]", "not three finite numbers"),
        ("Material \"matte\" \"rgb Kd\"", "has no value"),
        ("Material \"matte\" \"float foo\" 1", "`float foo` of `matte` is left out"),
        ("Material \"matte\" \"rgb Kd\" [1 \"a\" 1]", "numbers and strings"),
        ("Material \"matte\" \"rgb Kd", "without an end"),
        ("NamedMaterial \"none\"", "there is no material"),
        ("Material \"matte\" \"texture Kd\" \"none\"", "there is no texture"),
        ("AttributeEnd", "it ends nothing"),
        ("ObjectEnd", "ends nothing"),
        ("ObjectInstance \"none\"", "there is no object"),
        ("CoordSysTransform \"none\"", "no coordinate system"),
        ("Rotate 10 0 0 0", "about no axis"),
        ("LookAt 0 0 0 0 0 0 0 1 0", "no direction"),
        ("Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]", "last row"),
        ("1 2 3", "belong to no directive"),
        ("WorldBegin", "a second `WorldBegin`"),
        ("ActiveTransform EndTime Translate 5 5 5 ActiveTransform All", "motion"),
        ("MediumInterface \"\" \"fog\"", "a medium is left out"),
        ("Volume \"homogeneous\" \"color sigma_a\" [1 1 1]", "a medium is left out"),
        ("LightSource \"goniometric\"", "is left out: it is not read"),
        ("Shape \"curve\" \"point P\" [0 0 0]", "are left out: they are not read"),
        ("Shape \"trianglemesh\" \"point P\" [0 0 0 1]", "are no positions"),
        ("Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 0 0 1]", "are no triangles"),
        (
            "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 5]",
            "the mesh has 3 vertices",
        ),
        ("Shape \"plymesh\" \"string filename\" \"none.ply\"", "cannot be read"),
        ("Shape \"plymesh\" \"string filename\" \"none.ply.gz\"", "is compressed"),
        ("Shape \"plymesh\" \"string filename\" \"/none.ply\"", "is not read"),
        ("Include \"none.pbrt\"", "is not included"),
        ("Include \"none.pbrt.gz\"", "compressed"),
    ];
    for (text, words) in cases {
        let read = world(&format!("\n{text}"));
        assert!(read.says(4, "loss-dropped", words), "{text}: {:?}", read.said());
        // Whatever it was, reading went on.
        assert_eq!(read.scene().shapes.len(), 1, "{text}: {:?}", read.said());
    }
    let read = world("Material \"mirror\" \"rgb Kr\" [1 1 1] \"rgb Kr\" [0 0 0]");
    assert!(read.says(3, "loss-baked", "stands twice") && read.bsdf().is_black());
    let read = world("AttributeBegin");
    assert!(read.says(3, "loss-dropped", "a block is not ended"), "{:?}", read.said());
    let read = read_with(&format!("{HEAD}Shape \"sphere\" \"float radius\" [1"), &[]);
    assert!(read.says(3, "loss-dropped", "an array has no end"), "{:?}", read.said());
    assert!(read_with("# nothing\n", &[]).scene.is_none());
    let read = world("WorldEnd\nShape \"sphere\"");
    assert!(read.says(4, "loss-dropped", "behind `WorldEnd`"));
}

#[test]
fn files_are_included_once_each_and_not_without_end() {
    let inner = b"Material \"mirror\"".as_slice();
    let read = read_with(&format!("{HEAD}Include \"b/inner.pbrt\"{TRIANGLE}"), &[("a/b/inner.pbrt", inner)]);
    assert_eq!(read.said(), []);
    assert_eq!(read.bsdf().word(), "mirror");
    let read = read_with(&format!("{HEAD}Include \"b.pbrt\""), &[("a/b.pbrt", b"\nInclude \"scene.pbrt\"")]);
    assert!(read.says(2, "import-limit", "includes itself"), "{:?}", read.said());
    // Paths are meant from the main file; those from the file that includes are found too.
    let files: [(&str, &[u8]); 2] = [("a/b/c.pbrt", b"Include \"d.pbrt\""), ("a/b/d.pbrt", b"Material \"mirror\"")];
    let read = read_with(&format!("{HEAD}Include \"b/c.pbrt\"{TRIANGLE}"), &files);
    assert_eq!(read.said(), []);
    assert_eq!(read.bsdf().word(), "mirror");
}

#[test]
fn includes_that_multiply_end() {
    let names: Vec<String> = (0..31).map(|at| format!("a/f{at}.pbrt")).collect();
    let texts: Vec<String> = (0..31).map(|at| format!("Include \"f{0}.pbrt\" Include \"f{0}.pbrt\"", at + 1)).collect();
    let mut files = MemoryFiles::default();
    files.insert("a/scene.pbrt", format!("{HEAD}Include \"f0.pbrt\""));
    for (name, text) in names.iter().zip(&texts) {
        files.insert(name, text.as_bytes().to_vec());
    }
    let path = VPath::resolve("", "a/scene.pbrt").expect("a path");
    let mut options = Options::default();
    options.limits.steps = 10_000;
    let mut sources = Sources::default();
    let read = import(find(&path).expect("an importer"), &files, &mut sources, &path, &options);
    assert!(read.findings.iter().any(|finding| finding.message.contains("more than 10000 directives")));
}

#[test]
fn blocks_restore_what_they_should() {
    let text = "AttributeBegin Translate 1 0 0 ReverseOrientation Material \"mirror\" AttributeEnd\n\
                TransformBegin Translate 2 0 0 Material \"glass\" TransformEnd";
    let read = world(text);
    assert_eq!(read.said(), []);
    // A block of transforms keeps the material.
    assert_eq!(read.bsdf().word(), "dielectric");
    assert_eq!(read.shape(0).transform, crate::ir::Affine::IDENTITY);
    assert!(close(&read.front(0), &[0.0, 0.0, 1.0]));
}

#[test]
fn transforms_apply_the_last_one_first() {
    let read = world("Translate 1 2 3 Scale 2 2 2 Rotate 90 0 0 1");
    assert!(close(&read.shape(0).transform.point([1.0, 0.0, 0.0]), &[1.0, 4.0, 3.0]));
    let read = world(
        "ConcatTransform [2 0 0 0 0 2 0 0 0 0 2 0 5 6 7 1] CoordinateSystem \"here\" Identity CoordSysTransform \"here\"",
    );
    assert!(close(&read.shape(0).transform.point([1.0, 1.0, 1.0]), &[7.0, 8.0, 9.0]));
    // A point at the eye's own place, one step ahead.
    let read = world("CoordSysTransform \"camera\"");
    assert!(close(&read.shape(0).transform.point([0.0, 0.0, 1.0]), &[0.0, 0.0, 4.0]));
}

#[test]
fn objects_are_groups_with_instances() {
    let text = format!(
        "ObjectBegin \"o\" Translate 1 0 0 AreaLightSource \"diffuse\"{TRIANGLE}ObjectEnd\nTranslate 0 5 0 ObjectInstance \"o\" Identity"
    );
    let read = world(&text);
    assert_eq!(read.said().len(), 1);
    assert!(read.says(4, "loss-baked", "does not emit"));
    let scene = read.scene();
    let group = scene.groups.values().next().expect("a group");
    let inner = group.shapes.values().next().expect("a shape");
    let place = scene.instances.values().next().expect("an instance").places.maps()[0];
    assert_eq!(inner.emission, None);
    assert!(close(&inner.transform.then(&place).point([0.0; 3]), &[1.0, 5.0, 0.0]));
    assert_eq!((scene.shapes.len(), scene.groups.len(), scene.instances.len()), (1, 1, 1));
}

#[test]
fn large_meshes_are_read_fast() {
    let count = 100_000;
    let mut text = format!("{HEAD}Shape \"trianglemesh\" \"integer indices\" [");
    (0..count - 2).for_each(|at| text.push_str(&format!("{at} {} {} ", at + 1, at + 2)));
    text.push_str("] \"point P\" [");
    (0..count).for_each(|at| text.push_str(&format!("{}.25 {}e-1, 0.5\n", at, at % 7)));
    text.push(']');
    let read = super::read(&text);
    assert_eq!(read.said(), []);
    let mesh = read.scene().meshes.values().next().expect("a mesh");
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (count, count - 2));
    assert_eq!(mesh.positions[count - 1], [99999.25, 0.4, 0.5]);
}

/// A scene with one of everything.
const ALL: &str = r#"
Option "integer seed" 3
Scale -1 1 1 LookAt 0 0 5 0 0 0 0 1 0
Camera "perspective" "float fov" [45] "float screenwindow" [-1 1 -1 1]
Film "rgb" "integer xresolution" 100 "integer yresolution" [50]
PixelFilter "mitchell" Sampler "halton" "integer pixelsamples" 8 Integrator "volpath" "integer maxdepth" 4
WorldBegin
Attribute "material" "float roughness" 0.25
MakeNamedMaterial "m" "string type" "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
Texture "t" "spectrum" "checkerboard" "rgb tex1" [.2 .3 .4] "float uscale" 4
AttributeBegin AreaLightSource "diffuse" "blackbody L" [3000] "float power" 10 Shape "sphere" "float radius" .5 AttributeEnd
ObjectBegin "o" NamedMaterial "m" Shape "bilinearmesh" "point3 P" [0 0 0 1 0 0 0 1 0 1 1 1] ObjectEnd
TransformBegin Rotate 30 0 0 1 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1] ObjectInstance "o" TransformEnd
Material "coateddiffuse" "texture reflectance" "t" ReverseOrientation
Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "normal N" [0 0 1 0 0 1 0 0 1] "point2 uv" [0 0 1 0 0 1] "integer indices" [0 1 2]
Shape "disk" "float innerradius" .2 "float phimax" 90 Shape "loopsubdiv" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 2]
LightSource "spot" "point3 from" [0 0 1] "point3 to" [0 0 0] LightSource "infinite" "rgb L" [1 2 3] "float illuminance" 5
Include "scene.pbrt" Import "other.pbrt" MediumInterface "a" "b"
"#;

#[test]
fn a_scene_with_one_of_everything_is_read() {
    let read = super::read(ALL);
    assert_eq!(read.scene().shapes.len(), 4, "{:?}", read.said());
    assert!(read.scene().instances.len() == 1 && read.scene().lights.len() == 2);
    assert!(crate::pipeline::prepare(read.scene().clone()).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn changed_texts_make_valid_scenes(
        changes in prop::collection::vec((0.0..1.0_f64, 0_usize..12, prop::sample::select(vec![
            "\"", "[", "]", " ", "-1", "1e38", "4294967296", "nan", "#", "\\", "AttributeBegin", "WorldBegin", "0",
            "Scale 0 0 0 ", "ObjectBegin \"x\" ", "ObjectEnd ", "\u{e9}", "\n", ",", "Identity ",
        ])), 1..12),
    ) {
        let mut text = ALL.to_owned();
        for (place, length, by) in changes {
            let mut at = (place * text.len() as f64) as usize;
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            let mut end = (at + length).min(text.len());
            while !text.is_char_boundary(end) {
                end -= 1;
            }
            text.replace_range(at..end.max(at), by);
        }
        if let Some(scene) = super::read(&text).scene {
            let findings = crate::pipeline::prepare(scene).err().unwrap_or_default();
            // What is left may be nothing.
            let wrong = |found: &&Finding| found.severity == Severity::Error && !found.message.contains("has no shape");
            prop_assert_eq!(findings.iter().find(wrong).map(|found| &found.message), None, "{}", text);
        }
    }

    #[test]
    fn any_bytes_never_panic(text in ".{0,200}") {
        let _read = super::read(&format!("WorldBegin {text}"));
    }
}
