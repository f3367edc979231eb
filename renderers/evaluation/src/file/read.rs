//! The text of an evaluation file as what it says: keys and their types, and nothing about names.

use ltsc_core::diag::{FileId, Finding};

use super::model::{At, Reference, Source};
use super::parts;
use super::reader::{Item, Reader, Table, near};
use super::statement;
use super::sweep;
use super::written::{
    Against, Exclude, Overriding, Parameters, Written, WrittenCase, WrittenCompare, WrittenOutput, WrittenRenderer,
    WrittenScene,
};
use crate::command::split;
use crate::compare::verdict::GRIDS;

/// The placeholders of reference files.
pub const IN_REFERENCES: &[&str] = &["scene", "condition", "case", "renderer", "target"];

/// Reads what a text says.
#[must_use]
pub fn read(file: FileId, text: &str) -> (Written, Vec<Finding>) {
    let reader = &mut Reader::new(file);
    let document = reader.parse(text);
    let mut table = reader.whole(&document);
    let name = table.take("name").and_then(|item| item.word(reader));
    let description = table.take("description").and_then(|item| item.string(reader));
    let output = table.take("output").map(|item| output(&item, reader)).unwrap_or_default();
    let scenes = match table.take("scenes") {
        Some(item) => scenes(&item, reader),
        None => {
            reader.error("evaluation-missing", table.span, "the file has no `scenes`").help =
                Some("write for example `scenes = [\"cbox_classic\"]`".to_owned());
            None
        }
    };
    let sweeps = tables(table.take("sweep"), "[[sweep]]", reader);
    let sweeps = sweeps.into_iter().filter_map(|(_, table)| sweep::read(table, reader)).collect();
    let renderers = renderers(table.take("renderers"), reader);
    let sets = sets(table.take("parameters"), reader);
    let item = table.take("case");
    if item.is_none() {
        reader.error("evaluation-missing", table.span, "the file has no `[[case]]`").help =
            Some("write `[[case]]` with `name` and `renderer`".to_owned());
    }
    let cases = tables(item, "[[case]]", reader);
    let cases = cases.into_iter().filter_map(|(_, table)| case(table, reader)).collect();
    let excludes = tables(table.take("exclude"), "[[exclude]]", reader);
    let excludes = excludes.into_iter().filter_map(|(_, table)| exclude(table, reader)).collect();
    let reference = table.take("reference").and_then(|item| reference(&item, reader));
    let compare = table.take("compare").map(|item| compare(&item, reader)).unwrap_or_default();
    let all = Overriding {
        parameters: Parameters::default(),
        settings: table.take("settings").map(|item| parts::settings(&item, reader)).unwrap_or_default(),
        budget: table.take("budget").map(|item| parts::budget(&item, reader)).unwrap_or_default(),
        chunks: table.take("chunks").and_then(|item| item.count(reader, 1..=4096)),
    };
    table.finish(reader);
    let written = Written {
        name,
        description,
        output,
        scenes,
        sweeps,
        all,
        renderers,
        sets,
        cases,
        excludes,
        reference,
        compare,
    };
    (written, std::mem::take(&mut reader.findings))
}

/// The tables of a list of tables, each with its item.
fn tables<'t>(item: Option<Item<'t>>, name: &str, reader: &mut Reader) -> Vec<(Item<'t>, Table<'t>)> {
    let Some(item) = item else { return Vec::new() };
    let Some(list) = item.as_list(reader) else {
        reader.mismatch(&item, "a list of tables");
        if let Some(found) = reader.findings.last_mut() {
            found.help = Some(format!("write `{name}`, with two brackets"));
        }
        return Vec::new();
    };
    if list.is_empty() {
        reader.error("evaluation-value", item.span, format!("the list `{}` is empty", item.name));
    }
    list.into_iter().filter_map(|item| item.table(reader, name).map(|table| (item, table))).collect()
}

fn output(item: &Item<'_>, reader: &mut Reader) -> WrittenOutput {
    let Some(mut table) = item.table(reader, "`output`") else { return WrittenOutput::default() };
    let folder = table.take("folder").and_then(|item| item.word(reader));
    let mut switch = |key: &'static str| table.take(key).and_then(|item| item.bool(reader));
    let (dated, page, display) = (switch("dated"), switch("page"), switch("display"));
    table.finish(reader);
    WrittenOutput { folder, dated, page, display }
}

