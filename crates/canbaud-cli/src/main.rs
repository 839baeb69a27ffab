//! The `canbaud` command.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod exit;
mod judge;
mod outlet;
mod output;
mod printable;
mod report;
mod run;
#[cfg(test)]
mod schema;
mod tell;
mod values;

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;

use args::{Cli, Command};
use exit::Exit;
use tell::tell;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refuse(&error).into(),
    };
    let exit = match cli.command {
        Command::Detect(args) => run::detect(&args, cli.color),
        Command::Decode(args) => run::decode(&args),
        Command::Timing(args) => run::timing(&args),
        Command::Controllers(args) => run::controllers(&args),
        Command::Adapters(args) => run::adapters(&args),
        Command::Simulate(args) => run::simulate(&args),
        Command::Lss(args) => run::lss(&args),
    };
    exit.into()
}

/// Prints what clap has to say; a file in the place of a command gets the command it needs.
fn refuse(error: &clap::Error) -> Exit {
    // A closed pipe under --help is nobody's problem.
    let _ = error.print();
    if error.kind() == ErrorKind::InvalidSubcommand {
        let given = error.get(clap::error::ContextKind::InvalidSubcommand);
        if let Some(clap::error::ContextValue::String(given)) = given
            && std::path::Path::new(given).exists()
        {
            tell!("\nhint: to find the bit rate of this file: canbaud detect {given}");
        }
    }
    if error.use_stderr() { Exit::Usage } else { Exit::Found }
}
