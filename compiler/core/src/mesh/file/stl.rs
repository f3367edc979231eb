//! STL files, binary and as text: triangles without shared vertices.
//!
//! The vertices stay as they are in the file, three for each triangle with its flat normal; `smooth` takes equal positions for
//! one point. The normal in the file is only held against the winding, which decides: many programs write zero.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::finish::{finish, flat};
use super::polygons::Faces;
use super::text::{no_number, number, text, without_mark};
use super::{FileError, Note, missing_part, plural, shown};
use crate::ir::{Vec3, cross, dot, sub};
use crate::mesh::{Geometry, face_normal};

/// The bytes before the triangles: 80 for a title, 4 for the count.
const HEAD: usize = 84;

/// Normal, three corners, and two bytes of attributes.
const FACET: usize = 50;

/// Below this many triangles a loop is not worth other threads.
const WORTH_THREADS: usize = 1 << 14;

/// Reads the file, or of a text the solid called `part`.
pub(super) fn read(bytes: &[u8], part: Option<&str>) -> Result<(Geometry, Vec<Note>), FileError> {
    if bytes.is_empty() {
        return Err(FileError::new("", "the file is empty"));
    }
    if is_text(bytes) {
        return read_text(&text(bytes)?, part);
    }
    if !fits(bytes) {
        // Says it of what is text in UTF-16.
        text(bytes)?;
    }
    match part {
        None => binary(bytes),
        Some(_) => Err(FileError::new("", "a binary STL file has no parts").help("leave out `part`")),
    }
}

/// The names of the solids of a text, in their order.
pub(super) fn parts(bytes: &[u8]) -> Result<Vec<String>, FileError> {
    if !is_text(bytes) {
        return Ok(Vec::new());
    }
    let mut reader = Text { selected: true, ..Text::default() };
    reader.run(&text(bytes)?)?;
    Ok(reader.names())
}

/// Binary files may begin with `solid` too: what decides is whether the length fits the count, and a zero byte near the start.
fn is_text(bytes: &[u8]) -> bool {
    let binary = fits(bytes) || bytes[..bytes.len().min(512)].contains(&0);
    !binary && without_mark(bytes).trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// Whether the file is as long as the count of a binary one says.
fn fits(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| bytes.len() as u64 == HEAD as u64 + u64::from(count) * FACET as u64)
}

fn count(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEAD - 4..HEAD)?.first_chunk::<4>().map(|count| u32::from_le_bytes(*count))
}

fn binary(bytes: &[u8]) -> Result<(Geometry, Vec<Note>), FileError> {
    let Some(claimed) = count(bytes) else {
        return Err(FileError::new("", format!("the file has {} bytes, and its head alone has {HEAD}", bytes.len()))
            .help("is this an STL file?"));
    };
    let body = &bytes[HEAD..];
    let size = u64::from(claimed) * FACET as u64;
    if size > body.len() as u64 {
        let message =
            format!("the file declares {claimed} triangles, which take {size} bytes, but {} follow", body.len());
        return Err(FileError::new("byte 80", message).help("the file is cut off, or the count is wrong"));
    }
    let mut notes = Vec::new();
    if size < body.len() as u64 {
        let extra = body.len() as u64 - size;
        notes.push(Note::warn(
            format!("byte {}", HEAD as u64 + size),
            format!("{} behind the last triangle not read", plural(extra, "byte")),
        ));
    }
    if claimed == 0 {
        return Err(FileError::new("", "the file has no triangles"));
    }
    if u64::from(claimed) * 3 > u64::from(u32::MAX) {
        return Err(FileError::new("byte 80", "the file has more than 2^32 corners").help("split the mesh"));
    }
    let (facets, _) = body[..size as usize].as_chunks::<FACET>();
    let corners = |facet: &[u8; FACET]| [12, 24, 36].map(|at| [0, 4, 8].map(|axis| float(facet, at + axis)));
    let against = |facet: &&[u8; FACET]| is_against([0, 4, 8].map(|axis| float(facet, axis)), corners(facet));
    let marked = |facet: &&[u8; FACET]| facet[48] != 0 || facet[49] != 0;
    let (positions, turned, colors) = if facets.len() < WORTH_THREADS {
        let positions: Vec<[[f32; 3]; 3]> = facets.iter().map(corners).collect();
        (positions, facets.iter().filter(against).count(), facets.iter().any(|facet| marked(&facet)))
    } else {
        let all = facets.par_iter().with_min_len(WORTH_THREADS / 2);
        let positions: Vec<[[f32; 3]; 3]> = all.clone().map(corners).collect();
        (positions, all.clone().filter(against).count(), all.into_par_iter().any(|facet| marked(&facet)))
    };
    if colors {
        // Magics says so in its title, VisCAM in the highest bit of each color; what else stands there is no image.
        let title = bytes[..HEAD - 4].windows(6).any(|word| word == b"COLOR=");
        notes.push(if title || facets.iter().any(|facet| facet[49] >= 128) {
            Note::dropped("", "the colors of facets are not read")
        } else {
            Note::dropped("", "the attributes of facets are not read").slight()
        });
    }
    note_turned(turned as u64, &mut notes);
    let triangles = (0..claimed).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
    let mut geometry = Geometry { positions: positions.into_flattened(), normals: None, uvs: None, triangles };
    finish(&mut geometry, &mut notes, |vertex| format!("byte {}", HEAD + vertex / 3 * FACET + 12 + vertex % 3 * 12))?;
    Ok((flat_soup(geometry, &mut notes)?, notes))
}

