//! Values of the language and their types.

use std::rc::Rc;

use crate::diag::Span;
use crate::ir::{
    Affine, Bsdf, Color, Film, Filter, Handle, Integrator, LightKind, Mesh, Places, Sampler, Sides, Texture, Vec3,
};

use super::work::List;

/// A value. No number in it is ever NaN or infinite.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Number(f64),
    /// In degrees.
    Angle(f64),
    Bool(bool),
    String(Rc<str>),
    /// Two to four numbers.
    Vector(Rc<[f64]>),
    /// Any other tuple.
    Tuple(List),
    List(List),
    /// Both ends belong to it.
    Range(f64, f64),
    Color(Color),
    Texture(Handle<Texture>),
    Material(Rc<MaterialValue>),
    Emission(Rc<EmissionValue>),
    Light(Rc<LightKind>),
    Mesh(MeshValue),
    Group(GroupValue),
    Camera(Rc<CameraValue>),
    Film(Rc<Film>),
    Filter(Rc<Filter>),
    Integrator(Rc<Integrator>),
    Sampler(Rc<Sampler>),
    Function(Rc<super::function::Function>),
    /// The value of a declaration that has been reported; using it says nothing again.
    Poison,
}

/// A material and the name under which it was declared, if it was.
#[derive(Clone, Debug)]
pub(super) struct MaterialValue {
    pub name: Option<String>,
    pub bsdf: Bsdf,
    pub sides: Sides,
    pub span: Span,
}

/// What follows `with` at an emitter.
#[derive(Clone, Debug)]
pub(super) struct EmissionValue {
    pub radiance: Color,
    /// None for the black surface that emitters have unless another is asked for.
    pub over: Option<Rc<MaterialValue>>,
}

/// A mesh and where it has been moved. Stages move cheaply; the vertices stay shared.
#[derive(Clone, Debug)]
pub(super) struct MeshValue {
    pub mesh: Rc<Mesh>,
    pub transform: Affine,
    /// Where the mesh was made.
    pub span: Span,
}

/// A group and where it has been moved, or scattered.
#[derive(Clone, Debug)]
pub(super) struct GroupValue {
    pub body: Rc<super::items::GroupBody>,
    pub places: Places,
}

/// A camera before the film is known.
#[derive(Clone, Debug)]
pub(super) struct CameraValue {
    pub eye: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    /// In degrees, and whether it is the vertical one.
    pub fov: f64,
    pub vertical: bool,
    pub near: Option<f64>,
    pub far: Option<f64>,
}

impl Value {
    /// How deep lists and functions lie within each other in it.
    pub(super) fn depth(&self) -> usize {
        match self {
            Self::List(list) | Self::Tuple(list) => list.depth(),
            Self::Function(function) => function.depth(),
            _ => 0,
        }
    }

    /// The value as it would be written; what is long or has no short form by its type.
    pub(super) fn written(&self) -> String {
        let row = |parts: &[f64]| parts.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Self::Number(n) => n.to_string(),
            Self::Angle(a) => format!("{a}deg"),
            Self::Bool(b) => b.to_string(),
            Self::String(text) => format!("{text:?}"),
            Self::Vector(parts) => format!("({})", row(parts)),
            Self::Range(lo, hi) => format!("{lo}..{hi}"),
            Self::Color(color) if color.spectrum().is_none() => match color.rgb() {
                [r, g, b] if r == g && g == b => r.to_string(),
                rgb => format!("rgb({})", row(&rgb)),
            },
            Self::List(items) if items.len() <= 8 && items.iter().all(|item| !matches!(item, Self::List(_))) => {
                format!("[{}]", items.iter().map(Self::written).collect::<Vec<_>>().join(", "))
            }
            other => other.kind().to_owned(),
        }
    }

    /// The type in words, for "expected ..., found ...".
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Number(_) => "a number",
            Self::Angle(_) => "an angle",
            Self::Bool(_) => "true or false",
            Self::String(_) => "a string",
            Self::Vector(parts) => match parts.len() {
                2 => "a vector of 2",
                3 => "a vector of 3",
                _ => "a vector of 4",
            },
            Self::Tuple(_) => "a tuple",
            Self::List(_) => "a list",
            Self::Range(..) => "a range",
            Self::Color(_) => "a color",
            Self::Texture(_) => "a texture",
            Self::Material(_) => "a material",
            Self::Emission(_) => "an emission",
            Self::Light(_) => "a light",
            Self::Mesh(_) => "a mesh",
            Self::Group(_) => "a group",
            Self::Camera(_) => "a camera",
            Self::Film(_) => "a film",
            Self::Filter(_) => "a filter",
            Self::Integrator(_) => "an integrator",
            Self::Sampler(_) => "a sampler",
            Self::Function(_) => "a function",
            Self::Poison => "a value that could not be computed",
        }
    }
}

