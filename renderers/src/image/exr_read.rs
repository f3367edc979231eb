//! Decodes OpenEXR: finds the colour channels, refuses claims that the bytes cannot hold.

use std::io::Cursor;

use exr::image::{AnyChannel, FlatSamples};
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, read};

use super::attributes::{DAMAGED, scan};
use super::{Attributes, Fault, Image, MAX_SIDE};

/// No compression of the format packs better than Deflate, whose limit is 1032 to 1 (zlib's
/// technical details); a header that claims more than this many times the file's size is wrong.
const BEST_COMPRESSION: usize = 1100;
/// Each block has at least a place in the offset table and a header of two numbers.
const LEAST_BLOCK: usize = 16;

/// Decodes a whole file.
pub(super) fn decode(bytes: &[u8]) -> Result<(Image, Attributes), Fault> {
    let (raw, _) = scan(bytes)?;
    let attributes = raw
        .iter()
        .filter(|attribute| attribute.kind == b"string")
        .map(|attribute| (lossy(attribute.name), lossy(attribute.value)))
        .collect();
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(decoder_fault)?;
    for header in &meta.headers {
        check(header, bytes.len())?;
    }
    // One thread: a pool would take the fault of a damaged block out of our hands, and decoding is
    // short beside rendering.
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(decoder_fault)?;
    let layer = &image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let channels = Channels::choose(&layer.channel_data.list)?;
    let pixels = (0..width * height).map(|index| channels.pixel(index)).collect();
    Ok((Image { width, height, pixels }, attributes))
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

/// The channels that hold the picture.
enum Channels<'a> {
    Colour([&'a FlatSamples; 3]),
    Grey(&'a FlatSamples),
}

impl<'a> Channels<'a> {
    /// Takes R, G and B; else the only layer with such channels inside (`Combined.R`); else Y.
    fn choose(list: &'a [AnyChannel<FlatSamples>]) -> Result<Self, Fault> {
        let names: Vec<String> = list.iter().map(|channel| lossy(channel.name.bytes())).collect();
        let find = |wanted: &str| -> Result<Option<&'a FlatSamples>, Fault> {
            let Some(index) = names.iter().position(|name| name == wanted) else { return Ok(None) };
            let channel = &list[index];
            if channel.sampling.x() != 1 || channel.sampling.y() != 1 {
                return Err(Fault::new(
                    format!("its channel `{wanted}` is stored at a lower resolution"),
                    "write the image with full RGB channels, without chroma subsampling",
                ));
            }
            if matches!(channel.sample_data, FlatSamples::U32(_)) {
                return Err(Fault::new(
                    format!("its channel `{wanted}` has whole numbers"),
                    "write the image with half or float channels",
                ));
            }
            Ok(Some(&channel.sample_data))
        };
        let colour = |prefix: &str| -> Result<Option<Self>, Fault> {
            let found = ["R", "G", "B"].map(|name| find(&format!("{prefix}{name}")));
            let [red, green, blue] = found;
            Ok(match (red?, green?, blue?) {
                (Some(red), Some(green), Some(blue)) => Some(Self::Colour([red, green, blue])),
                _ => None,
            })
        };
        if let Some(found) = colour("")? {
            return Ok(found);
        }
        let mut inside = Vec::new();
        for name in &names {
            if let Some(prefix) = name.strip_suffix('R').filter(|prefix| prefix.ends_with('.')) {
                inside.extend(colour(prefix)?);
            }
        }
        if inside.len() == 1 {
            return Ok(inside.remove(0));
        }
        let chroma = names.iter().any(|name| name == "RY" || name == "BY");
        match find("Y")? {
            Some(grey) if !chroma => Ok(Self::Grey(grey)),
            _ => Err(Fault::new(
                format!("it has no channels R, G, B or Y, only {}", names.join(", ")),
                "write the colour of the image as channels R, G and B",
            )),
        }
    }

    fn pixel(&self, index: usize) -> [f32; 3] {
        match self {
            Self::Colour(channels) => channels.map(|channel| sample(channel, index)),
            Self::Grey(channel) => [sample(channel, index); 3],
        }
    }
}

fn sample(samples: &FlatSamples, index: usize) -> f32 {
    match samples {
        FlatSamples::F16(values) => values[index].to_f32(),
        FlatSamples::F32(values) => values[index],
        // Whole numbers were refused when the channels were chosen.
        FlatSamples::U32(values) => values[index] as f32,
    }
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
