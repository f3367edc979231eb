//! Files made by hand, whole, damaged and cut, and what they mean.

use super::*;
use crate::ir::Encoding;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples, Image, Layer};
use ::exr::math::Vec2;
use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::{IntegerBounds, LayerAttributes, WritableImage, f16};
use proptest::prelude::*;

const MOST: u64 = 1 << 20;

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut sum = !0_u32;
    for byte in kind.iter().chain(data) {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 };
        }
    }
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &(!sum).to_be_bytes()].concat()
}

/// A PNG file of two columns and one row, or what the encoder makes of `set`.
fn png_of(
    color: ::png::ColorType,
    depth: ::png::BitDepth,
    data: &[u8],
    set: impl Fn(&mut ::png::Encoder<&mut Vec<u8>>),
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(color);
    encoder.set_depth(depth);
    set(&mut encoder);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(data).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

fn rgb_png(data: &[u8; 6]) -> Vec<u8> {
    png_of(::png::ColorType::Rgb, ::png::BitDepth::Eight, data, |_| {})
}

/// The file with a chunk behind its header.
fn with(png: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    [&png[..33], &chunk(kind, data), &png[33..]].concat()
}

const JPEG: &[u8] = include_bytes!("../../../../tests/cases/images/quads.jpg");

fn jpeg(name: &str) -> Vec<u8> {
    let bytes: &[u8] = match name {
        "cmyk" => include_bytes!("../../../../tests/cases/images/cmyk.jpg"),
        "profile" => include_bytes!("../../../../tests/cases/images/profile.jpg"),
        "progressive" => include_bytes!("../../../../tests/cases/images/progressive.jpg"),
        "rgb" => include_bytes!("../../../../tests/cases/images/rgb.jpg"),
        "srgb_icc" => include_bytes!("../../../../tests/cases/images/srgb_icc.jpg"),
        "turned" => include_bytes!("../../../../tests/cases/images/turned.jpg"),
        other => panic!("{other}"),
    };
    bytes.to_vec()
}

fn half(values: &[f32]) -> FlatSamples {
    FlatSamples::F16(values.iter().map(|value| f16::from_f32(*value)).collect())
}

/// A part of a file: its channels, its size, and where its data begin.
fn part(channels: Vec<(&str, FlatSamples)>, size: (usize, usize), at: (i32, i32)) -> Layer<AnyChannels<FlatSamples>> {
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let attributes = LayerAttributes { layer_position: Vec2(at.0, at.1), ..LayerAttributes::default() };
    Layer::new(size, attributes, ::exr::image::Encoding::FAST_LOSSLESS, AnyChannels::sort(channels))
}

fn written(
    layers: Vec<Layer<AnyChannels<FlatSamples>>>,
    shown: IntegerBounds,
    primaries: Option<Chromaticities>,
) -> Vec<u8> {
    let mut image = Image::from_layers(::exr::meta::header::ImageAttributes::new(shown), layers);
    image.attributes.chromaticities = primaries;
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).expect("an image");
    bytes.into_inner()
}

/// Two pixels in a row.
fn exr_of(channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
    written(vec![part(channels, (2, 1), (0, 0))], bounds((0, 0), (2, 1)), None)
}

fn bounds(at: (i32, i32), size: (usize, usize)) -> IntegerBounds {
    IntegerBounds::new(at, size)
}

fn rgb(values: [[f32; 2]; 3]) -> Vec<(&'static str, FlatSamples)> {
    ["R", "G", "B"].into_iter().zip(values).map(|(name, values)| (name, half(&values))).collect()
}

const HDR: &[u8] = b"#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x20\x81\x01\x01\x01\x01";

fn loaded(ending: &str, bytes: &[u8]) -> (Loaded, Pixels) {
    let loaded = load(ending, bytes, MOST).unwrap_or_else(|error| panic!("{ending}: {error:?}"));
    let encoding = Encoding::Linear;
    let texture = Texture {
        name: "t".to_owned(),
        file: loaded.file.clone(),
        image: loaded.info,
        encoding,
        peak: loaded.peak,
        factor: [1.0; 3],
    };
    let pixels = stored(&texture).expect("what was read is read again");
    // What is plain stays as it is.
    let again = load(loaded.info.format.ending(), &loaded.file, MOST).expect("a plain file");
    assert_eq!((&again.file, again.info, again.remarks.len()), (&loaded.file, loaded.info, 0));
    (loaded, pixels)
}

