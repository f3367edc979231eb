//! The grammar, and [`parse`]: pieces of text to statements.

use pest::Parser;
use pest_derive::Parser;

use crate::diag::{FileId, Finding, Span};

use super::build::Builder;
use super::explain::explain;
use super::split::split;
use super::{NESTING_LIMIT, Tree};

#[derive(Parser)]
#[grammar = "../../../grammar/lts.pest"]
pub(super) struct Grammar;

/// The tree of `text`, which is the text of `file`, and what is wrong with it. Broken statements are left out of the
/// tree; each has at least one finding.
pub fn parse(file: FileId, text: &str) -> (Tree, Vec<Finding>) {
    let mut tree = Tree { file, statements: Vec::new() };
    let mut findings = Vec::new();
    let pieces = split(text);
    for at in pieces.too_deep {
        findings.push(
            Finding::error("nesting-limit", Span::new(file, at, at + 1), "brackets are nested too deeply")
                .label(format!("level {}", NESTING_LIMIT + 1))
                .note(format!("at most {NESTING_LIMIT} levels are read"))
                .help("give the inner parts names with `let`"),
        );
    }
    for piece in pieces.pieces {
        let part = &text[piece.clone()];
        match Grammar::parse(Rule::file, part) {
            Ok(pairs) => {
                let mut builder = Builder::new(file, piece.start, text);
                tree.statements.extend(builder.file(pairs));
                let (junk, found) = builder.finish();
                findings.extend(found);
                findings.extend(junk.into_iter().map(|range| explain(file, text, range)));
            }
            // The rule takes any text: what is left is pest's own limit on the depth of its calls.
            Err(_) => findings.push(
                Finding::error(
                    "nesting-limit",
                    Span::new(file, piece.start, piece.end.min(piece.start + 1)),
                    "the statement is nested too deeply",
                )
                .label("starts here")
                .help("give the inner parts names with `let`"),
            ),
        }
    }
    findings.sort_by_key(|finding| finding.origin.span());
    (tree, findings)
}

/// How much of a text is looked at first for its `scene` statement: it stands at the top by custom.
const TOP: usize = 1 << 16;

