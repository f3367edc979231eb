//! The syntax tree: what was written, with spans; no meaning yet.

use crate::diag::{FileId, Span};

/// One file.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// The file.
    pub file: FileId,
    /// Its statements in order; broken ones are missing.
    pub statements: Vec<Statement>,
}

/// A statement with its documentation.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// From the first word to the last token.
    pub span: Span,
    /// The text of the `///` lines before it, without the slashes and one blank; empty for none.
    pub doc: String,
    /// What it says.
    pub kind: StatementKind,
}

/// The forms of statements.
#[derive(Clone, Debug, PartialEq)]
pub enum StatementKind {
    /// `lts 1`
    Version(Expr),
    /// `scene NAME { field: value ... }`
    Scene {
        /// The scene's name.
        name: Name,
        /// Its fields.
        fields: Vec<Field>,
    },
    /// `use a, b as c from "path.lts"`
    Use {
        /// Names and what they are called here.
        names: Vec<(Name, Option<Name>)>,
        /// The path as written.
        path: Name,
    },
    /// `kind name(params) = value with surface`
    Declaration {
        /// The first word.
        kind: Kind,
        /// The name; settings have none, cameras may have one.
        name: Option<Name>,
        /// Parameters, for a function.
        params: Option<Vec<Param>>,
        /// The right side.
        value: Expr,
        /// What follows `with`.
        with: Option<Expr>,
    },
    /// `group NAME(params) { statements }`
    Group {
        /// The name.
        name: Name,
        /// Parameters.
        params: Vec<Param>,
        /// Its statements.
        body: Vec<Statement>,
    },
    /// `param NAME: type = default in range`
    Parameter {
        /// The name.
        name: Name,
        /// The type.
        ty: Type,
        /// The default.
        default: Expr,
        /// Allowed values.
        range: Option<Expr>,
    },
    /// `for pattern in list, ... { statements }`
    For {
        /// Loop variables and what they run over.
        clauses: Vec<Clause>,
        /// The statements repeated.
        body: Vec<Statement>,
    },
    /// `if condition { statements } else { statements }`
    If {
        /// Conditions with their statements, in order.
        branches: Vec<(Expr, Vec<Statement>)>,
        /// The statements of the last `else`.
        otherwise: Vec<Statement>,
    },
    /// `allow finding-id "reason"`
    Allow {
        /// The finding.
        id: Name,
        /// The reason.
        reason: Name,
    },
}

/// The first word of a declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// `let`
    Let,
    /// `material`
    Material,
    /// `mesh`
    Mesh,
    /// `texture`
    Texture,
    /// `group`
    Group,
    /// `shape`
    Shape,
    /// `emitter`
    Emitter,
    /// `instance`
    Instance,
    /// `camera`
    Camera,
    /// `film`
    Film,
    /// `integrator`
    Integrator,
    /// `sampler`
    Sampler,
}

impl Kind {
    /// The word itself.
    pub fn word(self) -> &'static str {
        match self {
            Self::Let => "let",
            Self::Material => "material",
            Self::Mesh => "mesh",
            Self::Texture => "texture",
            Self::Group => "group",
            Self::Shape => "shape",
            Self::Emitter => "emitter",
            Self::Instance => "instance",
            Self::Camera => "camera",
            Self::Film => "film",
            Self::Integrator => "integrator",
            Self::Sampler => "sampler",
        }
    }
}

/// A name, or the text of a string, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The name without backticks; a string with its escapes resolved.
    pub text: String,
    /// Its place.
    pub span: Span,
}

/// `label: value` in the header of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The label.
    pub name: Name,
    /// The value.
    pub value: Expr,
}

/// A parameter of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: Name,
    /// Its type.
    pub ty: Type,
    /// Its default.
    pub default: Option<Expr>,
}

/// A type as written: a word in some brackets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Type {
    /// The word.
    pub name: Name,
    /// How many brackets stand round it.
    pub lists: usize,
}

/// `pattern in list`
#[derive(Clone, Debug, PartialEq)]
pub struct Clause {
    /// One name, or the names of a tuple.
    pub names: Vec<Name>,
    /// Whether the names stand in brackets.
    pub tuple: bool,
    /// What they run over.
    pub over: Expr,
}

/// An expression with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Its place.
    pub span: Span,
    /// Its form.
    pub kind: ExprKind,
}