fn remarks(ending: &str, bytes: &[u8]) -> Vec<(Loss, String)> {
    loaded(ending, bytes).0.remarks.into_iter().map(|remark| (remark.loss, remark.message)).collect()
}

fn wrong(ending: &str, bytes: &[u8]) -> String {
    load(ending, bytes, MOST).map_or_else(|error| error.message, |loaded| panic!("{:?}", loaded.info))
}

#[test]
fn plain_files_stay_as_they_are() {
    let deep = png_of(::png::ColorType::Grayscale, ::png::BitDepth::Sixteen, &[0x12, 0x34, 0xff, 0xff], |_| {});
    let grey = [&b"Pf\n2 1\n-1.0\n"[..], &0.5_f32.to_le_bytes(), &2.0_f32.to_le_bytes()].concat();
    let color = rgb([[0.5, 1.0], [0.25, 4.0], [0.0, 1.0]]);
    let kinds: [(&str, Vec<u8>, u8, u8, f64); 7] = [
        ("png", rgb_png(&[255, 0, 0, 0, 51, 0]), 3, 8, 1.0),
        ("png", deep, 1, 16, 1.0),
        ("jpg", JPEG.to_vec(), 3, 8, f64::NAN),
        ("exr", exr_of(color), 3, 16, 4.0),
        ("exr", exr_of(vec![("Y", FlatSamples::F32(vec![1.0, 1e30]))]), 1, 32, f64::from(1e30_f32)),
        ("pfm", grey, 1, 32, 2.0),
        ("hdr", HDR.to_vec(), 3, 32, 1.0),
    ];
    for (ending, bytes, channels, bits, peak) in kinds {
        let (loaded, _) = loaded(ending, &bytes);
        assert_eq!((&loaded.file[..], loaded.remarks.len()), (&bytes[..], 0), "{ending}");
        assert_eq!((loaded.info.channels, loaded.info.bits), (channels, bits), "{ending}");
        assert!(peak.is_nan() || loaded.peak == peak, "{ending}: {}", loaded.peak);
    }
    assert_eq!(loaded("hdr", HDR).1.values, [1.0, 0.5, 0.25, 1.0, 0.5, 0.25], "a pixel, repeated in the old way");
}

#[test]
fn codes_of_png_stay_whatever_holds_them() {
    use ::png::{BitDepth, ColorType};
    let plain = rgb_png(&[255, 0, 10, 0, 51, 0]);
    let wanted = loaded("png", &plain).1;
    let palette = png_of(ColorType::Indexed, BitDepth::Two, &[0b0100_0000], |encoder| {
        encoder.set_palette(vec![0, 51, 0, 255, 0, 10]);
    });
    assert_eq!(loaded("png", &palette).1, wanted);
    assert!(loaded("png", &palette).0.remarks.is_empty());
    let low = png_of(ColorType::Grayscale, BitDepth::Two, &[0b0100_0000], |_| {});
    assert_eq!(loaded("png", &low).1.values, [85.0 / 255.0, 0.0]);
    // Alpha that is 1 everywhere is no loss, and another one is.
    let solid = png_of(ColorType::Rgba, BitDepth::Eight, &[255, 0, 10, 255, 0, 51, 0, 255], |_| {});
    let clear = png_of(ColorType::Rgba, BitDepth::Eight, &[255, 0, 10, 255, 0, 51, 0, 7], |_| {});
    assert_eq!((loaded("png", &solid).1, remarks("png", &solid)), (wanted.clone(), vec![]));
    assert_eq!(loaded("png", &clear).1, wanted);
    assert!(matches!(&remarks("png", &clear)[..], [(Loss::Dropped, what)] if what.contains("alpha")));
    let keyed = with(&plain, b"tRNS", &[0, 255, 0, 0, 0, 10]);
    assert_eq!(loaded("png", &keyed).1, wanted);
    assert_eq!(remarks("png", &keyed).len(), 1);
}

