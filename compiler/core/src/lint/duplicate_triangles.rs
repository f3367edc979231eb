//! Rule `duplicate-triangles`: no two triangles of a mesh lie at one place.
#![doc = include_str!("duplicate_triangles.md")]

use super::{Level, Report, Rule, Subject, plural};
use crate::mesh::{View, duplicate_triangles};

pub(super) const RULE: Rule = Rule {
    id: "duplicate-triangles",
    level: Level::Warn,
    summary: "Triangles of a mesh lie exactly on others of it.",
    doc: include_str!("duplicate_triangles.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter() {
        let found = duplicate_triangles(View::from(mesh));
        if found.count == 0 {
            continue;
        }
        let triangles = plural(found.count, "triangle");
        report.add(
            scene.meshes.origin(handle),
            format!("the mesh `{}` has {triangles} on others, the first is number {}", mesh.name, found.first),
            "made here",
            "a ray meets both at one distance: which one counts depends on the renderer's tree, an emitter shines twice, and glass \
             is entered twice or not at all",
            "remove them in the program that made the mesh; a surface has two sides without a second triangle".to_owned(),
        );
    }
}
