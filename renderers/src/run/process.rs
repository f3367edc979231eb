//! Runs one program to its end: output to a log, lines to the caller, no orphans.
//!
//! Standard error goes straight into the log file and standard output through a thread that keeps
//! one line at most, so that no amount of output can block the program or fill memory. On Unix the
//! program leads a process group of its own, which is killed as a whole; a descendant that makes
//! itself leader of another session escapes that. On other systems only the program itself is
//! killed, which has not been tested.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// What begins a line that is meant for us.
pub(crate) const EVENT: &str = "@ltsc ";
/// Lines that are longer are not for us, and are cut where they are shown.
const LONGEST_LINE: usize = 64 * 1024;
/// How often the end of the program and of the patience is looked for.
const POLL: Duration = Duration::from_millis(20);
/// How long output may go on after the program and its group have ended.
const LINGER: Duration = Duration::from_secs(2);

/// Which lines of standard output the caller wants; all others go to the log only.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lines {
    /// Those that begin with [`EVENT`], without it; they are not logged.
    Events,
    /// All of them, and each state of a progress bar, which ends where the bar returns to the start of its line; they are
    /// logged as well.
    All,
}

/// When to give up.
#[derive(Clone, Copy, Default)]
pub(crate) struct Patience<'a> {
    pub timeout: Option<Duration>,
    pub cancel: Option<&'a AtomicBool>,
}

/// How the program ended.
#[derive(Debug)]
pub(crate) enum End {
    Exited(ExitStatus),
    TimedOut,
    Cancelled,
}

/// Begins a log anew.
pub(crate) fn begin(log: &Path) -> io::Result<()> {
    File::create(log).map(|_| ())
}

/// Runs the command, whose input and output are set here; the output is added to `log`.
pub(crate) fn run(
    mut command: Command,
    log: &Path,
    lines: Lines,
    patience: Patience<'_>,
    on_line: &mut dyn FnMut(&str),
) -> io::Result<End> {
    // Two writers share the log, so each write must go to the end.
    let open = || OpenOptions::new().append(true).create(true).open(log);
    let (sink, errors) = (open()?, open()?);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let start = Instant::now();
    let mut tree = Tree { child: command.spawn()?, ended: false };
    // The command keeps the other end of the log open.
    drop(command);
    let Some(stdout) = tree.child.stdout.take() else {
        return Err(io::Error::other("the program has no standard output"));
    };
    let (sender, receiver) = sync_channel(64);
    thread::spawn(move || pump(stdout, sink, lines, &sender));
    let end = loop {
        match receiver.recv_timeout(POLL) {
            Ok(line) => on_line(&line),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => thread::sleep(POLL),
        }
        if patience.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
            break End::Cancelled;
        }
        if tree.has_exited()? {
            break End::Exited(tree.finish()?);
        }
        if patience.timeout.is_some_and(|timeout| start.elapsed() >= timeout) {
            break End::TimedOut;
        }
    };
    match end {
        End::Exited(_) => drain(&receiver, on_line),
        End::TimedOut | End::Cancelled => {
            tree.finish()?;
        }
    }
    Ok(end)
}

/// The last lines of a log, fit for a terminal.
pub(crate) fn tail(log: &Path, count: usize) -> Vec<String> {
    const BYTES: u64 = 64 * 1024;
    const WIDTH: usize = 400;
    let read = || -> io::Result<Vec<u8>> {
        let mut file = File::open(log)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(BYTES)))?;
        let mut bytes = Vec::new();
        file.take(BYTES).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let text = read().unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let lines: Vec<String> = text
        .lines()
        .map(|line| plain(line).chars().take(WIDTH).collect::<String>())
        .filter(|line| !line.trim().is_empty())
        .collect();
    lines[lines.len().saturating_sub(count)..].to_vec()
}

/// The text without what would move the cursor or change the colors of a terminal. A progress bar
/// that returns to the start of its line shows its last state.
fn plain(line: &str) -> String {
    let line = line.trim_end_matches('\r').rsplit('\r').next().unwrap_or_default();
    let mut out = String::new();
    let mut chars = line.chars().peekable();
    while let Some(char) = chars.next() {
        if char == '\u{1b}' {
            // A control sequence ends with a letter (ECMA-48, 5.4).
            if chars.next_if_eq(&'[').is_some() {
                for char in chars.by_ref() {
                    if char.is_ascii_alphabetic() {
                        break;
                    }
                }
            }
        } else if char == '\t' {
            out.push(' ');
        } else if !char.is_control() {
            out.push(char);
        }
    }
    out
}

