//! Shapes: inline meshes, mesh files, bodies with a formula.

use std::f64::consts::{PI, TAU};
use std::rc::Rc;

use super::dialect::Dialect;
use super::material::grey;
use super::params::Params;
use super::round;
use super::texture::Map;
use super::world::World;
use crate::import::Builder;
use crate::import::build::{Shading, Wanted};
use crate::import::reader::Fate;
use crate::import::reader::shown;
use crate::ir::{Bsdf, Color, Handle, Mesh, Shape, Sides, cross, dot, normalized, sub};
use crate::mesh::{self, Geometry};

/// A mesh in object coordinates, its front turned as the file says.
struct Body {
    mesh: Handle<Mesh>,
    name: String,
    /// Whether it is a body with a formula.
    round: bool,
}

impl World<'_, '_> {
    /// `Shape`.
    pub fn shape(&mut self, params: &Params) {
        let body = self.body(params);
        self.mask(params);
        params.pass(&["discarddegenerateUVs", "faceIndices", "S", "edgelength"]);
        let Some(Body { mut mesh, name, round }) = body else { return };
        let at = params.span.into();
        let surface = self.state.material.as_ref().map(Rc::clone);
        let (bsdf, map, of) = match &surface {
            Some(surface) => (surface.bsdf.clone(), surface.map, surface.name.as_str()),
            None => (Some(grey()), Map::IDENTITY, "default"),
        };
        let radiance = self.radiance(mesh);
        let lit = radiance.is_some();
        // Light passes what has no material as if it was not there.
        let Some(bsdf) = bsdf.or_else(|| lit.then(|| Bsdf::Diffuse { reflectance: Color::BLACK.into() })) else {
            return;
        };
        if bsdf.texture().is_some() {
            mesh = self.mapped(mesh, map);
        }
        let transform = self.place();
        let clear = matches!(bsdf, Bsdf::Dielectric { interior: _, exterior: _, alpha: _ });
        if round && self.state.map.determinant() < 0.0 && self.dialect != Dialect::Old && (clear || lit) {
            let message = "a mirrored body with a formula has its front outside; pbrt-v3 and pbrt-v4 have it inside for \
                           rays that meet it, and outside for samples of its light";
            self.near(params.span, message);
        }
        let material = self.to.material(of, bsdf, Sides::Both, &at);
        let emission = radiance.and_then(Builder::emission);
        let shape = Shape { name, mesh, transform, material, emission };
        if let Some((_, shapes, _)) = &mut self.object {
            let shape = Shape { transform: self.state.map, emission: None, ..shape };
            if lit {
                let message = "a light in an object does not emit, as in PBRT";
                self.reader.lost(Fate::Baked, params.span, message);
            }
            self.to.shape_in(self.reader, shapes, shape, &at);
        } else {
            self.to.shape(self.reader, shape, &at);
        }
    }

    /// What a shape emits.
    fn radiance(&mut self, mesh: Handle<Mesh>) -> Option<Color> {
        let area = Rc::clone(self.state.area.as_ref()?);
        if area.both_sides {
            self.dropped(area.span, "a light that emits on both sides does so on the side of its normals");
        }
        let Some(power) = area.power else { return Some(area.radiance.clone()) };
        // Each triangle is a light of its own in v4, and has the power: what the mean one emits.
        let map = self.state.map;
        let mesh = self.to.mesh_of(mesh);
        let mut whole = 0.0;
        for triangle in mesh.triangles.iter() {
            let [a, b, c] = mesh.corners(*triangle).map(|corner| map.point(corner));
            let across = cross(sub(b, a), sub(c, a));
            whole += dot(across, across).sqrt() / 2.0;
        }
        let mean = whole / mesh.triangles.len().max(1) as f64;
        let sides = if area.both_sides { 2.0 } else { 1.0 };
        if mesh.triangles.len() > 1 {
            let message = "`power` of a light of triangles, which each of them has, is that of the mean triangle";
            self.near(area.span, message);
        }
        let share = if mean > 0.0 { power / (sides * PI * mean) } else { 0.0 };
        let radiance = super::color::times(&area.radiance, &Color::Grey(share));
        Some(self.cut(radiance, crate::import::color::Use::Light, area.span))
    }

