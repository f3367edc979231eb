//! Drivers of programs, with programs that only look like PBRT, its ports and Mitsuba 0.x: what they are given, what they
//! write, and how they can fail.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::time::Duration;

use super::super::{
    Driver, Installation, Progress, RenderError, RenderRequest, Rendered, Search, driver, find, render,
};
use crate::env::Env;
use crate::image::{Image, Provenance, write_exr, write_pfm};

/// A folder with an emitted scene, a mesh beside it, and a program.
struct Stage {
    folder: tempfile::TempDir,
    request: RenderRequest,
}

const PBRT: &str = "# a scene\nFilm \"image\" \"integer xresolution\" [2]\nSampler \"random\" \"integer pixelsamples\" [16]\n\
                    Integrator \"path\" \"integer maxdepth\" [5]\n";
const MITSUBA: &str = "<scene><default name=\"samples\" value=\"16\"/></scene>\n";
const SIZE: (usize, usize) = (2, 1);

impl Stage {
    /// The program finds its stage in `$stage` and the value behind an option by `after OPTION "$@"`.
    fn new(name: &str, program: &str, scene: &str, body: &str) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let driver = driver(name).expect("a driver");
        let emitted = folder.path().join("emitted");
        fs::create_dir_all(emitted.join("meshes")).expect("folders");
        fs::write(emitted.join("meshes/floor.ply"), "ply\n").expect("a mesh");
        fs::write(emitted.join(driver.main_file), scene).expect("a scene");
        let path = folder.path().join(program);
        let text = format!(
            "#!/bin/sh\nstage=$(dirname \"$0\")\necho \"$@\" >> \"$stage/calls\"\n\
             after() {{ want=$1; shift; while [ $# -gt 1 ]; do [ \"$1\" = \"$want\" ] && echo \"$2\"; shift; done; }}\n\
             for last; do :; done\n{body}\n"
        );
        fs::write(&path, text).expect("a program");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("mode");
        let mut request = RenderRequest::new(driver, emitted, SIZE, folder.path().join("log"));
        request.executable = Some(path);
        request.timeout = Some(Duration::from_secs(60));
        Self { folder, request }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn render(&self) -> Result<(Rendered, Vec<Progress>), RenderError> {
        let mut news = Vec::new();
        render(&self.request, &mut |progress| news.push(progress)).map(|rendered| (rendered, news))
    }

    fn fails(&self) -> RenderError {
        self.render().map(|(rendered, _)| rendered.samples_done).expect_err("a failure")
    }

    /// The arguments of the last call.
    fn call(&self) -> String {
        let calls = fs::read_to_string(self.path("calls")).expect("calls");
        calls.lines().last().expect("a call").to_owned()
    }

    /// The emitted folder as one text, to see that nothing is written there.
    fn emitted(&self) -> String {
        let mut names: Vec<_> = fs::read_dir(&self.request.folder)
            .expect("a folder")
            .map(|entry| entry.expect("an entry").path())
            .collect();
        names.sort();
        names
            .iter()
            .map(|path| format!("{}\n{}", path.display(), fs::read_to_string(path).unwrap_or_default()))
            .collect()
    }
}

fn picture() -> Image {
    Image { width: 2, height: 1, pixels: vec![[1.0, 2.0, 3.0], [0.5, 0.25, 20.0]] }
}

/// Banners, bars and statistics as the programs write them.
const PBRT3: &str = r#"case "$last" in *nothing.pbrt) echo 'pbrt version 3 (built Nov 26 2026 at 23:51:42) [Detected 2 cores]'; exit 0;; esac
printf 'pbrt version 3\n\rRendering: [    ] \rRendering: [++  ]  (0.3s|0.3s)  '
cp "$stage/image.pfm" "$(after --outfile "$@")"; cp "$last" "$stage/read.pbrt"
printf '\rRendering: [++++]  (0.6s)       \nStatistics:\n'"#;

const PBRT4: &str = r#"case "$*" in
*--help*) echo '  --seed <n>   Set random number generator seed.
  --spp <n>    Override number of pixel samples' >&2; exit 0;;