/// The tree of a scene file with nothing but its `scene` statement; none for a library, or where the statement is broken.
pub fn header(file: FileId, text: &str) -> Option<Tree> {
    let cut = (0..=TOP.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let top = &text[..cut];
    // A statement that is cut at the end of the top does not parse, and is found in the whole text.
    header_of(file, top).or_else(|| (top.len() < text.len()).then(|| header_of(file, text)).flatten())
}

fn header_of(file: FileId, text: &str) -> Option<Tree> {
    let is_header = |piece: &&std::ops::Range<usize>| {
        let mut lines = text[(*piece).clone()].lines().map(str::trim_start);
        let first = lines.find(|line| !line.is_empty() && !line.starts_with("//"));
        let rest = first.and_then(|line| line.strip_prefix("scene"));
        rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_'))
    };
    let pieces = split(text).pieces;
    let piece = pieces.iter().find(is_header)?.clone();
    let pairs = Grammar::parse(Rule::file, &text[piece.clone()]).ok()?;
    let mut builder = Builder::new(file, piece.start, text);
    let statements = builder.file(pairs);
    let (junk, found) = builder.finish();
    let whole = junk.is_empty() && found.is_empty() && statements.len() == 1;
    whole.then_some(Tree { file, statements })
}

#[cfg(test)]
mod tests {
    use super::super::{ExprKind, StatementKind};
    use super::*;
    use crate::diag::Sources;
    use proptest::prelude::*;

    fn run(text: &str) -> (Tree, Vec<Finding>) {
        parse(Sources::default().add("a.lts", ""), text)
    }

    fn messages(text: &str) -> Vec<String> {
        run(text).1.into_iter().map(|finding| finding.message).collect()
    }

    #[test]
    fn the_header_is_found_alone() {
        let file = || Sources::default().add("a.lts", "");
        let name = |text: &str| {
            header(file(), text).map(|tree| match &tree.statements[..] {
                [super::super::Statement { kind: StatementKind::Scene { name, .. }, doc, .. }] => {
                    (name.text.clone(), doc.clone())
                }
                other => panic!("{other:?}"),
            })
        };
        let text = "lts 1\n// x\n/// A.\n///\n/// B.\nscene a {\n paths: [\"LDE\"]\n}\nlet a = (\n";
        assert_eq!(name(text), Some(("a".to_owned(), "A.\n\nB.".to_owned())));
        assert_eq!(name("lts 1\nlet scenery = 1\n"), None);
        assert_eq!(name("lts 1\nscene a { paths: [ }\n"), None);
        let far = format!("lts 1\n{}scene far {{}}\n", "let a = \"\u{e9}\"\n".repeat(9000));
        assert_eq!(name(&far), Some(("far".to_owned(), String::new())));
    }

    #[test]
    fn precedence_is_that_of_the_language() {
        let shape = |text: &str| {
            let (tree, findings) = run(text);
            assert_eq!(findings, [], "{text}");
            let StatementKind::Declaration { value, .. } = tree.statements.into_iter().next().unwrap().kind else {
                panic!("{text}")
            };
            show(&value)
        };
        assert_eq!(shape("let a = 1 + 2 * 3 - 4"), "((1+(2*3))-4)");
        assert_eq!(shape("let a = -x.y[0] * 2"), "((-x.y[0])*2)");
        assert_eq!(shape("let a = not a and b or c == d"), "(((not a)and b)or(c==d))");
        assert_eq!(shape("let a = -1..2 + 3"), "((-1)..(2+3))");
        assert_eq!(shape("let a = b |> f(1) |> g()"), "g(f(b,1))");
        assert_eq!(shape("let a = if b then 1 else 2 + 3"), "(if b 1 (2+3))");
        assert_eq!(shape("let a = (1, -2, 3)"), "row[1.0, -2.0, 3.0]");
    }

    fn show(e: &super::super::Expr) -> String {
        match &e.kind {
            ExprKind::Number(n) => n.to_string(),
            ExprKind::Name(n) => n.clone(),
            ExprKind::Row(r) => format!("row{r:?}"),
            ExprKind::Binary(op, _, pair) => {
                let gap =
                    if op.sign().starts_with(|c: char| c.is_alphabetic()) && op.sign() == "and" { " " } else { "" };
                format!("({}{}{gap}{})", show(&pair.0), op.sign(), show(&pair.1))
            }
            ExprKind::Unary(super::super::Unary::Minus, x) => format!("(-{})", show(x)),
            ExprKind::Unary(super::super::Unary::Not, x) => format!("(not {})", show(x)),
            ExprKind::Index(pair) => format!("{}[{}]", show(&pair.0), show(&pair.1)),
            ExprKind::Member(x, name) => format!("{}.{}", show(x), name.text),
            ExprKind::If(three) => format!("(if {} {} {})", show(&three.0), show(&three.1), show(&three.2)),
            ExprKind::Call(call) => {
                let args: Vec<String> =
                    call.piped.iter().map(show).chain(call.args.iter().map(|arg| show(&arg.value))).collect();
                format!("{}({})", call.name.text, args.join(","))
            }
            ExprKind::Unit(..)
            | ExprKind::String(_)
            | ExprKind::Bool(_)
            | ExprKind::Tuple(_)
            | ExprKind::List(_)
            | ExprKind::Comprehension(..) => format!("{e:?}"),
        }
    }

    #[test]
    fn one_broken_statement_hides_no_other() {
        let text =
            "lts 1\nlet a = = 3\nlet b = 2\nshape s = (1, with m\nlet c = 3\nshpae d = 4\nlet e = 5\n}\nlet f = 6\n";
        let (tree, findings) = run(text);
        assert_eq!(tree.statements.len(), 5, "lts, b, c, e, f: {tree:#?} {findings:#?}");
        assert_eq!(findings.len(), 4, "{findings:#?}");
    }

    #[test]
    fn the_commonest_mistakes_have_their_own_words() {
        for (text, words) in [
            ("let film = 3", "`film` is a reserved word"),
            ("let a = .5", "a number needs a digit before the point"),
            ("let a = 20 deg", "the unit must touch the number"),
            ("let a = 1;", "statements end without `;`"),
            ("/* x */ let a = 1", "block comments"),
            ("let a = f(1 2)", "a comma is missing"),
            ("let a == 1", "`==` compares"),
            ("let a = 2 ^ 3", "no operator `^`"),
            ("let a = f(1", "is not closed"),
            ("let a = \"x", "the string is not closed"),
            ("shpae a = box(size: 1)", "no statement starts with `shpae`"),
            ("let a = 'x'", "strings stand in"),
        ] {
            let found = messages(text);
            assert!(found.iter().any(|message| message.contains(words)), "{text}: {found:?}");
        }
    }

    #[test]
    fn documentation_is_kept() {
        let (tree, findings) = run("/// One.\r\n///\r\n///   Two.\nlet a = 1 // no doc\n//// no doc\nlet b = 2");
        assert_eq!(findings, []);
        assert_eq!(tree.statements[0].doc, "One.\n\n  Two.");
        assert_eq!(tree.statements[1].doc, "");
    }

    #[test]
    fn long_chains_end_in_a_finding() {
        let chain = format!("let a = {} 1", "if a then b else ".repeat(20_000));
        assert!(run(&chain).1.iter().any(|finding| finding.id == "nesting-limit"));
        let signs = format!("let a = {}1", "-".repeat(100_000));
        assert!(run(&signs).1.iter().any(|finding| finding.id == "nesting-limit"));
        let sum = format!("let a = 1{}", " + 1".repeat(10_000));
        assert!(run(&sum).1.iter().any(|finding| finding.id == "nesting-limit"));
        let (_, findings) = run(&"(".repeat(10_000_000));
        assert_eq!(findings.len(), 1);
    }

    proptest! {
        #[test]
        fn any_text_is_parsed(text in "\\PC*") {
            run(&text);
        }

        #[test]
        fn anything_made_of_tokens_is_parsed(tokens in prop::collection::vec(prop::sample::select(vec![
            "let", "shape", "group", "a", "b", "=", "==", "(", ")", "[", "]", "{", "}", ",", ":", "..", ".", "|>", "+", "-",
            "if", "then", "else", "for", "in", "with", "1", "2.5", "45deg", "\"s\"", "\n", "//x\n", "///y\n", "use", "from", "`q`",
        ]), 0..60)) {
            run(&tokens.join(" "));
        }
    }
}