/// The forms of expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// `1.5`
    Number(f64),
    /// `45deg`: the number and the letters that touch it.
    Unit(f64, String),
    /// `"text"`
    String(String),
    /// `true`
    Bool(bool),
    /// `name`
    Name(String),
    /// `(a, b)`
    Tuple(Vec<Expr>),
    /// `(1, 2, 3)`: a tuple of plain numbers.
    Row(Vec<f64>),
    /// `[a, b]`
    List(Vec<Expr>),
    /// `[for i in 0..3: expr]`
    Comprehension(Vec<Clause>, Box<Expr>),
    /// `f(a, label: b)`, or `x |> f(a)` with `x` as the piped value.
    Call(Box<Call>),
    /// `- x`, `not x`
    Unary(Unary, Box<Expr>),
    /// `a + b`; the span is the operator's.
    Binary(Binary, Span, Box<(Expr, Expr)>),
    /// `x[i]`
    Index(Box<(Expr, Expr)>),
    /// `v.x`
    Member(Box<Expr>, Name),
    /// `if c then a else b`
    If(Box<(Expr, Expr, Expr)>),
}

/// A call.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// What is called.
    pub name: Name,
    /// The value before `|>`.
    pub piped: Option<Expr>,
    /// Arguments with their labels.
    pub args: Vec<Arg>,
    /// The name with its brackets.
    pub span: Span,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct Arg {
    /// Its label.
    pub label: Option<Name>,
    /// Its value.
    pub value: Expr,
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// `-`
    Minus,
    /// `not`
    Not,
}

/// Operators with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// `..`
    Range,
    /// `or`
    Or,
    /// `and`
    And,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
}

impl Binary {
    /// The operator as written.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Range => "..",
            Self::Or => "or",
            Self::And => "and",
            Self::Equal => "==",
            Self::NotEqual => "!=",
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
        }
    }
}

impl Expr {
    /// Shows `see` the expressions that this one is made of, one level down.
    pub fn each_part<'t>(&'t self, see: &mut dyn FnMut(&'t Self)) {
        match &self.kind {
            ExprKind::Number(_)
            | ExprKind::Unit(..)
            | ExprKind::String(_)
            | ExprKind::Bool(_)
            | ExprKind::Row(_)
            | ExprKind::Name(_) => {}
            ExprKind::Tuple(parts) | ExprKind::List(parts) => parts.iter().for_each(see),
            ExprKind::Comprehension(clauses, body) => {
                clauses.iter().for_each(|clause| see(&clause.over));
                see(body);
            }
            ExprKind::Call(call) => {
                call.piped.iter().for_each(&mut *see);
                call.args.iter().for_each(|arg| see(&arg.value));
            }
            ExprKind::Unary(_, of) | ExprKind::Member(of, _) => see(of),
            ExprKind::Binary(_, _, both) | ExprKind::Index(both) => {
                see(&both.0);
                see(&both.1);
            }
            ExprKind::If(parts) => {
                see(&parts.0);
                see(&parts.1);
                see(&parts.2);
            }
        }
    }
}

impl Statement {
    /// Shows `see` the expressions that stand in the statement itself, and `inner` the statements within its braces.
    pub fn each_part<'t>(&'t self, see: &mut dyn FnMut(&'t Expr), inner: &mut dyn FnMut(&'t [Statement])) {
        match &self.kind {
            StatementKind::Version(number) => see(number),
            StatementKind::Scene { name: _, fields } => fields.iter().for_each(|field| see(&field.value)),
            StatementKind::Use { .. } | StatementKind::Allow { .. } => {}
            StatementKind::Declaration { kind: _, name: _, params, value, with } => {
                params.iter().flatten().filter_map(|param| param.default.as_ref()).for_each(&mut *see);
                see(value);
                with.iter().for_each(see);
            }
            StatementKind::Group { name: _, params, body } => {
                params.iter().filter_map(|param| param.default.as_ref()).for_each(see);
                inner(body);
            }
            StatementKind::Parameter { name: _, ty: _, default, range } => {
                see(default);
                range.iter().for_each(see);
            }
            StatementKind::For { clauses, body } => {
                clauses.iter().for_each(|clause| see(&clause.over));
                inner(body);
            }
            StatementKind::If { branches, otherwise } => {
                for (condition, body) in branches {
                    see(condition);
                    inner(body);
                }
                inner(otherwise);
            }
        }
    }
}
