//! Portable float maps, and Radiance's pictures.

use super::{ImageError, Pixels, Remark};

/// The longest header that is looked at, in bytes.
const HEADER: usize = 4096;

/// What the header of a portable float map says.
pub(super) struct Pfm {
    pub width: u32,
    pub height: u32,
    channels: usize,
    /// Where the numbers begin.
    at: usize,
    little: bool,
}

/// A portable float map (Debevec): `PF` or `Pf`, width and height, a scale whose sign says the order of bytes.
pub(super) fn pfm(bytes: &[u8]) -> Result<Pfm, ImageError> {
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut at = 2;
    let mut word = || {
        let head = &bytes[..bytes.len().min(HEADER)];
        let start = head.get(at..).unwrap_or_default().iter().position(|byte| !byte.is_ascii_whitespace())? + at;
        let end = head[start..].iter().position(u8::is_ascii_whitespace)? + start;
        at = end + 1;
        std::str::from_utf8(&head[start..end]).ok()
    };
    let (width, height, scale) = (word(), word(), word());
    let side = |word: Option<&str>| word.and_then(|word| word.parse::<u32>().ok());
    let scale = scale.and_then(|word| word.parse::<f64>().ok());
    let (Some(width), Some(height), Some(scale)) = (side(width), side(height), scale) else {
        return Err(ImageError::new("has no width, height and scale", "in its header"));
    };
    if scale.abs() != 1.0 {
        return Err(ImageError::new(format!("has the scale {scale}"), "in its header")
            .help("save it with scale 1 or -1: some renderers apply another one, some do not"));
    }
    let size = u64::from(width) * u64::from(height) * channels as u64 * 4;
    let there = (bytes.len() - at.min(bytes.len())) as u64;
    if there < size {
        return Err(ImageError::cut(format!("{there} bytes of pixels instead of {size}")));
    }
    Ok(Pfm { width, height, channels, at, little: scale < 0.0 })
}

/// Its pixels; the file has its lowest row first.
pub(super) fn pfm_pixels(bytes: &[u8]) -> Result<Pixels, ImageError> {
    let Pfm { width, height, channels, at, little } = pfm(bytes)?;
    let (width, height) = (width as usize, height as usize);
    let row = width * channels;
    let number = |four: &[u8; 4]| if little { f32::from_le_bytes(*four) } else { f32::from_be_bytes(*four) };
    let (numbers, _) = bytes[at..].as_chunks::<4>();
    let values = numbers[..row * height].chunks_exact(row.max(1)).rev().flatten().map(number).collect();
    Ok(Pixels { width, height, channels, values })
}

/// What the header of a picture of Radiance says.
pub(super) struct Hdr {
    pub width: u32,
    pub height: u32,
    /// Where the rows begin.
    at: usize,
    /// Lines by which some programs change the numbers: where they stand, and what they say.
    spoken: Vec<(std::ops::Range<usize>, String)>,
}

/// Variables of the header that say something of the numbers (`picture.5` of Radiance).
const SPOKEN: [&str; 4] = ["EXPOSURE", "COLORCORR", "PRIMARIES", "GAMMA"];

/// A picture of Radiance (Ward, "Real Pixels", and `picture.5` of Radiance).
pub(super) fn hdr(bytes: &[u8]) -> Result<Hdr, ImageError> {
    let place = || "in its header".to_owned();
    let head = &bytes[..bytes.len().min(HEADER)];
    let mut at = 0;
    let mut line = || {
        let end = head.get(at..)?.iter().position(|byte| *byte == b'\n')? + at;
        let line = at..end;
        at = end + 1;
        Some(line)
    };
    let mut format = false;
    let mut spoken = Vec::new();
    while let Some(place_of) = line() {
        let text = &head[place_of.clone()];
        if text.is_empty() {
            break;
        }
        if let Some(name) = text.strip_prefix(b"FORMAT=") {
            if name != b"32-bit_rle_rgbe" {
                return Err(ImageError::new("holds other colors than RGB", place()).help("save it as RGBE"));
            }
            format = true;
        }
        let text = String::from_utf8_lossy(text);
        if let Some((name, value)) = text.split_once('=').filter(|(name, _)| SPOKEN.contains(&name.trim())) {
            // A gamma or exposure of 1 says nothing.
            if value.trim().parse::<f64>().ok() != Some(1.0) {
                let what = format!("`{}={}`", name.trim(), value.trim().escape_debug());
                spoken.push((place_of.start..place_of.end + 1, what));
            }
        }
    }
    let size = line().and_then(|line| std::str::from_utf8(&head[line]).ok()).unwrap_or_default();
    let words: Vec<&str> = size.split_ascii_whitespace().collect();
    let ["-Y", height, "+X", width] = words[..] else {
        return Err(ImageError::new("has no size, or its rows do not run from top to bottom", place())
            .help("save it with the usual order of pixels, `-Y height +X width`"));
    };
    let (Ok(width), Ok(height)) = (width.parse(), height.parse()) else {
        return Err(ImageError::new("has no size", place()));
    };
    if !format {
        return Err(ImageError::new("does not say its format", place()));
    }
    if bytes.len() <= at {
        return Err(ImageError::cut("behind its header"));
    }
    Ok(Hdr { width, height, at, spoken })
}

