//! The one table of constructors and functions: names, parameters, types, defaults and documentation. It drives
//! checking, suggestions, `ltsc explain` and the reference manual.

mod arrays;
mod functions;
mod generators;
mod groups;
mod lights;
mod materials;
mod meshes;
mod settings;
mod stages;
mod textures;

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::{Arc, OnceLock};

use crate::diag::{Finding, Span};
use crate::files::{Bytes, ReadError, VPath};
use crate::ir::{Affine, Color, ColorOrTexture, Handle, Texture, Vec3};

use super::function::Function;
use super::value::{Ty, Value};
use super::{Limit, Limits, Reported};

/// What a constructor makes; the place where it stands asks for one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Family {
    /// How a surface scatters light.
    Material,
    /// What an emitter emits.
    Emission,
    /// A light without a surface.
    Light,
    /// A triangle mesh.
    Mesh,
    /// Shapes that lie together.
    Group,
    /// Moves or changes a mesh: `mesh |> stage(...)`.
    Stage,
    /// A camera.
    Camera,
    /// A film.
    Film,
    /// A reconstruction filter.
    Filter,
    /// A light transport algorithm.
    Integrator,
    /// Sampling.
    Sampler,
    /// A color.
    Color,
    /// An image on a surface.
    Texture,
    /// A function of values.
    Function,
}

impl Family {
    /// All families in the order of the manual.
    pub const ALL: [Self; 14] = [
        Self::Material,
        Self::Emission,
        Self::Light,
        Self::Mesh,
        Self::Group,
        Self::Stage,
        Self::Camera,
        Self::Film,
        Self::Filter,
        Self::Integrator,
        Self::Sampler,
        Self::Color,
        Self::Texture,
        Self::Function,
    ];

    /// The name with its article.
    pub fn words(self) -> &'static str {
        match self {
            Self::Material => "a material",
            Self::Emission => "an emission",
            Self::Light => "a light",
            Self::Mesh => "a mesh",
            Self::Group => "a group",
            Self::Stage => "a stage",
            Self::Camera => "a camera",
            Self::Film => "a film",
            Self::Filter => "a filter",
            Self::Integrator => "an integrator",
            Self::Sampler => "a sampler",
            Self::Color => "a color",
            Self::Texture => "a texture",
            Self::Function => "a function",
        }
    }
}

/// A row of the table.
pub struct Constructor {
    /// What it makes.
    pub family: Family,
    /// Its name.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Its parameters in order. A stage's first one is what stands before `|>`.
    pub params: &'static [Parameter],
    /// How many of them may be given without label.
    pub positional: usize,
    /// A statement that uses it.
    pub example: &'static str,
    /// Makes the value; arguments have been counted and typed.
    pub(super) build: fn(&Args, &mut Site<'_>) -> Result<Value, Problem>,
}

/// A parameter of a constructor.
pub struct Parameter {
    /// Its label.
    pub name: &'static str,
    /// Its type.
    pub ty: Ty,
    /// What it is without argument: none for required, empty for "not given", else the value as it would be written.
    pub default: Option<&'static str>,
    /// Meaning, unit and range.
    pub doc: &'static str,
}

/// Why a constructor makes nothing. Boxed: values are many, problems are few.
pub(super) struct Problem(pub(super) Box<Detail>);

/// The parts of a [`Problem`], as those of a finding.
pub(super) struct Detail {
    /// The argument that is wrong; none for the call.
    pub at: Option<&'static str>,
    pub message: String,
    pub label: String,
    pub note: Option<String>,
    pub help: Option<String>,
    /// The finding's code where it is a special one; empty for what has been reported.
    pub id: &'static str,
}

/// The code of a problem that has been reported.
pub(super) const REPORTED: &str = "";

impl Problem {
    pub(super) fn new(at: impl Into<Option<&'static str>>, message: impl Into<String>) -> Self {
        Self(Box::new(Detail {
            at: at.into(),
            message: message.into(),
            label: String::new(),
            note: None,
            help: None,
            id: "invalid-argument",
        }))
    }