#[test]
fn what_a_png_says_of_its_numbers_is_left_out_and_said() {
    let plain = rgb_png(&[255, 0, 10, 0, 51, 0]);
    let white = [31_270_u32, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000].map(u32::to_be_bytes).concat();
    let other = [34_567_u32, 35_850, 73_470, 26_530, 11_500, 82_600, 15_660, 1_770].map(u32::to_be_bytes).concat();
    let gamma = |gamma: u32| with(&plain, b"gAMA", &gamma.to_be_bytes());
    for (bytes, said) in [
        (gamma(45_455), None),
        (gamma(100_000), Some("gamma of 1")),
        (with(&gamma(100_000), b"sRGB", &[0]), None),
        (with(&plain, b"cHRM", &white), None),
        (with(&plain, b"cHRM", &other), Some("primaries")),
        (with(&plain, b"cICP", &[1, 13, 0, 1]), None),
        (with(&plain, b"cICP", &[9, 16, 0, 1]), Some("color space")),
        (
            with(&plain, b"eXIf", b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"),
            Some("orientation"),
        ),
        (with(&plain, b"tEXt", b"a\0b"), None),
    ] {
        let found = remarks("png", &bytes);
        assert_eq!(found.len(), usize::from(said.is_some()), "{found:?}");
        assert!(found.iter().zip(said).all(|((loss, what), said)| *loss == Loss::Dropped && what.contains(said)));
        let (loaded, _) = loaded("png", &bytes);
        // The chunk is gone, and nothing else.
        let text = bytes.windows(4).any(|part| part == b"tEXt");
        assert_eq!(&loaded.file[..], if text { &bytes[..] } else { &plain[..] });
    }
}

#[test]
fn jpeg_is_read_by_its_numbers() {
    let plain = loaded("jpg", JPEG).1;
    // What libjpeg makes of it: the same within a code, and within two where halved chroma is interpolated over an edge.
    for (x, y, wanted, off) in [
        (3, 3, [201, 60, 40], 1),
        (12, 3, [38, 179, 66], 1),
        (3, 12, [53, 68, 193], 1),
        (12, 12, [219, 222, 213], 1),
        (7, 7, [138, 85, 77], 2),
        (8, 8, [206, 225, 229], 2),
        (8, 7, [96, 146, 83], 2),
    ] {
        let found = plain.at(x, y).map(|value| (value * 255.0).round() as i32);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= off), "{found:?} for {wanted:?} at {x}, {y}");
    }
    let progressive = loaded("jpg", &jpeg("progressive"));
    assert!(progressive.0.remarks.is_empty());
    assert!((progressive.1.at(3, 3)[0] * 255.0 - 200.0).abs() <= 4.0);
    // An orientation and a profile of Lab are not applied, and gone; one of sRGB says nothing else than we do.
    for (name, said) in [("turned", Some("orientation")), ("profile", Some("profile")), ("srgb_icc", None)] {
        let bytes = jpeg(name);
        let found = remarks("jpg", &bytes);
        assert_eq!(found.len(), usize::from(said.is_some()), "{name}: {found:?}");
        assert!(found.iter().zip(said).all(|((loss, what), said)| *loss == Loss::Dropped && what.contains(said)));
        let (loaded, pixels) = loaded("jpg", &bytes);
        assert_eq!((loaded.file.len() < bytes.len(), pixels.width), (said.is_some(), 16));
        assert!((pixels.at(3, 3)[0] * 255.0 - 200.0).abs() <= 2.0, "the corner is where it was");
    }
    assert!(wrong("jpg", &jpeg("cmyk")).contains("4 channels"));
    assert!(wrong("jpg", &jpeg("rgb")).contains("instead of luma and chroma"));
    assert!(wrong("jpg", &JPEG[..300]).contains("cut off"));
}

#[test]
fn openexr_is_its_display_window() {
    // Two pixels at (1, 0), of three shown: the first one is black.
    let data = |at| vec![part(rgb([[1.0, 2.0], [0.0; 2], [0.0; 2]]), (2, 1), at)];
    let red = |bytes: &[u8]| loaded("exr", bytes).1.values.chunks(3).map(|pixel| pixel[0]).collect::<Vec<_>>();
    for (at, origin, size, wanted, how) in [
        ((1, 0), (0, 0), (3, 1), &[0.0, 1.0, 2.0][..], "filled"),
        ((-1, 0), (0, 0), (1, 1), &[2.0], "cut"),
        ((5, 7), (4, 6), (2, 2), &[0.0, 0.0, 0.0, 1.0], "filled"),
        ((-1, -1), (-1, -1), (2, 1), &[1.0, 2.0], ""),
    ] {
        let bytes = written(data(at), bounds(origin, size), None);
        assert_eq!(red(&bytes), wanted, "{at:?} in {origin:?}");
        let found = remarks("exr", &bytes);
        let said =
            if how.is_empty() { found.is_empty() } else { found[0].0 == Loss::Baked && found[0].1.contains(how) };
        assert!(said, "{found:?}");
    }
    assert!(wrong("exr", &written(data((5, 0)), bounds((0, 0), (2, 1)), None)).contains("no pixels within"));
}

