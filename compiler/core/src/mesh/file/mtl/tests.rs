//! Material libraries: what surfaces statements make, and what is said of those that are not understood.

use proptest::prelude::*;

use super::*;

fn library(text: &str) -> (Materials, Vec<String>) {
    let (mut materials, mut notes) = (Materials::default(), Vec::new());
    materials.read(text.as_bytes(), "a.mtl", &mut notes);
    (materials, notes.into_iter().map(|note| format!("{}: {}", note.place, note.message)).collect())
}

/// The scattering of a material with these statements, and what of it is lost.
fn made(statements: &str) -> (Scatter, Vec<&'static str>) {
    let (materials, notes) = library(&format!("newmtl a\n{}", statements.replace("; ", "\n")));
    assert_eq!(notes, Vec::<String>::new(), "{statements}");
    let Surface { scatter, lost, .. } = materials.surfaces[0].clone();
    (scatter, lost)
}

const GLASS: Scatter = Scatter::Glass { ior: 1.5, alpha: 0.0 };
const BLUE: Scatter = Scatter::Diffuse([0.2, 0.2, 0.8]);

#[test]
fn opacity_decides_with_the_illumination_model() {
    let opacity = "opacity (`d`), by which things are seen through a surface without being refracted";
    let contradicts = "`Tr`, which contradicts `d`";
    let tint = "the color (`Kd`) of what is taken for clear glass";
    let means_opaque = "`Tr 1`, by which several programs mean that a surface is opaque";
    for (statements, scatter, lost) in [
        ("Kd 0.2 0.2 0.8; Ni 1.5; d 1", BLUE, &[][..]),
        // Written for opaque surfaces by MeshLab and others.
        ("Kd 0.2 0.2 0.8; Ni 1.5; d 1.0; Tr 1.0; illum 2", BLUE, &[contradicts]),
        ("Kd 0.2 0.2 0.8; Tr 1; illum 2", BLUE, &[means_opaque]),
        ("Kd 0.2 0.2 0.8; Tr 1; Ni 1.5", BLUE, &[means_opaque]),
        ("Kd 0.2 0.2 0.8; Ni 1.5; Tr 0; d 1", BLUE, &[]),
        // Nearly opaque, by a model without refraction.
        ("Kd 0.2 0.2 0.8; Ni 1.45; d 0.999; illum 2", BLUE, &[opacity]),
        ("Kd 0.2 0.2 0.8; Ni 1.45; d 0.1; illum 2", BLUE, &[opacity]),
        ("Kd 0.2 0.2 0.8; Ni 1.5; d 0.9; illum 4", BLUE, &[opacity]),
        ("Kd 0.2 0.2 0.8; Ni 1.5; illum 9", BLUE, &[]),
        ("Kd 0.2 0.2 0.8; Ni 1.5; d 0.9", BLUE, &[opacity]),
        ("Kd 0.2 0.2 0.8; d 0.1", BLUE, &[opacity]),
        // As Maya writes what is opaque.
        ("Kd 0.2 0.2 0.8; Ni 1.0; Tf 1 1 1; illum 4", BLUE, &[]),
        ("Kd 0.2 0.2 0.8; Ni 1.0; Tf 0.5 1 1; illum 4", BLUE, &["the tint of transmitted light (`Tf`)"]),
        ("Kd 0 0 0; Ni 1.5; d 0.1; illum 4", GLASS, &[]),
        ("Kd 0.2 0.2 0.8; Ni 1.5; Tr 0.9; illum 4", GLASS, &[tint]),
        ("Kd 1 1 1; Ni 1.5; Tr 1; illum 9", GLASS, &[]),
        ("Ni 1.5; d 0.2", GLASS, &[]),
        ("Ni 1.5; illum 7", GLASS, &[]),
        ("illum 6", GLASS, &["glass without an index of refraction, which is taken for 1.5"]),
        ("Ni 1.5; illum 6; Tf 1 0 0", GLASS, &["the tint of transmitted light (`Tf`)"]),
        ("d 7", Scatter::Diffuse([0.8; 3]), &[]),
    ] {
        assert_eq!(made(statements), (scatter, lost.to_vec()), "{statements}");
    }
}

#[test]
fn colors_and_mirrors() {
    let highlights = "highlights (`Ks`, `Ns`), since the model of Phong and Blinn keeps no energy";
    for (statements, scatter, lost) in [
        ("", Scatter::Diffuse([0.8; 3]), &[][..]),
        ("Kd 0.5", Scatter::Diffuse([0.5; 3]), &[]),
        ("kd 0.2 0.2 0.8", BLUE, &[]),
        ("Kd 0 0 0; Ks 0.9 0.9 0.9; illum 3", Scatter::Mirror([0.9; 3]), &[]),
        ("Kd 0.2 0.2 0.8; Ks 0.9 0.9 0.9; illum 3", BLUE, &[highlights]),
        ("Kd 0.2 0.2 0.8; Ks 0.9 0.9 0.9; illum 1", BLUE, &[]),
        ("Kd 0.2 0.2 0.8; map_Kd oak.png", BLUE, &[]),
        (
            "Kd 0 0 0; map_Kd oak.png",
            Scatter::Diffuse([0.0; 3]),
            &["anything of its texture (`map_Kd`), which is black times `Kd 0 0 0`"],
        ),
        ("Kd 1 1 1; map_Kd oak.png", Scatter::Diffuse([1.0; 3]), &[]),
        ("Kd 0.2 0.2 0.8; illum 10", BLUE, &["an illumination model (`illum`) other than 0 to 9"]),
        ("Kd 0.2 0.2 0.8; d -halo 1", BLUE, &["opacity that depends on the angle (`d -halo`)"]),
        ("Kd 0.2 0.2 0.8; decal a.png", BLUE, &["decals"]),
    ] {
        assert_eq!(made(statements), (scatter, lost.to_vec()), "{statements}");
    }
}

