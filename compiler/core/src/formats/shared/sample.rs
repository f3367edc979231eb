//! Scenes for the tests of the formats.

use crate::diag::Origin;
use crate::image::{self, Pixels, write};
use crate::ir::{
    Affine, Arena, Bsdf, Camera, Color, Documentation, Emission, Encoding, Film, Filter, Group, Handle, ImageFormat,
    Instance, Integrator, Material, Mesh, Places, Sampler, Scene, Shape, Texture, Vec3, cross, normalized, sub,
};
use crate::mesh::Geometry;

/// A scene without surfaces: a square camera at (0, -160, 50) that looks along y with 45 degrees.
pub fn empty(name: &str) -> Scene {
    let mut cameras = Arena::default();
    cameras.push(
        Camera {
            name: None,
            eye: [0.0, -160.0, 50.0],
            target: [0.0, 0.0, 50.0],
            up: [0.0, 0.0, 1.0],
            fov_x: 45.0,
            near: None,
            far: None,
        },
        Origin::Made,
    );
    Scene {
        name: name.to_owned(),
        origin: Origin::Made,
        documentation: Documentation::default(),
        meshes: Arena::default(),
        textures: Arena::default(),
        materials: Arena::default(),
        shapes: Arena::default(),
        lights: Arena::default(),
        groups: Arena::default(),
        instances: Arena::default(),
        cameras,
        film: Film { width: 128, height: 128, filter: Filter::Box { radius: 0.5 } },
        integrator: Integrator::Path { max_depth: 10 },
        sampler: Sampler::Independent { samples: 32, seed: 0 },
    }
}

/// Adds a material.
pub fn material(scene: &mut Scene, name: &str, bsdf: Bsdf) -> Handle<Material> {
    scene.materials.push(Material::new(name, bsdf), Origin::Made)
}

/// Adds a shape at its place.
pub fn shape(
    scene: &mut Scene,
    name: &str,
    mesh: Handle<Mesh>,
    material: Handle<Material>,
    emission: Option<Emission>,
) -> Handle<Shape> {
    let transform = Affine::IDENTITY;
    let name = name.to_owned();
    scene.shapes.push(Shape { name, mesh, transform, material, emission }, Origin::Made)
}

/// Flat quadrilaterals, each with its own four vertices, counter-clockwise seen from the side of the normal.
pub fn quads(scene: &mut Scene, name: &str, quads: &[[Vec3; 4]]) -> Handle<Mesh> {
    let mut geometry = Geometry::default();
    let mut normals = Vec::new();
    for quad in quads {
        let normal = normalized(cross(sub(quad[1], quad[0]), sub(quad[2], quad[0])));
        let normal = normal.expect("a proper quadrilateral").map(|x| x as f32);
        let first = geometry.positions.len() as u32;
        geometry.positions.extend(quad.map(|corner| corner.map(|x| x as f32)));
        normals.extend([normal; 4]);
        geometry.triangles.push([first, first + 1, first + 2]);
        geometry.triangles.push([first, first + 2, first + 3]);
    }
    geometry.normals = Some(normals);
    scene.meshes.push(geometry.into_mesh(name), Origin::Made)
}

/// The six outward sides of a box with its center at `center`, turned about z.
pub fn block(scene: &mut Scene, name: &str, size: Vec3, center: Vec3, degrees: f64) -> Handle<Mesh> {
    let [x, y, z] = size.map(|side| side / 2.0);
    let place = Affine::rotation([0.0, 0.0, 1.0], degrees).then(&Affine::translation(center));
    let sides = [
        [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]],
        [[-x, y, -z], [x, y, -z], [x, -y, -z], [-x, -y, -z]],
        [[-x, -y, -z], [x, -y, -z], [x, -y, z], [-x, -y, z]],
        [[x, y, -z], [-x, y, -z], [-x, y, z], [x, y, z]],
        [[x, -y, -z], [x, y, -z], [x, y, z], [x, -y, z]],
        [[-x, y, -z], [-x, -y, -z], [-x, -y, z], [-x, y, z]],
    ];
    quads(scene, name, &sides.map(|side| side.map(|corner| place.point(corner))))
}

/// A diffuse reflectance.
pub fn diffuse(rgb: [f64; 3]) -> Bsdf {
    let [r, g, b] = rgb;
    let reflectance = if r == g && g == b { Color::Grey(r) } else { Color::Rgb(rgb) };
    Bsdf::Diffuse { reflectance: reflectance.into() }
}

