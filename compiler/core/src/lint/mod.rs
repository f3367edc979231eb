//! Portability rules: what renderers agree on, and where a scene leaves that ground. Lint only judges a Scene.
//!
//! A rule is a file with its page (`DOC`), and a line in [`RULES`].

mod black_surface;
mod camera_in_dielectric;
mod camera_inside_mesh;
mod dark_emitter;
mod degenerate_triangles;
mod dielectric_contact;
mod duplicate_triangles;
mod emitter_facing_away;
mod emitter_in_wall;
mod far_from_origin;
mod flipped_normals;
mod inside_out_dielectric;
mod inside_out_mesh;
mod large_extent;
mod large_mesh;
mod leaning_normals;
mod long_brief;
mod many_materials;
mod mirroring_transform;
mod misplaced_mesh;
mod missing_normals;
mod needless_triangles;
mod non_basic_material;
mod non_mesh_emitter;
mod non_unit_normals;
mod nothing_in_view;
mod odd_field_of_view;
mod one_sided_similar;
mod one_sided_surface;
mod open_dielectric;
mod out_of_gamut;
mod out_of_range_distance;
mod outside_not_air;
mod overlapping_faces;
mod reflectance_over_one;
mod rough_too_small;
mod same_paths;
mod saturated_albedo;
mod smooth_emitter;
mod undocumented_scene;
mod unknown_similar;
mod unlit_scene;
mod unreachable_paths;
mod unused_name;
mod wide_roughness;

use std::cell::OnceCell;
use std::collections::BTreeMap;

use crate::contact::Contacts;
use crate::diag::{CODES, Finding, Label, Origin, Severity, Span, nearest};
use crate::ir::{Camera, Handle, Mesh, Scene, Scenes};
use crate::mesh::{Faults, View, faults, is_closed};
use crate::survey::{Placed, Survey};

/// What happens to the findings of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// They are dropped.
    Allow,
    /// They are shown.
    Warn,
    /// They are shown and make the answer no.
    Deny,
}

impl Level {
    /// The level called `word`.
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "allow" => Some(Self::Allow),
            "warn" => Some(Self::Warn),
            "deny" => Some(Self::Deny),
            _ => None,
        }
    }

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Self::Allow => "allow",
            Self::Warn => "warn",
            Self::Deny => "deny",
        }
    }

    fn severity(self) -> Severity {
        match self {
            Self::Allow => Severity::Allow,
            Self::Warn => Severity::Warn,
            Self::Deny => Severity::Deny,
        }
    }
}

/// A rule.
pub struct Rule {
    /// Its code, which reads well after "allow".
    pub id: &'static str,
    /// Its level unless the project or the command line says otherwise.
    pub level: Level,
    /// One sentence.
    pub summary: &'static str,
    /// Its page in Markdown: what, why with the renderer and source, bad, good, targets.
    pub doc: &'static str,
    /// The targets whose renderers it exists for; empty for a rule that holds for all.
    pub targets: &'static [&'static str],
    /// Looks at a scene.
    check: fn(&Subject<'_>, &mut Report),
}

impl Rule {
    /// Whether the rule matters where only `targets` are asked for; no targets are all.
    pub fn concerns(&self, targets: &[&str]) -> bool {
        targets.is_empty() || self.targets.is_empty() || self.targets.iter().any(|own| targets.contains(own))
    }
}

/// A name that a scene's text declares in vain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnusedName {
    /// The word of its declaration.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// Where it is declared.
    pub span: Span,
}

/// What rules know beside the Scene.
#[derive(Clone, Debug, Default)]
pub struct Around {
    /// The documentation of the project's scenes by name, this one's included; empty where a scene is looked at alone.
    pub scenes: Scenes,
    /// Names that the text declares in vain.
    pub unused: Vec<UnusedName>,
    /// Where mesh files with normals of another length than 1 are read, and what was done about it.
    pub lengthened: Vec<(Span, String)>,
}

/// What a rule looks at. What several rules ask for is made once, when the first one asks.
struct Subject<'a> {
    scene: &'a Scene,
    around: &'a Around,
    /// What is asked for; empty for all.
    targets: &'a [&'a str],
    survey: OnceCell<Survey<'a>>,
    /// By mesh.
    faults: Vec<OnceCell<Faults>>,
    /// By mesh.
    closed: Vec<OnceCell<bool>>,
    contacts: OnceCell<Contacts>,
}

