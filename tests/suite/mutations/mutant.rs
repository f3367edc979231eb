//! A scene that defects are injected into.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;

use ltsc_core::diag::{Finding, Origin, Severity, Sources};
use ltsc_core::eval::{self, Evaluated, Limits, Overrides};
use ltsc_core::files::{MemoryFiles, VPath};
use ltsc_core::ir::{
    Affine, Bsdf, Camera, Documentation, Handle, Material, Mesh, Scene, Shape, Vec3, cross, dot, length, normalized,
    sub,
};
use ltsc_core::lint::{Around, Levels, lint};
use ltsc_core::mesh::face_normal;
use ltsc_core::pipeline;
use ltsc_core::survey::Survey;

use super::super::{files_below, root};
use super::every_rule;

/// A code and a message.
pub type Found = (String, String);

/// A scene of the project and what is around it.
#[derive(Clone)]
pub struct Mutant {
    pub scene: Scene,
    /// The documentation of all scenes, this one's included.
    pub scenes: BTreeMap<String, Documentation>,
    /// Its text, from which edits of the text are evaluated anew.
    pub text: String,
}

/// A flat place of a surface: its middle lies in a corner where no scene has anything else.
pub struct Place {
    pub middle: Vec3,
    /// Unit vectors: in the plane, and across it to the front.
    pub along: Vec3,
    pub normal: Vec3,
}

impl Mutant {
    /// These scenes of the project.
    pub fn of(scenes: &[String]) -> Vec<Self> {
        let folder = root().join("scenes-src");
        let mut files = MemoryFiles::default();
        for path in files_below(&folder) {
            files.insert(path.clone(), fs::read(folder.join(&path)).expect("a file"));
        }
        let names = super::super::scenes();
        let path = |name: &String| VPath::resolve("", &format!("{name}.lts")).expect("a path");
        let headers = names.iter().filter_map(|name| eval::header(&files, &path(name), Limits::default()));
        let documentation: BTreeMap<String, Documentation> = headers.collect();
        let one = |name: &String| {
            let text = fs::read_to_string(folder.join(format!("{name}.lts"))).expect("a scene");
            let made = eval::evaluate(&files, &mut Sources::default(), &path(name), &Overrides::default());
            let scene = made.scene.unwrap_or_else(|| panic!("{name}: {:#?}", made.findings));
            Self { scene, scenes: documentation.clone(), text }
        };
        scenes.iter().map(one).collect()
    }

    /// What lint finds.
    pub fn findings(&self, levels: &Levels) -> Vec<Found> {
        let around = Around { scenes: self.scenes.clone().into(), ..Around::default() };
        pairs(&lint(&self.scene, &around, levels, &[]))
    }

    /// What validation refuses.
    pub fn refused(&self) -> Vec<Found> {
        let invalid = pipeline::prepare(self.scene.clone()).err().unwrap_or_default();
        pairs(&invalid.into_iter().filter(|finding| finding.severity == Severity::Error).collect::<Vec<_>>())
    }

    /// Adds the meshes, materials, shapes and lights of a piece of text, which uses no names of the scene; what is wrong with the
    /// text comes back.
    pub fn graft(&mut self, text: &str) -> Result<(), Vec<Found>> {
        let piece = evaluated(text)?;
        let scene = &mut self.scene;
        let materials: Vec<Handle<Material>> =
            piece.materials.values().map(|material| scene.materials.push(material.clone(), here())).collect();
        for shape in piece.shapes.values() {
            let mesh = scene.meshes.push(in_place(&piece.meshes[shape.mesh], &shape.transform), here());
            let material = materials[shape.material.index()];
            let transform = Affine::IDENTITY;
            let _handle = scene.shapes.push(Shape { mesh, material, transform, ..shape.clone() }, here());
        }
        for light in piece.lights.values() {
            let _handle = scene.lights.push(light.clone(), here());
        }
        Ok(())
    }

    /// The only camera.
    pub fn camera(&mut self) -> &mut Camera {
        self.scene.cameras.iter_mut().next().expect("a camera").1
    }

    /// The documentation, in the scene and in what other scenes see of it.
    pub fn document(&mut self, change: impl Fn(&mut Documentation)) {
        change(&mut self.scene.documentation);
        self.scenes.insert(self.scene.name.clone(), self.scene.documentation.clone());
    }

    /// A scene of the project that neither names this one as similar nor is named by it.
    pub fn stranger(&self) -> Option<String> {
        let own = &self.scene;
        let names = |from: &Documentation, to: &str| from.similar.iter().any(|similar| similar.scene == to);
        let strange = |(name, other): &(&String, &Documentation)| {
            **name != own.name && !names(other, &own.name) && !names(&own.documentation, name)
        };
        self.scenes.iter().find(strange).map(|(name, _)| name.clone())
    }

    /// The mesh of an opaque surface that emits nothing.
    pub fn opaque(&mut self) -> &mut Mesh {
        let found = self.scene.surfaces().find(|(_, shape)| is_opaque(&self.scene, shape));
        let mesh = found.expect("an opaque surface").1.mesh;
        &mut self.scene.meshes[mesh]
    }

    /// The mesh of an emitter.
    pub fn lamp(&mut self) -> &mut Mesh {
        let found = self.scene.surfaces().find(|(_, shape)| shape.emission.is_some());
        let mesh = found.expect("an emitter").1.mesh;
        &mut self.scene.meshes[mesh]
    }

