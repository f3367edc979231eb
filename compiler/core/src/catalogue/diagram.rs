//! A line drawing of a scene from above and from the front, as SVG.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use crate::ir::{Bsdf, Camera, Scene, Vec3};
use crate::survey::{Bounds, Placed, Survey};

use super::edges::{Edge, LIMIT, edges};
use super::short;

/// Pixels along the longer side of a view.
const SIDE: f64 = 360.0;

/// Pixels round and between the views.
const MARGIN: f64 = 24.0;

/// Pixels that the words below a view need.
const WORDS: f64 = 200.0;

/// Lines that one view holds at most; a scene with more is drawn in boxes.
const LINES: usize = 9_000;

/// Tenths of a pixel: where lines begin and end on the same of these they are one.
const GRID: f64 = 2.0;

/// A projection along an axis.
struct View {
    title: &'static str,
    /// The axes to the right and up, and the sign of up in the picture.
    across: usize,
    up: usize,
    /// The direction of sight.
    direction: Vec3,
}

const VIEWS: [View; 2] = [
    View { title: "from above", across: 0, up: 1, direction: [0.0, 0.0, -1.0] },
    View { title: "from the front", across: 0, up: 2, direction: [0.0, 1.0, 0.0] },
];

/// What lines are drawn in.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Ink {
    Surface,
    Clear,
    Light,
}

impl Ink {
    fn of(scene: &Scene, placed: &Placed<'_>) -> Self {
        if placed.shape.emission.is_some() {
            return Self::Light;
        }
        match scene.materials[placed.shape.material].bsdf {
            Bsdf::Dielectric { interior: _, exterior: _, alpha: _ } => Self::Clear,
            Bsdf::Plastic { reflectance: _, ior: _, alpha: _ }
            | Bsdf::Principled { base: _, metallic: _, roughness: _, ior: _ }
            | Bsdf::Diffuse { reflectance: _ }
            | Bsdf::Conductor { eta: _, k: _, alpha: _ }
            | Bsdf::Mirror { reflectance: _ } => Self::Surface,
        }
    }

    fn style(self) -> &'static str {
        match self {
            Self::Surface => "stroke=\"#667\" stroke-width=\"0.6\"",
            Self::Clear => "stroke=\"#27c\" stroke-width=\"0.8\"",
            Self::Light => "stroke=\"#d70\" stroke-width=\"1.6\"",
        }
    }
}

type Lines = BTreeMap<Ink, BTreeSet<[i32; 4]>>;

/// The drawing; none for a scene without surfaces.
pub fn diagram(scene: &Scene) -> Option<String> {
    let survey = Survey::of(scene);
    let bounds = survey.bounds?;
    let camera = scene.cameras.values().next();
    // The camera belongs to the picture unless it is far away from everything.
    let frame = camera.map_or(bounds, |camera| bounds.union(Bounds { low: camera.eye, high: camera.eye }));
    let frame = if frame.diagonal() > 6.0 * bounds.diagonal() { bounds } else { frame };
    let longest = frame.size().into_iter().fold(0.0_f64, f64::max).max(1e-9);
    let scale = SIDE / longest;
    let meshes: Vec<Option<Vec<Edge>>> =
        scene.meshes.values().map(|mesh| if mesh.triangles.len() > LIMIT { None } else { Some(edges(mesh)) }).collect();
    let size = frame.size();
    let height = |view: &View| size[view.up] * scale;
    let tallest = VIEWS.iter().map(height).fold(0.0_f64, f64::max);
    let width = (size[0] * scale).max(WORDS);
    let total = (2.0 * width + 3.0 * MARGIN, tallest + 2.0 * MARGIN + 14.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" font-family=\"sans-serif\" \
         font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        short(total.0.ceil(), 0),
        short(total.1.ceil(), 0)
    );
    for (at, view) in VIEWS.iter().enumerate() {
        let left = MARGIN + at as f64 * (width + MARGIN);
        let place = |point: Vec3| {
            let x = left + (point[view.across] - frame.low[view.across]) * scale;
            let y = MARGIN + tallest - (point[view.up] - frame.low[view.up]) * scale;
            [x, y]
        };
        let lines = lines(&survey, &meshes, view, &place);
        let _written = writeln!(svg, "<g fill=\"none\" stroke-linecap=\"round\">");
        for (ink, lines) in &lines {
            let _written = writeln!(svg, "<path {} d=\"{}\"/>", ink.style(), data(lines));
        }
        if let Some(camera) = camera {
            svg.push_str(&sight(camera, f64::from(scene.film.height) / f64::from(scene.film.width), &place));
        }
        let _written = writeln!(svg, "</g>");
        let axes = ["x", "y", "z"];
        let _written = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" fill=\"#333\">{}: {} to the right, {} up</text>",
            short(left, 1),
            short(total.1 - 8.0, 1),
            view.title,
            axes[view.across],
            axes[view.up]
        );
    }
    svg.push_str("</svg>\n");
    Some(svg)
}