/// Where a scene is, by its text.
fn source(text: String) -> Source {
    let file = text.contains(['/', '\\']) || text.ends_with(".lts");
    if file { Source::File(text) } else { Source::Name(text) }
}

fn scenes(item: &Item<'_>, reader: &mut Reader) -> Option<At<Vec<WrittenScene>>> {
    let list = item.list(reader)?;
    if list.is_empty() {
        reader.error("evaluation-value", item.span, "the list `scenes` is empty");
    }
    let found = list.into_iter().filter_map(|item| scene(&item, reader)).collect();
    Some(At::new(found, item.span))
}

fn scene(item: &Item<'_>, reader: &mut Reader) -> Option<WrittenScene> {
    let plain = |text: At<String>| At::new(source(text.value), text.span);
    if item.as_str().is_some() {
        let source = plain(item.word(reader)?);
        return Some(WrittenScene { source, name: None, set: Vec::new(), camera: None, reference: None });
    }
    let Some(mut table) = item.as_table(reader, "a scene") else {
        reader.mismatch(item, "names of scenes, or tables with `scene`");
        return None;
    };
    let source = table.take("scene").map(|item| item.word(reader).map(plain));
    let name = table.take("name").and_then(|item| item.word(reader));
    let set = table.take("set").map(|item| set(&item, reader)).unwrap_or_default();
    let camera = table.take("camera").and_then(|item| item.word(reader));
    let reference = table.take("reference").and_then(|item| self::reference(&item, reader));
    table.finish(reader);
    if source.is_none() {
        reader.error("evaluation-missing", item.span, "a scene has no `scene`");
    }
    Some(WrittenScene { source: source??, name, set, camera, reference })
}

fn set(item: &Item<'_>, reader: &mut Reader) -> Vec<(At<String>, String)> {
    let Some(mut table) = item.table(reader, "`set`") else { return Vec::new() };
    let rest = table.rest();
    rest.into_iter()
        .filter_map(|(key, item)| Some((At::new(key.value.to_owned(), key.span), sweep::expression(&item, reader)?)))
        .collect()
}

fn renderers(item: Option<Item<'_>>, reader: &mut Reader) -> Vec<WrittenRenderer> {
    let Some(mut table) = item.and_then(|item| item.table(reader, "`renderers`")) else { return Vec::new() };
    let mut found = Vec::new();
    for (name, item) in table.rest() {
        let Some(mut table) = item.table(reader, &format!("[renderers.{}]", name.value)) else { continue };
        let target = table.take("target").and_then(|item| item.word(reader));
        let path = table.take("path").and_then(|item| item.word(reader));
        let options = table.take("options").and_then(|item| command_line(&item, reader)).unwrap_or_default();
        let command = table.take("command").and_then(|item| Some(At::new(command_line(&item, reader)?, item.span)));
        let threads = table.take("threads").and_then(|item| item.count(reader, 1..=1024));
        let timeout = table.take("timeout").and_then(|item| parts::time(&item, reader));
        let manual = table.take("manual").and_then(|item| item.bool(reader)).unwrap_or(false);
        table.finish(reader);
        let name = At::new(name.value.to_owned(), name.span);
        found.push(WrittenRenderer { name, target, path, options, command, threads, timeout, manual });
    }
    found
}

/// Words in a list, or in a string as a shell splits it.
fn command_line(item: &Item<'_>, reader: &mut Reader) -> Option<Vec<String>> {
    let problem = "contains a NUL character";
    let checked = |words: Vec<String>, reader: &mut Reader| {
        if words.iter().any(|word| word.contains('\0')) {
            reader.error("evaluation-value", item.span, format!("`{}` {problem}", item.name));
            return None;
        }
        Some(words)
    };
    if let Some(line) = item.as_str() {
        return match split(line) {
            Ok(words) => checked(words, reader),
            Err(problem) => {
                reader.error("evaluation-value", item.span, format!("`{}`: {problem}", item.name));
                None
            }
        };
    }
    let Some(list) = item.as_list(reader) else {
        reader.mismatch(item, "a string or a list of strings");
        return None;
    };
    let words = list.iter().filter_map(|word| word.string(reader)).map(|word| word.value).collect();
    checked(words, reader)
}

