//! What a scene has, counted and measured.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use crate::ir::{Arena, Bsdf, Color, ColorOrTexture, Instance, LightExtent, LightKind, Scene, cross, length, sub};
use crate::survey::{Bounds, Survey};

use super::short;

/// Emitters of one name, loops aside: `lamp[0]` and `lamp[1]` are two of `lamp`.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// The name without what loops added.
    pub name: String,
    /// How many there are.
    pub count: u64,
    /// What it is: `surface`, or the word of a light.
    pub kind: &'static str,
    /// The smallest and largest strength by channel: radiance in W/(m2 sr), intensity in W/sr, irradiance in W/m2.
    pub strength: ([f64; 3], [f64; 3]),
    /// Area of all of them in square units, 0 for lights without a surface.
    pub area: f64,
    /// Power of all of them in W by channel, one unit of length being a meter; none where a light has no end.
    pub power: Option<[f64; 3]>,
}

/// The numbers of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers {
    /// Triangles in memory: each mesh once.
    pub triangles: u64,
    /// Triangles that rays meet: meshes as often as they are placed.
    pub placed_triangles: u64,
    /// Meshes.
    pub meshes: u64,
    /// Shapes, those of groups once.
    pub shapes: u64,
    /// Groups.
    pub groups: u64,
    /// Places of groups, those within groups as often as these are placed.
    pub instances: u64,
    /// Uses of shapes, groups multiplied out.
    pub placed: u64,
    /// Lights of every kind, most powerful first within the order of the text.
    pub emitters: Vec<Emitter>,
    /// Each material with what it is and the number of shapes made of it (those of groups once).
    pub materials: Vec<(String, String, u64)>,
    /// A box around everything.
    pub bounds: Option<Bounds>,
    /// What its lights are, for the full form of light paths.
    pub extents: Vec<LightExtent>,
    /// Whether the scene is larger than what is looked at.
    pub cut: bool,
}

impl Numbers {
    /// Counts and measures.
    pub fn of(scene: &Scene) -> Self {
        let survey = Survey::of(scene);
        let count = |len: usize| len as u64;
        let placed_triangles =
            survey.placed.iter().map(|placed| count(scene.meshes[placed.shape.mesh].triangles.len())).sum();
        let emitters = emitters(scene, &survey);
        let mut extents = Vec::new();
        if emitters.iter().any(|emitter| matches!(emitter.kind, "surface" | "environment")) {
            extents.push(LightExtent::Area);
        }
        if emitters.iter().any(|emitter| !matches!(emitter.kind, "surface" | "environment")) {
            extents.push(LightExtent::Point);
        }
        Self {
            triangles: scene.meshes.values().map(|mesh| count(mesh.triangles.len())).sum(),
            placed_triangles,
            meshes: count(scene.meshes.len()),
            shapes: count(scene.surfaces().count()),
            groups: count(scene.groups.len()),
            instances: instances(scene),
            placed: count(survey.placed.len()),
            emitters,
            materials: materials(scene),
            bounds: survey.bounds,
            extents,
            cut: survey.cut,
        }
    }

    /// How many lights there are.
    pub fn lights(&self) -> u64 {
        self.emitters.iter().map(|emitter| emitter.count).sum()
    }
}

/// How many groups a scene places, those within groups as often as these are placed.
pub fn instances(scene: &Scene) -> u64 {
    // Groups stand behind those that they hold, so that one pass counts what each places.
    let mut within: Vec<u64> = Vec::with_capacity(scene.groups.len());
    let places = |within: &[u64], instances: &Arena<Instance>| -> u64 {
        let of = |instance: &Instance| {
            let inner = within.get(instance.group.index()).copied().unwrap_or(0);
            (instance.places.maps().len() as u64).saturating_mul(inner.saturating_add(1))
        };
        instances.values().map(of).fold(0, u64::saturating_add)
    };
    for group in scene.groups.values() {
        let count = places(&within, &group.instances);
        within.push(count);
    }
    places(&within, &scene.instances)
}

/// A name without the iterations of loops and the instances around it.
fn base(name: &str) -> &str {
    let last = name.rsplit('/').next().unwrap_or(name);
    last.split('[').next().unwrap_or(last)
}

