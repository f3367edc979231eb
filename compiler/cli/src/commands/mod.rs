//! One file per subcommand.

mod build;
mod completions;
mod diff;
mod emit;
mod explain;
mod lint;
mod render;
mod renderers;
mod shared;

use crate::args::{Arguments, Command};
use crate::output::Exit;
use crate::terminal;

/// Runs the command.
pub fn run(arguments: Arguments) -> Exit {
    terminal::choose(arguments.color);
    let done = match arguments.command {
        Command::Build(command) => build::run(&command),
        Command::Lint(command) => lint::run(&command),
        Command::Emit(command) => emit::run(&command),
        Command::Render(command) => render::run(&command),
        Command::Diff(command) => diff::run(&command),
        Command::Renderers(command) => renderers::run(&command),
        Command::Explain(command) => explain::run(&command),
        Command::Completions { shell } => completions::run(shell),
    };
    done.unwrap_or_else(|failure| failure.show())
}
