//! The fixes, each where there is one right answer; where there are several, the finding's help names them and nothing is changed.

use crate::diag::{Edit, Fix, Span};
use crate::syntax::{self, Binary, Expr, ExprKind, Kind, Name, Statement, StatementKind, Unary};

use super::{Place, tree};

fn fix(title: impl Into<String>, edits: Vec<Edit>) -> Option<Fix> {
    Some(Fix { title: title.into(), edits })
}

fn edit(span: Span, text: impl Into<String>) -> Edit {
    Edit { span, text: text.into() }
}

/// `|> faceted()` behind the mesh of an emitter. It scatters nothing (the finding is not fixable otherwise), so that its normals do
/// nothing but choose a side.
pub fn facet_emitter(place: &Place<'_>) -> Option<Fix> {
    let statement = tree::statement(place.tree(), place.span, |statement| is(statement, &[Kind::Emitter]))?;
    stage_behind(place, statement, "faceted", "the emitter's mesh")
}

/// `|> flip()` behind a closed mesh that looks inwards: both sides scatter alike, and a lamp is not fixable. Not where the statement is carried out for other meshes, too: in a loop or
/// a function.
pub fn flip_mesh(place: &Place<'_>) -> Option<Fix> {
    let kinds = [Kind::Emitter, Kind::Shape];
    let statement = tree::statement(place.tree(), place.span, |statement| is(statement, &kinds))?;
    let repeats = |outer: &Statement| {
        matches!(&outer.kind, StatementKind::For { .. })
            || matches!(&outer.kind, StatementKind::Group { params, .. } if !params.is_empty())
    };
    if tree::statement(place.tree(), place.span, repeats).is_some() {
        return None;
    }
    stage_behind(place, statement, "flip", "the mesh")
}

/// `|> flip()` behind the mesh of an emitter that has everything behind it: as it is, it lights nothing. Not in a loop or a group, where the same statement
/// makes emitters at other places.
pub fn turn_emitter(place: &Place<'_>) -> Option<Fix> {
    let statement = tree::statement(place.tree(), place.span, |_| true)?;
    let alone = place.tree().statements.iter().any(|top| std::ptr::eq(top, statement));
    if !alone || !is(statement, &[Kind::Emitter]) {
        return None;
    }
    stage_behind(place, statement, "flip", "the emitter's mesh")
}

/// Generators that have a `center`, which is the origin unless it is given.
const CENTRED: &[&str] = &["box", "sphere"];

/// `box(size: 1, center: (1, 0, 0))` for `box(size: 1) |> translate(x: 1)`: the mesh lies in its place then. Whatever else moves a
/// mesh needs new coordinates, which nobody but its author can name.
pub fn center_mesh(place: &Place<'_>) -> Option<Fix> {
    let statement = tree::statement(place.tree(), place.span, |one| is(one, &[Kind::Emitter, Kind::Shape]))?;
    let StatementKind::Declaration { params: None, value, with: Some(_), .. } = &statement.kind else { return None };
    let ExprKind::Call(moves) = &value.kind else { return None };
    let mesh = moves.piped.as_ref().filter(|_| moves.name.text == "translate")?;
    let ExprKind::Call(made) = &mesh.kind else { return None };
    if made.piped.is_some() || !CENTRED.contains(&made.name.text.as_str()) {
        return None;
    }
    let has = |name: &str| made.args.iter().any(|arg| arg.label.as_ref().is_some_and(|label| label.text == name));
    if has("center") || made.name.text == "box" && !has("size") {
        return None;
    }
    let mut by = ["0"; 3];
    for (at, arg) in moves.args.iter().enumerate() {
        let axis = match &arg.label {
            Some(label) => ["x", "y", "z"].iter().position(|axis| *axis == label.text)?,
            None => at,
        };
        *by.get_mut(axis)? = place.text_of(arg.value.span);
    }
    // Between the brackets and the stage nothing may stand that would be lost or end the line.
    let bracket = made.span.end.checked_sub(1)?;
    let last = made.args.last().map(|arg| arg.value.span.end);
    let rest = place.range(last.unwrap_or(made.name.span.end + 1) as usize, bracket as usize);
    let stage = place.range(mesh.span.end as usize, moves.span.end as usize);
    if !place.text_of(rest).trim().is_empty() || place.text_of(stage).contains("//") {
        return None;
    }
    let comma = if last.is_some() { ", " } else { "" };
    let center = format!("center: ({})", by.join(", "));
    let at = place.range(bracket as usize, bracket as usize);
    fix(
        format!("write `{center}` in `{}`", made.name.text),
        vec![edit(at, format!("{comma}{center}")), edit(stage, "")],
    )
}

/// Whether a statement declares one of these.
fn is(statement: &Statement, kinds: &[Kind]) -> bool {
    matches!(statement.kind, StatementKind::Declaration { kind, .. } if kinds.contains(&kind))
}

