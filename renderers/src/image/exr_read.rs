//! Decodes OpenEXR: finds the color channels, refuses claims that the bytes cannot hold.

use std::io::Cursor;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

use super::attributes::{DAMAGED, scan};
use super::{Attributes, Fault, Image, MAX_SIDE, Window, exr_plain};

/// No compression of the format packs better than Deflate, whose limit is 1032 to 1 (zlib's
/// technical details); a header that claims more than this many times the file's size is wrong.
const BEST_COMPRESSION: usize = 1100;
/// Each block has at least a place in the offset table and a header of two numbers.
const LEAST_BLOCK: usize = 16;
/// How far primaries may be from those of Rec. 709 (red, green, blue, white): files round them.
const SAME_PLACE: f32 = 2e-3;
const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

/// A picture, where its pixels lie, and the string attributes of its file.
pub(super) type Decoded = (Image, Window, Attributes);

/// Decodes a whole file.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    let attributes = texts(bytes)?;
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decoder_fault)?;
    for header in &meta.headers {
        check(header, bytes.len())?;
    }
    let (part, names) = choose(&meta.headers)?;
    let header = &meta.headers[part];
    usable(header, &names)?;
    let image = match exr_plain::decode(bytes, &meta) {
        Some(image) => image,
        None => pixels(bytes, &names)?,
    };
    let shown = header.shared_attributes.display_window;
    let corner = |at: Vec2<i32>| (i64::from(at.x()), i64::from(at.y()));
    let window = Window {
        at: corner(header.own_attributes.layer_position),
        shown_at: corner(shown.position),
        shown: (shown.size.x(), shown.size.y()),
    };
    Ok((image, window, attributes))
}

/// The picture in the channels of a prefix, such as `error.`; none where no part of the file has them.
pub(super) fn layer(bytes: &[u8], prefix: &str) -> Result<Option<Image>, Fault> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decoder_fault)?;
    for header in &meta.headers {
        check(header, bytes.len())?;
    }
    let names: Vec<String> = ["R", "G", "B"].map(|name| format!("{prefix}{name}")).to_vec();
    let has = |header: &&Header, name: &String| header.channels.list.iter().any(|one| lossy(one.name.bytes()) == *name);
    let Some(header) = meta.headers.iter().find(|header| names.iter().all(|name| has(header, name))) else {
        return Ok(None);
    };
    usable(header, &names)?;
    pixels(bytes, &names).map(Some)
}

/// The names of all layers with channels R, G and B, such as `diffuse`, in the order of the file; nothing where the file has a picture
/// beside them.
pub(super) fn layers(bytes: &[u8]) -> Result<Vec<String>, Fault> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decoder_fault)?;
    for header in &meta.headers {
        check(header, bytes.len())?;
    }
    if choose(&meta.headers).is_ok() {
        return Ok(Vec::new());
    }
    let mut found: Vec<String> = Vec::new();
    for header in &meta.headers {
        let names: Vec<String> = header.channels.list.iter().map(|channel| lossy(channel.name.bytes())).collect();
        for layer in names.iter().filter_map(|name| name.strip_suffix(".R")) {
            let whole = ["G", "B"].iter().all(|color| names.iter().any(|name| *name == format!("{layer}.{color}")));
            if whole && !found.iter().any(|known| known == layer) {
                found.push(layer.to_owned());
            }
        }
    }
    Ok(found)
}

/// The string attributes in front of a file.
pub(super) fn texts(bytes: &[u8]) -> Result<Attributes, Fault> {
    let (raw, _) = scan(bytes)?;
    let texts = raw.iter().filter(|attribute| attribute.kind == b"string");
    Ok(texts.map(|attribute| (lossy(attribute.name), lossy(attribute.value))).collect())
}

/// Refuses sizes that would take memory without reason.
fn check(header: &Header, file: usize) -> Result<(), Fault> {
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(Fault::new(format!("its header claims {width}x{height} pixels"), DAMAGED));
    }
    let pixel: usize = header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
    let claimed = width.saturating_mul(height).saturating_mul(pixel);
    let blocks = header.chunk_count.saturating_mul(LEAST_BLOCK);
    if blocks > file || claimed / BEST_COMPRESSION > file {
        return Err(Fault::new(
            format!("its header claims {width}x{height} pixels, but the file has {file} bytes"),
            DAMAGED,
        ));
    }
    Ok(())
}

