//! `ltsc`: compiler and translator for light-transport test scenes. The only package that sees arguments and
//! terminal.

mod args;
mod commands;
mod output;
mod project;
mod signals;
mod terminal;
mod trust;

use std::process::ExitCode;

use ltsc_render::{guard, supervisor};

/// Bytes of stack of each thread. The deepest recursion is that of nested expressions; this is far more than it needs.
const STACK: usize = 64 << 20;

/// Prints what clap says, without its advice to write `--` before an option that is not known: no command takes it that way.
fn show(error: &clap::Error) {
    let asked = !error.use_stderr();
    let text = error.render();
    let text = if terminal::colored(asked) { text.ansi().to_string() } else { text.to_string() };
    let mut kept: Vec<&str> = text.lines().filter(|line| !line.contains("as a value, use '")).collect();
    kept.dedup_by(|a, b| a.is_empty() && b.is_empty());
    let kept = kept.join("\n");
    if asked { terminal::print(&(kept + "\n")) } else { terminal::say(kept.trim_end()) }
}

fn main() -> ExitCode {
    let mut words = std::env::args_os().skip(1);
    if words.next().is_some_and(|word| word == supervisor::MARK) {
        return ExitCode::from(u8::try_from(supervisor::run(words)).unwrap_or(1));
    }
    let arguments = match args::parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let asked = !error.use_stderr();
            show(&error);
            return if asked { output::Exit::Done.into() } else { output::Exit::Usage.into() };
        }
    };
    signals::end_cleanly();
    ltsc_evaluation::disk::show_by(terminal::say);
    // The executable may be replaced while this runs.
    let own = std::path::PathBuf::from("/proc/self/exe");
    if let Some(executable) = if own.exists() { Some(own) } else { std::env::current_exe().ok() } {
        supervisor::is(executable);
    }
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map_or(String::new(), |at| format!(" ({}:{})", at.file(), at.line()));
        terminal::error(&format!(
            "an internal error (a bug in ltsc){place}: {}",
            terminal::panic_text(panic.payload())
        ));
        terminal::error("please report it with the command and the scene");
    }));
    let worker = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        // What works on several files has the stack of what works on one, and is this thread where one is all there may be.
        let _pool = rayon::ThreadPoolBuilder::new().stack_size(STACK).use_current_thread().build_global();
        commands::run(arguments)
    });
    let exit = worker.map_err(|_| ()).and_then(|worker| worker.join().map_err(|_| ()));
    guard::stop_if_ending();
    exit.unwrap_or(output::Exit::Fault).into()
}
