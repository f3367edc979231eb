//! Surfaces of the scene and of a reading side by side, in their order.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::look::{self, Back, Materials, off};
use super::measure::{Pair, area_factor, difference};
use super::vertices::{self, PLACE, Placed, same_place};
use super::{Asked, Audit, Found, Lost, Measure, Meshes, emits, inexact, measured, unsupported};
use crate::capability::{self, Feature};
use crate::formats::Target;
use crate::formats::shared::images::{self, Forms, Use as Purpose};
use crate::formats::shared::reading::{Front, Item, MeshPlace, Model, Paint, Picture, Reading, Rgb, Use};
use crate::ir::{
    Affine, Bsdf, Color, ColorOrTexture, Emission, Handle, Instance, Material, Mesh, Shape, Vec3, length, sub,
};
use crate::mesh::Geometry;

/// What is placed at once: a shape, or a group.
struct Block<'b, T> {
    /// What it is: equal for the same group.
    key: usize,
    map: Affine,
    parts: &'b [T],
}

impl<T> Clone for Block<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Block<'_, T> {}

pub(super) fn compare(
    asked: &Asked<'_>,
    target: &Target,
    reading: &Reading,
    meshes: &mut Meshes<'_>,
    audit: &mut Audit,
    found: &mut Found,
) {
    let measures = measured(reading, meshes, found);
    let mut walk = Walk {
        asked,
        target,
        reading,
        measures,
        same_meshes: BTreeMap::new(),
        same_materials: BTreeSet::new(),
        same_groups: BTreeSet::new(),
        emitter: 0,
        audit,
        found,
    };
    let plain = Affine::IDENTITY;
    let shapes = asked.shapes.iter().enumerate();
    let own = shapes.map(|(at, shape)| Block { key: at, map: plain, parts: std::slice::from_ref(shape) });
    let groups = asked.scene.instances.values().flat_map(|instance| {
        let Instance { name: _, group, places } = instance;
        let (key, parts) = (asked.shapes.len() + group.index(), asked.groups[group.index()].as_slice());
        places.maps().iter().map(move |map| Block { key, map: *map, parts })
    });
    let said = |at: usize| match &reading.items[at] {
        Item::Shape(one) => Block { key: at, map: plain, parts: std::slice::from_ref(one) },
        Item::Instance { name: _, group, transform } => {
            let parts = reading.groups.get(*group).map_or(&[][..], Vec::as_slice);
            Block { key: reading.items.len() + group, map: *transform, parts }
        }
    };
    if reading.gathered {
        let order = by_names(asked, reading);
        walk.all(own.chain(groups), order.into_iter().map(said));
    } else {
        walk.all(own.chain(groups), (0..reading.items.len()).map(said));
    }
}

/// The items of a reading in the order of the scene, as their names say; those with other names come last.
fn by_names<'r>(asked: &'r Asked<'_>, reading: &'r Reading) -> Vec<usize> {
    let mut places: BTreeMap<(Cow<'r, str>, bool), VecDeque<usize>> = BTreeMap::new();
    let shapes = asked.shapes.iter().map(|shape| (Cow::Borrowed(shape.name.as_str()), shape.emission.is_some()));
    let placed = asked.scene.instances.values().flat_map(Instance::named).map(|(name, _)| (name, false));
    for (at, key) in shapes.chain(placed).enumerate() {
        places.entry(key).or_default().push_back(at);
    }
    let place = |item: &'r Item| {
        let key = match item {
            Item::Shape(one) => (Cow::Borrowed(one.name.as_str()), one.emission.is_some()),
            Item::Instance { name, group: _, transform: _ } => (Cow::Borrowed(name.as_str()), false),
        };
        places.get_mut(&key).and_then(VecDeque::pop_front).unwrap_or(usize::MAX)
    };
    let found: Vec<usize> = reading.items.iter().map(place).collect();
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by_key(|at| found[*at]);
    order
}

