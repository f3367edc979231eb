//! Material libraries of OBJ files (`.mtl`), as far as a surface of physics can be told from them.
//!
//! | statement | read as |
//! |---|---|
//! | `Kd` | the reflectance of a diffuse surface |
//! | `illum 3`, `5`, `8` with `Kd 0` and `Ks` | a mirror of reflectance `Ks` |
//! | `illum 6`, `7` | clear glass of index `Ni` |
//! | `illum 4`, `9`, or none with `Ni` > 1, and less than half opaque | the same |
//! | `d`, else `Tr` | how opaque: `Tr` is `1 - d`, but 1 where several programs write what is opaque |
//! | `map_Kd` | a texture, times `Kd`, with the options `-s` and `-o` |
//! | `Ke` | radiance of an emitter |
//! | `Ka` | nothing: ambient light is no light of a scene |
//!
//! Nothing that a library says makes its mesh unreadable: what is not understood is a note.

mod texture;

use std::collections::BTreeMap;

use super::model::{Picture, Scatter, Surface};
use super::text::{lines, text};
use super::{Note, shown};
use crate::ir::Vec3;
pub(super) use texture::Placing;

/// The grey of a material that says no color, as in most programs.
const GREY: f64 = 0.8;

/// The materials of all libraries of a file.
#[derive(Default)]
pub(super) struct Materials {
    pub surfaces: Vec<Surface>,
    /// How the texture of each surface lies, where it is not as the texture coordinates say.
    pub placings: Vec<Option<Placing>>,
    /// Their positions by name, and by what stands before a `#` in it.
    known: BTreeMap<Vec<u8>, usize>,
    short: BTreeMap<Vec<u8>, usize>,
}

/// What a library says of one material.
#[derive(Default)]
struct Entry {
    name: String,
    kd: Option<Vec3>,
    ks: Option<Vec3>,
    ke: Option<Vec3>,
    ni: Option<f64>,
    opacity: Option<f64>,
    transparency: Option<f64>,
    illum: Option<f64>,
    filter: Option<Vec3>,
    picture: Option<String>,
    placing: Option<Placing>,
    /// Statements that stand for something that is not read.
    lost: Vec<&'static str>,
}

impl Entry {
    fn lose(&mut self, what: &'static str) {
        if !self.lost.contains(&what) {
            self.lost.push(what);
        }
    }
}

/// The name without a comment behind it: from the first `#` behind a blank, where `sure` only if a blank follows it too.
fn bare(name: &[u8], sure: bool) -> &[u8] {
    let begins = |at: &usize| {
        let after = name.get(at + 1).is_none_or(u8::is_ascii_whitespace);
        *at > 0 && name[*at] == b'#' && name[at - 1].is_ascii_whitespace() && (after || !sure)
    };
    (0..name.len()).find(begins).map_or(name, |at| name[..at].trim_ascii())
}

impl Materials {
    /// The surface of this name. Names may contain `#`, and a comment may stand behind them: the whole name counts first.
    pub fn find(&self, name: &[u8]) -> Option<usize> {
        let whole = self.known.get(name).or_else(|| self.known.get(bare(name, false)));
        whole.or_else(|| self.short.get(bare(name, true))).copied()
    }

    /// Adds the materials of a library.
    pub fn read(&mut self, bytes: &[u8], path: &str, notes: &mut Vec<Note>) {
        let bytes = match text(bytes) {
            Ok(bytes) => bytes,
            Err(error) => {
                notes.push(Note::dropped(format!("`{}`, {}", shown(path), error.place), error.message));
                return;
            }
        };
        let mut entries: Vec<(Vec<u8>, Entry)> = Vec::new();
        let all = lines(&bytes, |line, number| -> Result<(), std::convert::Infallible> {
            let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
            let (keyword, rest) = (&line[..end], line[end..].trim_ascii());
            if keyword.is_empty() || keyword.starts_with(b"#") {
                return Ok(());
            }
            if keyword.eq_ignore_ascii_case(b"newmtl") {
                let name = String::from_utf8_lossy(bare(rest, true)).into_owned();
                entries.push((rest.to_vec(), Entry { name, ..Entry::default() }));
            } else if let Some((_, entry)) = entries.last_mut() {
                let place = || format!("`{}`, line {number}", shown(path));
                entry.statement(keyword, rest, &place, notes);
            }
            Ok(())
        });
        let Ok(()) = all;
        for (key, entry) in entries {
            if self.known.contains_key(&key) {
                let message = format!("two materials are called `{}`: the first counts", shown(&entry.name));
                notes.push(Note::warn(format!("`{}`", shown(path)), message));
                continue;
            }
            let at = self.surfaces.len();
            self.short.entry(bare(&key, false).to_vec()).or_insert(at);
            self.known.insert(key, at);
            self.placings.push(entry.placing);
            self.surfaces.push(entry.surface());
        }
    }
}

