//! The grammar, and [`parse`]: pieces of text to statements.

use std::ops::Range;

use pest::Parser;
use pest_derive::Parser;
use rayon::prelude::*;

use crate::diag::{FileId, Finding, Span};

use super::build::Builder;
use super::explain::explain;
use super::split::{Split, split};
use super::{NESTING_LIMIT, Statement, Tree};

#[derive(Parser)]
#[grammar = "../../../grammar/lts.pest"]
pub(super) struct Grammar;

/// The tree of `text`, which is the text of `file`, and what is wrong with it. Broken statements are left out of the
/// tree; each has at least one finding.
pub fn parse(file: FileId, text: &str) -> (Tree, Vec<Finding>) {
    let mut tree = Tree { file, statements: Vec::new() };
    let mut findings = Cut::new(text).read(file, text, &mut |statements| tree.statements.extend(statements));
    findings.sort_by_key(|finding| finding.origin.span());
    (tree, findings)
}

/// How many bytes of text are parsed at a time: enough to keep the threads busy, few enough that the trees stay small.
const BATCH: usize = 256 << 10;

/// A text cut into its top-level statements, none of which has been parsed.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Byte ranges, in order.
    pieces: Vec<Range<usize>>,
    too_deep: Vec<usize>,
}

impl Cut {
    /// Cuts `text`, in one pass over its bytes.
    pub fn new(text: &str) -> Self {
        let Split { pieces, too_deep } = split(text);
        Self { pieces, too_deep }
    }

    /// Parses the statements of `text`, which is the text that was cut, and shows them to `see` in their order, a batch at a
    /// time. A large text is parsed in parallel, the next batch while `see` looks at one: no more than two batches are in
    /// memory. Comes back with what is wrong with the text, in no order.
    pub fn read(&self, file: FileId, text: &str, see: &mut dyn FnMut(Vec<Statement>)) -> Vec<Finding> {
        self.read_by(BATCH, file, text, see)
    }

    fn read_by(&self, size: usize, file: FileId, text: &str, see: &mut dyn FnMut(Vec<Statement>)) -> Vec<Finding> {
        let deep = |at: &usize| {
            Finding::error("nesting-limit", Span::new(file, *at, at + 1), "brackets are nested too deeply")
                .label(format!("level {}", NESTING_LIMIT + 1))
                .note(format!("at most {NESTING_LIMIT} levels are read"))
                .help("give the inner parts names with `let`")
        };
        let mut findings: Vec<Finding> = self.too_deep.iter().map(deep).collect();
        let mut batches = self.batches(size);
        let parse_all = |pieces: &[Range<usize>]| pieces.iter().map(|piece| parse_piece(file, text, piece)).collect();
        let parse_many = |pieces: &[Range<usize>]| {
            pieces.par_iter().with_min_len(32).map(|piece| parse_piece(file, text, piece)).collect()
        };
        let mut show = |parsed: Vec<Parsed>| {
            let mut statements = Vec::new();
            for Parsed { statements: some, findings: found } in parsed {
                statements.extend(some);
                findings.extend(found);
            }
            see(statements);
        };
        let Some(first) = batches.next() else { return findings };
        let mut next = batches.next();
        let mut parsed: Vec<Parsed> = if next.is_none() { parse_all(first) } else { parse_many(first) };
        while let Some(pieces) = next {
            let mut ahead = Vec::new();
            rayon::in_place_scope(|scope| {
                scope.spawn(|_| ahead = parse_many(pieces));
                show(std::mem::take(&mut parsed));
            });
            parsed = ahead;
            next = batches.next();
        }
        show(parsed);
        findings
    }

    /// Runs of pieces that lie within `size` bytes, or of one that is larger.
    fn batches(&self, size: usize) -> impl Iterator<Item = &[Range<usize>]> {
        let mut rest = self.pieces.as_slice();
        std::iter::from_fn(move || {
            let end = rest.first()?.start + size;
            let count = rest.partition_point(|piece| piece.end <= end).max(1);
            let (batch, after) = rest.split_at(count);
            rest = after;
            Some(batch)
        })
    }

    /// The names of values that statements declare, with the range of the name and the end of its statement. They are read
    /// off the first words of the pieces, so that a statement that does not parse has its name too.
    pub fn declared<'t>(&self, text: &'t str) -> impl Iterator<Item = (&'t str, Range<usize>, usize)> {
        self.pieces.iter().filter_map(|piece| {
            let (name, at) = declared(&text[piece.clone()])?;
            let start = piece.start + at;
            Some((name, start..start + name.len(), piece.end))
        })
    }
}

