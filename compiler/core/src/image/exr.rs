//! OpenEXR (openexr.com, "OpenEXR File Layout"): which channels of a file are its picture, and their pixels within the display
//! window, in linear sRGB.

use std::io::Cursor;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, SampleType};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

use super::color::{Primaries, times};
use super::{ImageError, LONGEST_SIDE, Loss, Pixels, Remark};

/// No compression of the format packs better than Deflate, whose limit is 1032 to 1 (zlib's technical details).
const BEST_COMPRESSION: u64 = 1100;
/// Each block has at least a place in the offset table and a header of two numbers.
const LEAST_BLOCK: u64 = 16;

/// A file that has been read.
pub(super) struct Exr {
    /// The display window.
    pub pixels: Pixels,
    /// Whether the file is that and nothing else, so that all renderers read it alike.
    pub plain: bool,
    /// Whether a channel of the picture has 32 bits.
    pub full: bool,
    /// What of the file is not in the pixels as it stands there.
    pub remarks: Vec<Remark>,
}

/// The channels of a picture: three, or one.
struct Chosen {
    part: usize,
    /// What stands before `R`, `G` and `B`: empty, or the name of a layer with its dot.
    layer: String,
    color: bool,
}

pub(super) fn load(bytes: &[u8], most: u64) -> Result<Exr, ImageError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
    for header in &meta.headers {
        claims(header, bytes.len() as u64, most)?;
    }
    let (chosen, others) = choose(&meta.headers)?;
    let header = &meta.headers[chosen.part];
    let names = if chosen.color { &["R", "G", "B"][..] } else { &["Y"] };
    let names: Vec<String> = names.iter().map(|name| format!("{}{name}", chosen.layer)).collect();
    let full = check(header, &names)?;
    let data = read_channels(bytes, &names)?;
    let mut remarks = Vec::new();
    if !chosen.layer.is_empty() || chosen.part > 0 {
        let from = match chosen.layer.strip_suffix('.') {
            Some(layer) => format!("layer `{}`", layer.escape_debug()),
            None => format!("part {}", chosen.part + 1),
        };
        remarks.push(Remark::new(Loss::Baked, format!("is read as its {from} and nothing else")));
    } else if others.contains(&"A") {
        // Colors stay as they are: those of OpenEXR are premultiplied, and nothing is behind a surface or a sky.
        remarks.extend(opaque(bytes)?);
    }
    let (mut pixels, moved) = window(header, data, most, &mut remarks)?;
    let primaries = header.shared_attributes.chromaticities;
    if let Some(matrix) = primaries.map(matrix).transpose()?.flatten() {
        pixels = pixels.colored();
        for pixel in pixels.values.chunks_exact_mut(3) {
            let [r, g, b] = *pixel else { continue };
            let color = times(&matrix, [r, g, b].map(f64::from));
            pixel.iter_mut().zip(color).for_each(|(value, new)| *value = new as f32);
        }
        remarks.push(Remark::new(
            Loss::Baked,
            "has primaries of its own; its colors are converted to linear sRGB, white to white".to_owned(),
        ));
    }
    let same = header.channels.list.iter().all(|channel| channel.sample_type == header.channels.list[0].sample_type);
    let alone = header.channels.list.len() == names.len() && meta.headers.len() == 1 && chosen.layer.is_empty();
    let plain = alone && same && !moved && primaries.is_none();
    Ok(Exr { pixels, plain, full, remarks })
}

/// Refuses sizes that would take memory without reason.
fn claims(header: &Header, file: u64, most: u64) -> Result<(), ImageError> {
    let sides = |size: Vec2<usize>| [size.x() as u64, size.y() as u64];
    for [width, height] in [sides(header.layer_size), sides(header.shared_attributes.display_window.size)] {
        super::fits(width, height, most)?;
    }
    if header.deep {
        return Err(ImageError::new("is a deep image", "in its header")
            .help("save one flat image: no renderer reads another one as a picture"));
    }
    let [width, height] = sides(header.layer_size);
    let pixel: usize = header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
    let claimed = width.saturating_mul(height).saturating_mul(pixel as u64);
    if (header.chunk_count as u64).saturating_mul(LEAST_BLOCK) > file || claimed / BEST_COMPRESSION > file {
        return Err(ImageError::cut(format!("its header claims {width} x {height} pixels")));
    }
    Ok(())
}

