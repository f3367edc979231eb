//! Surfaces that were not found again as wholes: shared out otherwise among shapes, tessellated otherwise, moved, changed, or only in
//! one of the scenes.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::body::{Corners, Use};
use super::fact::{point, short};
use super::fit::{Fit, Fitter};
use super::near::{Spot, pairs};
use super::report::{Kind, Report};
use super::surface::{Looks, place};
use crate::ir::{Vec3, cross, dot, length, normalized, sub};
use crate::survey::Bounds;

/// Triangles of what is left that are looked for one by one.
const TRIANGLES: usize = 20_000_000;

/// How much of its box's diagonal a surface may lie aside that is tessellated otherwise, and of its area it may have more.
const TESSELLATED: f64 = 0.03;

/// A use with those of its triangles that were not found.
struct Part<'u, 's> {
    one: &'u Use<'s>,
    triangles: Vec<Corners>,
    /// The use in the other scene, by its index, which has most of the others.
    partner: Option<usize>,
    open: bool,
}

/// Looks for the rest of both scenes, and says what became of it; how many of A's uses were found.
pub fn compare<'s>(fitter: &Fitter<'s>, left: [Vec<usize>; 2], looks: &mut Looks<'s>, report: &mut Report) -> usize {
    let all = left[0].len();
    let mut parts = apart(fitter, &left, looks, report);
    planes(fitter, &mut parts, looks, report);
    tessellated(fitter, &mut parts, looks, report);
    changed(fitter, &mut parts, report);
    moved(fitter, &mut parts, looks, report);
    for (side, what) in [(0, "only in A"), (1, "only in B")] {
        for part in parts[side].iter().filter(|part| part.open) {
            let bounds = part.one.bounds();
            let count = part.triangles.len();
            let triangles = if count == 1 { "1 triangle".to_owned() } else { format!("{count} triangles") };
            let mut words = ["none".to_owned(), "none".to_owned()];
            words[side] = format!("{triangles} around {}", point(bounds.center()));
            let mut places = [None, None];
            places[side] = place(part.one);
            report.add(Kind::Surface, what, words, places);
        }
    }
    all - parts[0].iter().filter(|part| part.open).count()
}

/// Finds triangles one by one; what is left of each use.
fn apart<'u, 's>(
    fitter: &Fitter<'s>,
    left: &[Vec<usize>; 2],
    looks: &mut Looks<'s>,
    report: &mut Report,
) -> [Vec<Part<'u, 's>>; 2]
where
    's: 'u,
{
    let uses = [0, 1].map(|side| &fitter.sides[side].uses);
    let many = (0..2).any(|side| left[side].iter().map(|at| uses[side][*at].count).sum::<usize>() > TRIANGLES);
    let gather = |side: usize| -> (Vec<usize>, Vec<(&'s Use<'s>, Corners)>) {
        let of = |at: usize| fitter.sides[side].triangles(&uses[side][at]).map(move |corners| (at, corners));
        let all = left[side].iter().copied().filter(|_| !many).flat_map(of);
        all.map(|(at, corners)| (at, (&fitter.sides[side].uses[at], corners))).unzip()
    };
    let ((owners_a, a), (owners_b, b)) = (gather(0), gather(1));
    let mut together: BTreeMap<(usize, usize), (Fit, usize)> = BTreeMap::new();
    let mut found = [vec![false; a.len()], vec![false; b.len()]];
    for (at, to, fit) in fitter.triangles(&a, &b) {
        (found[0][at], found[1][to]) = (true, true);
        let entry = together.entry((owners_a[at], owners_b[to])).or_default();
        *entry = (entry.0.and(fit), entry.1 + 1);
    }
    let mut partners = [HashMap::new(), HashMap::new()];
    for ((at, to), (fit, count)) in &together {
        looks.compare(fitter, &uses[0][*at], &uses[1][*to], *fit, report);
        for (side, own, other) in [(0, at, to), (1, to, at)] {
            let best: &mut (usize, usize) = partners[side].entry(*own).or_default();
            if *count > best.0 {
                *best = (*count, *other);
            }
        }
    }
    [(0, owners_a, a), (1, owners_b, b)].map(|(side, owners, all)| {
        let mut open: BTreeMap<usize, Vec<Corners>> = left[side].iter().map(|at| (*at, Vec::new())).collect();
        for ((owner, (_, corners)), found) in owners.iter().zip(&all).zip(&found[side]) {
            if !found {
                open.entry(*owner).or_default().push(*corners);
            }
        }
        let part = |(at, triangles): (usize, Vec<Corners>)| {
            let partner = partners[side].get(&at).map(|(_, other)| *other);
            Part { one: &fitter.sides[side].uses[at], triangles, partner, open: true }
        };
        // Where there are too many to look at one by one, all are left as wholes.
        open.into_iter().map(part).filter(|part| many || !part.triangles.is_empty()).collect()
    })
}

