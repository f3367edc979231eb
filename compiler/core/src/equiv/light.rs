//! Lights without a surface.

use super::fact::{Fact, Facts, Measure};
use super::look::Images;
use super::near::{Spot, pairs};
use super::report::{Kind, Place, Report};
use crate::diag::Origin;
use crate::ir::{Affine, LightKind, LightSource, Scene, Vec3, normalized, sub};

type Lights<'s> = Vec<(&'s Origin, &'s LightSource)>;

/// Compares the lights of two scenes: those at one place are one.
pub fn compare(a: &Scene, b: &Scene, measure: Measure, report: &mut Report) {
    let mut images = Images::of(a, b, measure);
    let lit = |scene| -> Lights<'_> {
        let scene: &Scene = scene;
        scene.lights.entries().filter(|(_, light)| !light.kind.color().is_black()).collect()
    };
    let (mut ours, mut theirs) = (lit(a), lit(b));
    // Those that are the same, then those that lie at one place, then one after the other of one kind.
    for round in [Round::Same, Round::Place, Round::Kind] {
        let spots = |lights: &Lights<'_>, reach: &dyn Fn(Vec3) -> f64| -> Vec<Spot> {
            let spot = |(_, light): &(&Origin, &LightSource)| {
                let at = if round == Round::Kind { [0.0; 3] } else { place(&light.kind) };
                Spot { at, reach: reach(at) }
            };
            lights.iter().map(spot).collect()
        };
        let within = |at: Vec3| measure.distance(at.iter().fold(measure.size, |most, x| most.max(x.abs())));
        let found = pairs(&spots(&ours, &within), &spots(&theirs, &|_| 0.0), |at, to| {
            let (one, other) = (&ours[at].1.kind, &theirs[to].1.kind);
            if one.word() != other.word() {
                return None;
            }
            let same = round != Round::Same
                || facts(one, other, &mut images).is_none_or(|[a, b]| a.differences(&b, measure).is_empty());
            same.then_some(0)
        });
        let mut kept = [vec![true; ours.len()], vec![true; theirs.len()]];
        for (at, to) in found {
            (kept[0][at], kept[1][to]) = (false, false);
            let (one, other) = (ours[at], theirs[to]);
            let Some([first, second]) = facts(&one.1.kind, &other.1.kind, &mut images) else { continue };
            for (what, words) in first.differences(&second, measure) {
                report.add(Kind::Light, &what, words, [named(one), named(other)]);
            }
        }
        for (lights, kept) in [&mut ours, &mut theirs].into_iter().zip(kept) {
            let mut kept = kept.into_iter();
            lights.retain(|_| kept.next().unwrap_or(true));
        }
    }
    for one in ours {
        let (word, none) = (alone(&one.1.kind), "none".to_owned());
        report.add(Kind::Light, "only in A", [word, none], [named(one), None]);
    }
    for other in theirs {
        let (word, none) = (alone(&other.1.kind), "none".to_owned());
        report.add(Kind::Light, "only in B", [none, word], [None, named(other)]);
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Round {
    Same,
    Place,
    Kind,
}

fn named((origin, light): (&Origin, &LightSource)) -> Option<Place> {
    Some(Place { name: light.name.clone(), origin: origin.clone() })
}

/// Where a light is looked for: its position, or the direction of one that has none.
fn place(kind: &LightKind) -> Vec3 {
    match kind {
        LightKind::Environment { radiance: _, tint: _, turn: _ } => [0.0; 3],
        LightKind::Point { position, intensity: _ }
        | LightKind::Spot { position, target: _, intensity: _, angle: _, inner: _ } => *position,
        LightKind::Directional { direction, irradiance: _ } => *direction,
    }
}

fn alone(kind: &LightKind) -> String {
    format!("{} of {}", kind.word(), super::fact::shown(kind.color()))
}

fn axis(from: Vec3, to: Vec3) -> Fact {
    Fact::Direction(normalized(sub(to, from)).unwrap_or([0.0; 3]))
}

/// Both as facts; none for two of different kinds.
fn facts(a: &LightKind, b: &LightKind, images: &mut Images<'_>) -> Option<[Facts; 2]> {
    let rows = match (a, b) {
        (
            LightKind::Environment { radiance: one, tint, turn },
            LightKind::Environment { radiance: other, tint: tint_b, turn: turn_b },
        ) => {
            let [one_fact, other_fact] = images.facts(one, other);
            let rows = |radiance: Fact, image: bool, tint: &crate::ir::Color, turn: &Affine| {
                let mut rows = vec![("radiance", radiance)];
                if image {
                    let [x, y, z] = turn.rows.map(|[x, y, z, _]| Fact::Direction([x, y, z]));
                    rows.extend([("tint", Fact::Color(tint.clone())), ("turn x", x), ("turn y", y), ("turn z", z)]);
                }
                rows
            };
            [
                rows(one_fact, one.texture().is_some(), tint, turn),
                rows(other_fact, other.texture().is_some(), tint_b, turn_b),
            ]
        }
        (LightKind::Point { .. }, LightKind::Point { .. })
        | (LightKind::Spot { .. }, LightKind::Spot { .. })
        | (LightKind::Directional { .. }, LightKind::Directional { .. }) => [plain(a), plain(b)],
        (
            LightKind::Environment { .. }
            | LightKind::Point { .. }
            | LightKind::Spot { .. }
            | LightKind::Directional { .. },
            LightKind::Environment { .. }
            | LightKind::Point { .. }
            | LightKind::Spot { .. }
            | LightKind::Directional { .. },
        ) => return None,
    };
    let [one, other] = rows;
    Some([Facts { word: a.word(), rows: one }, Facts { word: b.word(), rows: other }])
}

/// The facts of a light that is no environment.
fn plain(kind: &LightKind) -> Vec<(&'static str, Fact)> {
    match kind {
        LightKind::Environment { radiance: _, tint: _, turn: _ } => Vec::new(),
        LightKind::Point { position, intensity } => {
            vec![("position", Fact::Place(*position)), ("intensity", Fact::Color(intensity.clone()))]
        }
        LightKind::Spot { position, target, intensity, angle, inner } => vec![
            ("position", Fact::Place(*position)),
            ("direction", axis(*position, *target)),
            ("intensity", Fact::Color(intensity.clone())),
            ("angle", Fact::Number(*angle, "deg")),
            ("inner angle", Fact::Number(*inner, "deg")),
        ],
        LightKind::Directional { direction, irradiance } => {
            vec![("direction", axis([0.0; 3], *direction)), ("irradiance", Fact::Color(irradiance.clone()))]
        }
    }
}
