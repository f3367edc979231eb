//! PLY as text: one line per item, numbers separated by blanks.

use super::super::text::{no_number, number};
use super::header::{Element, Kind};
use super::{COLUMNS, Faces, File, FileError, List, Note, Vertices, add, shown, too_short};

/// Reads the elements after the header.
pub(super) fn read(file: &File<'_>, notes: &mut Vec<Note>) -> Result<(Vertices, Faces), FileError> {
    let mut lines = Lines { rest: &file.bytes[file.header.payload..], number: file.header.lines };
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    for (at, element) in file.header.elements.iter().enumerate() {
        if element.properties.is_empty() {
            // Its items have nothing to write; blank lines are passed over in any case.
            continue;
        }
        // Each number takes a digit and a blank at least; only the very last blank may be missing.
        let least = u128::from(element.count) * 2 * element.properties.len() as u128;
        if least > lines.rest.len() as u128 + 1 {
            let least = u64::try_from(least).unwrap_or(u64::MAX);
            return Err(too_short(element, least, lines.rest.len(), file.header));
        }
        if at == file.layout.vertex {
            vertices = read_vertices(file, element, &mut lines)?;
        } else if let Some(list) = file.layout.list(at) {
            read_lists(file, list, &mut lines, &mut faces)?;
        } else {
            for item in 0..element.count {
                lines.next(element, item)?;
            }
        }
    }
    if let Some(line) = lines.peek() {
        notes.push(Note::warn(format!("line {line}"), "lines after the last element are not read"));
    }
    Ok((vertices, faces))
}

/// The line of a vertex that has been read before.
pub(super) fn place_of_vertex(file: &File<'_>, vertex: usize) -> String {
    let mut lines = Lines { rest: &file.bytes[file.header.payload..], number: file.header.lines };
    let before = &file.header.elements[..file.layout.vertex];
    let before: u64 = before.iter().filter(|element| !element.properties.is_empty()).map(|element| element.count).sum();
    for item in 0..=before + vertex as u64 {
        if lines.next(file.vertex(), item).is_err() {
            break;
        }
    }
    format!("line {}", lines.number)
}

fn read_vertices(file: &File<'_>, element: &Element, lines: &mut Lines<'_>) -> Result<Vertices, FileError> {
    let columns = file.layout.column_of(element.properties.len());
    let mut vertices = Vertices::with_room(file.layout);
    for item in 0..element.count {
        let mut words = Words::new(lines.next(element, item)?);
        let mut values = [0.0; COLUMNS];
        for (property, column) in element.properties.iter().zip(&columns) {
            match (property.kind, column) {
                (Kind::One(_), Some(column)) => values[*column] = words.float(lines.number, &property.name)?,
                (kind, _) => words.skip(kind, lines.number, &property.name)?,
            }
        }
        words.end(lines.number, element)?;
        vertices.push(values);
    }
    Ok(vertices)
}

fn read_lists(file: &File<'_>, list: List, lines: &mut Lines<'_>, faces: &mut Faces) -> Result<(), FileError> {
    let element = &file.header.elements[list.element];
    let room = element.count.min(lines.rest.len() as u64 / 8);
    faces.triangles.reserve(room as usize);
    let mut corners: Vec<u32> = Vec::new();
    for item in 0..element.count {
        let line = lines.next(element, item)?;
        let number = lines.number;
        let mut words = Words::new(line);
        for (at, property) in element.properties.iter().enumerate() {
            if at != list.property {
                words.skip(property.kind, number, &property.name)?;
                continue;
            }
            let length = words.length(number, &property.name)?;
            let indices = (0..length).map(|_| words.integer(number, &property.name));
            add(list, indices, file.layout.vertices, &mut corners, faces, || format!("line {number}"))?;
        }
        words.end(number, element)?;
    }
    Ok(())
}

/// Lines that are not blank.
struct Lines<'a> {
    rest: &'a [u8],
    /// Of the line last given.
    number: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self, element: &Element, item: u64) -> Result<&'a [u8], FileError> {
        while !self.rest.is_empty() {
            let line = self.take();
            if !line.is_empty() {
                return Ok(line);
            }
        }
        let message =
            format!("the file ends after {item} of {} items of element `{}`", element.count, shown(&element.name));
        Err(FileError::new(format!("line {}", self.number), message).help("the file is cut off, or the count is wrong"))
    }

    /// The number of the next line that is not blank, if there is one.
    fn peek(&mut self) -> Option<usize> {
        while !self.rest.is_empty() {
            if !self.take().is_empty() {
                return Some(self.number);
            }
        }
        None
    }

    fn take(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, mut rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        if let Some(after) = rest.strip_prefix(b"\r\n") {
            rest = after;
        } else if !rest.is_empty() {
            rest = &rest[1..];
        }
        self.rest = rest;
        self.number += 1;
        line.trim_ascii()
    }
}

fn unfit(line: usize, word: &[u8], property: &str) -> FileError {
    no_number(format!("line {line}"), word, &format!(" that property `{}` can have", shown(property)))
}

/// The words of a line.
struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    fn new(line: &'a [u8]) -> Self {
        Self { rest: line }
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn required(&mut self, line: usize, property: &str) -> Result<&'a [u8], FileError> {
        self.word().ok_or_else(|| {
            let message = format!("the line ends before property `{}`", shown(property));
            FileError::new(format!("line {line}"), message)
                .help("every item of an element stands on one line with all its properties")
        })
    }

    /// A number in single precision at once: by way of double precision it would be rounded twice.
    fn float(&mut self, line: usize, property: &str) -> Result<f32, FileError> {
        let word = self.required(line, property)?;
        number(word).ok_or_else(|| unfit(line, word, property))
    }

    fn integer(&mut self, line: usize, property: &str) -> Result<i64, FileError> {
        let word = self.required(line, property)?;
        std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()).ok_or_else(|| unfit(line, word, property))
    }

    /// The length of a list that fits in the line.
    fn length(&mut self, line: usize, property: &str) -> Result<usize, FileError> {
        let length = self.integer(line, property)?;
        match usize::try_from(length) {
            // Each item takes a blank and a digit at least.
            Ok(length) if length <= self.rest.len() / 2 => Ok(length),
            Ok(_) | Err(_) => {
                let message = format!("list `{}` has length {length}, the line is shorter", shown(property));
                let message = if length < 0 { message.replace(", the line is shorter", "") } else { message };
                Err(FileError::new(format!("line {line}"), message))
            }
        }
    }

    /// Passes over a property that is not read. Its numbers may be anything.
    fn skip(&mut self, kind: Kind, line: usize, property: &str) -> Result<(), FileError> {
        let count = match kind {
            Kind::One(_) => 1,
            Kind::List(..) => self.length(line, property)?,
        };
        for _ in 0..count {
            if self.word().is_none() {
                let message = format!("the line ends before property `{}`", shown(property));
                return Err(FileError::new(format!("line {line}"), message));
            }
        }
        Ok(())
    }

    fn end(&mut self, line: usize, element: &Element) -> Result<(), FileError> {
        match self.word() {
            None => Ok(()),
            Some(_) => {
                let message =
                    format!("the line has more numbers than element `{}` has properties", shown(&element.name));
                Err(FileError::new(format!("line {line}"), message))
            }
        }
    }
}
