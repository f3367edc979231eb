//! A process and all that came of it, ended as a whole.
//!
//! On Linux a supervisor is the parent of whatever its descendants leave behind ("subreaper"), so that all of them are found
//! through `/proc`, whatever groups and sessions they made. On other Unix systems the process group is ended.

use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// How long processes are looked for that start others faster than they are ended.
const PATIENCE: Duration = Duration::from_secs(5);

/// Ends all that descends from `root`, and not `root` itself.
pub(crate) fn end_below(root: Pid) {
    let start = Instant::now();
    loop {
        let below = below(root);
        if below.is_empty() || start.elapsed() > PATIENCE {
            return;
        }
        for pid in below {
            // It fails only if the process is gone.
            let _ = kill_process(pid, Signal::KILL);
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Ends `root`, which leads a group, and all that descends from it.
pub(crate) fn end(root: Pid) {
    end_below(root);
    let _ = kill_process_group(root, Signal::KILL);
    let _ = kill_process(root, Signal::KILL);
}

/// The most memory that a process below `root` has held at once, in bytes; none where the system does not tell.
#[cfg(target_os = "linux")]
pub(crate) fn peak_memory(root: Pid) -> Option<u64> {
    let of = |pid: Pid| {
        let status = std::fs::read_to_string(format!("/proc/{}/status", pid.as_raw_nonzero())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
    };
    below(root).into_iter().filter_map(of).max()
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn peak_memory(_: Pid) -> Option<u64> {
    None
}

/// Seconds of processor time that the ended children of a process took, itself ended and not yet waited for, or running.
#[cfg(target_os = "linux")]
pub(crate) fn time_of_children(root: Pid) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", root.as_raw_nonzero())).ok()?;
    // Behind the name, the fields are the third and later (proc(5)): cutime and cstime are the 16th and 17th.
    let (_, rest) = stat.rsplit_once(')')?;
    let mut words = rest.split_whitespace().skip(13);
    let ticks: u64 = words.next()?.parse::<u64>().ok()? + words.next()?.parse::<u64>().ok()?;
    Some(ticks as f64 / rustix::param::clock_ticks_per_second() as f64)
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn time_of_children(_: Pid) -> Option<f64> {
    None
}

/// All that descends from a process, without those that have ended and wait to be heard.
#[cfg(target_os = "linux")]
fn below(root: Pid) -> Vec<Pid> {
    let mut parents = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let number = entry.file_name().to_str().and_then(|name| name.parse::<i32>().ok());
        let Some(pid) = number else { continue };
        // `1234 (name, which may hold anything) S 1200 ...`
        let Ok(stat) = std::fs::read_to_string(entry.path().join("stat")) else { continue };
        let Some((_, rest)) = stat.rsplit_once(')') else { continue };
        let mut words = rest.split_whitespace();
        let (state, parent) = (words.next(), words.next().and_then(|word| word.parse::<i32>().ok()));
        if let Some(parent) = parent {
            parents.push((pid, parent, !matches!(state, Some("Z" | "X"))));
        }
    }
    let mut known = vec![root.as_raw_nonzero().get()];
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(parent) = known.get(at).copied() {
        for (pid, _, runs) in parents.iter().filter(|(_, of, _)| *of == parent) {
            known.push(*pid);
            found.extend(Pid::from_raw(*pid).filter(|_| *runs));
        }
        at += 1;
    }
    found
}

#[cfg(not(target_os = "linux"))]
fn below(_: Pid) -> Vec<Pid> {
    Vec::new()
}
