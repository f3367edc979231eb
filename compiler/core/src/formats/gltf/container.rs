//! The binary container of glTF 2.0 (4.4): a header, the document, the buffer.

use std::io::{self, Write};

/// `glTF` in ASCII.
const MAGIC: u32 = 0x4654_6C67;
/// The version of the container.
const VERSION: u32 = 2;
/// The type of the chunk with the document: `JSON` in ASCII.
const JSON: u32 = 0x4E4F_534A;
/// The type of the chunk with the buffer: `BIN` and a zero.
const BIN: u32 = 0x004E_4942;
/// Every chunk begins at a multiple of this and is as long as one.
const ALIGNMENT: u64 = 4;
/// Bytes of the container's header, and of that of a chunk.
const HEADER: u64 = 12;
const CHUNK: u64 = 8;

/// Where the bytes of a container lie.
#[derive(Debug, PartialEq)]
pub struct Plan {
    whole: u32,
    json: u32,
    bin: u32,
}

impl Plan {
    /// The plan of a document of `json` bytes and a buffer of `bin` bytes, which may be 0: then it has no chunk.
    ///
    /// # Errors
    /// A container of more than 2^32 - 1 bytes, which its own header cannot tell.
    pub fn new(json: u64, bin: u64) -> io::Result<Self> {
        let padded = |bytes: u64| bytes.checked_next_multiple_of(ALIGNMENT);
        let parts = padded(json).zip(padded(bin));
        let whole = parts.and_then(|(json, bin)| {
            let chunk = if bin > 0 { CHUNK } else { 0 };
            (HEADER + CHUNK + chunk).checked_add(json)?.checked_add(bin)
        });
        let narrow = |bytes: u64| u32::try_from(bytes).ok();
        let plan = parts.zip(whole).and_then(|((json, bin), whole)| {
            Some(Self { whole: narrow(whole)?, json: narrow(json)?, bin: narrow(bin)? })
        });
        plan.ok_or_else(|| {
            let text = format!(
                "the scene has {} bytes in glTF, and a binary container of it holds at most {}: the target `gltf` has no such \
                 limit",
                json.saturating_add(bin),
                u32::MAX
            );
            io::Error::new(io::ErrorKind::FileTooLarge, text)
        })
    }

    /// Writes the container. `buffer` writes as many bytes as the plan was made for.
    pub fn write(
        &self,
        document: &[u8],
        buffer: impl FnOnce(&mut dyn Write) -> io::Result<()>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let Self { whole, json, bin } = *self;
        for word in [MAGIC, VERSION, whole, json, JSON] {
            out.write_all(&word.to_le_bytes())?;
        }
        out.write_all(document)?;
        // The document is padded by spaces, the buffer by zeros (4.4.3).
        out.write_all(&b"   "[..pad(document.len())])?;
        if bin > 0 {
            for word in [bin, BIN] {
                out.write_all(&word.to_le_bytes())?;
            }
            buffer(out)?;
        }
        Ok(())
    }
}

/// The bytes that are missing to a multiple of the alignment.
pub fn pad(bytes: usize) -> usize {
    bytes.next_multiple_of(4) - bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_aligned_and_their_lengths_true() {
        for (document, bin) in [(&b"{}"[..], &[1_u8, 2, 3, 4][..]), (b"{ }", &[]), (b"{  }", &[0; 8])] {
            let mut out = Vec::new();
            let plan = Plan::new(document.len() as u64, bin.len() as u64).expect("a small one");
            plan.write(document, |out| out.write_all(bin), &mut out).expect("memory takes all");
            let word = |at: usize| u32::from_le_bytes(out[at..at + 4].try_into().expect("four bytes"));
            assert_eq!((&out[..4], word(4), word(8) as usize), (&b"glTF"[..], 2, out.len()));
            let json = word(12) as usize;
            assert_eq!((json % 4, &out[16..20], &out[20..20 + document.len()]), (0, &b"JSON"[..], document));
            assert!(out[20 + document.len()..20 + json].iter().all(|byte| *byte == b' '));
            let rest = &out[20 + json..];
            if bin.is_empty() {
                assert!(rest.is_empty());
            } else {
                assert_eq!((word(20 + json) as usize, &rest[4..8], &rest[8..]), (bin.len(), &b"BIN\0"[..], bin));
            }
        }
    }

    #[test]
    fn what_the_header_cannot_tell_is_refused() {
        let most = u64::from(u32::MAX) - 28 - 4;
        assert!(Plan::new(4, most - 3).is_ok());
        for (json, bin) in [(4, most + 1), (u64::from(u32::MAX), 4), (4, u64::from(u32::MAX) + 1), (4, u64::MAX - 1)] {
            let error = Plan::new(json, bin).expect_err("too large");
            assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
            assert!(error.to_string().contains("at most 4294967295"), "{error}");
        }
    }
}
