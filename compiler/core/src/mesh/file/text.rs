//! What all text files of meshes have in common: byte order marks, and line ends of old systems.

use std::borrow::Cow;

use super::{FileError, shown};

/// The text without a byte order mark, with lines that end with a line feed.
pub(super) fn text(bytes: &[u8]) -> Result<Cow<'_, [u8]>, FileError> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(FileError::new("byte 0", "the file is text in UTF-16").help("save it in UTF-8"));
    }
    let text = without_mark(bytes);
    // Old files of the Macintosh end lines with a carriage return alone.
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        return Ok(text.iter().map(|byte| if *byte == b'\r' { b'\n' } else { *byte }).collect());
    }
    Ok(Cow::Borrowed(text))
}

/// The bytes behind the byte order mark of UTF-8, if there is one.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Gives each line to `take`, without blanks at its ends and with its number; a backslash at the end of a line joins the next
/// one.
pub(super) fn lines<E>(text: &[u8], mut take: impl FnMut(&[u8], usize) -> Result<(), E>) -> Result<(), E> {
    let mut joined = Vec::new();
    let mut lines = text.split(|byte| *byte == b'\n').enumerate();
    while let Some((index, line)) = lines.next() {
        let number = index + 1;
        let mut line = line.trim_ascii();
        if !line.ends_with(b"\\") {
            take(line, number)?;
            continue;
        }
        joined.clear();
        while let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
            line = lines.next().map_or(&[][..], |(_, next)| next.trim_ascii());
        }
        joined.extend_from_slice(line);
        take(&joined, number)?;
    }
    Ok(())
}

/// The number in a word, which may be infinite or NaN. Some programs write `-nan(ind)` and `1.#IND` for what is none.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    if let Some(number) = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()) {
        return Some(number);
    }
    let digits = word.strip_prefix(b"-").unwrap_or(word);
    let none = digits.get(..3).is_some_and(|start| start.eq_ignore_ascii_case(b"nan")) || digits.starts_with(b"1.#");
    none.then_some(f32::NAN)
}

/// That a word is no number, with help where its comma is meant for a point.
pub(super) fn no_number(place: String, word: &[u8], what: &str) -> FileError {
    let shown = shown(&String::from_utf8_lossy(&word[..word.len().min(200)]));
    let error = FileError::new(place, format!("`{shown}` is no number{what}"));
    let point = word.iter().map(|byte| if *byte == b',' { b'.' } else { *byte }).collect::<Vec<_>>();
    if number(&point).is_some() { error.help("write numbers with a point: `0.5`, not `0,5`") } else { error }
}

/// A name as it stands in a file that other programs wrote: without quotes, and of an absolute path the last part, which the file's
/// folder may have.
pub(super) fn file_name(name: &str) -> (&str, bool) {
    let name = name.trim();
    let name = name.strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name);
    let drive = |name: &str| name.len() > 2 && name.as_bytes()[0].is_ascii_alphabetic() && name.as_bytes()[1] == b':';
    let absolute = name.starts_with(['/', '\\']) || drive(name);
    if absolute { (name.rsplit(['/', '\\']).next().unwrap_or(name), true) } else { (name, false) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_and_line_ends_make_no_difference() {
        assert_eq!(text(b"\xef\xbb\xbfv 1\n").as_deref(), Ok(&b"v 1\n"[..]));
        assert_eq!(text(b"v 1\rv 2\r").as_deref(), Ok(&b"v 1\nv 2\n"[..]));
        assert_eq!(text(b"v 1\r\nv 2\r\n").as_deref(), Ok(&b"v 1\r\nv 2\r\n"[..]));
        assert!(text(b"\xff\xfev\0").is_err());
    }

    #[test]
    fn numbers_may_be_none() {
        for none in ["nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND00"] {
            assert!(number(none.as_bytes()).is_some_and(f32::is_nan), "{none}");
        }
        assert_eq!(
            [&b"1e3"[..], b"+.5", b"x", b"1,5", b"", b"-"].map(number),
            [Some(1e3), Some(0.5), None, None, None, None]
        );
        let error = no_number("line 1".to_owned(), b"0,5", "");
        assert_eq!((error.message.as_str(), error.help.is_some()), ("`0,5` is no number", true));
        assert_eq!(no_number(String::new(), b"a,b", "").help, None);
    }

    #[test]
    fn backslashes_join_lines() {
        let mut all = Vec::new();
        let take = |line: &[u8], number| -> Result<(), ()> {
            all.push((String::from_utf8_lossy(line).into_owned(), number));
            Ok(())
        };
        lines(b"f 1 \\\r\n 2 \\\n3\nv 1\nend \\", take).expect("lines");
        let expected = [("f 1  2  3", 1), ("v 1", 4), ("end  ", 5)];
        assert_eq!(all, expected.map(|(line, number)| (line.to_owned(), number)));
    }

    #[test]
    fn names_lose_quotes_and_other_peoples_folders() {
        assert_eq!(file_name("\"my oak.png\""), ("my oak.png", false));
        assert_eq!(file_name("textures\\oak.png"), ("textures\\oak.png", false));
        assert_eq!(file_name("C:\\Users\\me\\oak.png"), ("oak.png", true));
        assert_eq!(file_name("/me/oak.png"), ("oak.png", true));
    }
}
