//! A target that only tests have: a list of what a scene holds, a line each. It shows what a new target costs: this folder, and two
//! lines in the table beside it. Every test that asks all targets asks this one, too.

use std::io::{self, Write};

use super::shared::images;
use super::shared::number::{Num, Row};
use super::shared::text::{self, Head, Line};
use super::{Emission, STAND_IN, Target, mesh_files};
use crate::capability::{Feature, Support};
use crate::files::Sink;
use crate::ir::{
    Affine, Bsdf, Camera, Color, ColorOrTexture, Emission as Light, Film, Filter, Group, Instance, LightSource,
    Material, Sampler, Scene, Shape,
};

/// The list.
pub const TOY: Target = Target {
    name: "toy",
    aliases: &["list"],
    summary: "a list of what a scene holds",
    main_file: "SCENE.txt",
    shares_meshes: true,
    supports,
    conversions: &[(Feature::Camera, "half the angle of view")],
    images: images::shared_or_scaled,
    bound: |_, _| None,
    choices: &[],
    emit,
    import: None,
    statements: None,
};

const COLOUR: Support = Support::approximate("a surface is one color", "what it reflects at normal incidence");

fn supports(feature: Feature) -> Support {
    match feature {
        Feature::Diffuse
        | Feature::ColoredDiffuse
        | Feature::SmoothDiffuse
        | Feature::BlackEmitter
        | Feature::ScatteringEmitter
        | Feature::ColoredEmitter
        | Feature::VertexNormals
        | Feature::NoNormals
        | Feature::TextureCoordinates
        | Feature::TransformedShape
        | Feature::SharedMesh
        | Feature::Instances
        | Feature::Camera
        | Feature::Resolution => Support::Exact,
        Feature::SmoothConductor
        | Feature::RoughConductor
        | Feature::SharpConductor
        | Feature::WideConductor
        | Feature::ColoredConductor
        | Feature::SmoothDielectric
        | Feature::RoughDielectric
        | Feature::ThinnerInside
        | Feature::Mirror
        | Feature::DimMirror
        | Feature::Plastic
        | Feature::TexturedPlastic
        | Feature::Principled
        | Feature::TexturedPrincipled
        | Feature::OneSided => COLOUR,
        Feature::Spectrum => super::RGB_ONLY,
        Feature::SeveralCameras => super::ONE_CAMERA,
        Feature::Environment
        | Feature::EnvironmentImage
        | Feature::TurnedEnvironment
        | Feature::TintedEnvironment
        | Feature::PointLight
        | Feature::SpotLight
        | Feature::SoftSpotLight
        | Feature::DirectionalLight
        | Feature::Texture
        | Feature::ColoredTexture
        | Feature::SrgbTexture
        | Feature::LinearTexture
        | Feature::DeepTexture
        | Feature::ScaledTexture
        | Feature::JpegTexture
        | Feature::LinearJpegTexture
        | Feature::ExrTexture
        | Feature::PfmTexture
        | Feature::HdrTexture
        | Feature::ClippingPlanes
        | Feature::PixelFilter
        | Feature::BoxFilter
        | Feature::GaussianFilter
        | Feature::CutGaussianFilter
        | Feature::Path
        | Feature::Bidirectional
        | Feature::LightTracing
        | Feature::Metropolis
        | Feature::PhotonMap
        | Feature::EmissionOnly
        | Feature::IndirectLight
        | Feature::IndependentSampler
        | Feature::SobolSampler
        | Feature::SobolForLightPaths
        | Feature::Seed => Support::unsupported("a list has no word for it"),
    }
}

fn emit(emission: &Emission<'_>, sink: &mut dyn Sink) -> io::Result<()> {
    let Emission { scene, camera, meshes: folder, textures: _, choices: _, statements: _ } = emission;
    let scene: &Scene = scene;
    text::file(sink, &TOY.main_file_of(&scene.name), |out| {
        writeln!(out, "# {}", Line(&Head { scene: &scene.name, target: TOY.name }.to_string()))?;
        let Camera { name: _, eye, target, up, fov_x, near: _, far: _ } = &scene.cameras[*camera];
        let Film { width, height, filter } = &scene.film;
        writeln!(out, "film {width} {height} {}", filter_word(filter))?;
        let [eye, target, up] = [eye, target, up].map(|row| Row(row, " ").to_string());
        writeln!(out, "camera [{eye}] [{target}] [{up}] {}", Num(fov_x / 2.0))?;
        let (Sampler::Independent { samples, seed: _ } | Sampler::Sobol { samples, seed: _ }) = &scene.sampler;
        writeln!(out, "{} {samples}", scene.integrator.word())?;
        for material in scene.materials.values() {
            let Material { name, bsdf, sides: _ } = material;
            writeln!(out, "color {} [{}]", Line(name), Row(&color(bsdf).rgb(), " "))?;
        }
        let files = mesh_files(scene);
        let shape = |shape: &Shape, out: &mut dyn Write| {
            let Shape { name, mesh, transform: Affine { rows }, material, emission } = shape;
            let material = Line(&scene.materials[*material].name);
            let place = Row(rows.as_flattened(), " ");
            write!(out, "shape {} {folder}{} {material} [{place}]", Line(name), files[mesh.index()])?;
            match emission {
                Some(Light { radiance }) => writeln!(out, " [{}]", Row(&radiance.rgb(), " ")),
                None => writeln!(out),
            }
        };
        for group in scene.groups.values() {
            let Group { name, shapes, instances: _ } = group;
            writeln!(out, "group {}", Line(name))?;
            shapes.values().try_for_each(|one| shape(one, out))?;
            writeln!(out, "end")?;
        }
        scene.shapes.values().try_for_each(|one| shape(one, out))?;
        for instance in scene.instances.values() {
            let Instance { name: _, group, places: _ } = instance;
            for (name, Affine { rows }) in instance.named() {
                let place = Row(rows.as_flattened(), " ");
                writeln!(out, "instance {} {} [{place}]", Line(&name), Line(&scene.groups[*group].name))?;
            }
        }
        for light in scene.lights.values() {
            let LightSource { name, kind } = light;
            writeln!(out, "# {} is left out: {}", Line(name), kind.word())?;
        }
        Ok(())
    })
}

