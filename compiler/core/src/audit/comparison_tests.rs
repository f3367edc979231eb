//! What was read is changed by one number or word at a time, and one comparison says so: without it, its row fails.

use super::tests::{camera, full, written};
use super::*;
use crate::files::MemoryFiles;
use crate::formats::effective::Effective;
use crate::formats::shared::reading::{Clip, Light, Paint, Picture, View};
use crate::formats::{self, shared::sample};
use crate::ir::{Color, ColorOrTexture, Encoding, Filter, ImageFormat, Integrator, LightKind, LightSource, Sampler};
use crate::valid::{Valid, validate};

/// A change of what was read, and words of the one finding that it makes.
pub(super) type Row = (fn(&mut Reading), &'static str);

/// What is found of the files of a scene when `change` was made to what was read of them.
pub(super) fn found(scene: &Valid, target: &str, change: impl FnOnce(&mut Reading)) -> Vec<String> {
    let target = formats::find(target).expect("a target");
    let mut memory = MemoryFiles::default();
    for (path, bytes) in written(scene, target) {
        memory.insert(path, bytes);
    }
    let main = VPath::resolve(target.name, &target.main_file_of(&scene.name)).expect("a path");
    let mut source = Source::new(&memory);
    let mut reading = target.import.expect("a reader")(&main, &mut source);
    let unread = source.finish();
    assert!(unread.is_empty(), "{}: {unread:?}", target.name);
    change(&mut reading);
    let asked = Asked::new(scene, camera(scene));
    let mut found = Found { target: target.name, main: String::new(), now: String::new(), findings: vec![], more: 0 };
    let mut audit = Audit {
        target: target.name,
        said: Sums::default(),
        emitters: Vec::new(),
        materials: 0,
        angles: 0,
        max_depth: None,
        fov_x: None,
        film: None,
        effective: Effective::default(),
        lost: Vec::new(),
        findings: Vec::new(),
    };
    compare(&asked, target, &reading, &mut Meshes::new(&memory), (&mut audit, &mut found));
    found.finish().into_iter().map(|finding| finding.message).collect()
}

/// Each change is one finding with its words, and without a change there is none.
pub(super) fn each(scene: Scene, target: &str, rows: &[Row]) {
    let scene = validate(scene).expect("a valid scene");
    assert_eq!(found(&scene, target, |_| ()), Vec::<String>::new(), "{target}");
    for (change, words) in rows {
        let all = found(&scene, target, change);
        assert!(all.len() == 1 && all[0].contains(words), "{target}: `{words}` of {all:#?}");
    }
}

fn view(reading: &mut Reading) -> &mut View {
    reading.view.as_mut().expect("a camera")
}

/// A millionth more.
pub(super) const MORE: f64 = 1.000_001;

#[test]
fn image_and_filter() {
    each(
        full(),
        "mitsuba-3",
        &[
            (|read| read.film = Some([95, 64]), "95 x 64 pixels instead of 96 x 64"),
            (|read| read.film = Some([96, 65]), "96 x 65 pixels instead of 96 x 64"),
            (|read| read.film = None, "no size of the image"),
            (|read| read.filter = None, "the filter is none instead of"),
            (|read| read.filter = Some(Filter::Box { radius: 2.0 }), "the filter is Box"),
            (|read| read.filter = Some(Filter::Gaussian { stddev: 0.5 * MORE, radius: 2.0 }), "the filter is Gaussian"),
            (|read| read.filter = Some(Filter::Gaussian { stddev: 0.5 / MORE, radius: 2.0 }), "the filter is Gaussian"),
        ],
    );
    each(
        full(),
        "pbrt-v4",
        &[(|read| read.filter = Some(Filter::Gaussian { stddev: 0.5, radius: 2.0 * MORE }), "the filter is Gaussian")],
    );
    for radius in [0.5, 1.5] {
        let mut scene = sample::room();
        scene.film.filter = Filter::Box { radius };
        each(
            scene,
            "pbrt-v3",
            &[
                (|read| read.filter = Some(Filter::Box { radius: 0.5 * MORE }), "the filter is Box"),
                (|read| read.filter = Some(Filter::Gaussian { stddev: 0.5, radius: 0.5 }), "the filter is Gaussian"),
            ],
        );
    }
}

#[test]
fn depth() {
    let rows: &[Row] = &[
        (|read| read.max_depth = Some(9), "paths have 9 segments instead of 10"),
        (|read| read.max_depth = Some(11), "paths have 11 segments instead of 10"),
        (|read| read.max_depth = Some(2), "paths have 2 segments instead of 10"),
        (|read| read.max_depth = None, "the files give no path depth"),
    ];
    each(sample::room(), "mitsuba-3", rows);
    // One segment is exact for this target, so that two are wrong.
    let one: &[Row] = &[(|read| read.max_depth = Some(2), "paths have 2 segments instead of 1")];
    each(Scene { integrator: Integrator::Path { max_depth: 1 }, ..sample::room() }, "mitsuba-3", one);
    each(
        Scene { integrator: Integrator::Path { max_depth: 2 }, ..sample::room() },
        "luxcore",
        &[
            (|read| read.max_depth = Some(1), "paths have 1 segments instead of 2"),
            (|read| read.max_depth = Some(3), "paths have 3 segments instead of 2"),
        ],
    );
}

#[test]
fn the_camera() {
    each(
        sample::room(),
        "mitsuba-3",
        &[
            (|read| read.view = None, "the files give no camera"),
            (|read| view(read).eye[0] += 1e-5, "the camera stands at"),
            (|read| view(read).eye[1] -= 1e-5, "the camera stands at"),
            (|read| view(read).eye[2] += 1e-5, "the camera stands at"),
            (|read| view(read).eye[2] = f64::NAN, "the camera stands at"),
            (|read| view(read).forward[0] += 1e-6, "the camera looks along"),
            (|read| view(read).forward[2] -= 1e-6, "the camera looks along"),
            (|read| view(read).right[2] += 1e-6, "the image is turned"),
            (|read| view(read).up[0] += 1e-6, "the image is turned"),
            (|read| view(read).right = view(read).right.map(|x| -x), "the image is mirrored"),
            (|read| view(read).up = view(read).up.map(|x| -x), "the image is turned"),
            (
                |read| {
                    let view = view(read);
                    (view.right, view.up) = (view.right.map(|x| -x), view.up.map(|x| -x));
                },
                "the image is turned",
            ),
            (|read| view(read).fov_x *= MORE, "`fov_x` is 45.00004"),
            (|read| view(read).fov_x /= MORE, "`fov_x` is 44.9999"),
            (|read| view(read).fov_y *= MORE, "the vertical angle of view is"),
            (|read| view(read).fov_y /= MORE, "the vertical angle of view is"),
            (|read| view(read).shift[0] = 1e-5, "the image is shifted"),
            (|read| view(read).shift[1] = -1e-5, "the image is shifted"),
        ],
    );
}

#[test]
fn algorithms() {
    let path: &[Row] =
        &[(|read| read.algorithm = Some("metropolis"), "the algorithm is `metropolis` instead of `path`")];
    each(sample::room(), "pbrt-v3", path);
    // A target that lacks an algorithm has path tracing for it, and nothing else.
    let lacks = Scene { integrator: Integrator::Metropolis { max_depth: 10 }, ..sample::room() };
    each(
        lacks.clone(),
        "mitsuba-3",
        &[(|read| read.algorithm = Some("bidirectional"), "the algorithm is `bidirectional` instead of `path`")],
    );
    each(
        lacks.clone(),
        "mitsuba-0.6",
        &[(|read| read.algorithm = Some("path"), "the algorithm is `path` instead of `metropolis`")],
    );
    // What is only noted is the scene's own.
    each(
        lacks,
        "gltf",
        &[
            (|read| read.algorithm = Some("path"), "the algorithm is `path` instead of `metropolis`"),
            (|read| read.noted = Some(Filter::Box { radius: 0.6 }), "the filter is Box"),
        ],
    );
    let photons = Scene { integrator: Integrator::PhotonMap { max_depth: 10 }, ..sample::room() };
    each(
        photons,
        "mitsuba-0.6",
        &[
            (|read| read.photons.0 = read.photons.0.map(|radius| radius * MORE), "photons are gathered within"),
            (|read| read.photons.0 = read.photons.0.map(|radius| radius / MORE), "photons are gathered within"),
            (
                |read| read.photons.1 = read.photons.1.map(|count| count + 1),
                "a pass has 16385 photons instead of 16384",
            ),
            (
                |read| read.photons.1 = read.photons.1.map(|count| count - 1),
                "a pass has 16383 photons instead of 16384",
            ),
        ],
    );
}

fn clip(reading: &mut Reading) -> &mut Clip {
    reading.clip.as_mut().expect("distances")
}

#[test]
fn clipping_distances() {
    let mut scene = sample::room();
    let camera = scene.cameras.iter().next().expect("a camera").0;
    (scene.cameras[camera].near, scene.cameras[camera].far) = (Some(20.0), Some(400.0));
    let rows: &[Row] = &[
        (|read| clip(read).near = Some(20.0 * MORE), "the distance `near` is 20.00002 instead of 20"),
        (|read| clip(read).near = Some(20.0 / MORE), "the distance `near` is 19.9"),
        (|read| clip(read).far = Some(400.0 * MORE), "the distance `far` is 400.000"),
        (|read| clip(read).far = None, "the distance `far` is"),
    ];
    for target in ["mitsuba-3", "luxcore", "cycles", "gltf"] {
        each(scene.clone(), target, rows);
    }
    each(scene.clone(), "gltf", &[(|read| clip(read).near = None, "the distance `near` is none instead of 20")]);
    // Where the scene leaves them open, the writer's own are compared.
    for target in ["mitsuba-3", "luxcore", "cycles"] {
        each(
            sample::room(),
            target,
            &[
                (|read| clip(read).near = Some(7.0), "the distance `near` is 7 instead of"),
                (|read| clip(read).far = Some(7.0), "the distance `far` is 7 instead of"),
            ],
        );
    }
    each(
        sample::room(),
        "gltf",
        &[
            (|read| clip(read).near = clip(read).near.map(|near| near * MORE), "the distance `near` is"),
            (|read| clip(read).far = Some(7.0), "the distance `far` is 7 instead of none"),
        ],
    );
}

#[test]
fn samples() {
    each(
        sample::room(),
        "mitsuba-3",
        &[
            (|read| read.sampling.samples = vec![31], "there are 31 samples instead of 32"),
            (|read| read.sampling.samples.push(33), "there are 33 samples instead of 32"),
            (|read| read.sampling.samples.clear(), "the files give no samples"),
            (|read| read.sampling.seed = Some((1, i64::from)), "the seed is 1 instead of 0"),
            (|read| read.sampling.seed = Some((0, |seed| i64::from(seed) + 7)), "the seed is 0 instead of 7"),
            (|read| read.sampling.sobol = Some(true), "the samples are a Sobol sequence instead of independent"),
        ],
    );
    let sobol = Scene { sampler: Sampler::Sobol { samples: 32, seed: 3 }, ..sample::room() };
    each(
        sobol,
        "pbrt-v4",
        &[(|read| read.sampling.sobol = Some(false), "the samples are independent instead of a Sobol sequence")],
    );
}

/// A number of a light, by the place of the light and its own.
fn light(reading: &mut Reading, at: usize, number: usize) -> &mut f64 {
    match &mut reading.lights[at] {
        Light::Environment { radiance: Paint::Color(color), turn: _ } => &mut color[number],
        Light::Environment { radiance: Paint::Image { file: _, linear: _, factor }, turn: _ } => &mut factor[number],
        Light::Point { position, intensity } => position.iter_mut().chain(intensity).nth(number).expect("a number"),
        Light::Spot { position, direction, intensity, angle, inner } => {
            let all = position.iter_mut().chain(direction).chain(intensity);
            all.chain([angle, inner]).nth(number).expect("a number")
        }
        Light::Directional { direction, irradiance } => {
            direction.iter_mut().chain(irradiance).nth(number).expect("a number")
        }
    }
}

#[test]
fn every_number_of_every_light() {
    let scene = validate(full()).expect("a valid scene");
    let strength =
        |at: usize, first: usize| [0, 1, 2].map(|channel| (at, first + channel, "has the strength")).to_vec();
    let place = |at: usize| [0, 1, 2].map(|axis| (at, axis, "is at")).to_vec();
    let along = |at: usize, first: usize| [0, 1, 2].map(|axis| (at, first + axis, "goes along")).to_vec();
    let rows = [
        strength(0, 0),
        place(1),
        strength(1, 3),
        along(2, 0),
        strength(2, 3),
        place(3),
        along(3, 3),
        strength(3, 6),
        vec![(3, 9, "has the angles"), (3, 10, "has the angles")],
    ];
    for target in ["mitsuba-3", "mitsuba-0.5", "pbrt-v3", "pbrt-v4", "luxcore", "cycles"] {
        let reads = found(&scene, target, |_| ());
        assert_eq!(reads, Vec::<String>::new(), "{target}");
        for (at, number, words) in rows.iter().flatten() {
            for by in [1e-5, -1e-5] {
                let all = found(&scene, target, |read| *light(read, *at, *number) += by);
                let words = format!("the light `light {at}` {words}");
                assert!(all.len() == 1 && all[0].contains(&words), "{target}: {number} by {by}: {all:?}");
            }
        }
    }
}

#[test]
fn lights_are_as_many_of_the_same_kinds() {
    for target in ["mitsuba-3", "mitsuba-0.6", "mitsuba-0.5", "pbrt-v3", "pbrt-v4", "luxcore", "cycles"] {
        each(
            full(),
            target,
            &[
                (|read| drop(read.lights.remove(0)), "there are 3 lights without a surface instead of 4"),
                (|read| drop(read.lights.pop()), "there are 3 lights without a surface instead of 4"),
                (|read| read.lights.clear(), "there are 0 lights without a surface instead of 4"),
                (|read| read.lights.push(read.lights[1].clone()), "there are 5 lights without a surface instead of 4"),
                (|read| read.lights[0] = read.lights[1].clone(), "`light 0` is `point` instead of `environment`"),
                (|read| read.lights[1] = read.lights[2].clone(), "`light 1` is `directional` instead of `point`"),
                (|read| read.lights[2] = read.lights[3].clone(), "`light 2` is `spot` instead of `directional`"),
                (|read| read.lights[3] = read.lights[0].clone(), "`light 3` is `environment` instead of `spot`"),
            ],
        );
    }
    // Of the four it has no environment: what is left must be the other three.
    each(full(), "gltf", &[(|read| drop(read.lights.remove(0)), "there are 2 lights without a surface instead of 3")]);
    let scene = validate(full()).expect("a valid scene");
    let all = found(&scene, "gltf", |read| read.lights.push(read.lights[0].clone()));
    assert_eq!(all[0], "the light `light 0` is `point` instead of `environment`");
}

#[test]
fn images_of_the_sky() {
    let mut scene = sample::room();
    let texture = scene.textures.push(sample::image("sky", ImageFormat::Exr, Encoding::Linear), Origin::Made);
    let kind = LightKind::Environment {
        radiance: ColorOrTexture::Texture(texture),
        tint: Color::Rgb([0.5, 3.0, 1.0]),
        turn: Affine::rotation([0.6, 0.0, 0.8], 70.0),
    };
    scene.lights.push(LightSource { name: "sky".to_owned(), kind }, Origin::Made);
    for target in ["mitsuba-3", "pbrt-v4", "luxcore"] {
        each(
            scene.clone(),
            target,
            &[
                (|read| *light(read, 0, 0) *= MORE, "the light `sky` shows its image times"),
                (|read| *light(read, 0, 1) *= MORE, "the light `sky` shows its image times"),
                (|read| *light(read, 0, 2) /= MORE, "the light `sky` shows its image times"),
                (
                    |read| {
                        if let Light::Environment { radiance: _, turn } = &mut read.lights[0] {
                            turn.rows[1][2] += 1e-6;
                        }
                    },
                    "the light `sky` is turned by",
                ),
                (
                    |read| {
                        if let Light::Environment { radiance, turn: _ } = &mut read.lights[0] {
                            *radiance = Paint::WHITE;
                        }
                    },
                    "the light `sky` shows no image",
                ),
                (
                    |read| {
                        let other = VPath::resolve("", "other.exr").expect("a path");
                        if let Light::Environment { radiance: Paint::Image { file, linear: _, factor: _ }, turn: _ } =
                            &mut read.lights[0]
                        {
                            *file = Picture::File(other);
                        }
                    },
                    "the light `sky` shows the image `other.exr` instead of",
                ),
            ],
        );
    }
}