/// R, G and B of the first part that has them; else the only layer with such channels inside, of several the one called
/// `Combined`; else Y. Beside it the names of the other channels of a part without layers.
fn choose(headers: &[Header]) -> Result<(Chosen, Vec<&str>), ImageError> {
    let names: Vec<Vec<String>> = headers
        .iter()
        .map(|header| header.channels.list.iter().map(|channel| channel.name.to_string()).collect())
        .collect();
    let has = |part: usize, layer: &str| {
        ["R", "G", "B"].iter().all(|name| names[part].iter().any(|known| *known == format!("{layer}{name}")))
    };
    let colored = |part, layer: String| Chosen { part, layer, color: true };
    if let Some(part) = (0..headers.len()).find(|part| has(*part, "")) {
        let alpha = names[part].iter().any(|name| name == "A");
        return Ok((colored(part, String::new()), if alpha { vec!["A"] } else { Vec::new() }));
    }
    let mut layers: Vec<(usize, String)> = Vec::new();
    for (part, names) in names.iter().enumerate() {
        for layer in names.iter().filter_map(|name| name.strip_suffix('R')).filter(|layer| layer.ends_with('.')) {
            if has(part, layer) && !layers.iter().any(|(_, known)| known == layer) {
                layers.push((part, layer.to_owned()));
            }
        }
    }
    let combined = |layer: &str| layer == "Combined." || layer.ends_with(".Combined.");
    let beauty: Vec<_> = layers.iter().filter(|(_, layer)| combined(layer)).collect();
    match (&beauty[..], &layers[..]) {
        ([(part, layer)], _) | ([], [(part, layer)]) => return Ok((colored(*part, layer.clone()), Vec::new())),
        ([], []) => {}
        _ => {
            let all: Vec<String> =
                layers.iter().map(|(_, layer)| format!("`{}`", layer.trim_end_matches('.').escape_debug())).collect();
            return Err(ImageError::new(
                format!("has several layers with colors: {}", all.join(", ")),
                "in its header",
            )
            .help("save the one that is meant as channels R, G and B"));
        }
    }
    for (part, names) in names.iter().enumerate() {
        let chroma = names.iter().any(|name| name == "RY" || name == "BY");
        if chroma {
            return Err(ImageError::new("holds luminance and chroma, which few renderers read", "in its header")
                .help("save it with channels R, G and B"));
        }
        if names.iter().any(|name| name == "Y") {
            let alpha = names.iter().any(|name| name == "A");
            let chosen = Chosen { part, layer: String::new(), color: false };
            return Ok((chosen, if alpha { vec!["A"] } else { Vec::new() }));
        }
    }
    let shown: Vec<String> = names.iter().flatten().take(8).map(|name| format!("`{}`", name.escape_debug())).collect();
    Err(ImageError::new(format!("has no channels R, G and B, and no Y, but {}", shown.join(", ")), "in its header")
        .help("save the picture as channels R, G and B"))
}

/// Refuses channels that are no picture; says whether one of them has 32 bits.
fn check(header: &Header, names: &[String]) -> Result<bool, ImageError> {
    let mut full = false;
    for channel in header.channels.list.iter().filter(|channel| names.contains(&channel.name.to_string())) {
        if channel.sampling != Vec2(1, 1) {
            return Err(ImageError::new("has channels of fewer pixels", "in its header").help("save it as RGB"));
        }
        match channel.sample_type {
            SampleType::F16 => {}
            SampleType::F32 => full = true,
            SampleType::U32 => {
                return Err(
                    ImageError::new("has channels of whole numbers", "in its header").help("save it as half or float")
                );
            }
        }
    }
    Ok(full)
}

