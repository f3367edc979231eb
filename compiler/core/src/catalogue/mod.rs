//! The catalogue of scenes: what a reader wants to know of each before choosing one, as Markdown, with a diagram of where its
//! surfaces lie, and the table of what classes of light paths the scenes test together.
//!
//! It judges nothing and reads no files; pictures and what was measured on them are given to it.

mod coverage;
mod diagram;
mod edges;
mod numbers;
mod page;

#[cfg(test)]
mod tests;

pub use coverage::coverage;
pub use diagram::diagram;
pub use numbers::{Emitter, Numbers, instances};
pub use page::{index, page};

use crate::ir::Scene;

/// A scene of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'s> {
    /// The scene, before lowering: groups are what the author wrote.
    pub scene: &'s Scene,
    /// Renderings, where there are some.
    pub pictures: Option<&'s Pictures>,
}

/// Renderings of a scene by two renderers, and how they differ. Files lie in the folder `pictures` beside the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pictures {
    /// Each with its title and its file.
    pub shown: Vec<(String, String)>,
    /// Facts about them, each with its value: samples, ratio of the means.
    pub facts: Vec<(String, String)>,
}

/// Text within a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// A number as people read it: at most `digits` behind the point, no zeros at its end.
fn short(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A whole number with blanks between groups of three digits.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}
