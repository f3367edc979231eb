//! Materials, colors and textures.

use super::*;
use crate::formats::shared::coat::Coat;
use crate::import::metals;
use crate::ir::{Color, ColorOrTexture, Encoding};

/// The same in a file that pbrt-v4, or pbrt-v2, is for.
fn in_version(mark: &str, text: &str) -> Read {
    read(&format!("{mark} {HEAD}{text}{TRIANGLE}WorldEnd\n"))
}

const V4: &str = "Option \"integer seed\" 1";
const OLD: &str = "SurfaceIntegrator \"path\"";

fn diffuse(color: Color) -> Bsdf {
    Bsdf::Diffuse { reflectance: color.into() }
}

#[test]
fn diffuse_materials() {
    assert_eq!(world("").bsdf(), &diffuse(Color::Grey(0.5)));
    assert_eq!(world("Material \"matte\" \"rgb Kd\" [.1 .2 .3]").bsdf(), &diffuse(Color::Rgb([0.1, 0.2, 0.3])));
    assert_eq!(world("Material \"matte\" \"color Kd\" [.2 .2 .2]").bsdf(), &diffuse(Color::Grey(0.2)));
    assert_eq!(
        in_version(V4, "Material \"diffuse\" \"rgb reflectance\" [1 0 0]").bsdf(),
        &diffuse(Color::Rgb([1.0, 0.0, 0.0]))
    );
    let read = world("Material \"matte\" \"float sigma\" 20");
    assert!(read.says(3, "loss-approximated", "ideally diffuse"));
    let read = world("Material \"matte\" \"rgb Kd\" [2 .5 .5]");
    assert!(read.says(3, "loss-approximated", "beyond 0 to 1"));
    assert_eq!(read.bsdf(), &diffuse(Color::Rgb([1.0, 0.5, 0.5])));
}

#[test]
fn materials_without_a_counterpart_are_grey() {
    for kind in ["hair", "fourier", "subsurface", "measured", "felt", "nonsense"] {
        let read = world(&format!("Material \"{kind}\" \"float whatever\" 1"));
        assert!(read.says(3, "loss-dropped", "a grey diffuse surface stands in"), "{kind}");
        assert_eq!(read.bsdf(), &diffuse(Color::Grey(0.5)));
    }
    for kind in ["", "none", "interface"] {
        let read = world(&format!("Material \"{kind}\""));
        assert_eq!((read.said(), read.scene().shapes.len()), (vec![], 0));
    }
    let read = world("Material \"none\" AreaLightSource \"diffuse\"");
    assert_eq!(read.bsdf(), &diffuse(Color::BLACK));
}

#[test]
fn roughness_is_the_width_of_ggx_by_the_version() {
    let alpha = |read: Read| {
        let Bsdf::Conductor { eta: _, k: _, alpha } = read.bsdf() else { panic!("{:?}", read.bsdf()) };
        *alpha
    };
    // 1.62142 - 0.819955 * 2.302585 + 0.1734 * 5.301898 - 0.0171201 * 12.208072 + 0.000640711 * 28.110124
    assert!((alpha(world("Integrator \"path\" Material \"metal\" \"float roughness\" .1")) - 0.461_761).abs() < 1e-5);
    assert_eq!(alpha(world("Material \"metal\" \"float roughness\" .1 \"bool remaproughness\" \"false\"")), 0.1);
    assert_eq!(alpha(in_version(V4, "Material \"conductor\" \"float roughness\" .25")), 0.5);
    assert_eq!(alpha(in_version(V4, "Material \"conductor\"")), 0.0);
    // Blinn's exponent is 10: sqrt(2 / 12).
    assert!(
        (alpha(in_version(OLD, "Material \"metal\" \"float roughness\" .1")) - (1.0_f64 / 6.0).sqrt()).abs() < 1e-12
    );
    let read =
        world("Material \"metal\" \"float uroughness\" .1 \"float vroughness\" .4 \"bool remaproughness\" false");
    assert!(read.says(3, "loss-approximated", "anisotropic"));
    assert!((alpha(read) - 0.2).abs() < 1e-12);
    let text = "Texture \"r\" \"float\" \"constant\" \"float value\" .3 Material \"metal\" \"texture roughness\" \"r\" \"bool remaproughness\" false";
    assert_eq!(alpha(world(text)), 0.3);
}