    /// Holes in a surface.
    fn mask(&mut self, params: &Params) {
        for name in ["alpha", "shadowalpha"] {
            if !params.has(name) {
                continue;
            }
            let texture = params.find(name).filter(|found| found.kind == "texture");
            let whole = match texture.and_then(|found| found.strings().first().cloned()) {
                Some(texture) => matches!(
                    self.referred(&texture, false, params.span_of(name)),
                    Some(super::texture::Paint::Color(color)) if color.max() >= 1.0
                ),
                None => params.float(name, self.reader).is_none_or(|alpha| alpha >= 1.0),
            };
            if !whole {
                self.dropped(params.span_of(name), format!("`{name}` is left out: a surface has no holes"));
            }
        }
    }

    /// The mesh with the coordinates of its image.
    fn mapped(&mut self, mesh: Handle<Mesh>, map: Map) -> Handle<Mesh> {
        let bare = self.to.mesh_of(mesh).uvs.is_none();
        if !bare && map == Map::IDENTITY {
            return mesh;
        }
        let key = (mesh.index(), format!("{map:?}"));
        if let Some(known) = self.forms.get(&key) {
            return *known;
        }
        let made = self.to.changed(mesh, |geometry| {
            let mut geometry = if bare { cornered(geometry) } else { geometry };
            geometry.uvs.iter_mut().flatten().for_each(|uv| *uv = map.apply(*uv));
            geometry
        });
        self.forms.insert(key, made);
        made
    }

    fn body(&mut self, params: &Params) -> Option<Body> {
        let kind = params.kind.as_str();
        match kind {
            "plymesh" => return self.file(params),
            "trianglemesh" | "loopsubdiv" | "heightfield" | "bilinearmesh" => {
                let geometry = match kind {
                    "heightfield" => self.height_field(params),
                    "bilinearmesh" => self.patches(params),
                    _ => self.inline(params),
                }?;
                let geometry = if self.state.reverse { mesh::flip(geometry) } else { geometry };
                let mesh = self.to.mesh(self.reader, kind, geometry, &params.span.into())?;
                return Some(Body { mesh, name: kind.to_owned(), round: false });
            }
            _ => {}
        }
        let of = |name: &str, default: f64, world: &mut Self| params.float(name, world.reader).unwrap_or(default);
        let degrees = of("phimax", 360.0, self).clamp(0.0, 360.0);
        let turn = if degrees == 360.0 { TAU } else { degrees.to_radians() };
        let (what, key, make): (&str, String, Box<dyn Fn() -> Geometry>) = match kind {
            "sphere" => {
                let radius = of("radius", 1.0, self).abs();
                let (a, b) = (of("zmin", -radius, self), of("zmax", radius, self));
                let (low, high) = (a.min(b).clamp(-radius, radius), a.max(b).clamp(-radius, radius));
                let key = format!("{radius} {low} {high}");
                ("a sphere", key, Box::new(move || round::sphere(radius, low, high, turn)))
            }
            "cylinder" => {
                let radius = of("radius", 1.0, self).abs();
                let (a, b) = (of("zmin", -1.0, self), of("zmax", 1.0, self));
                let (low, high) = (a.min(b), a.max(b));
                let key = format!("{radius} {low} {high}");
                ("a cylinder", key, Box::new(move || round::line([radius, low], [radius, high], turn)))
            }
            "disk" => {
                let (radius, height) = (of("radius", 1.0, self).abs(), of("height", 0.0, self));
                let inner = of("innerradius", 0.0, self).clamp(0.0, radius);
                let key = format!("{radius} {height} {inner}");
                ("a disk", key, Box::new(move || round::line([radius, height], [inner, height], turn)))
            }
            "cone" => {
                let (radius, height) = (of("radius", 1.0, self).abs(), of("height", 1.0, self));
                let key = format!("{radius} {height}");
                ("a cone", key, Box::new(move || round::line([radius, 0.0], [0.0, height], turn)))
            }
            "paraboloid" => {
                let radius = of("radius", 1.0, self).abs();
                let (a, b) = (of("zmin", 0.0, self), of("zmax", 1.0, self));
                let (low, high) = (a.min(b), a.max(b));
                let key = format!("{radius} {low} {high}");
                ("a paraboloid", key, Box::new(move || round::paraboloid(radius, high, low, high, turn)))
            }
            other => {
                let message = format!("shapes of the kind `{}` are left out: they are not read", shown(other));
                self.dropped(params.span, message);
                params.pass_all();
                return None;
            }
        };
        // The middle of a segment lies inside by 1 - cos(pi / n) of the radius.
        let inside = 100.0 * (1.0 - libm::cos(PI / round::SEGMENTS as f64));
        let message = format!(
            "{what} becomes a mesh of {} segments, inside of it by up to {inside:.2} % of its radius",
            round::SEGMENTS
        );
        self.near(params.span, message);
        let key = format!("{kind} {key} {degrees} {}", self.state.reverse);
        let known = self.bodies.get(&key).copied();
        let mesh = match known {
            Some(mesh) => mesh,
            None => {
                let geometry = make();
                let whole = mesh::area((&geometry).into());
                if !whole.is_finite() || whole <= 0.0 {
                    self.dropped(params.span, format!("{what} without an area is left out"));
                    return None;
                }
                let geometry = if self.state.reverse { mesh::flip(geometry) } else { geometry };
                let mesh = self.to.mesh(self.reader, kind, geometry, &params.span.into())?;
                self.bodies.insert(key, mesh);
                mesh
            }
        };
        Some(Body { mesh, name: kind.to_owned(), round: true })
    }