/// A side of the walk: blocks, and the place within the one at hand.
struct Side<'b, T, I> {
    blocks: I,
    now: Option<Block<'b, T>>,
    at: usize,
}

impl<'b, T, I: Iterator<Item = Block<'b, T>>> Side<'b, T, I> {
    fn new(blocks: I) -> Self {
        let mut side = Self { blocks, now: None, at: 0 };
        side.skip();
        side
    }

    /// Goes to the next block that holds something.
    fn skip(&mut self) {
        self.at = 0;
        self.now = self.blocks.find(|block| !block.parts.is_empty());
    }

    fn step(&mut self) {
        self.at += 1;
        if self.now.is_none_or(|block| self.at >= block.parts.len()) {
            self.skip();
        }
    }

    /// How many parts are left.
    fn count(&mut self) -> u64 {
        let mut left = self.now.map_or(0, |block| (block.parts.len() - self.at) as u64);
        while self.now.is_some() {
            self.skip();
            left += self.now.map_or(0, |block| block.parts.len() as u64);
        }
        left
    }
}

struct Walk<'w, 's, 'f> {
    asked: &'w Asked<'s>,
    target: &'w Target,
    reading: &'w Reading,
    measures: Vec<Option<Measure>>,
    /// Whether meshes of the scene and of the reading are the same.
    same_meshes: BTreeMap<(usize, usize), bool>,
    /// Whether materials were compared already; the last says whether the surface emits.
    same_materials: BTreeSet<(usize, usize, bool)>,
    /// Groups that hold the same, by their keys.
    same_groups: BTreeSet<(usize, usize)>,
    /// The next of the scene's emitters.
    emitter: usize,
    audit: &'w mut Audit,
    found: &'f mut Found,
}

