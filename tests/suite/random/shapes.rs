//! Meshes with their stages, and what surfaces are made of.

use ltsc_core::eval::Family::{Emission, Material, Mesh, Stage, Texture};

use super::author::Author;

/// How scenes are sized: most as people write them, some tiny, some huge.
fn size(author: &mut Author) -> f64 {
    match author.dice.at(8) {
        0 => author.dice.size(-4.0, -1.0),
        1 => author.dice.size(1.0, 4.0),
        _ => author.dice.between(0.2, 5.0),
    }
}

/// Mesh files, each with the part that is taken of it.
const FILES: &[(&str, Option<&str>)] = &[
    ("ridge.ply", None),
    ("colored.ply", None),
    ("no_normals.ply", None),
    ("strips.ply", None),
    ("tetrahedron.obj", None),
    ("tetrahedron.obj", Some("pot")),
    ("cube.stl", None),
    ("table.glb", None),
];

/// Images on surfaces, with their encodings: none where it follows from the format.
const IMAGES: &[(&str, Option<&str>)] = &[
    ("colors.png", None),
    ("colors.png", Some("linear")),
    ("edge.png", Some("srgb")),
    ("edge_16.png", None),
    ("edge_16.png", Some("linear")),
    ("edge.jpg", None),
    ("edge.jpg", Some("linear")),
    ("edge.exr", None),
    ("edge.pfm", Some("linear")),
    ("edge.hdr", None),
    ("odd name (1).png", None),
    ("palette.png", None),
];

/// A mesh in its place, and whether it has texture coordinates.
pub fn mesh(author: &mut Author) -> (String, bool) {
    let mut text = plain(author);
    // Of files and of `triangles` without them the author says none.
    let painted = !text.starts_with("file(") && (!text.starts_with("triangles(") || text.contains("uvs"));
    for _ in 0..author.dice.pick(&[0, 0, 1, 1, 2, 3]) {
        text = format!("{text} |> {}", stage(author, true));
    }
    (text, painted)
}

