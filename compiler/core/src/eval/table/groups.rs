//! Groups that are read from files: `group g = file("x.glb")`.

use std::collections::BTreeMap;
use std::rc::Rc;

use crate::diag::{Finding, Severity};
use crate::files::{Bytes, VPath};
use crate::image::{self, Loaded};
use crate::ir::{Affine, Bsdf, Color, Encoding, Handle, Places, Sides, Texture};
use crate::mesh::Geometry;
use crate::mesh::file::{Model, NAMELESS, Part, Picture, Surface, plain_color, read_parts};

use super::super::items::{GroupBody, Item};
use super::super::value::{EmissionValue, GroupValue, MaterialValue, MeshValue, Ty, Value};
use super::meshes::{beside, broken, read, remark};
use super::textures::lost;
use super::{Args, Constructor, Family, Parameter, Problem, Site};

pub(super) const ROWS: &[Constructor] = &[Constructor {
    family: Family::Group,
    name: "file",
    summary: "All parts of a mesh file with their materials: OBJ with its `.mtl`, glTF (turned to z up), STL, PLY.",
    params: &[Parameter { name: "path", ty: Ty::String, default: None, doc: "from the folder of this file, with `/`" }],
    positional: 1,
    example: "group bunny = file(\"meshes/bunny.ply\")\ninstance bunny = bunny |> scale(10)",
    build: file,
}];

/// The surface of parts for which the file gives none.
const GREY: f64 = 0.8;

fn file(args: &Args, site: &mut Site<'_>) -> Result<Value, Problem> {
    let (path, bytes) = read(args, site)?;
    let read = {
        let mut beside = beside(&path, site);
        read_parts(&path.extension(), &bytes, &mut beside)
    };
    let (model, notes) = read.map_err(|error| broken(&path, error))?;
    remark(&path, notes, site);
    let Model { meshes, surfaces, mut parts } = model;
    if let [only] = parts.as_mut_slice()
        && only.name == NAMELESS
    {
        path.stem().clone_into(&mut only.name);
    }
    let mut used = vec![false; surfaces.len()];
    let mut bare = 0;
    for part in &parts {
        match part.surface.and_then(|surface| used.get_mut(surface)) {
            Some(used) => *used = true,
            None => bare += 1,
        }
    }
    report(&path.to_string(), &surfaces, &used, bare, site);
    let span = site.span;
    let textures = textures(&path, &surfaces, &used, site);
    unpainted(&path, &surfaces, &textures, &parts, &meshes, site);
    let painted: Vec<Option<Rc<MaterialValue>>> = surfaces
        .iter()
        .zip(textures)
        .map(|(surface, texture)| {
            let (bsdf, _) = surface.scatter.bsdf(Some(texture?));
            let name = (!surface.name.is_empty()).then(|| surface.name.clone());
            bsdf.texture().map(|_| Rc::new(MaterialValue { name, bsdf, sides: Sides::Both, span }))
        })
        .collect();
    let material = |surface: &Surface| {
        let Surface { name, scatter, emission, picture: _, factor: _, lost: _ } = surface;
        let material = Rc::new(MaterialValue {
            name: (!name.is_empty()).then(|| name.clone()),
            bsdf: scatter.bsdf(None).0,
            sides: Sides::Both,
            span,
        });
        (material, emission.map(plain_color))
    };
    let materials: Vec<_> = surfaces.iter().map(material).collect();
    let grey = Bsdf::Diffuse { reflectance: Color::Grey(GREY).into() };
    let grey = Rc::new(MaterialValue { name: Some("grey".to_owned()), bsdf: grey, sides: Sides::Both, span });
    // A mesh without a name takes that of its first part.
    let mut first = vec![""; meshes.len()];
    for part in parts.iter().rev() {
        if let Some(first) = first.get_mut(part.mesh) {
            *first = &part.name;
        }
    }
    let named = |((name, geometry), first): ((String, Geometry), &str)| {
        Rc::new(geometry.into_mesh(if name.is_empty() { first.to_owned() } else { name }))
    };
    let meshes: Vec<Rc<_>> = meshes.into_iter().zip(first).map(named).collect();
    let mut items = Vec::new();
    for Part { name, mesh, surface, transform } in parts {
        let found = surface.and_then(|surface| materials.get(surface)).cloned();
        let (material, emission) = found.unwrap_or_else(|| (Rc::clone(&grey), None));
        let Some(mesh) = meshes.get(mesh) else { continue };
        // Without texture coordinates there is nothing to lay an image over.
        let paint = surface.and_then(|surface| painted.get(surface)).and_then(Option::as_ref);
        let material = paint.filter(|_| mesh.uvs.is_some()).map_or(material, Rc::clone);
        let mesh = Rc::clone(mesh);
        let mesh = MeshValue { mesh, transform, span };
        let (material, emission) = match emission {
            None => (Some(material), None),
            Some(radiance) => (None, Some(Rc::new(EmissionValue { radiance, over: Some(material) }))),
        };
        items.push(Item { name, span, mesh, material, emission });
    }
    let size = items.len() as u64;
    let name = path.stem().to_owned();
    let body = GroupBody { name, span, items, lights: Vec::new(), instances: Vec::new(), size, depth: 1, lit: false };
    Ok(Value::Group(GroupValue { body: Rc::new(body), places: Places::One(Affine::IDENTITY) }))
}

