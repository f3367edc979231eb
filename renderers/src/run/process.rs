//! Runs one program to its end: output to a log, lines to the caller, no orphans.
//!
//! Standard error goes straight into the log file and standard output through a thread that keeps
//! one line at most, so that no amount of output can block the program or fill memory. The program
//! runs under a supervisor, and ends with all that it started: on Linux all of its descendants, on
//! other Unix systems its process group. On other systems only the program itself is killed, which
//! has not been tested.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::{guard, supervisor};

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
    pub until: Option<Instant>,
    pub cancel: Option<&'a AtomicBool>,
}

/// How the program ended.
#[derive(Debug)]
pub(crate) enum End {
    Exited(ExitStatus),
    TimedOut,
    Cancelled,
}

/// What a program took, with all that it started.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Usage {
    /// Seconds of processor time; none where the system does not tell, or no supervisor was there to hear of it.
    pub cpu_seconds: Option<f64>,
    /// Bytes of memory that its largest process held at once, looked at five times a second.
    pub peak_memory: Option<u64>,
}

/// How often the memory is looked at.
const LOOK: Duration = Duration::from_millis(200);

/// Begins a log anew.
pub(crate) fn begin(log: &Path) -> io::Result<()> {
    File::create(log).map(|_| ())
}

/// Runs the command, whose input and output are set here; the output is added to `log`.
pub(crate) fn run(
    command: Command,
    log: &Path,
    lines: Lines,
    patience: Patience<'_>,
    on_line: &mut dyn FnMut(&str),
) -> io::Result<(End, Usage)> {
    // Two writers share the log, so each write must go to the end.
    let open = || OpenOptions::new().append(true).create(true).open(log);
    let (sink, errors) = (open()?, open()?);
    let mut command = supervisor::over(command);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut tree = Tree::start(&mut command)?;
    // The command keeps the other end of the log open.
    drop(command);
    let Some(stdout) = tree.child.stdout.take() else {
        return Err(io::Error::other("the program has no standard output"));
    };
    let (sender, receiver) = sync_channel(64);
    thread::spawn(move || pump(stdout, sink, lines, &sender));
    let (mut usage, mut looked) = (Usage::default(), None::<Instant>);
    let end = loop {
        if looked.is_none_or(|looked| looked.elapsed() >= LOOK) {
            usage.peak_memory = usage.peak_memory.max(tree.peak_memory());
            looked = Some(Instant::now());
        }
        match receiver.recv_timeout(POLL) {
            Ok(line) => on_line(&line),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => thread::sleep(POLL),
        }
        if patience.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
            break End::Cancelled;
        }
        if tree.has_exited()? {
            // It may have been ended because this process is being ended.
            guard::stop_if_ending();
            usage.cpu_seconds = tree.cpu_seconds();
            break End::Exited(tree.finish()?);
        }
        if patience.until.is_some_and(|until| Instant::now() >= until) {
            break End::TimedOut;
        }
    };
    match end {
        End::Exited(_) => drain(&receiver, on_line),
        End::TimedOut | End::Cancelled => {
            tree.finish()?;
        }
    }
    Ok((end, usage))
}

/// The last lines of a log, fit for a terminal.
#[must_use]
pub fn tail(log: &Path, count: usize) -> Vec<String> {
    const BYTES: u64 = 64 * 1024;
    const WIDTH: usize = 400;
    let read = || -> io::Result<Vec<u8>> {
        let (mut file, length) = crate::regular::open(log)?;
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
    /// What ends all that the program started; none where the system refuses it.
    #[cfg(windows)]
    whole: Option<crate::job_object::Whole>,
    ended: bool,
    _held: guard::Held,
}

impl Tree {
    /// Starts it, and sees to it that it ends with this process.
    fn start(command: &mut Command) -> io::Result<Self> {
        let make = || {
            // Under a supervisor this would come too late for an error.
            let missing = |path: &Path| path.components().count() > 1 && !path.exists();
            if command.get_args().next().is_some_and(|first| first == supervisor::MARK)
                && supervisor::program(command).is_some_and(|program| missing(Path::new(program)))
            {
                return Err(io::ErrorKind::NotFound.into());
            }
            command.spawn()
        };
        let (child, held) = guard::hold(make, |child| {
            let id = child.id();
            // Where descendants are not found from here, the supervisor ends them, once this process and its input have ended.
            move || match supervisor::is_used() && !cfg!(target_os = "linux") {
                true => {}
                false => end(id),
            }
        })?;
        Ok(Self {
            #[cfg(windows)]
            whole: crate::job_object::Whole::of(&child).ok(),
            child,
            ended: false,
            _held: held,
        })
    }

    /// Whether the program has ended. It is not yet waited for, so that its number, which is also
    /// that of its group, cannot pass to another program.
    #[cfg(unix)]
    fn has_exited(&self) -> io::Result<bool> {
        use rustix::process::{WaitId, WaitIdOptions, waitid};
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let pid = pid(self.child.id()).ok_or_else(|| io::Error::other("the program has no process number"))?;
        loop {
            match waitid(WaitId::Pid(pid), options) {
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

    /// The most memory that one of its processes has held.
    #[cfg(unix)]
    fn peak_memory(&self) -> Option<u64> {
        crate::tree::peak_memory(pid(self.child.id())?)
    }

    /// The processor time of all that has ended; the supervisor, which has heard of it, is not yet waited for.
    #[cfg(unix)]
    fn cpu_seconds(&self) -> Option<f64> {
        crate::tree::time_of_children(pid(self.child.id())?).filter(|_| supervisor::is_used())
    }

    #[cfg(not(unix))]
    fn peak_memory(&self) -> Option<u64> {
        None
    }

    #[cfg(not(unix))]
    fn cpu_seconds(&self) -> Option<f64> {
        None
    }

    /// Ends the supervisor's input, and gives it time to end what descends from it.
    #[cfg(all(unix, not(target_os = "linux")))]
    fn let_supervisor_end(&mut self) {
        drop(self.child.stdin.take());
        let start = std::time::Instant::now();
        while supervisor::is_used() && start.elapsed() < LINGER && !self.has_exited().unwrap_or(true) {
            thread::sleep(POLL);
        }
    }

    /// Kills what is left of the program and what it started, and waits for the program.
    fn finish(&mut self) -> io::Result<ExitStatus> {
        #[cfg(all(unix, not(target_os = "linux")))]
        self.let_supervisor_end();
        end(self.child.id());
        // First the program, whose exit code would be that of a success where only the job ends it.
        #[cfg(not(unix))]
        let _gone = self.child.kill();
        #[cfg(windows)]
        drop(self.whole.take());
        let status = self.child.wait();
        self.ended = true;
        status
    }
}

#[cfg(unix)]
fn pid(id: u32) -> Option<rustix::process::Pid> {
    i32::try_from(id).ok().and_then(rustix::process::Pid::from_raw)
}

/// Ends a process with all that it started. It is not yet waited for, so that its number is still its own.
#[cfg(unix)]
fn end(id: u32) {
    if let Some(pid) = pid(id) {
        crate::tree::end(pid);
    }
}

#[cfg(not(unix))]
fn end(_id: u32) {}

impl Drop for Tree {
    fn drop(&mut self) {
        if !self.ended {
            let _ = self.finish();
        }
    }
}
