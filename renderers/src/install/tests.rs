//! Installations with a real Python and a fake one, without any package.

use std::fs;
use std::path::PathBuf;

use super::*;
use crate::image::{Image, Provenance, write_exr};
use crate::run::driver;

/// A folder with a cache, and a Python that the request will find on the path.
struct Stage {
    folder: tempfile::TempDir,
    request: InstallRequest,
}

impl Stage {
    #[cfg(unix)]
    fn new(python: &str) -> Self {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("temporary folder");
        let bin = folder.path().join("bin");
        fs::create_dir(&bin).expect("folder");
        let file = bin.join("python3");
        fs::write(&file, format!("#!/bin/sh\n{python}\n")).expect("write");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).expect("mode");
        let request = InstallRequest {
            driver: driver("luxcore").expect("a driver"),
            cache: CachePaths { root: folder.path().join("cache") },
            env: Env::of(&[("PATH", bin.to_str().expect("Unicode"))]),
            python: None,
            cancel: None,
        };
        Self { folder, request }
    }

    fn root(&self) -> PathBuf {
        self.request.cache.renderer("luxcore", "2.11.2")
    }

    fn status(&self) -> Status {
        status_in_cache(self.request.driver, &self.request.cache)
    }

    fn install(&self) -> Result<Installed, InstallError> {
        install(&self.request, &mut |_| {})
    }

    fn calls(&self) -> String {
        fs::read_to_string(self.folder.path().join("calls")).unwrap_or_default()
    }
}

/// A Python that notes its calls, makes an environment which is a copy of itself, whose pip fails
/// as long as there is a file `offline`, and which renders what the test scene should show.
#[cfg(unix)]
const FAKE: &str = r#"
here=$(cd "$(dirname "$0")" && pwd)
stage=$here
while [ ! -d "$stage/cache" ]; do stage=$(dirname "$stage"); done
for last; do :; done
case "$*" in
*ensurepip*) echo '@ltsc version 3.12.1'; echo '@ltsc venv' ;;
*runpy*" venv "*) echo venv >> "$stage/calls"; mkdir -p "$last/bin"; cp "$0" "$last/bin/python" ;;
*runpy*" pip "*)
    for a; do case $a in download|install) echo "pip $a PIP_USER=$PIP_USER TMPDIR=$TMPDIR" >> "$stage/calls" ;; esac; done
    if [ -e "$stage/offline" ]; then echo 'ERROR: No matching distribution found for x'; exit 1; fi
    echo 'Downloading renderer.whl (1 MB)' ;;
*render.py*)
    scratch=$(printf %s "$last" | sed 's/.*"scratch":"\([^"]*\)".*/\1/')
    cp "$stage/image.pfm" "$scratch/image.pfm"
    echo '@ltsc {"event":"version","version":"2.11.2"}'
    echo '@ltsc {"event":"pass","samples":64,"done":64,"total":64,"file":"image.pfm","seconds":1}'
    echo '@ltsc {"event":"done","seconds":1}' ;;
*) exit 9 ;;
esac"#;

/// The image of the test scene.
fn expected() -> Image {
    let mut image = Image::filled(8, 8, [1.0; 3]);
    for y in 0..4 {
        for x in 0..4 {
            image.pixels[y * 8 + x] = [1.0, 2.0, 4.0];
            image.pixels[(y + 4) * 8 + x + 4] = [0.505, 0.252, 0.124];
        }
    }
    image
}

#[cfg(unix)]
fn stage() -> Stage {
    let stage = Stage::new(FAKE);
    fs::create_dir(stage.folder.path().join("cache")).expect("folder");
    crate::image::write_pfm(&stage.folder.path().join("image.pfm"), &expected()).expect("write");
    stage
}

