//! The scenes of a project, for rules that compare them; indexed, so that a rule costs no look at every other scene.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{Documentation, LightPaths};

/// The documentation of a project's scenes by name. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Scenes(Arc<Index>);

#[derive(Debug, Default)]
struct Index {
    scenes: BTreeMap<String, Documentation>,
    /// Names of scenes by the classes of light paths that they test, sorted; none where a scene names no classes.
    by_paths: BTreeMap<BTreeSet<String>, Vec<String>>,
    /// For each name the scenes that call it similar.
    named_by: BTreeMap<String, BTreeSet<String>>,
}

impl From<BTreeMap<String, Documentation>> for Scenes {
    fn from(scenes: BTreeMap<String, Documentation>) -> Self {
        let mut index = Index::default();
        for (name, documentation) in &scenes {
            let classes = classes(documentation);
            if !classes.is_empty() {
                index.by_paths.entry(classes).or_default().push(name.clone());
            }
            for similar in &documentation.similar {
                index.named_by.entry(similar.scene.clone()).or_default().insert(name.clone());
            }
        }
        Self(Arc::new(Index { scenes, ..index }))
    }
}

impl std::ops::Deref for Scenes {
    type Target = BTreeMap<String, Documentation>;

    fn deref(&self) -> &Self::Target {
        &self.0.scenes
    }
}

impl Scenes {
    /// Of the scenes that test the same classes of light paths as the scene `name`, and of which neither calls the other similar,
    /// up to `most`, those next to it by name first; and how many there are.
    pub fn with_same_paths(&self, name: &str, own: &Documentation, most: usize) -> (Vec<&str>, usize) {
        let Some(alike) = self.0.by_paths.get(&classes(own)) else { return (Vec::new(), 0) };
        let here = alike.partition_point(|other| other.as_str() < name);
        let named = own.similar.iter().map(|similar| similar.scene.as_str());
        let naming = self.0.named_by.get(name).into_iter().flatten().map(String::as_str);
        let argued: BTreeSet<&str> = named.chain(naming).filter(|other| *other != name).collect();
        let itself = usize::from(alike.get(here).is_some_and(|other| other == name));
        let excused = argued.iter().filter(|other| alike.binary_search_by(|known| known.as_str().cmp(other)).is_ok());
        let count = alike.len() - itself - excused.count();
        let open = |other: &&str| !argued.contains(other);
        let mut after = alike[here + itself..].iter().map(String::as_str).filter(open);
        let mut before = alike[..here].iter().rev().map(String::as_str).filter(open);
        let mut near = Vec::new();
        while near.len() < most {
            let pair = [before.next(), after.next()];
            if pair == [None, None] {
                break;
            }
            near.extend(pair.into_iter().flatten());
        }
        near.truncate(most);
        near.sort_unstable();
        (near, count)
    }
}

/// The classes of a scene, in one spelling and without order.
fn classes(documentation: &Documentation) -> BTreeSet<String> {
    documentation.paths.iter().map(|text| LightPaths::canonical(text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Similar;

    #[test]
    fn scenes_with_the_same_paths_are_counted_and_the_next_ones_named() {
        let made = |at: usize, similar: &[&str]| {
            let similar = similar.iter().map(|name| Similar { scene: (*name).to_owned(), reason: "r".to_owned() });
            let documentation =
                Documentation { paths: vec!["LDE".to_owned()], similar: similar.collect(), ..Documentation::default() };
            (format!("s{at}"), documentation)
        };
        let all: BTreeMap<String, Documentation> =
            [made(0, &[]), made(1, &["s4"]), made(2, &[]), made(3, &[]), made(4, &[]), made(5, &["s3"])].into();
        let scenes = Scenes::from(all.clone());
        let near = |name: &str| scenes.with_same_paths(name, &all[name], 3);
        assert_eq!(near("s2"), (vec!["s0", "s1", "s3"], 5));
        assert_eq!(near("s3"), (vec!["s1", "s2", "s4"], 4), "s5 says why it stands beside it");
        assert_eq!(near("s4"), (vec!["s2", "s3", "s5"], 4), "so does s1");
        let none = Documentation::default();
        assert_eq!(scenes.with_same_paths("s9", &none, 3), (vec![], 0));
    }
}
