//! Textures of material libraries: options, then the name of a file, which may contain blanks.

use super::super::text::file_name;

/// How a texture lies: texture coordinates are multiplied by `scale`, then `offset` is added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    pub scale: [f64; 2],
    pub offset: [f64; 2],
}

impl Placing {
    const PLAIN: Self = Self { scale: [1.0; 2], offset: [0.0; 2] };

    /// The texture coordinates under which a texture that lies plainly looks the same.
    pub fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        let placed = [0, 1].map(|axis| (f64::from(uv[axis]) * self.scale[axis] + self.offset[axis]) as f32);
        if placed.iter().all(|x| x.is_finite()) { placed } else { uv }
    }
}

/// What a statement says of a texture.
#[derive(Debug, PartialEq)]
pub(super) struct Texture {
    pub name: String,
    /// Whether the name was an absolute path.
    pub absolute: bool,
    pub placing: Option<Placing>,
    /// Whether it has options that change the image and are not read.
    pub ignored: bool,
}

/// Reads what stands behind `map_Kd`.
pub(super) fn read(rest: &str) -> Texture {
    let mut placing = Placing::PLAIN;
    let mut ignored = false;
    let mut rest = rest.trim();
    while let Some(option) = rest.strip_prefix('-').map(|rest| rest.split_whitespace().next().unwrap_or_default()) {
        rest = rest[1 + option.len()..].trim_start();
        match option {
            "s" | "o" | "t" => {
                let numbers = numbers(&mut rest, 3);
                let pair = |missing: f64| [0, 1].map(|at| numbers.get(at).copied().unwrap_or(missing));
                match option {
                    "s" => placing.scale = pair(1.0),
                    "o" => placing.offset = pair(0.0),
                    _ => ignored |= numbers.iter().any(|number| *number != 0.0),
                }
            }
            "mm" => ignored |= numbers(&mut rest, 2) != [0.0, 1.0],
            // The strength of bumps, the resolution to scale to, the sharpness of mip maps.
            "bm" | "texres" | "boost" => drop(numbers(&mut rest, 1)),
            // How texels are averaged, which is up to the renderer.
            "blendu" | "blendv" => drop(word(&mut rest)),
            "cc" | "clamp" => ignored |= word(&mut rest) != "off",
            "imfchan" | "type" => {
                word(&mut rest);
                ignored = true;
            }
            _ => ignored = true,
        }
    }
    let finite = placing.scale.into_iter().chain(placing.offset).all(|number| number.abs() < 1e6);
    ignored |= !finite;
    let placing = Some(placing).filter(|placing| finite && *placing != Placing::PLAIN);
    let (name, absolute) = file_name(without_comment(rest));
    Texture { name: name.to_owned(), absolute, placing, ignored }
}

/// Names may contain `#`: a comment begins behind an ending and a blank.
fn without_comment(name: &str) -> &str {
    for (at, _) in name.match_indices(" #") {
        let before = name[..at].trim_end();
        let ending = before.rsplit_once('.').map_or("", |(_, ending)| ending.trim_end_matches('"'));
        if (2..=5).contains(&ending.len()) && ending.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
            return before;
        }
    }
    name
}

/// Takes the first word off.
fn word<'t>(rest: &mut &'t str) -> &'t str {
    let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
    let (word, after) = rest.split_at(end);
    *rest = after.trim_start();
    word
}

/// Takes at most `most` numbers off. A name may be a number too: it is the last word.
fn numbers(rest: &mut &str, most: usize) -> Vec<f64> {
    let mut numbers = Vec::new();
    while numbers.len() < most {
        let mut after = *rest;
        let word = word(&mut after);
        match word.parse() {
            Ok(number) if !after.is_empty() => numbers.push(number),
            _ => break,
        }
        *rest = after;
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_names_are_told_apart() {
        let plain = |name: &str| Texture { name: name.to_owned(), absolute: false, placing: None, ignored: false };
        let placed = |scale, offset| Some(Placing { scale, offset });
        for (text, expected) in [
            ("oak.png", plain("oak.png")),
            ("my old oak.png", plain("my old oak.png")),
            ("\"my oak.png\" # old", plain("my oak.png")),
            ("oak #2.png # old", plain("oak #2.png")),
            ("-bm 0.5 -blendu on -texres 512 -mm 0 1 -clamp off -t 0 0 0 oak.png", plain("oak.png")),
            ("-s 1 1 1 -o 0 0 0 oak.png", plain("oak.png")),
            ("-s 2 3 4 -o 0.5 oak.png", Texture { placing: placed([2.0, 3.0], [0.5, 0.0]), ..plain("oak.png") }),
            ("-s 2 007", Texture { placing: placed([2.0, 1.0], [0.0; 2]), ..plain("007") }),
            ("-s nan 1 oak.png", Texture { ignored: true, ..plain("oak.png") }),
            ("-clamp on oak.png", Texture { ignored: true, ..plain("oak.png") }),
            ("-mm 0.1 2 a\\oak.png", Texture { ignored: true, ..plain("a\\oak.png") }),
            ("-new oak.png", Texture { ignored: true, ..plain("oak.png") }),
            ("D:\\oak.png", Texture { absolute: true, ..plain("oak.png") }),
            ("-s", plain("")),
            ("", plain("")),
        ] {
            assert_eq!(read(text), expected, "{text}");
        }
    }

    #[test]
    fn placing_scales_before_it_moves() {
        let placing = Placing { scale: [2.0, 3.0], offset: [0.5, -1.0] };
        assert_eq!(placing.apply([1.0, 0.5]), [2.5, 0.5]);
        assert_eq!(placing.apply([f32::MAX, 0.5]), [f32::MAX, 0.5]);
    }
}