#[test]
fn metals_by_name_and_number() {
    let gold = metals::metal("Au").expect("gold");
    let copper = metals::metal("Cu").expect("copper");
    let of = |(eta, k): ([f64; 3], [f64; 3])| (Color::Rgb(eta), Color::Rgb(k));
    let found = |read: &Read| {
        let Bsdf::Conductor { eta, k, alpha: _ } = read.bsdf() else { panic!("{:?}", read.bsdf()) };
        (eta.clone(), k.clone())
    };
    assert_eq!(
        found(&in_version(
            V4,
            "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\""
        )),
        of(gold)
    );
    assert_eq!(
        found(&world("Material \"metal\" \"spectrum eta\" \"spds/Au.eta.spd\" \"spectrum k\" [\"spds/Au.k.spd\"]")),
        of(gold)
    );
    assert_eq!(found(&world("Material \"metal\"")), of(copper));
    let read = in_version(V4, "Material \"conductor\" \"spectrum eta\" \"metal-CuZn-eta\"");
    assert!(read.says(3, "loss-dropped", "the metal `CuZn` is not known"), "{:?}", read.said());
    // Half of the light head-on: k = 2 sqrt(1/2 / 1/2) with an index of 1.
    let read = in_version(V4, "Material \"conductor\" \"rgb reflectance\" [.5 .5 .5]");
    assert_eq!(found(&read), (Color::Grey(1.0), Color::Rgb([2.0; 3])));
}

#[test]
fn glass_of_all_versions() {
    let glass = |interior: f64, alpha: f64| Bsdf::Dielectric { interior, exterior: 1.0, alpha };
    assert_eq!(world("Material \"glass\" \"float index\" 1.3").bsdf(), &glass(1.3, 0.0));
    assert_eq!(in_version(V4, "Material \"dielectric\"").bsdf(), &glass(1.5, 0.0));
    let read = in_version(V4, "Material \"dielectric\" \"spectrum eta\" \"glass-BK7\"");
    assert_eq!(read.bsdf(), &glass(1.5168, 0.0));
    assert!(read.says(3, "loss-approximated", "yellow light"));
    let read = world("Material \"glass\" \"rgb Kt\" [1 .5 .5]");
    assert!(read.says(3, "loss-dropped", "`Kt` of `glass` is left out"));
    let read = in_version(V4, "Material \"thindielectric\"");
    assert!(read.says(3, "loss-approximated", "thin dielectric") && read.scene().shapes.is_empty());
}

#[test]
fn mirrors() {
    assert_eq!(world("Material \"mirror\"").bsdf(), &Bsdf::Mirror { reflectance: Color::Grey(0.9) });
    let read = world("Material \"mirror\" \"rgb Kr\" [1 0 0]");
    assert_eq!(read.bsdf(), &Bsdf::Mirror { reflectance: Color::Rgb([1.0, 0.0, 0.0]) });
}