#[test]
fn openexr_of_other_primaries_becomes_srgb() {
    let place = |x, y| Vec2(x, y);
    let ap1 = Chromaticities {
        red: place(0.713, 0.293),
        green: place(0.165, 0.83),
        blue: place(0.128, 0.044),
        white: place(0.321_68, 0.337_67),
    };
    let of = |values, primaries| written(vec![part(rgb(values), (2, 1), (0, 0))], bounds((0, 0), (2, 1)), primaries);
    let bytes = of([[0.8, 0.8], [0.0, 0.8], [0.0, 0.8]], Some(ap1));
    let (loaded_, pixels) = loaded("exr", &bytes);
    // 0.8 of AP1's red, its negative parts cut; white stays white.
    let close =
        |found: [f32; 3], wanted: [f64; 3]| found.iter().zip(wanted).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-3);
    assert!(close(pixels.at(0, 0), [1.3637, 0.0, 0.0]) && close(pixels.at(1, 0), [0.8; 3]), "{pixels:?}");
    assert_eq!(loaded_.info.bits, 32);
    let losses: Vec<Loss> = loaded_.remarks.iter().map(|remark| remark.loss).collect();
    assert_eq!(losses, [Loss::Baked, Loss::Approximated]);
    // Those of Rec. 709 are left out: they say nothing.
    let rec709 = Chromaticities {
        red: place(0.64, 0.33),
        green: place(0.3, 0.6),
        blue: place(0.15, 0.06),
        white: place(0.3127, 0.329),
    };
    let same = of([[0.8, 0.5], [0.0, 0.5], [0.0, 0.5]], Some(rec709));
    assert_eq!(remarks("exr", &same), vec![]);
    assert_eq!(loaded("exr", &same).1.at(0, 0), [f16::from_f32(0.8).to_f32(), 0.0, 0.0]);
    let flat = Chromaticities { red: place(0.3, 0.6), ..rec709 };
    assert!(wrong("exr", &of([[0.8; 2]; 3], Some(flat))).contains("no colors"));
}

#[test]
fn openexr_of_layers_and_parts_is_the_picture_in_it() {
    let value = |value: f32| half(&[value, value]);
    let layer = |name: &'static str, bright: f32| {
        ["R", "G", "B"].map(|channel| (format!("{name}.{channel}"), value(bright))).to_vec()
    };
    let of = |channels: Vec<(String, FlatSamples)>| {
        let channels = channels.iter().map(|(name, samples)| (name.as_str(), samples.clone())).collect();
        exr_of(channels)
    };
    let bright = |bytes: &[u8]| loaded("exr", bytes).1.at(0, 0)[0];
    assert_eq!(bright(&of(layer("main", 0.5))), 0.5);
    let blender = [layer("ViewLayer.Noisy Image", 2.0), layer("ViewLayer.Combined", 0.5)].concat();
    assert_eq!(bright(&of(blender.clone())), 0.5);
    assert!(matches!(&remarks("exr", &of(blender))[..], [(Loss::Baked, what)] if what.contains("ViewLayer.Combined")));
    assert!(wrong("exr", &of([layer("a", 1.0), layer("b", 1.0)].concat())).contains("several layers"));
    // The picture in the second part.
    let named = |name: &str, mut part: Layer<AnyChannels<FlatSamples>>| {
        part.attributes.layer_name = Some(name.into());
        part
    };
    let depth = named("depth", part(vec![("Z", value(9.0))], (2, 1), (0, 0)));
    let picture = named("picture", part(rgb([[0.5; 2]; 3]), (2, 1), (0, 0)));
    let bytes = written(vec![depth, picture], bounds((0, 0), (2, 1)), None);
    assert_eq!(bright(&bytes), 0.5);
    assert!(matches!(&remarks("exr", &bytes)[..], [(Loss::Baked, what)] if what.contains("part 2")));
    // More channels beside a picture, an alpha, and what is none.
    let alpha = |alpha: f32| {
        let mut channels = rgb([[0.5; 2]; 3]);
        channels.push(("A", value(alpha)));
        exr_of(channels)
    };
    assert_eq!((bright(&alpha(1.0)), remarks("exr", &alpha(1.0)).len()), (0.5, 0));
    assert_eq!((bright(&alpha(0.5)), remarks("exr", &alpha(0.5)).len()), (0.5, 1));
    let chroma = exr_of(vec![("Y", value(1.0)), ("RY", value(0.0)), ("BY", value(0.0))]);
    assert!(wrong("exr", &chroma).contains("luminance and chroma"));
    assert!(wrong("exr", &exr_of(vec![("Z", value(1.0))])).contains("but `Z`"));
    assert!(wrong("exr", &exr_of(vec![("Y", FlatSamples::U32(vec![1, 2]))])).contains("whole numbers"));
}

