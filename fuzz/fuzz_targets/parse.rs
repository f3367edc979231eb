//! Any text gives a tree and findings whose places lie in it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::diag::Sources;
use ltsc_core::syntax::parse;

fuzz_target!(|text: &str| {
    let file = Sources::default().add("fuzz.lts", text);
    let (_tree, findings) = parse(file, text);
    for finding in findings {
        let span = finding.origin.span().expect("syntax findings have a place");
        assert!(span.start <= span.end && span.end as usize <= text.len());
        assert!(text.is_char_boundary(span.start as usize) && text.is_char_boundary(span.end as usize));
    }
});