/// The geometry with its flat normals, if no two triangles share a vertex; triangles without area are left out.
fn flat_soup(mut geometry: Geometry, notes: &mut Vec<Note>) -> Result<Geometry, FileError> {
    let (soup, rest) = geometry.positions.as_chunks::<3>();
    let whole = |made: Geometry| {
        if made.triangles.is_empty() {
            return Err(FileError::new("", "no triangle of the file has an area"));
        }
        Ok(made)
    };
    if !rest.is_empty() || soup.len() != geometry.triangles.len() {
        return flat(geometry, notes).and_then(whole);
    }
    let normal = |corners: &[[f32; 3]; 3]| {
        // Zero marks a triangle without area. Adding 0 turns -0 to 0.
        let unit = face_normal(corners.map(|corner| corner.map(f64::from)));
        [unit.map_or([0.0; 3], |unit| unit.map(|x| x as f32 + 0.0)); 3]
    };
    let normals: Vec<[[f32; 3]; 3]> = if soup.len() < WORTH_THREADS {
        soup.iter().map(normal).collect()
    } else {
        soup.par_iter().with_min_len(WORTH_THREADS / 2).map(normal).collect()
    };
    if normals.iter().any(|[normal, ..]| *normal == [0.0; 3]) {
        return flat(geometry, notes).and_then(whole);
    }
    geometry.normals = Some(normals.into_flattened());
    Ok(geometry)
}

/// The four bytes of a facet from `at`; 0 beyond its end, which the callers rule out.
#[inline(always)]
fn float(facet: &[u8; FACET], at: usize) -> f32 {
    facet.get(at..).and_then(<[u8]>::first_chunk::<4>).map_or(0.0, |bytes| f32::from_le_bytes(*bytes))
}