impl<'w> Walk<'w, '_, '_> {
    fn all<'b>(
        &mut self,
        wanted: impl Iterator<Item = Block<'b, &'b Shape>>,
        said: impl Iterator<Item = Block<'w, Use>>,
    ) {
        let (mut wanted, mut said) = (Side::new(wanted), Side::new(said));
        self.audit.said.area = Some(0.0);
        self.audit.said.instances = self.instances();
        while let (Some(one), Some(other)) = (wanted.now, said.now) {
            let whole = wanted.at == 0 && said.at == 0 && one.parts.len() == other.parts.len() && one.parts.len() > 1;
            if whole && self.same_group(&one, &other) {
                let area = self.group_area(&other);
                self.add_area(other.parts.len() as u64, area);
                wanted.skip();
                said.skip();
                continue;
            }
            self.pair(wanted.at, &one, other.parts.get(said.at), &other.map);
            wanted.step();
            said.step();
        }
        let (missing, extra) = (wanted.count(), said.count());
        let (surfaces, all) = (self.asked.sums.surfaces, self.audit.said.surfaces + extra);
        if missing > 0 || extra > 0 {
            self.found.differs(format!("there are {all} surfaces instead of {surfaces}"));
            self.audit.said.surfaces = all;
        }
        self.rest();
        let (emitters, wanted) = (self.audit.said.emitters, self.asked.sums.emitters);
        if emitters != wanted {
            self.found.differs(format!("there are {emitters} emitting surfaces instead of {wanted}"));
        }
    }

    /// Materials that the file gives no surface: each must be one of the scene's.
    fn rest(&mut self) {
        let mut used = vec![false; self.reading.materials.len()];
        let own = self.reading.items.iter().filter_map(|item| match item {
            Item::Shape(one) => Some(one),
            Item::Instance { name: _, group: _, transform: _ } => None,
        });
        for one in own.chain(self.reading.groups.iter().flatten()) {
            if let Some(used) = used.get_mut(one.material) {
                *used = true;
            }
        }
        // Parts of others are among them, such as the two of a blend.
        let whole = |model: &Model| match model {
            Model::Mix { share: _, parts: _ } => true,
            Model::Diffuse { reflectance: _ }
            | Model::Conductor { fresnel: _, tint: _, alpha: _ }
            | Model::Dielectric { eta: _, alpha: _ }
            | Model::Coated { base: _, inside: _, ior: _, alpha: _ }
            | Model::Principled { base: _, metallic: _, alpha: _, specular: _, ceiling: _ } => false,
        };
        let mixed = self.reading.materials.iter().any(|surface| whole(&surface.model));
        for (surface, _) in self.reading.materials.iter().zip(used).filter(|(_, used)| !used && !mixed) {
            let known = self.asked.scene.materials.values().any(|Material { name: _, bsdf, sides: _ }| {
                let capped = if self.reading.capped { capped(bsdf) } else { None };
                let bsdf = capped.as_ref().unwrap_or(bsdf);
                let excused = self.excused(bsdf, &surface.model);
                let factor = self.factor_beside(bsdf);
                look::difference(&Materials { bsdf, surface, back: Back::Either, excused, factor }).is_none()
                    && self.image_differs(bsdf, &surface.model).is_none()
            });
            if !known {
                self.found
                    .differs(format!("material `{}`, which no surface has, is none of the scene's", surface.name));
            }
        }
    }

    fn instances(&self) -> u64 {
        self.reading.items.iter().filter(|item| matches!(item, Item::Instance { .. })).count() as u64
    }

    fn add_area(&mut self, surfaces: u64, area: Option<f64>) {
        self.audit.said.surfaces += surfaces;
        self.audit.said.area = self.audit.said.area.and_then(|sum| Some(sum + area?));
    }

    fn group_area(&self, block: &Block<'_, Use>) -> Option<f64> {
        let outer = area_factor(&block.map)?;
        let own = |one: &Use| Some(self.measures.get(one.mesh)?.as_ref()?.area * area_factor(&one.transform)?);
        block.parts.iter().map(|one| Some(own(one)? * outer)).sum()
    }

    /// Whether two groups at their places are the same, so that their parts need no look.
    fn same_group(&mut self, one: &Block<'_, &Shape>, other: &Block<'_, Use>) -> bool {
        let known = (one.key, other.key);
        if !self.same_groups.contains(&known) {
            for (shape, said) in one.parts.iter().zip(other.parts) {
                let Shape { name: _, mesh, transform, material: _, emission } = shape;
                let emit = emission.is_some() || said.emission.is_some();
                if emit || !self.same_part((*mesh, transform), (said.mesh, &said.transform)) {
                    return false;
                }
            }
            for (shape, said) in one.parts.iter().zip(other.parts) {
                self.material(shape, said);
            }
            self.same_groups.insert(known);
        }
        // Parts lie where the outer maps take the corners of their boxes.
        one.parts.iter().all(|shape| {
            let inner = &shape.transform;
            let corners = self.asked.measures[shape.mesh.index()].corners();
            corners.iter().all(|corner| same_place(&one.map, &other.map, inner.point(*corner), self.share()))
        })
    }

    /// What a map of the file may lose of what it makes.
    fn share(&self) -> f64 {
        if self.reading.gathered { PLACE } else { super::TEXT }
    }

    /// Whether a mesh of the scene lies where one of the reading does, with all its vertices.
    fn same_part(&mut self, (mesh, wanted): (Handle<Mesh>, &Affine), (said, map): (usize, &Affine)) -> bool {
        match self.reading.meshes.get(said).map(|source| &source.place) {
            // The format may have moved its vertices.
            Some(MeshPlace::Here(geometry)) => self.moved(mesh, wanted, geometry, map).is_none(),
            Some(MeshPlace::File(_)) => self.same_mesh(mesh.index(), said) && self.same_map(mesh.index(), wanted, map),
            None => false,
        }
    }

    /// What differs between a mesh of the scene and one whose numbers the file holds.
    fn moved(&self, mesh: Handle<Mesh>, wanted: &Affine, geometry: &Geometry, map: &Affine) -> Option<String> {
        let asked = Placed { mesh: (&self.asked.scene.meshes[mesh]).into(), map: wanted };
        let share = if self.reading.gathered { PLACE } else { 0.0 };
        vertices::difference(asked, Placed { mesh: geometry.into(), map }, share)
    }

    fn same_map(&self, mesh: usize, a: &Affine, b: &Affine) -> bool {
        a == b || {
            let corners = self.asked.measures[mesh].corners();
            corners.iter().all(|corner| same_place(a, b, *corner, self.share()))
        }
    }

    fn same_mesh(&mut self, mesh: usize, said: usize) -> bool {
        if let Some(known) = self.same_meshes.get(&(mesh, said)) {
            return *known;
        }
        // Both sides hold the same numbers in single precision.
        let print = &self.asked.measures[mesh].print;
        let same = self.measures.get(said).and_then(Option::as_ref).is_some_and(|said| said.print == *print);
        self.same_meshes.insert((mesh, said), same);
        same
    }

    fn pair(&mut self, at: usize, block: &Block<'_, &Shape>, said: Option<&'w Use>, outer: &Affine) {
        let (Some(shape), Some(said)) = (block.parts.get(at), said) else { return };
        let Shape { name, mesh, transform, material: _, emission } = *shape;
        let mesh = *mesh;
        let (wanted, map) = (transform.then(&block.map), said.transform.then(outer));
        let kind = if emission.is_some() { "emitter" } else { "shape" };
        let same = self.same_part((mesh, &wanted), (said.mesh, &map));
        let source = self.reading.meshes.get(said.mesh);
        let measure = self.measures.get(said.mesh).copied().flatten();
        let scene_mesh = &self.asked.scene.meshes[mesh];
        let placed = measure.and_then(|measure| {
            measure.placed(&map).or_else(|| match &source?.place {
                MeshPlace::Here(geometry) => Some(Measure::of(geometry.into(), &map)),
                // The mesh is the scene's, or the difference is said anyhow.
                MeshPlace::File(_) => same.then(|| Measure::of(scene_mesh.into(), &map)),
            })
        });
        if !same {
            let what = match (source.map(|source| &source.place), measure) {
                (Some(MeshPlace::Here(geometry)), _) => {
                    let asked = Measure::of(scene_mesh.into(), &wanted);
                    let said = Measure::of(geometry.into(), &map);
                    let sums = sums_differ(&asked, &said, f64::from(f32::EPSILON));
                    sums.or_else(|| self.moved(mesh, &wanted, geometry, &map))
                }
                (Some(MeshPlace::File(_)), Some(measure)) => Some(self.file_differs(mesh, &wanted, &measure, placed)),
                // What cannot be read was said.
                (Some(MeshPlace::File(_)) | None, _) => None,
            };
            if let Some(what) = what {
                self.found.differs(format!("{kind} `{name}` has {what}"));
            }
        }
        if source
            .is_some_and(|source| source.flat.is_some_and(|flat| flat == self.asked.measures[mesh.index()].normals))
        {
            let how = if self.asked.measures[mesh.index()].normals { "flat" } else { "smooth" };
            self.found.differs(format!("{kind} `{name}` is drawn {how}, whatever the scene says of its normals"));
        }
        self.material(shape, said);
        self.add_area(1, placed.map(|placed| placed.area));
        match (emission, said.emission) {
            (None, None) => {}
            (None, Some(_)) => {
                self.audit.said.emitters += 1;
                self.found.differs(format!("shape `{name}` emits light"));
            }
            (Some(_), None) => {
                self.emitter += 1;
                self.found.differs(format!("emitter `{name}` emits no light"));
            }
            (Some(Emission { radiance }), Some(emitted)) => {
                let Some((index, wanted)) = self.asked.emitters.get(self.emitter).copied() else { return };
                self.emitter += 1;
                let Some(placed) = placed else { return };
                let by_normals = source.is_some_and(|source| source.front == Front::Normals);
                let sides = if emitted.both_sides { 2.0 } else { 1.0 };
                let sides = if emitted.reversed { -sides } else { sides };
                let said = emits(&placed, emitted.radiance, by_normals, sides);
                let leaning = !by_normals && {
                    let measure = &self.asked.measures[mesh.index()];
                    measure.normals && apart(measure.front, measure.winding) > super::TEXT * measure.area
                };
                if leaning && !self.audit.lost.contains(&LEANING) {
                    self.audit.lost.push(LEANING);
                }
                if emitted.both_sides {
                    self.found.differs(format!("emitter `{name}` emits on both sides"));
                } else if emitted.reversed || (!same && apart(said.facing, wanted.facing) > 1e-3) {
                    // Of what is closed and turned over both are 0, and of the same mesh they are the same.
                    let (said, wanted) = (said.facing, wanted.facing);
                    self.found.differs(format!("emitter `{name}` faces {said:?} instead of {wanted:?}"));
                }
                let radiance = radiance.rgb();
                let far = |at: usize| off(radiance[at], emitted.radiance[at], super::TEXT * radiance[at].abs());
                if (0..3).any(far) {
                    let (said, wanted) = (said.power, wanted.power);
                    self.found.differs(format!("emitter `{name}` emits {said:?} W instead of {wanted:?} W"));
                }
                self.audit.said.emitters += 1;
                self.audit.said.emitting_area += said.area;
                self.audit.said.power = [0, 1, 2].map(|channel| self.audit.said.power[channel] + said.power[channel]);
                self.audit.emitters.push((index, said));
            }
        }
    }

    /// What differs between a mesh of the scene and one in a file, of which something does.
    fn file_differs(&self, mesh: Handle<Mesh>, wanted: &Affine, measure: &Measure, placed: Option<Measure>) -> String {
        let asked = &self.asked.measures[mesh.index()];
        let there = super::placed(asked, &self.asked.scene.meshes[mesh], wanted);
        let sums = placed.and_then(|said| sums_differ(&there, &said, super::TEXT));
        let numbers = || asked.print.difference(&measure.print).map(str::to_owned);
        sums.or_else(numbers).unwrap_or_else(|| "another transform".to_owned())
    }

    fn material(&mut self, shape: &Shape, said: &Use) {
        let emits = shape.emission.is_some();
        let key = (shape.material.index(), said.material, emits);
        if !self.same_materials.insert(key) {
            return;
        }
        let name = &self.asked.scene.materials[shape.material].name;
        let capped = if self.reading.capped { capped(self.asked.material(shape)) } else { None };
        if capped.is_some() && !self.audit.lost.contains(&OVER_ONE) {
            self.audit.lost.push(OVER_ONE);
        }
        let Some(surface) = self.reading.materials.get(said.material) else {
            self.found.differs(format!("`{}` has no material instead of `{name}`", shape.name));
            return;
        };
        let bsdf = capped.as_ref().unwrap_or_else(|| self.asked.material(shape));
        // Where an emitter is not drawn from behind, that is said of it.
        let unlit = emits && inexact(&(self.target.supports)(Feature::BlackEmitter));
        let front = self.asked.scene.materials[shape.material].is_one_sided();
        let back = match front {
            _ if unlit => Back::Either,
            false => Back::Scatters,
            true if inexact(&(self.target.supports)(Feature::OneSided)) => Back::Either,
            true => Back::Black,
        };
        let excused = self.excused(bsdf, &surface.model);
        let what = look::difference(&Materials { bsdf, surface, back, excused, factor: self.factor_beside(bsdf) });
        let what = what.or_else(|| self.image_differs(bsdf, &surface.model));
        if let Some(what) = what {
            let also = if surface.name.is_empty() || surface.name == *name {
                String::new()
            } else {
                format!(" (`{}`)", surface.name)
            };
            self.found.differs(format!("material `{name}`{also} {what}"));
        }
        self.audit.materials += 1;
        let known = look::asked(bsdf, 1.0, [1.0; 3]).known.min(look::said(&surface.model).known);
        self.audit.angles += if excused { 0 } else { known };
    }

    /// Whether the target cannot be exact in what is seen of a material.
    fn excused(&self, bsdf: &Bsdf, model: &Model) -> bool {
        match bsdf {
            Bsdf::Dielectric { interior, exterior, alpha: _ } => {
                interior < exterior && unsupported(&(self.target.supports)(Feature::ThinnerInside))
            }
            // The texture of a base as it is, where the target would need what is seen of it.
            Bsdf::Plastic { reflectance: ColorOrTexture::Texture(_), ior: _, alpha: _ } => {
                let plain = match look::image(model) {
                    Some(Paint::Image { file: _, linear: _, factor }) => *factor == [1.0; 3],
                    Some(Paint::Color(_)) | None => false,
                };
                plain && inexact(&(self.target.supports)(Feature::TexturedPlastic))
            }
            Bsdf::Plastic { reflectance: ColorOrTexture::Color(_), ior: _, alpha: _ }
            | Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Mirror { reflectance: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ } => false,
        }
    }

    /// The factor of a material's image that a file has beside the image, and not in it.
    fn factor_beside(&self, bsdf: &Bsdf) -> Rgb {
        let Some(texture) = bsdf.texture() else { return [1.0; 3] };
        let texture = &self.asked.scene.textures[texture];
        let inside = (self.target.images)(texture, Purpose::Surface).factor();
        if inside == texture.factor { [1.0; 3] } else { texture.factor }
    }

    fn image_differs(&self, bsdf: &Bsdf, model: &Model) -> Option<String> {
        let said = look::image(model);
        match (bsdf.texture(), said) {
            (None, None) => None,
            (None, Some(_)) => Some("shows an image".to_owned()),
            (Some(texture), None) => {
                let texture = &self.asked.scene.textures[texture];
                let unread = capability::of_texture(texture)
                    .into_iter()
                    .any(|feature| unsupported(&(self.target.supports)(feature)));
                (!unread).then(|| format!("does not show the image `{}`", texture.name))
            }
            (Some(texture), Some(paint)) => {
                same_image(self.asked, texture, paint, (self.target.images, Purpose::Surface))
            }
        }
    }
}

