//! Whole scenes: settings, groups, lights, and texts around them.

use ltsc_core::eval::Family::{Camera, Film, Filter, Group, Integrator, Light, Sampler, Stage};

use super::author::Author;
use super::shapes;

/// Files that group constructors read.
const GROUPS: &[&str] = &["room.obj", "table.glb", "cube.stl", "colored.ply"];
/// Arrays of places.
const PLACES: &[&str] = &["positions.npy", "forest.npy"];
/// Images of all directions.
const SKIES: &[&str] = &["sky.exr", "edge.pfm", "edge.hdr"];

/// The text of a scene called `name`.
pub fn text(author: &mut Author, name: &str) -> String {
    let mut parts = vec![header(name), settings(author)];
    parts.push("let hill(x: number, y: number) = exp(0 - x * x - y * y)".to_owned());
    let mut materials = vec![("cloth".to_owned(), false)];
    parts.insert(1, "use cloth, stool from \"lib.lts\"".to_owned());
    for _ in 0..author.dice.at(3) {
        let (word, value) = (author.word("paint"), shapes::material(author));
        parts.push(format!("material {word} = {value}"));
        materials.push((word, shapes::is_painted(&value)));
    }
    let mut meshes = Vec::new();
    for _ in 0..author.dice.at(3) {
        let (word, (value, painted)) = (author.word("form"), shapes::mesh(author));
        parts.push(format!("mesh {word} = {value}"));
        meshes.push((word, painted));
    }
    let mut shelf = Shelf { materials, meshes, groups: vec!["stool".to_owned()] };
    for _ in 0..author.dice.pick(&[0, 1, 1, 2, 3]) {
        let (word, body) = (author.word("group"), group(author, &shelf));
        parts.push(format!("group {word} {body}"));
        shelf.groups.push(word);
    }
    if author.dice.chance(0.15) {
        let path = author.dice.pick(GROUPS);
        let (word, file) = (author.word("file"), author.call(Group, "file", &[("path", format!("\"{path}\""))]));
        parts.push(format!("group {word} = {file}"));
        shelf.groups.push(word);
    }
    for _ in 0..author.dice.whole(1, 4) {
        let statement = if author.dice.chance(0.6) { shape(author, &shelf) } else { emitter(author, &shelf) };
        parts.push(repeated(author, statement));
    }
    for _ in 0..author.dice.pick(&[0, 1, 2, 3]) {
        let statement = instance(author, &shelf, true);
        parts.push(repeated(author, statement));
    }
    for _ in 0..author.dice.pick(&[0, 0, 1, 2]) {
        parts.push(light(author, true));
    }
    if author.dice.chance(0.3) {
        parts.push(environment(author));
    }
    parts.join("\n")
}

/// The library that all scenes use.
pub const LIBRARY: &str = "lts 1\n\nmaterial cloth = diffuse(rgb(0.6, 0.5, 0.4))\n\ngroup stool {\n    \
    shape seat = box(size: (1, 1, 0.1)) |> translate(z: 1) with cloth\n    \
    shape leg = cylinder(radius: 0.05, z: 0..1, segments: 6) with mirror(0.9)\n}\n";

/// What the statements of a scene may name.
struct Shelf {
    /// Materials, and whether they show an image.
    materials: Vec<(String, bool)>,
    /// Meshes, and whether an image can lie on them.
    meshes: Vec<(String, bool)>,
    groups: Vec<String>,
}

fn header(name: &str) -> String {
    format!("lts 1\n\n/// A.\n///\n/// B.\nscene {name} {{\n    paths: [\"LDE\"]\n    license: \"CC0\"\n}}\n")
}