/// Whether a normal points to the back of its triangle. Many programs write zero.
fn is_against(normal: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> bool {
    if normal == [0.0; 3] {
        return false;
    }
    let [a, b, c]: [Vec3; 3] = [a, b, c].map(|corner| corner.map(f64::from));
    dot(normal.map(f64::from), cross(sub(b, a), sub(c, a))) < 0.0
}

fn note_turned(turned: u64, notes: &mut Vec<Note>) {
    if turned > 0 {
        let message = format!("the normals of {} point against their winding, which decides", plural(turned, "facet"));
        let help = "write `|> flip()` if the surface is seen from the wrong side";
        notes.push(Note::warn("", message).help(help));
    }
}

fn read_text(bytes: &[u8], part: Option<&str>) -> Result<(Geometry, Vec<Note>), FileError> {
    let mut reader = Text { part, selected: part.is_none(), ..Text::default() };
    reader.run(bytes)?;
    if let Some(part) = part
        && !reader.found
    {
        return Err(missing_part("solid", part, &reader.names()));
    }
    let Text { positions, faces, turned, unknown, open, .. } = reader;
    let mut notes = Vec::new();
    if let Some((line, word, count)) = unknown {
        let message = format!("{} not understood, the first is `{word}`", plural(count, "line"));
        notes.push(Note::dropped(format!("line {line}"), message).help("is this an STL file?"));
    }
    if open {
        notes.push(Note::warn("", "the last `solid` has no `endsolid`").help("is the file cut off?"));
    }
    note_turned(turned, &mut notes);
    let triangles = faces.finish(|vertex| positions[vertex as usize], &mut notes)?.triangles;
    let mut geometry = Geometry { positions, normals: None, uvs: None, triangles };
    finish(&mut geometry, &mut notes, |_| String::new())?;
    Ok((flat_soup(geometry, &mut notes)?, notes))
}

/// A text on its way to triangles.
#[derive(Default)]
struct Text<'a> {
    part: Option<&'a str>,
    /// Whether facets are read now, and whether one has been.
    selected: bool,
    found: bool,
    solid: String,
    /// Whether a solid has not ended.
    open: bool,
    named: BTreeMap<String, usize>,
    positions: Vec<[f32; 3]>,
    faces: Faces,
    normal: [f32; 3],
    /// The corners of the facet that is being read.
    corners: Vec<u32>,
    turned: u64,
    unknown: Option<(usize, String, u64)>,
}

impl Text<'_> {
    fn names(&self) -> Vec<String> {
        let mut ranked: Vec<(usize, &String)> = self.named.iter().map(|(name, rank)| (*rank, name)).collect();
        ranked.sort_unstable();
        ranked.into_iter().map(|(_, name)| name.clone()).collect()
    }

    fn run(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        for (index, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
            self.line(line.trim_ascii(), index + 1)?;
        }
        if self.corners.is_empty() {
            return Ok(());
        }
        Err(FileError::new("", "the file ends within a facet").help("the file is cut off"))
    }

    fn line(&mut self, line: &[u8], number: usize) -> Result<(), FileError> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let point = three(&mut words, number, "position")?;
                if !point.iter().all(|x| x.is_finite()) {
                    return Err(FileError::new(
                        format!("line {number}"),
                        "the position is not finite in single precision",
                    )
                    .help("repair the mesh in the program that made the file"));
                }
                if self.positions.len() + 1 >= u32::MAX as usize {
                    return Err(FileError::new(format!("line {number}"), "the file has more than 2^32 corners"));
                }
                self.corners.push(self.positions.len() as u32);
                self.positions.push(point);
            }
            b"facet" => {
                self.normal = [0.0; 3];
                if words.next().is_some() {
                    // Normals that are no numbers matter as little as those that are wrong.
                    self.normal = three(&mut words, number, "normal").unwrap_or_default();
                }
            }
            b"endfacet" => self.facet(number),
            b"outer" | b"endloop" => {}
            b"solid" => {
                let name = line[keyword.len()..].trim_ascii();
                self.solid = String::from_utf8_lossy(name).into_owned();
                self.open = true;
                if let Some(part) = self.part {
                    self.selected = self.solid == part;
                }
            }
            b"endsolid" => self.open = false,
            _ => {
                let word = || shown(&String::from_utf8_lossy(&keyword[..keyword.len().min(200)]));
                self.unknown.get_or_insert_with(|| (number, word(), 0)).2 += 1;
            }
        }
        Ok(())
    }

    fn facet(&mut self, number: usize) {
        let corners = std::mem::take(&mut self.corners);
        if !self.solid.is_empty() && !self.named.contains_key(&self.solid) {
            self.named.insert(self.solid.clone(), self.named.len());
        }
        if !self.selected {
            self.positions.truncate(self.positions.len() - corners.len());
            return;
        }
        self.found = true;
        if let [a, b, c] = corners[..] {
            let points = [a, b, c].map(|corner| self.positions[corner as usize]);
            self.turned += u64::from(is_against(self.normal, points));
        }
        self.faces.push(&corners, || format!("line {number}"));
        // Kept for its room.
        self.corners = corners;
        self.corners.clear();
    }
}