/// The value that the statement `piece` declares, and where its name stands.
fn declared(piece: &str) -> Option<(&str, usize)> {
    let mut rest = piece;
    loop {
        rest = rest.trim_start();
        let Some(comment) = rest.strip_prefix("//") else { break };
        rest = comment.split_once('\n')?.1;
    }
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_')?;
    if !["let", "material", "mesh", "texture", "group", "param"].contains(&&rest[..end]) {
        return None;
    }
    rest = rest[end..].trim_start();
    let name = match rest.strip_prefix('`') {
        Some(quoted) => {
            rest = quoted;
            quoted.split(['`', '\n']).next()?
        }
        None => &rest[..rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len())],
    };
    (!name.is_empty()).then(|| (name, piece.len() - rest.len()))
}

/// The statements of a piece, and what is wrong with it.
#[derive(Default)]
struct Parsed {
    statements: Vec<Statement>,
    findings: Vec<Finding>,
}

fn parse_piece(file: FileId, text: &str, piece: &Range<usize>) -> Parsed {
    let Ok(pairs) = Grammar::parse(Rule::file, &text[piece.clone()]) else {
        // The rule takes any text: what is left is pest's own limit on the depth of its calls.
        let span = Span::new(file, piece.start, piece.end.min(piece.start + 1));
        let finding = Finding::error("nesting-limit", span, "the statement is nested too deeply")
            .label("starts here")
            .help("give the inner parts names with `let`");
        return Parsed { statements: Vec::new(), findings: vec![finding] };
    };
    let mut builder = Builder::new(file, piece.start, text);
    let statements = builder.file(pairs);
    let (junk, mut findings) = builder.finish();
    findings.extend(junk.into_iter().map(|range| explain(file, text, range)));
    Parsed { statements, findings }
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

/// Whether a piece begins with `word`, comments aside.
fn begins(piece: &str, word: &str) -> bool {
    let mut lines = piece.lines().map(str::trim_start);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with("//"));
    let rest = first.and_then(|line| line.strip_prefix(word));
    rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_'))
}

/// The `use` statements of a file, and nothing else of it; broken ones are left out.
pub fn uses(file: FileId, text: &str) -> Tree {
    let pieces = split(text).pieces;
    let pieces = pieces.iter().filter(|piece| begins(&text[(*piece).clone()], "use"));
    Tree { file, statements: pieces.flat_map(|piece| parse_piece(file, text, piece).statements).collect() }
}

fn header_of(file: FileId, text: &str) -> Option<Tree> {
    let pieces = split(text).pieces;
    let piece = pieces.iter().find(|piece| begins(&text[(*piece).clone()], "scene"))?.clone();
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

    /// Statements, good and broken, and brackets that hold several.
    fn many() -> String {
        let deep = format!("let deep = {}1{}\n", "(".repeat(200), ")".repeat(200));
        let mut text = "lts 1\n".to_owned();
        for at in 0..60 {
            text.push_str(&format!(
                "/// Number {at}.\nlet a{at} = {at} + 1 // one\nshape s{at} = ball |> scale({at}) with m\n"
            ));
            match at % 7 {
                0 => text.push_str(&format!("let b{at} = = 3\n")),
                1 => text.push_str("group g { shape x = (1, with m\n    let y = 2 }\n"),
                2 => text.push_str("shpae z = 4\n}\n"),
                3 if at == 24 => text.push_str(&deep),
                _ => text.push_str("if a { let c = \"\u{e9}\" } else { let d = [1, 2] }\n"),
            }
        }
        text
    }

    #[test]
    fn batches_change_nothing() {
        let text = many();
        let (whole, found) = run(&text);
        assert!(whole.statements.len() > 120 && found.len() > 25, "{} {}", whole.statements.len(), found.len());
        for size in [1, 100, 1000, 5000] {
            let (mut statements, mut shows) = (Vec::new(), 0);
            let mut findings = Cut::new(&text).read_by(size, whole.file, &text, &mut |some| {
                statements.extend(some);
                shows += 1;
            });
            findings.sort_by_key(|finding| finding.origin.span());
            assert!(shows > 1);
            assert_eq!((&statements, &findings), (&whole.statements, &found), "batches of {size}");
        }
    }

    #[test]
    fn names_are_read_off_the_first_words() {
        let text = "lts 1\n// let no = 1\n/// let no = 1\nlet a = 1\nmesh `b c` = d\nshape e = f with g\nmaterial = x\n\
                    group h(i: number) { let j = 1 }\nparam k: number = 2\nlet l = = 3";
        let found: Vec<(&str, &str)> =
            Cut::new(text).declared(text).map(|(name, range, end)| (name, &text[range.start..end])).collect();
        let names: Vec<&str> = found.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["a", "b c", "h", "k", "l"]);
        assert!(found.iter().all(|(name, rest)| rest.starts_with(name)));
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
