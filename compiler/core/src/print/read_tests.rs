//! What tests of this folder share: a scene that is written and read again.

use super::{Printed, difference};
use crate::diag::{Severity, Sources};
use crate::eval::{Overrides, evaluate};
use crate::files::{MemoryFiles, VPath};
use crate::ir::{Bsdf, Color, Scene};

/// The scene that a text means, with all its files in memory.
pub(super) fn read(printed: &Printed<'_>) -> Scene {
    let mut files = MemoryFiles::default();
    for (path, content) in &printed.files {
        files.insert(path.clone(), content.bytes());
    }
    files.insert(printed.file(), printed.text.clone());
    evaluated(&files, &printed.file())
}

/// The scene at a path.
pub(super) fn evaluated(files: &MemoryFiles, path: &str) -> Scene {
    let path = VPath::resolve("", path).expect("a path");
    let mut sources = Sources::default();
    let evaluated = evaluate(files, &mut sources, &path, &Overrides::default());
    let text = files_text(files, &path);
    let bad: Vec<_> = evaluated.findings.iter().filter(|finding| finding.severity >= Severity::Warn).collect();
    assert!(bad.is_empty(), "{bad:#?}\n{text}");
    evaluated.scene.unwrap_or_else(|| panic!("no scene in\n{text}"))
}

fn files_text(files: &MemoryFiles, path: &VPath) -> String {
    let bytes = crate::files::Files::read(files, path, u64::MAX).expect("it is there");
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn differences_are_seen() {
    let mut files = MemoryFiles::default();
    files.insert("a.lts", super::tests::BALL);
    let one = evaluated(&files, "a.lts");
    assert_eq!(difference(&one, &one.clone()), None);
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut other = one.clone();
        change(&mut other);
        difference(&one, &other).expect("they differ")
    };
    let first = one.shapes.iter().next().expect("a shape").0;
    assert!(changed(&|scene| scene.name.push('x')).starts_with("name"));
    assert!(changed(&|scene| scene.film.width += 1).starts_with("film"));
    assert!(changed(&|scene| scene.shapes[first].transform.rows[0][3] += 1e-9).contains("transform"));
    assert!(
        changed(&|scene| scene
            .materials
            .iter_mut()
            .for_each(|(_, made)| made.bsdf = Bsdf::Mirror { reflectance: Color::Grey(0.5) }))
        .contains("surface")
    );
}
