//! The attributes in an OpenEXR header, at the level of bytes.
//!
//! The layout is a magic number, a version with flags, then per attribute a name and a type (both
//! ended by a zero), a length and that many bytes, and at last one zero ("OpenEXR File Layout").
//! Looking at it by hand has two uses: sizes are checked before a decoder believes them, and own
//! attributes are written in one order, which the encoder's hash map would not keep.

use super::Fault;

/// The first bytes of every OpenEXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Magic number, version and flags.
pub(super) const PROLOGUE: usize = 8;

/// One attribute as it lies in the file.
pub(super) struct Raw<'a> {
    pub name: &'a [u8],
    pub kind: &'a [u8],
    pub value: &'a [u8],
}

/// The attributes of the first header and the position behind its closing zero.
pub(super) fn scan(bytes: &[u8]) -> Result<(Vec<Raw<'_>>, usize), Fault> {
    let mut found = Vec::new();
    let mut at = PROLOGUE;
    loop {
        let name = text(bytes, &mut at)?;
        if name.is_empty() {
            return Ok((found, at));
        }
        let kind = text(bytes, &mut at)?;
        let length = bytes.get(at..at + 4).and_then(|field| field.try_into().ok());
        let length = length.map(i32::from_le_bytes).ok_or_else(truncated)?;
        let length = usize::try_from(length).map_err(|_| Fault::new("an attribute has a negative length", DAMAGED))?;
        at += 4;
        let value = bytes.get(at..).and_then(|rest| rest.get(..length)).ok_or_else(truncated)?;
        at += length;
        found.push(Raw { name, kind, value });
    }
}

/// What to say about a header that ends too early.
pub(super) fn truncated() -> Fault {
    Fault::new("the file ends in its header", DAMAGED)
}

/// What to do about damage.
pub(super) const DAMAGED: &str = "copy or render the file again; it is damaged or cut off";

/// Text up to the next zero, of at most the 255 bytes that the format allows.
fn text<'a>(bytes: &'a [u8], at: &mut usize) -> Result<&'a [u8], Fault> {
    let rest = bytes.get(*at..).ok_or_else(truncated)?;
    match rest.iter().take(256).position(|&byte| byte == 0) {
        Some(length) => {
            *at += length + 1;
            Ok(&rest[..length])
        }
        None if rest.len() < 256 => Err(truncated()),
        None => Err(Fault::new("the name of an attribute does not end", DAMAGED)),
    }
}