    /// What has been reported already, where it happened.
    pub(super) fn reported() -> Self {
        Self::new(None, "").id(REPORTED)
    }

    pub(super) fn help(self, text: impl Into<String>) -> Self {
        self.maybe_help(Some(text.into()))
    }

    pub(super) fn maybe_help(mut self, text: Option<String>) -> Self {
        self.0.help = text;
        self
    }

    pub(super) fn label(mut self, text: impl Into<String>) -> Self {
        self.0.label = text.into();
        self
    }

    pub(super) fn note(mut self, text: impl Into<String>) -> Self {
        self.0.note = Some(text.into());
        self
    }

    pub(super) fn id(mut self, id: &'static str) -> Self {
        self.0.id = id;
        self
    }
}

/// The arguments of a call by parameter, each of its parameter's type.
pub(super) struct Args {
    pub params: &'static [Parameter],
    pub values: Vec<Option<Value>>,
}

impl Args {
    /// The argument of the parameter `name`.
    pub(super) fn get(&self, name: &str) -> Option<&Value> {
        let at = self.params.iter().position(|param| param.name == name);
        at.and_then(|at| self.values.get(at)).and_then(Option::as_ref)
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.get(name) {
            Some(Value::Number(n) | Value::Angle(n)) => Some(*n),
            _ => None,
        }
    }

    /// A whole number; [`Ty::Whole`] has checked that it fits.
    pub(super) fn whole(&self, name: &str) -> Option<u32> {
        self.number(name).map(|n| n as u32)
    }

    pub(super) fn color(&self, name: &str) -> Option<Color> {
        match self.get(name) {
            Some(Value::Color(color)) => Some(color.clone()),
            _ => None,
        }
    }

    pub(super) fn color_or_texture(&self, name: &str) -> Option<ColorOrTexture> {
        match self.get(name) {
            Some(Value::Color(color)) => Some(ColorOrTexture::Color(color.clone())),
            Some(Value::Texture(texture)) => Some(ColorOrTexture::Texture(*texture)),
            _ => None,
        }
    }

    pub(super) fn vec3(&self, name: &str) -> Option<Vec3> {
        match self.get(name) {
            Some(Value::Vector(parts)) => Some([*parts.first()?, *parts.get(1)?, *parts.get(2)?]),
            Some(Value::Number(n)) => Some([*n; 3]),
            _ => None,
        }
    }

    /// The numbers of a vector.
    pub(super) fn vector(&self, name: &str) -> Option<&[f64]> {
        match self.get(name) {
            Some(Value::Vector(parts)) => Some(parts),
            _ => None,
        }
    }

    pub(super) fn list(&self, name: &str) -> Option<&[Value]> {
        match self.get(name) {
            Some(Value::List(items)) => Some(items),
            _ => None,
        }
    }
}

/// What constructors ask of the evaluator.
pub(super) trait Host {
    /// Reads a file of the project.
    fn read(&mut self, path: &VPath) -> Result<Bytes, ReadError>;

    /// Keeps a texture, made at `span`.
    fn texture(&mut self, texture: Texture, span: Span) -> Handle<Texture>;

    /// The header of a texture that is kept.
    fn image(&self, texture: Handle<Texture>) -> &Texture;

    /// Maps that have been read from a file and are to be kept for the next call that names it.
    fn scattered(&mut self) -> &mut BTreeMap<VPath, Arc<[Affine]>>;

    /// Calls a user's function with as many values as it has parameters, each of its parameter's type; errors are
    /// reported with the call at `span`.
    fn apply(&mut self, function: &Rc<Function>, values: Vec<Value>, span: Span) -> Result<Value, Reported>;

    /// A list of these elements, if the scene may have it.
    fn list(&mut self, items: Vec<Value>, span: Span) -> Result<Value, Reported>;

