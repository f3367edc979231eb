//! A small process between ltsc and each program that it starts. It ends the program with all that this started, when it ends,
//! when ltsc asks, and when ltsc is gone, however it went. It is the executable of ltsc itself, called in a way of its own.
//!
//! ltsc holds the supervisor's standard input open; the end of it is the request to end, or tells that nobody is left to ask.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

/// The first argument of a supervisor.
pub const MARK: &str = "--supervise-a-renderer";

static EXECUTABLE: OnceLock<PathBuf> = OnceLock::new();

/// Says which executable supervises when it is called with [`MARK`]. Without one programs are started directly, and outlive a caller
/// that is killed.
pub fn is(executable: PathBuf) {
    let _first = EXECUTABLE.set(executable);
}

/// Whether programs are supervised.
pub(crate) fn is_used() -> bool {
    cfg!(unix) && EXECUTABLE.get().is_some()
}

/// The command under a supervisor, which also removes the temporary folders of ltsc where ltsc itself can no longer do so.
pub(crate) fn over(command: Command) -> Command {
    let Some(executable) = EXECUTABLE.get().filter(|_| cfg!(unix)) else { return command };
    let mut outer = Command::new(executable);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::arg0(&mut outer, "ltsc");
    outer.arg(MARK);
    let folders = crate::guard::folders();
    outer.arg(folders.len().to_string()).args(folders);
    outer.arg(command.get_program()).args(command.get_args());
    if let Some(folder) = command.get_current_dir() {
        outer.current_dir(folder);
    }
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => outer.env(name, value),
            None => outer.env_remove(name),
        };
    }
    outer
}

/// The program that such a command leads to.
pub(crate) fn program(outer: &Command) -> Option<&OsStr> {
    let mut arguments = outer.get_args().skip(1);
    let count = arguments.next()?.to_str()?.parse::<usize>().ok()?;
    arguments.nth(count)
}

/// Supervises, with the arguments behind [`MARK`], and gives the exit code of the program; a signal that ended it ends this process
/// as well.
#[cfg(unix)]
pub fn run(mut arguments: impl Iterator<Item = OsString>) -> i32 {
    let count = arguments.next().and_then(|count| count.to_str()?.parse::<usize>().ok()).unwrap_or(0);
    let folders: Vec<PathBuf> = arguments.by_ref().take(count).map(PathBuf::from).collect();
    let Some(program) = arguments.next() else { return UNSTARTED };
    let mut command = Command::new(program);
    command.args(arguments);
    unix::supervise(command, folders)
}

/// Nothing is supervised here.
#[cfg(not(unix))]
pub fn run(_: impl Iterator<Item = OsString>) -> i32 {
    UNSTARTED
}

/// The exit code where the program cannot be started, as of shells; the reason is on standard error.
const UNSTARTED: i32 = 126;

#[cfg(unix)]
mod unix {
    use std::io::{self, Read, Write};
    use std::os::unix::process::CommandExt;
    use std::path::PathBuf;
    use std::process::{Command, Stdio};
    use std::sync::Mutex;
    use std::thread;
    use std::time::Duration;

    use rustix::process::{Pid, Signal, WaitOptions, WaitStatus, getpid, kill_process, kill_process_group, wait};

    use super::UNSTARTED;
    use crate::{guard, tree};

    /// Held by whoever says how this process ends.
    static END: Mutex<()> = Mutex::new(());

    pub(super) fn supervise(mut command: Command, folders: Vec<PathBuf>) -> i32 {
        // What descendants leave behind becomes a child of this process.
        #[cfg(target_os = "linux")]
        let _older_kernels = rustix::process::set_child_subreaper(Some(getpid()));
        // Its input never ends, as long as this process is there.
        command.stdin(Stdio::piped()).process_group(0);
        let child = match command.spawn() {
            Ok(child) => child,
            Err(error) => {
                let program = command.get_program().to_string_lossy().into_owned();
                let _told = writeln!(io::stderr(), "`{program}` does not start: {error}");
                return UNSTARTED;
            }
        };
        let Some(program) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) else { return UNSTARTED };
        thread::spawn(move || {
            let _ended = io::copy(&mut io::stdin().lock().take(u64::MAX), &mut io::sink());
            let _only = END.lock();
            end(program);
            // ltsc removes them if it is there.
            for folder in folders {
                guard::remove(&folder);
            }
            std::process::exit(143);
        });
        let status = loop {
            match wait(WaitOptions::empty()) {
                Ok(Some((pid, status))) if pid == program => break Some(status),
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(_) => break None,
            }
        };
        let _only = END.lock();
        end(program);
        finish(status)
    }

    fn end(program: Pid) {
        let _gone = kill_process_group(program, Signal::KILL);
        tree::end_below(getpid());
    }

    /// As the program ended.
    fn finish(status: Option<WaitStatus>) -> i32 {
        let Some(status) = status else { return 1 };
        let signal = status.terminating_signal().and_then(Signal::from_named_raw);
        // The first one of some may only take away the handler of the standard library.
        for signal in signal.iter().cycle().take(2 * signal.iter().count()) {
            let _sent = kill_process(getpid(), *signal);
            thread::sleep(Duration::from_millis(50));
        }
        status.exit_status().unwrap_or(1)
    }
}
