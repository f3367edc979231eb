//! The reference manual as Markdown, made from the tables that the compiler itself runs on: constructors, findings, rules,
//! capabilities. Only the chapter on statements and values is written by hand (`language.md`), and its examples are compiled
//! by a test.

mod findings;
mod measured;
mod reference;
mod targets;

#[cfg(test)]
mod tests;

pub use measured::{Measured, Proof};

/// A page of the manual.
pub struct Page {
    /// What people type: `reference`.
    pub name: &'static str,
    /// One line on what it holds.
    pub summary: &'static str,
    /// Its text in Markdown, given what was measured of the targets.
    pub text: fn(&Measured) -> String,
}

impl Page {
    /// The file of the page: `reference.md`.
    pub fn file(&self) -> String {
        format!("{}.md", self.name)
    }
}

/// All pages.
pub static PAGES: &[Page] = &[
    Page {
        name: "reference",
        summary: "The language: statements, values, every constructor",
        text: |_| reference::page(),
    },
    Page { name: "findings", summary: "What ltsc can say about a scene, and why", text: |_| findings::page() },
    Page {
        name: "targets",
        summary: "What each target supports, exactly or approximated, and how that was measured",
        text: targets::page,
    },
];

/// The page called `name`.
pub fn find(name: &str) -> Option<&'static Page> {
    PAGES.iter().find(|page| page.name == name)
}

/// What stands below the title of a page: how the page is made.
const MADE: &str = "*Written by `ltsc manual -o docs`; a test holds it against the program. Do not edit.*\n";

/// The link of a heading, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// Text within a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// The first letter as a capital.
fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}
