//! What targets do only where it is asked for, by `--option` or in `ltsc.toml`.

use std::collections::BTreeSet;
use std::fmt;

use super::{TARGETS, Target};
use crate::diag::nearest;

/// Something that a target does only where it is asked for.
pub struct Choice {
    /// The name people type behind that of the target: `instancing` in `gltf.instancing`.
    pub name: &'static str,
    /// What it does, for help texts.
    pub summary: &'static str,
}

/// What was asked for, of all targets.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choices(BTreeSet<(&'static str, &'static str)>);

/// A choice that there is not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChoiceError {
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: String,
}

impl fmt::Display for ChoiceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Choices {
    /// Adds what `text` asks for, written `TARGET.CHOICE`; the target by its name or an alias. Gives the target.
    ///
    /// # Errors
    /// There is no such target, or no such choice of it.
    pub fn add(&mut self, text: &str) -> Result<&'static Target, ChoiceError> {
        // Names of targets may hold dots themselves (`mitsuba-0.6`), those of choices never do.
        let found = text.rsplit_once('.').and_then(|(target, choice)| {
            let target = super::find(target.trim())?;
            Some((target, target.choices.iter().find(|known| known.name == choice.trim())?))
        });
        let Some((target, choice)) = found else {
            let known: Vec<String> = all().map(|(target, choice)| format!("{}.{}", target.name, choice.name)).collect();
            let help = match nearest(text, known.iter().map(String::as_str)) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("known: {}", known.join(", ")),
            };
            return Err(ChoiceError { message: format!("there is no option `{text}`"), help });
        };
        self.0.insert((target.name, choice.name));
        Ok(target)
    }

    /// Whether `choice` of `target` was asked for.
    pub fn has(&self, target: &str, choice: &str) -> bool {
        self.0.iter().any(|(of, name)| *of == target && *name == choice)
    }
}

/// All choices that targets have.
pub fn all() -> impl Iterator<Item = (&'static Target, &'static Choice)> {
    TARGETS.iter().flat_map(|target| target.choices.iter().map(move |choice| (target, choice)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_are_found_by_target_and_name() {
        let mut choices = Choices::default();
        assert!(!choices.has("glb", "instancing"));
        assert_eq!(choices.add("gltf-binary.instancing").map(|target| target.name), Ok("glb"));
        assert!(choices.has("glb", "instancing") && !choices.has("gltf", "instancing"));
        let error = |text: &str| Choices::default().add(text).map(|target| target.name).expect_err("no option");
        assert_eq!(error("gltf.instances").help, "did you mean `gltf.instancing`?");
        assert_eq!(error("x").message, "there is no option `x`");
        assert!(error("mitsuba-0.6.instancing").help.contains("gltf.instancing"));
        assert_eq!(error("").help, "known: gltf.instancing, glb.instancing");
    }
}
