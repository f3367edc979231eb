//! How near two scenes are: by the light paths that they test, by their materials, and by what their briefs say.
//!
//! A suite has few scenes, each for a purpose of its own (Tázlar 2020, section 5.1). Before a scene joins it, the near ones are looked
//! at: where there are none it joins, and where there are some it says why it stands beside them, or takes the place of one.
//!
//! Weights and bounds were chosen by the eleven scenes of the `lteval` suite, see [`NEAR`] and [`VERY_NEAR`].

use std::collections::{BTreeMap, BTreeSet};

use crate::ir::{LightPaths, Scene};

/// Weight of the light paths: they are what a scene tests.
const PATHS: f64 = 0.5;

/// Weight of the materials.
const MATERIALS: f64 = 0.25;

/// Weight of the brief.
const BRIEF: f64 = 0.25;

/// From this score on two scenes are near. Of the eleven scenes' 55 pairs, 11 name each other in `similar`; 8 of them score 0.53 and
/// more, and of the others none more than 0.48.
pub const NEAR: f64 = 0.5;

/// Two scenes whose briefs are this near are near, whatever the rest says: the diffuse and the glossy form of one scene share no light
/// path. Of the eleven scenes' pairs, 2 more that name each other (0.72 and 0.75); of the others none more than 0.53.
pub const NEAR_BRIEF: f64 = 0.6;

/// From this score on one of two scenes may be enough. Of the eleven scenes only the pairs that differ by nothing but the radiance
/// of their lights (0.95); the next ones, a room with and without boxes, score 0.80.
pub const VERY_NEAR: f64 = 0.9;

/// Vertices between light and eye of the longest paths that are compared.
const LONGEST: usize = 5;

/// What scenes are compared by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Profile {
    /// The scene's name.
    pub name: String,
    /// Classes of light paths that it tests, as written.
    pub paths: Vec<String>,
    /// Kinds of scattering of its surfaces.
    pub materials: BTreeSet<&'static str>,
    /// What it tests, in a sentence.
    pub brief: String,
}

impl Profile {
    /// That of `scene`.
    pub fn of(scene: &Scene) -> Self {
        let surfaces = scene.surfaces().filter(|(_, shape)| shape.emission.is_none());
        Self {
            name: scene.name.clone(),
            paths: scene.documentation.paths.clone(),
            materials: surfaces.map(|(_, shape)| scene.materials[shape.material].bsdf.kind()).collect(),
            brief: scene.documentation.brief.clone(),
        }
    }
}

/// What follows from a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Nearness {
    /// Nothing.
    Far,
    /// The scene should say why it stands beside the other.
    Near,
    /// One of them may be enough.
    VeryNear,
}

/// How near a scene is to another one. Measures lie between 0 and 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Near {
    /// The other scene.
    pub name: String,
    /// The weighted mean of the measures that there are.
    pub score: f64,
    /// Light paths that both test, as a share of those that one of them tests; a path of n vertices weighs 2^-n, as grey surfaces would
    /// weigh it. None where a scene names no paths.
    pub paths: Option<f64>,
    /// Kinds of scattering that both have, as a share of those that one of them has. None where neither has a surface.
    pub materials: Option<f64>,
    /// Cosine of the words of the briefs, where a word weighs the more the fewer scenes have it. None where a scene has no brief.
    pub brief: Option<f64>,
    /// What follows.
    pub nearness: Nearness,
}

/// How near `own` is to each of `others`, the nearest first, and by name where two are as near.
pub fn rank(own: &Profile, others: &[Profile]) -> Vec<Near> {
    let words: Vec<Vec<String>> = others.iter().chain([own]).map(|profile| words_of(&profile.brief)).collect();
    let vectors = vectors(&words);
    let own_paths = paths_of(&own.paths);
    let mut ranked: Vec<Near> = others
        .iter()
        .zip(&vectors)
        .map(|(other, vector)| {
            let theirs = paths_of(&other.paths);
            let paths =
                own_paths.as_ref().zip(theirs.as_ref()).and_then(|(a, b)| shared(a, b, |path| path_weight(path)));
            let materials = shared(&own.materials, &other.materials, |_| 1.0);
            let brief = vectors.last().zip(Some(vector)).and_then(|(a, b)| cosine(a, b));
            let score = mean(&[(PATHS, paths), (MATERIALS, materials), (BRIEF, brief)]);
            let nearness = if score >= VERY_NEAR {
                Nearness::VeryNear
            } else if score >= NEAR || brief.is_some_and(|brief| brief >= NEAR_BRIEF) {
                Nearness::Near
            } else {
                Nearness::Far
            };
            Near { name: other.name.clone(), score, paths, materials, brief, nearness }
        })
        .collect();
    ranked.sort_by(|a, b| {
        b.nearness.cmp(&a.nearness).then(b.score.total_cmp(&a.score)).then_with(|| a.name.cmp(&b.name))
    });
    ranked
}

