//! The disk: what is read lies below a root, what is written appears as a whole.

mod manifest;
mod read;
mod rewrite;
mod sink;
mod staging;
#[cfg(test)]
mod tests;

pub use manifest::{MANIFEST, Manifest};
pub use read::{Changed, DiskFiles};
pub use rewrite::rewrite;
pub use sink::{Changes, DiskSink, unwritable, write_atomically};
pub use staging::{STAGING, Staging, left_over};