#[test]
fn numbers_that_are_no_light_are_refused_or_become_0() {
    let [nan, infinite] = [f32::NAN, f32::INFINITY].map(|bad| exr_of(rgb([[0.5; 2], [0.5; 2], [0.5, bad]])));
    assert!(wrong("exr", &nan).contains("number NaN in column 1 of row 0") && wrong("exr", &infinite).contains("inf"));
    let pfm = |value: f32| [&b"Pf\n1 2\n-1\n"[..], &value.to_le_bytes(), &1.0_f32.to_le_bytes()].concat();
    assert!(wrong("pfm", &pfm(f32::NAN)).contains("column 0 of row 1"), "the file has its lowest row first");
    for (ending, bytes) in [("pfm", pfm(-0.25)), ("exr", exr_of(rgb([[0.5, -0.25], [0.0; 2], [0.0; 2]])))] {
        let (loaded, pixels) = loaded(ending, &bytes);
        assert_eq!(pixels.values.iter().copied().fold(f32::INFINITY, f32::min), 0.0);
        let [remark] = &loaded.remarks[..] else { panic!("{:?}", loaded.remarks) };
        assert!(
            remark.loss == Loss::Approximated && remark.message.contains("the negative number -0.25"),
            "{remark:?}"
        );
    }
}

#[test]
fn radiance_pictures_are_their_numbers() {
    let with = |line: &str| {
        let text = String::from_utf8_lossy(&HDR[..11]).into_owned() + line + "\n";
        [text.as_bytes(), &HDR[11..]].concat()
    };
    assert_eq!(remarks("hdr", &with("EXPOSURE=1")), vec![]);
    let bright = with("EXPOSURE=2.5");
    assert!(matches!(&remarks("hdr", &bright)[..], [(Loss::Dropped, what)] if what.contains("`EXPOSURE=2.5`")));
    assert_eq!(&loaded("hdr", &bright).0.file[..], HDR);
    // A row of the usual packing: 8 pixels, each part a run.
    let packed = [
        &b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n\x02\x02\0\x08"[..],
        b"\x88\x80\x88\x40\x82\x20\x06\x20\x20\x20\x20\x20\0\x88\x81",
    ]
    .concat();
    let pixels = loaded("hdr", &packed).1;
    assert_eq!(
        (pixels.at(0, 0), pixels.at(6, 0), pixels.at(7, 0)),
        ([1.0, 0.5, 0.25], [1.0, 0.5, 0.25], [1.0, 0.5, 0.0])
    );
}

#[test]
fn claims_are_bounded() {
    let huge = |ending: &str, bytes: &[u8]| {
        let error = load(ending, bytes, MOST).expect_err("too large");
        (error.id, error.message)
    };
    let mut png = rgb_png(&[0; 6]);
    png.splice(16..24, [60_000_u32.to_be_bytes(), 60_000_u32.to_be_bytes()].concat());
    let mut jpeg = JPEG.to_vec();
    let frame = jpeg.windows(2).position(|two| two == b"\xff\xc0").expect("a frame");
    jpeg.splice(frame + 5..frame + 9, [0xea, 0x60, 0xea, 0x60]);
    let pfm = [&b"PF\n60000 60000\n-1\n"[..], &[0; 100]].concat();
    let hdr = [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n"[..], &[0; 100]].concat();
    for (ending, bytes) in [("png", png), ("jpg", jpeg), ("hdr", hdr)] {
        let (id, message) = huge(ending, &bytes);
        assert!(id == "image-limit" && message.contains("60000 x 60000"), "{ending}: {id} {message}");
    }
    assert!(huge("pfm", &pfm).1.contains("cut off"), "the pixels would have to be there");
    let exr = exr_of(rgb([[0.0; 2]; 3]));
    for window in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let mut exr = exr.clone();
        let at = exr.windows(window.len()).position(|part| part == window).expect("a window") + window.len() + 12;
        exr.splice(at..at + 8, [59_999_i32.to_le_bytes(), 59_999_i32.to_le_bytes()].concat());
        let (id, message) = huge("exr", &exr);
        assert!(id == "image-limit" || message.contains("cut off") || message.contains("damaged"), "{id} {message}");
    }
}

