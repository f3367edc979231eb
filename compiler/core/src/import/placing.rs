//! Shapes, groups and instances at their places: not too many, and each where numbers can say it is.

use super::build::{Builder, plain};
use super::reader::{Fate, Reader};
use crate::diag::Origin;
use crate::ir::{Affine, Arena, Group, Handle, Instance, Places, Shape};

/// A bound of the coordinates of what reaches so far, after a map.
fn moved(map: &Affine, reach: f64) -> f64 {
    map.rows.iter().map(|[x, y, z, far]| (x.abs() + y.abs() + z.abs()) * reach + far.abs()).fold(0.0, f64::max)
}

/// Whether single precision holds such coordinates.
fn holds(reach: f64) -> bool {
    reach <= f64::from(f32::MAX)
}

impl Builder {
    /// A shape of the scene; its name is made unique.
    pub fn shape(&mut self, reader: &mut Reader<'_>, shape: Shape, at: &Origin) {
        if let Some(shape) = self.placed(reader, shape, at) {
            self.shapes.push(shape, at.clone());
        }
    }

    /// A shape of a group.
    pub fn shape_in(&mut self, reader: &mut Reader<'_>, group: &mut Arena<Shape>, shape: Shape, at: &Origin) {
        if let Some(shape) = self.placed(reader, shape, at) {
            group.push(shape, at.clone());
        }
    }

    /// What can be placed: not what a transform makes flat, or too many.
    fn placed(&mut self, reader: &mut Reader<'_>, shape: Shape, at: &Origin) -> Option<Shape> {
        self.placed += 1;
        if self.placed > reader.limits().instances {
            let most = reader.limits().instances;
            let message = format!("there are more than {most} shapes");
            reader.lost_with(Fate::Dropped, at.clone(), message, "`--limit instances=N` allows more");
            return None;
        }
        if !shape.transform.is_invertible() {
            reader.lost(Fate::Dropped, at.clone(), "a shape is left out: its transform has no inverse");
            return None;
        }
        let reach = self.reach(&shape);
        if !holds(reach) {
            reader.lost(Fate::Dropped, at.clone(), "a shape is left out: it lies out of the range of single precision");
            return None;
        }
        let name = self.unique(&shape.name);
        Some(Shape { name, ..shape })
    }

    /// A bound of the coordinates of a shape at its place.
    fn reach(&mut self, shape: &Shape) -> f64 {
        let mesh = &self.meshes[shape.mesh];
        let largest = || mesh.positions.as_flattened().iter().fold(0.0, |most: f64, x| most.max(f64::from(x.abs())));
        moved(&shape.transform, *self.mesh_reach.entry(shape.mesh).or_insert_with(largest))
    }

    /// The same of what is in a group.
    fn reach_of(&mut self, group: Handle<Group>) -> f64 {
        if let Some(known) = self.group_reach.get(&group) {
            return *known;
        }
        let shapes: Vec<Shape> = self.groups[group].shapes.values().cloned().collect();
        let reach = shapes.iter().map(|shape| self.reach(shape)).fold(0.0, f64::max);
        self.group_reach.insert(group, reach);
        reach
    }

    /// A group.
    pub fn group(&mut self, name: &str, shapes: Arena<Shape>, at: &Origin) -> Handle<Group> {
        let group = Group { name: plain(name), shapes, instances: Arena::default() };
        self.groups.push(group, at.clone())
    }

    /// A group at its place.
    pub fn instance(&mut self, reader: &mut Reader<'_>, name: &str, group: Handle<Group>, place: Affine, at: &Origin) {
        self.placed += self.groups[group].shapes.len().max(1) as u64;
        if self.placed > reader.limits().instances {
            let most = reader.limits().instances;
            let message = format!("there are more than {most} shapes");
            reader.lost_with(Fate::Dropped, at.clone(), message, "`--limit instances=N` allows more");
        } else if let Some(why) = self.misplaced(group, &place) {
            reader.lost(Fate::Dropped, at.clone(), format!("an instance is left out: {why}"));
        } else {
            let name = self.unique(name);
            self.instances.push(Instance { name, group, places: Places::One(place) }, at.clone());
        }
    }

    /// A group at many places, which have numbers and no names.
    pub fn instances(
        &mut self,
        reader: &mut Reader<'_>,
        name: &str,
        group: Handle<Group>,
        mut places: Vec<Affine>,
        at: &Origin,
    ) {
        let shapes = self.groups[group].shapes.len().max(1) as u64;
        self.placed = self.placed.saturating_add(shapes.saturating_mul(places.len() as u64));
        if self.placed > reader.limits().instances {
            let most = reader.limits().instances;
            let message = format!("there are more than {most} shapes");
            reader.lost_with(Fate::Dropped, at.clone(), message, "`--limit instances=N` allows more");
            return;
        }
        places.retain(|place| {
            let why = self.misplaced(group, place);
            if let Some(why) = why {
                reader.lost(Fate::Dropped, at.clone(), format!("an instance is left out: {why}"));
            }
            why.is_none()
        });
        if !places.is_empty() {
            let name = self.unique(name);
            self.instances.push(Instance { name, group, places: Places::Many(places.into()) }, at.clone());
        }
    }

    /// Why a group cannot lie at a place.
    fn misplaced(&mut self, group: Handle<Group>, place: &Affine) -> Option<&'static str> {
        if !place.is_invertible() {
            return Some("its transform has no inverse");
        }
        let reach = moved(place, self.reach_of(group));
        (!holds(reach)).then_some("it lies out of the range of single precision")
    }

    /// The number of shapes of a group.
    pub fn shapes_of(&self, group: Handle<Group>) -> usize {
        self.groups[group].shapes.len()
    }
}
