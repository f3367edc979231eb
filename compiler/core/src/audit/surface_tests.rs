//! Surfaces, materials and meshes: each comparison has a change that it alone sees.

use super::comparison_tests::{MORE, Row, each, found};
use super::look::{self, Back, Materials};
use super::tests::{audited, said, written};
use super::*;
use crate::formats::shared::reading::{Emitted, Fresnel, Inside, Item, Model, Paint, Surface, Use};
use crate::formats::{self, shared::sample};
use crate::ir::{Color, ColorOrTexture, Encoding, ImageFormat, LightKind, LightSource};
use crate::mesh::sphere;
use crate::valid::validate;

/// Targets whose meshes lie in files, each item a shape of the scene.
const FILES: [&str; 4] = ["mitsuba-3", "pbrt-v4", "luxcore", "cycles"];

fn shape(reading: &mut Reading, at: usize) -> &mut Use {
    match &mut reading.items[at] {
        Item::Shape(one) => one,
        Item::Instance { .. } => panic!("an instance"),
    }
}

/// The lamp's place among the shapes of a room.
const LAMP: usize = 7;

fn emission(reading: &mut Reading) -> &mut Emitted {
    shape(reading, LAMP).emission.as_mut().expect("a lamp")
}

#[test]
fn surfaces_and_what_they_emit() {
    let rows: &[Row] = &[
        (|read| drop(read.items.pop()), "there are 7 surfaces instead of 8"),
        (|read| emission(read).both_sides = true, "emitter `lamp` emits on both sides"),
        (|read| emission(read).reversed = true, "emitter `lamp` faces"),
        (|read| emission(read).radiance[0] *= MORE, "emitter `lamp` emits"),
        (|read| emission(read).radiance[1] /= MORE, "emitter `lamp` emits"),
        (|read| emission(read).radiance[2] *= MORE, "emitter `lamp` emits"),
        (|read| emission(read).radiance[2] = f64::NAN, "emitter `lamp` emits"),
        (|read| shape(read, 0).material = usize::MAX, "`floor` has no material instead of `white`"),
        (|read| shape(read, 0).material = shape(read, 3).material, "material `white`"),
        (|read| shape(read, 0).mesh = shape(read, 1).mesh, "shape `floor` has"),
        (|read| shape(read, 0).transform.rows[0][3] += 1e-5, "shape `floor` has"),
        (|read| shape(read, 2).transform.rows[1][3] -= 1e-5, "shape `back` has"),
        (|read| shape(read, 6).transform.rows[2][3] += 1e-5, "shape `tall` has"),
        (|read| shape(read, 6).transform.rows[1][0] = 1e-5, "shape `tall` has"),
        (|read| shape(read, LAMP).transform.rows[2][3] += 1e-5, "emitter `lamp` has"),
    ];
    // The lamp is the last one, and its loss is the loss of an emitter, too.
    for target in FILES {
        let scene = validate(sample::room()).expect("a valid scene");
        assert_eq!(found(&scene, target, |_| ()), Vec::<String>::new(), "{target}");
        for (change, words) in rows {
            let all = found(&scene, target, change);
            assert!(all[0].contains(words), "{target}: `{words}` of {all:#?}");
            let emitters = usize::from(words.contains("7 surfaces"));
            assert_eq!(all.len(), 1 + emitters, "{target}: `{words}` of {all:#?}");
        }
        for (change, words) in [
            (
                (|read| read.items.push(read.items[0].clone())) as fn(&mut Reading),
                &["there are 9 surfaces instead of 8"][..],
            ),
            (
                |read| {
                    let emitted = *emission(read);
                    shape(read, 0).emission = Some(emitted);
                },
                &["shape `floor` emits light", "there are 2 emitting surfaces instead of 1"],
            ),
            (
                |read| shape(read, LAMP).emission = None,
                &["emitter `lamp` emits no light", "there are 0 emitting surfaces instead of 1"],
            ),
        ] {
            let all = found(&scene, target, change);
            assert!(all.iter().map(String::as_str).eq(words.iter().copied()), "{target}: {all:#?}");
        }
    }
}