*nothing.pbrt) echo 'pbrt version 4 (built Jun 10 2026 at 12:00:00)'; echo 'Error: End of files before "WorldBegin"' >&2; exit 1;;
esac
printf 'pbrt version 4\n\rRendering: [++++]  (0.6s)       \n'; cp "$stage/image.exr" "$(after --outfile "$@")""#;

const MITSUBA6: &str = r#"if [ "$1" = -h ]; then
    echo 'Mitsuba version 0.6.0 (Linux, 64 bit), Copyright (c) 2017 Wenzel Jakob'; echo 'Usage: mitsuba'; exit 0; fi
echo "libraries $LD_LIBRARY_PATH"; echo mine > mitsuba.here.log
printf '\rRendering: [++  ] (1.2s, ETA: 1.2s)  \b\b\rRendering: [++++] (2.4s, ETA: 0s)  \b\b\n'
echo '2026-11-26 12:00:00 INFO  ren0 [RenderJob] Render time: 2.4000s'; cp "$stage/image.exr" "$(after -o "$@")""#;

/// A port, which keeps what it reads.
const PORT: &str = r#"if [ "$1" = --version ]; then echo "NAME 4.5.2"; exit 0; fi
echo "NAME version 4.5.2 [Detected 2 cores]"; echo "temporary $TMPDIR"
# As the port does: links are followed, then what is included is looked for.
cd "$(dirname "$(readlink -f "$last")")" && cat scene.pbrt settings.pbrt > "$stage/read.pbrt" 2>/dev/null
cp "$stage/image.exr" "$(after --outfile "$@")""#;

fn port(name: &str, scene: &str) -> Stage {
    let stage = Stage::new(name, name, "Include \"settings.pbrt\"\n", &PORT.replace("NAME", name));
    fs::write(stage.request.folder.join("settings.pbrt"), scene).expect("settings");
    write_exr(&stage.path("image.exr"), &picture(), &Provenance::default()).expect("an image");
    stage
}

#[test]
fn pbrt_r4_is_told_its_seed_in_a_copy_of_the_settings() {
    let mut stage = port("pbrt-r4", PBRT);
    let before = stage.emitted();
    let (rendered, _) = stage.render().expect("an image");
    assert_eq!((&rendered.image, rendered.renderer_version.as_str()), (&picture(), "4.5.2"));
    assert!(fs::read_to_string(stage.path("read.pbrt")).expect("a scene").ends_with(PBRT));
    (stage.request.samples, stage.request.seed, stage.request.threads) = (77, 5, Some(2));
    stage.render().expect("an image");
    assert!(stage.call().starts_with("--nthreads 2 --texture-cache off --spp 77 --outfile "), "{}", stage.call());
    let seeded = "Sampler \"random\" \"integer seed\" [5] \"integer pixelsamples\" [77]";
    let read = fs::read_to_string(stage.path("read.pbrt")).expect("a scene");
    assert!(
        read.contains(seeded) && !read.contains("Option") && !read.contains("maxdepth\" [5] \"integer seed"),
        "{read}"
    );
    assert_eq!(stage.emitted(), before);
    for (kind, wanted) in [
        ("sppm", "Integrator \"sppm\" \"integer seed\" [5]"),
        ("mlt", "Option \"seed\" 5\nIntegrator \"mlt\" \"integer maxdepth\""),
    ] {
        let mut bdpt = port("pbrt-r4", PBRT);
        bdpt.request.features = vec!["bidirectional path tracing".to_owned()];
        let bdpt = bdpt.render().expect("an image").0;
        assert!(bdpt.facts[0].1.contains("bidirectional"), "{:?}", bdpt.facts);
        let mut stage = port("pbrt-r4", &PBRT.replace("\"path\"", &format!("\"{kind}\"")));
        stage.request.seed = 5;
        stage.render().expect("an image");
        let read = fs::read_to_string(stage.path("read.pbrt")).expect("a scene");
        assert!(read.contains(wanted) && read.contains("Sampler \"random\" \"integer seed\" [5]"), "{read}");
    }
    stage.request.seed = u32::MAX;
    assert!(stage.fails().to_string().contains("too large"));
}

