//! What can be said after `canbaud simulate`.

use std::path::PathBuf;

use canbaud::units::Hertz;
use clap::{Args, ValueEnum};

/// Arguments of `canbaud simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  canbaud simulate bus.toml                        what happened, line by line
  canbaud simulate bus.toml -q --sr bus.sr         for PulseView and sigrok-cli
  canbaud simulate bus.toml --repeat 1000 --json   statistics over seeds
  canbaud simulate bus.toml --slcan tester         the bus as an adapter on a pty

Exit codes:
  0  the scenario ran as it expects          3  an expectation was not met
  2  wrong command line or scenario          5  a file cannot be read or written")]
pub(crate) struct SimulateArgs {
    /// Scenario file (TOML)
    #[arg(value_name = "SCENARIO")]
    pub(crate) scenario: PathBuf,

    /// Seed instead of the one of the scenario; the first one with --repeat
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,

    /// Run with N seeds one after the other, on all cores, and print statistics
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..),
          conflicts_with_all = ["vcd", "sr", "candump", "slcan"])]
    pub(crate) repeat: Option<u64>,

    /// Runs at a time with --repeat [default: one per processor core]
    #[arg(short, long, value_name = "N", requires = "repeat",
          value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,

    /// Print statistics as JSON instead of the timeline
    #[arg(long)]
    pub(crate) json: bool,

    /// No timeline
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Check the law of the bus on every bit while running
    #[arg(long)]
    pub(crate) check: bool,

    /// Write the levels of the bus and of each TXD as a value change dump
    #[arg(long, value_name = "FILE")]
    pub(crate) vcd: Option<PathBuf>,

    /// Write the levels of the bus as a sigrok session
    #[arg(long, value_name = "FILE")]
    pub(crate) sr: Option<PathBuf>,

    /// Sample rate of the sigrok session
    #[arg(long, value_name = "RATE", default_value = "20M", requires = "sr")]
    pub(crate) samplerate: Hertz,

    /// Write the frames sent as a log for can-utils
    #[arg(long, value_name = "FILE")]
    pub(crate) candump: Option<PathBuf>,

    /// Offer this node of the scenario as a slcan adapter on a pty; its path is printed first
    #[arg(long, value_name = "NODE", conflicts_with_all = ["vcd", "sr", "candump", "json"])]
    pub(crate) slcan: Option<String>,

    /// How the adapter tells bus errors
    #[arg(long, value_name = "HOW", default_value = "records", requires = "slcan")]
    pub(crate) errors: ErrorReports,

    /// The bit rate of S7: 800k (lawicel) or 750k (canable)
    #[arg(long, value_name = "WHOSE", default_value = "lawicel", requires = "slcan")]
    pub(crate) dialect: DialectName,

    /// Run the bus of the adapter as fast as possible instead of in real time
    #[arg(long, requires = "slcan")]
    pub(crate) fast: bool,
}

/// How a slcan adapter tells bus errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ErrorReports {
    /// e and s records, as the kernel's slcan driver reads them, and F
    Records,
    /// F alone
    Flags,
    /// Not at all
    Silent,
}

/// Whose slcan commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DialectName {
    /// S7 is 800 kbit/s
    Lawicel,
    /// S7 is 750 kbit/s, S9 is 83.333 kbit/s
    Canable,
}
