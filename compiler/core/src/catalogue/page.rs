//! The page of a scene, and the page of all scenes.

use crate::ir::{Film, Filter, LightExtent, LightPaths, Scene};

use super::numbers::channels;
use super::{Emitter, Entry, Numbers, cell, coverage, grouped, short};

/// What stands below the title of a page: how it is made.
const MADE: &str = "*Written by `ltsc doc`; do not edit.*\n";

/// Emitters and materials that are listed at most.
const LISTED: usize = 24;

/// The page of a scene, with links to those of `names`.
pub fn page(entry: &Entry<'_>, names: &[&str]) -> String {
    let scene = entry.scene;
    let doc = &scene.documentation;
    let numbers = Numbers::of(scene);
    let mut text = format!("# {}\n\n{MADE}\n", scene.name);
    if !doc.brief.is_empty() {
        text.push_str(&format!("**{}**\n\n", doc.brief.replace('\n', " ")));
    }
    if !doc.full.is_empty() {
        text.push_str(&format!("{}\n\n", doc.full.trim()));
    }
    if !doc.comments.is_empty() {
        text.push_str(&format!("{}\n\n", doc.comments.trim()));
    }
    text.push_str(&similar(scene, names));
    for (word, value) in [("Source", &doc.source), ("License", &doc.license)] {
        if !value.is_empty() {
            text.push_str(&format!("{word}: {}\n\n", value.trim()));
        }
    }
    text.push_str(&pictures(entry));
    text.push_str(&format!(
        "## Layout\n\n![{0} from above and from the front](pictures/{0}.svg)\n\nOrange: what emits; blue: dielectrics; dashed: what the \
         camera sees, up to its target.\n\n",
        scene.name
    ));
    text.push_str(&paths(scene, &numbers));
    text.push_str(&table_of_numbers(&numbers));
    text.push_str(&lights(&numbers.emitters));
    text.push_str(&materials(&numbers));
    text.push_str(&parameters(scene));
    text.push_str(&settings(scene));
    text
}

/// What `--set` may change.
fn parameters(scene: &Scene) -> String {
    let all = &scene.documentation.parameters;
    if all.is_empty() {
        return String::new();
    }
    let mut text =
        "## Parameters\n\nChanged by `--set NAME=VALUE`; this page shows the scene with these values.\n\n".to_owned();
    text.push_str("| name | value | allowed | type |\n|---|---|---|---|\n");
    for one in all {
        let allowed = if one.allowed.is_empty() { "-".to_owned() } else { format!("`{}`", cell(&one.allowed)) };
        text.push_str(&format!("| `{}` | `{}` | {allowed} | {} |\n", one.name, cell(&one.value), one.ty));
    }
    text.push('\n');
    text
}

fn similar(scene: &Scene, names: &[&str]) -> String {
    let rows = scene.documentation.similar.iter();
    let lines: String = rows
        .map(|other| {
            let name = &other.scene;
            let name =
                if names.contains(&name.as_str()) { format!("[{name}]({name}.md)") } else { format!("`{name}`") };
            format!("- {name}: {}\n", other.reason)
        })
        .collect();
    if lines.is_empty() { lines } else { format!("Similar scenes, and why both are kept:\n\n{lines}\n") }
}

fn pictures(entry: &Entry<'_>) -> String {
    let Some(pictures) = entry.pictures.filter(|pictures| !pictures.shown.is_empty()) else {
        return "## Pictures\n\nNot rendered: `ltsc doc --render` does it, where Mitsuba 3 or LuxCore is installed.\n\n".to_owned();
    };
    let titles: Vec<&str> = pictures.shown.iter().map(|(title, _)| title.as_str()).collect();
    let files: Vec<String> =
        pictures.shown.iter().map(|(title, file)| format!("![{title}](pictures/{file})")).collect();
    let mut text = format!(
        "## Pictures\n\n| {} |\n|{}\n| {} |\n\n",
        titles.join(" | "),
        "---|".repeat(titles.len()),
        files.join(" | ")
    );
    for (what, value) in &pictures.facts {
        text.push_str(&format!("- {what}: {value}\n"));
    }
    text.push('\n');
    text
}

fn paths(scene: &Scene, numbers: &Numbers) -> String {
    let paths = &scene.documentation.paths;
    if paths.is_empty() {
        return "## Light paths\n\nThe scene does not say which classes of light paths it tests.\n\n".to_owned();
    }
    let mut text = "## Light paths\n\n| class | full form | found by local sampling |\n|---|---|---|\n".to_owned();
    for path in paths {
        let Ok(class) = LightPaths::parse(path) else { continue };
        let kinds: &[LightExtent] = if numbers.extents.is_empty() { &[LightExtent::Area] } else { &numbers.extents };
        let mut forms: Vec<String> = kinds.iter().map(|kind| format!("`{}`", class.full_form(path, *kind))).collect();
        forms.dedup();
        let found = kinds.iter().all(|kind| class.is_found_by_local_sampling(*kind));
        let found = match (class.is_whole(), found) {
            (false, _) => "a part of paths",
            (true, true) => "yes",
            (true, false) => "not every path",
        };
        text.push_str(&format!("| `{}` | {} | {found} |\n", cell(path), cell(&forms.join(", "))));
    }
    text.push('\n');
    text
}

