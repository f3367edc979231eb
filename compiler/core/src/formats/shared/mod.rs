//! What the formats share: small writers (numbers, names, XML text, PLY files), arithmetic of cameras and surfaces, and for readers
//! the record of what a file says and the door through which files are opened.

pub mod bounds;
pub mod camera;
pub mod coat;
pub mod filter;
pub mod fresnel;
pub mod images;
pub mod microfacet;
pub mod names;
pub mod number;
pub mod ply;
pub mod reading;
pub mod source;
pub mod text;

#[cfg(test)]
pub mod sample;
