//! The header of a scene, and its settings.

use super::names::{Names, written};
use super::notes::Notes;
use super::number::{angle, direction, number, string, vector};
use crate::diag::Origin;
use crate::ir::{Camera, Documentation, Film, Filter, Integrator, LightPaths, Sampler, cross, length, normalized, sub};

/// The largest side of an image that the language has.
const LARGEST_SIDE: u32 = 65_536;

/// How wide lines of documentation are made.
const WIDTH: usize = 112;

/// Documentation and `scene NAME { ... }`.
pub(super) fn header(notes: &mut Notes, name: &str, documentation: &Documentation, at: &Origin) -> String {
    let Documentation { brief, full, paths, similar, comments, source, license, parameters } = documentation;
    let mut text = String::new();
    for line in lines(notes, brief, full, at) {
        text.push_str(if line.is_empty() { "///" } else { "/// " });
        text.push_str(&line);
        text.push('\n');
    }
    if !parameters.is_empty() {
        let names: Vec<String> = parameters.iter().map(|parameter| format!("`{}`", parameter.name)).collect();
        notes.dropped(at, format!("the parameters {} are left out: their values are written", names.join(", ")));
    }
    let mut fields = Vec::new();
    let good = paths.iter().filter(|path| {
        let good = LightPaths::parse(path).is_ok();
        if !good {
            notes.dropped(at, format!("`{}` is left out: it is no class of light paths", path.escape_debug()));
        }
        good
    });
    let paths: Vec<String> = good.map(|path| string(path)).collect();
    if !paths.is_empty() {
        fields.push(format!("paths: [{}]", paths.join(", ")));
    }
    if !similar.is_empty() {
        let pair = |similar: &crate::ir::Similar| format!("({}, {})", string(&similar.scene), string(&similar.reason));
        fields.push(format!("similar: [{}]", similar.iter().map(pair).collect::<Vec<_>>().join(", ")));
    }
    for (field, value) in [("comments", comments), ("source", source), ("license", license)] {
        if !value.is_empty() {
            fields.push(format!("{field}: {}", string(value)));
        }
    }
    let fields: String = fields.into_iter().map(|field| format!("    {field}\n")).collect();
    let name = written(name);
    text + &if fields.is_empty() { format!("scene {name} {{}}\n") } else { format!("scene {name} {{\n{fields}}}\n") }
}

/// The lines of the documentation.
fn lines(notes: &mut Notes, brief: &str, full: &str, at: &Origin) -> Vec<String> {
    let plain =
        |text: &str| -> String { text.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect() };
    let of_full = |lines: &mut Vec<String>| {
        if !full.is_empty() {
            // An empty line parts the two; behind no brief it is there already.
            if lines.last().is_none_or(|line| !line.is_empty()) {
                lines.push(String::new());
            }
            lines.extend(plain(full).split('\n').map(|line| line.trim_end().to_owned()));
        }
    };
    // A long line is parted at its single blanks, which join it again.
    let mut parted = Vec::new();
    for word in plain(brief).split([' ', '\n']) {
        match parted.last_mut() {
            Some(line) if String::len(line) + word.len() < WIDTH => {
                line.push(' ');
                line.push_str(word);
            }
            _ => parted.push(word.to_owned()),
        }
    }
    let whole = vec![plain(brief).replace('\n', " ")];
    let mut first = None;
    for mut way in [parted, whole] {
        of_full(&mut way);
        if way.iter().all(String::is_empty) {
            way.clear();
        }
        if read(&way) == (brief.to_owned(), full.to_owned()) {
            return way;
        }
        first.get_or_insert(way);
    }
    notes.changed(at, "the documentation is written in other lines: the first paragraph of a text is its brief");
    first.unwrap_or_default()
}

/// Brief and full text as evaluation reads them from lines.
fn read(lines: &[String]) -> (String, String) {
    let end = lines.iter().position(|line| line.trim().is_empty()).unwrap_or(lines.len());
    (lines[..end].join(" ").trim().to_owned(), lines[end..].join("\n").trim().to_owned())
}

