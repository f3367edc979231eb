//! The commonest mistakes of writing, each with what to write instead. What is typed by people who come from other languages
//! counts as such.

use crate::diag::{Finding, Span};

use super::build::clip;
use super::explain::{ends_with_operator, innermost, inside_brackets, last_word, token};
use super::{RESERVED, STARTERS};

/// Statement words of other languages and formats, and ours.
const WORDS: &[(&str, &str)] = &[
    ("import", "use"),
    ("include", "use"),
    ("from", "use"),
    ("def", "let"),
    ("fn", "let"),
    ("func", "let"),
    ("function", "let"),
    ("var", "let"),
    ("const", "let"),
    ("set", "let"),
    ("object", "shape"),
    ("geometry", "shape"),
    ("light", "emitter"),
    ("lamp", "emitter"),
    ("bsdf", "material"),
    ("brdf", "material"),
    ("sensor", "camera"),
    ("while", "for"),
    ("foreach", "for"),
    ("parameter", "param"),
    ("ignore", "allow"),
];

/// Statements of the form `word name = value`.
const NAMED: &[&str] = &["let", "material", "mesh", "texture", "shape", "emitter", "instance"];

/// Statements that need no name.
const SETTINGS: &[&str] = &["camera", "film", "integrator", "sampler"];

/// Our word for a statement word of other languages.
pub(super) fn statement_word(word: &str) -> Option<&'static str> {
    WORDS.iter().find(|(theirs, _)| *theirs == word).map(|(_, ours)| *ours)
}

/// A mistake in the statement `junk` whose text stops making sense at `offset`.
pub(super) fn find(junk: &str, offset: usize, at: &dyn Fn(usize, usize) -> Span) -> Option<Finding> {
    let seen = Seen {
        junk,
        offset,
        first: token(junk),
        before: junk[..offset].trim_end(),
        rest: &junk[offset..],
        word: token(&junk[offset..]),
        at,
    };
    let found = seen
        .operators()
        .or_else(|| seen.brackets(at))
        .or_else(|| seen.numbers())
        .or_else(|| seen.equals(at))
        .or_else(|| seen.words());
    found.map(|found| match found {
        Found::Whole(finding) => *finding,
        Found::Here { length, message, label, help } => {
            let finding = Finding::error("syntax-error", at(offset, length.max(1)), message).help(help);
            if label.is_empty() { finding } else { finding.label(label) }
        }
    })
}

enum Found {
    Whole(Box<Finding>),
    Here { length: usize, message: String, label: &'static str, help: String },
}

fn here(length: usize, message: impl Into<String>, help: impl Into<String>) -> Option<Found> {
    Some(Found::Here { length, message: message.into(), label: "", help: help.into() })
}

/// The statement, the place, and what stands round it.
struct Seen<'t> {
    junk: &'t str,
    offset: usize,
    first: &'t str,
    before: &'t str,
    rest: &'t str,
    word: &'t str,
    at: &'t dyn Fn(usize, usize) -> Span,
}

