//! What the drivers of PBRT and of its ports have in common: settings, and how programs tell their version.

use std::path::PathBuf;
use std::process::Command;

use super::process::{End, Lines};
use super::{Asked, Job, RenderError, emitted, script};

/// Directives that count samples, each with what else counts them there; the number of the request goes into all.
const COUNTS: [(&str, &str); 4] = [
    ("Sampler", "pixelsamples"),
    ("Integrator", "mutationsperpixel"),
    // v4 and v3, in this order.
    ("Integrator", "iterations"),
    ("Integrator", "numiterations"),
];

/// Asks a PBRT for its major version and the rest of that line. Both versions say it when they render and not when they
/// are asked for help (`main/pbrt.cpp`, `cmd/pbrt.cpp`), so they are given a scene of nothing.
pub(super) fn banner(asked: Asked<'_>) -> Result<(u32, String), String> {
    let folder = crate::guard::Folder::new().map_err(|error| error.to_string())?;
    let scene = folder.path().join("nothing.pbrt");
    std::fs::write(&scene, "# Nothing.\n").map_err(|error| error.to_string())?;
    let mut command = Command::new(asked.program);
    command.arg(&scene);
    let mut version = None;
    let (end, tail) = script::ask(command, asked.until, Lines::All, &mut |line| {
        // "pbrt version 3 (built Nov 26 2026 at 12:00:00) [Detected 2 cores]"
        if let Some(rest) = line.trim().strip_prefix("pbrt version ") {
            version = version.take().or_else(|| Some(rest.to_owned()));
        }
    })?;
    match (end, version) {
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
        // Version 4 misses a world in nothing and ends with an error.
        (End::Exited(_), Some(text)) => {
            let digits = text.bytes().take_while(u8::is_ascii_digit).count();
            let major = text[..digits].parse().map_err(|_| format!("it says version `{text}`"))?;
            // "4 (built Jun 10 2026 at 12:00:00)": the minute of the build is no version.
            Ok((major, text.split([' ', '[']).next().unwrap_or_default().to_owned()))
        }
        (End::Exited(_), None) => {
            Err(format!("it does not say `pbrt version`: {}", tail.first().map_or("it says nothing", String::as_str)))
        }
    }
}

/// The version of a PBRT that must be `major`.
pub(super) fn version(asked: Asked<'_>, major: u32) -> Result<String, String> {
    let (found, text) = banner(asked)?;
    if found == major {
        return Ok(text);
    }
    let other = match found {
        3 | 4 => format!("; name it for `pbrt-v{found}`"),
        _ => String::new(),
    };
    Err(format!("it is version {found}, and this reads the files of version {major}{other}"))
}

/// The version of a port, which says `NAME 1.2.3` by itself.
pub(super) fn port(asked: Asked<'_>, name: &str) -> Result<String, String> {
    let mut command = Command::new(asked.program);
    command.arg("--version");
    let mut version = None;
    let (end, tail) = script::ask(command, asked.until, Lines::All, &mut |line| {
        if let Some(rest) = line.trim().strip_prefix(name).and_then(|rest| rest.strip_prefix(' ')) {
            version = version.take().or_else(|| rest.split_whitespace().next().map(str::to_owned));
        }
    })?;
    match (end, version) {
        (End::TimedOut | End::Cancelled, _) => Err("it does not answer".to_owned()),
        (End::Exited(_), Some(version)) => Ok(version),
        (End::Exited(_), None) => Err(format!(
            "it does not say `{name}` and its version: {}",
            tail.first().map_or("it says nothing", String::as_str)
        )),
    }
}

/// What errors of the ports mean.
pub(super) const PORT_HINTS: &[(&str, &str)] = &[
    ("No such file or directory", "a file is missing; emit the folder again and keep it together"),
    ("parser error", "it cannot parse a file; emit the folder again for this renderer's target"),
    ("legacy material name", "the file is one for version 3; emit the scene for `pbrt-v4`"),
    ("unknown", "it does not know a name in the file; emit the folder again for this renderer's target"),
    ("memory allocation", "it ran out of memory; make the image or the meshes smaller"),
];

/// The noise of version 4's four wavelengths; see [`super::Driver::wavelengths`]. Measured with pbrt-r4 4.5.2 on a lamp of
/// radiance 1, 64 x 64 pixels of 64 samples.
pub(super) const FOUR_WAVELENGTHS: [f64; 4] = [0.153, 0.033, 0.64, 0.19];