    /// Counts bytes that are made, or copied, and may be kept.
    fn hold(&mut self, bytes: u64, span: Span) -> Result<(), Reported>;

    /// The numbers that a user's function of two numbers has at up to [`super::numeric::LANES`] places; none, and nothing is done or reported,
    /// where [`Host::apply`] is to be asked one by one.
    fn apply_many(&mut self, function: &Rc<Function>, places: &[[f64; 2]]) -> Option<Vec<f64>>;
}

/// What a constructor may see of the place where it is called.
pub(super) struct Site<'s> {
    /// The call.
    pub span: Span,
    /// The folder of the file in which the path was written.
    pub folder: &'s str,
    /// How many triangles the scene may still make.
    pub triangles: u64,
    /// How large the scene may become.
    pub limits: Limits,
    /// What the evaluator does for it.
    pub host: &'s mut dyn Host,
    /// Normals of another length than 1 in files, which lint says.
    pub lengthened: Vec<String>,
    /// What is to be said although the value could be made.
    pub findings: Vec<Finding>,
}

impl Site<'_> {
    /// A list of these elements, if the scene may have it.
    pub(super) fn list(&mut self, items: impl Iterator<Item = Value>) -> Result<Value, Problem> {
        self.host.list(items.collect(), self.span).map_err(|Reported| Problem::reported())
    }

    /// Counts bytes that are about to be made, or copied, and may be kept.
    pub(super) fn hold(&mut self, bytes: usize) -> Result<(), Problem> {
        self.host.hold(bytes as u64, self.span).map_err(|Reported| Problem::reported())
    }

    /// Refuses to make `count` triangles where the scene would have too many; `at` is the argument that asks for them.
    pub(super) fn afford(&self, at: &'static str, count: u128) -> Result<(), Problem> {
        if count <= u128::from(self.triangles) {
            return Ok(());
        }
        let Limits { triangles, .. } = self.limits;
        let made = triangles - self.triangles;
        let problem = Problem::new(at, format!("the mesh would have {count} triangles, more than the scene may make"))
            .id("triangle-limit")
            .help(Limit::help("triangles"));
        Err(problem.note(match made {
            0 => format!("the meshes of a scene have at most {triangles}"),
            _ => format!("the meshes of a scene have at most {triangles}, and {made} are made already"),
        }))
    }
}

/// All rows, family by family.
pub fn table() -> impl Iterator<Item = &'static Constructor> {
    let parts: [&'static [Constructor]; 10] = [
        materials::ROWS,
        textures::ROWS,
        lights::ROWS,
        meshes::ROWS,
        generators::ROWS,
        stages::ROWS,
        settings::ROWS,
        functions::ROWS,
        arrays::ROWS,
        groups::ROWS,
    ];
    parts.into_iter().flatten()
}

/// The row called `name`; where several families have one, that of `wanted`.
pub(super) fn find(name: &str, wanted: Option<Family>) -> Option<&'static Constructor> {
    static INDEX: OnceLock<BTreeMap<&str, Vec<&Constructor>>> = OnceLock::new();
    let index = INDEX.get_or_init(|| {
        let mut index: BTreeMap<&str, Vec<&Constructor>> = BTreeMap::new();
        table().for_each(|row| index.entry(row.name).or_default().push(row));
        index
    });
    let rows = index.get(name)?;
    rows.iter().find(|row| wanted.is_none_or(|family| family == row.family)).or(rows.first()).copied()
}

impl Constructor {
    /// The call with its parameters, as the manual shows it.
    pub fn signature(&self) -> String {
        let params =
            self.params.iter().skip(usize::from(self.family == Family::Stage)).map(|param| match param.default {
                None => param.name.to_owned(),
                Some("") => format!("[{}]", param.name),
                Some(value) => format!("{} = {value}", param.name),
            });
        let pipe = if self.family == Family::Stage { "|> " } else { "" };
        format!("{pipe}{}({})", self.name, params.collect::<Vec<_>>().join(", "))
    }
}