/// A Cornell box with its front open, two blocks and a lamp: the classic scene of the light transport test suite.
pub fn room() -> Scene {
    let mut scene = empty("cbox_classic");
    let white = material(&mut scene, "white", diffuse([1.0; 3]));
    let red = material(&mut scene, "red", diffuse([0.529, 0.024, 0.024]));
    let green = material(&mut scene, "green", diffuse([0.024, 0.529, 0.024]));
    let ochre = material(&mut scene, "ochre", diffuse([0.882, 0.776, 0.341]));
    let black = material(&mut scene, "black", diffuse([0.0; 3]));
    let (l, h) = (50.0, 100.0);
    let walls: [(&str, Handle<Material>, [Vec3; 4]); 5] = [
        ("floor", white, [[-l, -l, 0.0], [l, -l, 0.0], [l, l, 0.0], [-l, l, 0.0]]),
        ("ceiling", white, [[-l, l, h], [l, l, h], [l, -l, h], [-l, -l, h]]),
        ("back", white, [[-l, l, 0.0], [l, l, 0.0], [l, l, h], [-l, l, h]]),
        ("left", red, [[-l, -l, 0.0], [-l, l, 0.0], [-l, l, h], [-l, -l, h]]),
        ("right", green, [[l, l, 0.0], [l, -l, 0.0], [l, -l, h], [l, l, h]]),
    ];
    for (name, material, corners) in walls {
        let mesh = quads(&mut scene, name, &[corners]);
        shape(&mut scene, name, mesh, material, None);
    }
    let small = block(&mut scene, "small", [30.0, 30.0, 30.0], [17.0, -10.0, 15.0], -17.5);
    shape(&mut scene, "small", small, ochre, None);
    let tall = block(&mut scene, "tall", [30.0, 30.0, 60.0], [-17.5, 17.5, 30.0], 20.0);
    shape(&mut scene, "tall", tall, ochre, None);
    let (d, z) = (10.0, 99.0);
    let lamp = quads(&mut scene, "lamp", &[[[-d, d, z], [d, d, z], [d, -d, z], [-d, -d, z]]]);
    shape(&mut scene, "lamp", lamp, black, Some(Emission { radiance: Color::Grey(30.0) }));
    scene
}

/// Two blocks in a group, seen three times: as they are, moved, and turned while sheared; and a lamp.
pub fn grid() -> Scene {
    let mut scene = empty("grid");
    let white = material(&mut scene, "white", diffuse([1.0; 3]));
    let black = material(&mut scene, "black", diffuse([0.0; 3]));
    let mesh = block(&mut scene, "block", [1.0; 3], [0.0; 3], 0.0);
    let mut group = Group { name: "pair".to_owned(), ..Group::default() };
    for (name, x) in [("left", -2.0), ("right", 2.0)] {
        let transform = Affine::translation([x, 0.0, 0.0]);
        let shape = Shape { name: name.to_owned(), mesh, transform, material: white, emission: None };
        group.shapes.push(shape, Origin::Made);
    }
    let group = scene.groups.push(group, Origin::Made);
    let turned = Affine::rotation([0.0, 0.0, 1.0], 90.0).then(&Affine::translation([0.0, 0.0, 5.0]));
    let sheared = Affine { rows: [[1.0, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 20.0]] };
    for (at, transform) in [Affine::IDENTITY, turned, sheared].into_iter().enumerate() {
        scene
            .instances
            .push(Instance { name: format!("pair[{at}]"), group, places: Places::One(transform) }, Origin::Made);
    }
    let lamp = quads(&mut scene, "lamp", &[[[-1.0, 1.0, 9.0], [1.0, 1.0, 9.0], [1.0, -1.0, 9.0], [-1.0, -1.0, 9.0]]]);
    shape(&mut scene, "lamp", lamp, black, Some(Emission { radiance: Color::Grey(30.0) }));
    scene
}

/// A small image of a format: 4 x 2 pixels, in JPEG 16 x 16.
pub fn image(name: &str, format: ImageFormat, encoding: Encoding) -> Texture {
    let values = (0..4 * 2 * 3).map(|at| at as f32 / 32.0).collect();
    let pixels = Pixels { width: 4, height: 2, channels: 3, values };
    let bytes = match format {
        ImageFormat::Png => write::png(&pixels, 8),
        ImageFormat::Jpeg => Ok(include_bytes!("../../../../../tests/cases/images/quads.jpg").to_vec()),
        ImageFormat::Exr => write::exr(&pixels, write::Depth::Full),
        ImageFormat::Pfm => Ok(write::pfm(&pixels)),
        ImageFormat::Hdr => {
            Ok([&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"[..], &b"\x80\x40\x20\x81".repeat(8)].concat())
        }
    };
    let loaded = image::load(format.ending(), &bytes.expect("an image"), 1 << 20).expect("an image");
    Texture {
        name: name.to_owned(),
        file: loaded.file,
        image: loaded.info,
        encoding,
        peak: loaded.peak,
        factor: [1.0; 3],
    }
}