#[test]
fn coats_over_a_base() {
    let plastic = |read: &Read| {
        let Bsdf::Plastic { reflectance, ior, alpha } = read.bsdf() else { panic!("{:?}", read.bsdf()) };
        (reflectance.color().expect("a color").rgb(), *ior, *alpha)
    };
    // Ks 1: as much as glass of 1.5 head-on, 0.04.
    let read = world(
        "Material \"plastic\" \"rgb Kd\" [.3 .3 .3] \"rgb Ks\" [1 1 1] \"float roughness\" .2 \"bool remaproughness\" \"false\"",
    );
    assert!(read.says(3, "loss-approximated", "under a clear coat"));
    let (base, ior, alpha) = plastic(&read);
    assert!((ior - 1.5).abs() < 1e-12 && alpha == 0.2);
    assert!((Coat::new(ior).seen(base[0]) - 0.3).abs() < 1e-12);
    // Ks 0.25: 0.01 head-on, an index of 1.1 / 0.9.
    assert!((plastic(&world("Material \"plastic\"")).1 - 1.1 / 0.9).abs() < 1e-12);
    assert_eq!(world("Material \"plastic\" \"rgb Ks\" [0 0 0]").bsdf(), &diffuse(Color::Grey(0.25)));
    // A substrate says what it reflects head-on itself.
    assert!((plastic(&world("Material \"substrate\" \"rgb Ks\" [.04 .04 .04]")).1 - 1.5).abs() < 1e-12);
    let read = world(
        "Material \"uber\" \"rgb Ks\" [1 1 1] \"float index\" 1.4 \"rgb Kr\" [.1 .1 .1] \"rgb opacity\" [.5 .5 .5]",
    );
    assert!((plastic(&read).1 - 1.4).abs() < 1e-12);
    assert!(read.says(3, "loss-dropped", "`opacity`") && read.says(3, "loss-dropped", "`Kr` of `uber`"));
    assert_eq!(world("Material \"uber\" \"rgb opacity\" [0 0 0]").scene().shapes.len(), 0);
    let read = in_version(
        V4,
        "Material \"coateddiffuse\" \"rgb reflectance\" [.5 .5 .5] \"float thickness\" 0 \"float eta\" 1.6",
    );
    assert_eq!((read.said(), plastic(&read)), (vec![], ([0.5; 3], 1.6, 0.0)));
    assert!(in_version(V4, "Material \"coateddiffuse\"").says(3, "loss-approximated", "absorbs nothing"));
}

#[test]
fn other_materials_say_what_they_lose() {
    assert!(in_version(V4, "Material \"coatedconductor\"").says(3, "loss-dropped", "the coat of a metal"));
    let read = world("Material \"translucent\" \"rgb Kd\" [.8 .8 .8] \"rgb reflect\" [.5 .5 .5]");
    assert!(read.says(3, "loss-dropped", "lets no light through"));
    assert_eq!(read.bsdf(), &diffuse(Color::Grey(0.4)));
    let read = world("Material \"disney\" \"rgb color\" [.1 .2 .3] \"float metallic\" .25 \"float sheen\" 1");
    assert!(read.says(3, "loss-dropped", "`sheen` of `disney`"));
    let base = ColorOrTexture::Color(Color::Rgb([0.1, 0.2, 0.3]));
    assert_eq!(read.bsdf(), &Bsdf::Principled { base, metallic: 0.25, roughness: 0.5, ior: 1.5 });
    let read = world("Material \"matte\" \"texture bumpmap\" \"b\"");
    assert!(read.says(3, "loss-dropped", "the surface is smooth"));
}

#[test]
fn mixtures() {
    let two = "MakeNamedMaterial \"a\" \"string type\" \"matte\" \"rgb Kd\" [1 1 1] MakeNamedMaterial \"b\" \"string type\" [\"matte\"] \"rgb Kd\" [0 0 0]";
    // v3's amount is the share of the first one, v4's of the second one.
    let read = world(&format!(
        "{two} Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.75 .75 .75]"
    ));
    assert_eq!((read.said(), read.bsdf()), (vec![], &diffuse(Color::Grey(0.75))));
    let read =
        in_version(V4, &format!("{two} Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .75"));
    assert_eq!(read.bsdf(), &diffuse(Color::Grey(0.25)));
    let other = two.replacen("\"matte\"", "\"mirror\"", 1).replacen("Kd", "Kr", 1);
    let read = world(&format!(
        "{other} Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [.75 .75 .75]"
    ));
    assert!(read.says(3, "loss-dropped", "the larger share") && read.bsdf().word() == "mirror");
    assert_eq!(world(&format!("{two} NamedMaterial \"a\"")).material().name, "a");
}