impl<'a> Subject<'a> {
    fn of(scene: &'a Scene, around: &'a Around, targets: &'a [&'a str]) -> Self {
        let meshes = scene.meshes.len();
        Self {
            scene,
            around,
            targets,
            survey: OnceCell::new(),
            faults: vec![OnceCell::new(); meshes],
            closed: vec![OnceCell::new(); meshes],
            contacts: OnceCell::new(),
        }
    }

    /// Whether a target is asked for.
    fn asks_for(&self, target: &str) -> bool {
        self.targets.is_empty() || self.targets.contains(&target)
    }

    /// What lies where.
    fn survey(&self) -> &Survey<'a> {
        self.survey.get_or_init(|| Survey::of(self.scene))
    }

    /// Where surfaces lie in or next to each other.
    fn contacts(&self) -> &Contacts {
        self.contacts.get_or_init(|| Contacts::of(self.survey()))
    }

    /// The area of a use in the scene; under a transform that stretches, about that.
    fn area(&self, placed: &Placed<'_>) -> f64 {
        let scale = libm::cbrt(placed.transform.determinant().abs());
        self.faults(placed.shape.mesh).area * scale * scale
    }

    /// Measures and faults of a mesh that is in the scene.
    fn faults(&self, mesh: Handle<Mesh>) -> &Faults {
        self.faults[mesh.index()].get_or_init(|| faults(View::from(&self.scene.meshes[mesh])))
    }

    /// Whether a mesh that is in the scene is closed.
    fn is_closed(&self, mesh: Handle<Mesh>) -> bool {
        *self.closed[mesh.index()].get_or_init(|| is_closed(View::from(&self.scene.meshes[mesh])))
    }

    /// Whether a mesh that is in the scene is closed and looks inwards. Flat ones have no inside.
    fn is_inside_out(&self, mesh: Handle<Mesh>) -> bool {
        let Faults { area, volume, .. } = *self.faults(mesh);
        // Most meshes have a positive volume, and need no closer look.
        volume < -1e-6 * area * area.sqrt() && self.is_closed(mesh)
    }
}

/// All rules, by name.
pub static RULES: &[Rule] = &[
    black_surface::RULE,
    camera_in_dielectric::RULE,
    camera_inside_mesh::RULE,
    dark_emitter::RULE,
    degenerate_triangles::RULE,
    dielectric_contact::RULE,
    duplicate_triangles::RULE,
    emitter_facing_away::RULE,
    emitter_in_wall::RULE,
    far_from_origin::RULE,
    flipped_normals::RULE,
    inside_out_dielectric::RULE,
    inside_out_mesh::RULE,
    large_extent::RULE,
    large_mesh::RULE,
    leaning_normals::RULE,
    long_brief::RULE,
    many_materials::RULE,
    mirroring_transform::RULE,
    misplaced_mesh::RULE,
    missing_normals::RULE,
    needless_triangles::RULE,
    non_basic_material::RULE,
    non_mesh_emitter::RULE,
    non_unit_normals::RULE,
    nothing_in_view::RULE,
    odd_field_of_view::RULE,
    one_sided_similar::RULE,
    one_sided_surface::RULE,
    open_dielectric::RULE,
    out_of_gamut::RULE,
    out_of_range_distance::RULE,
    outside_not_air::RULE,
    overlapping_faces::RULE,
    reflectance_over_one::RULE,
    rough_too_small::RULE,
    same_paths::RULE,
    saturated_albedo::RULE,
    smooth_emitter::RULE,
    undocumented_scene::RULE,
    unknown_similar::RULE,
    unlit_scene::RULE,
    unreachable_paths::RULE,
    unused_name::RULE,
    wide_roughness::RULE,
];

/// Levels that differ from the built-in ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    codes: BTreeMap<&'static str, Level>,
    /// What becomes of everything that would be a warning.
    warnings: Option<Level>,
}

/// Why something has no level to be chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelError {
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: String,
}

impl Levels {
    /// Names that stand for several codes, with what they mean.
    pub const GROUPS: &[(&str, &str)] =
        &[("all", "every rule"), ("warnings", "everything that would be a warning, rule or not")];

    /// Chooses the level of a rule, of another warning or remark, or of a group.
    ///
    /// # Errors
    /// There is no such code, or it is always an error.
    pub fn set(&mut self, name: &str, level: Level) -> Result<(), LevelError> {
        match name {
            "all" => self.codes.extend(RULES.iter().map(|rule| (rule.id, level))),
            "warnings" => self.warnings = Some(level),
            _ => {
                self.codes.insert(has_level(name)?, level);
            }
        }
        Ok(())
    }

    /// Whether someone has chosen the level of this rule.
    pub fn names(&self, code: &str) -> bool {
        self.codes.contains_key(code)
    }

    /// The level of `rule`.
    pub fn of(&self, rule: &Rule) -> Level {
        let level = self.codes.get(rule.id).copied().unwrap_or(rule.level);
        if level == Level::Warn { self.warnings.unwrap_or(level) } else { level }
    }

    /// Whether `rule` looks at a scene at all where only `targets` are asked for.
    pub fn ask(&self, rule: &Rule, targets: &[&str]) -> bool {
        rule.concerns(targets) && self.of(rule) != Level::Allow
    }

