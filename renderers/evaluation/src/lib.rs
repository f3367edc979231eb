//! Scenes in renderers: what is written is rendered, what is rendered is compared, and what follows is proved.
//!
//! Reading order: `failure` (how a command ends), `watch` (news while it goes on), `disk` (what is written appears as a whole), `command` (how programs
//! without a driver are called), `job` (a scene through a renderer), `chunk` (an image in pieces, kept by content), `executor` (who renders them: this machine or a cluster),
//! `compare` (statistics of images, and the verdict), `conventions` (micro-scenes of known answers), `agree` (renderers against each
//! other), `calibrate` (how often the verdict is wrong), `reference` (images that are kept with their error), `file` (what an evaluation
//! is to render), `study` (an evaluation carried out), `page` (its results in a browser), `reduce` (the
//! smallest scene on which two renderers differ). This is the only package that knows both scenes
//! and renderers; it knows no
//! arguments and no terminal.

pub mod agree;
pub mod calibrate;
pub mod chunk;
pub mod command;
pub mod compare;
pub mod conventions;
pub mod disk;
pub mod executor;
pub mod failure;
pub mod file;
pub mod job;
pub mod page;
pub mod reduce;
pub mod reference;
pub mod study;
pub mod watch;