/// Its pixels, and the file without lines that say something else than the numbers.
pub(super) fn hdr_load(bytes: &[u8]) -> Result<(Pixels, Vec<u8>, Vec<Remark>), ImageError> {
    let Hdr { width, height, at, spoken } = hdr(bytes)?;
    let (width, height) = (width as usize, height as usize);
    // A row of the usual kind takes at least its mark and two bytes for 127 numbers of each part; a plain one 4 bytes a pixel,
    // a repeated pixel of the old kind stands for at most 255 in each of up to three steps.
    if (bytes.len() - at) < height {
        return Err(ImageError::cut("behind its header"));
    }
    let mut rows = Rows { bytes: &bytes[at..], at: 0 };
    let mut values = Vec::with_capacity(width * height * 3);
    let mut row = vec![[0_u8; 4]; width];
    for _ in 0..height {
        rows.row(&mut row)?;
        values.extend(row.iter().flat_map(|pixel| float(*pixel)));
    }
    let mut plain = Vec::with_capacity(bytes.len());
    let mut from = 0;
    for (line, _) in &spoken {
        plain.extend_from_slice(&bytes[from..line.start]);
        from = line.end;
    }
    plain.extend_from_slice(&bytes[from..]);
    let remarks = spoken.iter().map(|(_, what)| Remark::unread(what)).collect();
    Ok((Pixels { width, height, channels: 3, values }, plain, remarks))
}

/// The numbers of a pixel with a shared exponent.
fn float([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    // 2^(e - 128) / 256: exact, subnormal at the least.
    let scale = libm::ldexp(1.0, i32::from(e) - 136);
    [r, g, b].map(|part| (f64::from(part) * scale) as f32)
}

struct Rows<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Rows<'_> {
    fn four(&mut self) -> Result<[u8; 4], ImageError> {
        let found = self.bytes.get(self.at..self.at + 4).and_then(|four| <[u8; 4]>::try_from(four).ok());
        self.at += 4;
        found.ok_or_else(|| ImageError::cut("within its pixels"))
    }

    fn byte(&mut self) -> Result<u8, ImageError> {
        let found = self.bytes.get(self.at).copied();
        self.at += 1;
        found.ok_or_else(|| ImageError::cut("within its pixels"))
    }

    fn row(&mut self, row: &mut [[u8; 4]]) -> Result<(), ImageError> {
        let width = row.len();
        let first = self.four()?;
        let [2, 2, high, low] = first else { return self.old(first, row) };
        if usize::from(high) << 8 | usize::from(low) != width || width < 8 {
            return self.old(first, row);
        }
        for part in 0..4 {
            let mut at = 0;
            while at < width {
                let count = self.byte()?;
                let (repeated, count) = if count > 128 { (true, count - 128) } else { (false, count) };
                let run = row.get_mut(at..at + usize::from(count)).filter(|run| !run.is_empty());
                let run = run.ok_or_else(|| ImageError::new("has a row that is too long", "within its pixels"))?;
                at += run.len();
                let mut value = 0;
                for (index, pixel) in run.iter_mut().enumerate() {
                    if index == 0 || !repeated {
                        value = self.byte()?;
                    }
                    pixel[part] = value;
                }
            }
        }
        Ok(())
    }

    /// Pixels one by one; 1, 1, 1, n repeats the last one n times, and further such pixels 256 times as often each.
    fn old(&mut self, first: [u8; 4], row: &mut [[u8; 4]]) -> Result<(), ImageError> {
        let wrong = || ImageError::new("has a row that is too long", "within its pixels");
        let (mut at, mut shift, mut next) = (0, 0, Some(first));
        while at < row.len() {
            let pixel = match next.take() {
                Some(first) => first,
                None => self.four()?,
            };
            if let [1, 1, 1, count] = pixel {
                let count = usize::from(count) << shift;
                let last = *at.checked_sub(1).and_then(|last: usize| row.get(last)).ok_or_else(wrong)?;
                let end = at.checked_add(count).filter(|end| *end <= row.len()).ok_or_else(wrong)?;
                row[at..end].fill(last);
                (at, shift) = (end, if shift < 16 { shift + 8 } else { return Err(wrong()) });
            } else {
                row[at] = pixel;
                (at, shift) = (at + 1, 0);
            }
        }
        Ok(())
    }
}
