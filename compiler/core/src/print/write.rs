//! The statements of a text, section by section.

use std::collections::BTreeMap;

use super::light::light;
use super::names::{Names, written};
use super::notes::Notes;
use super::number::string;
use super::place::stages;
use super::plan::{Plan, Said, is_usual, lost_instance};
use super::settings::{cameras, header, settings};
use super::surface::{Place, bitmap, color, material};
use super::{Content, Options};
use crate::diag::{Finding, Origin};
use crate::formats::shared::names::{file_stem, file_stems};
use crate::ir::{Affine, Arena, Emission, Handle, Instance, Material, Meaning, Places, Scene, Shape, Texture};
use crate::syntax::VERSION;

/// What became of a scene: its name, its text, its files and findings.
pub(super) type Written<'s> = (String, String, Vec<(String, Content<'s>)>, Vec<Finding>);

/// The text of a scene, before it is formatted.
pub(super) fn scene<'s>(scene: &'s Scene, options: &Options) -> Written<'s> {
    let mut notes = Notes::default();
    let wish = options.name.as_deref().unwrap_or(&scene.name);
    let name = file_stem(wish);
    notes.named(&scene.origin, "scene", wish, &name);
    let plan = Plan::new(scene, options, &mut notes);
    let mut writer = Writer { scene, plan, notes, textures: Vec::new(), places: BTreeMap::new() };
    let settings = {
        let notes = &mut writer.notes;
        let Scene { cameras: views, film, integrator, sampler, .. } = scene;
        let views: Vec<_> = views.entries().collect();
        cameras(notes, views.into_iter()) + &settings(notes, film, integrator, sampler)
    };
    let head = header(&mut writer.notes, &name, &scene.documentation, &scene.origin);
    let origin = options.origin.as_deref().map(comment).unwrap_or_default();
    writer.scatter(options);
    let sections = [
        format!("lts {VERSION}\n"),
        origin,
        head,
        settings,
        writer.textures() + &writer.materials(),
        writer.meshes(),
        writer.lights(),
        writer.groups(),
        writer.shapes(&scene.shapes, scene.groups.len(), ""),
        writer.instances(&scene.instances, scene.groups.len(), ""),
    ];
    let kept: Vec<String> = sections.into_iter().filter(|section| !section.is_empty()).collect();
    (name, kept.join("\n"), writer.plan.files, writer.notes.findings)
}

/// Lines of a comment.
fn comment(text: &str) -> String {
    let plain = |line: &str| line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>();
    text.lines().map(|line| format!("// {}", plain(line)).trim_end().to_owned() + "\n").collect()
}

struct Writer<'s> {
    scene: &'s Scene,
    plan: Plan<'s>,
    notes: Notes,
    /// How each image is written where it is used.
    textures: Vec<String>,
    /// The paths of arrays of places, by where these lie in memory.
    places: BTreeMap<(usize, usize), String>,
}

impl<'s> Writer<'s> {
    /// Gives each array of places a file.
    fn scatter(&mut self, options: &Options) {
        let groups = self.scene.groups.values().enumerate().filter(|(at, _)| self.plan.groups[*at].is_some());
        let inner = groups.map(|(at, group)| (at, &group.instances));
        let mut found: Vec<(&'s str, &'s [Affine])> = Vec::new();
        for (below, instances) in inner.chain([(self.scene.groups.len(), &self.scene.instances)]) {
            for instance in instances.values().filter(|instance| lost_instance(instance, below).is_none()) {
                if let Places::Many(maps) = &instance.places {
                    self.places.entry(key(maps)).or_insert_with(|| {
                        found.push((&instance.name, maps));
                        String::new()
                    });
                }
            }
        }
        let stems = file_stems(found.iter().map(|(name, _)| *name));
        for ((_, maps), stem) in found.into_iter().zip(stems) {
            let path = format!("{}places/{stem}.npy", options.folder);
            self.places.insert(key(maps), path.clone());
            self.plan.files.push((path, Content::Places(maps)));
        }
    }

    fn textures(&mut self) -> String {
        let mut text = String::new();
        for ((origin, texture), (said, path)) in self.scene.textures.entries().zip(&self.plan.textures) {
            let call = match said {
                Said::Unused => String::new(),
                Said::InPlace => bitmap(&mut self.notes, texture, path, origin),
                Said::Named(name) => {
                    let name = written(name);
                    let call = bitmap(&mut self.notes, texture, path, origin);
                    text.push_str(&format!("texture {name} = {call}\n"));
                    name.into_owned()
                }
            };
            self.textures.push(call);
        }
        text
    }

    fn materials(&mut self) -> String {
        let mut text = String::new();
        for (at, (origin, made)) in self.scene.materials.entries().enumerate() {
            if let Said::Named(name) = self.plan.materials[at].clone() {
                let call = self.material(made, origin);
                text.push_str(&format!("material {} = {call}\n", written(&name)));
            }
        }
        text
    }