/// The part and the channels that hold the picture: R, G and B of the first part that has them; else the only layer with such
/// channels inside, of several the one called `Combined`; else Y.
fn choose(headers: &[Header]) -> Result<(usize, Vec<String>), Fault> {
    let names: Vec<Vec<String>> = headers
        .iter()
        .map(|header| header.channels.list.iter().map(|channel| lossy(channel.name.bytes())).collect())
        .collect();
    let color = |layer: &str| ["R", "G", "B"].map(|name| format!("{layer}{name}"));
    let has = |part: usize, layer: &str| color(layer).iter().all(|name| names[part].contains(name));
    if let Some(part) = (0..headers.len()).find(|part| has(*part, "")) {
        return Ok((part, color("").to_vec()));
    }
    let mut layers: Vec<(usize, &str)> = Vec::new();
    for (part, names) in names.iter().enumerate() {
        let inside = names.iter().filter_map(|name| name.strip_suffix('R')).filter(|layer| layer.ends_with('.'));
        for layer in inside.filter(|layer| has(part, layer)) {
            if !layers.iter().any(|(_, known)| *known == layer) {
                layers.push((part, layer));
            }
        }
    }
    let beauty = |layer: &str| layer == "Combined." || layer.ends_with(".Combined.");
    let combined: Vec<_> = layers.iter().filter(|(_, layer)| beauty(layer)).collect();
    match (&combined[..], &layers[..]) {
        ([(part, layer)], _) | ([], [(part, layer)]) => return Ok((*part, color(layer).to_vec())),
        ([], []) => {}
        _ => {
            let all: Vec<&str> = layers.iter().map(|(_, layer)| layer.trim_end_matches('.')).collect();
            return Err(Fault::new(
                format!("it has several layers with colors: {}", all.join(", ")),
                "write the layer that is meant as channels R, G and B",
            ));
        }
    }
    if names.iter().flatten().any(|name| name == "RY" || name == "BY") {
        return Err(Fault::new(
            "it holds luminance and chroma instead of RGB",
            "write the image with full RGB channels, without chroma subsampling",
        ));
    }
    match names.iter().position(|names| names.iter().any(|name| name == "Y")) {
        Some(part) => Ok((part, vec!["Y".to_owned()])),
        None => Err(Fault::new(
            format!("it has no channels R, G, B or Y, only {}", names.concat().join(", ")),
            "write the color of the image as channels R, G and B",
        )),
    }
}

/// Refuses channels and colors that would be taken for something else.
fn usable(header: &Header, names: &[String]) -> Result<(), Fault> {
    for channel in header.channels.list.iter().filter(|channel| names.contains(&lossy(channel.name.bytes()))) {
        let name = lossy(channel.name.bytes());
        if channel.sampling != Vec2(1, 1) {
            return Err(Fault::new(
                format!("its channel `{name}` is stored at a lower resolution"),
                "write the image with full RGB channels, without chroma subsampling",
            ));
        }
        if channel.sample_type == SampleType::U32 {
            return Err(Fault::new(
                format!("its channel `{name}` has whole numbers"),
                "write the image with half or float channels",
            ));
        }
    }
    if let Some(found) = header.shared_attributes.chromaticities {
        let places = [found.red, found.green, found.blue, found.white].map(|place| [place.x(), place.y()]);
        let off = |(a, b): (&f32, &f32)| (a - b).abs().is_nan() || (a - b).abs() > SAME_PLACE;
        if places.as_flattened().iter().zip(REC_709.as_flattened()).any(off) {
            return Err(Fault::new(
                "its colors have other primaries than those of sRGB (attribute `chromaticities`)",
                "convert it to linear sRGB: numbers of other primaries are other colors",
            ));
        }
    }
    Ok(())
}

/// The data window of the first part that has these channels.
pub(super) fn pixels(bytes: &[u8], names: &[String]) -> Result<Image, Fault> {
    // One thread: a pool would take the fault of a damaged block out of our hands, and decoding is
    // short beside rendering.
    let ([red, green, blue], grey) = match names {
        [red, green, blue] => ([red, green, blue], false),
        _ => ([&names[0]; 3], true),
    };
    let (width, height, pixels) = if grey {
        read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required(red.as_str())
            .collect_pixels(
                |size, _| (size.x(), size.y(), vec![[0.0_f32; 3]; size.area()]),
                |(width, _, pixels), at, (grey,): (f32,)| pixels[at.y() * *width + at.x()] = [grey; 3],
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(decoder_fault)?
            .layer_data
            .channel_data
            .pixels
    } else {
        read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required(red.as_str())
            .required(green.as_str())
            .required(blue.as_str())
            .collect_pixels(
                |size, _| (size.x(), size.y(), vec![[0.0_f32; 3]; size.area()]),
                |(width, _, pixels), at, (r, g, b): (f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(decoder_fault)?
            .layer_data
            .channel_data
            .pixels
    };
    Ok(Image { width, height, pixels })
}

fn decoder_fault(error: exr::error::Error) -> Fault {
    match error {
        exr::error::Error::NotSupported(what) => Fault::new(
            format!("this kind of OpenEXR file is not supported: {what}"),
            "write it as one flat layer with ZIP compression",
        ),
        other => Fault::new(other.to_string(), DAMAGED),
    }
}

fn lossy(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
