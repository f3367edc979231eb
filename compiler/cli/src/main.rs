//! `ltsc`: compiler and translator for light-transport test scenes. The only package that sees arguments, disk and
//! terminal.

mod args;
mod commands;
mod disk;
mod output;
mod project;
mod terminal;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let arguments = match args::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let asked = !error.use_stderr();
            let _shown = error.print();
            return if asked { output::Exit::Done.into() } else { output::Exit::Usage.into() };
        }
    };
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map_or(String::new(), |at| format!(" ({}:{})", at.file(), at.line()));
        terminal::error(&format!("a fault of ltsc itself{place}: {}", terminal::panic_text(panic.payload())));
        terminal::error("please report it with the command and the scene");
    }));
    // The deepest recursion is that of nested expressions; this is far more than it needs.
    let worker = std::thread::Builder::new().stack_size(64 << 20).spawn(move || commands::run(arguments));
    let exit = worker.map_err(|_| ()).and_then(|worker| worker.join().map_err(|_| ()));
    exit.unwrap_or(output::Exit::Fault).into()
}
