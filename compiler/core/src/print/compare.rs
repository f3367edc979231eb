//! Whether two scenes are equal as printing promises: what people see of them, not how their arenas are filled.

use std::collections::BTreeMap;

use crate::ir::{
    Arena, Bsdf, ColorOrTexture, Documentation, Group, Handle, Instance, LightKind, Material, Mesh, Scene, Shape,
    Texture,
};

/// The first difference of two scenes, in words; none where they are equal as [`print`](fn@super::print) says it.
pub fn difference(one: &Scene, other: &Scene) -> Option<String> {
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
        let Scene { name, origin: _, documentation, meshes: _, textures: _, materials: _, shapes, lights, .. } = one;
        let Scene { groups: _, instances, cameras, film, integrator, sampler, .. } = one;
        same("name", name, &other.name)?;
        let plain = |documentation: &Documentation| Documentation { parameters: Vec::new(), ..documentation.clone() };
        same("documentation", &plain(documentation), &plain(&other.documentation))?;
        same("film", film, &other.film)?;
        same("integrator", integrator, &other.integrator)?;
        same("sampler", sampler, &other.sampler)?;
        same("cameras", &items(cameras), &items(&other.cameras))?;
        self.shapes(shapes, &other.shapes)?;
        self.instances(instances, &other.instances)?;
        same("lights", &lights.len(), &other.lights.len())?;
        for (a, b) in lights.values().zip(other.lights.values()) {
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
        let Shape { name: _, mesh, transform, material, emission } = one;
        same("transform", transform, &other.transform)?;
        same("emission", emission, &other.emission)?;
        self.meshes(*mesh, other.mesh)?;
        self.materials(*material, other.material)
    }

    fn instances(&mut self, one: &Arena<Instance>, other: &Arena<Instance>) -> Equal {
        same("instances", &names(one, |instance| &instance.name), &names(other, |instance| &instance.name))?;
        for (a, b) in one.values().zip(other.values()) {
            let Instance { name: _, group, places } = a;
            same("places", places, &b.places)?;
            if self.groups.meet(*group, b.group)? {
                let Group { name, shapes, instances } = &self.one.groups[*group];
                let other = &self.other.groups[b.group];
                same("group", name, &other.name)?;
                self.shapes(shapes, &other.shapes)?;
                self.instances(instances, &other.instances)?;
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
        let Mesh { name: _, positions, normals, uvs, triangles } = a;
        let equal = bits(Some(positions), Some(&b.positions))
            && bits(normals.as_deref(), b.normals.as_deref())
            && bits(uvs.as_deref(), b.uvs.as_deref())
            && *triangles == b.triangles;
        if equal { Ok(()) } else { Err(format!("the numbers of the mesh {} differ", a.name)) }
    }

    fn materials(&mut self, one: Handle<Material>, other: Handle<Material>) -> Equal {
        let (a, b) = (&self.one.materials[one], &self.other.materials[other]);
        same("material", &a.name, &b.name)?;
        same("sides", &a.sides, &b.sides)?;
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

/// Whether two arrays have the same bits.
fn bits<const N: usize>(one: Option<&Vec<[f32; N]>>, other: Option<&Vec<[f32; N]>>) -> bool {
    let (Some(one), Some(other)) = (one, other) else { return one.is_none() && other.is_none() };
    let mut pairs = one.as_flattened().iter().zip(other.as_flattened());
    one.len() == other.len() && pairs.all(|(a, b)| a.to_bits() == b.to_bits())
}

fn items<T>(arena: &Arena<T>) -> Vec<&T> {
    arena.values().collect()
}

fn names<'a, T>(arena: &'a Arena<T>, name: impl Fn(&'a T) -> &'a String) -> Vec<&'a String> {
    arena.values().map(name).collect()
}
