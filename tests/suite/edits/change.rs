//! One number or word of a file, and what it is changed to.

use crate::random::dice::Dice;

/// An edit of a file: `to` stands in place of the bytes from `at` to `end`.
#[derive(Clone, Debug)]
pub struct Change {
    pub at: usize,
    pub end: usize,
    pub to: Vec<u8>,
    /// What stood there, for people.
    pub from: String,
    /// What stands before it on its line, or the last of what does.
    pub before: String,
    /// The line.
    pub line: String,
}

impl Change {
    /// The last of what stands before it, for people.
    pub fn around(&self, bytes: &[u8]) -> String {
        let before = String::from_utf8_lossy(&bytes[self.at.saturating_sub(200)..self.at]).into_owned();
        before.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The file with the edit.
    pub fn applied(&self, bytes: &[u8]) -> Vec<u8> {
        [&bytes[..self.at], &self.to, &bytes[self.end..]].concat()
    }
}

/// How bytes of a file are to be changed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Words and numbers of a text.
    Text,
    /// Numbers of 32 bits, from the place on.
    Words(usize),
    /// Any byte from the place on.
    Bytes(usize),
}

/// What of a file can be changed; a binary file that begins with a text has two kinds.
fn kinds(path: &str, bytes: &[u8]) -> Vec<(Kind, std::ops::Range<usize>)> {
    let find = |what: &[u8]| bytes.windows(what.len()).position(|window| window == what);
    if path.ends_with(".ply") {
        let end = find(b"end_header\n").map_or(0, |at| at + 11);
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let vertices = head.lines().find_map(|line| line.strip_prefix("element vertex ")?.parse().ok()).unwrap_or(0);
        let faces = end + vertices * 4 * head.lines().filter(|line| line.starts_with("property float")).count();
        return vec![(Kind::Text, 0..end), (Kind::Words(end), end..faces), (Kind::Bytes(faces), faces..bytes.len())];
    }
    if path.ends_with(".glb") {
        let length = bytes.get(12..16).and_then(|word| word.try_into().ok()).map_or(0, u32::from_le_bytes);
        let json = 20..20 + length as usize;
        let rest = json.end + 8;
        // A file without meshes has one part.
        let mut all = vec![(Kind::Words(0), 0..20), (Kind::Text, json.clone()), (Kind::Text, json.clone())];
        if rest < bytes.len() {
            all.push((Kind::Words(rest), rest..bytes.len()));
        }
        return all;
    }
    if path.ends_with(".bin") {
        return vec![(Kind::Words(0), 0..bytes.len())];
    }
    let text = std::str::from_utf8(bytes).is_ok() && !path.ends_with(".pfm") && !path.ends_with(".hdr");
    vec![(if text { Kind::Text } else { Kind::Bytes(0) }, 0..bytes.len())]
}

/// A change of the file at `path`; none where the place that was chosen has nothing to change.
pub fn change(path: &str, bytes: &[u8], dice: &mut Dice) -> Option<Change> {
    let all = kinds(path, bytes);
    let (kind, range) = all[dice.at(all.len())].clone();
    if range.is_empty() || range.end > bytes.len() {
        return None;
    }
    match kind {
        Kind::Text => text_change(bytes, range, dice),
        Kind::Words(start) => {
            let count = (range.end - start) / 4;
            let at = start + 4 * dice.at(count.max(1));
            let word: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
            let (float, whole) = (f32::from_le_bytes(word), u32::from_le_bytes(word));
            // What is no number of a usual size is an index.
            let likely = float == 0.0 || (float.is_finite() && float.abs() > 1e-20);
            let to = match (likely, dice.at(3)) {
                (false, _) => whole.wrapping_add(1).to_le_bytes(),
                (true, 0) if float.abs() > 1e-6 => (float * 1.1).to_le_bytes(),
                (true, 1) if float.abs() > 1e-6 => (-float).to_le_bytes(),
                (true, _) => (float + 1.0).to_le_bytes(),
            };
            let line = format!("{:?} for {float:?} or {whole}", f32::from_le_bytes(to));
            let (before, from) = (format!("byte {at}"), format!("{word:?}"));
            Some(Change { at, end: at + 4, to: to.to_vec(), from, before, line })
        }
        Kind::Bytes(start) => {
            let at = dice.whole(start as u32, bytes.len() as u32 - 1) as usize;
            let to = bytes[at].wrapping_add(dice.whole(1, 255) as u8);
            let (before, from) = (format!("byte {at}"), format!("{}", bytes[at]));
            Some(Change { at, end: at + 1, to: vec![to], from, before, line: format!("byte {at}") })
        }
    }
}

fn text_change(bytes: &[u8], range: std::ops::Range<usize>, dice: &mut Dice) -> Option<Change> {
    let text = std::str::from_utf8(&bytes[range.clone()]).ok()?;
    // Any line is as likely as any other, and of long ones any place.
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let line = lines[dice.at(lines.len())];
    let start = line.as_ptr() as usize - text.as_ptr() as usize;
    let tokens = tokens(line);
    if tokens.is_empty() {
        return None;
    }
    let (from, to) = tokens[dice.at(tokens.len())];
    let token = &line[from..to];
    let made = match token.parse::<f64>() {
        Ok(number) => {
            let whole = !token.contains(['.', 'e', 'E']);
            let other = match dice.at(4) {
                // What is next to nothing is rounding.
                _ if number.abs() < 1e-12 => number + 1.0,
                0 if !whole => number * 1.1,
                1 => -number,
                2 if number.abs() < 1e6 => number + 1.0,
                _ if !whole => number * 0.5,
                _ => number + 1.0,
            };
            // Larger numbers have no next one.
            let other = if other == number { number * 2.0 } else { other };
            format!("{other}")
        }
        Err(_) => {
            let other = tokens_of_words(text, dice);
            match dice.at(3) {
                0 => format!("{token}x"),
                1 if other != token => other.to_owned(),
                _ => token.chars().rev().collect::<String>() + "q",
            }
        }
    };
    let before = line[..from].chars().rev().take(200).collect::<Vec<_>>().into_iter().rev().collect();
    let shown: String =
        line.trim_end().chars().skip(line[..from].chars().count().saturating_sub(90)).take(200).collect();
    let at = range.start + start + from;
    Some(Change { at, end: at + token.len(), to: made.into_bytes(), from: token.to_owned(), before, line: shown })
}

/// Another word of the text.
fn tokens_of_words<'t>(text: &'t str, dice: &mut Dice) -> &'t str {
    let mut from = dice.at(text.len());
    while !text.is_char_boundary(from) {
        from -= 1;
    }
    let part = &text[from..];
    let words = tokens(part.get(..part.len().min(400)).unwrap_or(part));
    let word = words.iter().map(|(a, b)| &part[*a..*b]).find(|word| word.parse::<f64>().is_err() && word.len() > 1);
    word.unwrap_or("other")
}

/// Numbers and words of a text.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let sign = bytes[at] == b'-' && digit(at + 1) && (at == 0 || !bytes[at - 1].is_ascii_alphanumeric());
        let start = at;
        if digit(at) || sign {
            at += 1;
            while at < bytes.len()
                && (digit(at) || bytes[at] == b'.' || bytes[at] == b'e' || (bytes[at] == b'-' && bytes[at - 1] == b'e'))
            {
                at += 1;
            }
            all.push((start, at));
        } else if bytes[at].is_ascii_alphabetic() || bytes[at] == b'_' {
            while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_') {
                at += 1;
            }
            all.push((start, at));
        } else {
            at += 1;
        }
    }
    all
}
