//! Commands of renderers that have no driver of ours: words with placeholders.

use std::fmt::Write as _;
use std::sync::Arc;

use ltsc_core::diag::nearest;
use ltsc_render::run::Call;

/// The placeholders, each with what takes its place.
pub const PLACEHOLDERS: &[(&str, &str)] = &[
    ("exe", "the executable of `path`, or the one that is found"),
    ("options", "the words of `options`; a word of its own"),
    ("out", "the image to write"),
    ("scene", "the main file of the scene"),
    ("samples", "samples per pixel of a chunk"),
    ("seed", "the seed of a chunk"),
    ("threads", "the number of threads"),
];

/// A command as words with placeholders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// The words.
    pub words: Vec<Vec<Piece>>,
}

/// A piece of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Plain text.
    Text(String),
    /// The name of a placeholder.
    Placeholder(&'static str),
}

impl Command {
    /// Reads the words of a command.
    ///
    /// # Errors
    /// What is wrong, with a help where there is one.
    pub fn new(words: &[String]) -> Result<Self, (String, Option<String>)> {
        if words.is_empty() {
            return Err(("the command is empty".to_owned(), None));
        }
        let words: Vec<Vec<Piece>> = words.iter().map(|word| pieces(word)).collect::<Result<_, _>>()?;
        let has = |name: &str| words.iter().flatten().any(|piece| *piece == Piece::Placeholder(static_name(name)));
        for needed in ["out", "scene"] {
            if !has(needed) {
                let help = "write for example `{exe} {options} -o {out} {scene}`".to_owned();
                return Err((format!("the command has no `{{{needed}}}`"), Some(help)));
            }
        }
        if words.iter().any(|word| word.len() > 1 && word.contains(&Piece::Placeholder(static_name("options")))) {
            return Err(("`{options}` is a word of its own".to_owned(), None));
        }
        Ok(Self { words })
    }

    /// Whether a placeholder is used.
    #[must_use]
    pub fn uses(&self, name: &str) -> bool {
        self.words.iter().flatten().any(|piece| matches!(piece, Piece::Placeholder(used) if *used == name))
    }

    /// The words with what takes the place of the placeholders; `{options}` becomes as many words as there are.
    #[must_use]
    pub fn fill(&self, options: &[String], value: impl Fn(&str) -> String) -> Vec<String> {
        let mut filled = Vec::new();
        for word in &self.words {
            if let [Piece::Placeholder("options")] = word.as_slice() {
                filled.extend(options.iter().cloned());
                continue;
            }
            let mut text = String::new();
            for piece in word {
                match piece {
                    Piece::Text(plain) => text.push_str(plain),
                    Piece::Placeholder(name) => text.push_str(&value(name)),
                }
            }
            filled.push(text);
        }
        filled
    }

    /// How a renderer is called by it.
    #[must_use]
    pub fn call(&self, options: &[String]) -> Call {
        let (command, options) = (self.clone(), options.to_vec());
        Call { seeded: self.uses("seed"), words: Arc::new(move |value| command.fill(&options, value)) }
    }

    /// The words as they are written.
    #[must_use]
    pub fn texts(&self) -> Vec<String> {
        let text = |word: &Vec<Piece>| {
            let mut text = String::new();
            for piece in word {
                match piece {
                    Piece::Text(plain) => text.push_str(&plain.replace('{', "{{").replace('}', "}}")),
                    Piece::Placeholder(name) => {
                        let _written = write!(text, "{{{name}}}");
                    }
                }
            }
            text
        };
        self.words.iter().map(text).collect()
    }
}

/// The name from the table.
fn static_name(name: &str) -> &'static str {
    PLACEHOLDERS.iter().map(|(known, _)| *known).find(|known| *known == name).unwrap_or_default()
}

