//! Names that are unique and safe in every target, made from names that need be neither.

use std::collections::{BTreeMap, BTreeSet};

/// The longest name that is made, in bytes: leaves room for a number and an ending in 255-byte file names.
const LONGEST: usize = 100;

/// Hands out unique words `[A-Za-z_][A-Za-z0-9_]*`: valid as an XML id (Mitsuba), within quotes (PBRT) and as one part
/// of a LuxCore property key, which must hold no dot.
#[derive(Debug, Default)]
pub struct Words {
    taken: BTreeSet<String>,
    next: BTreeMap<String, u32>,
    fold_case: bool,
}

impl Words {
    /// One word for each name, in the same order; the same names give the same words. A name that is a free word
    /// already is kept unless an earlier name is equal to it.
    pub fn assign<'a>(&mut self, names: impl Iterator<Item = &'a str>) -> Vec<String> {
        self.assign_by(names, is_word, word)
    }

    fn assign_by<'a>(
        &mut self,
        names: impl Iterator<Item = &'a str>,
        keeps: fn(&str) -> bool,
        make: fn(&str) -> String,
    ) -> Vec<String> {
        // Names that can stay as they are come first, so that a made-up name never takes theirs.
        let names: Vec<&str> = names.collect();
        let keep = |name: &&str| {
            let keep = keeps(name) && self.taken.insert(self.key(name));
            keep.then(|| (*name).to_owned())
        };
        let mut found: Vec<Option<String>> = names.iter().map(keep).collect();
        for (place, name) in found.iter_mut().zip(names) {
            if place.is_none() {
                *place = Some(self.free(make(name)));
            }
        }
        found.into_iter().flatten().collect()
    }

    fn free(&mut self, base: String) -> String {
        if self.taken.insert(self.key(&base)) {
            return base;
        }
        let key = self.key(&base);
        loop {
            let number = self.next.entry(key.clone()).or_insert(1);
            *number = number.saturating_add(1);
            let name = format!("{base}_{number}");
            if self.taken.insert(self.key(&name)) {
                return name;
            }
        }
    }

    fn key(&self, name: &str) -> String {
        if self.fold_case { name.to_ascii_lowercase() } else { name.to_owned() }
    }
}

/// A file name without ending for each name, in the same order: `[A-Za-z_][A-Za-z0-9_-]*`, unique also where upper
/// and lower case are one, and none of the names that Windows reserves. rs_pbrt 0.9.12 reads only mesh file names of
/// letters, digits and `_+.-/` that start with a letter or `_`.
pub fn file_stems<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut words = Words { fold_case: true, ..Words::default() };
    words.assign_by(names, is_stem, stem)
}

/// The file name without ending for a single name.
pub fn file_stem(name: &str) -> String {
    if is_stem(name) { name.to_owned() } else { stem(name) }
}

fn is_word(name: &str) -> bool {
    name.len() <= LONGEST && starts_well(name) && name.bytes().all(is_word_byte)
}

fn is_stem(name: &str) -> bool {
    let plain = name.bytes().all(|byte| is_word_byte(byte) || byte == b'-');
    name.len() <= LONGEST && starts_well(name) && plain && !is_reserved(name)
}

fn starts_well(name: &str) -> bool {
    name.bytes().next().is_some_and(|byte| byte == b'_' || byte.is_ascii_alphabetic())
}

fn is_word_byte(byte: u8) -> bool {
    byte == b'_' || byte.is_ascii_alphanumeric()
}

/// Device names that Windows gives no file, whatever the ending ("Naming Files, Paths, and Namespaces").
fn is_reserved(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let numbered = name.strip_prefix("com").or_else(|| name.strip_prefix("lpt"));
    let digit = |rest: &str| rest.len() == 1 && rest.bytes().all(|byte| byte.is_ascii_digit());
    ["con", "prn", "aux", "nul", "conin", "conout"].contains(&name.as_str()) || numbered.is_some_and(digit)
}

fn word(name: &str) -> String {
    simplified(name, is_word_byte)
}

fn stem(name: &str) -> String {
    let mut made = simplified(name, |byte| is_word_byte(byte) || byte == b'-');
    if is_reserved(&made) {
        made.push('_');
    }
    made
}

/// Runs of other characters become one `_`.
fn simplified(name: &str, keeps: impl Fn(u8) -> bool) -> String {
    let mut made = String::new();
    for character in name.chars() {
        match u8::try_from(character) {
            Ok(byte) if keeps(byte) => made.push(character),
            Ok(_) | Err(_) if made.ends_with('_') => {}
            Ok(_) | Err(_) => made.push('_'),
        }
        if made.len() >= LONGEST {
            break;
        }
    }
    // What stands for closing brackets and the like helps nobody.
    let kept = made.trim_end_matches('_').len();
    made.truncate(if kept > 0 { kept } else { 1 });
    if !starts_well(&made) {
        made.insert(0, '_');
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn words(names: &[&str]) -> Vec<String> {
        Words::default().assign(names.iter().copied())
    }

    #[test]
    fn good_names_stay_and_bad_ones_step_aside() {
        assert_eq!(words(&["a b", "a_b", "a b", "", "7"]), ["a_b_2", "a_b", "a_b_3", "_", "_7"]);
        assert_eq!(words(&["Wall", "wall", "Wall"]), ["Wall", "wall", "Wall_2"]);
        assert_eq!(words(&["x", "x_2", "x"]), ["x", "x_2", "x_3"]);
        assert_eq!(words(&["Wände/größe", "lamp (2)", "!?"]), ["W_nde_gr_e", "lamp_2", "_"]);
    }

    #[test]
    fn file_stems_hold_on_every_file_system() {
        let stems = |names: &[&str]| file_stems(names.iter().copied());
        assert_eq!(
            stems(&["Wall", "wall", "../x", "con", "COM1", "a-b"]),
            ["Wall", "wall_2", "_x", "con_", "COM1_", "a-b"]
        );
        assert_eq!(file_stem("veach_mis"), "veach_mis");
        assert_eq!(file_stem("2 + 2"), "_2_2");
    }

    #[test]
    fn many_equal_names_take_linear_time() {
        let made = Words::default().assign(std::iter::repeat_n("box", 20_000));
        assert_eq!(made[19_999], "box_20000");
    }

    proptest! {
        #[test]
        fn names_are_valid_and_unique(
            names in prop::collection::vec(prop_oneof![".*", "[a-cA-C_1-2 ]{0,3}", "(?i)con|nul|lpt3"], 0..40)
        ) {
            let all = || names.iter().map(String::as_str);
            let words = Words::default().assign(all());
            prop_assert_eq!(words.len(), names.len());
            prop_assert_eq!(&words, &Words::default().assign(all()));
            prop_assert_eq!(words.iter().collect::<BTreeSet<_>>().len(), words.len());
            for word in &words {
                prop_assert!(starts_well(word) && word.bytes().all(is_word_byte) && word.len() < 120);
            }
            let stems = file_stems(all());
            prop_assert_eq!(stems.len(), names.len());
            let folded: BTreeSet<String> = stems.iter().map(|stem| stem.to_ascii_lowercase()).collect();
            prop_assert_eq!(folded.len(), stems.len());
            for stem in &stems {
                prop_assert!(starts_well(stem) && !is_reserved(stem) && stem.len() < 120);
                prop_assert!(stem.bytes().all(|byte| is_word_byte(byte) || byte == b'-'));
            }
        }
    }
}