/// A stage without arguments behind the mesh that a statement names.
fn stage_behind(place: &Place<'_>, statement: &Statement, name: &str, whose: &str) -> Option<Fix> {
    let StatementKind::Declaration { kind, name: _, params, value, with } = &statement.kind else { return None };
    // What has no material is a light, whose value is no mesh.
    if *kind != Kind::Mesh && (params.is_some() || with.is_none()) {
        return None;
    }
    // A finding that stays is about another use of the same mesh.
    if matches!(&value.kind, ExprKind::Call(call) if call.name.text == name) {
        return None;
    }
    let (start, end) = (value.span.start, end_of(value));
    let stage = format!(" |> {name}()");
    // What binds more loosely than `|>` gets brackets.
    let whole = matches!(value.kind, ExprKind::Call(_) | ExprKind::Name(_) | ExprKind::Index(_) | ExprKind::Member(..));
    let at = |byte: u32| place.range(byte as usize, byte as usize);
    let edits = if whole {
        vec![edit(at(end), stage.as_str())]
    } else {
        vec![edit(at(start), "("), edit(at(end), format!("){stage}"))]
    };
    fix(format!("write `|> {name}()` behind {whose}"), edits)
}

/// Where an expression ends: the span of a condition reaches over the blanks behind it.
fn end_of(expr: &Expr) -> u32 {
    if let ExprKind::If(parts) = &expr.kind { end_of(&parts.2).min(expr.span.end) } else { expr.span.end }
}

/// `lts 1` before everything else.
pub fn add_version(place: &Place<'_>) -> Option<Fix> {
    let start = if place.text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let end = if place.text.contains("\r\n") { "\r\n" } else { "\n" };
    let version = syntax::VERSION;
    let gap = if place.text[start..].trim().is_empty() { "" } else { end };
    fix(
        format!("write `lts {version}` first"),
        vec![edit(place.range(start, start), format!("lts {version}{end}{gap}"))],
    )
}

/// The ends of an interval of plain numbers in their order. A loop that runs backwards is another matter: it may mean `reverse`.
pub fn swap_interval(place: &Place<'_>) -> Option<Fix> {
    let argument = tree::argument(place.tree(), place.span)?;
    let ExprKind::Binary(Binary::Range, _, ends) = &argument.kind else { return None };
    let (Some(low), Some(high)) = (plain(&ends.0), plain(&ends.1)) else { return None };
    if low <= high {
        return None;
    }
    let (first, second) = (place.text_of(ends.0.span), place.text_of(ends.1.span));
    fix(format!("write `{second}..{first}`"), vec![edit(ends.0.span, second), edit(ends.1.span, first)])
}

/// The value of a number that stands there as one, with its sign.
fn plain(expr: &Expr) -> Option<f64> {
    if let ExprKind::Unary(Unary::Minus, of) = &expr.kind {
        return plain(of).map(|value| -value);
    }
    if let ExprKind::Number(value) | ExprKind::Unit(value, _) = &expr.kind { Some(*value) } else { None }
}

/// A suppression of nothing, with its line. One that stands before nothing may belong elsewhere, and stays.
pub fn remove_allow(place: &Place<'_>) -> Option<Fix> {
    let is = |statement: &Statement| matches!(statement.kind, StatementKind::Allow { .. });
    let statement = tree::statement(place.tree(), place.span, is)?;
    let last = place.tree().statements.iter().rev().find(|statement| !is(statement))?;
    if statement.span.start > last.span.start {
        return None;
    }
    fix("remove it", vec![edit(lines(place, statement)?, "")])
}

/// A name of `use` that is not used: out of the list, or the statement where it is the only one.
pub fn remove_used_name(place: &Place<'_>) -> Option<Fix> {
    let is = |statement: &Statement| matches!(statement.kind, StatementKind::Use { .. });
    let statement = tree::statement(place.tree(), place.span, is)?;
    let StatementKind::Use { names, path: _ } = &statement.kind else { return None };
    let whole = |(name, alias): &(Name, Option<Name>)| match alias {
        Some(alias) => name.span.to(alias.span),
        None => name.span,
    };
    let here = |pair: &(Name, Option<Name>)| pair.1.as_ref().unwrap_or(&pair.0).span == place.span;
    let at = names.iter().position(here)?;
    let removed = if names.len() == 1 {
        lines(place, statement)?
    } else if let Some(next) = names.get(at + 1) {
        Span { end: whole(next).start, ..whole(&names[at]) }
    } else {
        Span { start: whole(&names[at - 1]).end, ..whole(&names[at]) }
    };
    // A comment within the list may be about what is removed, or not.
    if names.len() > 1 && place.text_of(removed).contains("//") {
        return None;
    }
    fix(format!("remove `{}`", place.text_of(place.span)), vec![edit(removed, "")])
}

/// The lines of a statement, with its line end; with one of two blank lines around it. None where something else stands on them, or
/// is about them.
fn lines(place: &Place<'_>, statement: &Statement) -> Option<Span> {
    let text = place.text;
    let (from, to) = (statement.span.start as usize, statement.span.end as usize);
    let start = text[..from].rfind('\n').map_or(0, |end| end + 1);
    let end = text[to..].find('\n').map_or(text.len(), |end| to + end + 1);
    let alone = text[start..from].trim().is_empty() && text[to..end].trim().is_empty();
    if !alone || !statement.doc.is_empty() {
        return None;
    }
    let before = text[..start].lines().next_back().unwrap_or_default();
    if before.trim_start().starts_with("//") {
        return None;
    }
    let next = text[end..].find('\n').map_or(text.len(), |line| end + line + 1);
    let blank_behind = next > end && text[end..next].trim().is_empty();
    let end = if before.trim().is_empty() && blank_behind { next } else { end };
    Some(place.range(start, end))
}
