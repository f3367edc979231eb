//! Transforms as stages: scale, turns and a move, or a frame, where these give the map exactly, else the matrix.

use super::number::{angle, direction, number, rounder, vector};
use crate::ir::{Affine, Vec3, cross, length, normalized};

/// The unit vectors along the axes.
const AXES: [Vec3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The names of the axes, as stages label them.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// How long a text may be that needs no shorter one.
const SHORT: usize = 48;

/// A stage.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// `scale`
    Scale(Vec3),
    /// `rotate` about an axis, in degrees.
    Turn(usize, f64),
    /// `rotate` about any other axis, in degrees.
    Tilt(Vec3, f64),
    /// `translate`
    Move(Vec3),
}

impl Stage {
    /// Its map, computed as evaluation does.
    fn map(self) -> Affine {
        match self {
            Self::Scale(by) => Affine::scaling(by),
            Self::Turn(axis, degrees) => turn(AXES[axis], degrees),
            Self::Tilt(axis, degrees) => turn(normalized(axis).unwrap_or_default(), degrees),
            Self::Move(by) => Affine::translation(by),
        }
    }

    /// As it is written; nothing for one that changes nothing.
    fn text(self) -> String {
        match self {
            Self::Scale([1.0, 1.0, 1.0]) | Self::Move([0.0, 0.0, 0.0]) | Self::Turn(_, 0.0) => String::new(),
            Self::Scale([x, y, z]) if x == y && y == z => format!(" |> scale({})", number(x)),
            Self::Scale(by) => format!(" |> scale({})", labelled(by, 1.0)),
            Self::Turn(axis, degrees) => format!(" |> rotate({}: {})", NAMES[axis], angle(degrees)),
            Self::Tilt(axis, degrees) => format!(" |> rotate(axis: {}, angle: {})", vector(&axis), angle(degrees)),
            Self::Move(by @ [x, y, z]) => {
                let some = by.iter().filter(|part| **part != 0.0).count();
                match some {
                    1 => format!(" |> translate({})", labelled(by, 0.0)),
                    _ => format!(" |> translate({}, {}, {})", number(x), number(y), number(z)),
                }
            }
        }
    }
}

/// The map of `rotate`.
fn turn(axis: Vec3, degrees: f64) -> Affine {
    let still = Affine::translation([0.0; 3]);
    still.then(&Affine::rotation(axis, degrees)).then(&still)
}

/// `x: 1, z: 2`, without those that are `usual`.
fn labelled(parts: Vec3, usual: f64) -> String {
    let some = NAMES.iter().zip(parts).filter(|(_, part)| *part != usual);
    some.map(|(name, part)| format!("{name}: {}", number(part))).collect::<Vec<_>>().join(", ")
}

/// What stands behind a mesh or group that is placed by `map`, which is finite and can be inverted: ` |> translate(z: 2)`.
pub(super) fn stages(map: &Affine) -> String {
    if *map == Affine::IDENTITY {
        return String::new();
    }
    let moved = Stage::Move(map.rows.map(|row| row[3]));
    let made = |stages: Vec<Stage>| {
        let all = stages.into_iter().chain([moved]);
        let all: Vec<Stage> = all.collect();
        let result = all.iter().fold(Affine::IDENTITY, |before, stage| before.then(&stage.map()));
        (result == *map).then(|| all.into_iter().map(Stage::text).collect::<String>())
    };
    if let Some(found) = quarter_turns(map).and_then(made) {
        return found;
    }
    // A turn by an angle of many digits may be a frame of few.
    match turned(map).and_then(made) {
        Some(found) if found.len() <= SHORT => found,
        found => {
            let other = framed(map).or_else(|| tilted(map).and_then(made));
            other.or(found).unwrap_or_else(|| matrix(map))
        }
    }
}

/// A scale and then a turn about any axis, of few digits.
fn tilted(map: &Affine) -> Option<Vec<Stage>> {
    let [a, b, c] = map.rows;
    let size = length([a[0], b[0], c[0]]);
    let axis = [c[1] - b[2], a[2] - c[0], b[0] - a[1]];
    let unit = normalized(axis)?;
    let degrees = libm::atan2(length(axis), a[0] + b[1] + c[2] - size).to_degrees();
    let near = |wanted: f64| rounder(wanted).into_iter().filter(move |other| (other / wanted - 1.0).abs() < 1e-9);
    let mut all = near(size).flat_map(|by| near(degrees).map(move |degrees| (by, degrees)));
    all.find_map(|(by, degrees)| {
        let stages = |axis: Vec3| [Stage::Scale([by; 3]), Stage::Tilt(axis, degrees)];
        let good = |axis: Vec3| {
            let made = stages(axis).iter().fold(Affine::IDENTITY, |before, stage| before.then(&stage.map()));
            made.rows.iter().zip(&map.rows).all(|(made, row)| made[..3] == row[..3])
        };
        few_digits(unit, &good).map(|axis| stages(axis).to_vec())
    })
}