impl Entry {
    fn statement(&mut self, keyword: &[u8], rest: &[u8], place: &dyn Fn() -> String, notes: &mut Vec<Note>) {
        let name = String::from_utf8_lossy(&keyword[..keyword.len().min(40)]).into_owned();
        let color = |notes: &mut Vec<Note>| color(&name, rest, place, notes);
        match keyword.to_ascii_lowercase().as_slice() {
            b"kd" => self.kd = color(notes).map(|kd| share(&name, kd, place, notes)).or(self.kd),
            b"ks" => self.ks = color(notes).map(|ks| share(&name, ks, place, notes)).or(self.ks),
            b"ke" => self.ke = color(notes).or(self.ke),
            b"tf" => self.filter = color(notes).or(self.filter),
            b"ni" => self.ni = number(&name, rest, place, notes).or(self.ni),
            b"d" => {
                let halo = rest.strip_prefix(b"-halo");
                if halo.is_some() {
                    self.lose("opacity that depends on the angle (`d -halo`)");
                }
                self.opacity = number(&name, halo.unwrap_or(rest), place, notes).or(self.opacity);
            }
            b"tr" => self.transparency = number(&name, rest, place, notes).or(self.transparency),
            b"illum" => self.illum = number(&name, rest, place, notes).or(self.illum),
            b"map_kd" => self.texture(rest, place, notes),
            b"map_ks" | b"map_ns" | b"map_pr" | b"map_pm" | b"map_ps" | b"refl" | b"map_refl" => {
                self.lose("textures of specular reflection");
            }
            b"map_ke" => self.lose("textures of emission"),
            b"map_d" | b"map_tr" | b"map_opacity" => self.lose("textures of opacity"),
            b"bump" | b"map_bump" | b"norm" | b"map_kn" | b"disp" | b"map_disp" => self.lose("bump and normal maps"),
            b"decal" => self.lose("decals"),
            b"pr" | b"pm" | b"ps" | b"pc" | b"pcr" | b"aniso" | b"anisor" => {
                self.lose("roughness, metallicity and other statements of the PBR extension");
            }
            // Ambient light, the width of highlights (told by `Ks`), sharpness of reflection maps, antialiasing of textures.
            b"ka" | b"map_ka" | b"ns" | b"km" | b"sharpness" | b"map_aat" => {}
            _ => {
                let message = format!("`{}` not read, which is not known", shown(&name));
                notes.push(Note::dropped(place(), message).counting(1, "statement"));
            }
        }
    }

    fn texture(&mut self, rest: &[u8], place: &dyn Fn() -> String, notes: &mut Vec<Note>) {
        let texture = texture::read(&String::from_utf8_lossy(rest));
        if texture.ignored {
            self.lose("options of textures other than `-s` and `-o`");
        }
        if texture.absolute {
            let message = format!("of an absolute path only `{}` is looked for", shown(&texture.name));
            notes.push(Note::warn(place(), message));
        }
        if texture.name.is_empty() {
            notes.push(Note::dropped(place(), "without a file left out").counting(1, "texture"));
            return;
        }
        (self.picture, self.placing) = (Some(texture.name), texture.placing);
    }

    /// How opaque the surface is, 0 to 1. MeshLab and others write `Tr 1` for what is opaque, beside `d 1` or alone.
    fn opaque(&mut self, transparent: bool) -> f64 {
        let clamp = |x: f64| x.clamp(0.0, 1.0);
        match (self.opacity.map(clamp), self.transparency.map(clamp)) {
            (Some(d), Some(tr)) => {
                if (d + tr - 1.0).abs() > 1e-3 {
                    self.lose("`Tr`, which contradicts `d`");
                }
                d
            }
            (Some(d), None) => d,
            (None, Some(1.0)) if !transparent => {
                self.lose("`Tr 1`, by which several programs mean that a surface is opaque");
                1.0
            }
            (None, Some(tr)) => 1.0 - tr,
            (None, None) => 1.0,
        }
    }

