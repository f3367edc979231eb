//! Items and settings: shapes, emitters, instances, cameras, film, integrator, sampler.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::diag::{Finding, Span};
use crate::ir::{GROUP_DEPTH, LightKind, Places};
use crate::syntax::{Expr, Kind, Name};

use super::module::{Module, Scope};
use super::table::Family;
use super::value::{EmissionValue, GroupValue, MaterialValue, MeshValue, Value};
use super::{Interpreter, Limit, Reported};

/// A shape or an emitter.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub name: String,
    pub span: Span,
    pub mesh: MeshValue,
    pub material: Option<Rc<MaterialValue>>,
    pub emission: Option<Rc<EmissionValue>>,
}

/// A light without a surface.
#[derive(Clone, Debug)]
pub(super) struct Lit {
    pub name: String,
    pub span: Span,
    pub kind: LightKind,
}

/// An instance.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub name: String,
    pub span: Span,
    pub group: GroupValue,
}

/// The shapes, emitters and instances of a group. Equal calls of a parametric group are one.
#[derive(Debug)]
pub(super) struct GroupBody {
    pub name: String,
    pub span: Span,
    pub items: Vec<Item>,
    pub lights: Vec<Lit>,
    pub instances: Vec<Placed>,
    /// Shapes and instances that placing it makes, those of inner groups included.
    pub size: u64,
    /// How many groups lie within each other, this one included.
    pub depth: usize,
    /// Whether it holds lights, itself or in inner groups.
    pub lit: bool,
}

/// The names of instances, with how many places each has if it is scattered.
#[derive(Debug, Default)]
pub(super) struct InstanceNames(BTreeMap<String, (Span, Option<usize>)>);

impl InstanceNames {
    /// Takes `name`, for as many places as `many` if it is scattered. Where a place is called as one that is known, that
    /// name and where it was taken.
    fn add(&mut self, name: &str, many: Option<usize>, span: Span) -> Option<(String, Span)> {
        if let Some((first, _)) = self.0.get(name) {
            return Some((name.to_owned(), *first));
        }
        // `oak[17]` is one of many places of `oak` too, or a name of its own.
        if let Some((base, at)) = split_number(name)
            && let Some((first, Some(count))) = self.0.get(base)
            && at < *count
        {
            return Some((name.to_owned(), *first));
        }
        if let Some(count) = many {
            let open = format!("{name}[");
            let later = self.0.range(open.clone()..).take_while(|(known, _)| known.starts_with(&open));
            for (known, (first, _)) in later {
                if split_number(known).is_some_and(|(base, at)| base == name && at < count) {
                    return Some((known.clone(), *first));
                }
            }
        }
        self.0.insert(name.to_owned(), (span, many));
        None
    }
}

/// `oak[17]` as `oak` and 17.
fn split_number(name: &str) -> Option<(&str, usize)> {
    let (base, number) = name.strip_suffix(']')?.rsplit_once('[')?;
    let at: usize = number.parse().ok()?;
    (at.to_string() == number).then_some((base, at))
}