/// ` |> frame(...)` of vectors of few digits.
fn framed(map: &Affine) -> Option<String> {
    let column = |at: usize| map.rows.map(|row| row[at]);
    let (x, z, origin) = (column(0), column(2), column(3));
    let near = |one: f64, other: f64| (one - other).abs() < 1e-9;
    if !(near(length(x), 1.0) && near(length(z), 1.0)) {
        return None;
    }
    let up = few_digits(z, &|candidate| normalized(candidate) == Some(z))?;
    // As evaluation computes it.
    let made = |wanted: Vec3| {
        let y = normalized(cross(z, normalized(wanted)?))?;
        let x = cross(y, z);
        let rows = [0, 1, 2].map(|at| [x[at], y[at], z[at], origin[at]]);
        (Affine::IDENTITY.then(&Affine { rows }) == *map && length(cross(z, wanted)) > 1e-6).then_some(wanted)
    };
    let axes = AXES.into_iter().chain(AXES.map(|axis| axis.map(|part| 0.0 - part)));
    let along = axes.into_iter().find_map(made).or_else(|| few_digits(x, &|wanted| made(wanted).is_some()))?;
    let origin = if origin == [0.0; 3] { String::new() } else { format!(", origin: {}", vector(&origin)) };
    Some(format!(" |> frame(x: {}, z: {}{origin})", direction(along), direction(up)))
}

/// A vector of few digits along `unit`, or near it, that is `good`.
pub(super) fn few_digits(unit: Vec3, good: &dyn Fn(Vec3) -> bool) -> Option<Vec3> {
    let smallest = unit.iter().map(|part| part.abs()).filter(|part| *part > 1e-9).fold(f64::INFINITY, f64::min);
    let largest = unit.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    let mut all = [smallest, largest, 1.0].into_iter().flat_map(|scale| {
        let near = unit.map(|part| rounder(part / scale));
        // The first two have four and seven digits.
        [0, 1].map(|digits: usize| [0, 1, 2].map(|axis: usize| near[axis].get(digits).or(near[axis].last()).copied()))
    });
    all.find_map(|parts| match parts {
        [Some(x), Some(y), Some(z)] if good([x, y, z]) => Some([x, y, z]),
        _ => None,
    })
}

/// ` |> matrix(...)`
pub(super) fn matrix(map: &Affine) -> String {
    let [x, y, z] = map.rows.map(|row| vector(&row));
    format!(" |> matrix({x}, {y}, {z})")
}

/// A scale along the axes and then quarter turns, with as few mirrorings and turns as there can be.
fn quarter_turns(map: &Affine) -> Option<Vec<Stage>> {
    // The row in which each column has its only number.
    let mut place = [0; 3];
    for (column, place) in place.iter_mut().enumerate() {
        let mut rows = (0..3).filter(|row| map.rows[*row][column] != 0.0);
        *place = rows.next()?;
        if rows.next().is_some() {
            return None;
        }
    }
    let entry = |column: usize| map.rows[place[column]][column];
    if place == [0, 1, 2] && (0..3).all(|column| entry(column) > 0.0) {
        return Some(vec![Stage::Scale([entry(0), entry(1), entry(2)])]);
    }
    let single = (0..3).flat_map(|axis| [90.0, 180.0, -90.0].map(|degrees| Stage::Turn(axis, degrees)));
    let single: Vec<Stage> = single.collect();
    let mut ways: Vec<Vec<Stage>> = vec![Vec::new()];
    ways.extend(single.iter().map(|turn| vec![*turn]));
    ways.extend(single.iter().flat_map(|first| single.iter().map(|second| vec![*first, *second])));
    let mut best: Option<(usize, Vec<Stage>)> = None;
    for way in ways {
        let turn = way.iter().fold(Affine::IDENTITY, |before, stage| before.then(&stage.map()));
        if (0..3).any(|column| turn.rows[place[column]][column] == 0.0) {
            continue;
        }
        let scale = [0, 1, 2].map(|column| entry(column) * turn.rows[place[column]][column]);
        let mirrored = scale.iter().filter(|part| **part < 0.0).count();
        if best.as_ref().is_none_or(|(least, _)| mirrored < *least) {
            best = Some((mirrored, [vec![Stage::Scale(scale)], way].concat()));
        }
    }
    best.map(|(_, stages)| stages)
}