#[test]
fn faces_that_are_drawn_flat_or_smooth_against_the_mesh() {
    let mut scene = sample::room();
    let bare = scene.meshes.iter().next().expect("a mesh").0;
    scene.meshes[bare].normals = None;
    each(
        scene,
        "mitsuba-3",
        &[
            (|read| read.meshes[0].flat = Some(false), "shape `floor` is drawn smooth"),
            (|read| read.meshes[1].flat = Some(true), "shape `ceiling` is drawn flat"),
        ],
    );
}

#[test]
fn materials_that_no_surface_has() {
    let other = |read: &mut Reading| {
        let model = Model::Diffuse { reflectance: Paint::Color([0.11, 0.12, 0.13]) };
        read.materials.push(Surface { name: "spare".to_owned(), model, two_sided: true });
    };
    let known = |read: &mut Reading| {
        let one = read.materials[0].clone();
        read.materials.push(one);
    };
    let scene = validate(sample::room()).expect("a valid scene");
    for target in FILES {
        assert_eq!(found(&scene, target, known), Vec::<String>::new(), "{target}");
        let all = found(&scene, target, other);
        assert_eq!(all, ["material `spare`, which no surface has, is none of the scene's"], "{target}");
    }
}

fn place(reading: &mut Reading, at: usize) -> &mut Affine {
    let instances = reading.items.iter_mut().filter_map(|item| match item {
        Item::Instance { name: _, group: _, transform } => Some(transform),
        Item::Shape(_) => None,
    });
    instances.into_iter().nth(at).expect("an instance")
}

#[test]
fn groups_and_their_places() {
    let scene = validate(sample::grid()).expect("a valid scene");
    for target in ["mitsuba-3", "pbrt-v4", "cycles"] {
        assert_eq!(found(&scene, target, |_| ()), Vec::<String>::new(), "{target}");
        for row in 0..3 {
            for column in 0..4 {
                let all = found(&scene, target, |read| place(read, 1).rows[row][column] += 1e-6);
                let both =
                    all.len() == 2 && all[0].contains("shape `left` has") && all[1].contains("shape `right` has");
                assert!(both, "{target}: {row} {column}: {all:#?}");
                let all = found(&scene, target, |read| read.groups[0][1].transform.rows[row][column] += 1e-6);
                assert!(
                    !all.is_empty() && all.iter().all(|line| line.contains("shape `right` has")),
                    "{target}: {all:#?}"
                );
            }
        }
        let count = |change: fn(&mut Reading)| found(&scene, target, change);
        let all = count(|read| read.groups[0].truncate(1));
        assert!(all.iter().any(|line| line == "there are 4 surfaces instead of 7"), "{target}: {all:#?}");
        let last = |read: &mut Reading| {
            let at = read.items.iter().rposition(|item| matches!(item, Item::Instance { .. })).expect("an instance");
            read.items.truncate(at);
        };
        let all = count(last);
        assert!(all.iter().any(|line| line == "there are 5 surfaces instead of 7"), "{target}: {all:#?}");
        let all = count(|read| {
            let emitted = Emitted { radiance: [1.0; 3], both_sides: false, reversed: false };
            read.groups[0][0].emission = Some(emitted);
        });
        assert!(all.iter().any(|line| line == "there are 4 emitting surfaces instead of 1"), "{target}: {all:#?}");
        let all = count(|read| read.groups[0][0].material = usize::MAX);
        assert_eq!(all, ["`left` has no material instead of `white`"], "{target}");
    }
}

