//! Programs of the system that answer in a moment and change nothing of ours, such as those of a batch system. They need no supervisor,
//! and may be asked while a signal ends this process.

use std::ffi::OsStr;
use std::io::{self, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The most bytes of an answer.
const LONGEST: u64 = 64 << 20;
/// How often the end of the program is looked for.
const POLL: Duration = Duration::from_millis(10);
/// How long output may go on after the end.
const LINGER: Duration = Duration::from_secs(2);

/// What a program said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether its exit code was 0.
    pub ok: bool,
    /// Its output.
    pub out: String,
    /// What it said on standard error.
    pub err: String,
}

impl Answer {
    /// Its complaint on one line, without its own name in front.
    #[must_use]
    pub fn words(&self) -> String {
        let text = if self.err.trim().is_empty() { &self.out } else { &self.err };
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let lines: Vec<&str> = lines.map(|line| line.split_once("error: ").map_or(line, |(_, words)| words)).collect();
        if lines.is_empty() { "it does not say why".to_owned() } else { lines.join("; ") }
    }
}

/// Asks a program, which is ended where it has not answered in time.
///
/// # Errors
/// If it does not start, or takes too long.
pub fn ask<S: AsRef<OsStr>>(program: &Path, arguments: &[S], patience: Duration) -> io::Result<Answer> {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (out, err) = (child.stdout.take().map(text_of), child.stderr.take().map(text_of));
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if start.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            return Err(io::Error::new(
                io::ErrorKind::TimedOut,
                format!("no answer within {} s", patience.as_secs_f64()),
            ));
        }
        thread::sleep(POLL);
    };
    let text =
        |from: Option<Receiver<String>>| from.and_then(|from| from.recv_timeout(LINGER).ok()).unwrap_or_default();
    Ok(Answer { ok: status.success(), out: text(out), err: text(err) })
}

fn text_of(from: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _as_far_as_it_came = from.take(LONGEST).read_to_end(&mut bytes);
        let _nobody_waits = sender.send(String::from_utf8_lossy(&bytes).into_owned());
    });
    receiver
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(text: &str, patience: Duration) -> io::Result<Answer> {
        ask(Path::new("/bin/sh"), &["-c", text], patience)
    }

    #[test]
    fn answers_and_complaints_are_heard() {
        let minute = Duration::from_secs(60);
        let answer = shell("echo 17; echo 'sbatch: error: no such partition' >&2; exit 1", minute).expect("an answer");
        assert_eq!((answer.ok, answer.out.as_str()), (false, "17\n"));
        assert_eq!(answer.words(), "no such partition");
        assert_eq!(shell("exit 1", minute).expect("an answer").words(), "it does not say why");
        // Much output on both sides does not block.
        let long = shell("yes | head -c 300000; yes | head -c 300000 >&2", minute).expect("an answer");
        assert!(long.ok && long.out.len() == 300_000 && long.err.len() == 300_000);
    }

    #[test]
    fn a_program_that_does_not_answer_is_ended() {
        let start = Instant::now();
        let error = shell("exec sleep 60", Duration::from_millis(100)).expect_err("no answer");
        assert!(error.kind() == io::ErrorKind::TimedOut && start.elapsed() < Duration::from_secs(20));
    }
}
