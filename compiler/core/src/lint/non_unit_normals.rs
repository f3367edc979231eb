//! Rule `non-unit-normals`: normals have the length 1.
#![doc = include_str!("non_unit_normals.md")]

use super::{Level, Report, Rule, Subject};
use crate::mesh::is_unit;

pub(super) const RULE: Rule = Rule {
    id: "non-unit-normals",
    level: Level::Warn,
    summary: "A mesh has normals of another length than 1.",
    doc: include_str!("non_unit_normals.md"),
    targets: &[],
    check,
};

const WHY: &str = "renderers interpolate normals as they are and bring the sum to unit length, so that a long normal outweighs its \
                   neighbors; some read them as written, others normalize first";

fn check(subject: &Subject<'_>, report: &mut Report) {
    for (span, message) in &subject.around.lengthened {
        report.add(
            &(*span).into(),
            message.clone(),
            "read here",
            WHY,
            "write the file with unit normals, so that every program reads the same surface".to_owned(),
        );
    }
    let scene = subject.scene;
    for (handle, mesh) in scene.meshes.iter() {
        let long = mesh.normals.iter().flat_map(|normals| normals.iter()).filter(|normal| !is_unit(**normal)).count();
        if long > 0 {
            report.add(
                scene.meshes.origin(handle),
                format!("{} normals of the mesh `{}` are not of unit length", long, mesh.name),
                "made here",
                WHY,
                "divide each by its length".to_owned(),
            );
        }
    }
}
