//! Rule `inside-out-mesh`: the normals of a closed body look outwards.
#![doc = include_str!("inside_out_mesh.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{Bsdf, Handle, Mesh};
use crate::survey::Placed;

pub(super) const RULE: Rule = Rule {
    id: "inside-out-mesh",
    level: Level::Warn,
    summary: "A closed mesh has its normals inside, and no camera is in it.",
    doc: include_str!("inside_out_mesh.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    // Rooms are seen from inside.
    let mut rooms: Vec<Option<bool>> = vec![None; scene.meshes.len()];
    let mut is_room = |mesh: Handle<Mesh>| {
        let seen = |placed: &Placed<'_>| scene.cameras.values().any(|camera| placed.bounds.contains(camera.eye));
        *rooms[mesh.index()].get_or_insert_with(|| {
            subject.survey().placed.iter().any(|placed| placed.shape.mesh == mesh && seen(placed))
        })
    };
    for (origin, shape) in scene.surfaces().filter(|(_, shape)| shape.material.index() < scene.materials.len()) {
        if let Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } = &scene.materials[shape.material].bsdf {
            continue;
        }
        if !subject.is_inside_out(shape.mesh) || is_room(shape.mesh) {
            continue;
        }
        let emits = shape.emission.is_some();
        let finding = report.add(
            origin,
            format!("the normals of the closed {} `{}` look into it", if emits { "emitter" } else { "surface" }, shape.name),
            if emits { "shines inwards" } else { "inside out" },
            if emits {
                "an emitter shines on the side of its normals: no light leaves it"
            } else {
                "materials scatter on both sides here, but renderers with one-sided surfaces (Mitsuba without `twosided`, glTF without \
                 `doubleSided`) show it black or not at all"
            },
            if emits {
                "write `|> flip()` behind its mesh, unless it is to light what lies in it".to_owned()
            } else {
                "write `|> flip()` behind its mesh".to_owned()
            },
        );
        finding.fixable = !emits;
    }
}