/// Pairs of what a scene asks for and a file says, and changes of the latter with what they are called.
#[test]
fn every_number_of_every_material() {
    type Change = (fn(&mut Model), &'static str);
    let color = || Color::Rgb([0.6, 0.4, 0.2]);
    let paint = || Paint::Color([0.6, 0.4, 0.2]);
    let (eta, k) = ([0.2, 0.924, 1.102], [3.913, 2.453, 2.142]);
    let pairs: Vec<(Bsdf, Model, Vec<Change>)> = vec![
        (
            Bsdf::Diffuse { reflectance: color().into() },
            Model::Diffuse { reflectance: paint() },
            vec![
                (|model| *number(model, 0) *= MORE, "reflects"),
                (|model| *number(model, 1) /= MORE, "reflects"),
                (|model| *number(model, 2) *= MORE, "reflects"),
                (|model| *model = Model::Dielectric { eta: 1.5, alpha: 0.0 }, "lets light through"),
                (
                    |model| {
                        let tint = Paint::Color([0.6, 0.4, 0.2]);
                        *model = Model::Conductor { fresnel: Fresnel::Constant, tint, alpha: 0.3 };
                    },
                    "has the width `alpha` 0.3 instead of none (a diffuse surface)",
                ),
            ],
        ),
        (
            Bsdf::Conductor { eta: Color::Rgb(eta), k: Color::Rgb(k), alpha: 0.2 },
            Model::Conductor { fresnel: Fresnel::Exact { eta, k }, tint: Paint::WHITE, alpha: 0.2 },
            vec![
                (|model| *number(model, 0) *= MORE, "reflects"),
                (|model| *number(model, 1) *= MORE, "reflects"),
                (|model| *number(model, 2) *= MORE, "reflects"),
                (|model| *number(model, 3) *= MORE, "reflects"),
                (|model| *number(model, 5) *= MORE, "reflects"),
                (|model| *number(model, 8) *= MORE, "reflects"),
                (|model| *number(model, 9) *= MORE, "has the width `alpha` 0.2000"),
                (|model| *number(model, 9) /= MORE, "has the width `alpha` 0.1999"),
                (
                    |model| *model = Model::Diffuse { reflectance: Paint::WHITE },
                    "`alpha` none (a diffuse surface) instead of 0.2",
                ),
            ],
        ),
        (
            Bsdf::Dielectric { interior: 1.8, exterior: 1.2, alpha: 0.15 },
            Model::Dielectric { eta: 1.8 / 1.2, alpha: 0.15 },
            vec![
                (|model| *number(model, 0) *= MORE, "has the relative index of refraction 1.50000"),
                (|model| *number(model, 0) = 1.2 / 1.8, "has the relative index of refraction 0.66"),
                (|model| *number(model, 1) *= MORE, "has the width `alpha`"),
                (|model| *model = Model::Diffuse { reflectance: Paint::WHITE }, "lets no light through"),
            ],
        ),
        (
            Bsdf::Mirror { reflectance: color() },
            Model::Conductor { fresnel: Fresnel::Constant, tint: paint(), alpha: 0.0 },
            vec![
                (|model| *number(model, 0) *= MORE, "reflects"),
                (|model| *number(model, 2) *= MORE, "reflects"),
                (|model| *number(model, 3) = 1e-5, "has the width `alpha` 0.00001 instead of 0"),
            ],
        ),
        (
            Bsdf::Plastic { reflectance: color().into(), ior: 1.5, alpha: 0.1 },
            Model::Coated { base: paint(), inside: Inside::Base, ior: 1.5, alpha: 0.1 },
            vec![
                (|model| *number(model, 0) *= MORE, "reflects"),
                (|model| *number(model, 1) *= MORE, "reflects"),
                (|model| *number(model, 2) *= MORE, "reflects"),
                (|model| *number(model, 3) *= MORE, "has a coat of the index of refraction 1.50000"),
                (|model| *number(model, 4) *= MORE, "has the width `alpha`"),
            ],
        ),
        (
            Bsdf::Principled { base: color().into(), metallic: 0.3, roughness: 0.5, ior: 1.5 },
            Model::Principled { base: paint(), metallic: 0.3, alpha: 0.25, specular: 0.04, ceiling: 1.0 },
            vec![
                (|model| *number(model, 0) *= MORE, "reflects"),
                (|model| *number(model, 2) *= MORE, "reflects"),
                (|model| *number(model, 3) *= MORE, "is metal by 0.300000"),
                (|model| *number(model, 3) /= MORE, "is metal by 0.299999"),
                (|model| *number(model, 4) *= MORE, "has the width `alpha`"),
                (|model| *number(model, 5) *= MORE, "reflects"),
                // What the format can say of a coat at most is what is asked for.
                (|model| *number(model, 6) = 0.03, "reflects"),
            ],
        ),
    ];
    for (bsdf, model, changes) in pairs {
        let differs = |model: Model, two_sided, back, excused| {
            let surface = Surface { name: String::new(), model, two_sided };
            let factor = [1.0; 3];
            look::difference(&Materials { bsdf: &bsdf, surface: &surface, back, excused, factor })
        };
        assert_eq!(differs(model.clone(), true, Back::Scatters, false), None, "{bsdf:?}");
        let clear = matches!(model, Model::Dielectric { .. });
        let one = (!clear).then_some("scatters on one side only");
        assert_eq!(differs(model.clone(), false, Back::Scatters, false).as_deref(), one, "{bsdf:?}");
        assert_eq!(differs(model.clone(), false, Back::Either, false), None, "{bsdf:?}");
        let both = Some("scatters on both sides");
        assert_eq!(differs(model.clone(), true, Back::Black, false).as_deref(), both, "{bsdf:?}");
        assert_eq!(differs(model.clone(), false, Back::Black, false), None, "{bsdf:?}");
        for (change, words) in changes {
            let mut other = model.clone();
            change(&mut other);
            let what = differs(other.clone(), true, Back::Scatters, false);
            assert!(what.as_ref().is_some_and(|what| what.contains(words)), "`{words}`, {bsdf:?}, {other:?}: {what:?}");
            // What is excused is the amount, never the kind.
            let amount = ["reflects", "is metal", "relative index"].iter().any(|word| words.contains(word));
            assert_eq!(differs(other, true, Back::Scatters, true).is_none(), amount, "{words}, {bsdf:?}");
        }
    }
}

/// The numbers of a model, one after the other: colors, then the rest.
fn number(model: &mut Model, at: usize) -> &mut f64 {
    fn channels(paint: &mut Paint) -> &mut [f64; 3] {
        match paint {
            Paint::Color(color) => color,
            Paint::Image { .. } => panic!("an image"),
        }
    }
    let mut all: Vec<&mut f64> = match model {
        Model::Diffuse { reflectance } => channels(reflectance).iter_mut().collect(),
        Model::Conductor { fresnel: Fresnel::Exact { eta, k }, tint, alpha } => {
            eta.iter_mut().chain(k).chain(channels(tint)).chain([alpha]).collect()
        }
        Model::Conductor { fresnel: _, tint, alpha } => channels(tint).iter_mut().chain([alpha]).collect(),
        Model::Dielectric { eta, alpha } => vec![eta, alpha],
        Model::Coated { base, inside: _, ior, alpha } => channels(base).iter_mut().chain([ior, alpha]).collect(),
        Model::Principled { base, metallic, alpha, specular, ceiling } => {
            channels(base).iter_mut().chain([metallic, alpha, specular, ceiling]).collect()
        }
        Model::Mix { .. } => panic!("a mix"),
    };
    all.swap_remove(at)
}

#[test]
fn a_reflectance_is_compared_at_each_angle() {
    // Each term is that of 1.5 but for cosines around one of the angles.
    fn odd(from: f64, to: f64, cosine: f64) -> f64 {
        let plain = crate::formats::shared::fresnel::conductor(1.5, 2.0, cosine);
        if (from..to).contains(&cosine) { plain + 1e-6 } else { plain }
    }
    let bsdf = Bsdf::Conductor { eta: Color::Grey(1.5), k: Color::Grey(2.0), alpha: 0.0 };
    for (from, to, degrees) in
        [(2.0, 3.0, None), (0.9, 2.0, Some(0)), (0.8, 0.9, Some(30)), (0.4, 0.6, Some(60)), (0.1, 0.2, Some(80))]
    {
        let fresnel = Fresnel::Fitted { n: [from; 3], k: [to; 3], term: odd, most: |_, _| 0.0 };
        let model = Model::Conductor { fresnel, tint: Paint::WHITE, alpha: 0.0 };
        let surface = Surface { name: String::new(), model, two_sided: true };
        let materials =
            Materials { bsdf: &bsdf, surface: &surface, back: Back::Scatters, excused: false, factor: [1.0; 3] };
        let what = look::difference(&materials);
        match degrees {
            None => assert_eq!(what, None),
            Some(degrees) => {
                let words = format!("at {degrees} degrees");
                assert!(what.as_ref().is_some_and(|what| what.ends_with(&words)), "{words}: {what:?}");
            }
        }
    }
}

/// The place of a painted ball among the shapes.
const BALL: usize = 8;

/// A room with an image on a ball and one of the sky.
fn painted() -> Scene {
    let mut scene = sample::room();
    let tiles = scene.textures.push(sample::image("tiles", ImageFormat::Png, Encoding::Srgb), Origin::Made);
    let sky = scene.textures.push(sample::image("sky", ImageFormat::Exr, Encoding::Linear), Origin::Made);
    let painted = Bsdf::Diffuse { reflectance: ColorOrTexture::Texture(tiles) };
    let mesh = sphere(5.0, [0.0, 0.0, 50.0], 8, 4).expect("a good sphere").into_mesh("ball");
    let mesh = scene.meshes.push(mesh, Origin::Made);
    let material = sample::material(&mut scene, "painted", painted);
    sample::shape(&mut scene, "ball", mesh, material, None);
    let kind = LightKind::environment(ColorOrTexture::Texture(sky));
    scene.lights.push(LightSource { name: "sky".to_owned(), kind }, Origin::Made);
    scene
}

/// One of them has another pixel, or is gone.
#[test]
fn pixels_of_images() {
    let scene = validate(painted()).expect("a valid scene");
    for target in ["mitsuba-3", "mitsuba-0.5", "pbrt-v3", "luxcore", "cycles"] {
        let target = formats::find(target).expect("a target");
        let whole = written(&scene, target);
        for (name, own_name) in [("tiles", "tiles"), ("sky", "environment")] {
            // A target has a form of its own where it cannot read the shared one.
            let own = |path: &&String| path.starts_with(target.name);
            let all = whole
                .keys()
                .filter(|path| path.contains(&format!("/{name}.")) || path.contains(&format!("/{own_name}.")));
            let path = all.max_by_key(own).expect("an image").clone();
            let mut files = whole.clone();
            let bytes = files.get_mut(&path).expect("an image");
            let at = bytes.len() / 2;
            bytes[at] ^= 1;
            let all = said(&audited(&scene, target, &files));
            let words = format!("the image `{name}` has other pixels");
            assert!(all.len() == 1 && all[0].contains(&words), "{}: {path}: {all:#?}", target.name);
            files.remove(&path);
            let all = said(&audited(&scene, target, &files));
            let words = format!("the image `{name}` cannot be read");
            assert!(all.len() == 1 && all[0].contains(&words), "{}: {path}: {all:#?}", target.name);
        }
    }
}

#[test]
fn images_of_materials() {
    let scene = painted();
    fn image(read: &mut Reading) -> &mut Paint {
        let at = shape(read, BALL).material;
        let Model::Diffuse { reflectance } = &mut read.materials[at].model else { panic!("another material") };
        reflectance
    }
    let rows: &[Row] = &[
        (|read| *image(read) = Paint::Color([0.5; 3]), "material `painted` does not show the image `tiles`"),
        (
            |read| {
                if let Paint::Image { file: _, linear, factor: _ } = image(read) {
                    *linear = !*linear;
                }
            },
            "material `painted` decodes the image `tiles` otherwise",
        ),
        (
            |read| {
                if let Paint::Image { file: _, linear: _, factor } = image(read) {
                    factor[1] *= MORE;
                }
            },
            "material `painted` reflects",
        ),
        (
            |read| {
                if let Paint::Image { file, linear: _, factor: _ } = image(read) {
                    *file = VPath::resolve("", "other.png").expect("a path").into();
                }
            },
            "material `painted` shows the image `other.png` instead of `tiles.png`",
        ),
        (
            |read| {
                let shown = image(read).clone();
                let at = shape(read, 3).material;
                let Paint::Image { file, linear, factor: _ } = shown else { panic!("no image") };
                let factor = [2.0 * 0.529, 2.0 * 0.024, 2.0 * 0.024];
                read.materials[at].model = Model::Diffuse { reflectance: Paint::Image { file, linear, factor } };
            },
            "material `red` shows an image",
        ),
    ];
    for target in ["mitsuba-3", "pbrt-v4", "luxcore"] {
        each(scene.clone(), target, rows);
    }
}

#[test]
fn sides_are_compared_wherever_a_format_has_them() {
    let mut scene = sample::room();
    for (_, material) in scene.materials.iter_mut().filter(|(_, one)| !one.bsdf.is_clear()) {
        material.sides = crate::ir::Sides::Front;
    }
    let black = scene.materials.values().filter(|one| one.bsdf.is_black()).count();
    assert!(black > 0 && black < scene.materials.len(), "some are black, which has no sides");
    let scene = validate(crate::lower::lower(scene).0).expect("a valid scene");
    let find = |name: &str| formats::find(name).expect("a target");
    for target in formats::TARGETS.iter().filter(|target| target.import.is_some()) {
        let audit = audited(&scene, target, &written(&scene, target));
        assert_eq!(said(&audit), Vec::<String>::new(), "{}", target.name);
    }
    // What is changed in a file is seen: the shape gets one side alone, the front has two, the back is no longer black.
    let edits = [
        ("luxcore", ".material = \"", "_back\"", "is one side of another material"),
        ("luxcore", "\"twosided\"", "\"matte\"", ""),
        ("luxcore", "_back.kd = 0 0 0", "_back.kd = 0.5 0.5 0.5", "a back that is not black"),
        ("cycles", "one_sided(", "(", ""),
        ("cycles", "one_sided(diffuse(", "one_sided(mirror(", ""),
    ];
    for (name, from, to, words) in edits {
        let target = find(name);
        let mut files = written(&scene, target);
        let mut changed = false;
        for bytes in files.values_mut() {
            let Ok(text) = std::str::from_utf8(bytes) else { continue };
            let Some(at) = text.find(from) else { continue };
            let mut text = text.to_owned();
            if to == "_back\"" {
                let end = at + from.len();
                let close = end + text[end..].find('"').expect("a name");
                if !text.contains(&format!("scene.materials.{}_back.", &text[end..close])) {
                    continue;
                }
                text.replace_range(close..=close, to);
            } else {
                text.replace_range(at..at + from.len(), to);
            }
            *bytes = text.into_bytes();
            changed = true;
            break;
        }
        assert!(changed, "{name}: {from}");
        let found = said(&audited(&scene, target, &files));
        assert!(!found.is_empty() && found.iter().any(|line| line.contains(words)), "{name}, {from}: {found:?}");
    }
}