#[test]
fn colors_of_all_kinds() {
    let color = |text: &str| {
        let read = world(&format!("Material \"matte\" {text}"));
        let Bsdf::Diffuse { reflectance } = read.bsdf() else { panic!("{:?}", read.bsdf()) };
        reflectance.color().expect("a color").rgb()
    };
    // White of D65.
    assert!(color("\"xyz Kd\" [.475235 .5 .544415]").iter().all(|channel| (channel - 0.5).abs() < 1e-3));
    assert!(close(&color("\"spectrum Kd\" [300 .5 800 .5]"), &[0.5; 3]));
    let read = world("Material \"matte\" \"spectrum Kd\" [300 .5 200 .5]");
    assert!(read.says(3, "loss-dropped", "growing wavelengths"));
    let files: [(&str, &[u8]); 1] = [("a/k.spd", b"# a file\n400 0.25\n700 0.25\n")];
    let read = read_with(&format!("{HEAD}Material \"matte\" \"spectrum Kd\" \"k.spd\"{TRIANGLE}"), &files);
    let Bsdf::Diffuse { reflectance } = read.bsdf() else { panic!("not diffuse") };
    assert!(close(&reflectance.color().expect("a color").rgb(), &[0.25; 3]), "{:?}", read.said());
    assert!(world("Material \"matte\" \"spectrum Kd\" \"none.spd\"").says(3, "loss-dropped", "cannot be read"));
}

fn textured(text: &str, mark: &str) -> Read {
    let image = image();
    let uv = "Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"float uv\" [0 0 1 0 0 .25] \"integer indices\" [0 1 2]";
    read_with(&format!("{mark} {HEAD}{text}\nMaterial \"matte\" \"texture Kd\" \"t\" {uv}"), &[("a/i.png", &image)])
}

fn uvs(read: &Read) -> Vec<[f32; 2]> {
    read.scene().meshes[read.shape(0).mesh].uvs.as_deref().cloned().unwrap_or_default()
}

#[test]
fn images_are_laid_by_their_coordinates() {
    let read = textured("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\"", "");
    assert_eq!(read.said(), []);
    let texture = read.scene().textures.values().next().expect("a texture");
    assert_eq!((texture.encoding, texture.factor), (Encoding::Srgb, [1.0; 3]));
    // v grows upwards, as in the Scene.
    assert_eq!(uvs(&read), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.25]]);
    // v1 and v2 have it downwards.
    let read = textured("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"i.png\"", OLD);
    assert_eq!(uvs(&read), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.75]]);
    let read = textured(
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\" \"float uscale\" 2 \"float vdelta\" .5 \"bool gamma\" \"false\"",
        "",
    );
    assert_eq!(uvs(&read), [[0.0, 0.5], [2.0, 0.5], [0.0, 0.75]]);
    assert_eq!(read.scene().textures.values().next().map(|texture| texture.encoding), Some(Encoding::Linear));
    let scaled = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\"\nTexture \"t\" \"spectrum\" \"scale\" \"texture tex1\" \"i\" \"rgb tex2\" [.5 .25 1]";
    let read = textured(scaled, "");
    assert_eq!(read.scene().textures.values().next().map(|texture| texture.factor), Some([0.5, 0.25, 1.0]));
    let read = textured(
        &scaled.replace("\"texture tex1\" \"i\" \"rgb tex2\" [.5 .25 1]", "\"texture tex\" \"i\" \"float scale\" .5"),
        V4,
    );
    assert_eq!(read.scene().textures.values().next().map(|texture| texture.factor), Some([0.5; 3]));
    let read = textured("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"", "");
    assert!(
        read.says(4, "loss-dropped", "cannot be read") || read.says(3, "loss-dropped", "cannot be read"),
        "{:?}",
        read.said()
    );
    for (more, words) in
        [("\"string wrap\" \"black\"", "images repeat"), ("\"string mapping\" \"planar\"", "is read as `uv`")]
    {
        let read =
            textured(&format!("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\" {more}"), "");
        assert!(read.says(3, "loss-dropped", words), "{:?}", read.said());
    }
}