impl Seen<'_> {
    /// Operators of other languages.
    fn operators(&self) -> Option<Found> {
        let Self { first, before, rest, junk, .. } = *self;
        if rest.starts_with('?') {
            return here(1, "there is no `? :`", "write `if c then a else b`");
        }
        if rest.starts_with("**") || rest.starts_with('*') && before.ends_with('*') {
            return here(1, "there is no `**`", "write `pow(a, b)`");
        }
        let piped = |text: &str| text.trim_end().ends_with("|>");
        if rest.starts_with("with") && piped(before) || before.strip_suffix("with").is_some_and(piped) {
            return here(4, "`with` needs no `|>`", "remove the `|>` before `with`");
        }
        if rest.starts_with('(')
            && let Some((_, method)) = before.rsplit_once('.')
            && !method.is_empty()
            && method.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && before.contains(')')
        {
            return here(1, "there are no methods", format!("write `... |> {method}(...)`"));
        }
        if first == "allow" && !junk.contains('"') {
            let id = junk.split_whitespace().nth(1).unwrap_or("finding");
            let finding = Finding::error(
                "missing-reason",
                (self.at)(0, junk.trim_end().len()),
                format!("`allow {id}` gives no reason"),
            )
            .help(format!("say why the finding is right and yet wanted: `allow {id} \"...\"`"));
            return Some(Found::Whole(Box::new(finding)));
        }
        None
    }

    fn brackets(&self, at: &dyn Fn(usize, usize) -> Span) -> Option<Found> {
        let Self { junk, offset, first, before, rest, .. } = *self;
        let open = innermost(before).map(|place| (place, &junk[place..=place]));
        if let (Some((place, opened)), Some(closing)) = (open, rest.chars().next()) {
            let right = match opened {
                "(" => ')',
                "[" => ']',
                _ => '}',
            };
            if matches!(closing, ')' | ']' | '}') && closing != right {
                let finding =
                    Finding::error("syntax-error", at(offset, 1), format!("`{opened}` is closed by `{closing}`"))
                        .label(format!("expected `{right}`"))
                        .also(at(place, 1), "opened here");
                return Some(Found::Whole(Box::new(finding)));
            }
        }
        if rest.starts_with('{') && first != "if" && holds_word(before, "if") {
            return here(1, "an `if` that gives a value has no braces", "write `if c then a else b`");
        }
        if rest.starts_with('(') && before.ends_with(')') {
            return here(1, "what a call gives cannot be called", "give it a name with `let`, or remove the brackets");
        }
        if rest.starts_with(')') && before.ends_with('(') && last_word(&before[..before.len() - 1]).is_empty() {
            return here(1, "empty brackets are no value", "a vector is written `(x, y, z)`, an empty list `[]`");
        }
        let parameters = matches!(first, "group" | "let" | "material" | "mesh") && !before.contains('=');
        if parameters && rest.starts_with([')', ',']) && before.contains('(') && !last_word(before).is_empty() {
            let name = last_word(before);
            return here(
                1,
                format!("the parameter `{name}` has no type"),
                format!("write for example `{name}: number`"),
            );
        }
        None
    }

    fn numbers(&self) -> Option<Found> {
        let Self { first: _, before, rest, word, .. } = *self;
        let digit = |text: &str| text.ends_with(|c: char| c.is_ascii_digit());
        if rest.starts_with('°') && digit(before) {
            return here(2, "an angle's unit is written in letters", format!("write `{}deg`", last_word(before)));
        }
        if rest.starts_with(',') && digit(before) && !inside_brackets(before) {
            let after: String = rest[1..].trim_start().chars().take_while(char::is_ascii_digit).collect();
            if !after.is_empty() {
                let help = format!("write `{}.{after}`", last_word(before));
                return here(1, "the decimal sign is a point", help);
            }
        }
        if before.ends_with('.') && digit(&before[..before.len() - 1]) && !rest.starts_with('.') {
            let number = last_word(&before[..before.len() - 1]);
            return here(1, "a number needs a digit behind the point", format!("write `{number}.0`"));
        }
        let letters = word.chars().any(|c| c.is_ascii_alphabetic());
        if word.starts_with(|c: char| c.is_ascii_digit()) && letters && STARTERS.contains(&last_word(before)) {
            return here(
                word.len(),
                "a name begins with a letter or `_`",
                format!("write another name, or `` `{}` ``", clip(word)),
            );
        }
        if let Some(tail) = rest.strip_prefix('#') {
            let digits: String = tail.chars().take_while(char::is_ascii_hexdigit).collect();
            return if digits.len() == 6
                && !before.is_empty()
                && (before.ends_with('=') || ends_with_operator(before) || before.ends_with(['(', ',']))
            {
                here(7, "a screen color says that it is one", format!("write `srgb(\"#{digits}\")`"))
            } else {
                here(1, "`#` means nothing", "a comment begins with `//`; a screen color is `srgb(\"#rrggbb\")`")
            };
        }
        None
    }

    fn equals(&self, at: &dyn Fn(usize, usize) -> Span) -> Option<Found> {
        let Self { junk, first, before, rest, .. } = *self;
        if first == "for" && (rest.starts_with(['=', ';', ':']) || holds_word(rest, "range")) {
            return here(
                1,
                "a loop runs over a range or a list",
                "write `for i in 0..3 { ... }`; both ends belong to a range",
            );
        }
        if rest.starts_with("=>") || rest.starts_with("->") || before.ends_with('=') && rest.starts_with('>') {
            return here(1, "there are no functions without a name", "declare `let f(x: number) = ...`, and pass `f`");
        }
        if rest.starts_with('=') && !rest.starts_with("==") && inside_brackets(before) {
            let name = last_word(before);
            if !name.is_empty() {
                return here(1, "a label ends with `:`", format!("write `{name}: ...`"));
            }
        }
        if first == "param" && rest.starts_with('=') && !inside_brackets(before) && !before.contains(':') {
            return here(
                1,
                "a parameter has a type",
                format!("write `{before}: number = ...`, `: angle`, or another type"),
            );
        }
        if rest.starts_with(':') && !inside_brackets(before) && STARTERS.contains(&first) && first != "param" {
            return here(1, "a declaration has a `=`", format!("write `{before} = ...`"));
        }
        let mut words = junk.split_whitespace();
        let (second, third) = (words.nth(1).unwrap_or_default(), words.next().unwrap_or_default());
        let starts = |text: &str| text.starts_with(|c: char| c.is_alphanumeric() || matches!(c, '"' | '[' | '`'));
        let (missing, name) = if SETTINGS.contains(&first) && second.contains('(') && !second.contains('=') {
            (second, String::new())
        } else if NAMED.contains(&first) && starts(second) && starts(third) && !second.contains(['=', '(']) {
            (third, format!(" {second}"))
        } else {
            return None;
        };
        let place = missing.as_ptr() as usize - junk.as_ptr() as usize;
        let value = token(missing);
        let finding = Finding::error("syntax-error", at(place, value.len().max(1)), "a `=` is missing")
            .label("before this")
            .help(format!("write `{first}{name} = {}...`", clip(value)));
        Some(Found::Whole(Box::new(finding)))
    }

    fn words(&self) -> Option<Found> {
        let Self { first, before, rest, word, .. } = *self;
        if word == "else" && first == "if" && !before.contains('{') {
            return here(
                4,
                "the statements of a condition stand in braces",
                "a value is chosen by `if c then a else b`, statements by `if c { ... } else { ... }`",
            );
        }
        let ends_value = before.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | '"' | ')' | ']' | '`'));
        let value =
            rest.starts_with(|c: char| c.is_alphabetic() || matches!(c, '_' | '`')) && !RESERVED.contains(&word);
        let surfaces = matches!(first, "shape" | "emitter") && before.contains('=') && !holds_word(before, "with");
        if surfaces && ends_value && value && !inside_brackets(before) {
            let (what, help) = if first == "shape" {
                ("a `with` is missing before the material", format!("write `with {}`", clip(word)))
            } else {
                ("a `with` is missing before the emission", format!("write `with {}`", clip(word)))
            };
            return Some(Found::Here {
                length: word.len(),
                message: what.to_owned(),
                label: "no operator stands before it",
                help,
            });
        }
        None
    }
}

/// Whether a text holds a word of its own.
fn holds_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).any(|other| other == word)
}