    fn file(&mut self, params: &Params) -> Option<Body> {
        let Some(written) = params.string("filename", self.reader).map(str::to_owned) else {
            self.dropped(params.span, "a mesh without `filename` is left out");
            return None;
        };
        let span = params.span;
        params.drop(Fate::Dropped, &["displacement"], "the surface is smooth", self.reader);
        if written.to_ascii_lowercase().ends_with(".gz") {
            let message = format!("a mesh is left out: `{}` is compressed", shown(&written));
            self.reader.lost_with(Fate::Dropped, span, message, "decompress it, and name it without `.gz`");
            return None;
        }
        let path = self.path(&written, span)?;
        let name = path.stem().to_owned();
        let flipped = self.state.reverse;
        let wanted = Wanted { path, part: None, shading: Shading::Given, flipped, down: false };
        let (mesh, normals) = self.to.mesh_file(self.reader, &wanted, true, &span.into())?;
        let mesh = if normals { self.facing(mesh) } else { mesh };
        Some(Body { mesh, name, round: false })
    }

    /// A mesh whose triangles are turned to the side of its normals, which decide in PBRT.
    fn facing(&mut self, mesh: Handle<Mesh>) -> Handle<Mesh> {
        let key = (mesh.index(), "facing".to_owned());
        if let Some(known) = self.forms.get(&key) {
            return *known;
        }
        let old = self.to.mesh_of(mesh);
        let normals = old.normals.as_deref().map_or(&[][..], Vec::as_slice);
        let against = old.triangles.iter().any(|triangle| is_against(*triangle, &old.positions, normals));
        let made = if against { self.to.changed(mesh, facing) } else { mesh };
        self.forms.insert(key, made);
        made
    }

    /// A mesh of arrays.
    fn inline(&mut self, params: &Params) -> Option<Geometry> {
        let kind = params.kind.as_str();
        let positions = self.points(params, "P")?;
        let count = positions.len();
        let triangles = match params.numbers("indices", self.reader) {
            Some(indices) => indexed::<3>(indices),
            // One triangle needs none.
            None if count == 3 && !params.has("indices") => Some(vec![[0, 1, 2]]),
            None => None,
        };
        let Some(triangles) = triangles else {
            let message = format!("the mesh `{kind}` is left out: its `indices` are no triangles");
            self.dropped(params.span_of("indices"), message);
            params.pass_all();
            return None;
        };
        let uvs = self.coordinates(params, count);
        let normals = self.normals(params, count);
        let mut geometry = Geometry { positions, normals, uvs, triangles };
        if kind == "loopsubdiv" {
            params.pass(&["levels", "nlevels", "scheme"]);
            self.near(params.span, "a subdivision surface is its control mesh with smooth normals");
            if geometry.check_indices().is_ok()
                && let Ok((smooth, _)) = mesh::smooth(geometry.clone(), 180.0)
            {
                geometry = smooth;
            }
            return Some(geometry);
        }
        if geometry.normals.is_some() && geometry.check_indices().is_ok() {
            geometry = facing(geometry);
        }
        Some(geometry)
    }

