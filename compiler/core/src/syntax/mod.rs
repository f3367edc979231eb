//! Text to tree. [`parse`] never fails: it gives the statements it understood and findings for the rest.
//!
//! [`split`](self) cuts the text into top-level statements in one pass over the bytes and refuses what is nested too
//! deeply; `parse` gives each piece, in parallel where there are many, to the grammar (`grammar/lts.pest`) and builds the tree; `explain` and `mistakes`
//! turn what the grammar refused into findings.

mod build;
mod explain;
mod mistakes;
mod parse;
mod split;
mod tree;

pub use parse::{Cut, header, parse, uses};
pub use tree::{
    Arg, Binary, Call, Clause, Expr, ExprKind, Field, Kind, Name, Param, Statement, StatementKind, Tree, Type, Unary,
};

/// How deep brackets, conditions and signs may nest.
pub const NESTING_LIMIT: usize = 128;

/// The longest name in bytes.
pub const NAME_LIMIT: usize = 256;

/// The newest version of the language that this compiler knows.
pub const VERSION: u32 = 1;

/// Words that cannot be names without backticks.
pub const RESERVED: &[&str] = &[
    "allow",
    "and",
    "as",
    "camera",
    "else",
    "emitter",
    "false",
    "film",
    "for",
    "from",
    "group",
    "if",
    "in",
    "instance",
    "integrator",
    "let",
    "lts",
    "material",
    "mesh",
    "not",
    "or",
    "param",
    "sampler",
    "scene",
    "shape",
    "texture",
    "then",
    "true",
    "use",
    "with",
];

/// Words that start a statement.
const STARTERS: &[&str] = &[
    "allow",
    "camera",
    "emitter",
    "film",
    "for",
    "group",
    "if",
    "instance",
    "integrator",
    "let",
    "lts",
    "material",
    "mesh",
    "param",
    "sampler",
    "scene",
    "shape",
    "texture",
    "use",
];
