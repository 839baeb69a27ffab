//! What can be said after `canbaud simulate`.

use std::path::PathBuf;

use canbaud::units::{Bitrate, Hertz};
use canbaud_sim::Span;
use clap::{Args, ValueEnum};

use crate::run::lss::Channel;

/// Arguments of `canbaud simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  canbaud simulate bus.toml                        what happened, line by line
  canbaud simulate bus.toml -q --sr bus.sr         for PulseView and sigrok-cli
  canbaud simulate bus.toml --repeat 1000 --json   statistics over seeds
  canbaud simulate bus.toml --slcan tester         the bus as an adapter on a pty
  canbaud simulate net.toml --bridge right --on vcan0 --transmit
                                                   a network for an LSS master to be tried on

Exit codes:
  0  the scenario ran as it expects          3  an expectation was not met
  2  wrong command line or scenario          5  a file cannot be read or written
With --bridge also:
  6  no permission                           7  the channel cannot be used, or is not as it was found
  128+n  ended by signal n; the channel is put back")]
pub(crate) struct SimulateArgs {
    /// Scenario file (TOML)
    #[arg(value_name = "SCENARIO")]
    pub(crate) scenario: PathBuf,

    /// Seed instead of the one of the scenario; the first one with --repeat
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,

    /// How long the run is, instead of the duration of the scenario
    #[arg(long = "for", value_name = "TIME")]
    pub(crate) duration: Option<Span>,

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

    /// Let this node of the scenario be the end of a channel (--on): what it receives is sent there,
    /// what comes from there it sends; in real time
    #[arg(long, value_name = "NODE", requires = "on",
          conflicts_with_all = ["vcd", "sr", "candump", "json", "repeat", "slcan"])]
    pub(crate) bridge: Option<String>,

    /// The channel of the bridge: vcan0, can0, slcan:/dev/ttyACM0, udp:239.74.163.2:43113
    #[arg(long, value_name = "CHANNEL", requires = "bridge")]
    pub(crate) on: Option<Channel>,

    /// Bit rate of the bridge's channel: a serial adapter is opened at it, an interface (can0) is set
    /// to it, for as long as the bridge is there
    #[arg(long, value_name = "RATE", requires = "on")]
    pub(crate) bitrate: Option<Bitrate>,

    /// Yes, transmit on the channel: without this nothing is opened
    #[arg(long, requires = "on")]
    pub(crate) transmit: bool,

    /// Whose adapter it is
    #[arg(long, value_name = "WHOSE", default_value = "lawicel", requires = "slcan")]
    pub(crate) firmware: FirmwareName,

    /// How the adapter tells bus errors [default: as its firmware does]
    #[arg(long, value_name = "HOW", requires = "slcan")]
    pub(crate) errors: Option<ErrorReports>,

    /// What comes of M1 in the firmwares of CANable
    #[arg(long, value_name = "WHAT", default_value = "honoured", requires = "slcan")]
    pub(crate) m1: SilentMode,

    /// Write every command, and everything that the adapter did to the bus; - is standard output
    #[arg(long, value_name = "FILE", requires = "slcan")]
    pub(crate) log: Option<PathBuf>,

    /// Unplug the adapter after so much time of the bus
    #[arg(long, value_name = "TIME", requires = "slcan")]
    pub(crate) unplug_after: Option<Span>,

    /// Unplug the adapter when the host was sent so many bytes
    #[arg(long, value_name = "N", requires = "slcan")]
    pub(crate) unplug_after_bytes: Option<u64>,

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

/// Whose slcan adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FirmwareName {
    /// CAN232 and CANUSB
    Lawicel,
    /// What CANable 1.x comes with: no answers, no L, silent by M1
    Canable1,
    /// Nakakiyo092/canable2-fw: answers, L, CAN FD
    Canable2,
    /// What CANable 2.0 comes with: no answers, no L, silent by M1, CAN FD
    Canable2Stock,
    /// USBtin
    Usbtin,
}

/// What comes of M1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SilentMode {
    /// The channel opens listen-only, as the README of the firmware says
    Honoured,
    /// O opens in normal mode all the same, as the source of the firmware does
    Ignored,
}
