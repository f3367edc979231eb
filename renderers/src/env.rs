//! The part of the process environment that this package reads, as a value that tests can make.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Environment variables.
#[derive(Clone, Debug, Default)]
pub struct Env {
    vars: BTreeMap<OsString, OsString>,
}

impl Env {
    /// The environment of this process.
    #[must_use]
    pub fn of_process() -> Self {
        Self { vars: std::env::vars_os().collect() }
    }

    /// An environment with just these variables.
    #[must_use]
    pub fn of(vars: &[(&str, &str)]) -> Self {
        Self { vars: vars.iter().map(|(name, value)| (name.into(), value.into())).collect() }
    }

    /// The value of a variable; an empty one counts as not set.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&OsStr> {
        self.vars.get(OsStr::new(name)).map(OsString::as_os_str).filter(|value| !value.is_empty())
    }

    /// All files of this name on the path that can be executed, first the one a shell would take.
    #[must_use]
    pub fn on_path(&self, program: &str) -> Vec<PathBuf> {
        let Some(path) = self.get("PATH") else { return Vec::new() };
        let mut found = Vec::new();
        for folder in std::env::split_paths(path) {
            // An empty or relative entry means the working directory, which may be anybody's.
            if !folder.is_absolute() {
                continue;
            }
            let file = folder.join(format!("{program}{}", std::env::consts::EXE_SUFFIX));
            if executable(&file) && !found.contains(&file) {
                found.push(file);
            }
        }
        found
    }
}

/// Whether the path is a file that somebody may execute.
#[must_use]
pub fn executable(path: &Path) -> bool {
    let Ok(metadata) = path.metadata() else { return false };
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        metadata.is_file() && metadata.permissions().mode() & 0o111 != 0
    }
    #[cfg(not(unix))]
    metadata.is_file()
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn only_executable_files_in_absolute_folders_are_found() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let (one, two) = (folder.path().join("one"), folder.path().join("two"));
        for (place, mode) in [(&one, 0o644), (&two, 0o755)] {
            fs::create_dir(place).expect("folder");
            let file = place.join("tool");
            fs::write(&file, "").expect("write");
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).expect("mode");
        }
        let path = format!(":relative:{}:{}:{}", one.display(), two.display(), two.display());
        let env = Env::of(&[("PATH", &path)]);
        assert_eq!(env.on_path("tool"), [two.join("tool")]);
        assert!(env.on_path("other").is_empty());
    }
}
