//! Rule `large-mesh`: meshes stay small enough to be handed about.
#![doc = include_str!("large_mesh.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "large-mesh",
    level: Level::Allow,
    summary: "A mesh has more than 100 000 triangles.",
    doc: include_str!("large_mesh.md"),
    targets: &[],
    check,
};

/// The most triangles of a mesh, from the methodology of the `lteval` test suite (Tázlar 2020).
const MOST: usize = 100_000;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter().filter(|(_, mesh)| mesh.triangles.len() > MOST) {
        report.add(
            scene.meshes.origin(handle),
            format!("the mesh `{}` has {} triangles", mesh.name, mesh.triangles.len()),
            "made here",
            "a test scene is copied, read and built into trees by every renderer that is compared; time is then spent on what it \
             does not test",
            format!("make it with fewer segments, at most {MOST} triangles"),
        );
    }
}
