//! Instances become one level of groups without emitters, each placed at least twice.
//!
//! Mitsuba 3 and PBRT refuse instances within instances and emitters within them, so both are resolved here: nested ones by
//! multiplying out, emitters by writing each of them as a shape of the scene. A group that is seen once is no group: its
//! shapes lie in the scene. An instance that mirrors places a mirrored copy of its group, because renderers disagree on
//! the front of a mirrored instance.

use std::collections::BTreeMap;

use super::Pass;
use crate::diag::{Finding, Origin, Severity};
use crate::ir::{Affine, Arena, GROUP_DEPTH, Group, Handle, INSTANCE_LIMIT, Instance, Places, Scene, Shape};

pub(super) const PASS: Pass = Pass {
    name: "instances",
    summary: "nested instances become one level, emitters leave instanced groups, groups seen once become shapes",
    run,
};

fn run(scene: Scene) -> (Scene, Vec<Finding>) {
    if scene.groups.is_empty() && scene.instances.is_empty() {
        return (scene, Vec::new());
    }
    let Some(uses) = uses(&scene) else { return (scene, Vec::new()) };
    let Scene {
        name,
        origin,
        documentation,
        meshes,
        textures,
        materials,
        shapes: own,
        lights,
        groups: old,
        instances,
        cameras,
        film,
        integrator,
        sampler,
    } = scene;
    let mut made = Placing::new(&old, &uses);
    for (place, instance) in instances.entries() {
        made.place(instance, place, &Affine::IDENTITY, "");
    }
    let Placing { old: _, uses: _, mut shapes, groups, instances, kept: _, emitters, nested, mirrored } = made;
    for (place, shape) in own.entries() {
        shapes.push(shape.clone(), place.clone());
    }
    let mut findings = Vec::new();
    let mut say = |count: usize, what: &str| {
        if count > 0 {
            let message = format!("{count} {what}");
            findings.push(Finding::new("loss-baked", Severity::Info, origin.clone(), message));
        }
    };
    say(emitters, "emitters of instanced groups become emitters of the scene, which share their meshes");
    say(nested, "instances within instances become instances of the scene");
    say(mirrored, "mirroring instances place mirrored copies of their groups");
    let scene = Scene {
        name,
        origin,
        documentation,
        meshes,
        textures,
        materials,
        shapes,
        lights,
        groups,
        instances,
        cameras,
        film,
        integrator,
        sampler,
    };
    (scene, findings)
}

/// How often each group is seen plain, and how often mirrored.
type Uses = Vec<[u64; 2]>;

/// None where the groups cannot be multiplied out.
fn uses(scene: &Scene) -> Option<Uses> {
    let mut uses = vec![[0_u64; 2]; scene.groups.len()];
    let mut depths = vec![1_usize; scene.groups.len()];
    for instance in scene.instances.values() {
        for map in instance.places.maps() {
            uses[instance.group.index()][usize::from(mirrors(map))] += 1;
        }
    }
    // A group stands behind those that it holds, so that backwards every group is counted before what it holds.
    let groups: Vec<(Handle<Group>, &Group)> = scene.groups.iter().collect();
    for (handle, group) in groups.into_iter().rev() {
        let ([plain, mirrored], depth) = (uses[handle.index()], depths[handle.index()]);
        for instance in group.instances.values() {
            let inner = instance.group.index();
            for map in instance.places.maps() {
                let added = if mirrors(map) { [mirrored, plain] } else { [plain, mirrored] };
                uses[inner] = [0, 1].map(|side| uses[inner][side].saturating_add(added[side]));
            }
            depths[inner] = depths[inner].max(depth + 1);
        }
    }
    let items = scene.groups.iter().map(|(handle, group)| {
        let [plain, mirrored] = uses[handle.index()];
        let inner: usize = group.instances.values().map(|instance| instance.places.maps().len()).sum();
        let own = group.shapes.len() as u64 + inner as u64;
        plain.saturating_add(mirrored).saturating_mul(own)
    });
    let total = items.fold(0_u64, u64::saturating_add);
    let deepest = depths.into_iter().max().unwrap_or_default();
    (total <= INSTANCE_LIMIT && deepest <= GROUP_DEPTH).then_some(uses)
}

fn mirrors(map: &Affine) -> bool {
    map.determinant() < 0.0
}

/// The scene in the making.
struct Placing<'a> {
    old: &'a Arena<Group>,
    uses: &'a [[u64; 2]],
    shapes: Arena<Shape>,
    groups: Arena<Group>,
    instances: Arena<Instance>,
    /// The new group of an old one, and of its mirror image.
    kept: BTreeMap<(Handle<Group>, bool), Handle<Group>>,
    emitters: usize,
    nested: usize,
    mirrored: usize,
}