#[test]
fn pbrt_r3_tells_its_defects() {
    let mut stage = port("pbrt-r3", PBRT);
    let (rendered, _) = stage.render().expect("an image");
    assert_eq!((rendered.image, rendered.facts.len()), (picture(), 0));
    let log = fs::read_to_string(stage.path("log")).expect("a log");
    assert!(log.contains("temporary ") && !log.contains("temporary /tmp\n"), "{log}");
    stage.request.seed = 3;
    assert!(stage.fails().to_string().contains("no perspective camera"), "{}", stage.fails());
    let mut stage = port("pbrt-r3", PBRT);
    stage.request.features = vec!["a principled material".to_owned()];
    let (rendered, _) = stage.render().expect("an image");
    assert!(rendered.facts[0].0 == "defects" && rendered.facts[0].1.contains("principled"), "{:?}", rendered.facts);
}

#[test]
fn a_port_fails_with_its_own_words() {
    let stage = Stage::new(
        "pbrt-r4",
        "pbrt-r4",
        PBRT,
        &PORT
            .replace("NAME", "pbrt-r4")
            .replace("cp \"$stage/image", "echo '[2026 ERROR] No such file or directory' >&2; exit 255; \""),
    );
    let error = stage.fails();
    assert_eq!(error.to_string(), "`pbrt-r4` failed with exit code 255: [2026 ERROR] No such file or directory");
    assert!(error.hint().contains("a file is missing"), "{}", error.hint());
    let other = Stage::new("pbrt-r4", "pbrt-r4", PBRT, &PORT.replace("NAME", "pbrt-r3"));
    assert!(other.fails().tail()[0].contains("does not say `pbrt-r4` and its version"), "{:?}", other.fails().tail());
}

#[test]
fn pbrt_3_reads_its_samples_from_a_copy_of_the_settings() {
    let mut stage = Stage::new("pbrt-v3", "pbrt", PBRT, PBRT3);
    write_pfm(&stage.path("image.pfm"), &picture()).expect("an image");
    let before = stage.emitted();
    let (rendered, news) = stage.render().expect("an image");
    assert_eq!(rendered.image, picture());
    assert_eq!((rendered.seconds, rendered.samples_done), (0.6, 16));
    assert_eq!(rendered.renderer_version, "3", "without the minute at which it was built");
    assert_eq!(news[0], Progress::Started { version: rendered.renderer_version.clone() });
    assert!(matches!(news[1], Progress::Loaded { .. }), "{news:?}");
    assert!(matches!(news.last(), Some(Progress::Samples { done: 16, total: 16, .. })), "{news:?}");
    assert!(stage.call().ends_with("emitted/scene.pbrt") && !stage.call().contains("nthreads"), "{}", stage.call());
    assert!(fs::read_to_string(stage.path("log")).expect("a log").contains("Statistics:"));

    (stage.request.samples, stage.request.threads) = (77, Some(3));
    stage.render().expect("an image");
    assert!(stage.call().starts_with("--nthreads 3 --logdir "), "{}", stage.call());
    assert_eq!(fs::read_to_string(stage.path("read.pbrt")).expect("a scene"), PBRT.replace("[16]", "[77]"));
    assert_eq!(stage.emitted(), before);
}

/// A scene of 2 by 1 pixels whose film grows.
const SEEDED: &str = "Camera \"perspective\" \"float fov\" [45]\nFilm \"image\" \"integer xresolution\" [2] \"integer yresolution\" \
                      [1]\nPixelFilter \"gaussian\" \"float xwidth\" [1.5] \"float ywidth\" [1.5]\nSampler \"random\" \
                      \"integer pixelsamples\" [16]\nIntegrator \"path\" \"integer maxdepth\" [5]\n";

/// `picture` under rows of something else.
fn tall(above: usize) -> Image {
    let mut pixels = vec![[9.0; 3]; 2 * above];
    pixels.extend(picture().pixels);
    Image { width: 2, height: above + 1, pixels }
}