/// A mesh as its constructor makes it.
fn plain(author: &mut Author) -> String {
    let s = size(author);
    let segments = |author: &mut Author| ("segments", author.dice.whole(3, 9).to_string());
    let caps = |author: &mut Author| ("caps", author.dice.chance(0.5).to_string());
    match author.dice.at(12) {
        0 => rectangle(author, s),
        1 if author.dice.chance(0.5) => {
            let [a, b, c] = [0, 1, 2].map(|_| author.dice.between(0.1, 2.0) * s);
            let [x, y, z] = [a, b, c].map(|side| author.range(-side, side));
            author.call(Mesh, "box", &[("x", x), ("y", y), ("z", z)])
        }
        1 => {
            let sides = [0, 1, 2].map(|_| author.dice.between(0.1, 2.0) * s);
            let size = if author.dice.chance(0.3) { author.number(s) } else { author.vector(&sides) };
            let center = author.near(3.0);
            let center = author.vector(&center);
            let all = [("size", size), ("center", center)];
            let count = author.dice.at(2) + 1;
            author.call(Mesh, "box", &all[..count])
        }
        2 => {
            let center = author.near(3.0);
            let (radius, center) = (author.number(s), author.vector(&center));
            let mut all = vec![("radius", radius)];
            if author.dice.chance(0.4) {
                all.push(("center", center));
            }
            all.push(segments(author));
            all.push(("rings", author.dice.whole(2, 7).to_string()));
            author.call(Mesh, "sphere", &all)
        }
        3 => {
            let mut all = vec![("radius", author.number(s))];
            if author.dice.chance(0.5) {
                let inner = author.dice.between(0.05, 0.95) * s;
                all.push(("inner", author.number(inner)));
            }
            all.push(segments(author));
            author.call(Mesh, "disk", &all)
        }
        4 => {
            let (radius, z) = (author.number(s), author.range(-s, 2.0 * s));
            let all = [("radius", radius), ("z", z), segments(author), caps(author)];
            author.call(Mesh, "cylinder", &all)
        }
        5 => {
            let top = if author.dice.chance(0.4) { 0.0 } else { author.dice.between(0.1, 2.0) * s };
            let (radius, top, z) = (author.number(s), author.number(top), author.range(0.0, s));
            let all = [("radius", radius), ("top", top), ("z", z), segments(author), caps(author)];
            author.call(Mesh, "cone", &all)
        }
        6 => {
            let minor = s * author.dice.between(0.05, 0.9);
            let (major, minor) = (author.number(s), author.number(minor));
            let rings = ("rings", author.dice.whole(3, 6).to_string());
            let all = [("major", major), ("minor", minor), segments(author), rings];
            author.call(Mesh, "torus", &all)
        }
        7 => {
            let closed = author.dice.chance(0.3);
            let points: &[[f64; 2]] =
                if closed { &[[1.0, 0.0], [3.0, 0.0], [2.0, 2.0]] } else { &[[0.0, 0.0], [3.0, 1.0], [4.0, 5.0]] };
            let points: Vec<String> = points.iter().map(|point| author.vector(&point.map(|x| x * s))).collect();
            let profile = ("profile", format!("[{}]", points.join(", ")));
            let all = [profile, segments(author), ("closed", closed.to_string())];
            author.call(Mesh, "lathe", &all)
        }
        8 => {
            let (x, y) = (author.range(-s, s), author.range(-s, s));
            let vertices = format!("({}, {})", author.dice.whole(2, 5), author.dice.whole(2, 5));
            let all = [("height", "hill".to_owned()), ("x", x), ("y", y), ("vertices", vertices)];
            author.call(Mesh, "height_field", &all)
        }
        9 => {
            let [a, b] = [author.dice.whole(3, 6), author.dice.whole(3, 6)];
            let cells = |author: &mut Author, count: u32| {
                let low = author.dice.whole(1, count - 2);
                let high = author.dice.whole(low, count - 2);
                format!("{low}..{high}")
            };
            let hole = format!("({}, {})", cells(author, a), cells(author, b));
            let thin = author.dice.at(3);
            let [x, y, z] = [0, 1, 2].map(|axis| {
                let half = if axis == thin { 0.03 * s } else { s };
                author.range(-half, half)
            });
            let raster = ("raster", format!("({a}, {b})"));
            author.call(Mesh, "plate", &[("x", x), ("y", y), ("z", z), raster, ("hole", hole)])
        }
        10 => triangles(author, s),
        _ => {
            let (path, part) = author.dice.pick(FILES);
            let mut all = vec![("path", format!("\"{path}\""))];
            all.extend(part.map(|part| ("part", format!("\"{part}\""))));
            author.call(Mesh, "file", &all)
        }
    }
}

fn rectangle(author: &mut Author, s: f64) -> String {
    let flat = author.dice.at(3);
    let sign = author.dice.pick(&["", "-"]);
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let (low, high) = (author.dice.between(0.1, 2.0) * s, author.dice.between(0.1, 2.0) * s);
        if axis == flat { author.within(-5.0, 5.0) } else { author.range(-low, high) }
    });
    let normal = format!("{sign}{}", ["X", "Y", "Z"][flat]);
    author.call(Mesh, "rectangle", &[("x", x), ("y", y), ("z", z), ("normal", normal)])
}

fn triangles(author: &mut Author, s: f64) -> String {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.2, 0.3, 1.0]];
    let count = author.dice.pick(&[3, 4]);
    let positions: Vec<String> = corners[..count].iter().map(|corner| author.vector(&corner.map(|x| x * s))).collect();
    let faces = if count == 3 { "[(0, 1, 2)]" } else { "[(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]" };
    let mut all = vec![("positions", format!("[{}]", positions.join(", "))), ("faces", faces.to_owned())];
    if author.dice.chance(0.4) {
        let normals: &[&str] = &["-Z", "normalize((1, -1, -0.3))", "(0, 1, 0)", "Z"];
        // Those of one triangle are its own, or nearly.
        let normals = if count == 3 { vec!["Z"; 3] } else { normals.to_vec() };
        all.push(("normals", format!("[{}]", normals.join(", "))));
    }
    if author.dice.chance(0.6) {
        let uvs: Vec<String> = (0..count)
            .map(|_| {
                let uv = [author.dice.between(-2.0, 2.0), author.dice.between(0.0, 1.0)];
                author.vector(&uv)
            })
            .collect();
        all.push(("uvs", format!("[{}]", uvs.join(", "))));
    }
    author.call(Mesh, "triangles", &all)
}

