//! Finds, installs and runs renderers; reads, writes and compares their images.
//!
//! Reading order: `image` (pixels in files), `compare` (two images), `run` (one driver for each
//! renderer), `install` (private copies of renderers), `cache` and `env` (where things are).
//! Nothing here knows what a scene is: the input is a folder that somebody emitted.

pub mod cache;
pub mod compare;
pub mod env;
pub mod image;
pub mod install;
pub mod run;
