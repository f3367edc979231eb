//! Which classes of light paths the scenes of a project test together, and which no scene tests.

use crate::ir::{LightPaths, Scene};

/// How many surfaces a path meets at most.
const SURFACES: usize = 4;

/// The classes of paths with at most [`SURFACES`] surfaces: `LDE`, `LGE`, ..., `LSSSSE`.
fn classes() -> Vec<String> {
    let mut all = Vec::new();
    let mut last = vec![String::new()];
    for _ in 0..SURFACES {
        last = last.iter().flat_map(|start| ["D", "G", "S"].map(|letter| format!("{start}{letter}"))).collect();
        all.extend(last.iter().map(|surfaces| format!("L{surfaces}E")));
    }
    all
}

/// Whether `scene` names a class that holds `path` (`LDE`); a class of parts of paths holds every path with such a part.
fn tests(scene: &Scene, path: &str) -> bool {
    let word = path.trim_start_matches('L').trim_end_matches('E');
    let paths = scene.documentation.paths.iter().filter_map(|text| LightPaths::parse(text).ok());
    paths.into_iter().any(|class| class.holds(word))
}

/// The table of classes by scenes, and the classes without a scene.
pub fn coverage(scenes: &[&Scene]) -> String {
    let mut text = format!(
        "## Light paths\n\nWhich scene says that it tests which class of light paths, with up to {SURFACES} surfaces (D diffuse, G glossy, \
         S specular).\nA class such as `LS+DE` stands in every row that it holds; `SDS` is tested by every path with that part.\n\n"
    );
    let used: Vec<&&Scene> = scenes.iter().filter(|scene| !scene.documentation.paths.is_empty()).collect();
    let mut empty: Vec<String> = Vec::new();
    let mut rows = String::new();
    for class in classes() {
        let marks: Vec<bool> = used.iter().map(|scene| tests(scene, &class)).collect();
        if !marks.contains(&true) {
            empty.push(class);
            continue;
        }
        let cells: Vec<&str> = marks.iter().map(|mark| if *mark { "x" } else { " " }).collect();
        rows.push_str(&format!("| `{class}` | {} |\n", cells.join(" | ")));
    }
    if rows.is_empty() {
        text.push_str("No scene names a class of light paths.\n");
    } else {
        let names: Vec<String> = used.iter().map(|scene| format!("[{0}]({0}.md)", scene.name)).collect();
        text.push_str(&format!("| class | {} |\n|---{}|\n{rows}", names.join(" | "), "|---".repeat(names.len())));
    }
    text.push_str("\n### Classes without a scene\n\n");
    for surfaces in 1..=SURFACES {
        let of: Vec<String> =
            empty.iter().filter(|class| class.len() == surfaces + 2).map(|class| format!("`{class}`")).collect();
        let all = 3_usize.pow(surfaces as u32);
        let list = match of.len() {
            0 => "none".to_owned(),
            count if count == all && surfaces > 2 => "all".to_owned(),
            _ => of.join(", "),
        };
        text.push_str(&format!(
            "- With {surfaces} surface{}, {} of {all}: {list}\n",
            if surfaces == 1 { "" } else { "s" },
            of.len()
        ));
    }
    text
}