fn settings(author: &mut Author) -> String {
    let cameras = if author.dice.chance(0.2) { vec!["camera `from the left`", "camera top"] } else { vec!["camera"] };
    let mut parts = Vec::new();
    for kind in cameras {
        let camera = camera(author);
        parts.push(format!("{kind} = {camera}"));
    }
    let side = |author: &mut Author| author.dice.pick(&[1, 7, 48, 64, 500, 512, 65_536]).to_string();
    let mut film = vec![("width", side(author)), ("height", side(author))];
    match author.dice.at(3) {
        0 => {}
        1 => {
            let radius = author.dice.pick(&[0.5, 1.0, 2.0]);
            let all = [("radius", author.number(radius))];
            let count = author.dice.at(2);
            film.push(("filter", author.call(Filter, "box", &all[..count])));
        }
        _ => {
            let (stddev, radius) = (author.dice.pick(&[0.3, 0.5, 1.0]), author.dice.pick(&[1.5, 2.0, 4.0]));
            let all = [("stddev", author.number(stddev)), ("radius", author.number(radius))];
            let count = author.dice.at(3);
            film.push(("filter", author.call(Filter, "gaussian", &all[..count])));
        }
    }
    parts.push(format!("film = {}", author.call(Film, "image", &film)));
    let integrator = author.dice.pick(&["path", "bidirectional", "light_tracing", "metropolis", "photon_map"]);
    let depth = author.dice.pick(&[1_u32, 2, 3, 10, 1000, i32::MAX as u32, 1 << 31, u32::MAX]);
    parts.push(format!("integrator = {}", author.call(Integrator, integrator, &[("max_depth", depth.to_string())])));
    let (samples, seed) = (author.dice.pick(&[1, 4, 1000, u32::MAX]), author.dice.pick(&[0, 1, 101, u32::MAX]));
    let all = [("samples", samples.to_string()), ("seed", seed.to_string())];
    let count = author.dice.pick(&[1, 2]);
    let sampler = author.dice.pick(&["independent", "sobol"]);
    parts.push(format!("sampler = {}", author.call(Sampler, sampler, &all[..count])));
    parts.join("\n")
}

fn camera(author: &mut Author) -> String {
    let far = author.dice.pick(&[10.0, 20.0, 1e3]);
    let mut eye = author.near(far);
    eye[1] = -far;
    let target = author.near(2.0);
    // Never along the way that it looks.
    let up = [author.dice.between(-3.0, 3.0), 0.0, 5.0];
    let mut all = vec![("eye", author.vector(&eye)), ("target", author.vector(&target))];
    if author.dice.chance(0.4) {
        all.push(("up", author.vector(&up)));
    }
    let angle = author.dice.pick(&[0.01, 1.0, 30.0, 45.0, 90.0, 120.0, 179.0]);
    let name = author.dice.pick(&["fov_x", "fov_y"]);
    all.push((name, format!("{angle}deg")));
    if author.dice.chance(0.4) {
        let near = author.dice.pick(&[1e-3, 0.01, 1.0]);
        all.push(("near", author.number(near)));
    }
    if author.dice.chance(0.4) {
        let far = author.dice.pick(&[50.0, 1e3, 1e6]);
        all.push(("far", author.number(far)));
    }
    author.call(Camera, "perspective", &all)
}

/// A statement, sometimes in a loop or a condition.
fn repeated(author: &mut Author, statement: String) -> String {
    match author.dice.at(12) {
        0 => format!("for i in 0..{} {{\n    {statement}\n}}", author.dice.at(3)),
        1 => format!("for (a, b) in [(1, 2), (3, 4)], c in [5] {{\n    {statement}\n}}"),
        2 => format!("if 1 < 2 {{\n    {statement}\n}} else {{\n    {statement}\n}}"),
        _ => statement,
    }
}

/// A material, and whether it shows an image.
fn surface(author: &mut Author, shelf: &Shelf) -> (String, bool) {
    if author.dice.chance(0.4) {
        let at = author.dice.at(shelf.materials.len());
        shelf.materials[at].clone()
    } else {
        let material = shapes::material(author);
        let painted = shapes::is_painted(&material);
        (material, painted)
    }
}

/// A mesh that what is laid on it may lie on.
fn form(author: &mut Author, shelf: &Shelf, painted: bool) -> String {
    loop {
        let (text, bears) = if shelf.meshes.is_empty() || author.dice.chance(0.6) {
            shapes::mesh(author)
        } else {
            let at = author.dice.at(shelf.meshes.len());
            let (name, bears) = shelf.meshes[at].clone();
            let stage = shapes::stage(author, true);
            (if author.dice.chance(0.3) { name } else { format!("{name} |> {stage}") }, bears)
        };
        if bears || !painted {
            return text;
        }
    }
}

fn shape(author: &mut Author, shelf: &Shelf) -> String {
    let (name, (surface, painted)) = (author.name("shape"), surface(author, shelf));
    format!("shape {name} = {} with {surface}", form(author, shelf, painted))
}