/// The pieces of a word; `{{` and `}}` are braces.
fn pieces(word: &str) -> Result<Vec<Piece>, (String, Option<String>)> {
    let mut found = Vec::new();
    let mut text = String::new();
    let mut rest = word;
    while let Some(letter) = rest.chars().next() {
        let doubled = rest.starts_with("{{") || rest.starts_with("}}");
        match letter {
            '{' | '}' if doubled => {
                text.push(letter);
                rest = &rest[2..];
            }
            '{' => {
                let Some(end) = rest.find('}') else {
                    return Err((format!("`{word}` has `{{` without `}}`"), None));
                };
                let name = &rest[1..end];
                let known = PLACEHOLDERS.iter().map(|(known, _)| *known);
                let Some(name) = known.clone().find(|known| *known == name) else {
                    let help = nearest(name, known).map(|near| format!("did you mean `{near}`?"));
                    return Err((format!("there is no placeholder `{{{name}}}`"), help));
                };
                if !text.is_empty() {
                    found.push(Piece::Text(std::mem::take(&mut text)));
                }
                found.push(Piece::Placeholder(name));
                rest = &rest[end + 1..];
            }
            '}' => return Err((format!("`{word}` has `}}` without `{{`"), None)),
            _ => {
                text.push(letter);
                rest = &rest[letter.len_utf8()..];
            }
        }
    }
    if !text.is_empty() || found.is_empty() {
        found.push(Piece::Text(text));
    }
    Ok(found)
}

/// The words of a command line, by the rules of a POSIX shell without substitutions: blanks part words, quotes hold them together, `\`
/// takes the meaning from the next letter.
///
/// # Errors
/// A quote that is not closed, or a `\` at the end.
pub fn split(line: &str) -> Result<Vec<String>, &'static str> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match letter {
            '\'' => {
                let word = word.get_or_insert_default();
                loop {
                    match letters.next() {
                        Some('\'') => break,
                        Some(inner) => word.push(inner),
                        None => return Err("a quote is not closed"),
                    }
                }
            }
            '"' => {
                let word = word.get_or_insert_default();
                loop {
                    match letters.next() {
                        Some('"') => break,
                        Some('\\') => match letters.next() {
                            Some(inner @ ('"' | '\\' | '$' | '`')) => word.push(inner),
                            Some(inner) => word.extend(['\\', inner]),
                            None => return Err("a quote is not closed"),
                        },
                        Some(inner) => word.push(inner),
                        None => return Err("a quote is not closed"),
                    }
                }
            }
            '\\' => match letters.next() {
                Some(inner) => word.get_or_insert_default().push(inner),
                None => return Err("a `\\` stands at the end"),
            },
            blank if blank.is_whitespace() => words.extend(word.take()),
            other => word.get_or_insert_default().push(other),
        }
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(words: &[&str]) -> Vec<String> {
        words.iter().map(|word| (*word).to_owned()).collect()
    }

    #[test]
    fn a_command_is_filled_in() {
        let given = split("{exe} {options} --out={out} '{scene}' {{x}}").expect("words");
        let command = Command::new(&given).expect("a command");
        assert_eq!(command.texts(), given);
        let filled = command.fill(&words(&["-m", "a b"]), |name| format!("<{name}>"));
        assert_eq!(filled, ["<exe>", "-m", "a b", "--out=<out>", "<scene>", "{x}"]);
        assert!(command.uses("exe") && !command.uses("seed"));
    }

    #[test]
    fn a_command_that_cannot_be_filled_in_is_refused() {
        let wrong = |line: &str| Command::new(&split(line).expect("words")).expect_err("wrong");
        assert_eq!(wrong("{exe} {scene}").0, "the command has no `{out}`");
        assert_eq!(wrong("{exe} {out} {scene} {sede}").1.as_deref(), Some("did you mean `seed`?"));
        assert_eq!(wrong("-{options} {out} {scene}").0, "`{options}` is a word of its own");
        assert!(wrong("{out} {scene").0.contains("without `}`"));
        assert!(wrong("{out} {scene} }").0.contains("without `{`"));
        assert_eq!(wrong("").0, "the command is empty");
    }

    #[test]
    fn words_are_split_as_a_shell_does() {
        assert_eq!(split(r#" -a  'b c'd "e\"f\g" \ h "" "#), Ok(words(&["-a", "b cd", r#"e"f\g"#, " h", ""])));
        assert_eq!(split("'a"), Err("a quote is not closed"));
        assert_eq!(split("a\\"), Err("a `\\` stands at the end"));
    }
}