/// The data window of the first part that has these channels.
fn read_channels(bytes: &[u8], names: &[String]) -> Result<Pixels, ImageError> {
    let (width, height, values) = match names {
        [r, g, b] => {
            let image = read()
                .no_deep_data()
                .largest_resolution_level()
                .specific_channels()
                .required(r.as_str())
                .required(g.as_str())
                .required(b.as_str())
                .collect_pixels(
                    |size, _| (size.x(), size.y(), vec![0.0_f32; size.area() * 3]),
                    |(width, _, values), at, (r, g, b): (f32, f32, f32)| {
                        let start = (at.y() * *width + at.x()) * 3;
                        values[start..start + 3].copy_from_slice(&[r, g, b]);
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map_err(fault)?;
            image.layer_data.channel_data.pixels
        }
        _ => {
            let image = read()
                .no_deep_data()
                .largest_resolution_level()
                .specific_channels()
                .required(names.first().map_or("Y", String::as_str))
                .collect_pixels(
                    |size, _| (size.x(), size.y(), vec![0.0_f32; size.area()]),
                    |(width, _, values), at, (y,): (f32,)| values[at.y() * *width + at.x()] = y,
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map_err(fault)?;
            image.layer_data.channel_data.pixels
        }
    };
    Ok(Pixels { width, height, channels: names.len(), values })
}

/// Says that an alpha that is not 1 everywhere is left out.
fn opaque(bytes: &[u8]) -> Result<Option<Remark>, ImageError> {
    let alpha = read_channels(bytes, &["A".to_owned()])?;
    let opaque = alpha.values.iter().all(|value| *value == 1.0);
    Ok((!opaque).then(Remark::alpha))
}

/// The display window, black where there are no data; and whether that is another one than the data window, or is not at the
/// origin.
fn window(header: &Header, data: Pixels, most: u64, remarks: &mut Vec<Remark>) -> Result<(Pixels, bool), ImageError> {
    let shown = header.shared_attributes.display_window;
    let Vec2(x, y) = header.own_attributes.layer_position;
    if shown.position == Vec2(x, y) && shown.size == header.layer_size {
        return Ok((data, shown.position != Vec2(0, 0)));
    }
    let (width, height) = (shown.size.x(), shown.size.y());
    super::fits(width as u64, height as u64, most)?;
    // Where the data begin, seen from the display window, which both lie within 32 bits.
    let (dx, dy) = (i64::from(x) - i64::from(shown.position.x()), i64::from(y) - i64::from(shown.position.y()));
    let mut values = vec![0.0; width * height * data.channels];
    let mut filled = false;
    for row in 0..data.height {
        let Some(to) = usize::try_from(row as i64 + dy).ok().filter(|to| *to < height) else { continue };
        let first = usize::try_from(-dx).unwrap_or(0);
        let start = usize::try_from(dx).unwrap_or(0);
        let count = data.width.saturating_sub(first).min(width.saturating_sub(start));
        if count == 0 {
            continue;
        }
        let from = (row * data.width + first) * data.channels;
        let into = (to * width + start) * data.channels;
        let count = count * data.channels;
        filled = true;
        values[into..into + count].copy_from_slice(&data.values[from..from + count]);
    }
    if !filled {
        return Err(ImageError::new("has no pixels within its display window", "in its header"));
    }
    let inside =
        dx <= 0 && dy <= 0 && dx + data.width as i64 >= width as i64 && dy + data.height as i64 >= height as i64;
    let how = if inside { "cut to its display window" } else { "filled up to its display window with black" };
    let size = format!("{} x {} instead of {width} x {height} pixels", data.width, data.height);
    remarks.push(Remark::new(Loss::Baked, format!("has data of {size}; it is {how}")));
    Ok((Pixels { width, height, channels: data.channels, values }, true))
}

/// From these primaries to linear sRGB; none where they are the same.
fn matrix(from: Chromaticities) -> Result<Option<[[f64; 3]; 3]>, ImageError> {
    let place = |at: Vec2<f32>| [f64::from(at.x()), f64::from(at.y())];
    let primaries =
        Primaries { red: place(from.red), green: place(from.green), blue: place(from.blue), white: place(from.white) };
    if primaries.is_rec_709() {
        return Ok(None);
    }
    primaries.to_srgb().map(Some).ok_or_else(|| {
        ImageError::new("has primaries that are no colors", "the attribute `chromaticities`")
            .help("remove the attribute, or write the primaries that are meant")
    })
}

fn fault(error: exr::error::Error) -> ImageError {
    use exr::error::Error;
    match error {
        Error::NotSupported(what) => {
            ImageError::new(format!("is a kind of OpenEXR that cannot be read: {what}"), "in its header")
                .help("save it as one flat part, with ZIP or PIZ compression")
        }
        other @ (Error::Aborted | Error::Invalid(_) | Error::Io(_)) => {
            ImageError::new("is cut off or damaged", other.to_string())
        }
    }
}

const _: () = assert!(LONGEST_SIDE < i32::MAX as u32);
