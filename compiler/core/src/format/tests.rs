//! One form, nothing lost, nothing changed.

use super::*;

fn formatted(text: &str) -> String {
    match format(&mut Sources::default(), "a.lts", text) {
        Ok(made) => made,
        Err(error) => panic!("{error:?} in\n{text}"),
    }
}

#[test]
fn broken_texts_are_refused() {
    let error = format(&mut Sources::default(), "a.lts", "lts 1\nlet a = (1,\n").expect_err("it is broken");
    assert!(matches!(error, FormatError::Malformed(findings) if !findings.is_empty()));
}

#[test]
fn differences_are_seen() {
    let mut sources = Sources::default();
    let file = sources.add("a.lts", "");
    let seen = |before, after| difference(file, before, after);
    assert_eq!(seen("let a = [1, 2,] // x", "let a = [\n1, 2] // x"), None);
    assert!(seen("let a = 1", "let a = 2").is_some_and(|text| text.contains("`1` became `2`")));
    assert!(seen("let a = f(1, -2)", "let a = f(1 - 2)").is_some());
    assert!(seen("let a = 1 // x", "let a = 1").is_some_and(|text| text.contains("comment")));
    assert!(seen("let a = 1", "let a = 1 )").is_some_and(|text| text.contains("parse")));
}

#[test]
fn lone_things_are_short() {
    assert_eq!(formatted(""), "");
    assert_eq!(formatted("\n\n// only a comment  \n\n\n"), "// only a comment\n");
    assert_eq!(formatted("lts   1\r\nlet a=-1 let b=[ ]"), "lts 1\nlet a = -1\nlet b = []\n");
}

mod random {
    //! Random programs with random blanks, line ends, comments and last commas.

    use proptest::prelude::*;

    use super::*;

    type Tokens = Vec<String>;

    fn words(list: &[&str]) -> Tokens {
        list.iter().map(|word| (*word).to_owned()).collect()
    }

    fn join(parts: &[Tokens]) -> Tokens {
        parts.concat()
    }

    /// Items between brackets, parted by commas, perhaps with a last one.
    fn bracket(open: &str, items: Vec<Tokens>, last: bool, close: &str) -> Tokens {
        let mut made = words(&[open]);
        let count = items.len();
        for (at, item) in items.into_iter().enumerate() {
            made.extend(item);
            if at + 1 < count || last {
                made.push(",".to_owned());
            }
        }
        made.push(close.to_owned());
        made
    }

    fn name() -> impl Strategy<Value = String> {
        prop::sample::select(vec!["a", "b2", "_c", "`Wall Paint`", "`mesh`", "a_rather_long_name_of_something"])
            .prop_map(str::to_owned)
    }

    fn leaf() -> impl Strategy<Value = Tokens> {
        prop_oneof![
            prop::sample::select(vec!["1", "0.5", "1e-3", "10_000", "45deg", "0.5rad", "2.50", "true", "false"])
                .prop_map(|text| words(&[text])),
            name().prop_map(|name| vec![name]),
            prop::sample::select(vec!["\"a b\"", "\"// no \\\" comment\""]).prop_map(|text| words(&[text])),
            prop::collection::vec("-?[0-9]{1,4}", 2..5).prop_map(|numbers| {
                let items = numbers.iter().map(|n| n.strip_prefix('-').map_or(words(&[n]), |n| words(&["-", n])));
                bracket("(", items.collect(), false, ")")
            }),
            (prop::collection::vec("[0-9]{1,3}", 0..60), any::<bool>()).prop_map(|(numbers, last)| {
                let last = last && !numbers.is_empty();
                bracket("[", numbers.into_iter().map(|number| vec![number]).collect(), last, "]")
            }),
        ]
    }

    fn expr() -> impl Strategy<Value = Tokens> {
        leaf().prop_recursive(4, 40, 4, |inner| {
            let operators = vec!["+", "-", "*", "/", "==", "<", "<=", "and", "or", ".."];
            let items = prop::collection::vec(inner.clone(), 0..4);
            prop_oneof![
                (inner.clone(), prop::sample::select(operators), inner.clone()).prop_map(|(a, o, b)| join(&[
                    words(&["("]),
                    a,
                    words(&[o]),
                    b,
                    words(&[")"])
                ])),
                (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| join(&[
                    a,
                    words(&["+"]),
                    b,
                    words(&["*"]),
                    c
                ])),
                (prop::sample::select(vec!["-", "not"]), inner.clone()).prop_map(|(o, a)| join(&[words(&[o]), a])),
                (name(), items.clone(), any::<bool>(), any::<bool>()).prop_map(|(name, items, last, labels)| {
                    let last = last && !items.is_empty();
                    let label = |item: Tokens| if labels { join(&[words(&["of", ":"]), item]) } else { item };
                    join(&[vec![name], bracket("(", items.into_iter().map(label).collect(), last, ")")])
                }),
                (items.clone(), any::<bool>()).prop_map(|(items, last)| {
                    let last = last && !items.is_empty();
                    bracket("[", items, last, "]")
                }),
                (name(), name(), inner.clone()).prop_map(|(i, list, body)| join(&[
                    words(&["[", "for", &i, "in", &list, ":"]),
                    body,
                    words(&["]"])
                ])),
                (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| {
                    join(&[words(&["(", "if"]), a, words(&["then"]), b, words(&["else"]), c, words(&[")"])])
                }),
                (name(), inner.clone()).prop_map(|(a, i)| join(&[vec![a], words(&["["]), i, words(&["]", ".", "x"])])),
                (inner.clone(), name(), inner.clone(), name()).prop_map(|(a, f, b, g)| {
                    join(&[words(&["("]), a, words(&["|>", &f, "("]), b, words(&[")", "|>", &g, "(", ")", ")"])])
                }),
            ]
        })
    }