fn emitters(scene: &Scene, survey: &Survey<'_>) -> Vec<Emitter> {
    let mut order: Vec<Emitter> = Vec::new();
    let mut known: BTreeMap<(String, &'static str), usize> = BTreeMap::new();
    let mut add = |name: &str, kind: &'static str, strength: [f64; 3], area: f64, power: Option<[f64; 3]>| {
        let name = base(name).to_owned();
        let at = *known.entry((name.clone(), kind)).or_insert_with(|| {
            let none =
                Emitter { name, count: 0, kind, strength: (strength, strength), area: 0.0, power: Some([0.0; 3]) };
            order.push(none);
            order.len() - 1
        });
        let emitter = &mut order[at];
        emitter.count += 1;
        emitter.area += area;
        let (low, high) = emitter.strength;
        let pick = |choose: fn(f64, f64) -> f64, known: [f64; 3]| {
            [0, 1, 2].map(|channel: usize| choose(known[channel], strength[channel]))
        };
        emitter.strength = (pick(f64::min, low), pick(f64::max, high));
        emitter.power = match (emitter.power, power) {
            (Some(all), Some(one)) => Some([0, 1, 2].map(|channel: usize| all[channel] + one[channel])),
            _ => None,
        };
    };
    for placed in &survey.placed {
        let Some(emission) = &placed.shape.emission else { continue };
        let area: f64 = survey.triangles(placed).map(|[a, b, c]| 0.5 * length(cross(sub(b, a), sub(c, a)))).sum();
        let radiance = emission.radiance.rgb();
        // A diffuse surface of radiance L sends pi L from each unit of its area.
        add(&placed.shape.name, "surface", radiance, area, Some(radiance.map(|part| PI * area * part)));
    }
    for light in scene.lights.values() {
        let strength = light.kind.color().rgb();
        let power = match &light.kind {
            LightKind::Point { position: _, intensity: _ } => Some(strength.map(|part| 4.0 * PI * part)),
            LightKind::Spot { position: _, target: _, intensity: _, angle, inner } => {
                Some(strength.map(|part| part * cone(*angle, *inner)))
            }
            LightKind::Environment { radiance: _, tint: _, turn: _ }
            | LightKind::Directional { direction: _, irradiance: _ } => None,
        };
        add(&light.name, light.kind.word(), strength, 0.0, power);
    }
    order
}

/// The solid angle of a spot's cone, in which the intensity falls linearly with the angle from `inner` to `angle` (degrees):
/// 2 pi times the integral of sin t from 0 to a, and of (b - t) / (b - a) sin t from there to b.
fn cone(angle: f64, inner: f64) -> f64 {
    let (b, a) = (angle.to_radians(), inner.to_radians());
    if b - a < 1e-9 {
        return 2.0 * PI * (1.0 - libm::cos(b));
    }
    2.0 * PI * (1.0 - (libm::sin(b) - libm::sin(a)) / (b - a))
}

fn materials(scene: &Scene) -> Vec<(String, String, u64)> {
    let mut uses = vec![0_u64; scene.materials.len()];
    let mut black: BTreeSet<usize> = BTreeSet::new();
    for (_, shape) in scene.surfaces() {
        uses[shape.material.index()] += 1;
        if shape.emission.is_some() {
            black.insert(shape.material.index());
        }
    }
    let rows = scene.materials.values().zip(&uses).enumerate();
    // The black surface that every emitter has unless another is asked for is no material of the author's.
    let hidden = |at: usize, bsdf: &Bsdf| black.contains(&at) && bsdf.is_black();
    rows.filter(|(at, (material, _))| !hidden(*at, &material.bsdf))
        .map(|(_, (material, uses))| (material.name.clone(), words(scene, &material.bsdf), *uses))
        .collect()
}

/// A material as a call.
fn words(scene: &Scene, bsdf: &Bsdf) -> String {
    match bsdf {
        Bsdf::Diffuse { reflectance } => format!("diffuse({})", paint(scene, reflectance)),
        Bsdf::Plastic { reflectance, ior, alpha } => {
            format!("plastic({}, ior: {ior}, alpha: {alpha})", paint(scene, reflectance))
        }
        Bsdf::Principled { base, metallic, roughness, ior } => {
            let base = paint(scene, base);
            format!("principled({base}, metallic: {metallic}, roughness: {roughness}, ior: {ior})")
        }
        Bsdf::Conductor { eta, k, alpha } => {
            format!("conductor(eta: {}, k: {}, alpha: {alpha})", color(eta), color(k))
        }
        Bsdf::Dielectric { interior, exterior, alpha } => {
            let mut text = format!("dielectric(ior: {interior}");
            if *exterior != 1.0 {
                text.push_str(&format!(", outside: {exterior}"));
            }
            if *alpha != 0.0 {
                text.push_str(&format!(", alpha: {alpha}"));
            }
            text + ")"
        }
        Bsdf::Mirror { reflectance } => format!("mirror({})", color(reflectance)),
    }
}

fn paint(scene: &Scene, paint: &ColorOrTexture) -> String {
    match paint {
        ColorOrTexture::Color(paint) => color(paint),
        ColorOrTexture::Texture(texture) => scene.textures[*texture].name.clone(),
    }
}

fn color(color: &Color) -> String {
    channels(color.rgb())
}

/// A grey as one number, else three.
pub(super) fn channels([r, g, b]: [f64; 3]) -> String {
    if r == g && g == b { short(r, 3) } else { format!("rgb({}, {}, {})", short(r, 3), short(g, 3), short(b, 3)) }
}
