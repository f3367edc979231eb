//! Small writers that the formats share: numbers, names, XML text, PLY files, camera arithmetic.

pub mod bounds;
pub mod camera;
pub mod coat;
pub mod fresnel;
pub mod microfacet;
pub mod names;
pub mod number;
pub mod ply;
pub mod text;

#[cfg(test)]
pub mod sample;
