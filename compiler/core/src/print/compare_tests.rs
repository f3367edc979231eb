//! What tests of this folder share: whether two scenes are equal as `print` promises, and a scene that is written and read again.

use std::collections::BTreeMap;

use crate::diag::{Severity, Sources};
use crate::eval::{Overrides, evaluate};
use crate::files::{MemoryFiles, VPath};
use crate::ir::{
    Arena, Bsdf, Color, ColorOrTexture, Documentation, Group, Handle, Instance, LightKind, Material, Mesh, Scene,
    Shape, Texture,
};

use super::Printed;

/// The scene that a text means, with all its files in memory.
pub(super) fn read(printed: &Printed<'_>) -> Scene {
    let mut files = MemoryFiles::default();
    for (path, content) in &printed.files {
        files.insert(path.clone(), content.bytes());
    }
    files.insert(printed.file(), printed.text.clone());
    evaluated(&files, &printed.file())
}

/// The scene at a path.
pub(super) fn evaluated(files: &MemoryFiles, path: &str) -> Scene {
    let path = VPath::resolve("", path).expect("a path");
    let mut sources = Sources::default();
    let evaluated = evaluate(files, &mut sources, &path, &Overrides::default());
    let text = files_text(files, &path);
    let bad: Vec<_> = evaluated.findings.iter().filter(|finding| finding.severity >= Severity::Warn).collect();
    assert!(bad.is_empty(), "{bad:#?}\n{text}");
    evaluated.scene.unwrap_or_else(|| panic!("no scene in\n{text}"))
}

fn files_text(files: &MemoryFiles, path: &VPath) -> String {
    let bytes = crate::files::Files::read(files, path, u64::MAX).expect("it is there");
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The first difference of two scenes; none where they are equal.
pub(super) fn difference(one: &Scene, other: &Scene) -> Option<String> {
    let mut pairs =
        Pairs { one, other, meshes: Twins::default(), textures: Twins::default(), groups: Twins::default() };
    pairs.scenes().err()
}

/// Which handle of one scene is which of the other.
struct Twins<T> {
    there: BTreeMap<Handle<T>, Handle<T>>,
    back: BTreeMap<Handle<T>, Handle<T>>,
}

impl<T> Default for Twins<T> {
    fn default() -> Self {
        Self { there: BTreeMap::new(), back: BTreeMap::new() }
    }
}

impl<T> Twins<T> {
    /// Whether the two are met for the first time; an error where they have others.
    fn meet(&mut self, one: Handle<T>, other: Handle<T>) -> Result<bool, String> {
        match (self.there.get(&one), self.back.get(&other)) {
            (None, None) => {
                self.there.insert(one, other);
                self.back.insert(other, one);
                Ok(true)
            }
            (Some(known), Some(_)) if *known == other => Ok(false),
            _ => Err(format!("{one:?} and {other:?} are shared otherwise")),
        }
    }
}

struct Pairs<'s> {
    one: &'s Scene,
    other: &'s Scene,
    meshes: Twins<Mesh>,
    textures: Twins<Texture>,
    groups: Twins<Group>,
}

type Equal = Result<(), String>;

fn same<T: PartialEq + std::fmt::Debug>(what: &str, one: &T, other: &T) -> Equal {
    if one == other { Ok(()) } else { Err(format!("{what}: {one:?} is {other:?}")) }
}