fn three<'w>(words: &mut impl Iterator<Item = &'w [u8]>, line: usize, what: &str) -> Result<[f32; 3], FileError> {
    let mut next = || {
        let place = format!("line {line}");
        let Some(word) = words.next() else {
            return Err(FileError::new(place, format!("the {what} has too few numbers")));
        };
        number(word).ok_or_else(|| no_number(place, word, ""))
    };
    Ok([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diag::Severity;
    use proptest::prelude::*;

    const TEXT: &str = "solid left one
facet normal 0 0 1
  outer loop
    vertex 0 0 0
    vertex 1 0 0
    vertex 0 1 0
  endloop
endfacet
endsolid left one
solid right
 facet normal 0 0 -1
  outer loop
   vertex 5 0 1e0
   vertex 6 0 1
   vertex 5 1 1
  endloop
 endfacet
endsolid right
";

    fn file(triangles: &[[[f32; 3]; 4]]) -> Vec<u8> {
        let mut bytes = b"solid that is binary all the same".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend(triangle.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    fn fault(bytes: &[u8], part: Option<&str>) -> String {
        read(bytes, part).map(|_| ()).expect_err("a bad file").to_string()
    }

    #[test]
    fn both_forms_give_the_same() {
        let (text, notes) = read(TEXT.as_bytes(), None).expect("a good file");
        assert_eq!((text.triangles.as_slice(), text.check()), (&[[0, 1, 2], [3, 4, 5]][..], Ok(())));
        assert_eq!(text.positions[4], [6.0, 0.0, 1.0]);
        assert_eq!(text.normals, Some(vec![[0.0, 0.0, 1.0]; 6]));
        assert_eq!(notes.len(), 1, "{notes:?}");
        assert!(notes[0].message.starts_with("the normals of 1 facet point against"));
        let (a, b) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        let facets = [
            [a, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            [b, [5.0, 0.0, 1.0], [6.0, 0.0, 1.0], [5.0, 1.0, 1.0]],
        ];
        assert_eq!(read(&file(&facets), None).expect("a good file"), (text.clone(), notes.clone()));
        let windows = TEXT.replace('\n', "\r\n").replace("facet", "FACET");
        assert_eq!(read(windows.as_bytes(), None), Ok((text.clone(), notes)));
        // With a mark, and with line ends of old systems.
        for other in [format!("\u{feff}{TEXT}"), TEXT.replace('\n', "\r")] {
            assert_eq!(read(other.as_bytes(), None).expect("a good file").0, text);
            assert_eq!(parts(other.as_bytes()).map(|names| names.len()), Ok(2));
        }
        // Enough for several threads.
        let many = vec![facets[0]; WORTH_THREADS * 3];
        let (many, notes) = read(&file(&many), None).expect("a good file");
        assert_eq!((many.triangles.len(), many.check(), notes.len()), (WORTH_THREADS * 3, Ok(()), 0));
    }

    #[test]
    fn parts_are_solids() {
        assert_eq!(parts(TEXT.as_bytes()), Ok(vec!["left one".to_owned(), "right".to_owned()]));
        let (right, _) = read(TEXT.as_bytes(), Some("right")).expect("a part");
        assert_eq!((right.positions.len(), right.positions[0]), (3, [5.0, 0.0, 1.0]));
        assert!(fault(TEXT.as_bytes(), Some("rigth")).contains("no solid `rigth`"));
        assert!(fault(&file(&[[[0.0; 3]; 4]]), Some("a")).contains("has no parts"));
    }

    #[test]
    fn colors_of_facets_are_told() {
        let facet = [[0.0; 3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let told = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = file(&[facet]);
            change(&mut bytes);
            let notes = read(&bytes, None).expect("a good file").1;
            notes.into_iter().map(|note| (note.severity, note.message)).collect::<Vec<_>>()
        };
        let colors = |severity, message: &str| [(severity, message.to_owned())];
        assert_eq!(told(&|_| {}), []);
        let some = "the attributes of facets are not read";
        assert_eq!(told(&|bytes| bytes[132] = 7), colors(Severity::Info, some));
        let painted = "the colors of facets are not read";
        assert_eq!(told(&|bytes| bytes[133] = 0x80), colors(Severity::Warn, painted));
        let magics = |bytes: &mut Vec<u8>| {
            bytes[10..16].copy_from_slice(b"COLOR=");
            bytes[132] = 7;
        };
        assert_eq!(told(&magics), colors(Severity::Warn, painted));
    }

    #[test]
    fn faults_are_found() {
        let facet = [[0.0; 3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let good = file(&[facet; 2]);
        assert!(fault(&good[..good.len() - 1], None).contains("which take 100 bytes, but 99 follow"));
        let mut lie = file(&[facet]);
        lie[0] = b'x';
        lie[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(
            fault(&lie, None).contains("declares 4294967295 triangles, which take 214748364750 bytes, but 50 follow")
        );
        assert!(fault(b"", None).contains("empty"));
        assert!(fault(b"\xff\xfes\0o\0l\0i\0d\0", None).contains("UTF-16"));
        assert!(fault(b"not a mesh", None).contains("has 10 bytes"));
        assert!(fault(&file(&[]), None).contains("no triangles"));
        assert!(fault(&file(&[[[1.0; 3]; 4]; 2]), None).contains("no triangle of the file has an area"));
        let mut bad = file(&[facet; 2]);
        bad[84 + 50 + 24..84 + 50 + 28].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(
            fault(&bad, None).starts_with("byte 158: the position of vertex 4 is not finite"),
            "{}",
            fault(&bad, None)
        );
        for (from, to, words) in [
            ("vertex 1 0 0", "vertex 1 0", "line 5: the position has too few numbers"),
            ("vertex 1 0 0", "vertex 1 0 x", "line 5: `x` is no number"),
            ("vertex 1 0 0", "vertex 1 0 inf", "line 5: the position is not finite"),
        ] {
            assert!(fault(TEXT.replace(from, to).as_bytes(), None).contains(words), "{to}");
        }
        let cut = &TEXT[..TEXT.find("   vertex 5 1").expect("a vertex")];
        assert!(fault(cut.as_bytes(), None).contains("ends within a facet"));
        let mut longer = file(&[facet, [[0.0; 3]; 4]]);
        longer[0] = b'x';
        longer.push(7);
        let (geometry, notes) = read(&longer, None).expect("a good file");
        assert_eq!(geometry.triangles.len(), 1);
        let told: Vec<&str> = notes.iter().map(|note| note.message.as_str()).collect();
        assert_eq!(told, ["1 byte behind the last triangle not read", "1 triangle without area left out"]);
        let (_, notes) = read(TEXT.replace("endsolid right", "bogus").as_bytes(), None).expect("a good file");
        assert_eq!(notes.len(), 3, "{notes:?}");
    }

    proptest! {
        #[test]
        fn noise_does_no_harm(bytes in any::<Vec<u8>>(), words in prop::collection::vec(prop::sample::select(vec![
            "solid", "endsolid", "facet normal 0 0 1\n", "outer loop\n", "vertex 1 2 3\n", "vertex 0 0 0\n", "vertex", "endloop\n",
            "endfacet\n", "\n", "x", "1e99", "nan",
        ]), 0..40)) {
            let mut headed = b"binary".to_vec();
            headed.resize(80, 0);
            headed.extend(&bytes);
            for bytes in [&bytes, &headed, &format!("solid {}", words.join(" ")).into_bytes()] {
                if let Ok((geometry, _)) = read(bytes, None) {
                    prop_assert_eq!(geometry.check(), Ok(()));
                    prop_assert!(!geometry.triangles.is_empty());
                }
                let _parts = parts(bytes);
            }
        }
    }
}
