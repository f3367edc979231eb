//! Random scenes, written and read again.

use std::sync::Arc;

use proptest::prelude::*;

use super::read_tests::read;
use super::{Options, difference, print};
use crate::diag::{Origin, Sources};
use crate::image::{self, Loaded, Pixels};
use crate::ir::{
    Affine, Arena, Bsdf, Camera, Color, ColorOrTexture, Documentation, Emission, Encoding, Film, Filter, Group, Handle,
    Instance, Integrator, LightKind, LightSource, Material, Meaning, Mesh, Places, Sampler, Scene, Shape, Sides,
    Similar, Spectrum, Texture, Vec3, normalized,
};
use crate::mesh::{Axis, Extent, Geometry, SignedAxis, boxed, cylinder, disk, rectangle, sphere};

/// Where random choices come from; 0 when they are used up, so that fewer make a smaller scene.
pub(super) struct Dice<'n> {
    pub numbers: &'n [u64],
    pub at: usize,
    /// Whether numbers may be such as no scene should have, and names the same.
    pub wild: bool,
}

/// Numbers that are hard to write, or to have.
const WILD: [f64; 9] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 1e300, 5e-324, 1e38, -1e-9];

impl Dice<'_> {
    fn next(&mut self) -> u64 {
        self.at += 1;
        self.numbers.get(self.at - 1).copied().unwrap_or(0)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn pick<T: Clone>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())].clone()
    }

    /// One of the wild numbers, now and then.
    fn odd(&mut self) -> Option<f64> {
        (self.wild && self.below(12) == 0).then(|| self.pick(&WILD))
    }

    /// From 0 to 1, round numbers and others.
    fn share(&mut self) -> f64 {
        if let Some(odd) = self.odd() {
            return odd;
        }
        let random = self.next() as f64 / u64::MAX as f64;
        self.pick(&[0.5, 0.0, 1.0, 0.1, 0.3, random, random, f64::from(random as f32)])
    }

    /// Above 0.
    fn positive(&mut self) -> f64 {
        let share = self.share();
        self.pick(&[1.0, 2.5, 0.1 + share, 1e-7 + share * 1e-3, 1e9 * (share + 1e-3)])
    }

    fn number(&mut self) -> f64 {
        let sign = self.pick(&[1.0, -1.0]);
        sign * self.pick(&[0.0_f64, 1.0]).max(self.share()) * self.positive()
    }

    fn vector(&mut self) -> Vec3 {
        [self.number(), self.number(), self.number()]
    }

    fn direction(&mut self) -> Vec3 {
        let wish = self.vector();
        normalized(wish).unwrap_or([0.0, 0.0, -1.0])
    }

    fn color(&mut self, meaning: Meaning, most: f64) -> Color {
        let part = |dice: &mut Self| dice.share().mul_add(most, 1e-9);
        match self.below(4) {
            0 | 1 => Color::Grey(part(self)),
            2 => Color::Rgb([part(self), part(self), part(self)]),
            _ => {
                let count = 2 + self.below(4);
                let points: Vec<_> = (0..count).map(|at| (400.0 + 37.5 * at as f64, part(self))).collect();
                Color::Spectrum(Spectrum::new(&points, meaning))
            }
        }
    }

    fn transform(&mut self) -> Affine {
        let angle = self.pick(&[90.0, -90.0, 180.0, 15.0, 33.3, 1.0 / 3.0]);
        let axis = self.pick(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]]);
        let scale = self.pick(&[[1.0; 3], [2.0; 3], [0.1, 0.1, 3.0], [1.0 / 3.0, 1.0, 7.0], [-1.0, 1.0, 1.0]]);
        let parts = [Affine::scaling(scale), Affine::rotation(axis, angle), Affine::translation(self.vector())];
        let count = self.below(4);
        let map = (0..count).fold(Affine::IDENTITY, |map, _| map.then(&self.pick(&parts)));
        if map.is_invertible() || self.wild { map } else { Affine::IDENTITY }
    }

    fn name(&mut self, kind: &str, at: usize) -> String {
        if self.wild {
            return self.pick(&["a", "a", "b", "a_2", "", "X", "`", "shape", "\u{7}bell"]).to_owned();
        }
        match self.below(5) {
            0 => format!("{kind} {at}"),
            1 => format!("{kind}[{at},0]/größe"),
            2 => format!("{at}//{{\"{kind}"),
            _ => format!("{kind}_{at}"),
        }
    }

    fn geometry(&mut self) -> Geometry {
        let low = self.number();
        let high = low + self.positive() * low.abs().max(1.0);
        let range = Extent::Range(low, high);
        let made = match self.below(7) {
            0 => boxed([low; 3], [high; 3]),
            1 => rectangle([range, Extent::At(low), range], SignedAxis { axis: Axis::Y, negative: true }),
            2 => sphere(self.positive(), [0.0; 3], 5, 4),
            3 => sphere(0.25, [1.0, 2.0, low.clamp(-3.0, 3.0)], 8, 3),
            4 => disk(1.5, 0.0, 6),
            5 => cylinder(0.5, (0.0, 2.0), 7, self.below(2) == 0),
            _ => Ok(self.soup()),
        };
        let mut geometry = made.unwrap_or_else(|_| self.soup());
        if self.below(6) == 0 {
            geometry.uvs.iter_mut().flatten().for_each(|uv| uv[1] = 1.0 - uv[1]);
        }
        geometry
    }

    /// Triangles of any form.
    fn soup(&mut self) -> Geometry {
        let count = 3 + self.below(4);
        let single = |vector: Vec3| vector.map(|part| part as f32);
        let positions: Vec<_> = (0..count).map(|_| single(self.vector())).collect();
        let normals = (self.below(2) == 0).then(|| (0..count).map(|_| single(self.direction())).collect());
        let uvs = (self.below(2) == 0).then(|| (0..count).map(|at| [at as f32 * 0.3, -0.0]).collect());
        let triangles = (0..1 + self.below(4)).map(|_| [0; 3].map(|_: i32| self.below(count) as u32)).collect();
        Geometry { positions, normals, uvs, triangles }
    }

    fn texture(&mut self, name: String, float: bool) -> Texture {
        // No image has wild numbers: its reader refuses them.
        let values = (0..24).map(|_| self.below(256) as f32 / 255.0).collect();
        let pixels = Pixels { width: 4, height: 2, channels: 3, values };
        let bytes = if float {
            let values = pixels.values.iter().flat_map(|value| value.to_le_bytes());
            [b"PF\n4 2\n-1.0\n".to_vec(), values.collect()].concat()
        } else {
            image::write::png(&pixels, 8).expect("an image")
        };
        let ending = if float { "pfm" } else { "png" };
        let Loaded { info, file, peak, .. } = image::load(ending, &bytes, u64::MAX).expect("an image");
        let linear = float || self.below(2) == 0;
        let (encoding, peak) = if linear { (Encoding::Linear, peak) } else { (Encoding::Srgb, image::decoded(peak)) };
        let factor = if float { [1.0; 3] } else { self.pick(&[[1.0; 3], [0.5; 3], [0.1, 0.2, 1.0 / 3.0]]) };
        Texture { name, file, image: info, encoding, peak, factor }
    }

    fn bsdf(&mut self, textures: &[Handle<Texture>]) -> Bsdf {
        let paint = |dice: &mut Self| -> ColorOrTexture {
            match textures {
                [first, ..] if dice.below(3) == 0 => {
                    ColorOrTexture::Texture(dice.pick(&[*first, textures[textures.len() - 1]]))
                }
                _ => dice.color(Meaning::Share, 1.0).into(),
            }
        };
        match self.below(6) {
            0 => Bsdf::Diffuse { reflectance: paint(self) },
            1 => {
                let (eta, k) = (self.color(Meaning::Index, 3.0), self.color(Meaning::Index, 4.0));
                Bsdf::Conductor { eta, k, alpha: self.share() }
            }
            2 => Bsdf::Dielectric { interior: self.positive(), exterior: self.positive(), alpha: self.share() },
            3 => Bsdf::Mirror { reflectance: self.color(Meaning::Share, 1.0) },
            4 => Bsdf::Plastic { reflectance: paint(self), ior: 1.0 + self.positive().max(1e-6), alpha: self.share() },
            _ => {
                let (base, ior) = (paint(self), 1.0 + self.positive().max(1e-6));
                Bsdf::Principled { base, metallic: self.share(), roughness: self.share(), ior }
            }
        }
    }

    fn material(&mut self, name: String, textures: &[Handle<Texture>]) -> Material {
        let made = Material::new(name, self.bsdf(textures));
        let sides = if self.below(4) == 0 && !made.bsdf.is_clear() { Sides::Front } else { Sides::Both };
        Material { sides, ..made }
    }

    fn light(&mut self, sky: Option<Handle<Texture>>) -> LightKind {
        let strength = self.color(Meaning::Light, 40.0);
        match (self.below(3), sky) {
            (_, Some(image)) => {
                let turn = self.transform();
                let turn = if turn.is_rotation() { turn } else { Affine::rotation([0.6, 0.0, 0.8], 12.3) };
                let tint = if matches!(strength, Color::Spectrum(_)) { Color::Grey(0.7) } else { strength };
                LightKind::Environment { radiance: ColorOrTexture::Texture(image), tint, turn }
            }
            (0, None) => LightKind::Point { position: self.vector(), intensity: strength },
            (1, None) => {
                let (position, angle) = (self.vector(), 1.0 + 80.0 * self.share());
                let target = position.map(|part| part + 1.0);
                let target = if target == position { [position[0] * 2.0 + 1.0; 3] } else { target };
                let inner = angle * self.pick(&[1.0, 0.5, 1.0 / 3.0]);
                LightKind::Spot { position, target, intensity: strength, angle, inner }
            }
            _ => LightKind::Directional { direction: self.direction(), irradiance: strength },
        }
    }

    fn shapes(&mut self, meshes: &Arena<Mesh>, materials: &Arena<Material>) -> Arena<Shape> {
        let mut shapes = Arena::default();
        for at in 0..self.below(4) {
            let mesh = self.pick(&meshes.iter().collect::<Vec<_>>());
            let fits = |material: &Material| mesh.1.uvs.is_some() || material.bsdf.texture().is_none();
            let good: Vec<_> =
                materials.iter().filter(|(_, material)| fits(material)).map(|(handle, _)| handle).collect();
            if good.is_empty() {
                continue;
            }
            let material = self.pick(&good);
            let emission = (self.below(3) == 0).then(|| Emission { radiance: self.color(Meaning::Light, 30.0) });
            let own = self.name("shape", at);
            let name = self.pick(&[own.clone(), own, mesh.1.name.clone(), materials[material].name.clone()]);
            let taken = !self.wild && shapes.values().any(|shape: &Shape| shape.name == name);
            let name = if taken { format!("shape {at} again") } else { name };
            let shape = Shape { name, mesh: mesh.0, transform: self.transform(), material, emission };
            shapes.push(shape, Origin::Made);
        }
        shapes
    }

    fn instances(&mut self, groups: &Arena<Group>) -> Arena<Instance> {
        let mut instances = Arena::default();
        for at in 0..self.below(3) {
            let all: Vec<_> = groups.iter().map(|(handle, _)| handle).collect();
            if all.is_empty() {
                break;
            }
            let group = self.pick(&all);
            let maps: Arc<[Affine]> = (0..1 + self.below(3)).map(|_| self.transform()).collect();
            let places = if self.below(3) == 0 { Places::Many(maps) } else { Places::One(maps[0]) };
            instances.push(Instance { name: self.name("placed", at), group, places }, Origin::Made);
        }
        instances
    }

    fn documentation(&mut self) -> Documentation {
        let long = "a sentence that goes on and on, ".repeat(12).trim().to_owned();
        let similar = Similar { scene: "other".to_owned(), reason: "with \"quotes\" and \\ and\na line".to_owned() };
        Documentation {
            brief: self.pick(&["Short.".to_owned(), long]),
            full: self.pick(&["", "One.\n\n- two\n    three\n/// four", "Größe `x`."]).to_owned(),
            paths: self.pick(&[vec![], vec!["LDE".to_owned(), "LS+DE".to_owned()]]),
            similar: self.pick(&[vec![], vec![similar]]),
            comments: self.pick(&["", "tab\tand \u{1} bell"]).to_owned(),
            source: self.pick(&["", "there"]).to_owned(),
            license: self.pick(&["", "MIT"]).to_owned(),
            parameters: Vec::new(),
        }
    }

    fn camera(&mut self, name: Option<String>) -> Camera {
        let (mut eye, near) = (self.vector(), self.positive());
        // Most scenes should keep their camera, so that they are read again.
        if self.wild && self.below(4) != 0 {
            eye = [1.0, 2.0, 3.0];
        }
        let far = near * 2.0;
        let (near, far) = self.pick(&[(None, None), (Some(near), None), (Some(near), Some(far)), (None, Some(far))]);
        let up = self.pick(&[[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.1, 0.2, 3.0]]);
        let target = [eye[0] * 2.0 + 5.0, eye[1] + eye[1].abs() + 1.0, eye[2] * 0.5 - 1.0];
        Camera { name, eye, target, up, fov_x: 1.0 + 170.0 * self.share(), near, far }
    }

    pub fn scene(&mut self) -> Scene {
        let made = Origin::Made;
        let (mut meshes, mut textures, mut materials) = (Arena::default(), Arena::default(), Arena::default());
        for at in 0..1 + self.below(3) {
            let name = self.name("mesh", at);
            meshes.push(self.geometry().into_mesh(name), made.clone());
        }
        let images: Vec<_> = (0..self.below(3))
            .map(|at| {
                let texture = self.texture(format!("image_{at}"), false);
                textures.push(texture, made.clone())
            })
            .collect();
        for at in 0..1 + self.below(3) {
            let name = self.name("paint", at);
            let material = self.material(name, &images);
            materials.push(material, made.clone());
        }
        let black = Bsdf::Diffuse { reflectance: Color::BLACK.into() };
        materials.push(Material::new("black", black), made.clone());
        let mut groups = Arena::default();
        for at in 0..self.below(3) {
            let (shapes, instances) = (self.shapes(&meshes, &materials), self.instances(&groups));
            groups.push(Group { name: self.name("group", at), shapes, instances }, made.clone());
        }
        let shapes = self.shapes(&meshes, &materials);
        let instances = self.instances(&groups);
        let mut lights = Arena::default();
        for at in 0..self.below(3) {
            let kind = self.light(None);
            lights.push(LightSource { name: self.name("light", at), kind }, made.clone());
        }
        match self.below(4) {
            0 => {
                let texture = self.texture("sky".to_owned(), true);
                let image = textures.push(texture, made.clone());
                lights.push(LightSource { name: "sky".to_owned(), kind: self.light(Some(image)) }, made.clone());
            }
            1 => {
                let kind = LightKind::environment(self.color(Meaning::Light, 2.0).into());
                lights.push(LightSource { name: "sky".to_owned(), kind }, made.clone());
            }
            _ => {}
        }
        let mut cameras = Arena::default();
        let names =
            self.pick(&[vec![None], vec![Some("top".to_owned())], vec![Some("a b".to_owned()), Some("X".to_owned())]]);
        for name in names {
            cameras.push(self.camera(name), made.clone());
        }
        let size = self.positive();
        let filter = self.pick(&[
            Filter::Box { radius: 0.5 },
            Filter::Box { radius: size },
            Filter::Gaussian { stddev: size, radius: 4.0 * size },
            Filter::Gaussian { stddev: 0.5, radius: size },
        ]);
        let word = self.pick(&Integrator::WORDS);
        let max_depth = 1 + self.below(1000) as u32;
        let sampler = self.pick(&Sampler::WORDS);
        let (samples, seed) = (1 + self.below(99) as u32, self.pick(&[0, 1, u32::MAX]));
        Scene {
            name: self.pick(&["scene_1", "a-b", "mesh"]).to_owned(),
            origin: made,
            documentation: self.documentation(),
            meshes,
            textures,
            materials,
            shapes,
            lights,
            groups,
            instances,
            cameras,
            film: Film { width: 1 + self.below(65_536) as u32, height: 7, filter },
            integrator: Integrator::of_word(word, max_depth).expect("a word"),
            sampler: Sampler::of_word(sampler, samples, seed).expect("a word"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]

    #[test]
    fn a_scene_is_itself_after_printing(numbers in prop::collection::vec(any::<u64>(), 0..400)) {
        let scene = Dice { numbers: &numbers, at: 0, wild: false }.scene();
        let printed = print(&scene, &Options::default());
        let formatted = crate::format::format(&mut Sources::default(), "a.lts", &printed.text).expect("a good text");
        prop_assert_eq!(&formatted, &printed.text);
        prop_assert!(printed.findings.is_empty(), "{:?}\n{}", printed.findings, printed.text);
        let again = read(&printed);
        prop_assert_eq!(difference(&scene, &again), None, "{}", printed.text);
    }

    #[test]
    fn a_scene_that_should_not_be_is_told_and_still_written(numbers in prop::collection::vec(any::<u64>(), 0..300)) {
        let scene = Dice { numbers: &numbers, at: 0, wild: true }.scene();
        let printed = print(&scene, &Options::default());
        // Without a camera it is for people to add one.
        if printed.text.contains("\ncamera") {
            let again = read(&printed);
            if printed.findings.is_empty() {
                prop_assert_eq!(difference(&scene, &again), None, "{}", printed.text);
            }
        }
    }
}
