//! Functions of numbers, angles, vectors and lists.

use std::rc::Rc;

use crate::ir::{cross, dot, normalized};

use super::super::Limit;
use super::super::value::{Ty, Value};
use super::{Args, Constructor, Family, Parameter, Problem};

const X: &[Parameter] = &[Parameter { name: "x", ty: Ty::Number, default: None, doc: "a number" }];
const ANGLE: &[Parameter] = &[Parameter { name: "x", ty: Ty::Angle, default: None, doc: "an angle" }];
const AB: &[Parameter] = &[
    Parameter { name: "a", ty: Ty::Number, default: None, doc: "a number" },
    Parameter { name: "b", ty: Ty::Number, default: None, doc: "a number" },
];
const VECTORS: &[Parameter] = &[
    Parameter { name: "a", ty: Ty::Vec3, default: None, doc: "a vector" },
    Parameter { name: "b", ty: Ty::Vec3, default: None, doc: "a vector" },
];
const VECTOR: &[Parameter] = &[Parameter { name: "v", ty: Ty::Vec3, default: None, doc: "a vector" }];
const NUMBERS: &[Parameter] = &[Parameter { name: "list", ty: Ty::Numbers, default: None, doc: "numbers" }];
const LIST: &[Parameter] = &[Parameter { name: "list", ty: Ty::List, default: None, doc: "a list" }];