/// The weighted mean of what there is; 0 where there is nothing.
fn mean(parts: &[(f64, Option<f64>)]) -> f64 {
    let there = parts.iter().filter_map(|(weight, value)| Some((weight, (*value)?)));
    let (weights, sum) =
        there.fold((0.0, 0.0), |(weights, sum), (weight, value)| (weights + weight, sum + weight * value));
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// The weight of what both have as a share of what either has.
fn shared<T: Ord>(a: &BTreeSet<T>, b: &BTreeSet<T>, of: impl Fn(&T) -> f64) -> Option<f64> {
    let sum = |weight: f64, item: &T| weight + of(item);
    let all = a.union(b).fold(0.0, sum);
    let both = a.intersection(b).fold(0.0, sum);
    (all > 0.0).then(|| both / all)
}

/// The paths of classes, without light and eye; none where there are no classes, or only ones of longer paths.
fn paths_of(classes: &[String]) -> Option<BTreeSet<String>> {
    let classes = classes.iter().filter_map(|text| LightPaths::parse(text).ok());
    let paths: BTreeSet<String> = classes.flat_map(|class| class.paths(LONGEST)).collect();
    (!paths.is_empty()).then_some(paths)
}

fn path_weight(path: &str) -> f64 {
    path.chars().fold(1.0, |weight, _| weight * 0.5)
}

/// Words of a text in small letters, without the `s` of plurals.
fn words_of(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let plain = |word: &str| {
        let word = word.to_lowercase();
        match word.strip_suffix('s') {
            Some(single) if single.chars().count() > 2 && !single.ends_with('s') => single.to_owned(),
            _ => word,
        }
    };
    words.map(plain).collect()
}

/// For each text its words with their weights: how often it has the word, times the logarithm of how rare the word is (tf-idf).
fn vectors(texts: &[Vec<String>]) -> Vec<BTreeMap<&str, f64>> {
    let mut texts_with: BTreeMap<&str, usize> = BTreeMap::new();
    for text in texts {
        for word in text.iter().map(String::as_str).collect::<BTreeSet<&str>>() {
            *texts_with.entry(word).or_default() += 1;
        }
    }
    let all = texts.len() as f64;
    let mut vectors = Vec::with_capacity(texts.len());
    for text in texts {
        let mut vector: BTreeMap<&str, f64> = BTreeMap::new();
        for word in text {
            let rarity = texts_with.get(word.as_str()).map_or(0.0, |count| libm::log((all + 1.0) / *count as f64));
            *vector.entry(word).or_default() += rarity;
        }
        vectors.push(vector);
    }
    vectors
}

/// The cosine of two vectors; none where one has no length.
fn cosine(a: &BTreeMap<&str, f64>, b: &BTreeMap<&str, f64>) -> Option<f64> {
    let length = |vector: &BTreeMap<&str, f64>| vector.values().map(|value| value * value).sum::<f64>().sqrt();
    let product = a.iter().filter_map(|(word, value)| Some(value * b.get(word)?)).fold(0.0, |sum, part| sum + part);
    let lengths = length(a) * length(b);
    (lengths > 0.0).then(|| (product / lengths).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(name: &str, paths: &[&str], materials: &[&'static str], brief: &str) -> Profile {
        Profile {
            name: name.to_owned(),
            paths: paths.iter().map(|path| (*path).to_owned()).collect(),
            materials: materials.iter().copied().collect(),
            brief: brief.to_owned(),
        }
    }

    #[test]
    fn a_scene_is_as_near_to_itself_as_can_be() {
        let own = profile("a", &["LDE", "LS+DE"], &["diffuse", "mirror"], "A caustic in a ring.");
        let ranked = rank(&own, &[profile("far", &["LGE"], &["rough conductor"], "Metals."), own.clone()]);
        assert_eq!((ranked[0].name.as_str(), ranked[0].nearness), ("a", Nearness::VeryNear));
        assert!((ranked[0].score - 1.0).abs() < 1e-12, "{ranked:?}");
        assert_eq!((ranked[1].score, ranked[1].nearness), (0.0, Nearness::Far));
    }

    #[test]
    fn paths_are_compared_and_not_their_spelling() {
        let near = |a: &[&str], b: &[&str]| rank(&profile("a", a, &[], ""), &[profile("b", b, &[], "")])[0].paths;
        assert_eq!(near(&["LDE", "LDDE"], &["L(D|DD)E"]), Some(1.0));
        assert_eq!(near(&["L D E"], &["LDD D DSE"]), Some(1.0), "the full form");
        assert_eq!(near(&["LDE"], &["LGE"]), Some(0.0));
        // 1/2 of 1/2 + 1/4.
        assert_eq!(near(&["LDE"], &["LDE", "LDDE"]), Some(0.5 / 0.75));
        // Of the paths of up to five vertices that hold `SDS`, `LSDSE` is one.
        assert!(near(&["SDS"], &["LSDSE"]).is_some_and(|share| share > 0.05 && share < 1.0));
        assert_eq!(near(&[], &["LDE"]), None);
        assert_eq!(near(&["LDDDDDDE"], &["LDE"]), None, "longer than what is compared");
    }

    #[test]
    fn words_that_every_brief_has_count_less() {
        let own = profile("a", &[], &[], "Caustics of a light");
        let others = [
            profile("b", &[], &[], "A caustic"),
            profile("c", &[], &[], "Shadows of a light"),
            profile("d", &[], &[], ""),
        ];
        let ranked = rank(&own, &others);
        let brief = |name: &str| ranked.iter().find(|near| near.name == name).and_then(|near| near.brief);
        assert!(brief("b") > Some(0.3) && brief("c") > Some(0.3) && brief("d").is_none(), "{ranked:?}");
        assert_eq!(words_of("Glass, lights: gas"), ["glass", "light", "gas"]);
    }
}
