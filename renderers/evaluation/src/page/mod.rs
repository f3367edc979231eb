//! The page of results: a folder that a browser opens from a disk, with all images in full range and every comparison computed where it
//! is looked at.
//!
//! Reading order: `model` (what a page shows), `gather` (found in a folder of results, or in loose files; `loose`, images that no table
//! names; `described`, what evaluation files say), `pixels` (images on their way into a browser), `measured` (what needs the pixels of two images), `plots`, `write` (the
//! folder). `assets` has what runs in the browser, as it is: no step builds it.

mod described;
mod gather;
mod loose;
mod measured;
mod model;
mod pixels;
mod plots;
mod write;

pub use gather::{Book, of_files, of_folder};
pub use write::{FOLDER, Written, is_page, write};