#[test]
fn seeds_of_pbrt_3_are_rows_above_the_image() {
    let mut stage = Stage::new("pbrt-v3", "pbrt", SEEDED, PBRT3);
    write_pfm(&stage.path("image.pfm"), &tall(48)).expect("an image");
    let before = stage.emitted();
    stage.request.seed = 3;
    let (rendered, _) = stage.render().expect("an image");
    assert_eq!(rendered.image, picture(), "the rows above are cut off");
    assert_eq!(stage.emitted(), before);
    // One row of tiles for each seed; the window grows as the film does, and the middle of the image stays its middle.
    let read = fs::read_to_string(stage.path("read.pbrt")).expect("a scene");
    assert!(read.contains("\"integer xresolution\" [2] \"integer yresolution\" [49]"), "{read}");
    assert!(read.contains("\"perspective\" \"float screenwindow\" [-2 2 -1 97] \"float fov\" [45]"), "{read}");
    assert!(read.contains("\"path\" \"integer pixelbounds\" [-16 18 32 65] \"integer maxdepth\""), "{read}");

    let mut port = port("pbrt-r3", SEEDED);
    write_exr(&port.path("image.exr"), &tall(48), &Provenance::default()).expect("an image");
    (port.request.seed, port.request.samples) = (3, 77);
    assert_eq!(port.render().expect("an image").0.image, picture());
    let read = fs::read_to_string(port.path("read.pbrt")).expect("a scene");
    assert!(read.contains("yresolution\" [49]") && read.contains("pixelsamples\" [77]"), "{read}");
    assert!(!read.contains("pixelbounds"), "the port does not know it: {read}");

    stage.request.seed = 2048;
    let error = stage.fails();
    assert_eq!(error.to_string(), "pbrt-v3 has no seed 2048 for an image of 2x1 pixels: the largest is 2047");
    // Images that fill the film by themselves, and a filter as wide as can be said.
    for (size, filter) in
        [((16_384, 16_384), "1.5"), ((2, 40_000), "1.5"), ((100_000, 1_000), "1.5"), ((2, 1), "1e300")]
    {
        let mut stage = Stage::new("pbrt-v3", "pbrt", &SEEDED.replace("1.5", filter), PBRT3);
        (stage.request.width, stage.request.height) = size;
        stage.request.seed = u32::MAX;
        assert!(stage.fails().to_string().ends_with("the largest is 0"), "{}", stage.fails());
    }
    for (from, to, what) in
        [("\"path\"", "\"sppm\"", "the integrator `sppm`"), ("\"random\"", "\"sobol\"", "the sampler `sobol`")]
    {
        let mut stage = Stage::new("pbrt-v3", "pbrt", &SEEDED.replace(from, to), PBRT3);
        stage.request.seed = 1;
        let error = stage.fails();
        assert_eq!(error.to_string(), format!("pbrt-v3 has no seeds for {what}"));
    }
    let mut stage = Stage::new("pbrt-v3", "pbrt", &SEEDED.replace("\"path\"", "\"bdpt\""), PBRT3);
    write_pfm(&stage.path("image.pfm"), &tall(16)).expect("an image");
    stage.request.seed = 1;
    stage.render().expect("an image");
    let read = fs::read_to_string(stage.path("read.pbrt")).expect("a scene");
    assert!(read.contains("yresolution\" [17]") && !read.contains("pixelbounds"), "{read}");
}

#[test]
fn pbrt_4_is_given_samples_and_seed() {
    let mut stage = Stage::new("pbrt-v4", "pbrt", PBRT, PBRT4);
    write_exr(&stage.path("image.exr"), &picture(), &Provenance::default()).expect("an image");
    (stage.request.samples, stage.request.seed, stage.request.threads) = (16, 5, Some(2));
    let (rendered, _) = stage.render().expect("an image");
    assert_eq!((&rendered.image, rendered.renderer_version.as_str()), (&picture(), "4"));
    assert!(stage.call().starts_with("--nthreads 2 --spp 16 --seed 5 --outfile "), "{}", stage.call());
    stage.request.seed = u32::MAX;
    assert!(stage.fails().to_string().contains("too large"));
    let old = Stage::new("pbrt-v4", "pbrt", PBRT, &PBRT4.replace("--seed <n>", ""));
    assert!(old.fails().tail()[0].contains("too old: it has no option `--seed`"), "{:?}", old.fails().tail());
}

