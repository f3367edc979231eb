//! What can be taken out of a scene, or made plainer.

use std::ops::Range;

use ltsc_core::ir::{Arena, Bsdf, Color, ColorOrTexture, Handle, Material, Scene};

/// Something that can be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thing {
    Shape(usize),
    Instance(usize),
    Light(usize),
}

/// All things of a scene: surfaces, instances of groups, lights without a surface.
pub fn things(scene: &Scene) -> Vec<Thing> {
    let shapes = (0..scene.shapes.len()).map(Thing::Shape);
    let instances = (0..scene.instances.len()).map(Thing::Instance);
    shapes.chain(instances).chain((0..scene.lights.len()).map(Thing::Light)).collect()
}

/// The scene without some of its [`things`].
pub fn without(scene: &Scene, out: Range<usize>) -> Scene {
    let all = things(scene);
    let gone = &all[out.start.min(all.len())..out.end.min(all.len())];
    let mut scene = scene.clone();
    scene.shapes = kept(&scene.shapes, |at| !gone.contains(&Thing::Shape(at)));
    scene.instances = kept(&scene.instances, |at| !gone.contains(&Thing::Instance(at)));
    scene.lights = kept(&scene.lights, |at| !gone.contains(&Thing::Light(at)));
    scene
}

/// Nothing points at shapes, instances or lights of a scene, so that their places may change.
fn kept<T: Clone>(arena: &Arena<T>, keep: impl Fn(usize) -> bool) -> Arena<T> {
    let mut new = Arena::default();
    for (at, (origin, item)) in arena.entries().enumerate().filter(|(at, _)| keep(*at)) {
        let _number = at;
        new.push(item.clone(), origin.clone());
    }
    new
}

/// A way to make a scene plainer.
pub struct Plainer {
    /// What it does, in words.
    pub what: String,
    /// Does it.
    pub make: Box<dyn Fn(&Scene) -> Scene>,
}

/// Each material that is used as a grey diffuse one.
pub fn plainer(scene: &Scene) -> Vec<Plainer> {
    let mut used: Vec<usize> = scene.surfaces().map(|(_, shape)| shape.material.index()).collect();
    used.sort_unstable();
    used.dedup();
    let handles: Vec<(Handle<Material>, &Material)> = scene.materials.iter().collect();
    let of = |(handle, material): (Handle<Material>, &Material)| {
        let name = if material.name.is_empty() { material.bsdf.word() } else { &material.name };
        Plainer {
            what: format!("the material `{name}` is a grey diffuse one"),
            make: Box::new(move |scene| {
                let mut scene = scene.clone();
                for (own, material) in scene.materials.iter_mut() {
                    if own == handle {
                        material.bsdf = Bsdf::Diffuse { reflectance: ColorOrTexture::Color(Color::Grey(0.5)) };
                    }
                }
                scene
            }),
        }
    };
    let plain = |material: &Material| matches!(&material.bsdf, Bsdf::Diffuse { reflectance: ColorOrTexture::Color(color) } if *color == Color::Grey(0.5));
    handles
        .into_iter()
        .filter(|(handle, material)| used.contains(&handle.index()) && !plain(material))
        .map(of)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltsc_core::diag::Sources;
    use ltsc_core::files::{MemoryFiles, VPath};
    use ltsc_core::pipeline::{self, Options};

    #[test]
    fn things_go_and_the_rest_stays() {
        let text = "lts 1\n/// A.\n///\n/// B.\nscene one { paths: [\"LDE\"] }\ncamera = perspective(eye: (0, -10, 0), target: (0, 0, \
                    0), fov_x: 45deg)\nfilm = image(8, 8)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
                    material wall = mirror(0.5)\nshape a = box(size: 1) with wall\nshape b = box(size: 1) |> translate(3, 0, 0) with \
                    diffuse(0.2)\nemitter lamp = rectangle(x: -1..1, y: -1..1, z: 5, normal: -Z) with radiance(10)\nemitter sun = \
                    point(position: (0, 0, 9), intensity: 3)\n";
        let mut files = MemoryFiles::default();
        files.insert("one.lts", text);
        let path = VPath::resolve("", "one.lts").expect("a path");
        let checked = pipeline::check(&files, &mut Sources::default(), &path, &Options::default());
        let scene = checked.scene.unwrap_or_else(|| panic!("{:?}", checked.findings));
        assert_eq!(things(&scene).len(), 4);
        let names = |scene: &Scene| scene.shapes.values().map(|shape| shape.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&without(&scene, 0..1)), ["b", "lamp"]);
        assert_eq!((names(&without(&scene, 1..9)), without(&scene, 1..9).lights.len()), (vec!["a".to_owned()], 0));
        assert!(without(&scene, 4..9) == scene);
        let plain = plainer(&scene);
        assert!(
            plain.iter().any(|one| one.what.contains("`wall`")),
            "{:?}",
            plain.iter().map(|one| &one.what).collect::<Vec<_>>()
        );
        let made = (plain[0].make)(&scene);
        assert!(made.materials.values().any(|material| matches!(material.bsdf, Bsdf::Diffuse { .. })) && made != scene);
    }
}