fn filter_word(filter: &Filter) -> &'static str {
    match filter {
        Filter::Box { radius: _ } => "box",
        Filter::Gaussian { stddev: _, radius: _ } => "gaussian",
    }
}

fn color(bsdf: &Bsdf) -> Color {
    match bsdf {
        Bsdf::Diffuse { reflectance }
        | Bsdf::Plastic { reflectance, ior: _, alpha: _ }
        | Bsdf::Principled { base: reflectance, metallic: _, roughness: _, ior: _ } => match reflectance {
            ColorOrTexture::Color(color) => color.clone(),
            ColorOrTexture::Texture(_) => Color::Grey(STAND_IN),
        },
        Bsdf::Conductor { eta, k, alpha: _ } => {
            let (eta, k) = (eta.rgb(), k.rgb());
            Color::Rgb([0, 1, 2].map(|at| super::shared::fresnel::head_on(eta[at], k[at])))
        }
        Bsdf::Mirror { reflectance } => reflectance.clone(),
        Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => Color::Grey(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Choices, TARGETS, find};
    use super::*;
    use crate::capability::features;
    use crate::diag::Sources;
    use crate::eval::{Overrides, evaluate};
    use crate::files::{MemoryFiles, MemorySink, VPath};
    use crate::formats::tests::{emitted, text};
    use crate::ledger::{FILE, Ledger};
    use crate::pipeline;

    macro_rules! scenes {
        ($($name:literal),* $(,)?) => {
            &[$(($name, include_bytes!(concat!("../../../../../scenes-src/", $name)))),*]
        };
    }

    /// What the project's scenes are read from.
    const FILES: &[(&str, &[u8])] = scenes![
        "cbox_classic.lts",
        "cbox_empty.lts",
        "cbox_indirect.lts",
        "cboxm_diffuse_lsame.lts",
        "cboxm_diffuse_lvar.lts",
        "cboxm_glossy_lsame.lts",
        "cboxm_glossy_lvar.lts",
        "pool_classic.lts",
        "pool_simple.lts",
        "ring.lts",
        "surfaces.lts",
        "veach_mis.lts",
        "lib/cboxm.lts",
        "lib/cornell.lts",
        "lib/metals.lts",
        "lib/water.lts",
        "textures/tiles.png",
    ];

    #[test]
    fn a_new_target_writes_every_scene() {
        let mut files = MemoryFiles::default();
        for (name, bytes) in FILES {
            files.insert(*name, *bytes);
        }
        let target = find("list").expect("a target by its other name");
        assert_eq!(TARGETS.last().map(|target| target.name), Some("toy"));
        for (file, _) in FILES.iter().filter(|(name, _)| !name.contains('/')) {
            let path = VPath::resolve("", file).expect("a path");
            let made = evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
            let scene = made.scene.unwrap_or_else(|| panic!("{file}: {:?}", made.findings));
            let (scene, _) = pipeline::prepare(scene).expect("a valid scene");
            let camera = pipeline::camera(&scene, None).expect("a camera");
            let ledger = Ledger::of(&scene, target, &[]);
            assert_eq!(ledger.converted.len(), 1, "the camera of {file}");
            assert!(ledger.dropped.iter().any(|dropped| dropped.what == Feature::Path.name()), "{file}");
            let mut sink = MemorySink::default();
            pipeline::emit_alone(&scene, camera, target, &ledger, &Choices::default(), &mut sink)
                .expect("memory takes all");
            let list = text(&sink, &target.main_file_of(&scene.name));
            let count = |word: &str| list.lines().filter(|line| line.split(' ').next() == Some(word)).count();
            let inner: usize = scene.groups.values().map(|group| group.shapes.len()).sum();
            let places: usize = scene.instances.values().map(|one| one.places.maps().len()).sum();
            assert_eq!((count("shape"), count("instance")), (scene.shapes.len() + inner, places), "{file}");
            assert_eq!((count("camera"), count("color")), (1, scene.materials.len()), "{file}");
            // The ledger, the list, and what targets share.
            assert!(sink.files.contains_key(FILE));
            let shared = sink.files.keys().filter(|path| path.contains('/')).count();
            assert_eq!(shared, scene.meshes.len() + scene.textures.len(), "{file}");
            assert!(!features(&scene).is_empty());
        }
    }

    #[test]
    fn a_list_has_a_line_for_each_thing() {
        let list = text(&emitted("toy", super::super::shared::sample::grid()), "grid.txt");
        let lines: Vec<&str> = list.lines().collect();
        assert_eq!(lines[2], "camera [0 -160 50] [0 0 50] [0 0 1] 22.5");
        assert!(lines.contains(&"shape left ../meshes/block.ply white [1 0 0 -2 0 1 0 0 0 0 1 0]"), "{list}");
        assert!(lines.contains(&"instance pair[1] pair [0 -1 0 0 1 0 0 0 0 0 1 5]"), "{list}");
        let lamp = "shape lamp ../meshes/lamp.ply black [1 0 0 0 0 1 0 0 0 0 1 0] [30 30 30]";
        assert!(lines.contains(&lamp), "{list}");
    }
}