impl Interpreter<'_> {
    /// `instance name = group |> moves`
    pub(super) fn instance(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        name: Option<&Name>,
        value: &Expr,
        span: Span,
    ) {
        let group = match self.eval(scope, value, Some(Family::Group)) {
            Ok(Value::Group(group)) => group,
            Ok(Value::Function(function)) if function.makes_groups() => {
                self.findings.push(
                    Finding::error(
                        "missing-argument",
                        value.span,
                        format!("the group `{}` has parameters", function.name),
                    )
                    .help(format!("write `{}(...)` with its arguments", function.name)),
                );
                return;
            }
            Ok(found) => {
                let message = format!("`instance` takes a group, not {}", found.kind());
                let finding = Finding::error("type-mismatch", value.span, message).label(found.kind());
                let mesh = matches!(found, Value::Mesh(_));
                self.findings.push(if mesh {
                    finding.help("write `shape name = ... with ...` for a mesh")
                } else {
                    finding
                });
                return;
            }
            Err(Reported) => return,
        };
        let Some(name) = name else { return };
        let text = module.item_name(name);
        let many = if let Places::Many(maps) = &group.places { Some(maps.len()) } else { None };
        if let Some((text, first)) = module.instance_names.add(&text, many, name.span) {
            let message = format!("two instances are named `{text}`");
            self.findings
                .push(Finding::error("duplicate-name", name.span, message).label("again").also(first, "first here"));
            return;
        }
        let made = group.body.size.saturating_add(1).saturating_mul(group.places.maps().len() as u64);
        if !self.grow(module, made, span) {
            return;
        }
        module.group_depth = module.group_depth.max(group.body.depth + 1);
        if module.group_depth > GROUP_DEPTH {
            let message = format!("groups hold each other more than {GROUP_DEPTH} levels deep");
            self.findings.push(Finding::error("nesting-limit", span, message));
            return;
        }
        module.instances.push(Placed { name: text, span, group });
    }

    /// Adds `more` shapes and instances to the size of what is evaluated; false where it is too large then, which is reported
    /// once.
    fn grow(&mut self, module: &mut Module, more: u64, span: Span) -> bool {
        let (before, most) = (module.size, self.limits.instances);
        module.size = before.saturating_add(more);
        if module.size > most && before <= most {
            let message = format!("the scene has more than {most} shapes and instances");
            self.findings.push(
                Finding::error("instance-limit", span, message)
                    .label("reached here")
                    .note("instances within groups count as often as their group is placed")
                    .help(Limit::help("instances")),
            );
        }
        module.size <= most
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one statement")]
    pub(super) fn item(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        kind: Kind,
        name: Option<&Name>,
        value: &Expr,
        with: Option<&Expr>,
        span: Span,
    ) {
        let bare = kind == Kind::Emitter && with.is_none();
        let found = self.eval(scope, value, Some(if bare { Family::Light } else { Family::Mesh }));
        if kind == Kind::Emitter
            && let Ok(Value::Light(light)) = &found
        {
            self.light(module, name, light, with, span);
            return;
        }
        // What was meant for a light must not be told to have a surface.
        if bare && found.is_err() {
            return;
        }
        let mesh = found.and_then(|found| match found {
            Value::Mesh(mesh) => Ok(rename_made(mesh, name)),
            Value::Light(light) => self.report(
                Finding::error("type-mismatch", value.span, "`shape` takes a mesh, not a light")
                    .label("a light")
                    .note(format!("`{}` has no surface", light.word()))
                    .help("write `emitter name = ...` without `with`"),
            ),
            found => {
                let word = kind.word();
                let message = format!("`{word}` takes a mesh, not {}", found.kind());
                let finding = Finding::error("type-mismatch", value.span, message).label(found.kind());
                let group = matches!(found, Value::Group(_)) && kind == Kind::Shape;
                self.report(if group { finding.help("write `instance name = ...` without `with`") } else { finding })
            }
        });
        let Some(with) = with else {
            let (what, example) = if kind == Kind::Shape {
                ("a shape needs `with <material>`", "write for example `... with diffuse(0.5)`")
            } else {
                ("an emitter needs `with <radiance>`", "write for example `... with radiance(30)`")
            };
            self.findings.push(Finding::error("missing-with", span, what).label("no surface is given").help(example));
            return;
        };
        let family = if kind == Kind::Shape { Family::Material } else { Family::Emission };
        let surface = self.eval(scope, with, Some(family)).and_then(|found| match (kind, found) {
            (Kind::Shape, Value::Material(material)) => Ok((Some(material), None)),
            (Kind::Emitter, Value::Emission(emission)) => Ok((None, Some(emission))),
            (Kind::Shape, Value::Emission(_)) => self.report(
                Finding::error("type-mismatch", with.span, "a shape takes a material, not an emission")
                    .label("an emission")
                    .help("write `emitter name = ...`"),
            ),
            (_, found) => {
                let wants =
                    if kind == Kind::Shape { "a shape takes a material" } else { "an emitter takes an emission" };
                let finding = Finding::error("type-mismatch", with.span, format!("{wants}, not {}", found.kind()))
                    .label(found.kind());
                self.report(if kind == Kind::Emitter {
                    finding.help("write for example `with radiance(30)`")
                } else {
                    finding
                })
            }
        });
        let (Ok(mesh), Ok((material, emission)), Some(name)) = (mesh, surface, name) else { return };
        let textured = material.iter().chain(emission.iter().filter_map(|emission| emission.over.as_ref()));
        for material in textured.filter(|material| material.bsdf.texture().is_some() && mesh.mesh.uvs.is_none()) {
            let mut finding = Finding::error(
                "missing-uvs",
                with.span,
                "a texture needs texture coordinates, and the mesh has none",
            )
            .label("this material has a texture")
            .also(mesh.span, "this mesh has no texture coordinates")
            .help("give `triangles` its `uvs`, export the file with texture coordinates, or give the material a color");
            if !(with.span.file == material.span.file
                && with.span.start <= material.span.start
                && material.span.end <= with.span.end)
            {
                finding = finding.also(material.span, "the material");
            }
            self.findings.push(finding);
        }
        let text = module.item_name(name);
        if let Some(first) = module.item_names.insert((emission.is_some(), text.clone()), name.span) {
            self.findings.push(
                Finding::error("duplicate-name", name.span, format!("two {}s are named `{text}`", kind.word()))
                    .label("again")
                    .also(first, "first here"),
            );
            return;
        }
        if !self.grow(module, 1, span) {
            return;
        }
        module.items.push(Item { name: text, span, mesh, material, emission });
    }

    /// `emitter name = light`
    fn light(&mut self, module: &mut Module, name: Option<&Name>, kind: &LightKind, with: Option<&Expr>, span: Span) {
        let word = kind.word();
        let everywhere = match kind {
            LightKind::Environment { radiance: _, tint: _, turn: _ } => Some("it shines from everywhere"),
            LightKind::Directional { direction: _, irradiance: _ } => Some("it shines from infinitely far away"),
            LightKind::Point { position: _, intensity: _ }
            | LightKind::Spot { position: _, target: _, intensity: _, angle: _, inner: _ } => None,
        };
        if let Some(with) = with {
            self.findings.push(
                Finding::error("misplaced-with", with.span, format!("`{word}` takes no `with`"))
                    .note("it has no surface, and its strength is one of its arguments")
                    .help("remove `with` and what stands behind it"),
            );
            return;
        }
        if let Some(why) = everywhere.filter(|_| module.group) {
            self.findings.push(
                Finding::error("misplaced-statement", span, format!("`{word}` stands in a group"))
                    .label("has no place that a group could give it")
                    .note(format!("a group is seen where instances place it, and {why}"))
                    .help("move it to the top level of the scene"),
            );
            return;
        }
        let Some(name) = name else { return };
        let text = module.item_name(name);
        if let Some(first) = module.item_names.insert((true, text.clone()), name.span) {
            self.findings.push(
                Finding::error("duplicate-name", name.span, format!("two emitters are named `{text}`"))
                    .label("again")
                    .also(first, "first here"),
            );
            return;
        }
        let sky = |light: &&Lit| matches!(light.kind, LightKind::Environment { radiance: _, tint: _, turn: _ });
        if let Some(first) = module.lights.iter().find(sky).filter(|_| matches!(kind, LightKind::Environment { .. })) {
            self.findings.push(
                Finding::error("second-environment", span, "there are two environments")
                    .label("again")
                    .also(first.span, "first here")
                    .note("Mitsuba refuses a second one")
                    .help("add their radiances: two constant environments are one"),
            );
            return;
        }
        if !self.grow(module, 1, span) {
            return;
        }
        module.lights.push(Lit { name: text, span, kind: kind.clone() });
    }

    pub(super) fn setting(
        &mut self,
        module: &mut Module,
        scope: &mut Scope,
        kind: Kind,
        name: Option<&Name>,
        value: &Expr,
        span: Span,
    ) {
        let family = match kind {
            Kind::Camera => Family::Camera,
            Kind::Film => Family::Film,
            Kind::Integrator => Family::Integrator,
            _ => Family::Sampler,
        };
        let Ok(found) = self.eval(scope, value, Some(family)) else {
            module.broken.push(kind);
            return;
        };
        let again = |first: Span| {
            Finding::error("duplicate-setting", span, format!("there are two {}s", kind.word()))
                .label("again")
                .also(first, "first here")
        };
        match (kind, found) {
            (Kind::Camera, Value::Camera(camera)) => {
                let own = name.map(|name| name.text.clone());
                let unnamed = own.is_none() || module.cameras.iter().any(|(name, _, _)| name.is_none());
                if let Some((_, _, first)) = module.cameras.iter().find(|(name, _, _)| unnamed || *name == own) {
                    self.findings
                        .push(again(*first).help("several cameras need different names: `camera above = ...`"));
                    return;
                }
                module.cameras.push((own, camera, span));
            }
            (Kind::Film, Value::Film(film)) => match module.film {
                Some((_, first)) => self.findings.push(again(first)),
                None => module.film = Some((film, span)),
            },
            (Kind::Integrator, Value::Integrator(integrator)) => match module.integrator {
                Some((_, first)) => self.findings.push(again(first)),
                None => module.integrator = Some((integrator, span)),
            },
            (Kind::Sampler, Value::Sampler(sampler)) => match module.sampler {
                Some((_, first)) => self.findings.push(again(first)),
                None => module.sampler = Some((sampler, span)),
            },
            (kind, found) => {
                module.broken.push(kind);
                let _reported: Result<(), Reported> = self.wrong_kind(kind, value.span, &found);
            }
        }
    }
}

/// A mesh takes the name of its declaration.
pub(super) fn rename(mesh: MeshValue, name: Option<&Name>) -> MeshValue {
    let Some(name) = name else { return mesh };
    let renamed = crate::ir::Mesh { name: name.text.clone(), ..(*mesh.mesh).clone() };
    MeshValue { mesh: Rc::new(renamed), ..mesh }
}

/// A mesh that was made in place takes the name of its shape; a declared one keeps its own.
fn rename_made(mesh: MeshValue, name: Option<&Name>) -> MeshValue {
    if mesh.mesh.name.is_empty() { rename(mesh, name) } else { mesh }
}
