//! Sweeps over parameters of scenes: lists, and ranges with a step or a count.

use super::reader::{Item, Reader, Table, near};
use super::written::{MOST_VALUES, WrittenSweep};

/// A value of a scene's parameter as the text of an expression.
pub(super) fn expression(item: &Item<'_>, reader: &mut Reader) -> Option<String> {
    if item.as_str().is_some() {
        return item.word(reader).map(|text| text.value);
    }
    if let Some(value) = item.as_bool() {
        return Some(value.to_string());
    }
    let number = item.as_int().map(|number| number.to_string()).or_else(|| item.as_number().map(show));
    if number.is_none() {
        reader.mismatch(item, "a number, a boolean, or an expression as a string");
    }
    number
}

/// A number as it stands in scenes.
fn show(number: f64) -> String {
    format!("{number}")
}

/// `[[sweep]]`.
pub(super) fn read(mut table: Table<'_>, reader: &mut Reader) -> Option<WrittenSweep> {
    let span = table.span;
    let parameter = table.take("parameter").map(|item| item.word(reader));
    let scenes = table.take("scenes").map(|item| item.words(reader));
    let listed = table.take("values");
    let range = ["from", "to", "step", "count", "scale"].map(|key| table.take(key));
    table.finish(reader);
    if parameter.is_none() {
        reader.error("evaluation-missing", span, "a sweep has no `parameter`");
    }
    let parameter = parameter.flatten();
    let values = match (listed, range.iter().flatten().next()) {
        (Some(listed), None) => values(&listed, reader),
        (None, Some(_)) => of_range(range, span, reader),
        (Some(listed), Some(range)) => {
            let message = format!("a sweep has `values` or a range, not both (`{}`)", range.name);
            reader.error("evaluation-key", listed.key, message);
            None
        }
        (None, None) => {
            reader.error("evaluation-missing", span, "a sweep has neither `values` nor a range").help =
                Some("write `values = [1, 2, 4]`, or `from = 1`, `to = 4` and `count = 7`".to_owned());
            None
        }
    };
    let (parameter, values) = (parameter?, values?);
    Some(WrittenSweep { parameter, scenes, values, span })
}

fn values(item: &Item<'_>, reader: &mut Reader) -> Option<Vec<String>> {
    let list = item.list(reader)?;
    if list.is_empty() || list.len() > MOST_VALUES {
        let problem = if list.is_empty() { "is empty" } else { "has more than 10,000 values" };
        reader.error("evaluation-value", item.span, format!("the list `values` {problem}"));
        return None;
    }
    let values: Vec<Option<String>> = list.iter().map(|value| expression(value, reader)).collect();
    let values: Vec<String> = values.into_iter().collect::<Option<_>>()?;
    for (at, value) in values.iter().enumerate() {
        if values[..at].contains(value) {
            reader.error(
                "evaluation-duplicate",
                list[at].span,
                format!("the value `{value}` stands twice in the sweep"),
            );
            return None;
        }
    }
    Some(values)
}

#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "there are at most 10,000 values"
)]
fn of_range(range: [Option<Item<'_>>; 5], span: ltsc_core::diag::Span, reader: &mut Reader) -> Option<Vec<String>> {
    let [from, to, step, count, scale] = range;
    let missing = from.is_none() || to.is_none() || step.is_some() == count.is_some();
    let from = from.and_then(|item| item.number(reader));
    let to = to.and_then(|item| item.number(reader));
    let step = step.map(|item| item.above_zero(reader));
    let count = count.map(|item| item.count(reader, 2..=MOST_VALUES as u32));
    let scale = scale.map_or(Some(false), |item| {
        let word = item.word(reader)?;
        let known = ["linear", "log"];
        if !known.contains(&word.value.as_str()) {
            let message = format!("`scale` is not `{}`", word.value);
            reader.error("evaluation-value", word.span, message).help = near(&word.value, known);
            return None;
        }
        Some(word.value == "log")
    });
    if missing {
        reader.error("evaluation-missing", span, "a range has `from`, `to`, and either `step` or `count`");
        return None;
    }
    let (from, to, log) = (from?, to?, scale?);
    let place = from.span.to(to.span);
    if from.value == to.value || !(to.value - from.value).is_finite() {
        reader.error("evaluation-value", place, "the range has no extent that can be divided");
        return None;
    }
    if let Some(step) = step {
        let step = step?;
        if log {
            reader.error("evaluation-value", step.span, "a range on a logarithmic scale has a `count`, not a `step`");
            return None;
        }
        // A step that ends a rounding error before `to` ends there.
        let steps = ((to.value - from.value).abs() / step.value + 1e-9).floor();
        if steps >= MOST_VALUES as f64 {
            reader.error("evaluation-value", step.span, "the range has more than 10,000 values");
            return None;
        }
        let signed = step.value.copysign(to.value - from.value);
        return Some(distinct((0..=steps as usize).map(|at| from.value + at as f64 * signed)));
    }
    let last = count??.value - 1;
    if log && (from.value <= 0.0 || to.value <= 0.0) {
        reader.error("evaluation-value", place, "a logarithmic scale takes numbers above 0");
        return None;
    }
    let value = |at: u32| {
        let share = f64::from(at) / f64::from(last);
        match at {
            0 => from.value,
            _ if at == last => to.value,
            _ if log => libm::exp(libm::log(from.value) * (1.0 - share) + libm::log(to.value) * share),
            _ => from.value * (1.0 - share) + to.value * share,
        }
    };
    Some(distinct((0..=last).map(value)))
}

/// The numbers as texts, each once: twelve digits, so that 0.1 + 0.2 reads 0.3.
fn distinct(numbers: impl Iterator<Item = f64>) -> Vec<String> {
    let round = |number: f64| format!("{number:.11e}").parse::<f64>().unwrap_or(number);
    let mut texts: Vec<String> = numbers.map(|number| show(round(number))).collect();
    texts.dedup();
    texts
}
