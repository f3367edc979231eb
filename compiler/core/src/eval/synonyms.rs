//! Words of other renderers and languages for what this language has under another name. They are only suggested.

use super::table::Family;
use crate::diag::nearest;

/// What people call a constructor elsewhere, its family here, and its name here (or what to write, where it has brackets).
const CONSTRUCTORS: &[(&str, Family, &str)] = &[
    ("lambert", Family::Material, "diffuse"),
    ("lambertian", Family::Material, "diffuse"),
    ("matte", Family::Material, "diffuse"),
    ("metal", Family::Material, "conductor"),
    ("roughconductor", Family::Material, "conductor"),
    ("glass", Family::Material, "dielectric"),
    ("roughplastic", Family::Material, "plastic"),
    ("coateddiffuse", Family::Material, "plastic"),
    ("disney", Family::Material, "principled"),
    ("roughdielectric", Family::Material, "dielectric"),
    ("specular", Family::Material, "mirror"),
    ("area", Family::Emission, "radiance"),
    ("emission", Family::Emission, "radiance"),
    ("emit", Family::Emission, "radiance"),
    ("constant", Family::Light, "environment"),
    ("infinite", Family::Light, "environment"),
    ("sky", Family::Light, "environment"),
    ("distant", Family::Light, "directional"),
    ("sun", Family::Light, "directional"),
    ("spotlight", Family::Light, "spot"),
    ("cube", Family::Mesh, "box"),
    ("plane", Family::Mesh, "rectangle"),
    ("quad", Family::Mesh, "rectangle"),
    ("ball", Family::Mesh, "sphere"),
    ("obj", Family::Mesh, "file"),
    ("ply", Family::Mesh, "file"),
    ("mesh", Family::Mesh, "triangles"),
    ("trianglemesh", Family::Mesh, "triangles"),
    ("move", Family::Stage, "translate"),
    ("rotate_x", Family::Stage, "rotate(x: ...)"),
    ("rotate_y", Family::Stage, "rotate(y: ...)"),
    ("rotate_z", Family::Stage, "rotate(z: ...)"),
    ("lookat", Family::Camera, "perspective"),
    ("pinhole", Family::Camera, "perspective"),
    ("film", Family::Film, "image"),
    ("hdrfilm", Family::Film, "image"),
    ("pathtracer", Family::Integrator, "path"),
    ("volpath", Family::Integrator, "path"),
    ("bdpt", Family::Integrator, "bidirectional"),
    ("ptracer", Family::Integrator, "light_tracing"),
    ("lightpath", Family::Integrator, "light_tracing"),
    ("mlt", Family::Integrator, "metropolis"),
    ("pssmlt", Family::Integrator, "metropolis"),
    ("sppm", Family::Integrator, "photon_map"),
    ("random", Family::Sampler, "independent"),
    ("halton", Family::Sampler, "sobol"),
    ("color", Family::Color, "rgb"),
    ("norm", Family::Function, "length"),
    ("fract", Family::Function, "mod(x, 1)"),
];

/// What people call a parameter elsewhere, and its name here.
const PARAMETERS: &[(&str, &str)] = &[
    ("albedo", "reflectance"),
    ("color", "reflectance"),
    ("colour", "reflectance"),
    ("kd", "reflectance"),
    ("roughness", "alpha"),
    ("int_ior", "ior"),
    ("ext_ior", "outside"),
    ("eta", "ior"),
    ("origin", "eye"),
    ("from", "eye"),
    ("look_at", "target"),
    ("lookat", "target"),
    ("at", "target"),
    ("to", "target"),
    ("spp", "samples"),
    ("sample_count", "samples"),
    ("emission", "value"),
    ("power", "intensity"),
    ("from", "position"),
    ("to", "direction"),
    ("vertices", "positions"),
    ("indices", "faces"),
    ("triangles", "faces"),
    ("filename", "path"),
    ("cutoff", "angle"),
    ("amount", "factor"),
    ("offset", "by"),
];

/// What is called `name` in other renderers has this name here.
pub fn any(name: &str) -> Option<&'static str> {
    constructor(name, None)
}

/// The constructor of `family` (any, where none is asked for) that other renderers call `name`.
pub(super) fn constructor(name: &str, family: Option<Family>) -> Option<&'static str> {
    let name = name.to_ascii_lowercase();
    let fits = |(word, of, _): &&(&str, Family, &str)| *word == name && family.is_none_or(|family| family == *of);
    CONSTRUCTORS.iter().find(fits).map(|(_, _, ours)| *ours)
}

/// The names among `known` that may be meant by `name`: the nearest one, else those that hold it as a word (`fov` in `fov_x`
/// and `fov_y`), else what other renderers mean by it.
pub(super) fn meant<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Vec<&'a str> {
    if let Some(similar) = nearest(name, known.clone()) {
        return vec![similar];
    }
    let lower = name.to_ascii_lowercase();
    let holds = |long: &str, short: &str| short.len() > 1 && long.split('_').any(|word| word == short);
    let words: Vec<&str> = known.clone().filter(|own| holds(own, &lower) || holds(&lower, own)).collect();
    if !words.is_empty() {
        return words;
    }
    let ours = PARAMETERS.iter().filter(|(word, _)| *word == lower).map(|(_, ours)| *ours);
    known.filter(|own| ours.clone().any(|ours| ours == *own)).collect()
}

/// "did you mean `a` or `b`?"
pub(super) fn question(names: &[&str]) -> Option<String> {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    (!quoted.is_empty()).then(|| format!("did you mean {}?", quoted.join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::super::table;
    use super::*;

    #[test]
    fn synonyms_lead_to_what_there_is() {
        for (word, family, ours) in CONSTRUCTORS {
            let name = ours.split('(').next().unwrap_or_default();
            assert!(table::table().any(|row| row.name == name && row.family == *family), "{ours}");
            assert!(!table::table().any(|row| row.name == *word && row.family == *family), "{word} is ours now");
        }
        for (_, ours) in PARAMETERS {
            assert!(table::table().any(|row| row.params.iter().any(|param| param.name == *ours)), "{ours}");
        }
    }

    #[test]
    fn parameters_are_found_by_letters_words_and_synonyms() {
        let of = |name: &str, known: &[&'static str]| meant(name, known.iter().copied());
        assert_eq!(of("fov", &["eye", "fov_x", "fov_y"]), ["fov_x", "fov_y"]);
        assert_eq!(of("depth", &["max_depth"]), ["max_depth"]);
        assert_eq!(of("reflectence", &["reflectance", "ior"]), ["reflectance"]);
        assert_eq!(of("roughness", &["eta", "k", "alpha"]), ["alpha"]);
        assert!(of("nonsense", &["eta", "k", "alpha"]).is_empty());
    }
}