#[test]
fn a_checkerboard_has_its_first_color_at_the_origin() {
    let read = textured("Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 0 1]", "");
    assert!(read.says(3, "loss-approximated", "a checkerboard becomes an image"), "{:?}", read.said());
    // A square for each step, two for each image.
    assert_eq!(uvs(&read), [[0.0, 0.0], [0.5, 0.0], [0.0, 0.125]]);
    let texture = read.scene().textures.values().next().expect("a texture");
    let pixels = crate::image::linear(texture).expect("pixels");
    let (right, bottom) = (pixels.width - 1, pixels.height - 1);
    assert_eq!((pixels.at(0, bottom), pixels.at(right, 0)), ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    assert_eq!((pixels.at(0, 0), pixels.at(right, bottom)), ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]));
}

#[test]
fn textures_of_constants_are_colors() {
    let color = |text: &str| {
        let read = textured(text, "");
        let Bsdf::Diffuse { reflectance } = read.bsdf() else { panic!("{:?}", read.bsdf()) };
        reflectance.color().expect("a color").rgb()
    };
    assert!(close(&color("Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]"), &[0.1, 0.2, 0.3]));
    assert!(close(
        &color("Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] \"rgb tex2\" [1 .5 0] \"float amount\" .25"),
        &[0.25, 0.125, 0.0]
    ));
    assert!(close(
        &color("Texture \"t\" \"spectrum\" \"scale\" \"rgb tex1\" [.5 .5 1] \"rgb tex2\" [.5 1 1]"),
        &[0.25, 0.5, 1.0]
    ));
    let read = textured("Texture \"t\" \"spectrum\" \"marble\" \"float scale\" 3", "");
    assert!(read.says(3, "loss-dropped", "the texture `marble` is not read"));
}

#[test]
fn triangles_without_coordinates_have_those_of_pbrt() {
    let image = image();
    let text = format!(
        "{HEAD}Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"i.png\" Material \"matte\" \"texture Kd\" \"t\"{TRIANGLE}"
    );
    let read = read_with(&text, &[("a/i.png", &image)]);
    assert_eq!(uvs(&read), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn a_texture_of_a_number_is_its_mean() {
    let image = image();
    let text = format!(
        "{HEAD}Texture \"r\" \"float\" \"imagemap\" \"string filename\" \"i.png\"\nMaterial \"glass\" \"texture roughness\" \
         \"r\" \"bool remaproughness\" false{TRIANGLE}"
    );
    let read = read_with(&text, &[("a/i.png", &image)]);
    // Each channel is 1 in two of the four pixels.
    assert!(read.says(4, "loss-approximated", "as its mean"), "{:?}", read.said());
    assert_eq!(read.bsdf(), &Bsdf::Dielectric { interior: 1.5, exterior: 1.0, alpha: 0.5 });
}

#[test]
fn the_amount_of_a_mixture_may_be_a_texture() {
    let text = "Texture \"t\" \"color\" \"constant\" \"rgb value\" [.25 .25 .25] MakeNamedMaterial \"a\" \"string type\" \
                \"matte\" \"rgb Kd\" [1 1 1] MakeNamedMaterial \"b\" \"string type\" \"matte\" \"rgb Kd\" [0 0 0] Material \
                \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"texture amount\" \"t\"";
    assert_eq!(world(text).bsdf(), &diffuse(Color::Grey(0.25)));
}
