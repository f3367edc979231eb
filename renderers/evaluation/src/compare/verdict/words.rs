//! A verdict in words.

use super::stated::Stated;
use super::{Cell, Channel, Outcome, Verdict};

/// A channel by its number.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// A verdict with what stands beside it.
#[derive(Clone, Copy)]
pub struct Told<'v> {
    /// What is proved.
    pub verdict: &'v Verdict,
    /// What the targets state of the scene.
    pub stated: &'v [Stated],
    /// Whether the images differ by more than the tolerance, and by no more than is stated.
    pub excused: bool,
}

impl Told<'_> {
    /// The ratios of the channels with their standard errors.
    pub fn channels(&self) -> String {
        let of = |channel: &Channel| match channel.ratio {
            Some(ratio) => format!("{ratio:.4} +- {:.4}", channel.error),
            None => "-".to_owned(),
        };
        self.verdict.channels.iter().map(of).collect::<Vec<_>>().join(", ")
    }

    /// What stands behind the outcome, in words.
    pub fn proof(&self) -> String {
        let verdict = self.verdict;
        let within = format!(
            "{:.1} % in each of {} tiles, {:.1} % in the whole",
            100.0 * verdict.tolerance.tiles,
            verdict.tiles.len(),
            100.0 * verdict.tolerance.whole
        );
        match verdict.outcome {
            Outcome::Agree => format!("within {within}"),
            Outcome::Differ => {
                let cell = &verdict.worst;
                let share = if cell.grid == 1 { verdict.tolerance.whole } else { verdict.tolerance.tiles };
                format!("{}, z {:.1}, by more than {:.1} %", place(cell, verdict.side()), cell.z, 100.0 * share)
            }
            Outcome::Undecided if self.excused => {
                format!("{}, by more than {within}, which the targets state", place(&verdict.worst, verdict.side()))
            }
            Outcome::Undecided => {
                let open = verdict.tiles.iter().filter(|tile| **tile != Outcome::Agree).count();
                let needed = match verdict.needed.map(|needed| (needed.half, needed.most)) {
                    None => String::new(),
                    Some((None, _)) => {
                        "; if they are equal, ten thousand times the samples would not show it".to_owned()
                    }
                    Some((Some(half), most)) => {
                        let most = most.map_or(String::new(), |most| format!(", {} in nine of ten", rounded(most)));
                        let half = rounded(half);
                        format!("; if they are equal, {half} samples per pixel would show it in one of two cases{most}")
                    }
                };
                let tiles = if open == 1 { "tile" } else { "tiles" };
                format!("{open} {tiles} not within {within}{needed}")
            }
        }
    }

    /// What is to blame for the outcome: the cell that differs the most for its noise.
    pub fn blame(&self) -> String {
        let worst = &self.verdict.worst;
        format!("{}, z {:.1}", place(worst, self.verdict.side()), worst.z)
    }

    /// What else there is to know.
    pub fn notes(&self) -> Vec<String> {
        let verdict = self.verdict;
        let mut notes: Vec<String> = Vec::new();
        for Stated { by, what, share } in self.stated {
            notes.push(format!("{by} states up to {:.1} % for {what}", 100.0 * share));
        }
        if verdict.rare > 0 {
            notes.push(format!(
                "{} beside rare bright samples that {} not met",
                if verdict.rare == 1 { "1 tile agrees".to_owned() } else { format!("{} tiles agree", verdict.rare) },
                if verdict.rare == 1 { "it has" } else { "they have" }
            ));
        }
        if verdict.together.0 || verdict.together.1 {
            notes.push("whole images go up and down together".to_owned());
        }
        if verdict.masked > 0 {
            let pixels = if verdict.masked == 1 { "pixel" } else { "pixels" };
            notes.push(format!("{} {pixels} left out: not finite, or a light seen directly", verdict.masked));
        }
        notes
    }
}

/// A place and its ratio in words: `green of tile 3, 4 is 1.0210 of it`.
fn place(cell: &Cell, tiles: usize) -> String {
    let Cell { grid, at: (column, row), channel, ratio, z: _ } = cell;
    let of = match grid {
        1 => "the whole image".to_owned(),
        grid if *grid == tiles => format!("tile {column}, {row}"),
        _ => format!("cell {column}, {row} of {grid} x {grid}"),
    };
    let ratio = ratio.map_or("light where A is black".to_owned(), |ratio| format!("{ratio:.4}"));
    format!("{} of {of}: {ratio}", CHANNELS[(*channel).min(2)])
}

/// Samples to two digits.
fn rounded(samples: f64) -> String {
    let scale = 10_f64.powf(samples.log10().floor() - 1.0).max(1.0);
    format!("{:.0}", (samples / scale).ceil() * scale)
}

#[cfg(test)]
mod tests {
    use super::super::{Needed, Tolerance};
    use super::*;