/// What of a surface is lost that reflects more than it gets.
const OVER_ONE: Lost =
    Lost { what: "a reflectance above 1", why: "its colors of surfaces are from 0 to 1: what is more becomes 1" };

/// What of a curved emitter is lost whose normals lean over the backs of its faces, as uneven scales make them.
const LEANING: Lost = Lost {
    what: "emission along normals that lean over the backs of their faces",
    why: "each of its faces emits on the side of its corners' order",
};

/// A material with its color held to 1; none where it needs no hold.
fn capped(bsdf: &Bsdf) -> Option<Bsdf> {
    let held =
        |color: &Color| color.rgb().iter().any(|x| *x > 1.0).then(|| Color::Rgb(color.rgb().map(|x| x.min(1.0))));
    let paint = |paint: &ColorOrTexture| paint.color().and_then(held).map(ColorOrTexture::Color);
    Some(match bsdf {
        Bsdf::Diffuse { reflectance } => Bsdf::Diffuse { reflectance: paint(reflectance)? },
        Bsdf::Mirror { reflectance } => Bsdf::Mirror { reflectance: held(reflectance)? },
        Bsdf::Plastic { reflectance, ior, alpha } => {
            Bsdf::Plastic { reflectance: paint(reflectance)?, ior: *ior, alpha: *alpha }
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            Bsdf::Principled { base: paint(base)?, metallic: *metallic, roughness: *roughness, ior: *ior }
        }
        Bsdf::Conductor { eta: _, k: _, alpha: _ } | Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => {
            return None;
        }
    })
}

