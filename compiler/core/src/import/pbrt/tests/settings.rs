//! Camera, film, filter, sampler, algorithm, and what is found out about the version.

use super::*;
use crate::import::pbrt::dialect::Dialect;
use crate::ir::{Filter, Integrator, Sampler};

fn head(text: &str) -> Read {
    read(&format!("Scale -1 1 1 LookAt 0 0 5 0 0 0 0 1 0\n{text}\nWorldBegin{TRIANGLE}"))
}

#[test]
fn a_camera_behind_a_mirror_is_read_as_it_is() {
    let read = head(
        "Camera \"perspective\" \"float fov\" 45 Film \"image\" \"integer xresolution\" 100 \"integer yresolution\" 100",
    );
    assert_eq!(read.said(), []);
    let camera = read.camera();
    assert_eq!((camera.eye, camera.target, camera.up), ([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0]));
    assert!((camera.fov_x - 45.0).abs() < 1e-9);
    assert_eq!(read.shape(0).transform, crate::ir::Affine::IDENTITY);
}

/// Without a mirror +x lies on the left of PBRT's image when it looks along -z with y up: the Scene's camera has it on the right, so
/// that the world is mirrored.
#[test]
fn a_left_handed_world_is_mirrored() {
    let read =
        super::read(&format!("LookAt 1 0 5 1 0 0 0 1 0\nCamera \"perspective\"\nWorldBegin Translate 3 0 0{TRIANGLE}"));
    assert_eq!(read.said().len(), 1);
    assert!(read.says(2, "loss-baked", "left-handed"));
    let camera = read.camera();
    assert_eq!((camera.eye, camera.target), ([-1.0, 0.0, 5.0], [-1.0, 0.0, 0.0]));
    // x = 3 is to the left of x = 1 in PBRT; mirrored, -3 is to the left of -1.
    let place = read.shape(0).transform.point([0.0; 3]);
    assert!(close(&place, &[-3.0, 0.0, 0.0]));
    let right = camera.axes().expect("axes").right;
    assert!(crate::ir::dot(right, crate::ir::sub(place, camera.eye)) < 0.0);
    // The front of the triangle stays +z.
    assert!(close(&read.front(0), &[0.0, 0.0, 1.0]));
}

#[test]
fn a_camera_is_found_by_its_matrix() {
    // World to camera: x mirrored, then 5 along z: at z = -5, looking along +z.
    let read = super::read(&format!(
        "Transform [-1 0 0 0 0 1 0 0 0 0 1 0 0 0 5 1] Camera \"perspective\" WorldBegin{TRIANGLE}"
    ));
    assert_eq!(read.said(), []);
    let camera = read.camera();
    assert!(close(&camera.eye, &[0.0, 0.0, -5.0]) && close(&camera.target, &[0.0, 0.0, -4.0]));
    let axes = camera.axes().expect("axes");
    assert!(close(&axes.right, &[-1.0, 0.0, 0.0]));
}