/// A surface in sums that do not depend on its triangles.
#[derive(Clone, Copy, Debug)]
struct Sheet {
    area: f64,
    middle: Vec3,
    /// Products of coordinates around the middle, times area.
    spread: [Vec3; 3],
    /// The sum of its normals, times area.
    towards: Vec3,
    bounds: Bounds,
}

impl Sheet {
    fn of(triangles: &[Corners]) -> Option<Self> {
        let mut bounds: Option<Bounds> = None;
        let (mut area, mut first, mut towards) = (0.0, [0.0; 3], [0.0; 3]);
        for corners in triangles {
            let [a, b, c] = corners.at;
            let own = Bounds::of_triangle(corners.at);
            bounds = Some(bounds.map_or(own, |all| all.union(own)));
            let normal = cross(sub(b, a), sub(c, a)).map(|x| 0.5 * x);
            let size = length(normal);
            area += size;
            first.iter_mut().zip(corners.middle()).for_each(|(sum, x)| *sum += size * x);
            towards.iter_mut().zip(normal).for_each(|(sum, x)| *sum += x);
        }
        let middle = first.map(|x| x / area);
        let mut spread = [[0.0; 3]; 3];
        for corners in triangles {
            let [a, b, c] = corners.at.map(|corner| sub(corner, middle));
            let size = 0.5 * length(cross(sub(b, a), sub(c, a)));
            let sum = [0, 1, 2].map(|axis| a[axis] + b[axis] + c[axis]);
            for (x, row) in spread.iter_mut().enumerate() {
                for (y, entry) in row.iter_mut().enumerate() {
                    // The integral of a product over a triangle.
                    *entry += size / 12.0 * (a[x] * a[y] + b[x] * b[y] + c[x] * c[y] + sum[x] * sum[y]);
                }
            }
        }
        bounds.map(|bounds| Self { area, middle, spread, towards, bounds })
    }

    /// Whether it lies in a plane.
    fn flat(&self) -> bool {
        length(self.towards) >= self.area * (1.0 - 1e-5) && {
            let normal = self.towards.map(|x| x / length(self.towards));
            let across = dot(self.spread.map(|row| dot(row, normal)), normal);
            across <= 1e-8 * self.area * dot(self.bounds.size(), self.bounds.size())
        }
    }

    /// How far its box and its middle are from those of another one, and whether that is near as a share of its diagonal.
    fn near(&self, other: &Self, share: f64) -> bool {
        let within = share * self.bounds.diagonal();
        let apart = [(self.bounds.low, other.bounds.low), (self.bounds.high, other.bounds.high)];
        apart.iter().all(|(a, b)| length(sub(*a, *b)) <= within)
            && length(sub(self.middle, other.middle)) <= within
            && (self.area - other.area).abs() <= 2.0 * share * self.area
    }

    /// Whether both are the same part of one plane.
    fn same(&self, other: &Self, share: f64) -> bool {
        self.flat() && other.flat() && self.near(other, share) && self.same_spread(other, share)
    }

    /// Whether the second moments agree too.
    fn same_spread(&self, other: &Self, share: f64) -> bool {
        let most = 4.0 * share * self.area * dot(self.bounds.size(), self.bounds.size());
        self.spread.iter().flatten().zip(other.spread.iter().flatten()).all(|(a, b)| (a - b).abs() <= most)
    }
}

