//! An evaluation as the text of its file: deterministic, and read back as the same.

use std::fmt::Write as _;
use std::time::Duration;

use ltsc_core::ir::Filter;

use super::model::{At, Budget, Parameter, Reference, Settings, Source, Value};
use super::written::{Against, Overriding, Parameters, Written, WrittenOutput, WrittenScene};

/// How long a line may be before a list is broken.
const WIDTH: usize = 110;

/// The text of a file.
#[must_use]
pub fn print(written: &Written) -> String {
    let mut text = String::new();
    let Written {
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
    } = written;
    let mut line = |key: &str, value: Option<String>| {
        if let Some(value) = value {
            let _written = writeln!(text, "{key} = {value}");
        }
    };
    line("name", name.as_ref().map(|name| string(&name.value)));
    line("description", description.as_ref().map(|text| string(&text.value)));
    line("output", self::output(output));
    line("scenes", scenes.as_ref().map(|scenes| list("scenes", scenes.value.iter().map(scene).collect())));
    line("reference", reference.as_ref().map(|reference| self::reference(&reference.value)));
    overriding_lines(all, &mut line);
    for renderer in renderers {
        let _written = writeln!(text, "\n[renderers.{}]", key(&renderer.name.value));
        let mut line = |key: &str, value: Option<String>| {
            if let Some(value) = value {
                let _written = writeln!(text, "{key} = {value}");
            }
        };
        line("target", renderer.target.as_ref().map(|target| string(&target.value)));
        line("path", renderer.path.as_ref().map(|path| string(&path.value)));
        line("options", (!renderer.options.is_empty()).then(|| strings("options", &renderer.options)));
        line("command", renderer.command.as_ref().map(|words| strings("command", &words.value)));
        line("threads", renderer.threads.map(|threads| threads.value.to_string()));
        line("timeout", renderer.timeout.map(|timeout| time(timeout.value)));
        line("manual", renderer.manual.then(|| "true".to_owned()));
    }
    for (name, parameters) in sets {
        let _written = writeln!(text, "\n[parameters.{}]", key(&name.value));
        set(parameters, &mut text);
    }
    for case in cases {
        text.push_str("\n[[case]]\n");
        let mut line = |key: &str, value: Option<String>| {
            if let Some(value) = value {
                let _written = writeln!(text, "{key} = {value}");
            }
        };
        line("name", Some(string(&case.name.value)));
        line("description", case.description.as_ref().map(|text| string(&text.value)));
        match case.renderers.as_slice() {
            [one] => line("renderer", Some(string(&one.value))),
            several => line("renderers", Some(names("renderers", several))),
        }
        line("scenes", case.scenes.as_ref().map(|scenes| names("scenes", scenes)));
        line("reference", case.reference.as_ref().map(|reference| self::reference(&reference.value)));
        line("parameters", inherited(&case.all.parameters));
        overriding_lines(&case.all, &mut line);
        if inherited(&case.all.parameters).is_none() && has(&case.all.parameters) {
            text.push_str("\n[case.parameters]\n");
            set(&case.all.parameters, &mut text);
        }
        for (name, over) in &case.one {
            let header = format!("case.for.{}", key(&name.value));
            let _written = writeln!(text, "\n[{header}]");
            let mut line = |key: &str, value: Option<String>| {
                if let Some(value) = value {
                    let _written = writeln!(text, "{key} = {value}");
                }
            };
            line("parameters", inherited(&over.parameters));
            overriding_lines(over, &mut line);
            if inherited(&over.parameters).is_none() && has(&over.parameters) {
                let _written = writeln!(text, "\n[{header}.parameters]");
                set(&over.parameters, &mut text);
            }
        }
    }
    for sweep in sweeps {
        let _written = writeln!(text, "\n[[sweep]]\nparameter = {}", string(&sweep.parameter.value));
        if let Some(scenes) = &sweep.scenes {
            let _written = writeln!(text, "scenes = {}", names("scenes", scenes));
        }
        let values = sweep.values.iter().map(|value| expression(value)).collect();
        let _written = writeln!(text, "values = {}", list("values", values));
    }
    for exclude in excludes {
        text.push_str("\n[[exclude]]\n");
        for (key, given) in [("scenes", &exclude.scenes), ("cases", &exclude.cases), ("renderers", &exclude.renderers)]
        {
            if let Some(given) = given {
                let _written = writeln!(text, "{key} = {}", names(key, given));
            }
        }
    }
    if *compare != super::written::WrittenCompare::default() {
        text.push_str("\n[compare]\n");
        let word =
            |against: Against| Against::WORDS.iter().find(|(_, known)| *known == against).map(|(word, _)| string(word));
        let mut line = |key: &str, value: Option<String>| {
            if let Some(value) = value {
                let _written = writeln!(text, "{key} = {value}");
            }
        };
        line("against", compare.against.and_then(|against| word(against.value)));
        let pair = |At { value: (a, b), .. }: &At<(String, String)>| format!("[{}, {}]", string(a), string(b));
        line("pairs", (!compare.pairs.is_empty()).then(|| list("pairs", compare.pairs.iter().map(pair).collect())));
        line("tolerance", compare.tolerance.map(|share| float(share.value)));
        line("mean_tolerance", compare.mean_tolerance.map(|share| float(share.value)));
        line("tiles", compare.tiles.map(|tiles| tiles.value.to_string()));
    }
    text
}

