//! Cameras, film, integrator, sampler, and what was lost when the files were read.

use super::Side;
use super::fact::{Fact, Facts, Measure};
use super::report::{Kind, Place, Report};
use crate::diag::Finding;
use crate::ir::{Camera, Film, Filter, Scene, dot, sub};
use crate::survey::Survey;

/// Compares the settings of two scenes.
pub fn compare(a: Side<'_>, b: Side<'_>, surveys: &[Survey<'_>; 2], measure: Measure, report: &mut Report) {
    cameras(surveys, measure, report);
    let (one, other) = (a.scene, b.scene);
    let places = [one, other].map(|scene| Some(Place { name: scene.name.clone(), origin: scene.origin.clone() }));
    let mut rows = |kind, one: &Facts, other: &Facts| {
        for (what, words) in one.differences(other, measure) {
            report.add(kind, &what, words, places.clone());
        }
    };
    rows(Kind::Film, &film(&one.film), &film(&other.film));
    rows(Kind::Film, &filter(&one.film.filter), &filter(&other.film.filter));
    rows(Kind::Integrator, &integrator(one), &integrator(other));
    rows(Kind::Sampler, &sampler(one), &sampler(other));
    losses([a.findings, b.findings], report);
}

fn whole(number: u32) -> Fact {
    Fact::Exact(number.to_string())
}

fn film(Film { width, height, filter: _ }: &Film) -> Facts {
    Facts { word: "image", rows: vec![("size", Fact::Exact(format!("{width} x {height}")))] }
}

fn filter(filter: &Filter) -> Facts {
    match filter {
        Filter::Box { radius } => Facts { word: "box", rows: vec![("radius", Fact::Number(*radius, "pixels"))] },
        Filter::Gaussian { stddev, radius } => Facts {
            word: "gaussian",
            rows: vec![("stddev", Fact::Number(*stddev, "pixels")), ("radius", Fact::Number(*radius, "pixels"))],
        },
    }
}

fn integrator(scene: &Scene) -> Facts {
    Facts {
        word: "integrator",
        rows: vec![
            ("algorithm", Fact::Exact(scene.integrator.word().to_owned())),
            ("max_depth", whole(scene.integrator.max_depth())),
        ],
    }
}

fn sampler(scene: &Scene) -> Facts {
    Facts {
        word: "sampler",
        rows: vec![
            ("kind", Fact::Exact(scene.sampler.word().to_owned())),
            ("samples", whole(scene.sampler.samples())),
            ("seed", whole(scene.sampler.seed())),
        ],
    }
}

fn cameras(surveys: &[Survey<'_>; 2], measure: Measure, report: &mut Report) {
    let [a, b] = [&surveys[0].scene.cameras, &surveys[1].scene.cameras];
    if a.len() != b.len() {
        report.add(Kind::Camera, "number of cameras", [a.len().to_string(), b.len().to_string()], [None, None]);
    }
    for ((from, one), (to, other)) in a.entries().zip(b.entries()) {
        let name = |camera: &Camera| camera.name.clone().unwrap_or_default();
        let places = [(one, from), (other, to)]
            .map(|(camera, origin)| Some(Place { name: name(camera), origin: origin.clone() }));
        let facts = [one, other].map(view);
        for (what, words) in facts[0].differences(&facts[1], measure) {
            report.add(Kind::Camera, &what, words, places.clone());
        }
        let clipping = [("near clipping", one.near, other.near), ("far clipping", one.far, other.far)];
        for (what, ours, theirs) in clipping {
            let same = match (ours, theirs) {
                (Some(a), Some(b)) => measure.numbers(a, b),
                (None, None) => true,
                (Some(_), None) | (None, Some(_)) => false,
            };
            if !same && (cuts(&surveys[0], one) || cuts(&surveys[1], other)) {
                let words = [ours, theirs].map(|distance| distance.map_or("none".to_owned(), super::fact::short));
                report.add(Kind::Camera, what, words, places.clone());
            }
        }
    }
}

fn view(camera: &Camera) -> Facts {
    let mut rows = vec![("position", Fact::Place(camera.eye))];
    if let Some(axes) = camera.axes() {
        rows.push(("direction", Fact::Direction(axes.forward)));
        rows.push(("up", Fact::Direction(axes.up)));
    }
    rows.push(("horizontal field of view", Fact::Number(camera.fov_x, "deg")));
    Facts { word: "camera", rows }
}

/// Whether the clipping planes of a camera may cut something: a surface whose box they meet, or that lies beyond one of them.
fn cuts(survey: &Survey<'_>, camera: &Camera) -> bool {
    let Some(axes) = camera.axes() else { return true };
    let near = camera.near.unwrap_or(0.0);
    let far = camera.far.unwrap_or(f64::INFINITY);
    let depth = |point| dot(sub(point, camera.eye), axes.forward);
    let reaches = |depths: &mut dyn Iterator<Item = f64>| {
        let (low, high) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        low < near && high > 0.0 || high > far
    };
    survey.placed.iter().any(|placed| {
        reaches(&mut placed.bounds.corners().into_iter().map(depth))
            && survey.triangles(placed).any(|corners| reaches(&mut corners.into_iter().map(depth)))
    })
}

/// What one of the files says and its scene does not hold, where that of the other does not say the same.
fn losses(findings: [&[Finding]; 2], report: &mut Report) {
    let lost = |side: usize| {
        findings[side].iter().filter(|finding| matches!(finding.id, "loss-dropped" | "loss-approximated"))
    };
    let place = |finding: &Finding| Some(Place { name: String::new(), origin: finding.origin.clone() });
    for (side, other) in [(0, 1), (1, 0)] {
        let known: std::collections::HashSet<&str> = lost(other).map(|finding| finding.message.as_str()).collect();
        for finding in lost(side).filter(|finding| !known.contains(finding.message.as_str())) {
            let mut words = ["".to_owned(), "".to_owned()];
            words[side] =
                std::iter::once(&finding.message).chain(&finding.notes).cloned().collect::<Vec<_>>().join("; ");
            words[other] = "-".to_owned();
            let mut places = [None, None];
            places[side] = place(finding);
            let what = ["only in A, and not held by the scene", "only in B, and not held by the scene"][side];
            report.add(Kind::Reading, what, words, places);
        }
    }
}