/// A stage. Only meshes have normals that a stage may change.
pub fn stage(author: &mut Author, of_mesh: bool) -> String {
    let three = |author: &mut Author, reach: f64| {
        let vector = author.near(reach);
        author.vector(&vector)
    };
    match author.dice.at(if of_mesh { 12 } else { 9 }) {
        0 => {
            let [x, y, z] = [0, 1, 2].map(|_| author.within(-9.0, 9.0));
            author.call(Stage, "translate", &[("x", x), ("y", y), ("z", z)])
        }
        1 => {
            let by = three(author, 10.0);
            author.call(Stage, "translate", &[("by", by)])
        }
        2 => {
            let axis = author.dice.pick(&["x", "y", "z"]);
            let degrees = author.dice.pick(&[90.0, 180.0, 360.0]);
            let angle = author.angle(-degrees, degrees);
            let mut all = vec![(axis, angle)];
            if author.dice.chance(0.3) {
                all.push(("about", three(author, 5.0)));
            }
            author.call(Stage, "rotate", &all)
        }
        3 => {
            let axis = author.direction();
            let (axis, angle) = (author.vector(&axis), author.angle(-180.0, 180.0));
            let all = [("axis", axis), ("angle", angle), ("about", three(author, 5.0))];
            let count = author.dice.pick(&[2, 3]);
            author.call(Stage, "rotate", &all[..count])
        }
        4 => {
            let sign = author.dice.pick(&[1.0, 1.0, 1.0, -1.0]);
            let size = author.dice.pick(&[0.5, 2.0, 6.0]);
            let factor = sign * author.dice.size(-size / 2.0, size / 2.0);
            let factor = author.number(factor);
            author.call(Stage, "scale", &[("factor", factor)])
        }
        5 => {
            let part = |author: &mut Author| {
                let size = author.dice.pick(&[1.0, -1.0, 0.1, 20.0, 0.01, 0.5, -3.0]);
                author.number(size)
            };
            let [x, y, z] = [0, 1, 2].map(|_| part(author));
            let all = [("x", x), ("y", y), ("z", z)];
            let count = author.dice.pick(&[1, 2, 3]);
            author.call(Stage, "scale", &all[..count])
        }
        6 => {
            let z = author.direction();
            // Something that does not lie along it.
            let x = if z[0].abs() > z[1].abs() { "Y" } else { "X" };
            let all = [("x", x.to_owned()), ("z", author.vector(&z)), ("origin", three(author, 5.0))];
            let count = author.dice.pick(&[2, 3]);
            author.call(Stage, "frame", &all[..count])
        }
        7 | 8 => {
            let (shear, size) = (author.dice.between(-2.0, 2.0), author.dice.pick(&[1.0, 0.3, -2.0]));
            let [a, b, c] = author.near(10.0);
            let tilt = author.dice.between(-1.0, 1.0);
            let rows = [[1.0, shear, 0.0, a], [0.0, size, 0.0, b], [tilt, 0.0, 1.0, c]];
            let [x, y, z] = rows.map(|row| author.vector(&row));
            author.call(Stage, "matrix", &[("row_x", x), ("row_y", y), ("row_z", z)])
        }
        9 => author.call(Stage, "faceted", &[]),
        10 => {
            let crease = author.angle(0.0, 180.0);
            let all = [("crease", crease)];
            let count = author.dice.at(2);
            author.call(Stage, "smooth", &all[..count])
        }
        _ => author.call(Stage, "flip", &[]),
    }
}