    fn verdict(outcome: Outcome) -> Verdict {
        let channel = |ratio| Channel { ratio, error: 0.001_23 };
        Verdict {
            outcome,
            tolerance: Tolerance { tiles: 0.05, whole: 0.01 },
            images: (4, 4),
            channels: [channel(Some(1.0)), channel(Some(0.987_654)), channel(None)],
            worst: Cell { grid: 2, at: (1, 0), channel: 1, ratio: Some(1.25), z: -5.25 },
            tiles: vec![Outcome::Agree; 4],
            differing: 0,
            needed: None,
            rare: 0,
            together: (false, false),
            masked: 0,
        }
    }

    fn told(verdict: &Verdict) -> Told<'_> {
        Told { verdict, stated: &[], excused: false }
    }

    #[test]
    fn proofs_are_told_in_words() {
        let agreed = verdict(Outcome::Agree);
        assert_eq!(told(&agreed).proof(), "within 5.0 % in each of 4 tiles, 1.0 % in the whole");
        assert_eq!(told(&agreed).channels(), "1.0000 +- 0.0012, 0.9877 +- 0.0012, -");
        assert_eq!(told(&agreed).blame(), "green of tile 1, 0: 1.2500, z -5.2");
        let differs = |grid: usize, channel: usize, ratio: Option<f64>| {
            let mut verdict = verdict(Outcome::Differ);
            verdict.worst = Cell { grid, at: (1, 0), channel, ratio, z: 6.0 };
            told(&verdict).proof()
        };
        assert_eq!(differs(2, 1, Some(1.25)), "green of tile 1, 0: 1.2500, z 6.0, by more than 5.0 %");
        assert_eq!(differs(1, 0, Some(0.5)), "red of the whole image: 0.5000, z 6.0, by more than 1.0 %");
        assert_eq!(
            differs(4, 2, None),
            "blue of cell 1, 0 of 4 x 4: light where A is black, z 6.0, by more than 5.0 %"
        );
        let open = verdict(Outcome::Undecided);
        assert_eq!(
            Told { excused: true, ..told(&open) }.proof(),
            "green of tile 1, 0: 1.2500, by more than 5.0 % in each of 4 tiles, 1.0 % in the whole, which the targets state"
        );
    }

    #[test]
    fn what_is_open_and_what_would_decide_it_is_told() {
        let open = |tiles: &[Outcome], needed: Option<(Option<f64>, Option<f64>)>| {
            let mut verdict = verdict(Outcome::Undecided);
            verdict.tiles[..tiles.len()].copy_from_slice(tiles);
            verdict.needed = needed.map(|(half, most)| Needed { half, most, tile: None });
            let text = told(&verdict).proof();
            text.replace(" not within 5.0 % in each of 4 tiles, 1.0 % in the whole", "")
        };
        use Outcome::{Differ, Undecided};
        assert_eq!((open(&[], None), open(&[Undecided], None)), ("0 tiles".to_owned(), "1 tile".to_owned()));
        assert_eq!(open(&[Undecided, Differ], None), "2 tiles");
        let never = "1 tile; if they are equal, ten thousand times the samples would not show it";
        assert_eq!(open(&[Undecided], Some((None, None))), never);
        let half = "1 tile; if they are equal, 1300 samples per pixel would show it in one of two cases";
        assert_eq!(open(&[Undecided], Some((Some(1234.0), None))), half);
        assert_eq!(open(&[Undecided], Some((Some(1234.0), Some(5001.0)))), format!("{half}, 5100 in nine of ten"));
        for (samples, text) in
            [(0.3, "1"), (5.0, "5"), (9.1, "10"), (12.0, "12"), (99.2, "100"), (100.0, "100"), (123_456.0, "130000")]
        {
            assert_eq!(rounded(samples), text, "{samples}");
        }
    }

    #[test]
    fn notes_say_what_else_there_is() {
        let of = |rare: usize, together: (bool, bool), masked: usize| {
            told(&Verdict { rare, together, masked, ..verdict(Outcome::Agree) }).notes()
        };
        assert!(of(0, (false, false), 0).is_empty());
        assert_eq!(of(1, (false, false), 0), ["1 tile agrees beside rare bright samples that it has not met"]);
        assert_eq!(of(2, (false, false), 0), ["2 tiles agree beside rare bright samples that they have not met"]);
        for together in [(true, false), (false, true), (true, true)] {
            assert_eq!(of(0, together, 0), ["whole images go up and down together"]);
        }
        assert_eq!(of(0, (false, false), 1), ["1 pixel left out: not finite, or a light seen directly"]);
        assert_eq!(of(0, (false, false), 2), ["2 pixels left out: not finite, or a light seen directly"]);
        let stated = [Stated { by: "pbrt".to_owned(), what: "glass".to_owned(), share: 0.025 }];
        let verdict = verdict(Outcome::Agree);
        assert_eq!(Told { stated: &stated, ..told(&verdict) }.notes(), ["pbrt states up to 2.5 % for glass"]);
    }
}
