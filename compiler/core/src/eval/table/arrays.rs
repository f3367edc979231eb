//! Arrays in files of NumPy: `scatter` places a group at every row, `table` gives the numbers as lists.

use std::rc::Rc;
use std::sync::Arc;

use crate::files::VPath;
use crate::ir::{Affine, Places};
use crate::npy::{self, Array, NpyError};

use super::super::limits::Limit;
use super::super::value::{GroupValue, Ty, Value};
use super::meshes::{read, resolved};
use super::{Args, Constructor, Family, Parameter, Problem, Site};

const PATH: Parameter = Parameter {
    name: "path",
    ty: Ty::String,
    default: None,
    doc: "from the folder of this file, with `/`; ends in `.npy`",
};

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Stage,
        name: "scatter",
        summary: "Places a group once for each row of a NumPy array: of shape (n, 3) for positions, (n, 3, 4) for affine maps.",
        params: &[Parameter { name: "of", ty: Ty::Placeable, default: None, doc: "the group before `|>`" }, PATH],
        positional: 1,
        example: "group oak { shape trunk = cylinder(radius: 0.3, z: 0..4) with diffuse(0.2) }\ninstance oak = oak |> scatter(\"forest.npy\")",
        build: scatter,
    },
    Constructor {
        family: Family::Function,
        name: "table",
        summary: "The numbers of a NumPy array as lists: a list of lists for an array of two axes.",
        params: &[PATH],
        positional: 1,
        example: "let heights = table(\"heights.npy\")",
        build: table,
    },
];

fn problem(path: &VPath, error: NpyError) -> Problem {
    let NpyError { message, help } = error;
    Problem::new("path", message).id("invalid-array").label(path.to_string()).maybe_help(help)
}

fn scatter(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let Some(Value::Group(GroupValue { body, places })) = args.get("of") else {
        return Err(Problem::new("of", "`scatter` places groups, not meshes")
            .label("a mesh")
            .help("put it into a group: `group name { shape part = ... with ... }`"));
    };
    let Places::One(own) = places else {
        return Err(Problem::new("of", "the group is scattered already")
            .help("put the first instance into a group of its own, and scatter that"));
    };
    let path = resolved(args, site)?;
    let known = site.host.scattered().get(&path).cloned();
    let maps = match known {
        Some(maps) => maps,
        None => {
            let maps = maps(args, site)?;
            site.host.scattered().insert(path, Arc::clone(&maps));
            maps
        }
    };
    if *own == Affine::IDENTITY {
        return Ok(Value::Group(GroupValue { body: Rc::clone(body), places: Places::Many(maps) }));
    }
    site.hold(size_of_val(&*maps))?;
    let moved: Arc<[Affine]> = maps.iter().map(|map| own.then(map)).collect();
    if let Some(row) = moved.iter().position(|map| !map.is_invertible()) {
        return Err(Problem::new("path", format!("row {row} takes the moved group out of the range of numbers")));
    }
    Ok(Value::Group(GroupValue { body: Rc::clone(body), places: Places::Many(moved) }))
}

/// The maps of the rows of a file.
fn maps(args: &Args, site: &mut Site<'_>) -> Result<Arc<[Affine]>, Problem> {
    let (path, bytes) = read(args, site)?;
    let array = Array::open(&bytes).map_err(|error| problem(&path, error))?;
    let wrong = |message: String| Problem::new("path", message).id("invalid-array").label(path.to_string());
    let (rows, matrices) = match array.shape() {
        [rows, 3] => (*rows, false),
        [rows, 3, 4] => (*rows, true),
        shape => {
            return Err(wrong(format!("the array has {}", npy::shape_words(shape)))
                .note("`scatter` takes (n, 3), a position for each place, or (n, 3, 4), an affine map for each")
                .help(if matches!(shape, [_, 4, 4]) {
                    "leave out the last row of each matrix: `numpy.save(path, array[:, :3, :])`"
                } else {
                    "write it by `numpy.save(path, array)` with one of these shapes"
                }));
        }
    };
    if rows == 0 {
        return Err(wrong("the array has no rows".to_owned())
            .note("a group that is placed nowhere is not seen")
            .help("remove the instance, or write rows"));
    }
    let most = site.limits.instances;
    if rows as u64 > most {
        return Err(Problem::new("path", format!("the array places {rows} groups, more than {most}"))
            .id("instance-limit")
            .help(Limit::help("instances")));
    }
    let numbers = array.numbers().map_err(|error| problem(&path, error))?;
    if !matrices {
        return Ok(numbers.as_chunks::<3>().0.iter().map(|at| Affine::translation(*at)).collect());
    }
    let maps: Arc<[Affine]> =
        numbers.as_chunks::<4>().0.as_chunks::<3>().0.iter().map(|rows| Affine { rows: *rows }).collect();
    match maps.iter().position(|map| !map.is_invertible()) {
        None => Ok(maps),
        Some(row) => Err(wrong(format!("the matrix of row {row} flattens the group"))
            .note("its determinant is 0, so that it has no inverse")
            .help("repair the array in the program that wrote it")),
    }
}

fn table(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let (path, bytes) = read(args, site)?;
    let array = Array::open(&bytes).map_err(|error| problem(&path, error))?;
    let most = site.limits.list;
    // Lists of nothing also count: an array of shape (1000000000, 0) has no numbers.
    let fits = |all: usize, axis: &usize| all.checked_mul(*axis).filter(|count| *count <= most);
    let count = array.shape().iter().try_fold(1, fits);
    if count.is_none() {
        let message =
            format!("a list has {most} elements or fewer, and the array has {}", npy::shape_words(array.shape()));
        return Err(Problem::new("path", message).id("list-limit").label(path.to_string()).help(Limit::help("list")));
    }
    let numbers = array.numbers().map_err(|error| problem(&path, error))?;
    let truth = array.is_bool();
    let value = |number: &f64| if truth { Value::Bool(*number != 0.0) } else { Value::Number(*number) };
    nested(array.shape(), &numbers, &value, site)
}

/// Lists within lists, one level for each axis.
fn nested(
    shape: &[usize],
    numbers: &[f64],
    value: &dyn Fn(&f64) -> Value,
    site: &mut Site<'_>,
) -> Result<Value, Problem> {
    match shape {
        [] => Ok(numbers.first().map_or(Value::Number(0.0), value)),
        [_] => site.list(numbers.iter().map(value)),
        [count, inner @ ..] => {
            let size: usize = inner.iter().product();
            let mut parts = Vec::with_capacity(*count);
            for at in 0..*count {
                parts.push(nested(inner, &numbers[at * size..(at + 1) * size], value, site)?);
            }
            site.list(parts.into_iter())
        }
    }
}
