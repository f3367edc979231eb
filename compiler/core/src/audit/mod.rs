//! The energy audit: what the files of a target say, read back from their text, against the Scene.
//!
//! A number that only went through text is the same to 1e-9 of itself ([`TEXT`]): texts hold the shortest form that reads back as
//! the same double, and readers and writers do a few operations on it. Meshes are the same to the bit, since both sides hold the same
//! single-precision numbers; where a format moves vertices itself, `vertices` says how far their rounding takes them.
//! Where a target says of itself that it is not exact, what is compared is the number that it was given to come near, and of
//! LuxCore's metals the reflectance, within what the fit says of that very metal.

mod look;
mod measure;
mod pictures;
mod settings;
mod vertices;
mod walk;

use std::collections::BTreeMap;

use crate::capability::{Feature, Support, features};
use crate::diag::{Finding, Origin, Severity};
use crate::files::{Files, VPath};
use crate::formats::Target;
use crate::formats::effective::Effective;
use crate::formats::shared::reading::{MeshPlace, Reading, Rgb};
use crate::formats::shared::source::Source;
use crate::formats::statements::Statements;
use crate::ir::{Affine, Bsdf, Camera, Emission, Group, Handle, Instance, Material, Mesh, Scene, Shape, Vec3};
use crate::mesh;

pub use look::{ANGLES, TEXT};
pub use measure::Measure;

/// The code of a finding that a file says something else than the scene.
pub const MISMATCH: &str = "audit-mismatch";

/// Findings of one target before the rest is only counted.
const SHOWN: usize = 20;

/// Sums over a scene, from the Scene or from files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Surfaces, those of groups once for each place.
    pub surfaces: u64,
    /// Places of groups; none of a format without groups.
    pub instances: u64,
    /// Area of all surfaces; none where a map does not keep angles and the mesh was not measured again.
    pub area: Option<f64>,
    /// Emitting surfaces.
    pub emitters: u64,
    /// Their area.
    pub emitting_area: f64,
    /// What they emit in W, per channel.
    pub power: Rgb,
    /// Lights without a surface.
    pub lights: u64,
}

/// What one emitter emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emits {
    /// Radiance times area times pi, in W per channel; twice that where both sides emit.
    pub power: Rgb,
    /// Area in scene units squared.
    pub area: f64,
    /// The mean normal of the emitting side by area: a unit vector for a plane, zero for what is closed.
    pub facing: Vec3,
    /// Mean place by area.
    pub center: Vec3,
}

/// What an audit of the files of one target says.
#[derive(Clone, Debug)]
pub struct Audit {
    /// The target.
    pub target: &'static str,
    /// By the files.
    pub said: Sums,
    /// Each emitter with its place among the scene's shapes, by the files.
    pub emitters: Vec<(usize, Emits)>,
    /// Materials that surfaces of the scene have, and that were compared.
    pub materials: usize,
    /// Angles of incidence at which they were, all materials together.
    pub angles: usize,
    /// Segments of a path by the files.
    pub max_depth: Option<u32>,
    /// Full horizontal angle of view in degrees by the files.
    pub fov_x: Option<f64>,
    /// Width and height by the files.
    pub film: Option<[u32; 2]>,
    /// The settings with which the image is rendered.
    pub effective: Effective,
    /// What the scene asks for and the target says of itself that it cannot say: what is left is what was compared.
    pub lost: Vec<Lost>,
    /// What differs, and what could not be read.
    pub findings: Vec<Finding>,
}

/// Something of a scene that a target cannot say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// What it is.
    pub what: &'static str,
    /// What is missing.
    pub why: &'static str,
}

impl Audit {
    /// Whether the files say what the scene says, but for what was lost.
    pub fn agrees(&self) -> bool {
        self.findings.is_empty()
    }

    /// `agrees`, `agrees, but for 2 losses`, `DIFFERS`.
    pub fn verdict(&self) -> String {
        match (self.agrees(), self.lost.len()) {
            (false, _) => "DIFFERS".to_owned(),
            (true, 0) => "agrees".to_owned(),
            (true, 1) => "agrees, but for 1 loss".to_owned(),
            (true, many) => format!("agrees, but for {many} losses"),
        }
    }

