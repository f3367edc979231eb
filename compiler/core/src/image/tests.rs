//! Headers written by hand, whole, damaged and cut.

use super::*;
use proptest::prelude::*;

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    // Renderers check the sums; here only their place counts.
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &[0; 4]].concat()
}

fn png(width: u32, height: u32, depth: u8, color: u8) -> Vec<u8> {
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, color, 0, 0, 0]].concat();
    let start = b"\x89PNG\r\n\x1a\n".to_vec();
    [start, chunk(b"IHDR", &header), chunk(b"tEXt", b"a"), chunk(b"IDAT", b"zz"), chunk(b"IEND", b"")].concat()
}

fn jpeg(frame: u8, precision: u8, components: u8) -> Vec<u8> {
    let mut bytes = b"\xff\xd8\xff\xe0\x00\x04ab".to_vec();
    bytes.extend([0xff, frame, 0, 11, precision, 0, 3, 0, 5, components, 1, 0x11, 0]);
    bytes.extend(b"\xff\xda\x00\x02pixels\xff\xd9");
    bytes
}

fn exr(version: u32, channels: &[(&str, u32)], window: [i32; 4]) -> Vec<u8> {
    let attribute = |name: &str, kind: &str, data: &[u8]| {
        let length = (data.len() as u32).to_le_bytes();
        [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, data].concat()
    };
    let mut list = Vec::new();
    for (name, kind) in channels {
        list.extend([name.as_bytes(), b"\0", &kind.to_le_bytes(), &[0; 4], &[1, 0, 0, 0, 1, 0, 0, 0]].concat());
    }
    list.push(0);
    let window: Vec<u8> = window.iter().flat_map(|side| side.to_le_bytes()).collect();
    let parts = [attribute("channels", "chlist", &list), attribute("dataWindow", "box2i", &window)];
    [&b"\x76\x2f\x31\x01"[..], &version.to_le_bytes(), &parts.concat(), b"\0rows"].concat()
}

const HDR: &[u8] = b"#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 5\nrows";

fn info(format: ImageFormat, width: u32, height: u32, channels: u8, bits: u8) -> Result<ImageInfo, ImageError> {
    Ok(ImageInfo { format, width, height, channels, bits })
}

fn wrong(ending: &str, bytes: &[u8]) -> String {
    read(ending, bytes).map_or_else(|error| error.message, |info| panic!("{info:?}"))
}

#[test]
fn headers_say_size_channels_and_depth() {
    for (depth, color, channels, bits) in [(8, 2, 3, 8), (16, 6, 4, 16), (1, 3, 3, 8), (8, 4, 2, 8), (16, 0, 1, 16)] {
        assert_eq!(read("png", &png(5, 3, depth, color)), info(ImageFormat::Png, 5, 3, channels, bits));
    }
    for frame in [0xc0, 0xc1, 0xc2] {
        assert_eq!(read("jpg", &jpeg(frame, 8, 3)), info(ImageFormat::Jpeg, 5, 3, 3, 8));
    }
    assert_eq!(read("jpeg", &jpeg(0xc0, 8, 1)), info(ImageFormat::Jpeg, 5, 3, 1, 8));
    let color = [("B", 1), ("G", 1), ("R", 1)];
    assert_eq!(read("exr", &exr(2, &color, [-2, 1, 2, 3])), info(ImageFormat::Exr, 5, 3, 3, 16));
    assert_eq!(read("exr", &exr(2, &[("A", 1), ("Y", 2)], [0, 0, 4, 2])), info(ImageFormat::Exr, 5, 3, 2, 32));
    let pfm = [&b"PF\n5 3\n-1.0\n"[..], &[0; 5 * 3 * 12]].concat();
    assert_eq!(read("pfm", &pfm), info(ImageFormat::Pfm, 5, 3, 3, 32));
    let grey = [&b"Pf 5 3 1\n"[..], &[0; 5 * 3 * 4]].concat();
    assert_eq!(read("pfm", &grey), info(ImageFormat::Pfm, 5, 3, 1, 32));
    assert_eq!(read("hdr", HDR), info(ImageFormat::Hdr, 5, 3, 3, 32));
}

#[test]
fn what_renderers_read_differently_is_refused() {
    assert!(wrong("png", &jpeg(0xc0, 8, 3)).contains("a JPEG file by another name"));
    assert!(wrong("tga", b"what is this").contains("no image that can be read"));
    assert!(wrong("png", &png(0, 3, 8, 2)).contains("no pixels"));
    assert!(wrong("png", &png(70_000, 3, 8, 2)).contains("70000 x 3"));
    assert!(wrong("png", &png(5, 3, 4, 2)).contains("4 bits"));
    assert!(wrong("png", &png(5, 3, 8, 5)).contains("colour type 5"));
    assert!(wrong("jpg", &jpeg(0xc9, 8, 3)).contains("arithmetic"));
    assert!(wrong("jpg", &jpeg(0xc1, 12, 3)).contains("12 bits"));
    assert!(wrong("jpg", &jpeg(0xc0, 8, 4)).contains("4 channels"));
    let color = [("B", 1), ("G", 1), ("R", 1)];
    assert!(wrong("exr", &exr(0x1002, &color, [0, 0, 4, 2])).contains("several parts"));
    assert!(wrong("exr", &exr(2, &[("layer.R", 1), ("layer.G", 1)], [0, 0, 4, 2])).contains("no channels R, G and B"));
    assert!(wrong("exr", &exr(2, &[("Y", 0)], [0, 0, 4, 2])).contains("whole numbers"));
    assert!(wrong("exr", &exr(2, &color, [0, 0, -1, 2])).contains("no pixels"));
    assert!(wrong("pfm", &[&b"PF 1 1 2.5\n"[..], &[0; 12]].concat()).contains("scale 2.5"));
    assert!(wrong("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 3 +X 5\nrows").contains("top to bottom"));
    assert!(wrong("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 3 +X 5\nrows").contains("other colours"));
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    // The last byte of a PNG is part of its last sum; of the others the pixels behind the header are cut.
    let color = [("B", 1), ("G", 1), ("R", 1)];
    let whole: [(&str, Vec<u8>, usize); 5] = [
        ("png", png(5, 3, 8, 2), 1),
        ("jpg", jpeg(0xc0, 8, 3), 8),
        ("exr", exr(2, &color, [0, 0, 4, 2]), 4),
        ("pfm", [&b"Pf 5 3 1\n"[..], &[0; 60]].concat(), 1),
        ("hdr", HDR.to_vec(), 4),
    ];
    for (ending, bytes, behind) in whole {
        for length in 0..=bytes.len() {
            let cut = read(ending, &bytes[..length]);
            assert_eq!(cut.is_ok(), length > bytes.len() - behind, "{ending} with {length} bytes: {cut:?}");
        }
    }
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
        if let Err(error) = read(ending, &[bytes, &tail[..]].concat()) {
            prop_assert!(!error.message.is_empty() && !error.place.is_empty());
        }
    }
}