fn table_of_numbers(numbers: &Numbers) -> String {
    let mut rows = vec![("triangles", grouped(numbers.triangles))];
    if numbers.placed_triangles != numbers.triangles {
        rows.push(("triangles, meshes as often as they are used", grouped(numbers.placed_triangles)));
    }
    rows.push(("meshes", grouped(numbers.meshes)));
    rows.push(("shapes", grouped(numbers.shapes)));
    if numbers.instances > 0 {
        rows.push(("groups", grouped(numbers.groups)));
        rows.push(("instances", grouped(numbers.instances)));
        rows.push(("uses of shapes, groups multiplied out", grouped(numbers.placed)));
    }
    rows.push(("lights", grouped(numbers.lights())));
    rows.push(("materials", grouped(numbers.materials.len() as u64)));
    if let Some(bounds) = numbers.bounds {
        let of = |corner: [f64; 3]| corner.map(|x| short(x, 3)).join(", ");
        rows.push(("extent", format!("({}) to ({})", of(bounds.low), of(bounds.high))));
        rows.push(("sides", bounds.size().map(|x| short(x, 3)).join(" x ")));
    }
    let lines: String = rows.iter().map(|(what, value)| format!("| {what} | {value} |\n")).collect();
    let cut = if numbers.cut { "\nThe scene is larger than what is counted here.\n" } else { "" };
    format!("## Numbers\n\n| | |\n|---|---|\n{lines}{cut}\n")
}

fn lights(emitters: &[Emitter]) -> String {
    if emitters.is_empty() {
        return String::new();
    }
    let mut text =
        "## Lights\n\n| light | count | what | strength | area | power in W |\n|---|---|---|---|---|---|\n".to_owned();
    for Emitter { name, count, kind, strength: (low, high), area, power } in emitters.iter().take(LISTED) {
        let unit = match *kind {
            "surface" | "environment" => "W/(m2 sr)",
            "directional" => "W/m2",
            _ => "W/sr",
        };
        let strength = if low == high { channels(*low) } else { format!("{} to {}", channels(*low), channels(*high)) };
        let area = if *area > 0.0 { short(*area, 3) } else { String::new() };
        let power = power.map_or(String::new(), |power| channels(power.map(significant)));
        text.push_str(&format!("| `{name}` | {} | {kind} | {strength} {unit} | {area} | {power} |\n", grouped(*count)));
    }
    more(&mut text, emitters.len());
    text.push_str("\nArea and power are those of all lights of the row, one unit of length taken as a meter; power is pi times radiance times \
                   area of surfaces.\n\n");
    text
}

/// Four significant digits.
fn significant(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn materials(numbers: &Numbers) -> String {
    if numbers.materials.is_empty() {
        return String::new();
    }
    let mut text = "## Materials\n\n| material | what | shapes |\n|---|---|---|\n".to_owned();
    for (name, words, uses) in numbers.materials.iter().take(LISTED) {
        text.push_str(&format!("| `{}` | `{}` | {} |\n", cell(name), cell(words), grouped(*uses)));
    }
    more(&mut text, numbers.materials.len());
    text.push('\n');
    text
}

fn more(text: &mut String, count: usize) {
    if count > LISTED {
        text.push_str(&format!("\nAnd {} more.\n", count - LISTED));
    }
}

fn settings(scene: &Scene) -> String {
    let Film { width, height, filter } = &scene.film;
    let filter = match filter {
        Filter::Box { radius } => format!("box(radius: {radius})"),
        Filter::Gaussian { stddev, radius } => format!("gaussian(stddev: {stddev}, radius: {radius})"),
    };
    let mut text = format!(
        "## Settings\n\n| | |\n|---|---|\n| image | {width} x {height}, `{filter}` |\n| integrator | `{}(max_depth: {})` |\n| samples | {} per \
         pixel |\n",
        scene.integrator.word(),
        scene.integrator.max_depth(),
        grouped(scene.sampler.samples().into())
    );
    for camera in scene.cameras.values() {
        let name = camera.name.as_ref().map_or(String::new(), |name| format!(" `{name}`"));
        let of = |point: [f64; 3]| point.map(|x| short(x, 3)).join(", ");
        text.push_str(&format!(
            "| camera{name} | from ({}) to ({}), {} degrees wide |\n",
            of(camera.eye),
            of(camera.target),
            short(camera.fov_x, 3)
        ));
    }
    text
}

/// The page of all scenes.
pub fn index(entries: &[Entry<'_>]) -> String {
    let mut text = format!(
        "# Scenes\n\n{MADE}\n| scene | | what it tests | triangles | instances | lights | light paths |\n|---|---|---|---|---|---|---|\n"
    );
    for entry in entries {
        let scene = entry.scene;
        let numbers = Numbers::of(scene);
        let picture = entry
            .pictures
            .and_then(|pictures| pictures.shown.first())
            .map_or(String::new(), |(title, file)| format!("![{}, {title}](pictures/{file})", scene.name));
        let paths: Vec<String> = scene.documentation.paths.iter().map(|path| format!("`{}`", cell(path))).collect();
        text.push_str(&format!(
            "| [{0}]({0}.md) | {picture} | {1} | {2} | {3} | {4} | {5} |\n",
            scene.name,
            cell(&scene.documentation.brief),
            grouped(numbers.placed_triangles),
            grouped(numbers.instances),
            grouped(numbers.lights()),
            paths.join(", ")
        ));
    }
    let scenes: Vec<&Scene> = entries.iter().map(|entry| entry.scene).collect();
    format!("{text}\n{}", coverage(&scenes))
}