/// Takes out what lies in one plane and is the same there, cut into other triangles.
fn planes<'s>(fitter: &Fitter<'s>, parts: &mut [Vec<Part<'_, 's>>; 2], looks: &mut Looks<'s>, report: &mut Report) {
    /// A plane of a part: which part, which of its triangles.
    type Plane = (usize, Vec<usize>);
    let planes = [0, 1].map(|side| {
        let mut all: BTreeMap<(usize, [i64; 4]), Vec<usize>> = BTreeMap::new();
        for (at, part) in parts[side].iter().enumerate() {
            let size = part.one.bounds().reach().max(f64::MIN_POSITIVE);
            for (index, corners) in part.triangles.iter().enumerate() {
                let [a, b, c] = corners.at;
                let Some(normal) = normalized(cross(sub(b, a), sub(c, a))) else { continue };
                let [x, y, z] = normal.map(|x| (1e3 * x).round() as i64);
                let key = [x, y, z, (1e3 * dot(normal, a) / size).round() as i64];
                all.entry((at, key)).or_default().push(index);
            }
        }
        all.into_iter().map(|((at, _), triangles)| (at, triangles)).collect::<Vec<Plane>>()
    });
    let sheets = [0, 1].map(|side| {
        let of = |(at, triangles): &Plane| {
            let own: Vec<Corners> = triangles.iter().map(|index| parts[side][*at].triangles[*index]).collect();
            Sheet::of(&own)
        };
        planes[side].iter().filter_map(of).collect::<Vec<Sheet>>()
    });
    let spots = [0, 1].map(|side| {
        let reach = |sheet: &Sheet| if side == 0 { fitter.measure.share * sheet.bounds.diagonal() } else { 0.0 };
        sheets[side].iter().map(|sheet| Spot { at: sheet.middle, reach: reach(sheet) }).collect::<Vec<Spot>>()
    });
    let found = pairs(&spots[0], &spots[1], |at, to| {
        let (one, other) = (&sheets[0][at], &sheets[1][to]);
        let same = one.same(other, fitter.measure.share);
        same.then(|| u32::from(dot(one.towards, other.towards) < 0.0))
    });
    let mut gone = [0, 1].map(|side| vec![BTreeSet::new(); parts[side].len()]);
    let mut together: BTreeMap<(usize, usize), Fit> = BTreeMap::new();
    for (at, to) in found {
        let ((one, triangles), (other, more)) = (&planes[0][at], &planes[1][to]);
        let turned = dot(sheets[0][at].towards, sheets[1][to].towards) < 0.0;
        let entry = together.entry((*one, *other)).or_default();
        *entry = entry.and(Fit { turned, ..Fit::default() });
        gone[0][*one].extend(triangles.iter().copied());
        gone[1][*other].extend(more.iter().copied());
    }
    for ((at, to), fit) in together {
        looks.compare(fitter, parts[0][at].one, parts[1][to].one, fit, report);
    }
    for (parts, gone) in parts.iter_mut().zip(gone) {
        for (part, gone) in parts.iter_mut().zip(gone) {
            let mut index = 0..;
            part.triangles.retain(|_| index.next().is_none_or(|index| !gone.contains(&index)));
            part.open = gone.is_empty() || !part.triangles.is_empty();
        }
        parts.retain(|part| part.open);
    }
}

/// Surfaces of other triangles: flat ones that are the same are, others of other numbers of triangles are told.
fn tessellated<'s>(
    fitter: &Fitter<'s>,
    parts: &mut [Vec<Part<'_, 's>>; 2],
    looks: &mut Looks<'s>,
    report: &mut Report,
) {
    let sheets = [0, 1].map(|side| parts[side].iter().map(|part| Sheet::of(&part.triangles)).collect::<Vec<_>>());
    let spots = |side: usize| -> Vec<Spot> {
        let spot = |sheet: &Option<Sheet>| {
            sheet.map_or(Spot { at: [f64::MAX; 3], reach: 0.0 }, |sheet| Spot {
                at: sheet.middle,
                reach: if side == 0 { TESSELLATED * sheet.bounds.diagonal() } else { 0.0 },
            })
        };
        sheets[side].iter().map(spot).collect()
    };
    let share = fitter.measure.share;
    let exact = |a: &Sheet, b: &Sheet| a.same(b, share);
    let found = pairs(&spots(0), &spots(1), |at, to| {
        let (one, other) = (sheets[0][at]?, sheets[1][to]?);
        if exact(&one, &other) {
            return Some(0);
        }
        let counts = parts[0][at].triangles.len() != parts[1][to].triangles.len();
        (counts && one.near(&other, TESSELLATED)).then_some(1)
    });
    for (at, to) in found {
        let (Some(one), Some(other)) = (sheets[0][at], sheets[1][to]) else { continue };
        let (a, b) = (&parts[0][at], &parts[1][to]);
        if !exact(&one, &other) {
            let words = [a, b].map(|part| format!("{} triangles", part.triangles.len()));
            report.add(Kind::Surface, "tessellation", words, [place(a.one), place(b.one)]);
        }
        let fit = Fit { turned: dot(one.towards, other.towards) < -0.5 * one.area * other.area, ..Fit::default() };
        looks.compare(fitter, a.one, b.one, fit, report);
        (parts[0][at].open, parts[1][to].open) = (false, false);
    }
}