/// Wavefront's MTL: the color is `Kd` times what the map holds; without `Kd` it is the map.
#[test]
fn a_map_is_multiplied_by_its_color() {
    for (statements, factor) in [
        ("Kd 0.2 0.2 0.8\nmap_Kd oak.png", [0.2, 0.2, 0.8]),
        ("map_Kd oak.png\nKd 0.5", [0.5; 3]),
        ("map_Kd oak.png", [1.0; 3]),
    ] {
        let (materials, notes) = library(&format!("newmtl a\n{statements}\n"));
        assert_eq!((materials.surfaces[0].factor, notes), (factor, Vec::new()), "{statements}");
    }
}

#[test]
fn one_bad_word_loses_one_value() {
    let take = "which takes one or three numbers of 0 or more";
    for (line, expected, kd) in [
        ("Kd 0.4 0.1 0.1 # brown", String::new(), [0.4, 0.1, 0.1]),
        ("Kd 0.4 0.1 0.1 1.0", "1 value of `Kd` cut off behind the third number".to_owned(), [0.4, 0.1, 0.1]),
        ("Kd 0.4 x 0.1", format!("1 value of `Kd` not read, {take}"), [0.8; 3]),
        ("Kd 0.4 0.1", format!("1 value of `Kd` not read, {take}"), [0.8; 3]),
        ("Kd 1e39 0 0", format!("1 value of `Kd` not read, {take}"), [0.8; 3]),
        ("Kd -1 0 0", format!("1 value of `Kd` not read, {take}"), [0.8; 3]),
        ("Kd", format!("1 value of `Kd` not read, {take}"), [0.8; 3]),
        (
            "Kd spectral brown.rfl",
            "1 value of `Kd` not read, since they are curves of spectra (`spectral`)".to_owned(),
            [0.8; 3],
        ),
        ("Kd xyz 1 1 1", "1 value of `Kd` not read, since they are in CIE XYZ (`xyz`)".to_owned(), [0.8; 3]),
        ("Kd 2 0.5 0", "1 value of `Kd` held to 1, the most that a surface reflects".to_owned(), [1.0, 0.5, 0.0]),
        ("d nan", "1 value of `d` not read, which takes a number of 0 or more".to_owned(), [0.8; 3]),
        ("illum 2 # phong", String::new(), [0.8; 3]),
        ("illum 2 3", "1 value of `illum` cut off behind the first number".to_owned(), [0.8; 3]),
        ("sparkle 2", "1 statement `sparkle` not read, which is not known".to_owned(), [0.8; 3]),
        ("map_Kd", "1 texture without a file left out".to_owned(), [0.8; 3]),
    ] {
        let (materials, notes) = library(&format!("newmtl a\n{line}\n"));
        let said: Vec<String> = Some(expected).filter(|text| !text.is_empty()).into_iter().collect();
        let said: Vec<String> = said.into_iter().map(|text| format!("`a.mtl`, line 2: {text}")).collect();
        assert_eq!(notes, said, "{line}");
        assert_eq!(materials.surfaces[0].scatter, Scatter::Diffuse(kd), "{line}");
    }
}

#[test]
fn names_have_blanks_comments_and_number_signs() {
    let (materials, _) =
        library("\u{feff}newmtl red paint  # first\nKd 1 0 0\nNEWMTL Material #25\nKd 0 1 0\nnewmtl b\rKd 1");
    let found = |name: &str| materials.find(name.as_bytes());
    assert_eq!([found("red paint"), found("red paint # again"), found("Material #25")], [Some(0), Some(0), Some(1)]);
    assert_eq!([found("red"), found("Material"), found("Material #26")], [None, Some(1), None]);
    assert_eq!([0, 1].map(|at| materials.surfaces[at].name.as_str()), ["red paint", "Material #25"]);
    let (materials, notes) = library("newmtl a\rKd 1 0 0\rnewmtl a\rKd 0 1 0\r");
    assert_eq!((materials.surfaces.len(), notes.len()), (1, 1), "{notes:?}");
    let (materials, notes) = library("Kd 1 0 0\nnewmtl\nKd 1 \\\n0 0\n");
    assert_eq!((materials.surfaces[0].scatter.clone(), notes.len()), (Scatter::Diffuse([1.0, 0.0, 0.0]), 0));
    let mut notes = Vec::new();
    Materials::default().read(b"\xff\xfen\0", "b.mtl", &mut notes);
    assert_eq!((notes[0].message.as_str(), notes[0].place.as_str()), ("the file is text in UTF-16", "`b.mtl`, byte 0"));
}

proptest! {
    #[test]
    fn noise_does_no_harm(bytes in any::<Vec<u8>>(), words in prop::collection::vec(prop::sample::select(vec![
        "newmtl", "a", "Kd", "0.5", "-s", "-o", "-clamp", "on", "map_Kd", "d", "Tr", "illum", "7", "\n", "\n", "#", "\"", "\\", "nan", "-1", "é.png",
    ]), 0..60)) {
        for bytes in [&bytes, &format!("newmtl x\n{}", words.join(" ")).into_bytes()] {
            let (mut materials, mut notes) = (Materials::default(), Vec::new());
            materials.read(bytes, "a.mtl", &mut notes);
            prop_assert_eq!(materials.surfaces.len(), materials.placings.len());
        }
    }
}