impl<'a> Placing<'a> {
    fn new(old: &'a Arena<Group>, uses: &'a Uses) -> Self {
        Self {
            old,
            uses,
            shapes: Arena::default(),
            groups: Arena::default(),
            instances: Arena::default(),
            kept: BTreeMap::new(),
            emitters: 0,
            nested: 0,
            mirrored: 0,
        }
    }

    /// Places `instance`, which lies in something that is called `path` and placed by `outer`.
    fn place(&mut self, instance: &Instance, origin: &Origin, outer: &Affine, path: &str) {
        let Instance { name, group: handle, places } = instance;
        let Group { name: _, shapes, instances } = &self.old[*handle];
        let own = joined(path, name);
        let together = self.together(*handle, places, outer);
        if let Some(mirrors) = together
            && shapes.values().any(|shape| shape.emission.is_none())
        {
            let places = if mirrors { moved_first(places, outer) } else { places.then(outer) };
            self.push(*handle, own.clone(), places, mirrors, origin, !path.is_empty());
        }
        let alone = together.is_none();
        if !alone && instances.is_empty() && shapes.values().all(|shape| shape.emission.is_none()) {
            return;
        }
        for (at, map) in places.maps().iter().enumerate() {
            let transform = map.then(outer);
            let name = joined(path, &instance.name_of(at));
            let mirrors = mirrors(&transform);
            let once = self.uses[handle.index()][usize::from(mirrors)] == 1;
            for (place, shape) in shapes.entries() {
                if once || shape.emission.is_some() {
                    self.emitters += usize::from(!once);
                    self.shapes.push(
                        Shape {
                            name: joined(&name, &shape.name),
                            transform: shape.transform.then(&transform),
                            mesh: shape.mesh,
                            material: shape.material,
                            emission: shape.emission.clone(),
                        },
                        place.clone(),
                    );
                }
            }
            if alone && !once && shapes.values().any(|shape| shape.emission.is_none()) {
                let places = Places::One(if mirrors { MIRROR.then(&transform) } else { transform });
                self.push(*handle, name.clone(), places, mirrors, origin, !path.is_empty());
            }
            for (place, inner) in instances.entries() {
                self.place(inner, place, &transform, &name);
            }
        }
    }

    /// Whether many places can stay one instance: all of them mirror (true), or none (false), and the group is no shape of
    /// the scene. Else each place keeps its name as an instance of its own.
    fn together(&self, group: Handle<Group>, places: &Places, outer: &Affine) -> Option<bool> {
        let Places::Many(maps) = places else { return None };
        let mut sides = maps.iter().map(|map| mirrors(&map.then(outer)));
        let first = sides.next()?;
        let same = sides.all(|side| side == first);
        (same && self.uses[group.index()][usize::from(first)] > 1).then_some(first)
    }

    fn push(
        &mut self,
        group: Handle<Group>,
        name: String,
        places: Places,
        mirrors: bool,
        origin: &Origin,
        nested: bool,
    ) {
        let count = places.maps().len();
        let group = self.group(group, mirrors);
        self.nested += if nested { count } else { 0 };
        self.mirrored += if mirrors { count } else { 0 };
        self.instances.push(Instance { name, group, places }, origin.clone());
    }

    /// The new group with the shapes of the old one that do not emit.
    fn group(&mut self, handle: Handle<Group>, mirrors: bool) -> Handle<Group> {
        if let Some(known) = self.kept.get(&(handle, mirrors)) {
            return *known;
        }
        let Group { name, shapes: old, instances: _ } = &self.old[handle];
        let mut shapes = Arena::default();
        for (place, shape) in old.entries().filter(|(_, shape)| shape.emission.is_none()) {
            let transform = if mirrors { shape.transform.then(&MIRROR) } else { shape.transform };
            shapes.push(Shape { transform, ..shape.clone() }, place.clone());
        }
        let name = if mirrors { format!("{name} mirrored") } else { name.clone() };
        let group = Group { name, shapes, instances: Arena::default() };
        let made = self.groups.push(group, self.old.origin(handle).clone());
        self.kept.insert((handle, mirrors), made);
        made
    }
}

/// Mirrors along x; its own inverse.
const MIRROR: Affine = Affine { rows: [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

/// The places of a mirrored copy.
fn moved_first(places: &Places, outer: &Affine) -> Places {
    Places::Many(places.maps().iter().map(|map| MIRROR.then(&map.then(outer))).collect())
}

/// `grid/cell[0,1,2]`
fn joined(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") }
}