    /// A place 4 units beside the scene, along x, with nothing around it.
    pub fn beside(&self) -> Vec3 {
        let bounds = Survey::of(&self.scene).bounds.expect("a box");
        let [_, y, z] = bounds.center();
        [bounds.high[0] + 4.0, y, z]
    }

    /// A place on a flat opaque surface that emits nothing, 4 units from its corner along both sides.
    pub fn wall(&self) -> Place {
        let survey = Survey::of(&self.scene);
        for placed in survey.placed.iter().filter(|placed| is_opaque(&self.scene, placed.shape)) {
            let triangles: Vec<[Vec3; 3]> = survey.triangles(placed).collect();
            let [a, b, c] = triangles[0];
            let Some(normal) = face_normal([a, b, c]) else { continue };
            let flat = |p: &Vec3| dot(normal, sub(*p, a)).abs() < 1e-6;
            if triangles.len() > 2 || !triangles.iter().flatten().all(flat) {
                continue;
            }
            // The corner with the right angle, and the sides that begin there.
            let sides = [[a, b, c], [b, c, a], [c, a, b]].map(|[p, q, r]| (p, sub(q, p), sub(r, p)));
            let square =
                |(_, one, other): &&(Vec3, Vec3, Vec3)| dot(*one, *other).abs() < 1e-6 * length(*one) * length(*other);
            let Some((corner, one, other)) = sides.iter().find(square) else { continue };
            let (Some(along), Some(up)) = (normalized(*one), normalized(*other)) else { continue };
            let middle = [0, 1, 2].map(|axis| corner[axis] + 4.0 * (along[axis] + up[axis]));
            return Place { middle, along, normal };
        }
        panic!("{} has no flat wall", self.scene.name);
    }

    /// Evaluates the text of the scene with a change; what is found comes back, lint included.
    pub fn edited(&self, change: impl Fn(&str) -> String) -> Vec<Found> {
        let folder = root().join("scenes-src");
        let mut files = MemoryFiles::default();
        for path in files_below(&folder) {
            files.insert(path.clone(), fs::read(folder.join(&path)).expect("a file"));
        }
        let name = format!("{}.lts", self.scene.name);
        let text = change(&self.text);
        assert_ne!(text, self.text, "the edit changes nothing");
        files.insert(name.clone(), text);
        let options = pipeline::Options {
            levels: every_rule(),
            no_allow: true,
            scenes: self.scenes.clone().into(),
            ..Default::default()
        };
        let path = VPath::resolve("", &name).expect("a path");
        pairs(&pipeline::check(&files, &mut Sources::default(), &path, &options).findings)
    }
}

impl Place {
    /// The stage that puts a mesh that was made around the origin at the place, its z to the front, `up` above the surface.
    pub fn frame(&self, up: f64) -> String {
        let [middle, along, normal] = [self.middle, self.along, self.normal];
        let origin = [0, 1, 2].map(|axis| middle[axis] + up * normal[axis]);
        format!("|> frame(x: {}, z: {}, origin: {})", words(along), words(normal), words(origin))
    }
}

/// A vector as the language writes it.
pub fn words([x, y, z]: Vec3) -> String {
    format!("({x}, {y}, {z})")
}

/// Whether a surface emits nothing and is no dielectric.
fn is_opaque(scene: &Scene, shape: &Shape) -> bool {
    shape.emission.is_none() && !matches!(scene.materials[shape.material].bsdf, Bsdf::Dielectric { .. })
}

/// A mesh with the transform in its vertices.
fn in_place(mesh: &Mesh, map: &Affine) -> Mesh {
    let mut moved = mesh.clone();
    if *map == Affine::IDENTITY {
        return moved;
    }
    for position in Arc::make_mut(&mut moved.positions) {
        *position = map.point(position.map(f64::from)).map(|x| x as f32);
    }
    let cofactors = map.cofactors();
    for normal in moved.normals.iter_mut().flat_map(Arc::make_mut) {
        let turned = cofactors.map(|row| dot(row, normal.map(f64::from)));
        *normal = normalized(turned).expect("a normal").map(|x| x as f32);
    }
    moved
}

/// The scene of a piece of text, or what is wrong with it.
fn evaluated(text: &str) -> Result<Scene, Vec<Found>> {
    let mut files = MemoryFiles::default();
    let header = "lts 1\nscene piece {}\ncamera = perspective(eye: (0, -9, 2), target: (0, 0, 2), fov_x: 45deg)\n\
                  film = image(8, 8)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n";
    files.insert("piece.lts", format!("{header}{text}\n"));
    let path = VPath::resolve("", "piece.lts").expect("a path");
    let Evaluated { scene, findings, .. } =
        eval::evaluate(&files, &mut Sources::default(), &path, &Overrides::default());
    scene.ok_or_else(|| pairs(&findings))
}

/// The unit axes of a camera: to the right and along its axis.
pub fn view(camera: &Camera) -> (Vec3, Vec3) {
    let forward = normalized(sub(camera.target, camera.eye)).expect("a direction");
    (normalized(cross(forward, camera.up)).expect("a direction"), forward)
}

fn pairs(findings: &[Finding]) -> Vec<Found> {
    findings.iter().map(|finding| (finding.id.to_owned(), finding.message.clone())).collect()
}

/// The place of what is added.
fn here() -> Origin {
    Origin::File { path: "mutation".to_owned(), place: String::new() }
}