/// The images of the surfaces that are used. One that cannot be read is reported, and the surface keeps its plain color.
fn textures(path: &VPath, surfaces: &[Surface], used: &[bool], site: &mut Site<'_>) -> Vec<Option<Handle<Texture>>> {
    let mut known: BTreeMap<(String, [u64; 3]), Option<Handle<Texture>>> = BTreeMap::new();
    let mut all = Vec::new();
    for (surface, used) in surfaces.iter().zip(used) {
        let Some(picture) = surface.picture.as_ref().filter(|_| *used) else {
            all.push(None);
            continue;
        };
        let key = match picture {
            Picture::Beside(name) => name.clone(),
            Picture::Inside { image, ending: _, bytes: _ } => format!("\0{image}"),
        };
        let key = (key, surface.factor.map(f64::to_bits));
        if let Some(known) = known.get(&key) {
            all.push(*known);
            continue;
        }
        let made = match texture(path, surface, picture, site) {
            Ok(texture) => Some(site.host.texture(texture, site.span)),
            Err(message) => {
                let message = format!(
                    "`{path}`: not read of the material `{}`: its texture, {message}",
                    surface.name.escape_debug()
                );
                site.findings.push(Finding::new("loss-dropped", Severity::Warn, site.span, message));
                None
            }
        };
        known.insert(key, made);
        all.push(made);
    }
    all
}

/// Says which images are read and seen nowhere: those of surfaces that take none, and of parts without texture coordinates.
fn unpainted(
    path: &VPath,
    surfaces: &[Surface],
    textures: &[Option<Handle<Texture>>],
    parts: &[Part],
    meshes: &[(String, Geometry)],
    site: &mut Site<'_>,
) {
    let textured = |at: usize| textures.get(at).copied().flatten();
    let takes = |at: usize| surfaces[at].scatter.bsdf(textured(at)).0.texture().is_some();
    let names: Vec<&str> = (0..surfaces.len())
        .filter(|at| textured(*at).is_some() && !takes(*at))
        .map(|at| surfaces[at].name.as_str())
        .collect();
    let dropped =
        |message: String| Finding::new("loss-dropped", Severity::Warn, site.span, format!("`{path}`: {message}"));
    let mut findings = Vec::new();
    if !names.is_empty() {
        findings.push(dropped(format!(
            "not read of {}: a texture of the color, which glass and mirrors do not take",
            listed(&names)
        )));
    }
    let bare = |part: &&Part| {
        let painted = part.surface.is_some_and(|at| textured(at).is_some() && takes(at));
        painted && meshes.get(part.mesh).is_some_and(|(_, mesh)| mesh.uvs.is_none())
    };
    let count = parts.iter().filter(bare).count();
    if let Some(first) = parts.iter().find(bare) {
        let parts = if count == 1 { "1 part has".to_owned() } else { format!("{count} parts have") };
        let message =
            format!("{parts} a texture and no texture coordinates, the first is `{}`", first.name.escape_debug());
        findings.push(dropped(message));
    }
    site.findings.extend(findings);
}

fn texture(path: &VPath, surface: &Surface, picture: &Picture, site: &mut Site<'_>) -> Result<Texture, String> {
    let (name, ending, bytes) = match picture {
        Picture::Inside { image: _, ending, bytes } => {
            (surface.name.clone(), (*ending).to_owned(), Bytes::new(bytes.to_vec()))
        }
        Picture::Beside(written) => {
            let other =
                VPath::resolve(path.folder(), &written.replace('\\', "/")).map_err(|error| error.to_string())?;
            let bytes = site.host.read(&other).map_err(|error| format!("`{other}`: {error}"))?;
            (other.stem().to_owned(), other.extension(), bytes)
        }
    };
    let loaded = image::load(&ending, &bytes, site.limits.pixels);
    let Loaded { info, file, peak, remarks } = loaded.map_err(|error| format!("`{name}` {}", error.message))?;
    for remark in remarks {
        site.findings.push(lost(&name, remark, site.span));
    }
    let (encoding, peak) = match info.format.is_float() {
        true => (Encoding::Linear, peak),
        false => (Encoding::Srgb, image::decoded(peak)),
    };
    Ok(Texture { name, file, image: info, encoding, peak, factor: surface.factor })
}

/// Says what of the materials is not read, or not exactly; once for each reason.
fn report(path: &str, surfaces: &[Surface], used: &[bool], bare: usize, site: &mut Site<'_>) {
    let mut dropped: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut nearly: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut shining = Vec::new();
    for (surface, _) in surfaces.iter().zip(used).filter(|(_, used)| **used) {
        for what in &surface.lost {
            dropped.entry(what).or_default().push(&surface.name);
        }
        if let Some(what) = surface.scatter.bsdf(None).1 {
            nearly.entry(what).or_default().push(&surface.name);
        }
        if surface.emission.is_some() {
            shining.push(surface.name.as_str());
        }
    }
    if !shining.is_empty() {
        nearly.entry("emission is taken for radiance in W/(m2 sr)").or_default().extend(shining);
    }
    let span = site.span;
    for (what, names) in dropped {
        let message = format!("`{path}`: not read of {}: {what}", listed(&names));
        site.findings.push(Finding::new("loss-dropped", Severity::Warn, span, message));
    }
    for (what, names) in nearly {
        let message = format!("`{path}`: nearly read of {}: {what}", listed(&names));
        site.findings.push(Finding::new("loss-approximated", Severity::Info, span, message));
    }
    if bare > 0 {
        let parts = if bare == 1 { "part has no material and becomes" } else { "parts have no material and become" };
        let message = format!("`{path}`: {bare} {parts} `diffuse({GREY})`");
        site.findings.push(Finding::new("loss-approximated", Severity::Info, span, message));
    }
}

/// `2 materials (a, b)`, at most five by name.
fn listed(names: &[&str]) -> String {
    let shown: Vec<String> = names.iter().take(5).map(|name| format!("`{}`", name.escape_debug())).collect();
    let more = if names.len() > 5 { ", ..." } else { "" };
    let word = if names.len() == 1 { "material" } else { "materials" };
    format!("{} {word} ({}{more})", names.len(), shown.join(", "))
}
