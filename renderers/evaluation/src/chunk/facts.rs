//! What is known of how a chunk was rendered: time, memory, and the machine.

use std::fmt;

use ltsc_render::image::Provenance;
use ltsc_render::regular;
use ltsc_render::run::Rendered;
use serde::{Deserialize, Serialize};

/// Names of facts in the header of a chunk.
const CPU: &str = "cpu-seconds";
const WALL: &str = "wall-seconds";
const MEMORY: &str = "peak-memory";
const MACHINE: &str = "machine";
const THREADS: &str = "threads";
const LOAD: &str = "load";
const AT_ONCE: &str = "at-once";

/// How a chunk was rendered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// The renderer's version, as it says.
    pub version: String,
    /// Samples per pixel that were really taken.
    pub samples: u64,
    /// Seconds of rendering, without start and loading where the renderer tells them apart.
    pub seconds: f64,
    /// Seconds from start to end.
    pub wall_seconds: f64,
    /// Seconds of processor time of the renderer with all that it started; none where the system does not tell.
    pub cpu_seconds: Option<f64>,
    /// Bytes of memory that its largest process held at once.
    pub peak_memory: Option<u64>,
    /// Threads that it was given; all processors if none.
    pub threads: Option<u32>,
    /// The machine.
    pub machine: String,
    /// Running processes of the machine when it began, averaged over a minute.
    pub load: Option<f64>,
    /// Renderers that ran at once, by this program's doing.
    pub at_once: Option<u32>,
}

impl Facts {
    /// Of a rendering that has just ended; `load` is that of its beginning.
    #[must_use]
    pub fn of(rendered: &Rendered, threads: Option<usize>, load: Option<f64>, at_once: Option<u32>) -> Self {
        Self {
            version: rendered.renderer_version.clone(),
            samples: rendered.samples_done,
            seconds: rendered.seconds,
            wall_seconds: rendered.wall_seconds,
            cpu_seconds: rendered.usage.cpu_seconds,
            peak_memory: rendered.usage.peak_memory,
            threads: threads.and_then(|threads| u32::try_from(threads).ok()),
            machine: Machine::here().to_string(),
            load,
            at_once,
        }
    }

    /// Adds what is not in the provenance's own fields.
    pub(super) fn write(&self, provenance: &mut Provenance) {
        let mut add = |name: &str, value: Option<String>| {
            provenance.extra.extend(value.map(|value| (name.to_owned(), value)));
        };
        add(WALL, Some(format!("{:.3}", self.wall_seconds)));
        add(CPU, self.cpu_seconds.map(|seconds| format!("{seconds:.2}")));
        add(MEMORY, self.peak_memory.map(|bytes| bytes.to_string()));
        add(THREADS, self.threads.map(|threads| threads.to_string()));
        add(AT_ONCE, self.at_once.map(|count| count.to_string()));
        add(LOAD, self.load.map(|load| format!("{load:.2}")));
        add(MACHINE, Some(self.machine.clone()));
    }

    /// Reads them from the header of a chunk.
    pub(super) fn read(provenance: &Provenance) -> Self {
        let text =
            |name: &str| provenance.extra.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str());
        let number = |name: &str| text(name).and_then(|value| value.parse::<f64>().ok());
        Self {
            version: provenance.renderer_version.clone(),
            samples: provenance.samples,
            seconds: provenance.seconds,
            wall_seconds: number(WALL).unwrap_or_default(),
            cpu_seconds: number(CPU),
            peak_memory: text(MEMORY).and_then(|value| value.parse().ok()),
            threads: text(THREADS).and_then(|value| value.parse().ok()),
            machine: text(MACHINE).unwrap_or_default().to_owned(),
            load: number(LOAD),
            at_once: text(AT_ONCE).and_then(|value| value.parse().ok()),
        }
    }
}

/// What a time depends on: times of different machines are not compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor, as the system calls it.
    pub processor: String,
    /// How many threads it runs at once.
    pub cores: usize,
    /// Bytes of memory; none where the system does not tell.
    pub memory: Option<u64>,
    /// The operating system and its architecture.
    pub system: String,
}

impl Machine {
    /// This one.
    #[must_use]
    pub fn here() -> Self {
        let line = |path: &str, name: &str| {
            let text = system_file(path)?;
            let value = text.lines().find_map(|line| line.strip_prefix(name))?;
            Some(value.trim_start_matches([' ', '\t', ':']).trim().to_owned())
        };
        let memory =
            line("/proc/meminfo", "MemTotal").and_then(|text| text.strip_suffix("kB")?.trim().parse::<u64>().ok());
        Self {
            processor: line("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown processor".to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            memory: memory.map(|kilobytes| kilobytes << 10),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} cores", self.processor, self.cores)?;
        if let Some(memory) = self.memory {
            write!(f, ", {:.0} GB", memory as f64 / 1e9)?;
        }
        write!(f, ", {}", self.system)
    }
}

/// Running processes of the machine, averaged over a minute.
pub(super) fn load() -> Option<f64> {
    system_file("/proc/loadavg")?.split_whitespace().next()?.parse().ok()
}

/// What Linux says of itself in a file that is made when it is read.
fn system_file(path: &str) -> Option<String> {
    regular::read_text(path.as_ref(), regular::TEXT).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facts_survive_the_header() {
        let facts = Facts {
            version: "3.9.1".to_owned(),
            samples: 64,
            seconds: 1.5,
            wall_seconds: 2.25,
            cpu_seconds: Some(1.25),
            peak_memory: Some(123_456),
            threads: Some(1),
            machine: Machine::here().to_string(),
            load: Some(0.5),
            at_once: Some(2),
        };
        let mut provenance = Provenance {
            renderer_version: facts.version.clone(),
            samples: facts.samples,
            seconds: facts.seconds,
            ..Provenance::default()
        };
        facts.write(&mut provenance);
        assert_eq!(Facts::read(&provenance), facts);
        assert_eq!(Facts::read(&Provenance::default()), Facts::default());
    }
}