/// A type that a parameter asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ty {
    /// Any number.
    Number,
    /// A whole number, at least 0.
    Whole,
    /// An angle with its unit.
    Angle,
    /// `true` or `false`.
    Bool,
    /// A string.
    String,
    /// A color; a number is a grey.
    Color,
    /// A color, or a texture.
    ColorOrTexture,
    /// Two numbers.
    Vec2,
    /// Three numbers.
    Vec3,
    /// A number (the same along each axis) or three numbers.
    NumberOrVec3,
    /// A range, or a number for a flat extent.
    Extent,
    /// A range.
    Range,
    /// Two ranges of cells of a raster; both ends may be the same.
    Cells,
    /// `X`, `-X`, `Y`, `-Y`, `Z` or `-Z`.
    Axis,
    /// A row of a matrix: four numbers.
    Row,
    /// A list of points.
    Points,
    /// A list of points of the texture.
    Points2,
    /// A list of triangles, three indices each.
    Faces,
    /// A list of numbers.
    Numbers,
    /// Any list.
    List,
    /// A number or an angle.
    NumberOrAngle,
    /// A number or a vector.
    NumberOrVector,
    /// A mesh.
    Mesh,
    /// A mesh or a group.
    Placeable,
    /// A mesh, a group or an environment.
    Turnable,
    /// A material.
    Material,
    /// A reconstruction filter.
    Filter,
    /// A function of two numbers, by its name.
    Height,
}

