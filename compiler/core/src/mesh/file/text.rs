//! What all text files of meshes have in common: byte order marks, and line ends of old systems.

use std::borrow::Cow;

use super::FileError;

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