/// The lines of a view.
fn lines(survey: &Survey<'_>, meshes: &[Option<Vec<Edge>>], view: &View, place: &dyn Fn(Vec3) -> [f64; 2]) -> Lines {
    let mut lines = Lines::new();
    let mut count = 0;
    for placed in &survey.placed {
        let ink = Ink::of(survey.scene, placed);
        let Some(edges) = meshes.get(placed.shape.mesh.index()).and_then(Option::as_ref) else {
            count += outline(&mut lines, ink, placed.bounds, place);
            continue;
        };
        let normals = placed.transform.cofactors();
        for edge in edges {
            if let Some(ends) = edge.seen(&placed.transform, &normals, view.direction) {
                count += draw(&mut lines, ink, ends, place);
            }
        }
        if count > LINES {
            // Too many lines are a grey surface: boxes say more.
            let mut boxes = Lines::new();
            for placed in &survey.placed {
                outline(&mut boxes, Ink::of(survey.scene, placed), placed.bounds, place);
            }
            return boxes;
        }
    }
    lines
}

/// Adds a line, and says whether it is a new one.
fn draw(lines: &mut Lines, ink: Ink, ends: [Vec3; 2], place: &dyn Fn(Vec3) -> [f64; 2]) -> usize {
    let on_grid = |point: Vec3| place(point).map(|x| (x * GRID).round() as i32);
    let (a, b) = (on_grid(ends[0]), on_grid(ends[1]));
    if a == b {
        return 0;
    }
    let (a, b) = if a < b { (a, b) } else { (b, a) };
    usize::from(lines.entry(ink).or_default().insert([a[0], a[1], b[0], b[1]]))
}

/// The four sides of a box as a view shows it.
fn outline(lines: &mut Lines, ink: Ink, bounds: Bounds, place: &dyn Fn(Vec3) -> [f64; 2]) -> usize {
    let (low, high) =
        (place(bounds.low).map(|x| (x * GRID).round() as i32), place(bounds.high).map(|x| (x * GRID).round() as i32));
    let ([x0, y0], [x1, y1]) = (low, high);
    let sides = [[x0, y0, x1, y0], [x0, y0, x0, y1], [x0, y1, x1, y1], [x1, y0, x1, y1]];
    let set = lines.entry(ink).or_default();
    sides
        .into_iter()
        .filter(|[a, b, c, d]| (a, b) != (c, d))
        .map(|[a, b, c, d]| {
            let (from, to) = if (a, b) < (c, d) { ([a, b], [c, d]) } else { ([c, d], [a, b]) };
            usize::from(set.insert([from[0], from[1], to[0], to[1]]))
        })
        .sum()
}

/// The data of a path: lines that begin where the last one ended go on from there.
fn data(lines: &BTreeSet<[i32; 4]>) -> String {
    let mut text = String::new();
    let mut pen = None;
    let number = |value: i32| short(f64::from(value) / GRID, 1);
    for [x0, y0, x1, y1] in lines {
        if pen != Some([*x0, *y0]) {
            let _written = write!(text, "M{} {}", number(*x0), number(*y0));
        }
        if y0 == y1 {
            let _written = write!(text, "H{}", number(*x1));
        } else if x0 == x1 {
            let _written = write!(text, "V{}", number(*y1));
        } else {
            let _written = write!(text, "L{} {}", number(*x1), number(*y1));
        }
        pen = Some([*x1, *y1]);
    }
    text
}

/// The camera's place and the sides of what it sees, up to its target.
fn sight(camera: &Camera, aspect: f64, place: &dyn Fn(Vec3) -> [f64; 2]) -> String {
    let Some(axes) = camera.axes() else { return String::new() };
    let reach = crate::ir::length(crate::ir::sub(camera.target, camera.eye));
    let half = libm::tan(camera.fov_x.to_radians() / 2.0);
    let to = |side: f64, up: f64| {
        [0, 1, 2].map(|axis: usize| {
            camera.eye[axis]
                + reach * (axes.forward[axis] + half * (side * axes.right[axis] + up * aspect * axes.up[axis]))
        })
    };
    let at = |point: Vec3| {
        let [x, y] = place(point);
        format!("{} {}", short(x, 1), short(y, 1))
    };
    let [x, y] = place(camera.eye);
    let corners = [to(-1.0, -1.0), to(1.0, -1.0), to(1.0, 1.0), to(-1.0, 1.0)];
    let rays: Vec<String> = corners.iter().map(|corner| format!("M{}L{}", at(camera.eye), at(*corner))).collect();
    format!(
        "<path stroke=\"#a2a\" stroke-width=\"0.5\" stroke-dasharray=\"3 3\" d=\"{}\"/>\n<circle cx=\"{}\" cy=\"{}\" r=\"3\" \
         fill=\"#a2a\"/>\n",
        rays.concat(),
        short(x, 1),
        short(y, 1)
    )
}
