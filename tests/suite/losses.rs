//! What mesh files say and is not read: in lint, emit and build, for people and programs, and in the ledger.

use std::fs;
use std::path::Path;

use super::{Ran, ltsc, run};

const SCENE: &str = "lts 1\n/// A file that says more than is read of it.\n///\n/// Something to look at.\n\
    scene painted { paths: [\"LDE\"] }\ncamera = perspective(eye: (0, -5, 1), target: (0, 0, 0), fov_x: 45deg)\n\
    film = image(16, 16)\nintegrator = path(max_depth: 3)\nsampler = independent(samples: 4)\n\
    group g = file(\"painted.obj\")\ninstance g = g\nshape s = file(\"painted.obj\") |> faceted() with diffuse(0.5)\n\
    emitter sky = environment(radiance: 1)\n";

/// A square with a color at each corner, and a line.
const OBJECT: &str =
    "mtllib painted.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 0 1 0 0 1\nv 0 0 1 1 1 1\nusemtl a\nf 1 2 3 4\nl 1 3\n";

const LIBRARY: &str = "newmtl a\nKd 0.4 0.1 0.1 # brown\nKs spectral shiny.rfl\nd 0.5\n";

fn project() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in
        [("ltsc.toml", "scenes = \".\"\n"), ("painted.lts", SCENE), ("painted.obj", OBJECT), ("painted.mtl", LIBRARY)]
    {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

fn told(folder: &Path, args: &[&str]) -> Ran {
    run(ltsc().current_dir(folder).args(args))
}

const COLORS: &str = "`painted.obj`, line 2: 4 vertex colors not read";
const SPECTRUM: &str =
    "`painted.obj`, `painted.mtl`, line 3: 1 value of `Ks` not read, since they are curves of spectra (`spectral`)";
const LINES: &str = "`painted.obj`, line 8: points and lines are not read";
const CUT: &str = "`painted.obj`: 1 face with more than 3 corners cut into triangles";

#[test]
fn losses_of_reading_reach_everybody() {
    let folder = project();
    let folder = folder.path();
    // People see what may be seen in an image, programs all.
    for args in [&["lint", "--format", "short"][..], &["build", "--target", "gltf", "--format", "short", "-o", "a"]] {
        let ran = told(folder, args);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        let said = ran.out + &ran.err;
        for message in [COLORS, SPECTRUM] {
            // The file is read as a mesh and as a group, and has one finding.
            assert_eq!(said.matches(message).count(), 1, "{args:?}: {said}");
        }
        assert!(!said.contains(LINES), "{said}");
    }
    let ran = told(folder, &["lint", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let findings = json["findings"].as_array().expect("a list");
    for (id, message, severity) in [
        ("loss-dropped", COLORS, "warn"),
        ("loss-dropped", SPECTRUM, "warn"),
        ("loss-dropped", LINES, "info"),
        ("loss-baked", CUT, "info"),
    ] {
        let mut same = findings.iter().filter(|one| one["message"] == message);
        let one = same.next().unwrap_or_else(|| panic!("no `{message}` in {}", ran.out));
        assert_eq!((one["id"].as_str(), one["severity"].as_str()), (Some(id), Some(severity)), "{message}");
        assert!(same.next().is_none(), "{message} twice");
    }
    // The ledger has them beside the losses of the target.
    let ran = told(folder, &["emit", "painted.lts", "--target", "pbrt-v4", "-o", "out"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains("4 vertex colors not read"), "{}", ran.err);
    for ledger in ["out/ledger.json", "a/painted/gltf/ledger.json"] {
        let text = fs::read_to_string(folder.join(ledger)).expect("a ledger");
        let ledger: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let reading = ledger["reading"].as_array().expect("a list");
        let of = |what: &str| reading.iter().find(|one| one["what"] == what).map(|one| one["loss"].clone());
        for message in [COLORS, SPECTRUM, LINES] {
            assert_eq!(of(message), Some("loss-dropped".into()), "{text}");
        }
        let baked = ledger["baked"].as_array().expect("a list");
        assert!(baked.iter().any(|one| one == CUT), "{text}");
    }
    // Levels hold for them.
    assert_eq!(told(folder, &["lint", "--deny", "loss-dropped"]).code, Some(1));
    let quiet = told(folder, &["lint", "--allow", "loss-dropped"]);
    assert!(!(quiet.out + &quiet.err).contains("vertex colors"));
}