fn overriding_lines(over: &Overriding, line: &mut dyn FnMut(&str, Option<String>)) {
    line("settings", settings(&over.settings));
    line("budget", budget(&over.budget));
    line("chunks", over.chunks.map(|chunks| chunks.value.to_string()));
}

/// A string in quotes.
pub(super) fn string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            '\t' => quoted.push_str("\\t"),
            letter if letter.is_control() => {
                let _written = write!(quoted, "\\u{:04X}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

/// A key, in quotes where it needs them.
pub(super) fn key(text: &str) -> String {
    let plain =
        !text.is_empty() && text.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-'));
    if plain { text.to_owned() } else { string(text) }
}

fn float(value: f64) -> String {
    format!("{value:?}")
}

/// A list in one line, or, where that is too long, with a line for each element.
fn list(key: &str, elements: Vec<String>) -> String {
    let line = format!("[{}]", elements.join(", "));
    if key.len() + 3 + line.chars().count() <= WIDTH {
        return line;
    }
    let mut text = String::from("[\n");
    for element in elements {
        let _written = writeln!(text, "    {element},");
    }
    text.push(']');
    text
}

fn strings(key: &str, words: &[String]) -> String {
    list(key, words.iter().map(|word| string(word)).collect())
}

fn names(key: &str, names: &[At<String>]) -> String {
    list(key, names.iter().map(|name| string(&name.value)).collect())
}

/// A table in one line; none where it has nothing.
fn inline(entries: &[(&str, Option<String>)]) -> Option<String> {
    let entries: Vec<String> =
        entries.iter().filter_map(|(key, value)| value.as_ref().map(|value| format!("{key} = {value}"))).collect();
    (!entries.is_empty()).then(|| format!("{{ {} }}", entries.join(", ")))
}

fn output(output: &WrittenOutput) -> Option<String> {
    let WrittenOutput { folder, dated, page, display } = output;
    let switch = |value: &Option<bool>| value.map(|value| value.to_string());
    inline(&[
        ("folder", folder.as_ref().map(|folder| string(&folder.value))),
        ("dated", switch(dated)),
        ("page", switch(page)),
        ("display", switch(display)),
    ])
}

fn scene(scene: &WrittenScene) -> String {
    let WrittenScene { source, name, set, camera, reference } = scene;
    let (Source::Name(text) | Source::File(text)) = &source.value;
    if name.is_none() && set.is_empty() && camera.is_none() && reference.is_none() {
        return string(text);
    }
    let values: Vec<String> =
        set.iter().map(|(parameter, value)| format!("{} = {}", key(&parameter.value), expression(value))).collect();
    let entries = [
        ("scene", Some(string(text))),
        ("name", name.as_ref().map(|name| string(&name.value))),
        ("set", (!values.is_empty()).then(|| format!("{{ {} }}", values.join(", ")))),
        ("camera", camera.as_ref().map(|camera| string(&camera.value))),
        ("reference", reference.as_ref().map(|reference| self::reference(&reference.value))),
    ];
    inline(&entries).unwrap_or_default()
}

/// The value of a scene's parameter: a number where it is one, else its expression.
fn expression(text: &str) -> String {
    let number = text.parse::<i64>().is_ok_and(|number| number.to_string() == text);
    let float = || text.contains('.') && text.parse::<f64>().is_ok_and(|number| format!("{number}") == text);
    if number || float() { text.to_owned() } else { string(text) }
}

fn reference(reference: &Reference) -> String {
    match reference {
        Reference::Nothing => string("nothing"),
        Reference::Convention => string("convention"),
        Reference::File(file) => format!("{{ file = {} }}", string(file)),
        Reference::Case { case, renderer } => {
            let entries = [("case", Some(string(case))), ("renderer", renderer.as_ref().map(|name| string(name)))];
            inline(&entries).unwrap_or_default()
        }
    }
}

fn settings(settings: &Settings) -> Option<String> {
    let Settings { integrator, max_depth, samples, sampler, filter, size, seed } = settings;
    let count = |count: &Option<At<u32>>| count.map(|count| count.value.to_string());
    let filter = filter.as_ref().map(|filter| match filter.value {
        Filter::Box { radius: 0.5 } => string("box"),
        Filter::Box { radius } => format!("{{ type = \"box\", radius = {} }}", float(radius)),
        Filter::Gaussian { stddev, radius } => {
            format!("{{ type = \"gaussian\", stddev = {}, radius = {} }}", float(stddev), float(radius))
        }
    });
    inline(&[
        ("integrator", integrator.map(|integrator| string(integrator.value))),
        ("max_depth", count(max_depth)),
        ("samples", count(samples)),
        ("sampler", sampler.map(|sampler| string(sampler.value))),
        ("filter", filter),
        ("size", size.map(|size| format!("[{}, {}]", size.value.0, size.value.1))),
        ("seed", count(seed)),
    ])
}

fn budget(budget: &Budget) -> Option<String> {
    let Budget { time: most, samples } = budget;
    inline(&[
        ("time", most.map(|most| time(most.value))),
        ("samples", samples.map(|samples| samples.value.to_string())),
    ])
}

/// Seconds.
fn time(time: Duration) -> String {
    if time.subsec_nanos() == 0 {
        return time.as_secs().to_string();
    }
    float(time.as_secs_f64())
}

/// Whether there are parameters at all.
fn has(parameters: &Parameters) -> bool {
    !parameters.base.is_empty() || !parameters.statements.is_empty()
}

/// Parameters that are names of sets alone.
fn inherited(parameters: &Parameters) -> Option<String> {
    let Parameters { base, statements } = parameters;
    match base.as_slice() {
        [] => None,
        _ if !statements.is_empty() => None,
        [one] => Some(string(&one.value)),
        several => Some(names("parameters", several)),
    }
}

fn set(parameters: &Parameters, text: &mut String) {
    let Parameters { base, statements } = parameters;
    if !base.is_empty() {
        let _written = writeln!(text, "base = {}", names("base", base));
    }
    for (name, parameters) in statements {
        let key = key(&name.value);
        let _written = writeln!(text, "{key} = {}", statement(&key, parameters));
    }
}

/// Whether a parameter needs no type in a table.
fn is_plain(parameter: &Parameter) -> bool {
    match &parameter.kind {
        None => parameter.name != "type",
        Some(kind) => kind.is_empty() && parameter.name == "type",
    }
}

fn entry(parameter: &Parameter) -> String {
    format!("{} = {}", key(&parameter.name), value(&parameter.value))
}

/// A table where that says everything, else a list of triples and tables.
fn statement(name: &str, parameters: &[Parameter]) -> String {
    let twice = |at: usize| parameters[..at].iter().any(|other| other.name == parameters[at].name);
    if !(0..parameters.len()).any(twice) && parameters.iter().all(is_plain) && !parameters.is_empty() {
        let entries: Vec<String> = parameters.iter().map(entry).collect();
        return format!("{{ {} }}", entries.join(", "));
    }
    let element = |parameter: &Parameter| match &parameter.kind {
        Some(kind) => format!("[{}, {}, {}]", string(&parameter.name), string(kind), value(&parameter.value)),
        None => format!("{{ {} }}", entry(parameter)),
    };
    list(name, parameters.iter().map(element).collect())
}

fn value(given: &Value) -> String {
    match given {
        Value::Bool(value) => value.to_string(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => float(*value),
        Value::String(text) => string(text),
        Value::List(values) => format!("[{}]", values.iter().map(value).collect::<Vec<_>>().join(", ")),
    }
}
