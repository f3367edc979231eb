//! Settings, budgets, times and shares.

use std::time::Duration;

use ltsc_core::ir::{Filter, Integrator, Sampler};

use super::model::{At, Budget, Settings};
use super::reader::{Item, Reader, near};

/// The widest image that a scene can have.
const WIDEST: u32 = 65_536;

/// `settings`.
pub(super) fn settings(item: &Item<'_>, reader: &mut Reader) -> Settings {
    let Some(mut table) = item.table(reader, "`settings`") else { return Settings::default() };
    let integrator = table.take("integrator").and_then(|item| one_of(&item, reader, &Integrator::WORDS));
    let max_depth = table.take("max_depth").and_then(|item| item.count(reader, 1..=u32::MAX));
    let samples = table.take("samples").and_then(|item| item.count(reader, 1..=u32::MAX));
    let sampler = table.take("sampler").and_then(|item| one_of(&item, reader, &Sampler::WORDS));
    let filter = table.take("filter").and_then(|item| filter(&item, reader));
    let size = table.take("size").and_then(|item| size(&item, reader));
    let seed = table.take("seed").and_then(|item| item.count(reader, 0..=u32::MAX));
    table.finish(reader);
    Settings { integrator, max_depth, samples, sampler, filter, size, seed }
}

/// One of several words.
fn one_of(item: &Item<'_>, reader: &mut Reader, known: &[&'static str]) -> Option<At<&'static str>> {
    if item.as_table(reader, "").is_some() {
        reader.mismatch(item, "a string");
        if let Some(found) = reader.findings.last_mut() {
            found.help = Some(
                "native statements stand under `parameters`; `settings` are the same for all renderers".to_owned(),
            );
        }
        return None;
    }
    let word = item.word(reader)?;
    let found = known.iter().find(|name| **name == word.value);
    if found.is_none() {
        let message = format!("`{}` is no neutral {}", word.value, item.name);
        let help = near(&word.value, known.iter().copied()).unwrap_or_default();
        reader.error("evaluation-setting", word.span, message).help =
            Some(format!("{help}; any other is passed through by `parameters`"));
    }
    found.map(|name| At::new(*name, word.span))
}

/// `box`, `gaussian`, or a table with `type` and lengths.
fn filter(item: &Item<'_>, reader: &mut Reader) -> Option<At<Filter>> {
    let (kind, stddev, radius) = if let Some(mut table) = item.as_table(reader, "`filter`") {
        let kind = table.take("type").map(|item| item.word(reader));
        let stddev = table.take("stddev").map(|item| item.above_zero(reader));
        let radius = table.take("radius").map(|item| item.above_zero(reader));
        table.finish(reader);
        if kind.is_none() {
            reader.error("evaluation-missing", item.span, "a filter has no `type`");
        }
        (kind??, stddev, radius)
    } else {
        (item.word(reader)?, None, None)
    };
    let filter = match kind.value.as_str() {
        "box" => {
            if let Some(Some(stddev)) = stddev {
                reader.error("evaluation-key", stddev.span, "a box has no `stddev`");
                return None;
            }
            Filter::Box { radius: radius.map_or(Some(0.5), |radius| Some(radius?.value))? }
        }
        "gaussian" => {
            let stddev = stddev.map_or(Some(0.5), |stddev| Some(stddev?.value))?;
            Filter::Gaussian { stddev, radius: radius.map_or(Some(4.0 * stddev), |radius| Some(radius?.value))? }
        }
        other => {
            let message = format!("`{other}` is no neutral filter");
            reader.error("evaluation-setting", kind.span, message).help =
                Some("known: box, gaussian; any other is passed through by `parameters`".to_owned());
            return None;
        }
    };
    Some(At::new(filter, item.span))
}

/// Width and height, or one number for both.
fn size(item: &Item<'_>, reader: &mut Reader) -> Option<At<(u32, u32)>> {
    if item.is_int() {
        let side = item.count(reader, 1..=WIDEST)?.value;
        return Some(At::new((side, side), item.span));
    }
    let Some(list) = item.as_list(reader) else {
        reader.mismatch(item, "`[width, height]`");
        return None;
    };
    let [width, height] = list.as_slice() else {
        let message = format!("`size` takes `[width, height]`, not {} numbers", list.len());
        reader.error("evaluation-value", item.span, message);
        return None;
    };
    let (width, height) = (width.count(reader, 1..=WIDEST), height.count(reader, 1..=WIDEST));
    Some(At::new((width?.value, height?.value), item.span))
}

/// `budget`.
pub(super) fn budget(item: &Item<'_>, reader: &mut Reader) -> Budget {
    let Some(mut table) = item.table(reader, "`budget`") else { return Budget::default() };
    let time = table.take("time").and_then(|item| time(&item, reader));
    let samples = table.take("samples").and_then(|item| item.count(reader, 1..=u32::MAX));
    table.finish(reader);
    Budget { time, samples }
}

/// The units of times, and how many seconds each has.
const UNITS: &[(&str, f64)] = &[("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("m", 60.0), ("h", 3600.0)];

/// A hundred days.
const LONGEST: f64 = 8_640_000.0;

/// A number with a unit, such as `90s`, `1.5min` or `2h`, in seconds.
fn seconds(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|letter: char| letter.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let unit = UNITS.iter().find(|(name, _)| *name == unit);
    number.trim().parse::<f64>().ok().zip(unit).map(|(number, (_, seconds))| number * seconds)
}

/// A time as people write it outside of files: the same, or seconds without a unit. None where it is none, or not above 0.
#[must_use]
pub fn duration(text: &str) -> Option<Duration> {
    let seconds = text.trim().parse::<f64>().ok().or_else(|| seconds(text))?;
    // A microsecond is the least, so that a time can be written down and read back.
    (1e-6..=LONGEST).contains(&seconds).then(|| Duration::from_secs_f64(seconds))
}

/// Seconds, or a text with a unit: `90`, `"90s"`, `"1.5min"`.
pub(super) fn time(item: &Item<'_>, reader: &mut Reader) -> Option<At<Duration>> {
    let seconds = if let Some(text) = item.as_str() {
        seconds(text)
    } else if item.is_int() || item.as_float().is_some() {
        item.as_number()
    } else {
        reader.mismatch(item, "seconds, or a string with a unit");
        return None;
    };
    let seconds = seconds.filter(|seconds| (1e-6..=LONGEST).contains(seconds));
    if seconds.is_none() {
        reader.error("evaluation-value", item.span, format!("`{}` takes a time above 0", item.name)).help =
            Some("write seconds (`90`), or a string such as \"90s\", \"1.5min\" or \"2h\"".to_owned());
    }
    seconds.map(|seconds| At::new(Duration::from_secs_f64(seconds), item.span))
}

/// A share of at most 1.
pub(super) fn share(item: &Item<'_>, reader: &mut Reader) -> Option<At<f64>> {
    let share = item.above_zero(reader)?;
    if share.value >= 1.0 {
        let message = format!("`{}` is a share below 1", item.name);
        reader.error("evaluation-value", item.span, message).help = Some("0.05 is 5 %".to_owned());
        return None;
    }
    Some(share)
}
