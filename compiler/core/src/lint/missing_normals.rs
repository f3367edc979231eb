//! Rule `missing-normals`: meshes carry explicit normals.
#![doc = include_str!("missing_normals.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "missing-normals",
    level: Level::Deny,
    summary: "A mesh has no normals, and renderers make up different ones.",
    doc: include_str!("missing_normals.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter() {
        if mesh.normals.is_none() {
            report.add(
                scene.meshes.origin(handle),
                format!("the mesh `{}` has no normals", mesh.name),
                "made here",
                "Mitsuba computes smooth normals for such a mesh, PBRT shades it flat, Blender asks the file",
                "write `|> faceted()` or `|> smooth()` behind it".to_owned(),
            );
        }
    }
}