/// `camera NAME = perspective(...)`, for each that can be written.
pub(super) fn cameras<'c>(
    notes: &mut Notes,
    cameras: impl ExactSizeIterator<Item = (&'c Origin, &'c Camera)>,
) -> String {
    let several = cameras.len() > 1;
    let mut names = Names::default();
    let mut text = String::new();
    for (at, camera) in cameras {
        let Some(call) = perspective(notes, camera, at) else { continue };
        let own = camera.name.as_deref();
        let name = match (own, several) {
            (None, false) => None,
            (Some(name), _) => Some((name, names.take(name))),
            (None, true) => Some(("", names.take("camera"))),
        };
        let name = name.map_or(String::new(), |(own, name)| {
            notes.named(at, "camera", own, &name);
            format!(" {}", written(&name))
        });
        text.push_str(&format!("camera{name} = {call}\n"));
    }
    if text.is_empty() {
        notes.dropped(&Origin::Made, "the scene has no camera that can be written: add one to the text");
    }
    text
}

fn perspective(notes: &mut Notes, camera: &Camera, at: &Origin) -> Option<String> {
    let Camera { name: _, eye, target, up, fov_x, near, far } = camera;
    let view = normalized(sub(*target, *eye));
    let upright = view.zip(normalized(*up)).is_some_and(|(view, up)| length(cross(view, up)) >= 1e-9);
    let finite = [eye, target, up].into_iter().flatten().all(|part| part.is_finite());
    if !(upright && finite && eye != target && *fov_x > 0.0 && *fov_x < 180.0) {
        notes.dropped(at, "a camera is left out: it looks nowhere, or its angle of view is none");
        return None;
    }
    let mut words = vec![format!("eye: {}", vector(eye)), format!("target: {}", vector(target))];
    if *up != [0.0, 0.0, 1.0] {
        words.push(format!("up: {}", direction(*up)));
    }
    words.push(format!("fov_x: {}", angle(*fov_x)));
    let mut distance = |label: &str, value: Option<f64>, least: f64| {
        let value = value?;
        if value > least && value.is_finite() {
            words.push(format!("{label}: {}", number(value)));
            return Some(value);
        }
        notes.dropped(at, format!("the {label} distance of a camera is left out: it is {value}"));
        None
    };
    let near = distance("near", *near, 0.0);
    distance("far", *far, near.unwrap_or(f64::NEG_INFINITY));
    Some(format!("perspective({})", words.join(", ")))
}

/// The film, the integrator and the sampler.
pub(super) fn settings(notes: &mut Notes, film: &Film, integrator: &Integrator, sampler: &Sampler) -> String {
    let at = &Origin::Made;
    let mut whole =
        |what: &str, value: u32, most: u32| number(notes.within(at, what, f64::from(value), 1.0, f64::from(most)));
    let Film { width, height, filter } = film;
    let (width, height) = (
        whole("the width of the image", *width, LARGEST_SIDE),
        whole("the height of the image", *height, LARGEST_SIDE),
    );
    let depth = whole("the depth of the integrator", integrator.max_depth(), u32::MAX);
    let samples = whole("the number of samples", sampler.samples(), u32::MAX);
    let mut radius = |value: f64| notes.within(at, "the size of the filter", value, f64::MIN_POSITIVE, f64::MAX);
    let filter = match filter {
        Filter::Box { radius: 0.5 } => String::new(),
        Filter::Box { radius: half } => format!(", filter: box(radius: {})", number(radius(*half))),
        Filter::Gaussian { stddev, radius: half } => {
            let (stddev, half) = (radius(*stddev), radius(*half));
            let half = if half == 4.0 * stddev { String::new() } else { format!(", radius: {}", number(half)) };
            format!(", filter: gaussian(stddev: {}{half})", number(stddev))
        }
    };
    let algorithm = match integrator {
        Integrator::Path { max_depth: _ }
        | Integrator::Bidirectional { max_depth: _ }
        | Integrator::LightTracing { max_depth: _ }
        | Integrator::Metropolis { max_depth: _ }
        | Integrator::PhotonMap { max_depth: _ } => integrator.word(),
    };
    let points = match sampler {
        Sampler::Independent { samples: _, seed: _ } | Sampler::Sobol { samples: _, seed: _ } => sampler.word(),
    };
    let seed = if sampler.seed() == 0 { String::new() } else { format!(", seed: {}", sampler.seed()) };
    format!(
        "film = image({width}, {height}{filter})\nintegrator = {algorithm}(max_depth: {depth})\nsampler = {points}(samples: \
         {samples}{seed})\n"
    )
}