/// A row for a function.
const fn row(
    name: &'static str,
    params: &'static [Parameter],
    summary: &'static str,
    example: &'static str,
    build: fn(&Args, &mut super::Site<'_>) -> Result<Value, Problem>,
) -> Constructor {
    Constructor { family: Family::Function, name, summary, params, positional: params.len(), example, build }
}

pub(super) const ROWS: &[Constructor] = &[
    row("sin", ANGLE, "The sine of an angle.", "let a = sin(30deg)", |args, _| trigonometry(args, |sine, _| Ok(sine))),
    row("cos", ANGLE, "The cosine of an angle.", "let a = cos(60deg)", |args, _| {
        trigonometry(args, |_, cosine| Ok(cosine))
    }),
    row("tan", ANGLE, "The tangent of an angle.", "let a = tan(45deg)", |args, _| {
        trigonometry(args, |sine, cosine| {
            if cosine == 0.0 {
                Err(Problem::new("x", "the tangent of a right angle is infinite"))
            } else {
                Ok(sine / cosine)
            }
        })
    }),
    row("asin", X, "The angle whose sine is x, -90..90 degrees.", "let a = asin(0.5)", |args, _| {
        inverse(args, libm::asin)
    }),
    row("acos", X, "The angle whose cosine is x, 0..180 degrees.", "let a = acos(0.5)", |args, _| {
        inverse(args, libm::acos)
    }),
    row("atan", X, "The angle whose tangent is x, -90..90 degrees.", "let a = atan(1)", |args, _| {
        Ok(Value::Angle(libm::atan(x(args)).to_degrees()))
    }),
    row("atan2", AB, "The angle of the point (b, a), -180..180 degrees.", "let a = atan2(1, -1)", |args, _| {
        let (a, b) = ab(args);
        Ok(Value::Angle(libm::atan2(a, b).to_degrees()))
    }),
    row("sqrt", X, "The square root.", "let a = sqrt(2)", |args, _| {
        if x(args) < 0.0 {
            Err(Problem::new("x", "the square root of a negative number"))
        } else {
            number(x(args).sqrt())
        }
    }),
    row("abs", X, "The value without its sign.", "let a = abs(-2)", |args, _| number(x(args).abs())),
    row("floor", X, "The next whole number below.", "let a = floor(2.7)", |args, _| number(x(args).floor())),
    row("ceil", X, "The next whole number above.", "let a = ceil(2.2)", |args, _| number(x(args).ceil())),
    row("round", X, "The nearest whole number; halves go away from 0.", "let a = round(2.5)", |args, _| {
        number(x(args).round())
    }),
    row("exp", X, "e to the power x.", "let a = exp(1)", |args, _| number(libm::exp(x(args)))),
    row("log", X, "The natural logarithm.", "let a = log(2)", |args, _| {
        if x(args) <= 0.0 {
            Err(Problem::new("x", "the logarithm of a number that is not positive"))
        } else {
            number(libm::log(x(args)))
        }
    }),
    row("pow", AB, "a to the power b.", "let a = pow(2, 10)", |args, _| {
        let (a, b) = ab(args);
        number(libm::pow(a, b))
    }),
    row("mod", AB, "The remainder of a / b with the sign of b.", "let a = mod(-1, 4)", |args, _| {
        let (a, b) = ab(args);
        if b == 0.0 { Err(Problem::new("b", "division by zero")) } else { number(a - b * (a / b).floor()) }
    }),
    row("min", AB, "The smaller one.", "let a = min(1, 2)", |args, _| number(ab(args).0.min(ab(args).1))),
    row("max", AB, "The larger one.", "let a = max(1, 2)", |args, _| number(ab(args).0.max(ab(args).1))),
    row(
        "random",
        &[
            Parameter { name: "a", ty: Ty::Number, default: None, doc: "any number" },
            Parameter { name: "b", ty: Ty::Number, default: Some("0"), doc: "any number" },
            Parameter { name: "c", ty: Ty::Number, default: Some("0"), doc: "any number" },
            Parameter { name: "d", ty: Ty::Number, default: Some("0"), doc: "any number" },
        ],
        "A number from 0 to just below 1 that is the same for the same arguments on every machine, and as good as random else.",
        "let a = [for i in 1..10: random(i, 7)]",
        |args, _| number(random(["a", "b", "c", "d"].map(|name| args.number(name).unwrap_or(0.0)))),
    ),
    row("sum", NUMBERS, "The sum of the numbers of a list.", "let a = sum([1, 2, 3])", |args, _| {
        let items = args.list("list").unwrap_or_default().iter();
        number(items.map(|item| if let Value::Number(n) = item { *n } else { 0.0 }).sum())
    }),
    row("len", LIST, "How many elements a list has.", "let a = len([1, 2, 3])", |args, _| {
        number(args.list("list").unwrap_or_default().len() as f64)
    }),
    row("reverse", LIST, "A list from its end to its start.", "let a = reverse([1, 2, 3])", |args, site| {
        site.list(args.list("list").unwrap_or_default().iter().rev().cloned())
    }),
    row(
        "concat",
        &[
            Parameter { name: "a", ty: Ty::List, default: None, doc: "a list" },
            Parameter { name: "b", ty: Ty::List, default: None, doc: "a list" },
        ],
        "Two lists, one behind the other.",
        "let a = concat([1, 2], [3])",
        |args, site| {
            let part = |name| args.list(name).unwrap_or_default();
            let (a, b) = (part("a"), part("b"));
            if a.len() + b.len() > site.limits.list {
                let message = format!("the list would have {} elements", a.len() + b.len());
                return Err(Problem::new(None, message)
                    .id("list-limit")
                    .note(format!("at most {} are allowed", site.limits.list))
                    .help(Limit::help("list")));
            }
            site.list(a.iter().chain(b).cloned())
        },
    ),
    row("dot", VECTORS, "The scalar product.", "let a = dot(X, (1, 2, 3))", |args, _| {
        let (a, b) = vectors(args);
        number(dot(a, b))
    }),
    row("cross", VECTORS, "The vector product.", "let a = cross(X, Y)", |args, _| {
        let (a, b) = vectors(args);
        vector(cross(a, b))
    }),
    row("length", VECTOR, "The length of a vector.", "let a = length((3, 4, 0))", |args, _| {
        number(crate::ir::length(args.vec3("v").unwrap_or_default()))
    }),
    row(
        "normalize",
        VECTOR,
        "The vector of length 1 in the same direction.",
        "let a = normalize((3, 4, 0))",
        |args, _| match normalized(args.vec3("v").unwrap_or_default()) {
            Some(unit) => vector(unit),
            None => Err(Problem::new("v", "the zero vector has no direction")),
        },
    ),
];

/// The finalizer of SplitMix64 (Steele, Lea and Flood 2014), fed with the bits of one number after the other; the upper 53
/// bits of the result make the number. Missing arguments are 0, and -0 is 0.
fn random(numbers: [f64; 4]) -> f64 {
    let mut state = 0_u64;
    for number in numbers {
        state = (state ^ (number + 0.0).to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 11) as f64 / (1_u64 << 53) as f64
}

fn number(value: f64) -> Result<Value, Problem> {
    if value.is_finite() {
        Ok(Value::Number(value))
    } else {
        Err(Problem::new(None, "the result is not a finite number"))
    }
}

fn vector(value: [f64; 3]) -> Result<Value, Problem> {
    if value.iter().all(|part| part.is_finite()) {
        return Ok(Value::Vector(Rc::new(value)));
    }
    Err(Problem::new(None, "the result is not finite"))
}

fn x(args: &Args) -> f64 {
    args.number("x").unwrap_or(0.0)
}

fn ab(args: &Args) -> (f64, f64) {
    (args.number("a").unwrap_or(0.0), args.number("b").unwrap_or(0.0))
}

fn vectors(args: &Args) -> ([f64; 3], [f64; 3]) {
    (args.vec3("a").unwrap_or_default(), args.vec3("b").unwrap_or_default())
}

fn trigonometry(args: &Args, of: fn(f64, f64) -> Result<f64, Problem>) -> Result<Value, Problem> {
    let (sine, cosine) = crate::ir::sin_cos_degrees(x(args));
    number(of(sine, cosine)?)
}

fn inverse(args: &Args, of: fn(f64) -> f64) -> Result<Value, Problem> {
    if x(args).abs() > 1.0 {
        return Err(Problem::new("x", "the argument must lie between -1 and 1"));
    }
    Ok(Value::Angle(of(x(args)).to_degrees()))
}

#[cfg(test)]
mod tests {
    use super::random;

    #[test]
    fn random_numbers_are_fixed_uniform_and_uncorrelated() {
        assert_eq!(random([0.0; 4]), random([-0.0; 4]));
        assert_eq!(random([1.0, 2.0, 0.0, 0.0]).to_bits(), 0x3fe3_af4e_c1c7_210f);
        let all: Vec<f64> = (0..10_000).map(|i| random([f64::from(i), 1.0, 0.0, 0.0])).collect();
        let mean = all.iter().sum::<f64>() / 1e4;
        let variance = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 1e4;
        let next = all.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum::<f64>() / 1e4;
        // Five standard errors each.
        assert!(
            (mean - 0.5).abs() < 5.0 * 0.0029 && (variance - 1.0 / 12.0).abs() < 5.0 * 0.00075,
            "{mean} {variance}"
        );
        assert!(next.abs() < 5.0 * 0.00084, "{next}");
        assert!(all.iter().all(|x| (0.0..1.0).contains(x)));
    }
}
