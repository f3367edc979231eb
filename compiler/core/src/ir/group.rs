//! Groups and instances: shapes that are written once and placed several times.

use std::borrow::Cow;
use std::sync::Arc;

use super::{Affine, Arena, Handle, Shape};

/// The most shapes and instances that a scene's groups make when they are multiplied out: what the language and importers can
/// be told to allow at most.
pub const INSTANCE_LIMIT: u64 = 1_000_000_000;

/// How deep groups may hold each other.
pub const GROUP_DEPTH: usize = 128;

/// Shapes that lie together in coordinates of their own. They are seen only where an [`Instance`] places the group.
///
/// Spelling: Mitsuba `shapegroup`; PBRT `ObjectBegin`; LuxCore has none, every use is written as an object that shares its
/// mesh; glTF a mesh with a primitive per shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// As the author wrote it; need not be a word, need not be unique.
    pub name: String,
    /// Its shapes, in the group's coordinates; names are unique within the group. None of them emits after lowering.
    pub shapes: Arena<Shape>,
    /// Groups within it, which stand before it in the scene; none after lowering.
    pub instances: Arena<Instance>,
}

/// A group at its place, or at many.
///
/// Spelling, once for each place: Mitsuba `instance`; PBRT `ObjectInstance`; LuxCore objects with `transformation`; glTF a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// As the author wrote it, with the loops around it: `cell[3,0,5]`. Unique among the instances beside it.
    pub name: String,
    /// The group.
    pub group: Handle<Group>,
    /// Where it lies.
    pub places: Places,
}

impl Instance {
    /// The places with their names: that of the instance for a single one, `oak[17]` for the eighteenth of many.
    pub fn named(&self) -> impl Iterator<Item = (Cow<'_, str>, &Affine)> {
        self.places.maps().iter().enumerate().map(|(at, map)| (self.name_of(at), map))
    }

    /// The name of place `at`, counted from 0.
    pub fn name_of(&self, at: usize) -> Cow<'_, str> {
        self.places.name_of(&self.name, at)
    }
}

/// Maps from a group's coordinates to those of what holds its instance; invertible, and not mirroring after lowering.
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    /// A single place.
    One(Affine),
    /// As many as an array has rows, at least one; they have numbers and no names of their own.
    Many(Arc<[Affine]>),
}

impl Places {
    /// All of them in their order.
    pub fn maps(&self) -> &[Affine] {
        match self {
            Self::One(map) => std::slice::from_ref(map),
            Self::Many(maps) => maps,
        }
    }

    /// The name of place `at`, counted from 0, of an instance called `name`.
    pub fn name_of<'n>(&self, name: &'n str, at: usize) -> Cow<'n, str> {
        match self {
            Self::One(_) => Cow::Borrowed(name),
            Self::Many(_) => Cow::Owned(format!("{name}[{at}]")),
        }
    }

    /// The same places after one more map.
    #[must_use]
    pub fn then(&self, after: &Affine) -> Self {
        match self {
            Self::One(map) => Self::One(map.then(after)),
            Self::Many(maps) if *after == Affine::IDENTITY => Self::Many(Arc::clone(maps)),
            Self::Many(maps) => Self::Many(maps.iter().map(|map| map.then(after)).collect()),
        }
    }
}
