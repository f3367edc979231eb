//! Cuts a file into pieces of one top-level statement each, in one pass over the bytes.
//!
//! Pieces keep errors local and memory small. The cut needs no grammar: a statement word outside brackets starts a
//! statement unless the token before it asks for more (`= if a then b else c`). Where brackets do not match, a piece
//! swallows the statements behind it, and the recovery of the grammar takes over.

use std::ops::Range;

use super::{NESTING_LIMIT, STARTERS};

/// The pieces of a text and what is nested too deeply in it.
pub(super) struct Split {
    /// Byte ranges, in order, each with the comments before its statement.
    pub pieces: Vec<Range<usize>>,
    /// Where a bracket opens one level too deep; the piece is left out.
    pub too_deep: Vec<usize>,
}

/// What a token says about the one behind it.
#[derive(Clone, Copy, PartialEq)]
enum Before {
    /// A statement may start.
    Complete,
    /// An operator, `=`, `,`, or a word such as `then`: more has to come.
    Open,
}

pub(super) fn split(text: &str) -> Split {
    let bytes = text.as_bytes();
    let mut out = Split { pieces: Vec::new(), too_deep: Vec::new() };
    let mut start = 0;
    let mut doc: Option<usize> = None;
    let mut depth = 0_usize;
    let mut refused = false;
    let mut before = Before::Complete;
    let mut at = 0;
    while at < bytes.len() {
        let byte = bytes[at];
        match byte {
            b' ' | b'\t' | b'\r' | b'\n' => at += 1,
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                let is_doc = bytes.get(at + 2) == Some(&b'/') && bytes.get(at + 3) != Some(&b'/');
                if is_doc && depth == 0 && doc.is_none() {
                    doc = Some(at);
                }
                at += line_length(&bytes[at..]);
            }
            // There are none, which is said where it stands; what follows is a statement all the same.
            b'/' if bytes.get(at + 1) == Some(&b'*') => {
                let rest = &text[at + 2..];
                at = rest.find("*/").map_or(bytes.len(), |found| at + 2 + found + 2);
            }
            b'"' => {
                at = end_of_string(bytes, at);
                (before, doc) = (Before::Complete, None);
            }
            b'`' => {
                let rest = &bytes[at + 1..];
                at += rest.iter().position(|b| matches!(b, b'`' | b'\n')).map_or(rest.len() + 1, |found| found + 2);
                (before, doc) = (Before::Complete, None);
            }
            b'(' | b'[' | b'{' => {
                depth += 1;
                if depth > NESTING_LIMIT && !refused {
                    out.too_deep.push(at);
                    refused = true;
                }
                at += 1;
                (before, doc) = (Before::Open, None);
            }
            b')' | b']' | b'}' => {
                depth = depth.saturating_sub(1);
                at += 1;
                (before, doc) = (Before::Complete, None);
            }
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                let end = at + bytes[at..].iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
                let word = &text[at..end];
                if depth == 0 && before == Before::Complete && STARTERS.contains(&word) {
                    let from = doc.unwrap_or(at);
                    if !refused && !bytes[start..from].iter().all(u8::is_ascii_whitespace) {
                        out.pieces.push(start..from);
                    }
                    (start, refused) = (from, false);
                }
                let asks = ["then", "else", "in", "with", "and", "or", "not", "from", "as"].contains(&word);
                // Behind a statement word comes a name: `let film = 3` is one broken statement, not two.
                before = if asks || STARTERS.contains(&word) { Before::Open } else { Before::Complete };
                doc = None;
                at = end;
            }
            b'0'..=b'9' => {
                at += bytes[at..].iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
                (before, doc) = (Before::Complete, None);
            }
            _ => {
                at += 1;
                (before, doc) = (Before::Open, None);
            }
        }
    }
    if !refused && !bytes[start.min(bytes.len())..].iter().all(u8::is_ascii_whitespace) {
        out.pieces.push(start..bytes.len());
    }
    out
}

fn line_length(bytes: &[u8]) -> usize {
    bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len())
}

/// One past the closing quote, or the end of the line.
fn end_of_string(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 2,
            b'"' => return at + 1,
            b'\n' => return at,
            _ => at += 1,
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(text: &str) -> Vec<&str> {
        split(text).pieces.into_iter().map(|range| text[range].trim()).collect()
    }

    #[test]
    fn statements_are_cut_at_their_words() {
        let text =
            "lts 1\n/// Doc.\nlet a = if b then 1 else 2 // end\n/// X\n/// Y\nshape s = m with n film = image(1, 2)";
        assert_eq!(
            pieces(text),
            [
                "lts 1",
                "/// Doc.\nlet a = if b then 1 else 2 // end",
                "/// X\n/// Y\nshape s = m with n",
                "film = image(1, 2)"
            ]
        );
    }

    #[test]
    fn words_in_brackets_and_strings_start_nothing() {
        assert_eq!(pieces("let f(m: material) = \"let x\" let y = [for i in a: i]").len(), 2);
        assert_eq!(pieces("group g { shape a = b with c } if x { let y = 1 } else { let z = 2 }").len(), 2);
    }

    #[test]
    fn a_block_comment_hides_no_statement() {
        assert_eq!(pieces("let a = 1\n/* hi, let */ material b = c"), ["let a = 1\n/* hi, let */", "material b = c"]);
        assert_eq!(pieces("let a = 1 /* let b = 2"), ["let a = 1 /* let b = 2"]);
    }

    #[test]
    fn depth_is_refused_and_later_statements_survive() {
        let deep = format!("let a = {}1{}\nlet b = 2", "(".repeat(129), ")".repeat(129));
        let split = split(&deep);
        assert_eq!((split.too_deep, split.pieces.len()), (vec![8 + 128], 1));
    }

    #[test]
    fn unclosed_things_end_with_the_text() {
        for text in ["let a = \"x\\", "let a = `x", "let a = (", "///", "}"] {
            assert!(split(text).pieces.len() <= 1);
        }
    }
}