#[test]
fn what_renderers_read_differently_is_refused() {
    assert!(wrong("png", JPEG).contains("a JPEG file by another name"));
    assert!(wrong("tga", b"what is this").contains("no image that can be read"));
    let mut none = rgb_png(&[0; 6]);
    none.splice(16..20, [0; 4]);
    assert!(wrong("png", &none).contains("no pixels"));
    let mut damaged = rgb_png(&[0; 6]);
    let data = damaged.windows(4).position(|part| part == b"IDAT").expect("pixels") + 6;
    damaged[data] ^= 0xff;
    assert!(wrong("png", &damaged).contains("damaged"));
    let mut depth = rgb_png(&[0; 6]);
    depth[24] = 4;
    assert!(wrong("png", &depth).contains("4 bits"));
    assert!(wrong("pfm", &[&b"PF 1 1 2.5\n"[..], &[0; 12]].concat()).contains("scale 2.5"));
    assert!(wrong("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 3 +X 5\nrows").contains("top to bottom"));
    assert!(wrong("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 3 +X 5\nrows").contains("other colors"));
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    // The last bytes of a PNG are those of its end, of a JPEG of a picture that is whole without them.
    let whole: [(&str, Vec<u8>, usize); 5] = [
        ("png", rgb_png(&[1, 2, 3, 4, 5, 6]), 0),
        ("jpg", JPEG.to_vec(), JPEG.len()),
        ("exr", exr_of(rgb([[0.5; 2]; 3])), 0),
        ("pfm", [&b"Pf 5 3 1\n"[..], &[0; 60]].concat(), 0),
        ("hdr", HDR.to_vec(), 0),
    ];
    for (ending, bytes, spare) in whole {
        for length in 0..bytes.len() {
            let cut = load(ending, &bytes[..length], MOST);
            assert!(cut.is_err() || length + spare >= bytes.len(), "{ending} with {length} bytes: {cut:?}");
        }
    }
}

#[test]
fn equal_pixels_are_equal_bytes() {
    let values = (0..64 * 64 * 3).map(|at| (at % 251) as f32 / 250.0).collect();
    let pixels = Pixels { width: 64, height: 64, channels: 3, values };
    let all = || {
        [write::exr(&pixels, Depth::Half), write::exr(&pixels, Depth::Full), write::png(&pixels, 16)].map(Result::ok)
    };
    let first = all();
    assert!(first.iter().all(Option::is_some) && (0..4).all(|_| all() == first));
    // Half floats are within 2^-11 of what they stand for.
    let (half, _) = (write::exr(&pixels, Depth::Half).expect("bytes"), ());
    let back = exr::load(&half, MOST).expect("an image").pixels;
    let off = back.values.iter().zip(&pixels.values).map(|(a, b)| if *b > 0.0 { (a / b - 1.0).abs() } else { *a });
    assert!(off.fold(0.0, f32::max) <= 1.0 / 2048.0);
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(start in 0_usize..5, tail in proptest::collection::vec(any::<u8>(), 0..80)) {
        let starts: [(&str, &[u8]); 5] = [
            ("png", b"\x89PNG\r\n\x1a\n"),
            ("jpg", b"\xff\xd8\xff"),
            ("exr", b"\x76\x2f\x31\x01\x02\0\0\0"),
            ("pfm", b"PF "),
            ("hdr", b"#?RADIANCE\n"),
        ];
        let (ending, bytes) = starts[start];
        if let Err(error) = load(ending, &[bytes, &tail[..]].concat(), MOST) {
            prop_assert!(!error.message.is_empty() && !error.place.is_empty());
        }
    }

    #[test]
    fn a_file_with_another_byte_is_read_or_refused(kind in 0_usize..5, at in 0_usize..4000, byte in any::<u8>()) {
        let files: [(&str, Vec<u8>); 5] = [
            ("png", rgb_png(&[255, 0, 10, 0, 51, 0])),
            ("jpg", JPEG.to_vec()),
            ("exr", exr_of(rgb([[0.5; 2]; 3]))),
            ("pfm", [&b"Pf 5 3 1\n"[..], &[0; 60]].concat()),
            ("hdr", HDR.to_vec()),
        ];
        let (ending, mut bytes) = files[kind].clone();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = load(ending, &bytes, MOST);
    }
}
