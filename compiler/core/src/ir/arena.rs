//! Typed arenas: items of one kind, each with the place it comes from, addressed by small handles.

use std::fmt;
use std::hash::{Hash, Hasher};
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

use crate::diag::Origin;

/// The address of a `T` in an [`Arena<T>`].
pub struct Handle<T> {
    index: u32,
    kind: PhantomData<fn() -> T>,
}

impl<T> Handle<T> {
    /// The position in the arena, from 0.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

impl<T> Clone for Handle<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Handle<T> {}
impl<T> PartialEq for Handle<T> {
    fn eq(&self, other: &Self) -> bool {
        self.index == other.index
    }
}
impl<T> Eq for Handle<T> {}
impl<T> PartialOrd for Handle<T> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl<T> Ord for Handle<T> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.index.cmp(&other.index)
    }
}
impl<T> Hash for Handle<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.index.hash(state);
    }
}
impl<T> fmt::Debug for Handle<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}]", self.index)
    }
}

/// Items of one kind in the order in which they were made.
#[derive(Clone, Debug, PartialEq)]
pub struct Arena<T> {
    items: Vec<T>,
    origins: Vec<Origin>,
}

impl<T> Default for Arena<T> {
    fn default() -> Self {
        Self { items: Vec::new(), origins: Vec::new() }
    }
}

impl<T> Arena<T> {
    /// Adds an item that comes from `origin`.
    ///
    /// # Panics
    /// At more than `u32::MAX` items; the limits of the language and of importers lie far below.
    pub fn push(&mut self, item: T, origin: impl Into<Origin>) -> Handle<T> {
        let index = u32::try_from(self.items.len()).expect("fewer than 2^32 items of a kind");
        self.items.push(item);
        self.origins.push(origin.into());
        Handle { index, kind: PhantomData }
    }

    /// Where the item comes from.
    pub fn origin(&self, handle: Handle<T>) -> &Origin {
        &self.origins[handle.index()]
    }

    /// Items with their handles.
    pub fn iter(&self) -> impl Iterator<Item = (Handle<T>, &T)> {
        (0u32..).zip(&self.items).map(|(index, item)| (Handle { index, kind: PhantomData }, item))
    }

    /// Items with their handles, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (Handle<T>, &mut T)> {
        (0u32..).zip(&mut self.items).map(|(index, item)| (Handle { index, kind: PhantomData }, item))
    }

    /// Items with their origins.
    pub fn entries(&self) -> impl Iterator<Item = (&Origin, &T)> {
        self.origins.iter().zip(&self.items)
    }

    /// Items without handles.
    pub fn values(&self) -> impl ExactSizeIterator<Item = &T> {
        self.items.iter()
    }

    /// Count of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}

impl<T> Index<Handle<T>> for Arena<T> {
    type Output = T;

    fn index(&self, handle: Handle<T>) -> &T {
        &self.items[handle.index()]
    }
}

impl<T> IndexMut<Handle<T>> for Arena<T> {
    fn index_mut(&mut self, handle: Handle<T>) -> &mut T {
        &mut self.items[handle.index()]
    }
}