    /// Gives findings that no rule made, and that are no errors, the levels chosen for them.
    pub fn judge(&self, findings: &mut [Finding]) {
        let open = |finding: &&mut Finding| finding.severity != Severity::Error && find(finding.id).is_none();
        for finding in findings.iter_mut().filter(open) {
            if let Some(level) = self.codes.get(finding.id) {
                finding.severity = level.severity();
            }
            if let Some(level) = self.warnings.filter(|_| finding.severity == Severity::Warn) {
                finding.severity = level.severity();
            }
        }
    }
}

/// The code called `name`, if its level can be chosen.
fn has_level(name: &str) -> Result<&'static str, LevelError> {
    if let Some(rule) = find(name) {
        return Ok(rule.id);
    }
    match CODES.iter().find(|code| code.id == name) {
        Some(code) if code.leveled => Ok(code.id),
        Some(code) => Err(LevelError {
            message: format!("`{}` is always an error", code.id),
            help: "levels are chosen for rules, warnings and remarks".to_owned(),
        }),
        None => {
            let codes = CODES.iter().filter(|code| code.leveled).map(|code| code.id);
            let known =
                RULES.iter().map(|rule| rule.id).chain(codes).chain(Levels::GROUPS.iter().map(|(name, _)| *name));
            Err(LevelError {
                message: format!("there is no rule `{name}`"),
                help: match nearest(name, known) {
                    Some(similar) => format!("did you mean `{similar}`?"),
                    None => {
                        "`ltsc explain` lists the rules and other findings; `all` and `warnings` are groups".to_owned()
                    }
                },
            })
        }
    }
}

/// Where a rule puts what it finds.
struct Report {
    id: &'static str,
    severity: Severity,
    findings: Vec<Finding>,
}

impl Report {
    /// Adds a finding of the rule at `origin`, and gives it back for further places.
    fn add(&mut self, origin: &Origin, message: String, label: &str, note: &str, help: String) -> &mut Finding {
        let finding = Finding::new(self.id, self.severity, origin.clone(), message).label(label).note(note).help(help);
        self.findings.push(finding);
        let last = self.findings.len() - 1;
        &mut self.findings[last]
    }

    /// Findings of one place become one: a loop may make a thousand shapes from one statement. Those about the scene as a
    /// whole, whose place is `scene`, stay apart.
    fn merged(self, scene: &Origin) -> Vec<Finding> {
        let mut first: BTreeMap<Origin, usize> = BTreeMap::new();
        let mut merged: Vec<(Finding, usize)> = Vec::new();
        for finding in self.findings {
            if finding.origin == Origin::Made || finding.origin == *scene {
                merged.push((finding, 0));
                continue;
            }
            match first.get(&finding.origin) {
                Some(at) => merged[*at].1 += 1,
                None => {
                    first.insert(finding.origin.clone(), merged.len());
                    merged.push((finding, 0));
                }
            }
        }
        let count = |(mut finding, more): (Finding, usize)| {
            if more > 0 {
                finding.notes.push(format!("the same holds for {more} more that this statement makes"));
            }
            finding
        };
        merged.into_iter().map(count).collect()
    }
}

/// Adds a second place, where it is one of a text.
fn also(finding: &mut Finding, origin: &Origin, text: &str) {
    if let Some(span) = origin.span() {
        finding.labels.push(Label { span, text: text.to_owned() });
    }
}

/// Two digits of a length are enough in a message.
fn short(length: f64) -> f64 {
    format!("{length:.1e}").parse().unwrap_or(length)
}

/// `1 triangle`, `2 triangles`.
fn plural(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// What messages call a camera.
fn called(camera: &Camera) -> String {
    camera.name.as_ref().map_or_else(|| "the camera".to_owned(), |name| format!("the camera `{name}`"))
}

/// Adds a second place unless it is there.
fn also_once(finding: &mut Finding, origin: &Origin, text: &str) {
    if origin.span() != finding.origin.span() && finding.labels.iter().all(|label| Some(label.span) != origin.span()) {
        also(finding, origin, text);
    }
}

/// The rule called `id`.
pub fn find(id: &str) -> Option<&'static Rule> {
    RULES.iter().find(|rule| rule.id == id)
}

/// What the rules find in `scene`, in the order of its text; rules that exist for none of `targets` are left out.
pub fn lint(scene: &Scene, around: &Around, levels: &Levels, targets: &[&str]) -> Vec<Finding> {
    let subject = Subject::of(scene, around, targets);
    let mut findings = Vec::new();
    for rule in RULES.iter().filter(|rule| levels.ask(rule, targets)) {
        let mut report = Report { id: rule.id, severity: levels.of(rule).severity(), findings: Vec::new() };
        (rule.check)(&subject, &mut report);
        findings.extend(report.merged(&scene.origin));
    }
    findings.sort_by_key(|finding| finding.origin.span());
    findings
}
