//! Small writers that the formats share: numbers, names, XML text, PLY files, camera arithmetic.

pub mod camera;
pub mod coat;
pub mod names;
pub mod number;
pub mod ply;
pub mod text;

#[cfg(test)]
pub mod sample;