#[test]
fn the_angle_is_along_the_shorter_axis() {
    let fov = |more: &str, width: u32, height: u32| {
        let film = format!("Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" {height}");
        let read = head(&format!("Camera \"perspective\" \"float fov\" 90 {more}\n{film}"));
        (read.camera().fov_x, read.said().len())
    };
    // 2:1: 2 atan(2 tan(45)); 1:2: 90.
    assert!((fov("", 200, 100).0 - 126.869_897_645).abs() < 1e-6);
    assert!((fov("", 100, 200).0 - 90.0).abs() < 1e-9);
    // The window is half as wide: 2 atan(1/2).
    let half = fov("\"float screenwindow\" [-.5 .5 -.5 .5]", 100, 100);
    assert!((half.0 - 53.130_102_354).abs() < 1e-6 && half.1 == 0);
    assert_eq!(fov("\"float screenwindow\" [-.5 1.5 -1 1]", 100, 100).1, 1);
    assert_eq!(fov("\"float frameaspectratio\" 2", 100, 100).1, 1);
    let wide = fov("\"float frameaspectratio\" 2", 200, 100);
    assert!((wide.0 - 126.869_897_645).abs() < 1e-6 && wide.1 == 0);
    assert_eq!(fov("\"float lensradius\" .1 \"float focaldistance\" 3", 100, 100).1, 1);
}

#[test]
fn other_cameras_and_none_are_findings() {
    let read = head("Camera \"realistic\" \"string lensfile\" \"a.dat\"");
    assert!(read.says(2, "loss-dropped", "the camera `realistic`"), "{:?}", read.said());
    assert_eq!(read.camera().fov_x.round(), 58.0);
    let read = super::read("WorldBegin\nShape \"sphere\"");
    assert!(read.says(1, "loss-approximated", "no camera"), "{:?}", read.said());
    assert_eq!(read.scene().cameras.len(), 1);
    let read = head("Camera \"perspective\"\nScale 1 1 0 Camera \"perspective\"");
    assert!(read.says(3, "loss-dropped", "a second camera"));
    let read = super::read(&format!("Scale 1 1 0\nCamera \"perspective\"\nWorldBegin{TRIANGLE}"));
    assert!(read.says(2, "loss-dropped", "no inverse"));
}

#[test]
fn filters() {
    let filter = |text: &str| head(&format!("Camera \"perspective\" PixelFilter {text}")).scene().film.filter.clone();
    assert_eq!(filter("\"box\""), Filter::Box { radius: 0.5 });
    // exp(-2 x^2): a standard deviation of 1/2.
    assert_eq!(filter("\"gaussian\""), Filter::Gaussian { stddev: 0.5, radius: 2.0 });
    let wide = filter("\"gaussian\" \"float alpha\" .5 \"float xwidth\" 3 \"float ywidth\" 3");
    assert_eq!(wide, Filter::Gaussian { stddev: 1.0, radius: 3.0 });
    let Filter::Gaussian { stddev, radius: _ } = filter("\"triangle\"") else { panic!("no Gaussian") };
    assert!((stddev * stddev - 4.0 / 6.0).abs() < 1e-9);
    let read = head("Camera \"perspective\" PixelFilter \"mitchell\" \"float B\" .3");
    assert!(read.says(2, "loss-approximated", "`mitchell`"));
    // v4's own default.
    let read = head("Camera \"perspective\" Film \"rgb\"");
    assert_eq!(read.scene().film.filter, Filter::Gaussian { stddev: 0.5, radius: 1.5 });
    assert_eq!((read.scene().film.width, read.scene().film.height), (1280, 720));
    let read = head("Camera \"perspective\" Film \"rgb\" PixelFilter \"gaussian\" \"float sigma\" .25");
    assert_eq!(read.scene().film.filter, Filter::Gaussian { stddev: 0.25, radius: 1.5 });
}

#[test]
fn samplers_and_algorithms() {
    let both = |text: &str| {
        let read = head(&format!("Camera \"perspective\" {text}"));
        (read.scene().sampler.clone(), read.scene().integrator.clone())
    };
    let independent = |samples| Sampler::Independent { samples, seed: 0 };
    let (sampler, integrator) =
        both("Sampler \"random\" \"integer pixelsamples\" 32 Integrator \"path\" \"integer maxdepth\" 9");
    assert_eq!((sampler, integrator), (independent(32), Integrator::Path { max_depth: 10 }));
    // The defaults: 16 samples, 5 bounces.
    assert_eq!(both("Integrator \"bdpt\""), (independent(16), Integrator::Bidirectional { max_depth: 6 }));
    assert_eq!(both("Sampler \"stratified\" \"integer xsamples\" 3 \"integer ysamples\" 5").0, independent(15));
    assert_eq!(both("Sampler \"sobol\" \"integer pixelsamples\" 8").0, Sampler::Sobol { samples: 8, seed: 0 });
    assert_eq!(
        both("Integrator \"mlt\" \"integer mutationsperpixel\" 7"),
        (independent(7), Integrator::Metropolis { max_depth: 6 })
    );
    assert_eq!(both("Integrator \"sppm\" \"integer iterations\" 9").0, independent(9));
    assert_eq!(both("SurfaceIntegrator \"path\" \"integer maxdepth\" 3").1, Integrator::Path { max_depth: 4 });
    assert_eq!(both("Film \"rgb\" Integrator \"lightpath\"").1, Integrator::LightTracing { max_depth: 6 });
    assert_eq!(both("Integrator \"directlighting\"").1, Integrator::Path { max_depth: 2 });
    assert_eq!(both("Renderer \"metropolis\"").1, Integrator::Metropolis { max_depth: 8 });
    assert!(head("Camera \"perspective\" Integrator \"whitted\"").says(2, "loss-approximated", "two segments"));
    assert!(head("Camera \"perspective\" Sampler \"halton\"").says(2, "loss-baked", "the noise is another"));
}

#[test]
fn what_a_film_does_to_its_image_is_a_finding() {
    for text in [
        "\"image\" \"float cropwindow\" [0 .5 0 1]",
        "\"image\" \"float scale\" 0",
        "\"rgb\" \"float iso\" -100",
        "\"rgb\" \"string sensor\" \"canon_eos_100d\"",
        "\"rgb\" \"float whitebalance\" 5000",
        "\"image\" \"integer xresolution\" 0",
    ] {
        let read = head(&format!("Camera \"perspective\" Film {text}"));
        assert_eq!(read.said().len(), 1, "{text}: {:?}", read.said());
        assert!(read.says(2, "loss-dropped", ""));
    }
    assert_eq!(
        head("Camera \"perspective\" Film \"image\" \"float cropwindow\" [0 1 0 1] \"string filename\" \"a.exr\"")
            .said(),
        []
    );
}

#[test]
fn what_multiplies_the_image_multiplies_the_lights() {
    let world = "LightSource \"point\" \"rgb I\" [1 2 3] LightSource \"infinite\" \"rgb L\" [.5 .5 .5]
        AreaLightSource \"diffuse\" \"rgb L\" [4 5 6]
        Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]";
    for film in [
        "\"image\" \"float scale\" 2",
        "\"rgb\" \"float iso\" 200",
        "\"rgb\" \"float iso\" 50 \"float exposuretime\" 4",
    ] {
        let read = super::read(&format!("Integrator \"path\" Camera \"perspective\"\nFilm {film}\nWorldBegin {world}"));
        assert!(read.says(2, "loss-baked", "multiplies light by 2"), "{film}: {:?}", read.said());
        let lights: Vec<_> = read.scene().lights.values().map(|light| light.kind.color().rgb()).collect();
        assert_eq!(lights, [[2.0, 4.0, 6.0], [1.0; 3]], "{film}");
        let lamp = read.shape(0).emission.as_ref().expect("a lamp");
        assert_eq!(lamp.radiance.rgb(), [8.0, 10.0, 12.0], "{film}");
    }
    // Of an image the tint, and no light is brighter than a Scene may have it.
    let pixels = crate::image::Pixels { width: 2, height: 1, channels: 3, values: vec![1.0; 6] };
    let image = crate::image::write::png(&pixels, 8).expect("a PNG file");
    let text = "Camera \"perspective\" Film \"image\" \"float scale\" 1e12 WorldBegin LightSource \"point\" \"rgb I\" [1e27 0 0]
        LightSource \"infinite\" \"string mapname\" \"m.png\" \"rgb L\" [2 3 4]
        Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]";
    let read = super::read_with(text, &[("a/m.png", &image)]);
    let lights: Vec<_> = read.scene().lights.values().map(|light| light.kind.color().rgb()).collect();
    assert_eq!(lights, [[1e28, 0.0, 0.0], [2e12, 3e12, 4e12]], "{:?}", read.said());
    crate::pipeline::prepare(read.scene().clone()).expect("a valid scene");
    let cut = head("Camera \"perspective\" Film \"image\" \"float maxsampleluminance\" 10");
    assert!(cut.says(2, "loss-approximated", "bright samples are not cut"), "{:?}", cut.said());
}