fn sets(item: Option<Item<'_>>, reader: &mut Reader) -> Vec<(At<String>, Parameters)> {
    let Some(mut table) = item.and_then(|item| item.table(reader, "`parameters`")) else { return Vec::new() };
    let mut found = Vec::new();
    for (name, item) in table.rest() {
        let Some(table) = item.table(reader, &format!("[parameters.{}]", name.value)) else { continue };
        found.push((At::new(name.value.to_owned(), name.span), statement::parameters(table, reader)));
    }
    found
}

/// What a case, or a case for one renderer, says beside names.
fn overriding(table: &mut Table<'_>, reader: &mut Reader) -> Overriding {
    let parameters = table.take("parameters").map(|item| {
        if let Some(table) = item.as_table(reader, "`parameters`") {
            return statement::parameters(table, reader);
        }
        if item.as_str().is_none() && item.as_list(reader).is_none() {
            reader.mismatch(&item, "names of parameter sets, or a table of statements");
            return Parameters::default();
        }
        Parameters { base: item.words(reader), statements: Vec::new() }
    });
    Overriding {
        parameters: parameters.unwrap_or_default(),
        settings: table.take("settings").map(|item| parts::settings(&item, reader)).unwrap_or_default(),
        budget: table.take("budget").map(|item| parts::budget(&item, reader)).unwrap_or_default(),
        chunks: table.take("chunks").and_then(|item| item.count(reader, 1..=4096)),
    }
}

fn case(mut table: Table<'_>, reader: &mut Reader) -> Option<WrittenCase> {
    let span = table.span;
    let name = table.take("name").map(|item| item.word(reader));
    let description = table.take("description").and_then(|item| item.string(reader));
    let one = table.take("renderer");
    let several = table.take("renderers");
    if let (Some(first), Some(second)) = (&one, &several) {
        reader.error("evaluation-key", second.key, "a case has `renderer` or `renderers`, not both").labels =
            vec![ltsc_core::diag::Label { span: first.key, text: "the other one".to_owned() }];
    }
    let given = one.is_some() || several.is_some();
    let renderers: Vec<At<String>> = one.into_iter().chain(several).flat_map(|item| item.words(reader)).collect();
    let scenes = table.take("scenes").map(|item| item.words(reader));
    let all = overriding(&mut table, reader);
    let mut each = Vec::new();
    if let Some(mut table) = table.take("for").and_then(|item| item.table(reader, "`for`")) {
        for (name, item) in table.rest() {
            let Some(mut table) = item.table(reader, &format!("`for.{}`", name.value)) else { continue };
            let over = overriding(&mut table, reader);
            table.finish(reader);
            each.push((At::new(name.value.to_owned(), name.span), over));
        }
    }
    let reference = table.take("reference").and_then(|item| reference(&item, reader));
    table.finish(reader);
    if name.is_none() {
        reader.error("evaluation-missing", span, "a case has no `name`");
    }
    let name = name.flatten();
    if !given {
        let called = name.as_ref().map_or_else(|| "a case".to_owned(), |name| format!("the case `{}`", name.value));
        let place = name.as_ref().map_or(span, |name| name.span);
        reader.error("evaluation-missing", place, format!("{called} has no renderer")).help =
            Some("write `renderer = \"NAME\"` or `renderers = [\"NAME\", ...]`".to_owned());
    }
    Some(WrittenCase { name: name?, description, renderers, scenes, all, one: each, reference, span })
}

fn exclude(mut table: Table<'_>, reader: &mut Reader) -> Option<Exclude> {
    let span = table.span;
    let mut names = |key: &'static str| table.take(key).map(|item| item.words(reader));
    let (scenes, cases, renderers) = (names("scenes"), names("cases"), names("renderers"));
    table.finish(reader);
    if scenes.is_none() && cases.is_none() && renderers.is_none() {
        reader.error("evaluation-missing", span, "`[[exclude]]` names nothing and would exclude everything").help =
            Some("name `scenes`, `cases` or `renderers`; what is left out stands for all".to_owned());
        return None;
    }
    Some(Exclude { scenes, cases, renderers, span })
}

