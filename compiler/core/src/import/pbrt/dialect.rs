//! Which version of PBRT a file is written for, found out from its words.

use super::tokens::{Token, Tokens};
use crate::diag::FileId;
use crate::files::VPath;
use crate::import::reader::Reader;

/// A version of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Dialect {
    /// pbrt-v1 and pbrt-v2, which differ little.
    Old,
    /// pbrt-v3 and rs_pbrt.
    V3,
    /// pbrt-v4.
    V4,
}

/// How many files are looked at.
const MOST_FILES: usize = 64;
/// How many bytes of each.
const MOST_BYTES: usize = 1 << 18;

/// What is known so far.
#[derive(Default)]
struct Marks {
    v4: bool,
    v3: bool,
    old: bool,
    /// `color` as a type, which v3 takes too.
    color: bool,
    /// A camera: a whole scene, which in v1 and v2 says how it is rendered.
    camera: bool,
}

/// The version of a text and of what it includes.
pub fn of(reader: &mut Reader<'_>, path: &VPath, file: FileId) -> Dialect {
    let mut marks = Marks::default();
    let mut files = vec![(path.clone(), file)];
    let mut at = 0;
    while let Some((path, file)) = files.get(at).cloned() {
        at += 1;
        let text = std::sync::Arc::clone(&reader.sources.get(file).text);
        let mut includes = Vec::new();
        look(&text, file, &mut marks, &mut includes);
        if marks.v4 {
            break;
        }
        for name in includes {
            // What cannot be read is a finding where it is included.
            let found = VPath::resolve(path.folder(), &name).ok().filter(|_| files.len() < MOST_FILES);
            let Some(found) = found else { continue };
            if files.iter().all(|(known, _)| *known != found)
                && let Ok(file) = reader.text(&found)
            {
                files.push((found, file));
            }
        }
    }
    match marks {
        Marks { v4: true, .. } => Dialect::V4,
        Marks { old: true, .. } => Dialect::Old,
        Marks { v3: true, .. } => Dialect::V3,
        Marks { color: true, camera: false, .. } => Dialect::Old,
        Marks { .. } => Dialect::V3,
    }
}

fn look(text: &str, file: FileId, marks: &mut Marks, includes: &mut Vec<String>) {
    let end = (MOST_BYTES.min(text.len())..text.len()).find(|at| text.is_char_boundary(*at)).unwrap_or(text.len());
    let text = text.get(..end).unwrap_or(text);
    let mut tokens = Tokens::new(text, 0, file);
    let mut directive = String::new();
    let mut skipped = Vec::new();
    while let Some(byte) = tokens.peek() {
        if !byte.is_ascii_alphabetic() && byte != b'"' {
            skipped.clear();
            let before = tokens.at;
            tokens.numbers(&mut skipped);
            if tokens.at > before {
                continue;
            }
        }
        match tokens.next() {
            Some((Token::Word(word), _)) => {
                match word.as_str() {
                    "Option" | "ColorSpace" | "Attribute" | "Import" => marks.v4 = true,
                    "SurfaceIntegrator" | "VolumeIntegrator" | "Renderer" | "Volume" | "SearchPath" => marks.old = true,
                    "Integrator" | "MakeNamedMedium" | "MediumInterface" => marks.v3 = true,
                    "Camera" => marks.camera = true,
                    _ => {}
                }
                if word.starts_with(|letter: char| letter.is_ascii_uppercase()) {
                    directive = word;
                }
            }
            Some((Token::Quoted(text), _)) => {
                if let Some((kind, name)) = text.split_once(' ') {
                    match (kind, name.trim()) {
                        ("color", _) => marks.color = true,
                        ("bool", "remaproughness") => marks.v3 = true,
                        ("float", "illuminance" | "power" | "iso") => marks.v4 = true,
                        _ => {}
                    }
                    continue;
                }
                match (directive.as_str(), text.as_str()) {
                    ("Include", _) => includes.push(text),
                    ("Film", "rgb" | "gbuffer" | "spectral")
                    | ("Shape", "bilinearmesh")
                    | ("Camera", "spherical")
                    | ("Sampler", "zsobol" | "independent" | "paddedsobol" | "pmj02bn")
                    | ("Integrator", "lightpath" | "simplepath" | "simplevolpath" | "randomwalk" | "function")
                    | (
                        "Material" | "MakeNamedMaterial",
                        "coateddiffuse"
                        | "coatedconductor"
                        | "diffuse"
                        | "conductor"
                        | "dielectric"
                        | "thindielectric"
                        | "diffusetransmission"
                        | "interface"
                        | "measured",
                    ) => marks.v4 = true,
                    ("Sampler", "02sequence" | "maxmindist" | "sobol")
                    | ("Material" | "MakeNamedMaterial", "fourier" | "disney" | "hair") => marks.v3 = true,
                    ("Sampler", "bestcandidate") => marks.old = true,
                    _ => {}
                }
            }
            _ => {}
        }
        if marks.v4 {
            return;
        }
    }
}