impl Ty {
    /// The type in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Number => "a number",
            Self::Whole => "a whole number",
            Self::Angle => "an angle",
            Self::Bool => "true or false",
            Self::String => "a string",
            Self::Color => "a color",
            Self::ColorOrTexture => "a color or a texture",
            Self::Vec2 => "a vector of 2",
            Self::Vec3 => "a vector of 3",
            Self::NumberOrVec3 => "a number or a vector of 3",
            Self::Extent => "a range or a number",
            Self::Range => "a range",
            Self::Cells => "a pair of ranges",
            Self::Axis => "an axis",
            Self::Row => "a row of 4 numbers",
            Self::Points => "a list of vectors of 3",
            Self::Points2 => "a list of vectors of 2",
            Self::Faces => "a list of triples of indices",
            Self::Numbers => "a list of numbers",
            Self::List => "a list",
            Self::NumberOrAngle => "a number or an angle",
            Self::NumberOrVector => "a number or a vector",
            Self::Mesh => "a mesh",
            Self::Placeable => "a mesh or a group",
            Self::Turnable => "a mesh, a group or an environment",
            Self::Material => "a material",
            Self::Filter => "a filter",
            Self::Height => "a function of two numbers",
        }
    }

    /// `value` as this type, or why it is none.
    pub(super) fn accept(self, value: Value) -> Result<Value, Refusal> {
        let plain = || Refusal::Type;
        match (self, value) {
            (
                Self::Number | Self::NumberOrVec3 | Self::NumberOrVector | Self::NumberOrAngle | Self::Extent,
                Value::Number(n),
            ) => Ok(Value::Number(n)),
            (Self::Whole, Value::Number(n)) => {
                let whole = n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&n);
                if whole { Ok(Value::Number(n)) } else { Err(Refusal::Whole(n)) }
            }
            (Self::Angle | Self::NumberOrAngle, Value::Angle(a)) => Ok(Value::Angle(a)),
            (Self::Angle, Value::Number(n)) => Err(Refusal::Unit(n)),
            (Self::Bool, Value::Bool(b)) => Ok(Value::Bool(b)),
            (Self::String, Value::String(text)) => Ok(Value::String(text)),
            (Self::ColorOrTexture, Value::Texture(texture)) => Ok(Value::Texture(texture)),
            (Self::Color | Self::ColorOrTexture, Value::Number(n)) => Ok(Value::Color(Color::Grey(n))),
            (Self::Color | Self::ColorOrTexture, Value::Color(color)) => Ok(Value::Color(color)),
            (Self::Color | Self::ColorOrTexture, Value::Vector(parts)) if parts.len() == 3 => {
                Err(Refusal::ColorFromVector)
            }
            (Self::Vec3 | Self::NumberOrVec3, Value::Vector(parts)) if parts.len() == 3 => Ok(Value::Vector(parts)),
            (Self::Vec2, Value::Vector(parts)) if parts.len() == 2 => Ok(Value::Vector(parts)),
            (Self::Row, Value::Vector(parts)) if parts.len() == 4 => Ok(Value::Vector(parts)),
            (Self::NumberOrVector, Value::Vector(parts)) => Ok(Value::Vector(parts)),
            (Self::Axis, Value::Vector(parts)) if axis(&parts).is_some() => Ok(Value::Vector(parts)),
            (Self::Extent | Self::Range, Value::Range(lo, hi)) => {
                if lo < hi {
                    Ok(Value::Range(lo, hi))
                } else {
                    Err(Refusal::Reversed(lo, hi))
                }
            }
            (Self::Cells, Value::Tuple(parts)) => match &parts[..] {
                [Value::Range(..), Value::Range(..)] => Ok(Value::Tuple(parts)),
                _ => Err(plain()),
            },
            (Self::Points, Value::List(items)) => vectors(items, 3),
            (Self::Points2, Value::List(items)) => vectors(items, 2),
            (Self::Faces, Value::List(items)) => vectors(items, 3),
            (Self::Numbers, Value::List(items)) => {
                if items.iter().all(|item| matches!(item, Value::Number(_))) {
                    Ok(Value::List(items))
                } else {
                    Err(plain())
                }
            }
            (Self::List, Value::List(items)) => Ok(Value::List(items)),
            (Self::Mesh | Self::Placeable | Self::Turnable, Value::Mesh(mesh)) => Ok(Value::Mesh(mesh)),
            (Self::Placeable | Self::Turnable, Value::Group(group)) => Ok(Value::Group(group)),
            (Self::Turnable, Value::Light(light)) if matches!(*light, LightKind::Environment { .. }) => {
                Ok(Value::Light(light))
            }
            (Self::Material, Value::Material(material)) => Ok(Value::Material(material)),
            (Self::Filter, Value::Filter(filter)) => Ok(Value::Filter(filter)),
            (Self::Height, Value::Function(function)) => {
                if function.takes_numbers(2) {
                    Ok(Value::Function(function))
                } else {
                    Err(Refusal::Signature)
                }
            }
            (_, Value::Poison) => Err(Refusal::Silent),
            (_, _) => Err(plain()),
        }
    }
}

fn vectors(items: List, size: usize) -> Result<Value, Refusal> {
    let good = |item: &Value| matches!(item, Value::Vector(parts) if parts.len() == size);
    match items.iter().position(|item| !good(item)) {
        None => Ok(Value::List(items)),
        Some(at) => Err(Refusal::Element(at)),
    }
}

/// The axis (0, 1, 2) and sign of a unit vector along an axis.
pub(super) fn axis(parts: &[f64]) -> Option<(usize, f64)> {
    if parts.len() != 3 || parts.iter().filter(|part| **part != 0.0).count() != 1 {
        return None;
    }
    let at = parts.iter().position(|part| part.abs() == 1.0)?;
    Some((at, parts[at]))
}

/// Why a value is not of a type.
pub(super) enum Refusal {
    /// Another type.
    Type,
    /// A number that is not whole, or negative, or too large.
    Whole(f64),
    /// A number where an angle is due.
    Unit(f64),
    /// A range whose ends are in the wrong order or equal.
    Reversed(f64, f64),
    /// A vector where a color is due.
    ColorFromVector,
    /// An element of a list.
    Element(usize),
    /// A function with other parameters.
    Signature,
    /// Already reported.
    Silent,
}
