//! Material libraries of OBJ files (`.mtl`), as far as a surface of physics can be told from them.
//!
//! | statement | read as |
//! |---|---|
//! | `Kd` | the reflectance of a diffuse surface |
//! | `illum 3`, `illum 8` with `Kd 0` and `Ks` | a mirror of reflectance `Ks` |
//! | `illum 4`, `6`, `7`, `9`, or `d` < 1 with `Ni` > 1 | clear glass of index `Ni` |
//! | `map_Kd` | a texture in the place of `Kd` |
//! | `Ke` | radiance of an emitter |
//! | `Ka` | nothing: ambient light is no light of a scene |

use std::collections::BTreeMap;

use super::model::{Picture, Scatter, Surface};
use super::{FileError, Note, shown};
use crate::ir::Vec3;

/// The grey of a material that says no colour, as in most programs.
const GREY: f64 = 0.8;

/// What a library says of one material.
#[derive(Default)]
struct Entry {
    name: String,
    kd: Option<Vec3>,
    ks: Option<Vec3>,
    ke: Option<Vec3>,
    ni: Option<f64>,
    opacity: Option<f64>,
    illum: Option<f64>,
    filter: Option<Vec3>,
    picture: Option<String>,
    /// Statements that stand for something that is not read.
    lost: Vec<&'static str>,
}

/// Adds the materials of a library to `surfaces`; `known` has their positions by name.
pub(super) fn read(
    bytes: &[u8],
    path: &str,
    surfaces: &mut Vec<Surface>,
    known: &mut BTreeMap<Vec<u8>, usize>,
    notes: &mut Vec<Note>,
) -> Result<(), FileError> {
    let mut entries: Vec<(Vec<u8>, Entry)> = Vec::new();
    for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (keyword, rest) = (&line[..end], line[end..].trim_ascii());
        if keyword.is_empty() || keyword.starts_with(b"#") {
            continue;
        }
        if keyword == b"newmtl" {
            let name = String::from_utf8_lossy(rest).into_owned();
            entries.push((rest.to_vec(), Entry { name, ..Entry::default() }));
            continue;
        }
        let Some((_, entry)) = entries.last_mut() else { continue };
        let place = || format!("`{}`, line {}", shown(path), index + 1);
        let mut lose = |what| {
            if !entry.lost.contains(&what) {
                entry.lost.push(what);
            }
        };
        match keyword {
            b"Kd" => entry.kd = Some(color(rest).ok_or_else(|| fault(place(), rest))?),
            b"Ks" => entry.ks = Some(color(rest).ok_or_else(|| fault(place(), rest))?),
            b"Ke" => entry.ke = Some(color(rest).ok_or_else(|| fault(place(), rest))?),
            b"Tf" => entry.filter = Some(color(rest).ok_or_else(|| fault(place(), rest))?),
            b"Ni" => entry.ni = Some(number(rest).ok_or_else(|| fault(place(), rest))?),
            b"d" => {
                let rest = rest.strip_prefix(b"-halo").unwrap_or(rest);
                entry.opacity = Some(number(rest).ok_or_else(|| fault(place(), rest))?);
            }
            b"Tr" => entry.opacity = Some(1.0 - number(rest).ok_or_else(|| fault(place(), rest))?),
            b"illum" => entry.illum = Some(number(rest).ok_or_else(|| fault(place(), rest))?),
            b"map_Kd" => {
                // Options come first; a name without them may contain blanks.
                let name = if rest.starts_with(b"-") {
                    lose("options of textures");
                    rest.rsplit(u8::is_ascii_whitespace).next().unwrap_or(rest)
                } else {
                    rest
                };
                entry.picture = Some(String::from_utf8_lossy(name).into_owned()).filter(|name| !name.is_empty());
            }
            b"map_Ks" | b"map_Ns" | b"map_Pr" | b"map_Pm" | b"refl" => lose("textures of specular reflection"),
            b"map_Ke" => lose("textures of emission"),
            b"map_d" | b"map_Tr" => lose("textures of opacity"),
            b"bump" | b"map_bump" | b"map_Bump" | b"norm" | b"disp" => lose("bump and normal maps"),
            b"Pr" | b"Pm" | b"Ps" | b"Pc" | b"Pcr" | b"aniso" | b"anisor" => {
                lose("roughness, metallicity and other statements of the PBR extension");
            }
            // Ambient light, the width of highlights (told by `Ks`), sharpness of reflection maps.
            _ => {}
        }
    }
    for (key, entry) in entries {
        if known.contains_key(&key) {
            notes.push(Note::warn(
                format!("`{}`", shown(path)),
                format!("two materials are called `{}`: the first counts", shown(&entry.name)),
            ));
            continue;
        }
        known.insert(key, surfaces.len());
        surfaces.push(entry.surface());
    }
    Ok(())
}

impl Entry {
    fn surface(self) -> Surface {
        let Self { name, kd, ks, ke, ni, opacity, illum, filter, picture, mut lost } = self;
        let illum = illum.unwrap_or(2.0);
        let shiny = ks.filter(|ks| *ks != [0.0; 3]);
        let opacity = opacity.unwrap_or(1.0);
        let index = ni.filter(|ni| *ni > 1.0);
        let refracts = [4.0, 6.0, 7.0, 9.0].contains(&illum) || opacity < 1.0 && index.is_some();
        let mirrors = [3.0, 5.0, 8.0].contains(&illum) && kd.is_none_or(|kd| kd == [0.0; 3]);
        let scatter = match (refracts, mirrors, shiny) {
            (true, _, _) => {
                if index.is_none() {
                    lost.push("glass without an index of refraction, which is taken for 1.5");
                }
                if filter.is_some_and(|filter| filter != [1.0; 3]) {
                    lost.push("the tint of transmitted light (`Tf`)");
                }
                Scatter::Glass { ior: index.unwrap_or(1.5), alpha: 0.0 }
            }
            (false, true, Some(reflectance)) => Scatter::Mirror(reflectance),
            (false, _, _) => {
                if opacity < 1.0 {
                    lost.push("opacity (`d`), by which things are seen through a surface without being refracted");
                }
                if shiny.is_some() && illum >= 2.0 {
                    lost.push("highlights (`Ks`, `Ns`), since the model of Phong and Blinn keeps no energy");
                }
                Scatter::Diffuse(kd.unwrap_or([GREY; 3]))
            }
        };
        let picture = picture.map(Picture::Beside);
        Surface { name, scatter, emission: ke.filter(|ke| *ke != [0.0; 3]), picture, lost }
    }
}

fn fault(place: String, rest: &[u8]) -> FileError {
    let text = String::from_utf8_lossy(&rest[..rest.len().min(200)]).into_owned();
    FileError::new(place, format!("`{}` is no number, or no color, of 0 or more", shown(&text)))
        .help("colours are one or three numbers; spectra and CIE values are not read")
}

fn number(text: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(text.trim_ascii()).ok()?.parse().ok()?;
    (number.is_finite() && number >= 0.0).then_some(number)
}

/// Three numbers, or one for a grey.
fn color(text: &[u8]) -> Option<Vec3> {
    let words: Vec<&[u8]> = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
    match words.as_slice() {
        [grey] => number(grey).map(|grey| [grey; 3]),
        [r, g, b] => Some([number(r)?, number(g)?, number(b)?]),
        _ => None,
    }
}