/// An image on a surface.
pub fn texture(author: &mut Author) -> String {
    let (path, encoding) = author.dice.pick(IMAGES);
    let mut all = vec![("path", format!("\"{path}\""))];
    all.extend(encoding.map(|encoding| ("encoding", format!("\"{encoding}\""))));
    if author.dice.chance(0.3) {
        let [r, g, b] = [0, 1, 2].map(|_| author.dice.share());
        let grey = author.dice.chance(0.5);
        all.push(("scale", if grey { format!("{r}") } else { format!("rgb({r}, {g}, {b})") }));
    }
    author.call(Texture, "bitmap", &all)
}

fn paint(author: &mut Author) -> String {
    if author.dice.chance(0.25) { texture(author) } else { author.color(1.0) }
}

fn alpha(author: &mut Author) -> String {
    let alpha = author.dice.pick(&[0.0, 1e-9, 0.001, 0.01, 0.1, 0.25, 0.5, 1.0]);
    let alpha = if author.dice.chance(0.3) { author.dice.between(0.0, 1.0) } else { alpha };
    author.number(alpha)
}

fn ior(author: &mut Author) -> f64 {
    author.dice.pick(&[1.000_000_1, 1.0001, 1.01, 1.33, 1.5, 1.5, 2.0, 2.4, 4.0])
}

/// A material; some are black from behind.
pub fn material(author: &mut Author) -> String {
    let front = scattering(author);
    if author.dice.chance(0.15) && !front.starts_with("dielectric") {
        return author.call(Material, "one_sided", &[("material", front)]);
    }
    front
}

fn scattering(author: &mut Author) -> String {
    match author.dice.at(6) {
        0 => {
            let reflectance = paint(author);
            author.call(Material, "diffuse", &[("reflectance", reflectance)])
        }
        1 => {
            let three = |author: &mut Author, low: f64, high: f64| {
                let [r, g, b] = [0, 1, 2].map(|_| author.within(low, high));
                if author.dice.chance(0.3) { r } else { format!("rgb({r}, {g}, {b})") }
            };
            let all = [("eta", three(author, 0.1, 4.0)), ("k", three(author, 0.0, 6.0)), ("alpha", alpha(author))];
            author.call(Material, "conductor", &all)
        }
        2 => {
            let inside = if author.dice.chance(0.2) { 0.7 } else { ior(author) };
            let outside = author.dice.pick(&[1.0, 1.0, 1.0, 1.33, 1.000_001]);
            let (ior, outside, alpha) = (author.number(inside), author.number(outside), alpha(author));
            let all = [("ior", ior), ("outside", outside), ("alpha", alpha)];
            let count = author.dice.pick(&[1, 2, 3]);
            author.call(Material, "dielectric", &all[..count])
        }
        3 => {
            let all = [("reflectance", author.color(1.0))];
            let count = author.dice.at(2);
            author.call(Material, "mirror", &all[..count])
        }
        4 => {
            let (paint, ior) = (paint(author), ior(author));
            let all = [("reflectance", paint), ("ior", author.number(ior)), ("alpha", alpha(author))];
            let count = author.dice.pick(&[1, 2, 3]);
            author.call(Material, "plastic", &all[..count])
        }
        _ => {
            let (base, ior) = (paint(author), ior(author));
            let metallic = author.dice.pick(&[0.0, 1.0, 0.3]);
            let metallic = if author.dice.chance(0.4) { author.dice.between(0.0, 1.0) } else { metallic };
            let rough = author.dice.pick(&[0.0, 1.0, 0.5, 0.1, 0.33]);
            let (metallic, roughness) = (author.number(metallic), author.number(rough));
            let all = [("base", base), ("metallic", metallic), ("roughness", roughness), ("ior", author.number(ior))];
            let count = author.dice.pick(&[1, 2, 3, 4]);
            author.call(Material, "principled", &all[..count])
        }
    }
}

/// Whether a material shows an image.
pub fn is_painted(material: &str) -> bool {
    material.contains("bitmap(")
}

/// What an emitter emits.
pub fn emission(author: &mut Author) -> String {
    let most = author.dice.size(-6.0, 5.0);
    let value = author.color(most);
    let mut all = vec![("value", value)];
    if author.dice.chance(0.4) {
        all.push(("over", material(author)));
    }
    author.call(Emission, "radiance", &all)
}