    /// The verdict with the names of what was lost: `agrees, but for 2 losses: an environment, path tracing`.
    pub fn whole_verdict(&self) -> String {
        if !self.agrees() || self.lost.is_empty() {
            return self.verdict();
        }
        let names: Vec<&str> = self.lost.iter().map(|lost| lost.what).collect();
        format!("{}: {}", self.verdict(), names.join(", "))
    }
}

/// A scene beside what was written of it.
#[derive(Clone, Debug)]
pub struct Audited {
    /// Sums of the scene.
    pub asked: Sums,
    /// Each emitter with its place among the scene's shapes, by the scene.
    pub emitters: Vec<(usize, Emits)>,
    /// The targets.
    pub targets: Vec<Audit>,
}

impl Audited {
    /// Everything that differs or could not be read.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.targets.iter().flat_map(|audit| &audit.findings)
    }
}

/// What a scene asks for, measured once for all its targets.
pub struct Asked<'s> {
    scene: &'s Scene,
    camera: Handle<Camera>,
    measures: Vec<Measure>,
    groups: Vec<Vec<&'s Shape>>,
    shapes: Vec<&'s Shape>,
    /// How large coordinates become.
    reach: f64,
    /// Sums of the scene.
    pub sums: Sums,
    /// Each emitter with its place among the scene's shapes.
    pub emitters: Vec<(usize, Emits)>,
}

impl<'s> Asked<'s> {
    /// Measures a scene that was lowered and validated.
    pub fn new(scene: &'s Scene, camera: Handle<Camera>) -> Self {
        let measures: Vec<Measure> = scene.meshes.values().map(|mesh| Measure::whole(mesh.into())).collect();
        let of = |group: &'s Group| {
            let Group { name: _, shapes, instances: _ } = group;
            shapes.values().collect()
        };
        let mut asked = Self {
            scene,
            camera,
            measures,
            groups: scene.groups.values().map(of).collect(),
            shapes: scene.shapes.values().collect(),
            reach: 0.0,
            sums: Sums::default(),
            emitters: Vec::new(),
        };
        asked.sum();
        asked
    }

    fn sum(&mut self) {
        let Camera { name: _, eye, target: _, up: _, fov_x: _, near: _, far: _ } = &self.scene.cameras[self.camera];
        let mut reach = eye.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut sums = Sums { area: Some(0.0), lights: self.scene.lights.len() as u64, ..Sums::default() };
        let mut see = |measure: &Measure, map: &Affine| {
            for corner in measure.corners() {
                reach = map.point(corner).iter().fold(reach, |most, x| most.max(x.abs()));
            }
        };
        for (at, shape) in self.shapes.iter().enumerate() {
            let Shape { name: _, mesh, transform, material: _, emission } = shape;
            let measure = &self.measures[mesh.index()];
            see(measure, transform);
            sums.surfaces += 1;
            let placed = placed(measure, &self.scene.meshes[*mesh], transform);
            sums.area = sums.area.map(|area| area + placed.area);
            if let Some(Emission { radiance }) = emission {
                let emits = emits(&placed, radiance.rgb(), true, 1.0);
                sums.emitters += 1;
                sums.emitting_area += emits.area;
                sums.power = [0, 1, 2].map(|channel| sums.power[channel] + emits.power[channel]);
                self.emitters.push((at, emits));
            }
        }
        for instance in self.scene.instances.values() {
            let Instance { name: _, group, places } = instance;
            let shapes = &self.groups[group.index()];
            let own: f64 = shapes
                .iter()
                .map(|shape| {
                    placed(&self.measures[shape.mesh.index()], &self.scene.meshes[shape.mesh], &shape.transform)
                })
                .map(|measure| measure.area)
                .sum();
            for place in places.maps() {
                sums.instances += 1;
                sums.surfaces += shapes.len() as u64;
                sums.area = measure::area_factor(place).and_then(|factor| Some(sums.area? + own * factor));
                for shape in shapes {
                    see(&self.measures[shape.mesh.index()], &shape.transform.then(place));
                }
            }
        }
        self.reach = reach;
        self.sums = sums;
    }

    /// How far places may be apart that went through text.
    fn slack(&self) -> f64 {
        TEXT * self.reach.max(f64::MIN_POSITIVE)
    }

    fn material(&self, shape: &Shape) -> &'s Bsdf {
        let Material { name: _, bsdf, sides: _ } = &self.scene.materials[shape.material];
        bsdf
    }
}

