//! Rule `unused-name`: what a scene declares, it uses.
#![doc = include_str!("unused_name.md")]

use super::{Level, Report, Rule, Subject, UnusedName};
use crate::diag::Origin;
use crate::ir::{Arena, Handle, Scene};

pub(super) const RULE: Rule = Rule {
    id: "unused-name",
    level: Level::Warn,
    summary: "A value, material, mesh or group is declared and never used.",
    doc: include_str!("unused_name.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    for UnusedName { kind, name, span } in &subject.around.unused {
        let help = if *kind == "use" { format!("remove `{name}` from the list") } else { HELP.to_owned() };
        add(report, &(*span).into(), &format!("`{name}`"), help);
    }
    // A text gives the Scene what is used only; files of other formats give it all that they declare.
    for (what, name, origin) in unused(subject.scene) {
        add(report, origin, &format!("the {what} `{name}`"), HELP.to_owned());
    }
}

const HELP: &str = "use it, or remove it";

fn add(report: &mut Report, origin: &Origin, what: &str, help: String) {
    report.add(
        origin,
        format!("{what} is declared and never used"),
        "nothing names it",
        "a reader looks for its purpose; a misspelt name elsewhere may have been meant for it",
        help,
    );
}

/// Meshes and materials that no shape has, and groups that nothing places.
fn unused(scene: &Scene) -> Vec<(&'static str, &str, &Origin)> {
    let mut found = Vec::new();
    let mut meshes = Used::of(&scene.meshes);
    let mut materials = Used::of(&scene.materials);
    let mut groups = Used::of(&scene.groups);
    for (_, shape) in scene.surfaces() {
        meshes.mark(shape.mesh);
        materials.mark(shape.material);
    }
    let inner = scene.groups.values().flat_map(|group| group.instances.values());
    for instance in scene.instances.values().chain(inner) {
        groups.mark(instance.group);
    }
    found.extend(meshes.rest().map(|(mesh, origin)| ("mesh", mesh.name.as_str(), origin)));
    found.extend(materials.rest().map(|(material, origin)| ("material", material.name.as_str(), origin)));
    found.extend(groups.rest().map(|(group, origin)| ("group", group.name.as_str(), origin)));
    found
}

/// Which items of an arena are used.
struct Used<'a, T> {
    arena: &'a Arena<T>,
    seen: Vec<bool>,
}

impl<'a, T> Used<'a, T> {
    fn of(arena: &'a Arena<T>) -> Self {
        Self { arena, seen: vec![false; arena.len()] }
    }

    fn mark(&mut self, handle: Handle<T>) {
        if let Some(seen) = self.seen.get_mut(handle.index()) {
            *seen = true;
        }
    }

    fn rest(self) -> impl Iterator<Item = (&'a T, &'a Origin)> {
        self.arena.entries().zip(self.seen).filter(|(_, seen)| !seen).map(|((origin, item), _)| (item, origin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::shared::sample;
    use crate::ir::{Bsdf, Color, Group};

    #[test]
    fn what_a_file_of_another_format_declares_in_vain_is_found() {
        let mut scene = sample::room();
        assert_eq!(unused(&scene), []);
        let origin = Origin::File { path: "room.xml".to_owned(), place: "line 7".to_owned() };
        let bsdf = Bsdf::Diffuse { reflectance: Color::Grey(0.5).into() };
        scene.materials.push(crate::ir::Material::new("chrome", bsdf), origin.clone());
        let mesh = scene.meshes.values().next().expect("a mesh").clone();
        scene.meshes.push(crate::ir::Mesh { name: "bunny".to_owned(), ..mesh }, origin.clone());
        scene.groups.push(Group { name: "herd".to_owned(), ..Group::default() }, origin.clone());
        let names: Vec<_> = unused(&scene).into_iter().map(|(what, name, _)| (what, name)).collect();
        assert_eq!(names, [("mesh", "bunny"), ("material", "chrome"), ("group", "herd")]);
    }
}
