//! Rule `overlapping-faces`: two surfaces do not share a plane.
#![doc = include_str!("overlapping_faces.md")]

use super::{Level, Report, Rule, Subject, also, plural};
use crate::contact::{Role, role};

pub(super) const RULE: Rule = Rule {
    id: "overlapping-faces",
    level: Level::Warn,
    summary: "Faces of two materials lie in one plane and over each other, and renderers show one or the other.",
    doc: include_str!("overlapping_faces.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    let contacts = subject.contacts();
    for contact in &contacts.found {
        let uses = contact.uses.map(|at| &survey.placed[at]);
        // Glass, and lamps in walls, have rules of their own.
        let both_emit = match uses.map(|placed| role(survey, placed)) {
            [Role::Opaque, Role::Opaque] => false,
            [Role::Emitter, Role::Emitter] => true,
            _ => continue,
        };
        // Of opposite faces a closed body hides the other: nobody sees the underside of a box.
        let open = || uses.iter().all(|placed| !subject.is_closed(placed.shape.mesh));
        let seen = contact.same.coplanar > 0.0 || contact.opposite.coplanar > 0.0 && open();
        if !seen {
            continue;
        }
        let [one, other] = uses;
        let finding = report.add(
            other.origin,
            format!("faces of `{}` and `{}` lie over each other in one plane", one.name(), other.name()),
            "this one",
            if both_emit {
                "a ray meets both at one distance and sees one of them, a renderer that samples lights counts both"
            } else {
                "a ray meets both at one distance: which material it sees is decided by rounding, another way in each renderer"
            },
            "move one of them off the other, or leave out what the other covers".to_owned(),
        );
        also(finding, one.origin, "in one plane with it");
    }
    if contacts.left_out > 0 {
        let pairs = plural(contacts.left_out, "pair");
        report.add(
            &subject.scene.origin,
            format!("{pairs} of surfaces were not held against each other"),
            "this scene",
            "their boxes overlap so often that the work would take minutes",
            "nothing need be done; contacts in the rest of the scene are reported".to_owned(),
        );
    }
}
