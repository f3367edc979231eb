//! A program for many places at once: each node computes all of them before the next one starts, so that the program is walked
//! once for all, and the loops over numbers become loops over vectors.
//!
//! The results are those of the program at one place, to the bit, or none at all.

use crate::ir::{cosines_degrees, sines_degrees};
use crate::syntax::Binary;

use super::{Node, Program, Test, Unit};

/// As many places are computed at once: few enough that what is between the nodes stays near the processor.
pub(in crate::eval) const LANES: usize = 128;

/// How deep nodes are followed; deeper programs run at one place after the other.
const DEPTH: usize = 100;

type Lanes = [f64; LANES];

/// The numbers of all places, or the one that all have.
#[derive(Debug)]
pub(super) enum Many {
    Same(f64),
    Each(Box<Lanes>),
}

/// What a run keeps: the values of slots, the steps of one place, and room for numbers that is free.
struct Run {
    slots: Vec<Many>,
    steps: u64,
    #[expect(clippy::vec_box, reason = "room goes to and fro without being copied")]
    free: Vec<Box<Lanes>>,
}

/// How a function of one number is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Sine,
    Cosine,
    Other,
}

impl Many {
    fn finite(self) -> Option<Self> {
        let good = match &self {
            Self::Same(number) => number.is_finite(),
            // No early end, so that it becomes a loop over vectors.
            Self::Each(numbers) => numbers.iter().fold(true, |good, number| good & number.is_finite()),
        };
        good.then_some(self)
    }

    #[inline(always)]
    fn one(self, function: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Same(number) => Self::Same(function(number)),
            Self::Each(mut numbers) => {
                for number in numbers.iter_mut() {
                    *number = function(*number);
                }
                Self::Each(numbers)
            }
        }
    }

    fn at(&self, lane: usize) -> f64 {
        match self {
            Self::Same(number) => *number,
            Self::Each(numbers) => numbers[lane],
        }
    }
}

impl Run {
    /// Both in one, in the room of the first.
    #[inline(always)]
    fn two(&mut self, one: Many, other: Many, function: impl Fn(f64, f64) -> f64) -> Many {
        match (one, other) {
            (a, Many::Same(b)) => a.one(|a| function(a, b)),
            (Many::Same(a), b) => b.one(|b| function(a, b)),
            (Many::Each(mut a), Many::Each(b)) => {
                for (a, b) in a.iter_mut().zip(b.iter()) {
                    *a = function(*a, *b);
                }
                self.free.push(b);
                Many::Each(a)
            }
        }
    }

    fn read(&mut self, slot: usize) -> Option<Many> {
        match self.slots.get(slot)? {
            Many::Same(number) => Some(Many::Same(*number)),
            Many::Each(numbers) => {
                let mut room = self.free.pop().unwrap_or_else(|| Box::new([0.0; LANES]));
                room.copy_from_slice(&numbers[..]);
                Some(Many::Each(room))
            }
        }
    }

    fn write(&mut self, slot: usize, value: Many) -> Option<()> {
        if let Many::Each(room) = std::mem::replace(self.slots.get_mut(slot)?, value) {
            self.free.push(room);
        }
        Some(())
    }
}

impl Program {
    /// The numbers at up to [`LANES`] places, each of as many coordinates as there are parameters; none where one of them has
    /// none, or another way than its neighbors. Adds the steps that the interpreter would count.
    pub(in crate::eval) fn run_many<const N: usize>(&self, places: &[[f64; N]], steps: &mut u64) -> Option<Vec<f64>> {
        let last = *places.last()?;
        if self.unit != Unit::Number || self.slots < N || places.len() > LANES {
            return None;
        }
        let mut run = Run { slots: (0..self.slots).map(|_| Many::Same(0.0)).collect(), steps: 0, free: Vec::new() };
        for (coordinate, slot) in run.slots.iter_mut().take(N).enumerate() {
            // Places that are missing are the last one once more.
            let at = |lane: usize| places.get(lane).unwrap_or(&last)[coordinate];
            *slot = Many::Each(Box::new(std::array::from_fn(at)));
        }
        let results = self.body.many(&mut run, DEPTH)?;
        *steps += run.steps * places.len() as u64;
        Some((0..places.len()).map(|lane| results.at(lane)).collect())
    }
}

impl Node {
    fn many(&self, run: &mut Run, depth: usize) -> Option<Many> {
        let depth = depth.checked_sub(1)?;
        let result = match self {
            Self::Constant(number) => return Some(Many::Same(*number)),
            Self::Slot(slot) => return run.read(*slot),
            Self::Negative(of) => of.many(run, depth)?.one(|x| -x),
            Self::Arithmetic(operator, both) => {
                let (a, b) = (both.0.many(run, depth)?, both.1.many(run, depth)?);
                match operator {
                    Binary::Add => run.two(a, b, |a, b| a + b),
                    Binary::Subtract => run.two(a, b, |a, b| a - b),
                    Binary::Multiply => run.two(a, b, |a, b| a * b),
                    // Division by zero is not finite.
                    Binary::Divide => run.two(a, b, |a, b| a / b),
                    _ => return None,
                }
            }
            Self::One(kind, function, of) => match (kind, of.many(run, depth)?) {
                (Kind::Sine, Many::Each(mut angles)) => {
                    sines_degrees(&mut angles[..]);
                    Many::Each(angles)
                }
                (Kind::Cosine, Many::Each(mut angles)) => {
                    cosines_degrees(&mut angles[..]);
                    Many::Each(angles)
                }
                (_, numbers) => numbers.one(function),
            },
            Self::Two(function, both) => {
                let (a, b) = (both.0.many(run, depth)?, both.1.many(run, depth)?);
                run.two(a, b, function)
            }
            Self::If(parts) => {
                let chosen = if parts.0.many(run, depth)? { &parts.1 } else { &parts.2 };
                return chosen.many(run, depth);
            }
            Self::Bind(first, args, body) => {
                run.steps += 1;
                for (at, arg) in args.iter().enumerate() {
                    let value = arg.many(run, depth)?;
                    run.write(first + at, value)?;
                }
                return body.many(run, depth);
            }
            Self::Sum(first, rows, body) => {
                let mut sum = Many::Same(std::iter::empty::<f64>().sum());
                for row in rows.numbers.chunks_exact(rows.width) {
                    run.steps += 1;
                    for (at, number) in row.iter().enumerate() {
                        run.write(first + at, Many::Same(*number))?;
                    }
                    let more = body.many(run, depth)?;
                    sum = run.two(sum, more, |sum, more| sum + more);
                }
                sum
            }
        };
        result.finite()
    }
}

impl Test {
    /// The answer that all places have.
    fn many(&self, run: &mut Run, depth: usize) -> Option<bool> {
        let depth = depth.checked_sub(1)?;
        match self {
            Self::Order(operator, both) => {
                let (a, b) = (both.0.many(run, depth)?, both.1.many(run, depth)?);
                let holds = |lane: usize| {
                    let (a, b) = (a.at(lane), b.at(lane));
                    match operator {
                        Binary::Less => a < b,
                        Binary::LessEqual => a <= b,
                        Binary::Greater => a > b,
                        _ => a >= b,
                    }
                };
                let order =
                    matches!(operator, Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual);
                let answer = holds(0);
                (order && (1..LANES).all(|lane| holds(lane) == answer)).then_some(answer)
            }
            Self::Logic(operator, both) => {
                let (a, b) = (both.0.many(run, depth)?, both.1.many(run, depth)?);
                Some(if *operator == Binary::And { a && b } else { a || b })
            }
            Self::Not(of) => of.many(run, depth).map(|value| !value),
        }
    }
}
