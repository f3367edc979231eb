//! Finds, installs and runs renderers; reads and writes their images.
//!
//! Reading order: `image` (pixels in files), `run` (one driver for each
//! renderer), `install` (private copies of renderers), `cache` and `env` (where things are), `guard` (what is half done, and
//! how it is put back), `supervisor` (the process that ends a renderer with all that it started; on Windows `job_object`), `regular` (the one way to
//! read a file), `client` (programs of the system that answer in a moment).
//! Nothing here knows what a scene is: the input is a folder that somebody emitted.

pub mod cache;
pub mod client;
pub mod env;
pub mod guard;
pub mod image;
pub mod install;
#[cfg(windows)]
mod job_object;
pub mod regular;
pub mod run;
pub mod supervisor;
#[cfg(unix)]
mod tree;