#[cfg(unix)]
#[test]
fn an_installation_goes_through_its_steps_once() {
    let stage = stage();
    assert_eq!(stage.status(), Status::NotInstalled);
    let mut news = Vec::new();
    let installed = install(&stage.request, &mut |progress| news.push(progress)).expect("it works");
    assert!(!installed.already);
    assert_eq!(installed.version, "2.11.2");
    let steps: Vec<Step> = news
        .iter()
        .filter_map(|progress| match progress {
            InstallProgress::Step(step) => Some(*step),
            InstallProgress::Line(_) => None,
        })
        .collect();
    assert_eq!(steps, [Step::Python, Step::Environment, Step::Packages, Step::Verification]);
    assert!(news.contains(&InstallProgress::Line("Downloading renderer.whl (1 MB)".to_owned())));
    let settings = format!("PIP_USER=0 TMPDIR={}", stage.root().join("tmp").display());
    assert_eq!(stage.calls(), format!("venv\npip download {settings}\npip install {settings}\n"));
    let path = stage.root().join("venv/bin/python");
    assert_eq!(stage.status(), Status::Installed { path: path.clone(), version: "2.11.2".to_owned() });
    // The second time there is nothing to do.
    let again = stage.install().expect("it is there");
    assert!(again.already);
    assert_eq!(stage.calls().lines().count(), 3);
    // Nothing lies outside the folder of this version.
    assert_eq!(fs::read_dir(stage.request.cache.renderers()).expect("list").count(), 1);
    // An environment whose Python has gone is no installation.
    fs::remove_file(path).expect("remove");
    assert_eq!(stage.status(), Status::Partial { folder: stage.root() });
}

#[cfg(unix)]
#[test]
fn a_failed_step_is_explained_and_can_be_taken_up_again() {
    let stage = stage();
    let offline = stage.folder.path().join("offline");
    fs::write(&offline, "").expect("write");
    let error = stage.install().expect_err("pip fails");
    assert_eq!(error.to_string(), "installing the packages for `luxcore` failed with exit code 1");
    assert!(error.hint().contains("3.10 to 3.14"), "{}", error.hint());
    assert_eq!(error.tail(), ["ERROR: No matching distribution found for x"]);
    assert_eq!(stage.status(), Status::Partial { folder: stage.root() });
    fs::remove_file(offline).expect("remove");
    assert!(!stage.install().expect("it works now").already);
    uninstall(stage.request.driver, &stage.request.cache).expect("delete");
    assert_eq!(stage.status(), Status::NotInstalled);
    uninstall(stage.request.driver, &stage.request.cache).expect("nothing to delete");
}

#[cfg(unix)]
#[test]
fn a_renderer_that_renders_wrong_is_not_installed() {
    let stage = stage();
    let mut image = expected();
    image.pixels.reverse();
    crate::image::write_pfm(&stage.folder.path().join("image.pfm"), &image).expect("write");
    let error = stage.install().expect_err("the image is upside down");
    assert!(matches!(error, InstallError::Wrong { .. }), "{error}");
    assert_eq!(stage.status(), Status::Partial { folder: stage.root() });
}

#[cfg(unix)]
#[test]
fn two_installations_do_not_run_at_once() {
    let stage = stage();
    fs::create_dir_all(stage.root()).expect("folder");
    let held = lock(&stage.root()).expect("free");
    let error = stage.install().expect_err("locked");
    assert!(error.to_string().ends_with(&format!("(number {})", std::process::id())), "{error}");
    assert!(uninstall(stage.request.driver, &stage.request.cache).is_err());
    // The file stays, as it does when a process dies; the lock does not.
    drop(held);
    assert!(stage.root().join(LOCK).exists());
    stage.install().expect("free again");
}

#[cfg(unix)]
#[test]
fn a_python_that_does_not_fit_is_named_with_the_reason() {
    let reason = |python: &str| {
        let error = Stage::new(python).install().expect_err("no Python fits");
        assert!(error.hint().contains("python3-venv"), "{}", error.hint());
        error.tail().join("\n")
    };
    assert!(reason("echo '@ltsc version 3.8.2'; echo '@ltsc venv'").contains("it is Python 3.8.2"));
    assert!(reason("echo '@ltsc version 2.7.2'; echo '@ltsc venv'").contains("it is Python 2.7.2"));
    assert!(reason("echo '@ltsc version 3.12.2'").contains("lacks the modules"));
    assert!(reason("echo no library; exit 127").contains("no library"));
    let mut stage = Stage::new("");
    stage.request.env = Env::default();
    assert_eq!(stage.install().expect_err("none").tail(), ["no `python3` on the path"]);
    stage.request.python = Some("/missing/python3".into());
    assert_eq!(stage.install().expect_err("none").tail(), ["`/missing/python3`: no such program"]);
}

