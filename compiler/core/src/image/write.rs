//! Pixels to bytes of image files. Equal pixels give equal bytes, on every machine.

use std::io::Cursor;

use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples};
use exr::prelude::{Compression, Image, Layer, LayerAttributes, LineOrder, WritableImage, f16};

use super::{ImageError, Pixels};

/// How many bits each channel of an OpenEXR file gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// 16: within a share of 2^-11 for numbers of 6e-5 to 65504, within 3e-8 below.
    Half,
    /// 32: as they are.
    Full,
}

/// Whether half floats hold all of the numbers.
pub fn fits_half(pixels: &Pixels) -> bool {
    pixels.values.iter().all(|value| f16::from_f32(*value).to_f32() == *value)
}

/// An OpenEXR file: one flat part, its data window the display window at the origin, channels R, G, B or Y.
pub fn exr(pixels: &Pixels, depth: Depth) -> Result<Vec<u8>, ImageError> {
    let names = if pixels.channels == 1 { &["Y"][..] } else { &["R", "G", "B"] };
    let channels = names.iter().enumerate().map(|(at, name)| {
        let values = pixels.values.iter().skip(at).step_by(pixels.channels).copied();
        let samples = match depth {
            Depth::Half => FlatSamples::F16(values.map(f16::from_f32).collect()),
            Depth::Full => FlatSamples::F32(values.collect()),
        };
        AnyChannel::new(*name, samples)
    });
    let channels = AnyChannels::sort(channels.collect());
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new((pixels.width, pixels.height), LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    // One thread: blocks end up in the order of their rows.
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|error| ImageError::new(format!("cannot be written as OpenEXR: {error}"), ""))?;
    Ok(bytes.into_inner())
}

/// A PNG file of whole numbers, 0..1 times the largest number of `bits`, which is 8 or 16.
pub fn png(pixels: &Pixels, bits: u8) -> Result<Vec<u8>, ImageError> {
    let fault = |error: png::EncodingError| ImageError::new(format!("cannot be written as PNG: {error}"), "");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width as u32, pixels.height as u32);
    encoder.set_color(if pixels.channels == 1 { png::ColorType::Grayscale } else { png::ColorType::Rgb });
    let data: Vec<u8> = if bits == 8 {
        encoder.set_depth(png::BitDepth::Eight);
        pixels.values.iter().map(|value| (value * 255.0).round() as u8).collect()
    } else {
        encoder.set_depth(png::BitDepth::Sixteen);
        pixels.values.iter().flat_map(|value| ((value * 65_535.0).round() as u16).to_be_bytes()).collect()
    };
    let mut writer = encoder.write_header().map_err(fault)?;
    writer.write_image_data(&data).map_err(fault)?;
    writer.finish().map_err(fault)?;
    Ok(bytes)
}

/// A portable float map, little-endian, its rows from the lowest up.
pub fn pfm(pixels: &Pixels) -> Vec<u8> {
    let kind = if pixels.channels == 1 { "Pf" } else { "PF" };
    let mut bytes = format!("{kind}\n{} {}\n-1\n", pixels.width, pixels.height).into_bytes();
    let row = pixels.width * pixels.channels;
    for row in pixels.values.chunks_exact(row.max(1)).rev() {
        bytes.extend(row.iter().flat_map(|value| value.to_le_bytes()));
    }
    bytes
}
