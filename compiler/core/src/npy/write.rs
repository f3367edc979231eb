//! Arrays of numbers in double precision, written.

use std::io::{self, Write};

/// What the header and all before it are a multiple of.
const ALIGN: usize = 64;

/// The bytes before the text of the header: the magic, the version, the length.
const BEFORE: usize = 10;

/// Writes the header of an array of `shape` of 64-bit floats, little-endian, the last axis running fastest; the numbers follow.
pub fn header(shape: &[usize], out: &mut dyn Write) -> io::Result<()> {
    let axes: String = shape.iter().map(|axis| format!("{axis}, ")).collect();
    let axes = axes.trim_end();
    // Python writes `(3,)` for one axis and `(3, 4)` for several.
    let axes = if shape.len() == 1 { axes } else { axes.trim_end_matches(',') };
    let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({axes}), }}");
    let length = (BEFORE + text.len() + 1).next_multiple_of(ALIGN) - BEFORE;
    text.push_str(&" ".repeat(length - 1 - text.len()));
    text.push('\n');
    let length = u16::try_from(length).map_err(io::Error::other)?;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::super::Array;
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        for shape in [vec![2, 3], vec![6], vec![1, 3, 2]] {
            let mut bytes = Vec::new();
            header(&shape, &mut bytes).expect("memory takes all");
            assert_eq!(bytes.len() % ALIGN, 0);
            let numbers = [1.0, -2.5, 0.1, 1e300, -0.0, 5e-324];
            numbers.iter().for_each(|number: &f64| bytes.extend(number.to_le_bytes()));
            let array = Array::open(&bytes).expect("an array");
            assert_eq!(array.shape(), shape);
            let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&array.numbers().expect("numbers")), bits(&numbers));
        }
    }
}