/// What of two meshes that are known to differ can be said in sums, when corners are moved by `share` of their coordinates.
fn sums_differ(asked: &Measure, said: &Measure, share: f64) -> Option<String> {
    let most = asked.low.iter().chain(&asked.high).fold(0.0_f64, |most, x| most.max(x.abs()));
    difference(Pair { asked, said, slack: share * most })
}

fn apart(a: Vec3, b: Vec3) -> f64 {
    length(sub(a, b))
}

/// What differs between an image of the scene and that of a file: its name, and how it is decoded. That the images
/// themselves are the scene's follows from their being written as they are, or from the tests of the other forms.
fn same_image(
    asked: &Asked<'_>,
    texture: crate::ir::Handle<crate::ir::Texture>,
    paint: &Paint,
    (forms, purpose): (Forms, Purpose),
) -> Option<String> {
    let Paint::Image { file, linear: said, factor: _ } = paint else { return Some("shows no image".to_owned()) };
    let wanted = images::file_name(asked.scene, texture, purpose, forms).unwrap_or_default();
    let texture = &asked.scene.textures[texture];
    match file {
        Picture::File(path) if path.name() != wanted => {
            return Some(format!("shows the image `{}` instead of `{wanted}`", path.name()));
        }
        Picture::Here(image) if *image != texture.file => {
            return Some(format!("shows another image instead of `{wanted}`"));
        }
        Picture::File(_) | Picture::Here(_) => {}
    }
    let form = forms(texture, purpose);
    let wanted = form.encoding(texture) == crate::ir::Encoding::Linear;
    // Images of floats are linear whatever is said of them.
    let floats = form.holds_floats(texture) || purpose != Purpose::Surface;
    (!floats && *said != wanted).then(|| format!("decodes the image `{}` otherwise", texture.name))
}