/// A cargo that notes its arguments and builds a renderer that shows the test scene; it fails as long as there is a file
/// `offline`.
#[cfg(unix)]
const FAKE_CARGO: &str = r#"
stage=$(cd "$(dirname "$0")/.." && pwd)
if [ "$1" = --version ]; then echo "cargo $(cat "$stage/version") (f2d3ce0bd 2026-03-21)"; exit 0; fi
echo "$@ in $CARGO_TARGET_DIR" >> "$stage/calls"
if [ -e "$stage/offline" ]; then echo 'error: failed to download: could not resolve host' >&2; exit 101; fi
mkdir -p "$CARGO_TARGET_DIR/release"
while [ "$1" != --root ]; do shift; done
mkdir -p "$2/bin"
cat > "$2/bin/pbrt-r3" <<END
#!/bin/sh
echo 'pbrt-r3 3.2.0'
if [ "\$1" = --version ]; then exit 0; fi
while [ "\$1" != --outfile ]; do shift; done
cp "$stage/image.exr" "\$2"
END
chmod +x "$2/bin/pbrt-r3"
"#;

#[cfg(unix)]
#[test]
fn a_crate_is_built_in_the_folder_of_its_version() {
    let mut stage = Stage::new("");
    let bin = stage.folder.path().join("bin");
    fs::rename(bin.join("python3"), bin.join("cargo")).expect("rename");
    fs::write(bin.join("cargo"), format!("#!/bin/sh\n{FAKE_CARGO}")).expect("write");
    stage.request.driver = driver("pbrt-r3").expect("a driver");
    let place = |name: &str| stage.folder.path().join(name);
    fs::write(place("version"), "1.79.0").expect("write");
    write_exr(&place("image.exr"), &expected(), &Provenance::default()).expect("an image");
    let error = stage.install().expect_err("too old");
    assert_eq!(error.to_string(), "no cargo was found that `pbrt-r3` can be built with");
    assert!(error.tail()[0].contains("1.79.0, and 1.80 is needed"), "{:?}", error.tail());

    fs::write(place("version"), "1.95.0").expect("write");
    fs::write(place("offline"), "").expect("write");
    let error = stage.install().expect_err("no network");
    assert_eq!(error.to_string(), "building the sources for `pbrt-r3` failed with exit code 101");
    assert!(error.hint().contains("network"), "{}", error.hint());
    fs::remove_file(place("offline")).expect("remove");

    let root = stage.request.cache.renderer("pbrt-r3", "3.2.0");
    let installed = stage.install().expect("it works");
    assert_eq!((installed.version.as_str(), &installed.path), ("3.2.0", &root.join("root/bin/pbrt-r3")));
    let call = "install pbrt-r3 --bin pbrt-r3 --locked --force --version =3.2.0 --root";
    let last = format!("{call} {} in {}", root.join("root").display(), root.join("build").display());
    assert_eq!(stage.calls().lines().last(), Some(last.as_str()));
    assert!(!root.join("build").exists() && root.join(MARKER).exists());
    assert_eq!(stage.status(), Status::Installed { path: installed.path.clone(), version: "3.2.0".to_owned() });
    assert!(stage.install().expect("it is there").already);
    uninstall(stage.request.driver, &stage.request.cache).expect("delete");
    assert_eq!(stage.status(), Status::NotInstalled);
}

#[test]
fn what_only_the_user_can_install_is_refused_with_its_source() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let request = InstallRequest {
        driver: driver("pbrt-v4").expect("a driver"),
        cache: CachePaths { root: folder.path().join("cache") },
        env: Env::default(),
        python: None,
        cancel: None,
    };
    let error = install(&request, &mut |_| {}).expect_err("not installed by ltsc");
    assert_eq!(error.to_string(), "`pbrt-v4` is not installed by ltsc");
    assert!(error.hint().contains("https://github.com/mmp/pbrt-v4"), "{}", error.hint());
    assert!(!request.cache.root.exists());
}

#[test]
fn markers_of_older_versions_are_read() {
    let text =
        r#"{"driver": "luxcore", "version": "2.11.2", "python": "3.12.1", "requirements": ["pyluxcore==2.11.2"]}"#;
    assert_eq!(serde_json::from_str::<Marker>(text).expect("a marker").tool, "3.12.1");
}

#[test]
fn verification_refuses_every_kind_of_wrong_image() {
    assert_eq!(verify::judge(&expected(), [1e-4; 3]), Ok(()));
    let change = |index: usize, pixel: [f32; 3]| {
        let mut image = expected();
        image.pixels[index] = pixel;
        verify::judge(&image, [1e-4; 3]).is_err()
    };
    // Emitter, environment and surface, wrong or not a number.
    assert!(change(0, [1.0, 2.0, 4.01]));
    assert!(change(7, [0.99, 1.0, 1.0]));
    assert!(change(63, [f32::NAN, 0.25, 0.125]));
    assert!(change(63, [0.5, 1.0, 0.125]));
    assert!(!change(63, [0.51, 0.25, 0.125]));
}
