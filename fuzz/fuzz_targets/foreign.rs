//! Any text gives a reading with findings, and never a panic. The first byte chooses the target; the text is the main file, and
//! what it includes or names, too.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::files::{Bytes, Files, ReadError, VPath};
use ltsc_core::formats::TARGETS;
use ltsc_core::formats::shared::source::Source;

/// Every file has the same bytes.
struct Same(Bytes);

impl Files for Same {
    fn read(&self, _: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let size = self.0.len() as u64;
        if size > limit { Err(ReadError::TooLarge { size, limit }) } else { Ok(self.0.clone()) }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let target = &TARGETS[usize::from(*first) % TARGETS.len()];
    let files = Same(Bytes::new(bytes.to_vec()));
    let mut source = Source::new(&files);
    let main = VPath::resolve("folder", &target.main_file_of("scene")).expect("a path");
    let Some(import) = target.import else { return };
    let reading = import(&main, &mut source);
    for item in &reading.items {
        let known = match item {
            ltsc_core::formats::shared::reading::Item::Shape(one) => one.mesh < reading.meshes.len(),
            ltsc_core::formats::shared::reading::Item::Instance { group, .. } => *group < reading.groups.len(),
        };
        assert!(known, "what is named is there");
    }
    assert!(source.finish().len() <= 102, "findings come to an end");
});
