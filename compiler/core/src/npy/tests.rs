//! Arrays as NumPy writes them, and as it does not.

use super::*;
use proptest::prelude::*;

/// A file of version 1 with this dictionary and these bytes.
fn file(dictionary: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((dictionary.len() as u16).to_le_bytes());
    bytes.extend(dictionary.as_bytes());
    bytes.extend(data);
    bytes
}

fn dictionary(descr: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}      \n")
}

fn numbers(descr: &str, shape: &str, data: &[u8]) -> Result<Vec<f64>, NpyError> {
    Array::open(&file(&dictionary(descr, "False", shape), data))?.numbers()
}

fn error(bytes: &[u8]) -> String {
    Array::open(bytes).and_then(|array| array.numbers()).expect_err("an error").message
}

#[test]
fn every_type_is_read() {
    for (descr, data, expected) in [
        ("<f4", [0, 0, 0xc0, 0x3f].to_vec(), 1.5),
        (">f4", [0x3f, 0xc0, 0, 0].to_vec(), 1.5),
        ("<f8", (-0.1_f64).to_le_bytes().to_vec(), -0.1),
        (">f8", (-0.1_f64).to_be_bytes().to_vec(), -0.1),
        ("<f2", [0x00, 0xc0].to_vec(), -2.0),
        (">f2", [0x35, 0x55].to_vec(), 0.333_251_953_125),
        ("<f2", [0x01, 0x00].to_vec(), 1.0 / 16_777_216.0),
        ("<f2", [0xff, 0x7b].to_vec(), 65_504.0),
        ("|i1", [0xff].to_vec(), -1.0),
        ("|u1", [0xff].to_vec(), 255.0),
        ("<i2", [0xfe, 0xff].to_vec(), -2.0),
        (">u2", [1, 0].to_vec(), 256.0),
        ("<i4", (-70_000_i32).to_le_bytes().to_vec(), -70_000.0),
        (">u4", 4_000_000_000_u32.to_be_bytes().to_vec(), 4e9),
        ("<i8", (-9_007_199_254_740_992_i64).to_le_bytes().to_vec(), -9_007_199_254_740_992.0),
        ("<u8", 7_u64.to_le_bytes().to_vec(), 7.0),
        ("|b1", [1].to_vec(), 1.0),
        ("=f4", [0, 0, 0xc0, 0x3f].to_vec(), 1.5),
    ] {
        assert_eq!(numbers(descr, "(1,)", &data), Ok(vec![expected]), "{descr}");
    }
}

#[test]
fn every_version_of_the_header_is_read() {
    let text = dictionary("|u1", "False", "(2L, 1L)");
    for version in [2, 3] {
        let mut bytes = vec![0x93, b'N', b'U', b'M', b'P', b'Y', version, 0];
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend([3, 4]);
        let array = Array::open(&bytes).expect("an array");
        assert_eq!((array.shape(), array.numbers()), (&[2, 1][..], Ok(vec![3.0, 4.0])));
    }
    let plain = r#"{"shape":(),"fortran_order":True,"descr":"|u1"}"#;
    let bytes = file(plain, &[9]);
    let array = Array::open(&bytes).expect("a number");
    assert_eq!((array.shape(), array.numbers(), array.len()), (&[][..], Ok(vec![9.0]), 1));
}

#[test]
fn the_order_in_the_file_does_not_matter() {
    let fortran = file(&dictionary("|u1", "True", "(2, 3)"), &[11, 21, 12, 22, 13, 23]);
    let array = Array::open(&fortran).expect("an array");
    assert_eq!(array.numbers(), Ok(vec![11.0, 12.0, 13.0, 21.0, 22.0, 23.0]));
    // numpy.asfortranarray(numpy.arange(24).reshape(2, 3, 4)), byte by byte.
    let mut data = Vec::new();
    for k in 0..4 {
        for j in 0..3 {
            data.extend((0..2).map(|i| (i * 12 + j * 4 + k) as u8));
        }
    }
    let three = file(&dictionary("|u1", "True", "(2, 3, 4)"), &data);
    let array = Array::open(&three).expect("an array");
    assert_eq!(array.numbers(), Ok((0..24).map(f64::from).collect()));
}

