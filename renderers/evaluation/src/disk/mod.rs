//! The disk: what is read lies below a root, what is written appears as a whole, and what ltsc did not write is not touched.
//!
//! Three forms: a folder of our own ([`DiskSink`]), files of ours among others ([`Pages`]), one file ([`write_whole`], [`Log`]).

mod log;
mod manifest;
mod notice;
mod pages;
mod place;
mod read;
mod rewrite;
mod sink;
mod staging;
#[cfg(test)]
mod tests;

pub use log::{Log, append, check as check_log};
pub use manifest::{MANIFEST, Manifest};
pub use notice::show_by;
pub use pages::{Done, Pages, not_ours};
pub use place::{no_temporary, probe, probe_file, unwritable};
pub use read::{Changed, DiskFiles};
pub use rewrite::rewrite;
pub(crate) use sink::is_removable;
pub use sink::{Changes, DiskSink};
pub use staging::{STAGING, Staging, left_over, write_whole};
