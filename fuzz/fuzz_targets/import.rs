//! Any file of another program gives a scene or a reason, within its limits; the scene is sound, and lint and lowering take it. The
//! first byte chooses the format; what the file includes or names has the same bytes, or is a mesh.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::diag::{Severity, Sources};
use ltsc_core::eval::Limits;
use ltsc_core::files::{Bytes, Files, ReadError, VPath};
use ltsc_core::import::{IMPORTERS, Options, import};
use ltsc_core::pipeline::prepare;

const TRIANGLE: &[u8] =
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement \
    face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

struct Around(Bytes);

impl Files for Around {
    fn read(&self, path: &VPath, limit: u64) -> Result<Bytes, ReadError> {
        let bytes = if path.extension() == "ply" { Bytes::new(TRIANGLE.to_vec()) } else { self.0.clone() };
        let size = bytes.len() as u64;
        if size > limit { Err(ReadError::TooLarge { size, limit }) } else { Ok(bytes) }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let importer = &IMPORTERS[usize::from(*first) % IMPORTERS.len()];
    let files = Around(Bytes::new(bytes.to_vec()));
    let path = VPath::resolve(
        "folder",
        &format!("main.{}", importer.endings[usize::from(*first) / 128 % importer.endings.len()]),
    )
    .expect("a path");
    let limits = Limits { steps: 100_000, triangles: 100_000, instances: 1_000, ..Limits::default() };
    let options = Options { limits, ..Options::default() };
    let imported = import(importer, &files, &mut Sources::default(), &path, &options);
    let Some(scene) = imported.scene else {
        assert!(imported.findings.iter().any(|finding| finding.severity == Severity::Error), "no scene and no reason");
        return;
    };
    if let Err(findings) = prepare(scene) {
        // What is left of a scene may be nothing.
        let wrong =
            findings.iter().find(|one| one.severity == Severity::Error && !one.message.contains("has no shape"));
        assert!(wrong.is_none(), "{wrong:?}");
    }
});
