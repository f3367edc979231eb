//! Rule `open-dielectric`: glass and water have an inside.
#![doc = include_str!("open_dielectric.md")]

use super::{Level, Report, Rule, Subject};
use crate::diag::Origin;
use crate::ir::{Arena, Bsdf, Shape};
use crate::mesh::{View, rim, transform_positions};

pub(super) const RULE: Rule = Rule {
    id: "open-dielectric",
    level: Level::Warn,
    summary: "A dielectric surface is not closed, and it is open what lies inside.",
    doc: include_str!("open_dielectric.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    holder(subject, &scene.shapes, report);
    scene.groups.values().for_each(|group| holder(subject, &group.shapes, report));
}

/// The open dielectrics among shapes that lie in the same coordinates.
fn holder<'s>(subject: &Subject<'s>, shapes: &'s Arena<Shape>, report: &mut Report) {
    let mut kinds: Vec<(&Bsdf, Vec<(&Origin, &Shape)>)> = Vec::new();
    for (origin, shape) in shapes.entries().filter(|(_, shape)| shape.material.index() < subject.scene.materials.len())
    {
        let bsdf = &subject.scene.materials[shape.material].bsdf;
        let Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } = bsdf else { continue };
        if subject.is_closed(shape.mesh) {
            continue;
        }
        match kinds.iter_mut().find(|(known, _)| *known == bsdf) {
            Some((_, open)) => open.push((origin, shape)),
            None => kinds.push((bsdf, vec![(origin, shape)])),
        }
    }
    for (origin, shape) in kinds.into_iter().flat_map(|(_, open)| still_open(subject, open)) {
        report.add(
            origin,
            format!("the dielectric `{}` is not closed", shape.name),
            "this surface",
            "Mitsuba, PBRT and LuxCore decide at each hit which side is inside; Cycles does not scale radiance by the index, which \
             cancels for closed bodies only, glTF's volumes are bodies, and light that goes round the edge is in no medium at all",
            "close it: a pane is a thin `box`, a pool has walls and a floor of its own".to_owned(),
        );
    }
}

/// The shapes whose edges are not closed by the others either.
fn still_open<'s>(subject: &Subject<'s>, open: Vec<(&'s Origin, &'s Shape)>) -> Vec<(&'s Origin, &'s Shape)> {
    let (mut positions, mut triangles, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for (_, shape) in &open {
        let mesh = &subject.scene.meshes[shape.mesh];
        let (Ok(moved), Ok(start)) =
            (transform_positions(&mesh.positions, &shape.transform), u32::try_from(positions.len()))
        else {
            return open;
        };
        positions.extend(moved);
        triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|index| index.saturating_add(start))));
        ends.push(triangles.len());
    }
    let rim = rim(View { positions: &positions, normals: None, triangles: &triangles });
    let mut start = 0;
    let mut on_rim = ends.into_iter().map(|end| {
        let from = std::mem::replace(&mut start, end);
        rim.get(rim.partition_point(|at| *at < from)).is_some_and(|at| *at < end)
    });
    open.into_iter().filter(|_| on_rim.next() == Some(true)).collect()
}