    /// Positions.
    fn points(&mut self, params: &Params, name: &str) -> Option<Vec<[f32; 3]>> {
        let numbers = params.numbers(name, self.reader).unwrap_or_default();
        if numbers.is_empty() || !numbers.len().is_multiple_of(3) {
            let message = format!("the mesh `{}` is left out: its `{name}` are no positions", shown(&params.kind));
            self.dropped(params.span_of(name), message);
            params.pass_all();
            return None;
        }
        Some(triples(numbers))
    }

    /// Texture coordinates.
    fn coordinates(&mut self, params: &Params, count: usize) -> Option<Vec<[f32; 2]>> {
        let name = *["uv", "st"].iter().find(|name| params.has(name))?;
        let numbers = params.numbers(name, self.reader)?;
        params.pass(&["uv", "st"]);
        if numbers.len() == 2 * count {
            let pair = |pair: &[f64]| if let [u, v] = pair { [*u as f32, *v as f32] } else { [0.0; 2] };
            return Some(numbers.chunks_exact(2).map(pair).collect());
        }
        let message = format!("`{name}` is left out: there are {} numbers for {count} positions", numbers.len());
        self.dropped(params.span_of(name), message);
        None
    }

    /// Normals, of unit length.
    fn normals(&mut self, params: &Params, count: usize) -> Option<Vec<[f32; 3]>> {
        let numbers = params.numbers("N", self.reader)?;
        if numbers.len() != 3 * count {
            let message = format!("`N` is left out: there are {} numbers for {count} positions", numbers.len());
            self.dropped(params.span_of("N"), message);
            return None;
        }
        let unit = |three: &[f64]| match three {
            [x, y, z] => normalized([*x, *y, *z]).map(|normal| normal.map(|part| part as f32)),
            _ => None,
        };
        let normals: Option<Vec<[f32; 3]>> = numbers.chunks_exact(3).map(unit).collect();
        if normals.is_none() {
            self.dropped(params.span_of("N"), "`N` is left out: one of the normals has no direction");
        }
        normals
    }