impl Pairs<'_> {
    fn scenes(&mut self) -> Equal {
        let (one, other) = (self.one, self.other);
        same("name", &one.name, &other.name)?;
        let plain = |documentation: &Documentation| Documentation { parameters: Vec::new(), ..documentation.clone() };
        same("documentation", &plain(&one.documentation), &plain(&other.documentation))?;
        same("film", &one.film, &other.film)?;
        same("integrator", &one.integrator, &other.integrator)?;
        same("sampler", &one.sampler, &other.sampler)?;
        same("cameras", &items(&one.cameras), &items(&other.cameras))?;
        self.shapes(&one.shapes, &other.shapes)?;
        self.instances(&one.instances, &other.instances)?;
        same("lights", &one.lights.len(), &other.lights.len())?;
        for (a, b) in one.lights.values().zip(other.lights.values()) {
            same("light", &a.name, &b.name)?;
            self.lights(&a.kind, &b.kind).map_err(|error| format!("light {}: {error}", a.name))?;
        }
        Ok(())
    }

    fn lights(&mut self, one: &LightKind, other: &LightKind) -> Equal {
        let sky = |kind: &LightKind| match kind {
            LightKind::Environment { radiance, tint, turn } => Some((radiance.clone(), tint.clone(), *turn)),
            LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Directional { .. } => None,
        };
        let (Some((image, tint, turn)), Some((other_image, other_tint, other_turn))) = (sky(one), sky(other)) else {
            return same("kind", one, other);
        };
        same("tint", &tint, &other_tint)?;
        match (image, other_image) {
            (ColorOrTexture::Texture(a), ColorOrTexture::Texture(b)) => {
                same("turn", &turn, &other_turn)?;
                self.textures(a, b)
            }
            (a, b) => same("radiance", &a, &b),
        }
    }

    fn shapes(&mut self, one: &Arena<Shape>, other: &Arena<Shape>) -> Equal {
        same("shapes", &names(one, |shape| &shape.name), &names(other, |shape| &shape.name))?;
        for (a, b) in one.values().zip(other.values()) {
            self.shape(a, b).map_err(|error| format!("shape {}: {error}", a.name))?;
        }
        Ok(())
    }

    fn shape(&mut self, one: &Shape, other: &Shape) -> Equal {
        same("transform", &one.transform, &other.transform)?;
        same("emission", &one.emission, &other.emission)?;
        self.meshes(one.mesh, other.mesh)?;
        self.materials(one.material, other.material)
    }

    fn instances(&mut self, one: &Arena<Instance>, other: &Arena<Instance>) -> Equal {
        same("instances", &names(one, |instance| &instance.name), &names(other, |instance| &instance.name))?;
        for (a, b) in one.values().zip(other.values()) {
            same("places", &a.places, &b.places)?;
            if self.groups.meet(a.group, b.group)? {
                let (inner, other_inner) = (&self.one.groups[a.group], &self.other.groups[b.group]);
                same("group", &inner.name, &other_inner.name)?;
                self.shapes(&inner.shapes, &other_inner.shapes)?;
                self.instances(&inner.instances, &other_inner.instances)?;
            }
        }
        Ok(())
    }

    fn meshes(&mut self, one: Handle<Mesh>, other: Handle<Mesh>) -> Equal {
        if !self.meshes.meet(one, other)? {
            return Ok(());
        }
        let (a, b) = (&self.one.meshes[one], &self.other.meshes[other]);
        same("mesh", &a.name, &b.name)?;
        let bits = |mesh: &Mesh| {
            let parts = [Some(&mesh.positions), mesh.normals.as_ref()].map(|part| part.map(|part| part.as_flattened()));
            let uvs = mesh.uvs.as_ref().map(|uvs| uvs.as_flattened());
            [parts[0], parts[1], uvs].map(|part| part.map(|part| part.iter().map(|x| x.to_bits()).collect::<Vec<_>>()))
        };
        if bits(a) == bits(b) && a.triangles == b.triangles { Ok(()) } else { Err(format!("mesh {} differs", a.name)) }
    }

    fn materials(&mut self, one: Handle<Material>, other: Handle<Material>) -> Equal {
        let (a, b) = (&self.one.materials[one], &self.other.materials[other]);
        same("material", &a.name, &b.name)?;
        match (a.bsdf.texture(), b.bsdf.texture()) {
            (Some(image), Some(other_image)) => {
                self.textures(image, other_image)?;
                same("surface", &a.bsdf, &b.bsdf.with_texture(image))
            }
            (None, None) => same::<Bsdf>("surface", &a.bsdf, &b.bsdf),
            _ => Err("a texture in one of the two".to_owned()),
        }
    }

    fn textures(&mut self, one: Handle<Texture>, other: Handle<Texture>) -> Equal {
        if self.textures.meet(one, other)? {
            same("texture", &self.one.textures[one], &self.other.textures[other])?;
        }
        Ok(())
    }
}

fn items<T>(arena: &Arena<T>) -> Vec<&T> {
    arena.values().collect()
}

fn names<'a, T>(arena: &'a Arena<T>, name: impl Fn(&'a T) -> &'a String) -> Vec<&'a String> {
    arena.values().map(name).collect()
}

#[test]
fn differences_are_seen() {
    let mut files = MemoryFiles::default();
    files.insert("a.lts", super::tests::BALL);
    let one = evaluated(&files, "a.lts");
    assert_eq!(difference(&one, &one.clone()), None);
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut other = one.clone();
        change(&mut other);
        difference(&one, &other).expect("they differ")
    };
    let first = one.shapes.iter().next().expect("a shape").0;
    assert!(changed(&|scene| scene.name.push('x')).starts_with("name"));
    assert!(changed(&|scene| scene.film.width += 1).starts_with("film"));
    assert!(changed(&|scene| scene.shapes[first].transform.rows[0][3] += 1e-9).contains("transform"));
    assert!(
        changed(&|scene| scene
            .materials
            .iter_mut()
            .for_each(|(_, made)| made.bsdf = Bsdf::Mirror { reflectance: Color::Grey(0.5) }))
        .contains("surface")
    );
}
