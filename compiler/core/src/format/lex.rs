//! Text to tokens with their comments; nothing is lost but blanks. The text has been parsed without findings before.

/// A comment, `//` or `///`, without blanks at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Comment<'t> {
    pub text: &'t str,
    /// Whether a blank line stands before it.
    pub blank: bool,
}

/// A token as it is written.
#[derive(Clone, Debug)]
pub(super) struct Token<'t> {
    pub text: &'t str,
    /// Comments on lines of their own before it.
    pub before: Vec<Comment<'t>>,
    /// Comments behind it: the first on its line, others on lines of their own.
    pub after: Vec<Comment<'t>>,
    /// Of a closing bracket: comments that stood behind the last item within.
    pub inside: Vec<Comment<'t>>,
    /// Whether a blank line stands before it, behind the comments before it.
    pub blank: bool,
}

impl<'t> Token<'t> {
    /// A token without comments.
    pub fn bare(text: &'t str) -> Self {
        Self { text, before: Vec::new(), after: Vec::new(), inside: Vec::new(), blank: false }
    }
}

/// Signs of two characters; all others are single.
const PAIRS: [&str; 6] = ["|>", "..", "==", "!=", "<=", ">="];

/// The tokens of a text. The last one is empty and holds the comments at the end.
pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut found: Vec<Token<'_>> = Vec::new();
    let mut before: Vec<Comment<'_>> = Vec::new();
    let mut at = 0;
    // Line ends since the last token or comment.
    let mut lines = 0;
    loop {
        let rest = &text[at..];
        let Some(first) = rest.chars().next() else { break };
        if matches!(first, ' ' | '\t' | '\r' | '\n' | '\u{feff}') {
            lines += usize::from(first == '\n');
            at += first.len_utf8();
            continue;
        }
        if rest.starts_with("//") {
            let end = rest.find('\n').unwrap_or(rest.len());
            let comment = Comment { text: rest[..end].trim_end(), blank: lines > 1 };
            let documents = rest.starts_with("///") && !rest.starts_with("////");
            match found.last_mut() {
                // What documents belongs to what follows, wherever it stands.
                Some(last) if lines == 0 && before.is_empty() && !documents => last.after.push(comment),
                _ => before.push(comment),
            }
            at += end;
            lines = 0;
            continue;
        }
        // A rule's name holds signs that are operators elsewhere.
        let rule = found.last().is_some_and(|token| token.text == "allow");
        let length = length(rest, first, rule);
        let before = std::mem::take(&mut before);
        found.push(Token { before, blank: lines > 1, ..Token::bare(&rest[..length]) });
        at += length;
        lines = 0;
    }
    found.push(Token { before, ..Token::bare("") });
    found
}

/// The length in bytes of the token at the start of `rest`.
fn length(rest: &str, first: char, rule: bool) -> usize {
    let run = |from: usize, inside: fn(char) -> bool| {
        rest[from..].char_indices().find(|(_, c)| !inside(*c)).map_or(rest.len(), |(at, _)| from + at)
    };
    let word: fn(char) -> bool = |c| c.is_ascii_alphanumeric() || c == '_';
    match first {
        '"' => end_of_string(rest),
        '`' => rest[1..].find('`').map_or(rest.len(), |at| at + 2),
        '0'..='9' => {
            let digits: fn(char) -> bool = |c| c.is_ascii_digit() || c == '_';
            let mut end = run(0, digits);
            let fraction =
                rest[end..].strip_prefix('.').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            if fraction {
                end = run(end + 1, digits);
            }
            let exponent =
                rest[end..].strip_prefix(['e', 'E']).map(|rest| rest.strip_prefix(['+', '-']).unwrap_or(rest));
            if let Some(power) = exponent.filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
                end = run(rest.len() - power.len(), |c| c.is_ascii_digit());
            }
            run(end, word)
        }
        c if c.is_ascii_alphabetic() && rule => run(0, |c| c.is_ascii_alphanumeric() || c == '_' || c == '-'),
        c if word(c) => run(0, word),
        c => PAIRS.iter().find(|pair| rest.starts_with(**pair)).map_or(c.len_utf8(), |pair| pair.len()),
    }
}

fn end_of_string(rest: &str) -> usize {
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            '"' if !escaped => return at + 1,
            '\\' => escaped = !escaped,
            _ => escaped = false,
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str) -> Vec<&str> {
        tokens(text).iter().map(|token| token.text).filter(|text| !text.is_empty()).collect()
    }

    #[test]
    fn tokens_are_those_of_the_grammar() {
        assert_eq!(texts("a..b 1..2 0.5..-1e-3"), ["a", "..", "b", "1", "..", "2", "0.5", "..", "-", "1e-3"]);
        assert_eq!(texts("45deg 1_000 2e3rad 3e v.x"), ["45deg", "1_000", "2e3rad", "3e", "v", ".", "x"]);
        assert_eq!(texts("allow smooth-emitter \"a\\\"b\""), ["allow", "smooth-emitter", "\"a\\\"b\""]);
        assert_eq!(texts("a-b|>f(`x y`)<=!="), ["a", "-", "b", "|>", "f", "(", "`x y`", ")", "<=", "!="]);
    }

    #[test]
    fn comments_lie_before_or_behind() {
        let found = tokens("// one\r\n\n// two\na // three\n// four\n\nb /// five\nc");
        let of = |at: usize| {
            let text = |comments: &[Comment<'_>]| comments.iter().map(|c| c.text.to_owned()).collect::<Vec<_>>();
            (text(&found[at].before), text(&found[at].after), found[at].blank)
        };
        assert_eq!(of(0), (vec!["// one".into(), "// two".into()], vec!["// three".into()], false));
        assert_eq!(of(1), (vec!["// four".into()], vec![], true));
        assert_eq!(of(2), (vec!["/// five".into()], vec![], false));
        assert!(found[0].before[1].blank && !found[0].before[0].blank);
    }
}