    fn surface(mut self) -> Surface {
        let glassy = |illum: f64| [4.0, 6.0, 7.0, 9.0].contains(&illum);
        let opaque = self.opaque(self.illum.is_some_and(glassy));
        let index = self.ni.filter(|ni| *ni > 1.0);
        let refracts = match self.illum {
            Some(6.0 | 7.0) => true,
            Some(4.0 | 9.0) => opaque < 0.5,
            Some(_) => false,
            None => opaque < 0.5 && index.is_some(),
        };
        let illum = self.illum.unwrap_or(2.0);
        let shiny = self.ks.filter(|ks| *ks != [0.0; 3]);
        let mirrors = [3.0, 5.0, 8.0].contains(&illum) && self.kd.is_none_or(|kd| kd == [0.0; 3]);
        if !(0.0..=9.0).contains(&illum) || illum.fract() != 0.0 {
            self.lose("an illumination model (`illum`) other than 0 to 9");
        }
        let scatter = match (refracts, mirrors, shiny) {
            (true, _, _) => {
                if index.is_none() {
                    self.lose("glass without an index of refraction, which is taken for 1.5");
                }
                if self.filter.is_some_and(|filter| filter != [1.0; 3]) {
                    self.lose("the tint of transmitted light (`Tf`)");
                }
                if self.kd.is_some_and(|kd| kd != [0.0; 3] && kd != [1.0; 3]) {
                    self.lose("the color (`Kd`) of what is taken for clear glass");
                }
                Scatter::Glass { ior: index.unwrap_or(1.5), alpha: 0.0 }
            }
            (false, true, Some(reflectance)) => Scatter::Mirror(reflectance),
            (false, _, _) => {
                if opaque < 1.0 {
                    self.lose("opacity (`d`), by which things are seen through a surface without being refracted");
                }
                if shiny.is_some() && illum >= 2.0 {
                    self.lose("highlights (`Ks`, `Ns`), since the model of Phong and Blinn keeps no energy");
                }
                // Maya writes `illum 4` and `Tf 1 1 1` for what is opaque.
                if self.illum.is_some_and(glassy) && self.filter.is_some_and(|filter| filter != [1.0; 3]) {
                    self.lose("the tint of transmitted light (`Tf`)");
                }
                if self.picture.is_some() && self.kd == Some([0.0; 3]) {
                    self.lose("anything of its texture (`map_Kd`), which is black times `Kd 0 0 0`");
                }
                Scatter::Diffuse(self.kd.unwrap_or([GREY; 3]))
            }
        };
        let Self { name, ke, kd, picture, lost, .. } = self;
        let factor = kd.filter(|_| picture.is_some()).unwrap_or([1.0; 3]);
        let picture = picture.map(Picture::Beside);
        Surface { name, scatter, emission: ke.filter(|ke| *ke != [0.0; 3]), picture, factor, lost }
    }
}

/// The words of a value, without a comment behind them.
fn words(rest: &[u8]) -> Vec<&[u8]> {
    let end = rest.iter().position(|byte| *byte == b'#').unwrap_or(rest.len());
    rest[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect()
}

/// No number of a material is larger.
const MOST: f64 = 1e30;

fn value(word: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(word).ok()?.parse().ok()?;
    (0.0..=MOST).contains(&number).then_some(number)
}

/// Notes a value that is not read, or not all of it.
fn unfit(name: &str, what: &str, place: &dyn Fn() -> String, notes: &mut Vec<Note>) {
    notes.push(Note::dropped(place(), format!("of `{}` {what}", shown(name))).counting(1, "value"));
}

/// A reflectance, which is 1 at most: a surface that sends out more than it gets is none.
fn share(name: &str, color: Vec3, place: &dyn Fn() -> String, notes: &mut Vec<Note>) -> Vec3 {
    if color.iter().any(|part| *part > 1.0) {
        let message = format!("of `{}` held to 1, the most that a surface reflects", shown(name));
        notes.push(Note::approximated(place(), message).counting(1, "value").grave());
    }
    color.map(|part| part.min(1.0))
}

fn number(name: &str, rest: &[u8], place: &dyn Fn() -> String, notes: &mut Vec<Note>) -> Option<f64> {
    let words = words(rest);
    let found = words.first().and_then(|word| value(word));
    if found.is_none() {
        unfit(name, "not read, which takes a number of 0 or more", place, notes);
    } else if words.len() > 1 {
        unfit(name, "cut off behind the first number", place, notes);
    }
    found
}

/// Three numbers, or one for a grey.
fn color(name: &str, rest: &[u8], place: &dyn Fn() -> String, notes: &mut Vec<Note>) -> Option<Vec3> {
    let words = words(rest);
    match words.first().copied() {
        Some(b"spectral") => {
            unfit(name, "not read, since they are curves of spectra (`spectral`)", place, notes);
            return None;
        }
        Some(b"xyz") => {
            unfit(name, "not read, since they are in CIE XYZ (`xyz`)", place, notes);
            return None;
        }
        _ => {}
    }
    let numbers: Option<Vec<f64>> = words.iter().take(3).map(|word| value(word)).collect();
    match numbers.as_deref() {
        Some([grey]) => Some([*grey; 3]),
        Some([r, g, b]) => {
            if words.len() > 3 {
                unfit(name, "cut off behind the third number", place, notes);
            }
            Some([*r, *g, *b])
        }
        _ => {
            unfit(name, "not read, which takes one or three numbers of 0 or more", place, notes);
            None
        }
    }
}

#[cfg(test)]
mod tests;