/// A mesh at its place.
fn placed(measure: &Measure, mesh: &Mesh, map: &Affine) -> Measure {
    measure.placed(map).unwrap_or_else(|| Measure::of(mesh.into(), map))
}

/// What a surface emits; `sides` is 1 or 2, negative where the back emits.
fn emits(placed: &Measure, radiance: Rgb, by_normals: bool, sides: f64) -> Emits {
    Emits {
        power: radiance.map(|channel| channel * placed.area * std::f64::consts::PI * sides.abs()),
        area: placed.area,
        facing: placed.facing(by_normals).map(|x| x * sides.signum()),
        center: placed.center,
    }
}

/// Measures of mesh files, each read once for all targets of a scene.
pub struct Meshes<'f> {
    files: &'f dyn Files,
    known: BTreeMap<VPath, Result<Measure, Box<Finding>>>,
}

impl<'f> Meshes<'f> {
    /// Reads from `files`.
    pub fn new(files: &'f dyn Files) -> Self {
        Self { files, known: BTreeMap::new() }
    }

    fn measure(&mut self, path: &VPath) -> Result<Measure, Box<Finding>> {
        if let Some(known) = self.known.get(path) {
            return known.clone();
        }
        let found = self.read(path).map(|geometry| Measure::whole((&geometry).into()));
        self.known.insert(path.clone(), found.clone());
        found
    }

    fn read(&self, path: &VPath) -> Result<mesh::Geometry, Box<Finding>> {
        let fault = |place: String, message: String| {
            let origin = Origin::File { path: path.as_str().to_owned(), place };
            Box::new(Finding::error(crate::formats::shared::source::REFERENCE, origin, message))
        };
        let bytes = self.files.read(path, u64::MAX);
        let bytes = bytes.map_err(|problem| fault(String::new(), format!("the mesh cannot be read: {problem}")))?;
        if path.extension() == "ply" && !is_plain(&bytes) {
            let message = "the corners of its triangles are no `vertex_indices`, which some renderers ask for";
            return Err(fault("header".to_owned(), message.to_owned()));
        }
        let (geometry, notes) = mesh::file::read(&path.extension(), &bytes, None, &mut mesh::file::alone)
            .map_err(|problem| fault(problem.place, problem.message))?;
        // What a reader mends, another one may take as it is.
        match notes.into_iter().next() {
            None => Ok(geometry),
            Some(note) => Err(fault(String::new(), note.message)),
        }
    }
}

/// Whether a PLY file names its triangles as all renderers know them.
fn is_plain(bytes: &[u8]) -> bool {
    let head = bytes.windows(10).position(|window| window == b"end_header").unwrap_or(0);
    let mut lines = bytes[..head].split(|byte| *byte == b'\n');
    lines.any(|line| line == b"property list uchar int vertex_indices")
}

/// Reads the files of `target`, which has a reader, in `folder` (below the root of what `meshes` reads from, empty for the root) and compares them with the scene.
/// What was written in the words of `given` is not that of the scene, and not compared.
pub fn audit(
    asked: &Asked<'_>,
    target: &'static Target,
    folder: &str,
    given: &Statements,
    meshes: &mut Meshes<'_>,
) -> Audit {
    let name = target.main_file_of(&asked.scene.name);
    let mut found = Found { target: target.name, main: name.clone(), now: name.clone(), findings: Vec::new(), more: 0 };
    let mut audit = Audit {
        target: target.name,
        said: Sums::default(),
        emitters: Vec::new(),
        materials: 0,
        angles: 0,
        max_depth: None,
        fov_x: None,
        film: None,
        effective: Effective::default(),
        lost: lost(asked.scene, target),
        findings: Vec::new(),
    };
    let (Ok(main), Some(import)) = (VPath::resolve(folder, &name), target.import) else {
        found.differs(format!("the file `{name}` has no place below `{folder}`, or no reader"));
        audit.findings = found.finish();
        return audit;
    };
    found.main = main.as_str().to_owned();
    found.stands_in(None);
    let mut source = Source::with(meshes.files, given);
    let reading = import(&main, &mut source);
    let (unread, passed) = source.finish_all();
    let passed = passed.into_iter().map(|finding| finding.message).collect();
    audit.effective = Effective { passed, ..Effective::of(target.name, &reading) };
    (audit.max_depth, audit.film) = (reading.max_depth, reading.film);
    audit.fov_x = reading.view.map(|view| view.fov_x);
    if unread.is_empty() {
        compare(asked, target, &reading, meshes, (&mut audit, &mut found));
    }
    audit.said.lights = reading.lights.len() as u64;
    audit.findings = unread;
    audit.findings.extend(found.finish());
    audit
}

