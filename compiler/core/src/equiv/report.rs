//! Differences, each kept once with all its places.

use std::collections::HashMap;

use crate::diag::Origin;

/// What a difference is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Where the image is taken from.
    Camera,
    /// Resolution and reconstruction filter.
    Film,
    /// Light transport algorithm.
    Integrator,
    /// Sampling.
    Sampler,
    /// Something that a file says and its scene does not hold.
    Reading,
    /// A light without a surface.
    Light,
    /// Where surfaces lie, and their normals.
    Surface,
    /// What they are made of.
    Material,
    /// What they emit.
    Emission,
}

impl Kind {
    /// Its word in output.
    pub fn word(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Film => "film",
            Self::Integrator => "integrator",
            Self::Sampler => "sampler",
            Self::Reading => "reading",
            Self::Light => "light",
            Self::Surface => "surface",
            Self::Material => "material",
            Self::Emission => "emission",
        }
    }
}

/// Something that has a place in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// What it is called; empty where it has no name.
    pub name: String,
    /// Where it is written.
    pub origin: Origin,
}

/// One difference, at one place or at many.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// What it is about.
    pub kind: Kind,
    /// What differs, in words.
    pub what: String,
    /// What A has, in words.
    pub a: String,
    /// What B has, in words.
    pub b: String,
    /// All places, in A and in B; never empty. None where it has none in that scene.
    pub places: Vec<[Option<Place>; 2]>,
}

/// Differences as they are found.
#[derive(Debug, Default)]
pub struct Report {
    known: HashMap<(Kind, String), usize>,
    found: Vec<Difference>,
}

impl Report {
    /// Adds a difference; those of one kind with the same words are one.
    pub fn add(&mut self, kind: Kind, what: &str, [a, b]: [String; 2], places: [Option<Place>; 2]) {
        let key = format!("{what}\n{a}\n{b}");
        self.add_by(kind, key, what, [a, b], places);
    }

    /// Adds a difference; those of one kind with the same `key` are one, which has the words of the first.
    pub fn add_by(&mut self, kind: Kind, key: String, what: &str, [a, b]: [String; 2], places: [Option<Place>; 2]) {
        if let Some(at) = self.known.get(&(kind, key.clone())) {
            self.found[*at].places.push(places);
            return;
        }
        self.known.insert((kind, key), self.found.len());
        self.found.push(Difference { kind, what: what.to_owned(), a, b, places: vec![places] });
    }

    /// All of them, by kind, and in each as they were found.
    pub fn finish(self) -> Vec<Difference> {
        let mut found = self.found;
        found.sort_by_key(|difference| difference.kind);
        found
    }
}