    /// `heightfield` of v1 to v3: a grid over the unit square.
    fn height_field(&mut self, params: &Params) -> Option<Geometry> {
        let (columns, rows) = (params.count("nu", self.reader)?, params.count("nv", self.reader)?);
        let (columns, rows) = (columns as usize, rows as usize);
        let heights = params.numbers("Pz", self.reader).or(params.numbers("z", self.reader)).unwrap_or_default();
        if columns < 2 || rows < 2 || columns.checked_mul(rows) != Some(heights.len()) {
            self.dropped(params.span, "a height field is left out: it has not `nu` times `nv` heights");
            return None;
        }
        let place = |at: usize| [at % columns, at / columns];
        let uv = |at: usize| {
            let [x, y] = place(at);
            [(x as f64 / (columns - 1) as f64) as f32, (y as f64 / (rows - 1) as f64) as f32]
        };
        let uvs: Vec<[f32; 2]> = (0..heights.len()).map(uv).collect();
        let positions = uvs.iter().zip(heights).map(|([x, y], z)| [*x, *y, *z as f32]).collect();
        let index = |x: usize, y: usize| (y * columns + x) as u32;
        let mut triangles = Vec::with_capacity(2 * (columns - 1) * (rows - 1));
        for y in 0..rows - 1 {
            for x in 0..columns - 1 {
                let (a, b, c, d) = (index(x, y), index(x + 1, y), index(x + 1, y + 1), index(x, y + 1));
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        Some(Geometry { positions, normals: None, uvs: Some(uvs), triangles })
    }

    /// v4's `bilinearmesh`: four corners each, p00, p10, p01, p11.
    fn patches(&mut self, params: &Params) -> Option<Geometry> {
        let positions = self.points(params, "P")?;
        let count = positions.len();
        let patches = match params.numbers("indices", self.reader) {
            Some(indices) => indexed::<4>(indices),
            None if count == 4 && !params.has("indices") => Some(vec![[0, 1, 2, 3]]),
            None => None,
        };
        let Some(patches) = patches.filter(|all| all.iter().flatten().all(|index| (*index as usize) < count)) else {
            self.dropped(params.span, "a mesh of patches is left out: its `indices` are not four positions each");
            params.pass_all();
            return None;
        };
        if params.has("emissionfilename") {
            params.pass(&["emissionfilename"]);
            self.near(params.span, "a light with an image emits the same everywhere");
        }
        let point = |index: u32| positions[index as usize].map(f64::from);
        let flat = |[a, b, c, d]: &[u32; 4]| {
            let [a, b, c, d] = [point(*a), point(*b), point(*c), point(*d)];
            let across = cross(sub(b, a), sub(c, a));
            let size = dot(across, across).sqrt() * dot(sub(d, a), sub(d, a)).sqrt();
            dot(across, sub(d, a)).abs() <= 1e-5 * size
        };
        if !patches.iter().all(flat) {
            self.near(params.span, "a curved bilinear patch is two triangles");
        }
        let triangles = patches.iter().flat_map(|[a, b, c, d]| [[*a, *b, *d], [*a, *d, *c]]).collect();
        let mut uvs = self.coordinates(params, count);
        if uvs.is_none() && patches.len() == 1 && count == 4 {
            uvs = Some(patches.first().map_or(Vec::new(), |patch| {
                let mut uvs = vec![[0.0; 2]; 4];
                let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
                patch.iter().zip(corners).for_each(|(index, corner)| uvs[*index as usize] = corner);
                uvs
            }));
        }
        let normals = self.normals(params, count);
        let geometry = Geometry { positions, normals, uvs, triangles };
        Some(if geometry.normals.is_some() { facing(geometry) } else { geometry })
    }
}

fn triples(numbers: &[f64]) -> Vec<[f32; 3]> {
    let triple = |three: &[f64]| match three {
        [x, y, z] => [*x as f32, *y as f32, *z as f32],
        _ => [0.0; 3],
    };
    numbers.chunks_exact(3).map(triple).collect()
}

/// Indices in rows; none where they are no whole numbers, or not rows of so many.
fn indexed<const N: usize>(numbers: &[f64]) -> Option<Vec<[u32; N]>> {
    if numbers.is_empty() || !numbers.len().is_multiple_of(N) {
        return None;
    }
    let whole =
        |value: f64| (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32);
    let row = |row: &[f64]| {
        let mut indices = [0; N];
        for (index, value) in indices.iter_mut().zip(row) {
            *index = whole(*value)?;
        }
        Some(indices)
    };
    numbers.chunks_exact(N).map(row).collect()
}

/// Whether a triangle is turned away from the normals of its corners.
fn is_against(triangle: [u32; 3], positions: &[[f32; 3]], normals: &[[f32; 3]]) -> bool {
    let corner = |index: u32| positions.get(index as usize).copied().unwrap_or_default().map(f64::from);
    let normal = |index: u32| normals.get(index as usize).copied().unwrap_or_default().map(f64::from);
    let [a, b, c] = triangle.map(corner);
    let [k, l, m] = triangle.map(normal);
    let mean = [0, 1, 2].map(|axis: usize| k[axis] + l[axis] + m[axis]);
    dot(cross(sub(b, a), sub(c, a)), mean) < 0.0
}

/// The triangles on the side of their normals.
fn facing(mut geometry: Geometry) -> Geometry {
    let Geometry { positions, normals, uvs: _, triangles } = &mut geometry;
    let normals = normals.as_deref().unwrap_or_default();
    for triangle in triangles.iter_mut() {
        if is_against(*triangle, positions, normals) {
            triangle.swap(1, 2);
        }
    }
    geometry
}

/// A mesh without texture coordinates: PBRT gives the corners of each triangle (0, 0), (1, 0) and (1, 1).
fn cornered(geometry: Geometry) -> Geometry {
    let Geometry { positions, normals, uvs: _, triangles } = geometry;
    let corners = || triangles.iter().flatten().map(|index| *index as usize);
    Geometry {
        positions: corners().map(|index| positions[index]).collect(),
        normals: normals.as_ref().map(|normals| corners().map(|index| normals[index]).collect()),
        uvs: Some(triangles.iter().flat_map(|_| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).collect()),
        triangles: (0..triangles.len() as u32).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect(),
    }
}
