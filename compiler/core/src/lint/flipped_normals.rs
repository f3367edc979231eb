//! Rule `flipped-normals`: normals look to the front of their faces.
#![doc = include_str!("flipped_normals.md")]

use super::{Level, Report, Rule, Subject, plural};

pub(super) const RULE: Rule = Rule {
    id: "flipped-normals",
    level: Level::Deny,
    summary: "Vertex normals look to the back of a face, and renderers take different sides for its front.",
    doc: include_str!("flipped_normals.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter() {
        let found = subject.faults(handle).flipped;
        if found.count == 0 {
            continue;
        }
        let help = if found.count == mesh.triangles.len() {
            "write `|> faceted()` or `|> smooth()` behind it, which follow the winding, and `|> flip()` where the normals were right"
        } else {
            "write `|> faceted()` or `|> smooth()` behind it: both compute the normals from the winding"
        };
        let triangles = plural(found.count, "triangle");
        let message = format!(
            "the normals of {triangles} of the mesh `{}` look to the back, the first is number {}",
            mesh.name, found.first
        );
        report.add(
            scene.meshes.origin(handle),
            message,
            "made here",
            "PBRT and Mitsuba 0.x turn the face to its normals, Cycles and glTF take the winding for the front: emitters shine to \
             different sides, and inside and outside of glass change places",
            help.to_owned(),
        );
    }
}