/// Reads what is left after the end, but not for long: a stray descendant may hold the pipe open.
fn drain(receiver: &Receiver<String>, on_line: &mut dyn FnMut(&str)) {
    let end = Instant::now() + LINGER;
    while let Some(left) = end.checked_duration_since(Instant::now()) {
        match receiver.recv_timeout(left) {
            Ok(line) => on_line(&line),
            Err(_) => return,
        }
    }
}

/// Copies standard output to the log and passes wanted lines on, until nobody writes any more.
fn pump(stdout: ChildStdout, mut log: File, lines: Lines, sender: &SyncSender<String>) {
    let mut reader = BufReader::with_capacity(LONGEST_LINE, stdout);
    let mut line = Vec::new();
    let mut inside = false;
    loop {
        line.clear();
        match read_line(&mut reader, lines == Lines::All, &mut line) {
            Ok(()) if !line.is_empty() => {}
            _ => return,
        }
        let begins = !inside;
        inside = !matches!((line.last(), lines), (Some(b'\n'), _) | (Some(b'\r'), Lines::All));
        let event = begins && !inside && line.starts_with(EVENT.as_bytes());
        // A full disk or a caller that has gone must not stop the reading, or the program would
        // wait for ever.
        if lines == Lines::All || !event {
            let _ = log.write_all(&line);
        }
        if lines == Lines::All && begins {
            let _ = sender.send(plain(String::from_utf8_lossy(&line).trim_end()));
        } else if event {
            let text = String::from_utf8_lossy(&line[EVENT.len()..]);
            let _ = sender.send(text.trim_end().to_owned());
        }
    }
}

/// Reads up to the end of a line, of the state of a progress bar if those are wanted, of the longest line, or of the stream.
fn read_line(reader: &mut impl BufRead, states: bool, line: &mut Vec<u8>) -> io::Result<()> {
    while line.len() < LONGEST_LINE {
        let bytes = match reader.fill_buf() {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        if bytes.is_empty() {
            return Ok(());
        }
        let bytes = &bytes[..bytes.len().min(LONGEST_LINE - line.len())];
        let end = bytes.iter().position(|byte| *byte == b'\n' || states && *byte == b'\r');
        let taken = end.map_or(bytes.len(), |end| end + 1);
        line.extend_from_slice(&bytes[..taken]);
        reader.consume(taken);
        if end.is_some() {
            return Ok(());
        }
    }
    Ok(())
}

/// A running program and what it started. Dropping it kills all of them.
struct Tree {
    child: Child,
    ended: bool,
}

impl Tree {
    /// Whether the program has ended. It is not yet waited for, so that its number, which is also
    /// that of its group, cannot pass to another program.
    #[cfg(unix)]
    fn has_exited(&self) -> io::Result<bool> {
        use rustix::process::{WaitId, WaitIdOptions, waitid};
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        loop {
            match waitid(WaitId::Pid(self.pid()?), options) {
                Ok(status) => return Ok(status.is_some()),
                Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    #[cfg(not(unix))]
    fn has_exited(&mut self) -> io::Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Kills what is left of the program and its group, and waits for the program.
    fn finish(&mut self) -> io::Result<ExitStatus> {
        self.kill();
        let status = self.child.wait();
        self.ended = true;
        status
    }

    #[cfg(unix)]
    fn kill(&mut self) {
        use rustix::process::{Signal, kill_process_group};
        if let Ok(pid) = self.pid() {
            // It fails only if the group is empty already.
            let _ = kill_process_group(pid, Signal::KILL);
        }
    }

    #[cfg(not(unix))]
    fn kill(&mut self) {
        let _ = self.child.kill();
    }

    #[cfg(unix)]
    fn pid(&self) -> io::Result<rustix::process::Pid> {
        i32::try_from(self.child.id())
            .ok()
            .and_then(rustix::process::Pid::from_raw)
            .ok_or_else(|| io::Error::other("the program has no process number"))
    }
}

impl Drop for Tree {
    fn drop(&mut self) {
        if !self.ended {
            let _ = self.finish();
        }
    }
}