    fn material(&mut self, made: &Material, origin: &Origin) -> String {
        let textures = &self.textures;
        let image = |texture: Handle<Texture>| textures[texture.index()].clone();
        material(&mut self.notes, made, origin, &image)
    }

    fn meshes(&self) -> String {
        let declared = self.plan.meshes.iter().filter_map(|(said, call)| match said {
            Said::Named(name) => Some(format!("mesh {} = {call}\n", written(name))),
            Said::Unused | Said::InPlace => None,
        });
        declared.collect()
    }

    fn lights(&mut self) -> String {
        let mut text = String::new();
        let mut environment = false;
        let names = std::mem::take(&mut self.plan.lights);
        let textures = &self.textures;
        let image = |texture: Handle<Texture>| textures[texture.index()].clone();
        for ((origin, source), name) in self.scene.lights.entries().zip(&names) {
            let everywhere = source.kind.word() == "environment";
            if everywhere && environment {
                self.notes.dropped(origin, "a second environment is left out: a scene has one");
                continue;
            }
            if let Some(call) = light(&mut self.notes, self.scene, &source.name, &source.kind, origin, &image) {
                environment |= everywhere;
                text.push_str(&format!("emitter {} = {call}\n", written(name)));
            }
        }
        text
    }

    fn groups(&mut self) -> String {
        let scene = self.scene;
        let mut made = Vec::new();
        for (at, group) in scene.groups.values().enumerate() {
            let Some(name) = self.plan.groups[at].clone() else { continue };
            let shapes = self.shapes(&group.shapes, at, "    ");
            let instances = self.instances(&group.instances, at, "    ");
            made.push(format!("group {} {{\n{shapes}{instances}}}\n", written(&name)));
        }
        made.join("\n")
    }

    /// The shapes of `holder`, the number of groups standing for the scene.
    fn shapes(&mut self, shapes: &'s Arena<Shape>, holder: usize, indent: &str) -> String {
        let mut text = String::new();
        for (at, (origin, shape)) in shapes.entries().enumerate() {
            let Shape { name, mesh, transform, material: _, emission } = shape;
            if let Some(why) = self.plan.lost_shape(shape) {
                self.notes.dropped(origin, format!("the shape `{}` is left out: {why}", name.escape_debug()));
                continue;
            }
            let surface = match emission {
                None => self.surface(shape),
                Some(emission) => self.radiance(shape, emission, origin),
            };
            let name = written(self.plan.name_of_item((holder, at), shape));
            let word = if emission.is_some() { "emitter" } else { "shape" };
            let (said, call) = &self.plan.meshes[mesh.index()];
            let mesh = match said {
                Said::Named(name) => written(name),
                Said::InPlace | Said::Unused => call.as_str().into(),
            };
            text.push_str(&format!("{indent}{word} {name} = {mesh}{} with {surface}\n", stages(transform)));
        }
        text
    }

    /// The material of a shape, by name or in place.
    fn surface(&mut self, shape: &Shape) -> String {
        let at = self.plan.material(shape.material);
        match &self.plan.materials[at] {
            Said::Named(name) => written(name).into_owned(),
            Said::InPlace | Said::Unused => {
                let (origin, made) =
                    (self.scene.materials.origin(shape.material), &self.scene.materials[shape.material]);
                self.material(made, origin)
            }
        }
    }

    fn radiance(&mut self, shape: &Shape, emission: &Emission, origin: &Origin) -> String {
        let Emission { radiance } = emission;
        let what = format!("the radiance of `{}`", shape.name.escape_debug());
        let place = Place { at: origin, what: &what, meaning: Meaning::Light, least: 0.0 };
        let value = color(&mut self.notes, radiance, &place);
        if is_usual(&self.scene.materials[shape.material]) {
            return format!("radiance({value})");
        }
        format!("radiance({value}, over: {})", self.surface(shape))
    }

    /// The instances of what `below` groups stand before.
    fn instances(&mut self, instances: &'s Arena<Instance>, below: usize, indent: &str) -> String {
        let mut text = String::new();
        let mut names = Names::default();
        for (origin, instance) in instances.entries() {
            if let Some(why) = lost_instance(instance, below) {
                let name = instance.name.escape_debug();
                self.notes.dropped(origin, format!("the instance `{name}` is left out: {why}"));
                continue;
            }
            let name = names.take(&instance.name);
            self.notes.named(origin, "instance", &instance.name, &name);
            let Some(Some(group)) = self.plan.groups.get(instance.group.index()) else { continue };
            let places = match &instance.places {
                Places::One(map) => stages(map),
                Places::Many(maps) => format!(" |> scatter({})", string(&self.places[&key(maps)])),
            };
            text.push_str(&format!("{indent}instance {} = {}{places}\n", written(&name), written(group)));
        }
        text
    }
}

/// Where places lie in memory; equal for those that instances share.
fn key(maps: &[Affine]) -> (usize, usize) {
    (maps.as_ptr() as usize, maps.len())
}