/// A reference: a word, a file, or a table.
fn reference(item: &Item<'_>, reader: &mut Reader) -> Option<At<Reference>> {
    if item.as_str().is_some() {
        let text = item.word(reader)?;
        let reference = match text.value.as_str() {
            "nothing" => Reference::Nothing,
            "convention" => Reference::Convention,
            file if file.contains(['/', '.', '{']) => reference_file(text, reader)?,
            _ => {
                let message = format!("`reference` takes `convention`, `nothing` or a file, not `{}`", text.value);
                reader.error("evaluation-value", item.span, message).help =
                    Some("another case is `reference = { case = \"NAME\" }`".to_owned());
                return None;
            }
        };
        return Some(At::new(reference, item.span));
    }
    let Some(mut table) = item.as_table(reader, "`reference`") else {
        reader.mismatch(item, "`convention`, `nothing`, a file, or a table with `case` or `file`");
        return None;
    };
    let case = table.take("case").and_then(|item| item.word(reader));
    let renderer = table.take("renderer").and_then(|item| item.word(reader));
    let file = table.take("file").and_then(|item| item.word(reader));
    table.finish(reader);
    let reference = match (case, file) {
        (Some(case), None) => Reference::Case { case: case.value, renderer: renderer.map(|name| name.value) },
        (None, Some(file)) => reference_file(file, reader)?,
        _ => {
            reader.error("evaluation-missing", item.span, "a reference is either a `case` or a `file`");
            return None;
        }
    };
    Some(At::new(reference, item.span))
}

fn reference_file(file: At<String>, reader: &mut Reader) -> Option<Reference> {
    let mut rest = file.value.as_str();
    while let Some((_, after)) = rest.split_once('{') {
        let name = after.split('}').next().unwrap_or_default();
        if !IN_REFERENCES.contains(&name) {
            let message = format!("there is no placeholder `{{{name}}}` in the names of references");
            reader.error("evaluation-value", file.span, message).help = near(name, IN_REFERENCES.iter().copied());
            return None;
        }
        rest = after;
    }
    Some(Reference::File(file.value))
}

fn compare(item: &Item<'_>, reader: &mut Reader) -> WrittenCompare {
    let Some(mut table) = item.table(reader, "`compare`") else { return WrittenCompare::default() };
    let against = table.take("against").and_then(|item| {
        let word = item.word(reader)?;
        let found = Against::WORDS.iter().find(|(known, _)| *known == word.value);
        if found.is_none() {
            let message = format!("`against` is not `{}`", word.value);
            reader.error("evaluation-value", word.span, message).help =
                near(&word.value, Against::WORDS.iter().map(|(known, _)| *known));
        }
        found.map(|(_, against)| At::new(*against, word.span))
    });
    let pairs = table.take("pairs").and_then(|item| item.list(reader)).unwrap_or_default();
    let pairs = pairs.iter().filter_map(|pair| {
        let sides = pair.list(reader)?;
        let [a, b] = sides.as_slice() else {
            let message = format!("a pair has two sides, not {}", sides.len());
            reader.error("evaluation-value", pair.span, message);
            return None;
        };
        Some(At::new((a.word(reader)?.value, b.word(reader)?.value), pair.span))
    });
    let pairs: Vec<_> = pairs.collect();
    let tolerance = table.take("tolerance").and_then(|item| parts::share(&item, reader));
    let mean_tolerance = table.take("mean_tolerance").and_then(|item| parts::share(&item, reader));
    let tiles = table.take("tiles").and_then(|item| {
        let span = item.span;
        let tiles = item.count(reader, 1..=256)?;
        if !GRIDS.contains(&(tiles.value as usize)) {
            let message = format!("{} tiles along each side are not among those of a verdict", tiles.value);
            reader.error("evaluation-value", span, message).help = Some(
                "take 8, 4, 2 or 1: larger tiles have less noise, and tell less of where images differ".to_owned(),
            );
            return None;
        }
        Some(tiles)
    });
    table.finish(reader);
    WrittenCompare { against, pairs, tolerance, mean_tolerance, tiles }
}
