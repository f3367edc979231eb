//! The pure core of ltsc: no disk, clock, process, environment or terminal.
//!
//! Reading order: [`diag`] and [`files`] (what everything speaks), [`ir`] (the Scene in the middle), [`syntax`] (text to
//! tree), [`format`] (text to its canonical form), [`eval`] (tree to Scene), [`import`] (scenes of other programs to Scene), [`print`](mod@print) (Scene to text), [`mesh`] (generators, mesh files), [`npy`] (arrays of numbers),
//! [`image`] (image files), [`valid`] (what every emitter may rely on),
//! [`survey`] (what lies where), [`contact`] (what lies against what), [`lint`] (portability), [`fix`] (findings to edits), [`similar`] (how near scenes are), [`equiv`] (how they differ), [`lower`] (Scene to Scene), [`capability`] (what a target can say), [`formats`] (targets and
//! importers), [`ledger`] (what became of everything), [`audit`] (what was written, read back and compared), [`pipeline`], the only file that knows all stages, [`catalogue`] (pages of scenes), and [`manual`], the pages made from the tables of them all.
#![deny(clippy::wildcard_enum_match_arm)]

pub mod audit;
pub mod capability;
pub mod catalogue;
pub mod contact;
pub mod diag;
pub mod equiv;
pub mod eval;
pub mod files;
pub mod fix;
pub mod format;
pub mod formats;
pub mod image;
pub mod import;
pub mod ir;
pub mod ledger;
pub mod lint;
pub mod lower;
pub mod manual;
pub mod mesh;
pub mod npy;
pub mod pipeline;
pub mod print;
pub mod similar;
pub mod survey;
pub mod syntax;
pub mod valid;
