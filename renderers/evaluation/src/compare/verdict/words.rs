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