fn emitter(author: &mut Author, shelf: &Shelf) -> String {
    let (name, emission) = (author.name("lamp"), shapes::emission(author));
    format!("emitter {name} = {} with {emission}", form(author, shelf, shapes::is_painted(&emission)))
}

fn group(author: &mut Author, shelf: &Shelf) -> String {
    let mut parts = vec![shape(author, shelf)];
    for _ in 0..author.dice.at(3) {
        let statement = match author.dice.at(5) {
            0 => emitter(author, shelf),
            1 => light(author, false),
            2 => instance(author, shelf, false),
            _ => shape(author, shelf),
        };
        parts.push(repeated(author, statement));
    }
    format!("{{\n    {}\n}}", parts.join("\n    "))
}

/// A group in its place, at the top also in many.
fn instance(author: &mut Author, shelf: &Shelf, top: bool) -> String {
    let at = author.dice.at(shelf.groups.len());
    let mut text = format!("instance {} = {}", author.name("place"), shelf.groups[at]);
    for _ in 0..author.dice.pick(&[0, 1, 1, 2]) {
        let stage = shapes::stage(author, false);
        text = format!("{text} |> {stage}");
    }
    if top && author.dice.chance(0.2) {
        let path = author.dice.pick(PLACES);
        let scatter = author.call(Stage, "scatter", &[("path", format!("\"{path}\""))]);
        text = format!("{text} |> {scatter}");
        if author.dice.chance(0.3) {
            let stage = shapes::stage(author, false);
            text = format!("{text} |> {stage}");
        }
    }
    text
}

/// A light without a surface; one from far away stands at the top only.
fn light(author: &mut Author, top: bool) -> String {
    let name = author.name("light");
    let strength = author.dice.size(-7.0, 5.0);
    let strength = author.color(strength);
    let position = author.near(6.0);
    let made = match author.dice.at(if top { 3 } else { 2 }) {
        0 => {
            let position = author.vector(&position);
            author.call(Light, "point", &[("position", position), ("intensity", strength)])
        }
        1 => {
            let along = author.direction();
            let target = [0, 1, 2].map(|axis| position[axis] + along[axis]);
            let (position, target) = (author.vector(&position), author.vector(&target));
            let (angle, share) = (author.dice.pick(&[0.01, 1.0, 20.0, 45.0, 89.9, 90.0]), author.dice.share());
            let mut all = vec![("position", position), ("target", target), ("intensity", strength)];
            all.push(("angle", format!("{angle}deg")));
            if author.dice.chance(0.7) {
                let inner = author.dice.pick(&[0.0, 1.0, 0.5, share]) * angle;
                all.push(("inner", format!("{inner}deg")));
            }
            author.call(Light, "spot", &all)
        }
        _ => {
            let direction = author.direction();
            let direction = author.vector(&direction);
            author.call(Light, "directional", &[("direction", direction), ("irradiance", strength)])
        }
    };
    format!("emitter {name} = {made}")
}

fn environment(author: &mut Author) -> String {
    let name = author.name("sky");
    let scale = author.dice.size(-2.0, 2.0);
    // They take long: a target lays them on an octahedron.
    let image = author.dice.chance(0.05);
    let mut all = vec![if image {
        let path = author.dice.pick(SKIES);
        let bitmap = author.call(ltsc_core::eval::Family::Texture, "bitmap", &[("path", format!("\"{path}\""))]);
        ("radiance", bitmap)
    } else {
        ("radiance", author.within(0.0, 3.0))
    }];
    if author.dice.chance(0.4) {
        all.push(("scale", author.number(scale)));
    }
    if author.dice.chance(0.4) {
        let [r, g, b] = [0, 1, 2].map(|_| author.within(0.1, 1.0));
        all.push(("tint", if author.dice.chance(0.5) { r } else { format!("rgb({r}, {g}, {b})") }));
    }
    let mut text = author.call(Light, "environment", &all);
    if image && author.dice.chance(0.5) {
        let (axis, angle) = (author.dice.pick(&["x", "y", "z"]), author.angle(-180.0, 180.0));
        let turn = author.call(Stage, "rotate", &[(axis, angle)]);
        text = format!("{text} |> {turn}");
    }
    format!("emitter {name} = {text}")
}
