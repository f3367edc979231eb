//! Rule `emitter-in-wall`: lamps do not lie in walls.
#![doc = include_str!("emitter_in_wall.md")]

use super::{Level, Report, Rule, Subject, also, short};
use crate::contact::{Role, role};

pub(super) const RULE: Rule = Rule {
    id: "emitter-in-wall",
    level: Level::Deny,
    summary: "An emitter lies in the plane of a surface, and renderers see one or the other.",
    doc: include_str!("emitter_in_wall.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let survey = subject.survey();
    for contact in &subject.contacts().found {
        let uses = contact.uses.map(|at| &survey.placed[at]);
        let roles = uses.map(|placed| role(survey, placed));
        let (lamp, wall) = match roles {
            [Role::Emitter, Role::Opaque] => (uses[0], uses[1]),
            [Role::Opaque, Role::Emitter] => (uses[1], uses[0]),
            _ => continue,
        };
        // The underside of a closed lamp that stands on something lights nothing, and is not seen.
        let into = contact.opposite.near > 0.0 && !subject.is_closed(lamp.shape.mesh);
        if contact.same.near == 0.0 && !into {
            continue;
        }
        let enough = short(2.0 * contact.nearness);
        let finding = report.add(
            lamp.origin,
            if into {
                format!("the emitter `{}` lies on `{}` and shines into it", lamp.name(), wall.name())
            } else {
                format!("the emitter `{}` lies in the surface of `{}`", lamp.name(), wall.name())
            },
            "this emitter",
            "a ray meets both at one distance, and rounding decides whether it sees light; shadow rays stop short of the lamp by an \
             epsilon of the renderer's own and do not see a wall in front of it",
            if into { "turn it round, and move it off the surface".to_owned() } else { format!("move it {enough} in front of the surface") },
        );
        also(finding, wall.origin, "in one plane with it");
    }
}