/// Uses of which a part was found.
fn changed(fitter: &Fitter<'_>, parts: &mut [Vec<Part<'_, '_>>; 2], report: &mut Report) {
    let index: HashMap<*const Use<'_>, usize> =
        parts[1].iter().enumerate().map(|(at, part)| (std::ptr::from_ref(part.one).cast(), at)).collect();
    let [ours, theirs] = parts;
    for part in ours.iter_mut().filter(|part| part.open) {
        let Some(other) = part.partner.map(|to| &fitter.sides[1].uses[to]) else { continue };
        part.open = false;
        let partner = index.get(&std::ptr::from_ref(other).cast()).map(|at| &mut theirs[*at]).filter(|part| part.open);
        let places = [place(part.one), place(other)];
        if let Some(partner) = partner {
            partner.open = false;
            let what = differs(fitter, part.one, other, &part.triangles, &partner.triangles);
            let words = |part: &Part<'_, '_>| format!("{} of {} triangles", part.triangles.len(), part.one.count);
            report.add(Kind::Surface, &what, [words(part), words(partner)], places);
        } else {
            let words = [format!("{} of {}", part.triangles.len(), part.one.count), "none".to_owned()];
            report.add(Kind::Surface, "triangles only in A", words, places);
        }
    }
    for part in theirs.iter_mut().filter(|part| part.open) {
        let Some(other) = part.partner.map(|to| &fitter.sides[0].uses[to]) else { continue };
        part.open = false;
        let words = ["none".to_owned(), format!("{} of {}", part.triangles.len(), part.one.count)];
        report.add(Kind::Surface, "triangles only in B", words, [place(other), place(part.one)]);
    }
}

/// How two surfaces at one place differ, in words.
fn differs(fitter: &Fitter<'_>, a: &Use<'_>, b: &Use<'_>, ours: &[Corners], theirs: &[Corners]) -> String {
    let within = fitter.within(a);
    match distance(ours, theirs, (0.03 * a.bounds().diagonal()).max(within)) {
        Some(apart) if apart <= within => "tessellation: the same corners, other triangles".to_owned(),
        Some(apart) => format!("corners up to {} apart", short(apart)),
        None if a.count == b.count => "another form".to_owned(),
        None => "another form, or another tessellation".to_owned(),
    }
}