/// What differs between a paint of the scene and that of a file.
pub(super) fn paint_differs(
    asked: &Asked<'_>,
    wanted: &ColorOrTexture,
    said: &Paint,
    stands_in: bool,
    (forms, purpose): (Forms, Purpose),
) -> Option<String> {
    let color = |wanted: &Color, said: Rgb| {
        let wanted = wanted.rgb();
        let far = |(a, b): (f64, f64)| off(a, b, super::TEXT * a.abs().max(b.abs()));
        wanted.into_iter().zip(said).any(far).then(|| format!("has the strength {said:?} instead of {wanted:?}"))
    };
    match (wanted, said) {
        (ColorOrTexture::Color(wanted), Paint::Color(said)) => color(wanted, *said),
        (ColorOrTexture::Texture(_), Paint::Color(said)) if stands_in => color(&Color::Grey(0.5), *said),
        (ColorOrTexture::Texture(_), Paint::Color(_)) => Some("shows no image".to_owned()),
        (ColorOrTexture::Color(_), Paint::Image { file: _, linear: _, factor: _ }) => Some("shows an image".to_owned()),
        (ColorOrTexture::Texture(texture), Paint::Image { file: _, linear: _, factor }) => {
            let tint = match purpose {
                Purpose::Surface => asked.scene.textures[*texture].factor,
                Purpose::Sky(tint) => tint,
            };
            // A part of the tint may be in the image itself.
            let inside = forms(&asked.scene.textures[*texture], purpose).factor();
            let far = |at: usize| off(factor[at] * inside[at], tint[at], super::TEXT * tint[at]);
            let strong = (0..3).any(far).then(|| format!("shows its image times {factor:?} instead of {tint:?}"));
            strong.or_else(|| same_image(asked, *texture, said, (forms, purpose)))
        }
    }
}
