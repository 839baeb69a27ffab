//! The `canbaud` command.

mod run;

use std::process::ExitCode;

use clap::Parser;

/// Finds the bit rate of a CAN bus, proves it, and never disturbs the bus
#[derive(Debug, Parser)]
#[command(name = "canbaud", version)]
enum Cli {
    /// Simulate a bus bit by bit
    Simulate(run::simulate::SimulateArgs),
}

fn main() -> ExitCode {
    match Cli::parse() {
        Cli::Simulate(args) => run::simulate::run(&args),
    }
}