    fn statement() -> impl Strategy<Value = Tokens> {
        let kinds = vec!["let", "material", "mesh", "shape", "emitter", "instance", "camera"];
        let plain = prop_oneof![
            (prop::sample::select(kinds), name(), expr(), prop::option::of(expr())).prop_map(
                |(kind, name, value, with)| {
                    let with = with.map_or(Vec::new(), |with| join(&[words(&["with"]), with]));
                    join(&[words(&[kind, &name, "="]), value, with])
                }
            ),
            (name(), expr(), name(), expr(), name(), expr()).prop_map(|(name, base, f, a, g, with)| {
                let stages = join(&[words(&["|>", &f, "("]), a, words(&[")", "|>", &g, "(", ")", "with"])]);
                join(&[words(&["shape", &name, "="]), base, stages, with])
            }),
            (name(), name(), expr()).prop_map(|(name, param, value)| {
                join(&[words(&["let", &name, "(", &param, ":", "number", "=", "1", ")", "="]), value])
            }),
            (name(), expr(), expr()).prop_map(|(name, value, range)| {
                join(&[words(&["param", &name, ":", "[", "number", "]", "="]), value, words(&["in"]), range])
            }),
            Just(words(&["allow", "smooth-emitter", "\"a reason\""])),
            (name(), name()).prop_map(|(a, b)| words(&["use", &a, "as", &b, ",", &a, "from", "\"lib/x.lts\""])),
            (expr(), expr()).prop_map(|(a, b)| {
                join(&[words(&["scene", "s", "{", "paths", ":"]), a, words(&[",", "similar", ":"]), b, words(&["}"])])
            }),
            Just(words(&["lts", "1"])),
        ];
        plain.prop_recursive(3, 12, 3, |inner| {
            let body = prop::collection::vec(inner, 0..3)
                .prop_map(|body| join(&[words(&["{"]), body.concat(), words(&["}"])]));
            prop_oneof![
                (name(), body.clone()).prop_map(|(name, body)| join(&[words(&["group", &name]), body])),
                (name(), expr(), body.clone()).prop_map(|(name, value, body)| {
                    join(&[
                        words(&["group", &name, "(", "p", ":", "number", "=", "("]),
                        value,
                        words(&[")", ")"]),
                        body,
                    ])
                }),
                (name(), expr(), body.clone()).prop_map(|(i, list, body)| join(&[
                    words(&["for", &i, "in"]),
                    list,
                    body
                ])),
                (expr(), body.clone(), body.clone()).prop_map(|(condition, body, other)| {
                    join(&[words(&["if"]), condition, body, words(&["else"]), other])
                }),
            ]
        })
    }

    /// The tokens with something between them, chosen by the numbers.
    fn scattered(tokens: &[String], choices: &[u8]) -> String {
        let mut text = String::new();
        for (at, token) in tokens.iter().enumerate() {
            text.push_str(token);
            // Rows of plain numbers, which are one token of the grammar, hold no comment.
            match choices[at % choices.len()] {
                0 => text.push_str(&format!(" // note {at}\n")),
                1 => text.push_str(&format!("\n// line {at}\n  // and {at}\n")),
                2 => text.push_str(&format!("\n\n\n//// far {at}\n\n")),
                3..8 => text.push('\n'),
                8 => text.push_str("\r\n\r\n"),
                9 => text.push('\t'),
                _ => text.push(' '),
            }
        }
        text
    }

    proptest! {
        #[test]
        fn programs_have_one_form_and_lose_nothing(
            statements in prop::collection::vec(statement(), 1..4),
            choices in prop::collection::vec(0..200_u8, 1..80),
            dense in any::<bool>(),
        ) {
            let choices: Vec<u8> = if dense { choices.iter().map(|choice| choice % 20).collect() } else { choices };
            let text = scattered(&statements.concat(), &choices);
            // The safety net compares tokens and comments.
            let once = match format(&mut Sources::default(), "a.lts", &text) {
                Ok(once) => once,
                // Random operators do not always parse: chained comparisons, ranges of ranges.
                Err(FormatError::Malformed(findings)) => {
                    prop_assert!(!findings.is_empty());
                    return Ok(());
                }
                Err(FormatError::Fault(fault)) => return Err(TestCaseError::fail(format!("{fault}\n{text}"))),
            };
            prop_assert_eq!(&formatted(&once), &once, "{}", text);
            for line in once.lines() {
                prop_assert!(line.trim_end() == line && !line.contains('\t'), "{:?}", line);
            }
        }
    }
}
