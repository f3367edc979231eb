//! What `ltsc build` says when it is done: what is new in full, and how much is as it was.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use ltsc_core::formats::Target;

use crate::args::Build;
use crate::output::Located;
use crate::terminal;

use super::super::said::{from_here, losses, losses_of, plural, warnings};
use super::{Built, Ready};

/// Scenes that get a line each.
const SCENES: usize = 4;

/// What there is to say.
pub struct Told<'t> {
    pub command: &'t Build,
    pub output: &'t Path,
    pub ready: &'t [Ready<'t>],
    pub targets: &'t [&'static Target],
    pub built: &'t [Built],
    /// Warnings that were not shown yet.
    pub warnings: &'t [Located<'t>],
}

/// Where the warnings of `paths` are shown.
pub fn lint(paths: &[PathBuf], count: usize) -> String {
    format!("{}: `ltsc lint{}` shows them", plural(count, "warning"), arguments(paths))
}

fn arguments(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| format!(" {}", path.display())).collect()
}

impl Told<'_> {
    /// Says it; warnings and losses only for people, since other forms have them already.
    pub fn say(&self, people: bool) {
        if self.command.check {
            self.stale();
            if people && !self.warnings.is_empty() {
                terminal::say(&lint(&self.command.paths, self.warnings.len()));
            }
            return;
        }
        if people {
            self.findings();
        }
        self.written();
        if people {
            self.files();
        }
    }

    /// What would be written.
    fn stale(&self) {
        let mut lines = String::new();
        for Built { name, changes, .. } in self.built {
            let stale = changes.written.iter().map(|path| (path, "stale"));
            for (path, word) in stale.chain(changes.removed.iter().map(|path| (path, "left over"))) {
                lines.push_str(&format!("{word}: {}\n", self.output.join(name).join(path).display()));
            }
        }
        terminal::print(&lines);
        self.by_hand("was changed by hand");
        let place = from_here(self.output);
        terminal::say(&match self.is_stale() {
            true => format!("{place} is stale; `ltsc build` brings it up to date"),
            false => format!("{} in {place}: nothing to do, all files are up to date", self.what()),
        });
    }

    /// Warnings and losses: those of scenes that have changed, and the number of the others.
    fn findings(&self) {
        let changed: BTreeSet<&str> =
            self.built.iter().filter(|scene| !scene.changes.is_empty()).map(|scene| scene.name.as_str()).collect();
        let fresh: BTreeSet<_> = self
            .ready
            .iter()
            .filter(|ready| changed.contains(ready.scene.name.as_str()))
            .flat_map(|ready| {
                ready
                    .file
                    .checked
                    .findings
                    .iter()
                    .chain(&ready.remarks)
                    .map(|one| ready.file.located(one.clone()).key())
            })
            .collect();
        let (new, old): (Vec<&Located<'_>>, Vec<_>) =
            self.warnings.iter().partition(|located| fresh.contains(&located.key()));
        for line in warnings(&new) {
            terminal::say(&line);
        }
        if !new.is_empty() {
            terminal::say(&format!("`ltsc lint{}` shows where, and what to write", arguments(&self.command.paths)));
        }
        let everything = self
            .ready
            .iter()
            .map(|ready| ready.ledgers.iter().map(|ledger| (ledger.target, losses_of(ledger))).collect::<Vec<_>>());
        let news: Vec<_> = match self.command.verbose {
            true => everything.collect(),
            false => self.built.iter().map(|scene| scene.news.clone()).collect(),
        };
        for line in losses(&news, self.ready.len(), self.command.verbose) {
            terminal::say(&line);
        }
        let mut same = Vec::new();
        if !old.is_empty() {
            same.push(format!("{} (`ltsc lint{}`)", plural(old.len(), "warning"), arguments(&self.command.paths)));
        }
        let lossy: BTreeSet<&str> = self
            .built
            .iter()
            .flat_map(|scene| scene.known.iter().filter(|(_, count)| *count > 0).map(|(target, _)| *target))
            .collect();
        if !lossy.is_empty() && !self.command.verbose {
            let targets = plural(lossy.len(), "target");
            same.push(format!("losses in {targets} (`ltsc build{} --verbose`)", arguments(&self.command.paths)));
        }
        if !same.is_empty() {
            terminal::say(&format!("as in the last build: {}", same.join(", ")));
        }
    }

    /// What was written of each scene, or of many together.
    fn written(&self) {
        let changed: Vec<&Built> = self.built.iter().filter(|scene| !scene.changes.is_empty()).collect();
        let line = |name: &str, [written, same, removed]: [usize; 3]| {
            let removed = if removed == 0 { String::new() } else { format!(", {removed} removed") };
            format!("{name}: {written} files written, {same} unchanged{removed}\n")
        };
        let counts = |scene: &&Built| [scene.changes.written.len(), scene.changes.same, scene.changes.removed.len()];
        let lines = match changed.len() {
            0..=SCENES => changed.iter().map(|scene| line(&scene.name, counts(scene))).collect(),
            many => {
                let sum = changed.iter().map(counts).fold([0; 3], |sum, one| [0, 1, 2].map(|at| sum[at] + one[at]));
                line(&plural(many, "scene"), sum)
            }
        };
        terminal::print(&lines);
        for (name, path) in
            self.built.iter().flat_map(|scene| scene.changes.kept.iter().map(|path| (&scene.name, path)))
        {
            let path = self.output.join(name).join(path);
            terminal::say(&format!("{} is no longer made, and was changed since: it stays", path.display()));
        }
        self.by_hand("was changed by hand, and is written anew");
        let place = from_here(self.output);
        terminal::say(&match self.is_stale() {
            true => format!("{} in {place}", self.what()),
            false => format!("{} in {place}: nothing to do, all files are up to date", self.what()),
        });
    }

    fn by_hand(&self, what: &str) {
        for scene in self.built {
            for path in &scene.changes.restored {
                let path = self.output.join(&scene.name).join(path);
                terminal::say(&format!("{} {what}", path.display()));
            }
        }
    }

    /// The files to open: those of a scene that is new, else one.
    fn files(&self) {
        let changed = |ready: &&Ready<'_>| {
            self.built.iter().any(|scene| scene.name == ready.scene.name && !scene.changes.is_empty())
        };
        let Some(shown) = self.ready.iter().find(changed).or(self.ready.first()) else { return };
        let name = &shown.scene.name;
        let file = |target: &Target| self.output.join(name).join(target.name).join(target.main_file_of(name));
        let new = self.built.iter().any(|scene| scene.first && scene.name == *name);
        if !new && !self.command.verbose {
            if let Some(target) = self.targets.first() {
                terminal::say(&format!("  for example {}", from_here(&file(target))));
            }
            return;
        }
        for target in self.targets {
            terminal::say(&format!("  {:<12} {}", target.name, from_here(&file(target))));
        }
        if self.ready.len() > 1 {
            terminal::say(&format!("  and the same for {}", plural(self.ready.len() - 1, "more scene")));
        }
        if new {
            terminal::say(&format!(
                "next: open one, or `ltsc render {} --renderer NAME -o {name}.exr`; `ltsc renderers list` says which are there",
                from_here(&shown.file.file)
            ));
        }
    }

    fn is_stale(&self) -> bool {
        self.built.iter().any(|scene| !scene.changes.is_empty())
    }

    /// `12 scenes for 9 targets`
    fn what(&self) -> String {
        let targets = self.built.iter().map(|scene| scene.targets).max().unwrap_or(0);
        let scenes = self.built.iter().filter(|scene| scene.targets > 0).count();
        format!("{} for {}", plural(scenes, "scene"), plural(targets, "target"))
    }
}