#[test]
fn an_object_that_is_described_again_is_another_from_there_on() {
    let triangle =
        |x: u32| format!("Shape \"trianglemesh\" \"point3 P\" [{x} 0 0 {x} 1 0 {x} 0 1] \"integer indices\" [0 1 2]");
    let object = |x: u32| format!("ObjectBegin \"o\" {} ObjectEnd ObjectInstance \"o\"", triangle(x));
    let text = format!("Camera \"perspective\" Film \"image\" WorldBegin\n{}\n{}", object(1), object(2));
    let read = super::read(&text);
    let scene = read.scene();
    let at = |instance: &crate::ir::Instance| {
        let shape = scene.groups[instance.group].shapes.values().next().expect("a shape");
        scene.meshes[shape.mesh].positions[0][0]
    };
    assert_eq!(scene.instances.values().map(at).collect::<Vec<_>>(), [1.0, 2.0], "{:?}", read.said());
    assert!(read.said().iter().all(|(_, code, _)| *code != "loss-dropped"), "{:?}", read.said());
}

#[test]
fn versions_are_found_out() {
    let of = |text: &str| {
        let mut files = MemoryFiles::default();
        files.insert("a.pbrt", text.as_bytes().to_vec());
        let mut sources = Sources::default();
        let options = Options::default();
        let mut reader = crate::import::Reader::new(&files, &mut sources, &options);
        let path = VPath::resolve("", "a.pbrt").expect("a path");
        let file = reader.text(&path).expect("a text");
        crate::import::pbrt::dialect::of(&mut reader, &path, file)
    };
    assert_eq!(of("SurfaceIntegrator \"path\""), Dialect::Old);
    assert_eq!(of("Material \"matte\" \"color Kd\" [1 1 1]"), Dialect::Old);
    assert_eq!(of("Camera \"perspective\" Material \"matte\" \"color Kd\" [1 1 1]"), Dialect::V3);
    assert_eq!(of("Integrator \"path\" Material \"matte\" \"color Kd\" [1 1 1]"), Dialect::V3);
    assert_eq!(of("Material \"matte\" \"rgb Kd\" [1 1 1]"), Dialect::V3);
    assert_eq!(of("Integrator \"path\" Film \"rgb\""), Dialect::V4);
    assert_eq!(of("# Option\nIntegrator \"path\" ColorSpace \"srgb\""), Dialect::V4);
    assert_eq!(of("Material \"diffuse\""), Dialect::V4);
}
