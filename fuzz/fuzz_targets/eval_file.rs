//! Any text is an evaluation file, or gives findings whose places lie in it; any text is a configuration of lteval, which becomes
//! TOML. The first byte chooses.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::diag::{Severity, Sources};
use ltsc_evaluation::file::{Unknown, load, lteval, print, read};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let file = Sources::default().add("fuzz.toml", text);
    let findings = if first % 2 == 0 {
        let (evaluation, findings) = load(file, text, "fuzz", &Unknown);
        let errors = findings.iter().any(|finding| finding.severity == Severity::Error);
        assert!(evaluation.is_none() == errors, "an evaluation or a reason");
        if !errors {
            // What is well-formed is printed and read back without a finding of the reader.
            let printed = print(&read(file, text).0);
            let (_, again) = read(Sources::default().add("again.toml", printed.as_str()), &printed);
            assert!(again.is_empty(), "{again:?}");
        }
        findings
    } else {
        let (written, findings) = lteval::read(file, text);
        let printed = print(&written);
        let (_, again) = load(Sources::default().add("again.toml", printed.as_str()), &printed, "fuzz", &Unknown);
        assert!(again.iter().all(|finding| finding.id != "evaluation-syntax"), "{again:?}");
        findings
    };
    for finding in findings {
        let span = finding.origin.span().expect("a place");
        assert!(text.get(span.start as usize..span.end as usize).is_some(), "the place lies in the text");
    }
});