#[test]
fn lies_are_found_before_anything_is_allocated() {
    let claim = |shape: &str| error(&file(&dictionary("<f8", "False", shape), &[0; 24]));
    assert!(claim("(4,)").contains("shape (4,) of type `float64`, which take 32 bytes, but 24 follow"));
    assert!(claim("(2,)").contains("16 bytes, but 24"));
    assert!(claim("(1000000000000, 3)").contains("but 24 follow"));
    assert!(claim("(4294967296, 4294967296, 4294967296)").contains("more bytes than can be counted"));
    assert!(claim("(1,1,1,1,1,1,1,1,3)").contains("9 axes"));
    assert!(claim("(99999999999999999999999,)").contains("no tuple of whole numbers"));
}

#[test]
fn other_files_have_their_own_words() {
    assert!(error(b"").contains("no `.npy` array"));
    assert!(error(b"PK\x03\x04 a zip").contains("no `.npy` array"));
    assert!(error(b"\x93NUMPY").contains("ends within its header"));
    assert!(error(b"\x93NUMPY\x01\x00\x46").contains("ends within its header"));
    assert!(error(b"\x93NUMPY\x09\x00\x00\x00").contains("version 9"));
    assert!(error(b"\x93NUMPY\x02\x00\xff\xff\xff\xff").contains("more than 65536"));
    for (text, words) in [
        (dictionary("|O", "False", "(1,)"), "the type `|O`"),
        (dictionary("<c16", "False", "(1,)"), "the type `<c16`"),
        (dictionary("<U5", "False", "(1,)"), "the type `<U5`"),
        ("{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (1,), }".to_owned(), "several fields"),
        ("{'descr': '<f8', 'fortran_order': False}".to_owned(), "is missing"),
        ("{'descr': '<f8', 'descr': '<f8'}".to_owned(), "two entries"),
        ("{'descr': '<f8', 'fortran_order': 0, 'shape': (1,)}".to_owned(), "neither `True` nor `False`"),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (-1,)}".to_owned(), "no tuple"),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (1,)".to_owned(), "`}` is missing"),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (1,)} x".to_owned(), "behind it"),
        ("{'more': 1}".to_owned(), "unknown entry"),
        ("[]".to_owned(), "`{` is missing"),
    ] {
        let message = error(&file(&text, &[0; 8]));
        assert!(message.contains(words), "{text}: {message}");
    }
}

#[test]
fn numbers_that_are_none_are_found_with_their_place() {
    let mut data: Vec<u8> = [1.0_f64, 2.0, 3.0, f64::NAN].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(numbers("<f8", "(2, 2)", &data).expect_err("an error").message.contains("[1, 1] is not a number"));
    data[..8].copy_from_slice(&f64::NEG_INFINITY.to_le_bytes());
    assert!(numbers("<f8", "(2, 2)", &data).expect_err("an error").message.contains("[0, 0] is infinite"));
    let wide = (1_i64 << 60).to_le_bytes();
    assert!(numbers("<i8", "(1,)", &wide).expect_err("an error").message.contains("beyond 2^53"));
}

proptest! {
    #[test]
    fn any_bytes_are_read(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _result = Array::open(&bytes).and_then(|array| array.numbers());
    }

    #[test]
    fn any_header_is_read(text in "\\{'descr': '[<>|=][bifu][1248]', 'fortran_order': (True|False), 'shape': \\([0-9, ]{0,8}\\)[ ,}]{0,3}", data in prop::collection::vec(any::<u8>(), 0..64)) {
        let bytes = file(&text, &data);
        if let Ok(array) = Array::open(&bytes) && let Ok(numbers) = array.numbers() {
            prop_assert_eq!(numbers.len(), array.len());
            prop_assert_eq!(array.shape().iter().product::<usize>(), array.len());
        }
    }
}
