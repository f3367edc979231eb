//! Rule `needless-triangles`: flat parts are not cut into many triangles.
#![doc = include_str!("needless_triangles.md")]

use super::{Level, Report, Rule, Subject};
use crate::mesh::{View, fewest_triangles};

pub(super) const RULE: Rule = Rule {
    id: "needless-triangles",
    level: Level::Allow,
    summary: "Neighbors in one plane would merge to less than a tenth of a mesh's triangles.",
    doc: include_str!("needless_triangles.md"),
    targets: &[],
    check,
};

/// A mesh of so many triangles or fewer is not worth a thought.
const FEW: usize = 100;

/// The least part of the triangles that must be needed.
const PART: usize = 10;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter().filter(|(_, mesh)| mesh.triangles.len() > FEW) {
        let fewest = fewest_triangles(View::from(mesh));
        if fewest * PART >= mesh.triangles.len() {
            continue;
        }
        report.add(
            scene.meshes.origin(handle),
            format!("the mesh `{}` has {} triangles where {fewest} make the same surface", mesh.name, mesh.triangles.len()),
            "made here",
            "every renderer reads and stores them, and edges between them are places where rays may slip through or meet two \
             triangles",
            "merge neighbors that lie in one plane, or write a generator that makes fewer".to_owned(),
        );
    }
}
