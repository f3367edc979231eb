//! The scene of a view: from the text in the binary to what emitters take.

use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::Overrides;
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::ir::{Documentation, Scene};
use ltsc_core::lint::{Level, Levels};
use ltsc_core::pipeline::{self, Checked, Options};
use ltsc_core::valid::Valid;

use super::kinds::{Convention, View};
use crate::failure::{Exit, Failure};

/// An image or a mesh that scenes of conventions name.
macro_rules! image {
    ($name:literal) => {
        (concat!("images/", $name), include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/conventions/images/", $name)))
    };
}

/// All of them, by their paths.
pub const IMAGES: &[(&str, &[u8])] = &[
    image!("colors.png"),
    image!("dark.png"),
    image!("edge.exr"),
    image!("edge.hdr"),
    image!("edge.jpg"),
    image!("edge.pfm"),
    image!("edge.png"),
    image!("edge_16.png"),
    image!("light.png"),
    image!("quarters.exr"),
    image!("quarters.hdr"),
    image!("quarters.jpg"),
    image!("quarters.pfm"),
    image!("quarters.png"),
    image!("quarters_16.png"),
    image!("ridge.ply"),
    image!("sky.exr"),
];

/// Reads the scene of a view. Lint is not asked: it takes longer than all else, and some conventions are about what it refuses.
fn read(convention: &Convention, view: &View) -> Result<Checked, Failure> {
    let mut levels = Levels::default();
    levels.set("all", Level::Allow).map_err(|error| Failure::new(Exit::Fault, error.message))?;
    linted(convention, view, levels)
}

/// The same with what lint says.
#[cfg(test)]
pub fn checked(convention: &Convention, view: &View) -> Result<Checked, Failure> {
    linted(convention, view, Levels::default())
}

fn linted(convention: &Convention, view: &View, levels: Levels) -> Result<Checked, Failure> {
    let fault = |message: String| Failure::new(Exit::Fault, format!("the convention `{}`: {message}", convention.name));
    let name = format!("{}.lts", convention.name);
    let mut files = MemoryFiles::default();
    files.insert(name.as_str(), convention.text);
    IMAGES.iter().for_each(|(name, bytes)| files.insert(*name, *bytes));
    let path = VPath::resolve("", &name).map_err(|error| fault(error.to_string()))?;
    let set = view.set.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
    let overrides = Overrides {
        width: view.size.map(|(width, _)| width),
        height: view.size.map(|(_, height)| height),
        max_depth: view.depth,
        set: set.collect(),
        ..Overrides::default()
    };
    let options = Options { overrides, levels, ..Options::default() };
    let checked = pipeline::check(&files, &mut Sources::default(), &path, &options);
    match checked.findings.iter().find(|finding| finding.severity == Severity::Error) {
        Some(finding) => Err(fault(finding.message.clone())),
        None => Ok(checked),
    }
}

/// The scene of a view, ready for emitters.
pub fn prepared(convention: &Convention, view: &View) -> Result<Valid, Failure> {
    let fault = |message: &str| Failure::new(Exit::Fault, format!("the convention `{}`: {message}", convention.name));
    let scene: Scene = read(convention, view)?.scene.ok_or_else(|| fault("it gives no scene"))?;
    let (scene, _) = pipeline::prepare(scene)
        .map_err(|findings| fault(findings.first().map_or("it is not valid", |finding| finding.message.as_str())))?;
    Ok(scene)
}

/// What the convention says in words.
pub fn documentation(convention: &Convention) -> Result<Documentation, Failure> {
    let view = View::plain(&[]);
    let scene = read(convention, &view)?.scene;
    scene
        .map(|scene| scene.documentation)
        .ok_or_else(|| Failure::new(Exit::Fault, format!("the convention `{}` gives no scene", convention.name)))
}
