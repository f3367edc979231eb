//! Rule `degenerate-triangles`: every triangle has a face.
#![doc = include_str!("degenerate_triangles.md")]

use super::{Level, Report, Rule, Subject, plural};

pub(super) const RULE: Rule = Rule {
    id: "degenerate-triangles",
    level: Level::Warn,
    summary: "Triangles have no area, or are so thin that rounding decides where they look.",
    doc: include_str!("degenerate_triangles.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter() {
        let found = subject.faults(handle).degenerate;
        if found.count == 0 {
            continue;
        }
        let triangles = plural(found.count, "triangle");
        report.add(
            scene.meshes.origin(handle),
            format!("the mesh `{}` has {triangles} without area, the first at index {} (counted from 0)", mesh.name, found.first),
            "made here",
            "PBRT never hits a triangle without area, Mitsuba divides by its area, and of a sliver that vanishes in single \
             precision every renderer computes another normal",
            "remove them in the program that made the mesh; `|> faceted()` and `|> smooth()` leave out only those without any area, not \
             slivers"
                .to_owned(),
        );
    }
}
