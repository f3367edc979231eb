//! One file per subcommand.

mod agree;
mod audit;
mod build;
mod cache;
mod calibrate;
mod clean;
mod completions;
mod conventions;
pub mod diff;
mod doc;
mod emit;
mod equiv;
mod eval;
mod explain;
mod fixes;
mod fmt;
mod import;
mod init;
mod lint;
mod manual;
mod page;
mod reduce;
mod reference;
mod render;
mod renderers;
mod said;
mod serve;
mod shared;
mod similar;
mod stats;
mod survey;
mod task;
mod users;

use crate::args::{Arguments, Command, Format, ReferenceAction, RenderersAction};
use crate::output::{Exit, print_failure, show};
use crate::terminal;

/// Runs the command.
pub fn run(arguments: Arguments) -> Exit {
    terminal::choose(arguments.color);
    let format = format_of(&arguments.command);
    let done = match arguments.command {
        Command::Init(command) => init::run(&command),
        Command::Build(command) => build::run(&command),
        Command::Lint(command) => lint::run(&command),
        Command::Fmt(command) => fmt::run(&command),
        Command::Similar(command) => similar::run(&command),
        Command::Import(command) => import::run(&command),
        Command::Equiv(command) => equiv::run(&command),
        Command::Emit(command) => emit::run(&command),
        Command::Audit(command) => audit::run(&command),
        Command::Render(command) => render::run(&command),
        Command::Diff(command) => diff::run(&command),
        Command::Agree(command) => agree::run(&command),
        Command::Eval(command) => eval::run(&command),
        Command::Reduce(command) => reduce::run(&command),
        Command::Report(command) => page::report(&command),
        Command::View(command) => page::view(&command),
        Command::Serve(command) => serve::run(&command),
        Command::Clean(command) => clean::run(&command),
        Command::Reference(command) => reference::run(&command),
        Command::Renderers(command) => renderers::run(&command),
        Command::Cache(command) => cache::run(&command),
        Command::Calibrate(command) => calibrate::run(&command),
        Command::Conventions(command) => conventions::run(&command),
        Command::Explain(command) => explain::run(&command),
        Command::Doc(command) => doc::run(&command),
        Command::Manual(command) => manual::run(&command),
        Command::Task(command) => task::run(&command),
        Command::Completions { shell } => completions::run(shell),
    };
    let exit = done.unwrap_or_else(|failure| {
        print_failure(&failure, format);
        show(&failure)
    });
    // A gate must not turn green because its answer could not be written.
    if terminal::output_failed() && exit == Exit::Done { Exit::Environment } else { exit }
}

/// The form in which the command answers.
fn format_of(command: &Command) -> Format {
    match command {
        Command::Build(command) => command.findings.format,
        Command::Lint(command) => command.findings.format,
        Command::Fmt(command) => command.format,
        Command::Similar(command) => command.findings.format,
        Command::Import(command) => command.findings.format,
        Command::Equiv(command) => command.findings.format,
        Command::Emit(command) => command.findings.format,
        Command::Audit(command) => command.findings.format,
        Command::Render(command) => command.findings.format,
        Command::Diff(command) => command.answer.format,
        Command::Conventions(command) => command.answer.format,
        Command::Calibrate(command) => command.answer.format,
        Command::Agree(command) => command.findings.format,
        Command::Eval(command) => command.findings.format,
        Command::Reduce(command) => command.findings.format,
        Command::Report(command) => command.answer.format,
        Command::View(command) => command.answer.format,
        Command::Serve(command) => command.answer.format,
        Command::Clean(command) => command.answer.format,
        Command::Cache(command) => command.format,
        Command::Reference(command) => match &command.action {
            Some(ReferenceAction::List(list)) => list.answer.format,
            Some(ReferenceAction::Add(add)) => add.answer.format,
            None => command.findings.format,
        },
        Command::Renderers(command) => match command.action {
            RenderersAction::List { answer } => answer.format,
            RenderersAction::Install { .. } | RenderersAction::Trust => Format::Human,
        },
        Command::Init(_)
        | Command::Explain(_)
        | Command::Doc(_)
        | Command::Manual(_)
        | Command::Task(_)
        | Command::Completions { .. } => Format::Human,
    }
}