#[test]
fn mitsuba_0_finds_its_libraries_and_leaves_nothing() {
    let mut stage = Stage::new("mitsuba-0.6", "mitsuba", MITSUBA, MITSUBA6);
    write_exr(&stage.path("image.exr"), &picture(), &Provenance::default()).expect("an image");
    fs::write(stage.path("libmitsuba-core.so"), "").expect("a library");
    let before = stage.emitted();
    (stage.request.samples, stage.request.threads) = (9, Some(4));
    let (rendered, _) = stage.render().expect("an image");
    assert_eq!((rendered.image, rendered.seconds), (picture(), 2.4));
    assert_eq!(rendered.renderer_version, "0.6.0");
    assert!(stage.call().starts_with("-p 4 -D samples=9 -o "), "{}", stage.call());
    let log = fs::read_to_string(stage.path("log")).expect("a log");
    assert!(log.starts_with(&format!("libraries {}", stage.folder.path().display())), "{log}");
    assert_eq!(stage.emitted(), before);
    stage.request.seed = 2;
    assert!(stage.fails().hint().contains("sobol"), "{}", stage.fails().hint());
    fs::write(stage.request.folder.join("settings.xml"), "<default name=\"seed\" value=\"0\"/>").expect("a write");
    stage.render().expect("a sampler with a seed");
    assert!(stage.call().contains("-D samples=9 -D seed=2 -o "), "{}", stage.call());
    fs::write(stage.request.folder.join("scene.xml"), "<scene/>").expect("a write");
    assert!(stage.fails().to_string().contains("no parameter `samples`"));
}

/// The program ends with code 0 then, and may leave an image of what it had.
#[test]
fn mitsuba_0_fails_where_it_says_so_whatever_its_code() {
    let line = "2026-06-01 12:00:00 WARN  ren0 [RenderJob] Rendering of scene \"scene.xml\" did not complete successfully, \
                caught exception: Unable to open the file \"floor.ply\"";
    let stage = Stage::new("mitsuba-0.6", "mitsuba", MITSUBA, &format!("{MITSUBA6}\necho '{line}'; exit 0"));
    write_exr(&stage.path("image.exr"), &picture(), &Provenance::default()).expect("an image");
    let error = stage.fails();
    assert_eq!(error.to_string(), format!("`mitsuba-0.6` failed: {line}"));
    assert!(error.hint().contains("a file is missing"), "{}", error.hint());
    let other = Stage::new(
        "mitsuba-0.5",
        "mitsuba",
        MITSUBA,
        &MITSUBA6.replace("0.6.0", "0.5.0").replace(
            "cp \"$stage",
            "echo 'WARN [RenderJob] Rendering of scene \"a\" did not complete successfully!' >&2; : \"$stage",
        ),
    );
    assert!(other.fails().to_string().ends_with("did not complete successfully!"), "{}", other.fails());
}

#[test]
fn a_program_of_another_version_is_named_with_the_driver_that_takes_it() {
    let wrong = |name: &str, program: &str, body: &str| {
        let error = Stage::new(name, program, if name.starts_with('m') { MITSUBA } else { PBRT }, body).fails();
        assert!(matches!(error, RenderError::NotFound { .. }), "{error}");
        error.tail().join("\n")
    };
    assert!(
        wrong("pbrt-v3", "pbrt", PBRT4)
            .contains("is version 4, and this reads the files of version 3; name it for `pbrt-v4`")
    );
    assert!(wrong("pbrt-v4", "pbrt", PBRT3).contains("name it for `pbrt-v3`"));
    assert!(wrong("pbrt-v3", "pbrt", "echo pbrt version 2.0.0 of Nov").contains("it is version 2, and"));
    assert!(wrong("pbrt-v3", "pbrt", "echo pbrt version unknown").contains("version `unknown`"));
    assert!(wrong("pbrt-v3", "pbrt", "echo I am a shell; echo more").contains("`pbrt version`: I am a shell"));
    assert!(wrong("pbrt-v3", "pbrt", "exit 1").contains("it says nothing"));
    let mitsuba = |version: &str| MITSUBA6.replace("0.6.0", version);
    assert!(wrong("mitsuba-0.5", "mitsuba", MITSUBA6).contains("name it for `mitsuba-0.6`"));
    assert!(wrong("mitsuba-0.6", "mitsuba", &mitsuba("3.9.1")).contains("name it for `mitsuba-3`"));
    assert!(wrong("mitsuba-0.5", "mitsuba", &mitsuba("0.4.4")).contains("too old"));
    let library = "echo 'mitsuba: error while loading shared libraries: libmitsuba-core.so' >&2; exit 127";
    assert!(wrong("mitsuba-0.6", "mitsuba", library).contains("libmitsuba-core.so"));
}