/// How far a corner of one surface lies at most from the nearest one of the other; none beyond `reach`, or where there are too many.
fn distance(a: &[Corners], b: &[Corners], reach: f64) -> Option<f64> {
    const MOST: usize = 200_000;
    let cell = |at: Vec3| at.map(|x| (x / reach).floor() as i64);
    let corners = |all: &[Corners]| -> HashSet<[u64; 3]> {
        all.iter().flat_map(|corners| corners.at).map(|at| at.map(f64::to_bits)).collect()
    };
    let (one, other) = (corners(a), corners(b));
    if one.len().max(other.len()) > MOST {
        return None;
    }
    let farthest = |from: &HashSet<[u64; 3]>, to: &HashSet<[u64; 3]>| -> Option<f64> {
        let sorted = |all: &HashSet<[u64; 3]>| all.iter().copied().collect::<BTreeSet<[u64; 3]>>();
        let mut cells: HashMap<[i64; 3], Vec<Vec3>> = HashMap::new();
        for at in sorted(to) {
            let at = at.map(f64::from_bits);
            cells.entry(cell(at)).or_default().push(at);
        }
        let nearest = |at: Vec3| -> Option<f64> {
            let [x, y, z] = cell(at);
            let around =
                (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
            let near = around.filter_map(|key| cells.get(&key)).flatten().map(|other| length(sub(*other, at)));
            near.min_by(f64::total_cmp).filter(|apart| *apart <= reach)
        };
        let all = sorted(from).into_iter().map(|at| nearest(at.map(f64::from_bits)));
        all.collect::<Option<Vec<f64>>>()?.into_iter().max_by(f64::total_cmp)
    };
    Some(farthest(&one, &other)?.max(farthest(&other, &one)?))
}

/// Uses of which nothing was found: the same elsewhere, turned, or by their names.
fn moved<'s>(fitter: &Fitter<'s>, parts: &mut [Vec<Part<'_, 's>>; 2], looks: &mut Looks<'s>, report: &mut Report) {
    for round in [Round::Moved, Round::Turned, Round::Named] {
        // Along a line that no scene has an axis on, so that what is moved as a whole is paired in its order.
        let along = |side: usize, at: usize| dot(parts[side][at].one.mean, [0.5417, 0.3163, 0.7788]);
        let open = [0, 1].map(|side| {
            let mut open: Vec<usize> = (0..parts[side].len()).filter(|at| parts[side][*at].open).collect();
            open.sort_by(|one, other| along(side, *one).total_cmp(&along(side, *other)));
            open
        });
        let mut names: HashMap<String, u32> = HashMap::new();
        let mut spot = |side: usize, at: usize| {
            let one = parts[side][at].one;
            let reach = if side == 0 { 4.0 * fitter.within(one) } else { 0.0 };
            let at = match round {
                Round::Moved => [0, 1, 2].map(|axis| one.spread[axis][axis].max(0.0).sqrt()),
                Round::Turned => [one.size().sqrt(), 0.0, 0.0],
                Round::Named => {
                    let next = names.len() as u32;
                    [f64::from(*names.entry(one.placed.name()).or_insert(next)), 0.0, 0.0]
                }
            };
            Spot { at, reach: if round == Round::Named && side == 0 { 0.1 } else { reach } }
        };
        let ours: Vec<Spot> = open[0].iter().map(|at| spot(0, *at)).collect();
        let theirs: Vec<Spot> = open[1].iter().map(|at| spot(1, *at)).collect();
        let found = pairs(&ours, &theirs, |at, to| {
            let (a, b) = (parts[0][open[0][at]].one, parts[1][open[1][to]].one);
            if round == Round::Named {
                return Some(0);
            }
            let named = a.placed.shape.name == b.placed.shape.name && a.placed.name() == b.placed.name();
            let most = 4.0 * fitter.within(a) * a.bounds().diagonal();
            let spread = a.spread.iter().flatten().zip(b.spread.iter().flatten());
            let same = round == Round::Turned || spread.into_iter().all(|(a, b)| (a - b).abs() <= most);
            (a.count == b.count && same).then_some(u32::from(!named))
        });
        for (at, to) in found {
            let (at, to) = (open[0][at], open[1][to]);
            let (a, b) = (parts[0][at].one, parts[1][to].one);
            told(fitter, round, [&parts[0][at], &parts[1][to]], report);
            looks.compare(fitter, a, b, Fit::default(), report);
            (parts[0][at].open, parts[1][to].open) = (false, false);
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Round {
    Moved,
    Turned,
    Named,
}

fn told(fitter: &Fitter<'_>, round: Round, [ours, theirs]: [&Part<'_, '_>; 2], report: &mut Report) {
    let (a, b) = (ours.one, theirs.one);
    let by = sub(b.mean, a.mean);
    let around = || [a, b].map(|one| format!("around {}", point(one.bounds().center())));
    let extent = |one: &Use<'_>| {
        let [x, y, z] = one.bounds().size().map(short);
        format!("{x} x {y} x {z}, {} triangles, around {}", one.count, point(one.bounds().center()))
    };
    let (what, words) = if round == Round::Moved && length(by) > fitter.within(a) {
        // As many digits as the move has, so that all that are moved together are one difference.
        let digit = 1e-4 * length(by);
        (format!("moved by {}", point(by.map(|x| (x / digit).round() * digit))), around())
    } else if round == Round::Turned && length(by) > fitter.within(a) {
        ("moved and turned, or another form".to_owned(), around())
    } else {
        let what = match differs(fitter, a, b, &ours.triangles, &theirs.triangles) {
            what if round != Round::Named && what.starts_with("another form") => "turned, or another form".to_owned(),
            what => what,
        };
        (what, [a, b].map(extent))
    };
    let key = if what.starts_with("moved by") { what.clone() } else { words.join("\n") + &what };
    report.add_by(Kind::Surface, key, &what, words, [place(a), place(b)]);
}
