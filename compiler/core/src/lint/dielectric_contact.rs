//! Rule `dielectric-contact`: glass lies against nothing.
#![doc = include_str!("dielectric_contact.md")]

use std::collections::BTreeMap;

use super::{Level, Report, Rule, Subject, also_once, short};
use crate::contact::{Role, role};
use crate::survey::Placed;

pub(super) const RULE: Rule = Rule {
    id: "dielectric-contact",
    level: Level::Deny,
    summary: "A face of a dielectric lies on another surface or so close to it that renderers mistake one for the other.",
    doc: include_str!("dielectric_contact.md"),
    targets: &[],
    check,
};

/// The least part of the smaller surface that must be close: a ball that lies on the floor touches it at a point.
const PART: f64 = 1e-3;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    // The finding about each use: further surfaces that touch it are further places.
    let mut known: BTreeMap<usize, usize> = BTreeMap::new();
    for contact in &subject.contacts().found {
        let uses = contact.uses.map(|at| &survey.placed[at]);
        let clear = |placed: &&Placed<'_>| role(survey, placed) == Role::Dielectric;
        let Some(at) = uses.iter().rposition(clear) else { continue };
        let (glass, other) = (uses[at], uses[1 - at]);
        let close = contact.same.and(contact.opposite);
        if close.near < PART * subject.area(glass).min(subject.area(other)) {
            continue;
        }
        if let Some(finding) = known.get(&contact.uses[at]).and_then(|known| report.findings.get_mut(*known)) {
            also_once(finding, other.origin, "touched by it too");
            continue;
        }
        known.insert(contact.uses[at], report.findings.len());
        let enough = short(2.0 * contact.nearness);
        let itself = contact.uses[0] == contact.uses[1];
        let (message, help) = if itself {
            (
                format!("faces of the dielectric `{}` lie {} apart", glass.name(), short(close.gap)),
                format!("make it at least {enough} thick"),
            )
        } else {
            let message = if close.coplanar > 0.0 {
                format!("the dielectric `{}` lies on `{}`", glass.name(), other.name())
            } else {
                format!("the dielectric `{}` lies {} from `{}`", glass.name(), short(close.gap), other.name())
            };
            let help = if role(survey, other) == Role::Dielectric {
                format!("leave a gap of {enough} between the two, or make one body of them")
            } else {
                format!(
                    "lift it by {enough} (a thin gap of air), or sink it by {enough} (contact without air); both are well defined, and differ"
                )
            };
            (message, help)
        };
        let finding = report.add(
            glass.origin,
            message,
            if itself { "too thin" } else { "this dielectric" },
            "a ray that leaves one of the faces does not see the other, or meets both at one distance: light ends up on the wrong side of \
             the glass in Mitsuba and PBRT, by 2 to 8 per cent of the image for a box on a floor",
            help,
        );
        if !itself {
            also_once(finding, other.origin, "touched by it");
        }
    }
}
