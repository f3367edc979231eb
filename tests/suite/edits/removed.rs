//! A whole light, sky, emitter or surface that is gone from the files of a target, or that only they have: the audit says so.

use ltsc_core::files::MemoryFiles;
use ltsc_core::formats::{Choices, TARGETS};
use ltsc_core::pipeline;
use ltsc_core::valid::Valid;

use super::super::{prepared, random};

const HEAD: &str = "lts 1

scene lights {}

camera = perspective(eye: (0, -10, 4), target: (0, 0, 1), fov_x: 30deg)
film = image(64, 64)
integrator = path(max_depth: 8)
sampler = independent(samples: 16)
";

/// Lines of a scene, each of which is left out once, with what the audit counts.
const LINES: &[(&str, &str)] = &[
    ("shape table = rectangle(x: -5..5, y: -5..5, z: 0, normal: Z) with diffuse(rgb(0.7, 0.6, 0.5))", "surfaces"),
    ("shape ball = sphere(center: (0, 0, 1.2)) with dielectric(ior: 1.5)", "surfaces"),
    ("emitter lamp = rectangle(x: -1..1, y: -1..1, z: 6, normal: -Z) with radiance(20)", "surfaces"),
    ("emitter glow = box(size: 0.5) |> translate(2, 0, 1) with radiance(rgb(1, 2, 3))", "surfaces"),
    ("emitter sky = environment(radiance: rgb(0.1, 0.2, 0.3))", "lights without a surface"),
    ("emitter bulb = point(position: (1, 2, 3), intensity: 4)", "lights without a surface"),
    (
        "emitter beam = spot(position: (0, 1, 9), target: (0, 0, 0), intensity: 9, angle: 30deg)",
        "lights without a surface",
    ),
    ("emitter sun = directional(direction: (1, 2, -4), irradiance: 3)", "lights without a surface"),
    ("emitter second = point(position: (-1, 2, 3), intensity: 4)", "lights without a surface"),
];

/// The scene without one of its lines, and its files.
fn written(without: Option<usize>) -> (Valid, MemoryFiles) {
    let lines = LINES.iter().enumerate().filter(|(at, _)| Some(*at) != without).map(|(_, (line, _))| *line);
    let text = format!("{HEAD}{}\n", lines.collect::<Vec<_>>().join("\n"));
    let mut source = MemoryFiles::default();
    source.insert("lights.lts", text);
    let scene = prepared(&source, "lights.lts");
    let mut files = MemoryFiles::default();
    random::written(&scene, &Choices::default()).into_iter().for_each(|(name, bytes)| files.insert(name, bytes));
    (scene, files)
}

#[test]
fn what_is_gone_and_what_is_too_much_is_counted() {
    let whole = written(None);
    for (at, (line, what)) in LINES.iter().enumerate() {
        let less = written(Some(at));
        let (all, fewer) = match *what {
            "surfaces" => (4, 3),
            _ => (5, 4),
        };
        for target in TARGETS.iter().filter(|target| target.import.is_some()) {
            let found = |(scene, _): &(Valid, MemoryFiles), (_, files): &(Valid, MemoryFiles)| {
                let camera = pipeline::camera(scene, None).expect("a camera");
                let audited = pipeline::audit(scene, camera, &[target], files, |target| target.name.to_owned());
                audited.findings().map(|finding| finding.message.clone()).collect::<Vec<_>>()
            };
            let (sky, lights) = (line.contains("environment"), *what != "surfaces");
            let (mut less_said, mut more_said) = (
                format!("there are {fewer} {what} instead of {all}"),
                format!("there are {all} {what} instead of {fewer}"),
            );
            if ["gltf", "glb"].contains(&target.name) {
                // glTF has no sky: its files are the same without it, and a light too much stands in the sky's place.
                assert_eq!(found(&whole, &less).is_empty(), sky, "{}: {line}", target.name);
                if sky {
                    continue;
                }
                if lights {
                    less_said = format!("there are {} {what} instead of {}", fewer - 1, all - 1);
                    more_said = "the light `sky` is `point` instead of `environment`".to_owned();
                }
            }
            for (found, says) in [(found(&whole, &less), less_said), (found(&less, &whole), more_said)] {
                assert!(found.contains(&says), "{}: {line}: `{says}` of {found:#?}", target.name);
            }
        }
    }
    for target in TARGETS {
        let camera = pipeline::camera(&whole.0, None).expect("a camera");
        let audited = pipeline::audit(&whole.0, camera, &[target], &whole.1, |target| target.name.to_owned());
        assert_eq!(audited.findings().count(), 0, "{}", target.name);
    }
}