#[test]
fn two_versions_on_one_path_are_told_apart() {
    let three = Stage::new("pbrt-v3", "pbrt", PBRT, PBRT3);
    let four = Stage::new("pbrt-v4", "pbrt", PBRT, PBRT4);
    let both = format!("{}:{}", three.folder.path().display(), four.folder.path().display());
    let env = Env::of(&[("PATH", &both)]);
    let search = Search { env: &env, cache: None, given: None, configured: None, until: None };
    for stage in [&three, &four] {
        let found = find(stage.request.driver, &search).expect("one fits");
        assert_eq!(Some(found.path), stage.request.executable);
    }
    let error = find(driver("mitsuba-0.6").expect("a driver"), &search).expect_err("no Mitsuba");
    assert!(error.hint().contains("https://github.com/mitsuba-renderer/mitsuba"), "{}", error.hint());
    assert!(error.tail().iter().all(|line| !line.contains("python") && !line.contains("cache")), "{:?}", error.tail());
}

#[test]
fn failures_come_with_the_end_of_the_log_and_a_hint() {
    let after = |body: &str| {
        let version = PBRT3.lines().next().expect("the version");
        Stage::new("pbrt-v3", "pbrt", PBRT, &format!("{version}\n{body}"))
    };
    let error = after("echo 'Error: Unable to open file \"floor.ply\"' >&2; exit 1").fails();
    assert!(error.to_string().contains("exit code 1") && error.hint().contains("keep it together"), "{}", error.hint());
    let error = after("echo last words; kill -SEGV $$").fails();
    assert_eq!(
        (error.to_string().as_str(), error.tail()),
        ("`pbrt-v3` was ended by signal 11", &["last words".to_owned()][..])
    );
    assert_eq!(after("exit 0").fails().to_string(), "`pbrt-v3` left no image");
    let stage = after("cp \"$stage/image.pfm\" \"$(after --outfile \"$@\")\"");
    write_pfm(&stage.path("image.pfm"), &Image::filled(3, 1, [1.0; 3])).expect("an image");
    assert_eq!(stage.fails().to_string(), "`pbrt-v3` gave an image of 3x1 pixels instead of 2x1");
    fs::write(stage.path("image.pfm"), "PF\n2 1\n").expect("a write");
    assert!(matches!(stage.fails(), RenderError::Image(_)));
    let mut stage = after("sleep 600");
    stage.request.timeout = Some(Duration::from_millis(500));
    assert!(matches!(stage.fails(), RenderError::TimedOut { .. }));
    stage.request.executable = Some(stage.path("missing"));
    assert!(stage.fails().tail()[0].contains("no such program"));
}

#[test]
fn every_row_says_how_to_come_by_it() {
    for driver in super::super::DRIVERS {
        let driver: &Driver = driver;
        let advice = driver.advice();
        match driver.installation {
            Installation::Python(_) | Installation::Cargo(_) => {
                assert!(advice.contains(&format!("ltsc renderers install {}", driver.name)));
                assert!(!driver.test_scene.is_empty(), "{} cannot be proven", driver.name);
            }
            Installation::User { source } => assert!(advice.contains(source) && advice.contains(driver.programs[0])),
        }
    }
}
