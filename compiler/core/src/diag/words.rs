//! The words by which output says what became of a scene: these, and no others.

/// A word with its meaning, in the order of the reference.
pub const WORDS: &[(&str, &str)] = &[
    ("exact", "the target has the same thing, with the same numbers"),
    ("converted", "the target has the same thing with other numbers, which follow from a formula"),
    (
        "approximated",
        "the target has no exact equivalent, and the nearest one was written; `ledger.json` and `ltsc explain --target NAME` say by how \
         much images differ",
    ),
    ("not supported", "the target has no equivalent; it was left out (finding `loss-dropped`)"),
    ("dropped", "left out: not supported by the target, or not read from a mesh file"),
    ("baked", "computed before it was written, such as a transform into vertices; the image stays the same"),
    ("allowed", "a finding that the scene, `ltsc.toml` or the command line accepts; it is only counted"),
    ("stale", "a generated file that differs from what would be written now"),
    ("up to date", "a generated file that is what would be written now"),
    ("agree", "images differ by less than the tolerance, and their noise is small enough to prove it"),
    ("differ", "images differ by more than the tolerance, and noise does not explain it"),
    ("undecided", "too noisy to tell; more samples would decide"),
    ("holds", "a renderer does what a convention says"),
];