/// Everything that was read, held against the scene.
fn compare(
    asked: &Asked<'_>,
    target: &Target,
    reading: &Reading,
    meshes: &mut Meshes<'_>,
    (audit, found): (&mut Audit, &mut Found),
) {
    settings::compare(asked, target, reading, found);
    walk::compare(asked, target, reading, meshes, audit, found);
    pictures::compare(asked, target, reading, meshes.files, found);
}

/// What of a scene a target cannot say.
fn lost(scene: &Scene, target: &Target) -> Vec<Lost> {
    let of = |(feature, _): (Feature, Origin)| match (target.supports)(feature) {
        Support::Unsupported { why } => Some(Lost { what: feature.name(), why }),
        Support::Exact | Support::Approximate { why: _, bound: _ } => None,
    };
    features(scene).into_iter().filter_map(of).collect()
}

/// Whether a target says of itself that it has no exact way.
fn inexact(support: &Support) -> bool {
    match support {
        Support::Exact => false,
        Support::Approximate { why: _, bound: _ } | Support::Unsupported { why: _ } => true,
    }
}

fn unsupported(support: &Support) -> bool {
    match support {
        Support::Exact | Support::Approximate { why: _, bound: _ } => false,
        Support::Unsupported { why: _ } => true,
    }
}

/// What was found to differ.
struct Found {
    target: &'static str,
    main: String,
    /// The file that is named: the main one, or the included one in which what is compared stands.
    now: String,
    findings: Vec<Finding>,
    more: usize,
}

impl Found {
    /// What is found from here on stands in this file, or in the main one.
    fn stands_in(&mut self, file: Option<&VPath>) {
        self.now = file.map_or_else(|| self.main.clone(), |file| file.as_str().to_owned());
    }

    fn differs(&mut self, message: impl Into<String>) {
        if self.findings.len() == SHOWN {
            self.more += 1;
            return;
        }
        let origin = Origin::File { path: self.now.clone(), place: String::new() };
        let finding = Finding::new(MISMATCH, Severity::Deny, origin, message.into());
        self.findings.push(finding.note(format!("read back from what was written for {}", self.target)));
    }

    fn finish(mut self) -> Vec<Finding> {
        if self.more > 0 {
            let more = self.more;
            let origin = Origin::File { path: self.main.clone(), place: String::new() };
            let message = format!("{more} more things differ from the scene");
            self.findings.push(Finding::new(MISMATCH, Severity::Deny, origin, message));
        }
        self.findings
    }
}

/// The measure of each mesh of a reading; what cannot be read is a finding, once.
fn measured(reading: &Reading, meshes: &mut Meshes<'_>, found: &mut Found) -> Vec<Option<Measure>> {
    let of = |source: &crate::formats::shared::reading::MeshSource| match &source.place {
        MeshPlace::File(path) => match meshes.measure(path) {
            Ok(measure) => Some(measure),
            Err(finding) => {
                found.findings.push(*finding);
                None
            }
        },
        MeshPlace::Here(geometry) => Some(Measure::whole(geometry.into())),
    };
    reading.meshes.iter().map(of).collect()
}

#[cfg(test)]
mod comparison_tests;
#[cfg(test)]
mod mesh_tests;
#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod tests;
