//! Groups and instances: shapes that are written once and placed several times.

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

/// A group at its place.
///
/// Spelling: Mitsuba `instance`; PBRT `ObjectInstance`; LuxCore objects with `transformation`; glTF a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// As the author wrote it, with the loops around it: `cell[3,0,5]`. Unique among the instances beside it.
    pub name: String,
    /// The group.
    pub group: Handle<Group>,
    /// From the group's coordinates to those of what holds the instance; invertible, and not mirroring after lowering.
    pub transform: Affine,
}