/// The files of the emitted folder in which the samples of the request are not yet said, as they should be.
pub(super) fn samples(job: &Job<'_>) -> Result<Vec<(PathBuf, String)>, RenderError> {
    let mut changed = Vec::new();
    let mut found = false;
    for (path, text) in emitted::texts(job.folder, "pbrt") {
        let mut new = text.clone();
        for (directive, name) in COUNTS {
            if let Some((start, end)) = value_of(&new, directive, name) {
                found = true;
                new.replace_range(start..end, &job.request.samples.to_string());
            }
        }
        if new != text {
            changed.push((path, new));
        }
    }
    if found {
        return Ok(changed);
    }
    Err(RenderError::Request {
        message: format!("no file beside `{}` has a `Sampler` with `\"integer pixelsamples\" [N]`", job.main.display()),
        hint: format!("emit the scene for the target `{}` again", job.request.driver.target),
    })
}

/// Where the directive at the start of a line begins, and where its type ends, behind the quote.
pub(super) fn directive(text: &str, name: &str) -> Option<(usize, usize)> {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let indent = line.len() - line.trim_start().len();
        if let Some(rest) = line.trim_start().strip_prefix(name)
            && let Some((between, kind)) = rest.split_once('"')
            && between.trim().is_empty()
            && let Some(length) = kind.find('"')
        {
            let start = at + indent;
            return Some((start, start + name.len() + between.len() + length + 2));
        }
        at += line.len();
    }
    None
}

/// The text with a parameter more in its directive, if it has that, of the type `kind` where one is asked for.
pub(super) fn with_parameter(text: &str, name: &str, kind: Option<&str>, parameter: &str) -> String {
    match directive(text, name) {
        Some((start, end)) if kind.is_none_or(|kind| text[start..end].ends_with(&format!("\"{kind}\""))) => {
            format!("{}{parameter}{}", &text[..end], &text[end..])
        }
        Some(_) | None => text.to_owned(),
    }
}

/// Where the number of an integer parameter of a directive stands.
pub(super) fn value_of(text: &str, name: &str, parameter: &str) -> Option<(usize, usize)> {
    let (start, _) = directive(text, name)?;
    // Parameters end where the next directive begins; none of those has a parameter of this name.
    let from = start + text[start..].find(&format!("\"integer {parameter}\""))?;
    let open = from + text[from..].find('[')? + 1;
    let close = open + text[open..].find(']')?;
    let number = text[open..close].trim();
    let offset = open + text[open..close].find(number)?;
    number.parse::<u32>().ok().map(|_| (offset, offset + number.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Film \"none\"\nFilm \"image\" \"integer xresolution\" [8]\n  Sampler  \"random\"\n\t\"integer \
                        pixelsamples\" [ 32 ]\nIntegrator \"mlt\" \"integer mutationsperpixel\" [64]\n";

    #[test]
    fn directives_and_their_numbers_are_found() {
        let (start, end) = directive(TEXT, "Film").expect("a film");
        assert_eq!(&TEXT[start..end], "Film \"image\"");
        let (start, end) = directive(TEXT, "Sampler").expect("a sampler");
        assert_eq!(&TEXT[start..end], "Sampler  \"random\"");
        let at = |directive: &str, name: &str| value_of(TEXT, directive, name).map(|(start, end)| &TEXT[start..end]);
        assert_eq!(at("Sampler", "pixelsamples"), Some("32"));
        assert_eq!(at("Integrator", "mutationsperpixel"), Some("64"));
        assert_eq!(at("Integrator", "iterations"), None);
        assert_eq!(at("Camera", "pixelsamples"), None);
        assert_eq!(directive("Filmless \"a\"", "Film"), None);
        let seed = " \"integer seed\" [3]";
        let more = with_parameter(TEXT, "Sampler", None, seed);
        assert_eq!(more, TEXT.replace("Sampler  \"random\"", "Sampler  \"random\" \"integer seed\" [3]"));
        assert_eq!(with_parameter(TEXT, "Integrator", Some("sppm"), seed), TEXT);
        assert!(
            with_parameter(TEXT, "Integrator", Some("mlt"), seed)
                .contains("\"mlt\" \"integer seed\" [3] \"integer mut")
        );
        assert_eq!(value_of("Sampler \"a\" \"integer n\" [x]", "Sampler", "n"), None);
    }
}
