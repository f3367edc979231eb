//! Rule `overlapping-faces`: two surfaces do not share a plane.
#![doc = include_str!("overlapping_faces.md")]

use std::collections::HashSet;

use super::{Level, Report, Rule, Subject, also, plural, short};
use crate::contact::{Role, coplanarity, places, role};
use crate::survey::{Placed, faces_against, whole, winding};

pub(super) const RULE: Rule = Rule {
    id: "overlapping-faces",
    level: Level::Warn,
    summary: "Faces lie in one plane and over each other, and renderers show one, the other, or neither.",
    doc: include_str!("overlapping_faces.md"),
    targets: &[],
    check,
};

/// What may be done to find out whether light reaches places where surfaces of one material meet: some seconds.
const WORK: u64 = 20_000_000;

/// What a surface near such a place costs beside its triangles.
const NEAR: u64 = 50;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    let contacts = subject.contacts();
    // Of a surface that lies in one plane with many one is named.
    let mut told = HashSet::new();
    let mut work = WORK;
    let mut left_out = contacts.left_out;
    for contact in &contacts.found {
        if told.contains(&contact.uses[1]) {
            continue;
        }
        let uses = contact.uses.map(|at| &survey.placed[at]);
        let [one, other] = uses;
        // Glass, and lamps in walls, have rules of their own.
        let both_emit = match uses.map(|placed| role(survey, placed)) {
            [Role::Opaque, Role::Opaque] => false,
            [Role::Emitter, Role::Emitter] => true,
            _ => continue,
        };
        // Of opposite faces a closed body hides the other: nobody sees the underside of a box.
        let open = || uses.iter().all(|placed| !subject.is_closed(placed.shape.mesh));
        let opposite = || contact.opposite.coplanar > 0.0 && open();
        let alike = !both_emit && alike(subject, uses);
        let seen = if alike {
            if !subject.asks_for("cycles") {
                continue;
            }
            let same = if contact.same.coplanar > 0.0 { lit(subject, contact.uses, &mut work) } else { Some(false) };
            let Some(same) = same else {
                left_out += 1;
                continue;
            };
            same || opposite()
        } else {
            contact.same.coplanar > 0.0 || opposite()
        };
        if !seen {
            continue;
        }
        told.insert(contact.uses[1]);
        let message = format!("faces of `{}` and `{}` lie over each other in one plane", one.name(), other.name());
        let (note, help) = if alike {
            (
                "a ray that leaves one of them meets the other at once in Cycles, which shows black there (0.0002 for 0.8); other \
                 renderers show one face, as both have one material",
                format!(
                    "move the face of one of them {} or more behind that of the other",
                    short(5.0 * contact.nearness)
                ),
            )
        } else {
            (
                if both_emit {
                    "a ray meets both at one distance and sees one of them, a renderer that samples lights counts both"
                } else {
                    "a ray meets both at one distance: which material it sees is decided by rounding, another way in each renderer"
                },
                "move one of them off the other, or leave out what the other covers".to_owned(),
            )
        };
        let finding = report.add(other.origin, message, "this one", note, help);
        also(finding, one.origin, "in one plane with it");
    }
    if left_out > 0 {
        let least = if contacts.uncounted { "at least " } else { "" };
        let pairs = format!("{least}{}", plural(left_out, "pair"));
        report.add(
            &subject.scene.origin,
            format!("{pairs} of surfaces were not held against each other"),
            "this scene",
            "their boxes overlap so often that the work would take minutes",
            "nothing need be done; contacts in the rest of the scene are reported".to_owned(),
        );
    }
}

/// Whether two uses have materials that scatter alike.
fn alike(subject: &Subject<'_>, uses: [&Placed<'_>; 2]) -> bool {
    let materials = &subject.scene.materials;
    let [a, b] = uses.map(|placed| placed.shape.material);
    let known = |at: usize| at < materials.len();
    known(a.index())
        && known(b.index())
        && materials[a].bsdf == materials[b].bsdf
        && materials[a].sides == materials[b].sides
}

/// Whether light can reach a place where two uses look the same way: it does not lie within a closed opaque body, nor against a wall.
/// None where `work` is used up, which counts the surfaces that are looked at, those near the place by their triangles.
fn lit(subject: &Subject<'_>, uses: [usize; 2], work: &mut u64) -> Option<bool> {
    let survey = subject.survey();
    let mut spend = |cost: u64| {
        let left = work.checked_sub(cost);
        *work = left.unwrap_or_default();
        left
    };
    spend(NEAR)?;
    for (place, normal) in places(survey, uses) {
        let reach = place.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let off = 8.0 * coplanarity(reach);
        let before = [0, 1, 2].map(|axis| place[axis] + off * normal[axis]);
        let mut dark = false;
        for (at, placed) in survey.placed.iter().enumerate() {
            spend(1)?;
            let near = placed.bounds.grown(off).contains(place) || placed.bounds.contains(before);
            if !near || role(survey, placed) == Role::Dielectric {
                continue;
            }
            let triangles = subject.scene.meshes[placed.shape.mesh].triangles.len() as u64;
            spend(NEAR.saturating_add(triangles))?;
            let hides = placed.bounds.contains(before)
                && subject.is_closed(placed.shape.mesh)
                && whole(winding(survey.triangles(placed), before)).is_some_and(|times| times != 0);
            let covers = !uses.contains(&at) && faces_against(survey, placed, place, normal, 2.0 * coplanarity(reach));
            if hides || covers {
                dark = true;
                break;
            }
        }
        if !dark {
            return Some(true);
        }
    }
    Some(false)
}