/// A scale along the axes and then one turn about an axis, of round numbers where they give the same.
fn turned(map: &Affine) -> Option<Vec<Stage>> {
    let rows = &map.rows;
    let alone = |axis: usize| (0..3).all(|other| other == axis || rows[axis][other] == 0.0 && rows[other][axis] == 0.0);
    let axis = (0..3).find(|axis| alone(*axis))?;
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (a, b, c, d) = (rows[i][i], rows[j][i], rows[i][j], rows[j][j]);
    let first = libm::hypot(a, b);
    let second = libm::hypot(c, d) * (a * d - b * c).signum();
    // A map that bends angles is none.
    if (a * c + b * d).abs() > 1e-9 * first * second.abs() {
        return None;
    }
    for degrees in rounder(libm::atan2(b, a).to_degrees()) {
        let turn = Stage::Turn(axis, degrees).map().rows;
        let of_first = |by: &f64| turn[i][i] * by == a && turn[j][i] * by == b;
        let Some(one) = rounder(first).into_iter().find(of_first) else { continue };
        let of_second = |by: &f64| turn[i][j] * by == c && turn[j][j] * by == d;
        let Some(other) = rounder(second).into_iter().find(of_second) else { continue };
        let mut scale = [rows[axis][axis]; 3];
        (scale[i], scale[j]) = (one, other);
        // What is all but no scale says less than a matrix.
        if scale.iter().any(|by| *by != 1.0 && (by - 1.0).abs() < 1e-9) {
            return None;
        }
        return Some(vec![Stage::Scale(scale), Stage::Turn(axis, degrees)]);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(stages: &[Stage]) -> String {
        super::stages(&stages.iter().fold(Affine::IDENTITY, |before, stage| before.then(&stage.map())))
    }

    #[test]
    fn maps_are_written_as_people_write_them() {
        use Stage::{Move, Scale, Tilt, Turn};
        assert_eq!(of(&[]), "");
        assert_eq!(of(&[Scale([2.0; 3]), Move([0.0, 0.0, -1.5])]), " |> scale(2) |> translate(z: -1.5)");
        assert_eq!(of(&[Scale([1.0, 3.0, 1.0]), Move([1.0, 2.0, 3.0])]), " |> scale(y: 3) |> translate(1, 2, 3)");
        assert_eq!(of(&[Turn(2, -17.5), Move([17.0, 0.0, 15.0])]), " |> rotate(z: -17.5deg) |> translate(17, 0, 15)");
        assert_eq!(of(&[Scale([0.1; 3]), Turn(0, 33.0)]), " |> scale(0.1) |> rotate(x: 33deg)");
        assert_eq!(of(&[Scale([1.0, 2.0, 3.0]), Turn(1, 90.0)]), " |> scale(y: 2, z: 3) |> rotate(y: 90deg)");
        assert_eq!(of(&[Turn(0, 90.0), Turn(2, 90.0)]), " |> rotate(x: 90deg) |> rotate(z: 90deg)");
        assert_eq!(of(&[Scale([-1.0, 1.0, 1.0])]), " |> scale(x: -1)");
        let tilted = of(&[Scale([0.3; 3]), Tilt([1.0, 2.0, -0.5], 12.5)]);
        assert_eq!(tilted, " |> scale(0.3) |> rotate(axis: (2, 4, -1), angle: 12.5deg)");
    }

    #[test]
    fn frames_of_few_digits_are_found_again() {
        let z = normalized([0.0, -0.9845, 0.1755]).expect("a direction");
        let y = normalized(cross(z, AXES[0])).expect("a direction");
        let x = cross(y, z);
        let map = Affine { rows: [0, 1, 2].map(|at| [x[at], y[at], z[at], [0.0, 7.8538, 45.9912][at]]) };
        assert_eq!(stages(&map), " |> frame(x: X, z: (0, -0.9845, 0.1755), origin: (0, 7.8538, 45.9912))");
    }

    #[test]
    fn what_is_no_such_map_is_a_matrix() {
        let sheared = Affine { rows: [[1.0, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, -0.0], [0.0, 0.0, 1.0, 3.0]] };
        assert_eq!(stages(&sheared), " |> matrix((1, 0.5, 0, 0), (0, 1, 0, 0), (0, 0, 1, 3))");
        let odd = normalized([0.123_456_789_1, 0.987_654_321_9, 0.555_555_123_4]).expect("an axis");
        assert!(stages(&Affine::rotation(odd, 20.123_456_789_1)).starts_with(" |> matrix("));
    }
}
