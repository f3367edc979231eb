//! Evaluation files with one thing wrong, and what is found where.

use ltsc_core::diag::{Finding, Severity};

use super::tests::{file, told};

/// Each: what stands before the case, what behind, the code, the place, parts of the message and of the help.
type Row = (&'static str, &'static str, &'static str, &'static str, &'static str, &'static str);

const WRONG: &[Row] = &[
    // Keys.
    ("quality = 1", "", "evaluation-key", "quality", "the file has no key `quality`", "known: "),
    ("setings = {}", "", "evaluation-key", "setings", "no key", "did you mean `settings`?"),
    ("", "setting = {}", "evaluation-key", "setting", "[[case]] has no key `setting`", "did you mean `settings`?"),
    ("settings = { sample = 8 }", "", "evaluation-key", "sample", "`settings` has no key", "did you mean `samples`?"),
    (
        "[renderers.x]\ntarget = \"luxcore\"\nexe = 1",
        "[[case]]\nname = \"b\"\nrenderer = \"x\"",
        "evaluation-key",
        "exe",
        "[renderers.x] has no key",
        "",
    ),
    ("", "renderers = [\"luxcore\"]", "evaluation-key", "renderers", "not both", ""),
    // Types.
    ("name = 3", "", "evaluation-type", "3", "`name` takes a string, not an integer", ""),
    ("output = \"x\"", "", "evaluation-type", "\"x\"", "`output` takes a table, not a string", ""),
    ("output = { page = 1 }", "", "evaluation-type", "1", "`page` takes `true` or `false`, not an integer", ""),
    ("chunks = \"8\"", "", "evaluation-type", "\"8\"", "`chunks` takes an integer, not a string", ""),
    ("chunks = 2024-01-01", "", "evaluation-type", "2024-01-01", "not a date", ""),
    (
        "settings = { integrator = { type = \"path\" } }",
        "",
        "evaluation-type",
        "{ type = \"path\" }",
        "takes a string, not a table",
        "native statements stand under `parameters`",
    ),
    (
        "",
        "parameters = { integrator = \"path\" }",
        "evaluation-type",
        "\"path\"",
        "`integrator` takes a table, or a list",
        "{ type = \"path\" }",
    ),
    ("", "parameters = { path.x.y = 1 }", "evaluation-type", "x", "`x` takes a boolean", "quotes"),
    (
        "sweep = { parameter = \"lamp\" }",
        "",
        "evaluation-type",
        "{ parameter = \"lamp\" }",
        "a list of tables",
        "[[sweep]]",
    ),
    // Values.
    ("chunks = 0", "", "evaluation-value", "0", "from 1 to 4096", ""),
    (
        "chunks = 8",
        "settings = { samples = 4 }",
        "evaluation-value",
        "4",
        "4 samples per pixel cannot be divided among 8 chunks",
        "fewer `chunks`",
    ),
    ("settings = { samples = 16 }", "budget = { samples = 8 }", "evaluation-value", "8", "smaller than the 16", ""),
    ("settings = { size = [1, 2, 3] }", "", "evaluation-value", "[1, 2, 3]", "not 3 numbers", ""),
    ("budget = { time = \"5 days\" }", "", "evaluation-value", "\"5 days\"", "a time above 0", "1.5min"),
    ("compare = { tolerance = 5 }", "", "evaluation-value", "5", "a share below 1", "5 %"),
    (
        "compare = { against = \"frist\" }",
        "",
        "evaluation-value",
        "\"frist\"",
        "`against` is not `frist`",
        "did you mean `first`?",
    ),
    ("compare = { pairs = [[\"a\"]] }", "", "evaluation-value", "[\"a\"]", "two sides", ""),
    ("compare = { pairs = [[\"a\", \"a\"]] }", "", "evaluation-value", "[\"a\", \"a\"]", "compared with itself", ""),
    ("", "parameters = { film = { x = [] } }", "evaluation-value", "[]", "the list `x` is empty", ""),
    (
        "",
        "parameters = { film = { x = 99999999999999999999 } }",
        "evaluation-value",
        "99999999999999999999",
        "64 bits",
        "",
    ),
    ("", "parameters = []", "evaluation-value", "[]", "the list `parameters` is empty", ""),
    ("", "scenes = []", "evaluation-value", "[]", "the list `scenes` is empty", ""),
    ("", "[[sweep]]\nparameter = \"lamp\"\nvalues = []", "evaluation-value", "[]", "the list `values` is empty", ""),
    (
        "",
        "[[sweep]]\nparameter = \"lamp\"\nfrom = 0\nto = 1\ncount = 3\nscale = \"log\"",
        "evaluation-value",
        "0\nto = 1",
        "above 0",
        "",
    ),
    ("", "[[sweep]]\nparameter = \"lamp\"\nfrom = 0\nto = 1\nstep = 1e-9", "evaluation-value", "1e-9", "10,000", ""),
    (
        "reference = \"{scne}.exr\"",
        "",
        "evaluation-value",
        "\"{scne}.exr\"",
        "no placeholder `{scne}`",
        "did you mean `scene`?",
    ),
    ("reference = \"bdpt\"", "", "evaluation-value", "\"bdpt\"", "not `bdpt`", "{ case = \"NAME\" }"),
    ("", "[[exclude]]\ncases = [\"a\"]", "evaluation-value", "", "all images are excluded", ""),
    (
        "[renderers.x]\ntarget = \"gltf\"\ncommand = \"y {scene}\"",
        "[[case]]\nname = \"b\"\nrenderer = \"x\"",
        "evaluation-value",
        "\"y {scene}\"",
        "no `{out}`",
        "{exe}",
    ),
    // What is missing.
    ("", "[[case]]\nname = \"b\"", "evaluation-missing", "\"b\"", "the case `b` has no renderer", "renderers ="),
    ("", "[[case]]\nrenderer = \"luxcore\"", "evaluation-missing", "[[case]]", "a case has no `name`", ""),
    ("", "[[sweep]]\nvalues = [1]", "evaluation-missing", "[[sweep]]", "no `parameter`", ""),
    ("", "[[sweep]]\nparameter = \"lamp\"", "evaluation-missing", "[[sweep]]", "neither", "count"),
    ("", "[[exclude]]", "evaluation-missing", "[[exclude]]", "names nothing", ""),
    (
        "compare = { against = \"reference\" }",
        "",
        "evaluation-missing",
        "\"reference\"",
        "nothing has a reference",
        "convention",
    ),
    // Names.
    (
        "",
        "[[case]]\nname = \"b\"\nrenderer = \"mitsuba3x\"",
        "evaluation-name",
        "\"mitsuba3x\"",
        "there is no renderer `mitsuba3x`",
        "did you mean `mitsuba-3`?",
    ),
    (
        "[renderers.x]\ntarget = \"luxcor\"",
        "[[case]]\nname = \"b\"\nrenderer = \"x\"",
        "evaluation-name",
        "\"luxcor\"",
        "no target or renderer `luxcor`",
        "did you mean `luxcore`?",
    ),
    (
        "",
        "[[case]]\nname = \"b\"\nrenderer = \"glb\"",
        "evaluation-name",
        "\"glb\"",
        "no renderer of ltsc reads `glb`",
        "command =",
    ),
    ("", "parameters = \"low\"", "evaluation-name", "\"low\"", "no parameter set `low`", ""),
    (
        "[parameters.low]",
        "parameters = [\"low\", \"lwo\"]",
        "evaluation-name",
        "\"lwo\"",
        "no parameter set `lwo`",
        "did you mean `low`?",
    ),
    ("", "for.luxcore = {}", "evaluation-name", "luxcore", "no renderer of the case `a` called `luxcore`", "mitsuba-3"),
    ("", "scenes = [\"rin\"]", "evaluation-name", "\"rin\"", "no scene `rin`", "did you mean `ring`?"),
    ("", "[[exclude]]\ncases = [\"b\"]", "evaluation-name", "\"b\"", "no case `b`", ""),
    (
        "",
        "[[exclude]]\nrenderers = [\"luxcore\"]\nscenes=[\"ring\"]",
        "evaluation-name",
        "\"luxcore\"",
        "no renderer `luxcore`",
        "",
    ),
    (
        "",
        "[[sweep]]\nparameter = \"lmap\"\nvalues = [1, 2]",
        "evaluation-name",
        "\"lmap\"",
        "no parameter of `ring` called `lmap`",
        "did you mean `lamp`?",
    ),
    ("reference = { case = \"z\" }", "", "evaluation-name", "{ case = \"z\" }", "no case `z`", ""),
    ("compare = { pairs = [[\"a\", \"c\"]] }", "", "evaluation-name", "[\"a\", \"c\"]", "no case `c`", ""),
    // Others.
    (
        "",
        "[[case]]\nname = \"a\"\nrenderer = \"luxcore\"",
        "evaluation-duplicate",
        "\"a\"",
        "there are two cases `a`",
        "",
    ),
    (
        "",
        "[[sweep]]\nparameter = \"lamp\"\nvalues = [1, 1]",
        "evaluation-duplicate",
        "1",
        "the value `1` stands twice",
        "",
    ),
    (
        "",
        "parameters = { film = [[\"type\", \"path\"]] }",
        "evaluation-parameter",
        "[\"type\", \"path\"]",
        "this one has 2 of three",
        "say the type too",
    ),
    (
        "",
        "parameters = { film = [[\"x\", \"float\", 0, 1]] }",
        "evaluation-parameter",
        "[\"x\", \"float\", 0, 1]",
        "this one has 4 of three",
        "a list of their own",
    ),
    (
        "",
        "parameters = { film = [\"x\", \"float\", 0] }",
        "evaluation-parameter",
        "[\"x\", \"float\", 0]",
        "a list of parameters, not one parameter",
        "[[name",
    ),
    (
        "",
        "parameters = { film = [[\"x\", 3, 0]] }",
        "evaluation-parameter",
        "3",
        "the type of a parameter is a string, not an integer",
        "",
    ),
    (
        "[parameters.p]\nbase = \"q\"\n[parameters.q]\nbase = \"p\"",
        "parameters = \"p\"",
        "evaluation-cycle",
        "\"q\"",
        "`p`, `q`, `p`",
        "",
    ),
    (
        "settings = { integrator = \"bdpt\" }",
        "",
        "evaluation-setting",
        "\"bdpt\"",
        "`bdpt` is no neutral integrator",
        "passed through by `parameters`",
    ),
    (
        "settings = { integrator = \"metropolis\" }",
        "",
        "evaluation-setting",
        "\"metropolis\"",
        "`mitsuba-3` has no Metropolis light transport",
        "for.mitsuba-3",
    ),
    ("reference = \"a.png\"", "", "unreadable-file", "\"a.png\"", "no reference `a.png`", ""),
    (
        "settings = { samples = 3 }",
        "",
        "evaluation-chunks",
        "3",
        "3 samples per pixel are too few for a verdict",
        "4 chunks",
    ),
    ("chunks = 2", "", "evaluation-chunks", "2", "2 chunks are too few for a verdict", "at least 4"),
    ("[parameters.low]", "", "evaluation-unused", "low", "the parameter set `low` is not used", ""),
    ("[renderers.x]\ntarget = \"luxcore\"", "", "evaluation-unused", "x", "no case names the renderer `x`", ""),
    (
        "",
        "[[case]]\nname = \"b\"\nrenderer = \"luxcore\"\n[[exclude]]\ncases = [\"a\"]\nrenderers = [\"luxcore\"]",
        "evaluation-unused",
        "[[exclude]]",
        "excludes nothing",
        "",
    ),
];

#[test]
fn everything_that_is_wrong_is_found_at_its_place() {
    let mut otherwise = Vec::new();
    for (before, behind, code, place, message, help) in WRONG {
        let (evaluation, findings) = told(&file(before, behind));
        let as_expected = |(finding, there): &(Finding, String)| {
            finding.id == *code
                && there == place
                && finding.message.contains(message)
                && finding.help.as_deref().unwrap_or_default().contains(help)
                && evaluation.is_some() == (finding.severity < Severity::Error)
        };
        if findings.len() != 1 || !findings.iter().all(as_expected) {
            let told = findings.iter().map(|(own, there)| (own.id, there, &own.message, &own.help));
            otherwise.push(format!("{before} | {behind}: {:?}", told.collect::<Vec<_>>()));
        }
    }
    assert!(otherwise.is_empty(), "{}", otherwise.join("\n"));
}
