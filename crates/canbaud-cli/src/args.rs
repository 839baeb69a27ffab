//! The command line: what can be said, and what it means.

use std::path::PathBuf;

use canbaud::units::{Bitrate, Hertz};
use canbaud::wire::Polarity;
use canbaud_capture::{Format, OpenOptions, Threshold};
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::judge::JudgeOptions;
use crate::run::live::LiveArgs;
use crate::run::timing::{ControllersArgs, TIMING_HELP, TimingArgs};
use crate::run::{AdaptersArgs, LSS_HELP, LssArgs, SimulateArgs};
use crate::values::{bus_rate, sample_rate};

const ABOUT: &str =
    "Finds the bit rate of a CAN or CAN FD bus, recorded or live, proves it, decodes it";

const EXAMPLES: &str = "\
Examples:
  canbaud detect bus.sr                     which bit rate, and how sure
  canbaud detect --json *.vcd               one JSON object a line per source and channel
  canbaud detect can0                       the same of a live bus, only listening
  canbaud decode bus.sr | grep ' can0 123#' every frame as candump log lines
  canbaud decode bus.sr --format pcapng -o bus.pcapng
  canbaud timing --clock 80M --bitrate 500k --controller m_can

Exit codes:
  0  a rate was found and proven        4  no traffic
  2  wrong command line                 5  a file cannot be read or written
  6  no permission                      7  the adapter cannot be used, or not be put back
  3  undecided, two rates in conflict, or an impossible bit timing
  128 + n  ended by signal n; whatever was changed was put back first
  With several sources: 5 before 3 before 4 before 0.";

/// Behind the help of both commands; the names are those of [`Format`].
macro_rules! formats {
    () => {
        "\
Formats, found from the content (and their names for --input-format):
  sigrok .sr (sr)            Saleae Logic 2 CSV, binary (saleae-csv, saleae-bin)
  VCD (vcd)                  Saleae Logic 1 .logicdata (logicdata)
  DSView .dsl .demo (dsl)    Saleae Logic 1 binary (logic1-8, -16, -32, -64: a word per sample;
  sigrok CSV (sigrok-csv)      logic1-changes-8, -16, -32, -64: per change)
  Tektronix .isf (isf)       oscilloscope CSV of any maker (scope-csv)"
    };
}

const DETECT_HELP: &str = concat!(
    "\
Examples:
  canbaud detect bus.sr
  canbaud detect --expected 500k bus.sr     how far the clocks are off
  canbaud detect -q captures/*              one line per file
  canbaud detect can0                       a live bus: listens only, puts the interface back
  canbaud detect slcan:/dev/ttyACM0         a serial adapter
  canbaud detect replay:bus.sr              a recording plays the bus
  canbaud detect can0 --sweep 10k..1M --timeout 5min
  canbaud detect --json bus.sr              described by schemas/detect.schema.json

Live buses:
  can0, socketcan:NAME                an interface of Linux; a file called can0 goes first
  slcan:PORT, slcan:PORT@BAUD         a serial adapter: slcan:/dev/ttyACM0, slcan:COM3@1000000
  replay:FILE, replay:FILE#CHANNEL    a recording in the place of a bus

",
    formats!()
);

const DECODE_HELP: &str = concat!(
    "\
Examples:
  canbaud decode bus.sr > bus.log           then: canplayer -I bus.log vcan0=can0
  canbaud decode --json bus.sr              described by schemas/decode.schema.json
  canbaud decode -f pcapng -o bus.pcapng bus.sr
  canbaud decode --bitrate 500k --data-bitrate 2M bus.sr
  canbaud decode --start $(stat -c %Y bus.sr) bus.sr | log2asc can0

Times are those of the edge of SOF, from the start of the capture.

",
    formats!()
);

/// Everything the user said.
#[derive(Debug, Parser)]
#[command(name = "canbaud", version, about = ABOUT, after_help = EXAMPLES)]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// Colours: auto (on a terminal, unless NO_COLOR is set), always, never
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    #[arg(hide_possible_values = true, hide_default_value = true)]
    pub(crate) color: When,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Find the bit rate and tell what is on the bus
    #[command(after_help = DETECT_HELP)]
    Detect(DetectArgs),
    /// Print every frame; the rate is detected unless given
    #[command(after_help = DECODE_HELP)]
    Decode(DecodeArgs),
    /// Bit timing and registers for a controller, or back from registers
    #[command(after_help = TIMING_HELP)]
    Timing(Box<TimingArgs>),
    /// What is known of each CAN controller
    Controllers(ControllersArgs),
    /// List the CAN adapters of this machine, and what is known of them
    Adapters(AdaptersArgs),
    /// Run a simulated bus from a scenario, to files, statistics or a virtual adapter
    Simulate(SimulateArgs),
    /// Set bit rate and node-ID of CANopen devices over the bus (CiA 305); transmits
    #[command(after_help = LSS_HELP)]
    Lss(Box<LssArgs>),
}

/// When to use colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum When {
    Auto,
    Always,
    Never,
}

/// `canbaud detect`.
#[derive(Debug, Args)]
pub(crate) struct DetectArgs {
    /// Capture files; or one live bus: can0, slcan:/dev/ttyACM0, replay:bus.sr
    #[arg(required = true, value_name = "SOURCE")]
    pub(crate) sources: Vec<PathBuf>,

    /// Print one JSON object a line per source and channel, the channel with the bus first
    #[arg(long)]
    pub(crate) json: bool,

    /// Print the verdict only, one line per source; no progress bar
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Tell how far the measured rate lies from this one
    #[arg(long, value_name = "RATE", value_parser = bus_rate)]
    pub(crate) expected: Option<Bitrate>,

    /// Files worked on at once [default: one per processor core]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,

    // Last: their headings hold for everything that follows.
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,

    #[command(flatten)]
    pub(crate) live: LiveArgs,
}

/// `canbaud decode`.
#[derive(Debug, Args)]
pub(crate) struct DecodeArgs {
    /// Capture file
    #[arg(value_name = "SOURCE")]
    pub(crate) source: PathBuf,

    /// candump (for can-utils and python-can), json (an object a line) or pcapng (for Wireshark)
    #[arg(
        short,
        long,
        value_name = "FORM",
        default_value = "candump",
        hide_possible_values = true
    )]
    pub(crate) format: FrameFormat,

    /// The same as --format json
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,

    /// Write to this file instead of the standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Tell DLC 9 to 15 of classic frames in candump lines as candump -8 does (_9 to _F); python-can
    /// does not read them
    #[arg(short = '8', long)]
    pub(crate) raw_dlc: bool,

    /// Time of the start of the capture, in s since 1970; log2asc wants at least 1
    #[arg(long, value_name = "SECONDS", default_value_t = 0,
          value_parser = clap::value_parser!(u64).range(..=9_999_999_999))]
    pub(crate) start: u64,

    /// No summary on the standard error
    #[arg(short, long)]
    pub(crate) quiet: bool,

    // Last: its heading holds for everything that follows.
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
}

/// The form of decoded frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FrameFormat {
    Candump,
    Json,
    Pcapng,
}

/// How to read a source; everything is found unless given.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Instead of finding it")]
pub(crate) struct ReadingArgs {
    /// Format of the file, by a name from below
    #[arg(long, value_name = "FORMAT")]
    pub(crate) input_format: Option<Format>,

    /// Sample rate, for files that do not hold theirs: 24M, 500k
    #[arg(long, value_name = "HZ", value_parser = sample_rate)]
    pub(crate) samplerate: Option<Hertz>,

    /// Channel that carries the bus, by its name
    #[arg(long, value_name = "NAME")]
    pub(crate) channel: Option<String>,

    /// Nominal bit rate: 500k, 83.333k, 1M
    #[arg(long, value_name = "RATE", value_parser = bus_rate)]
    pub(crate) bitrate: Option<Bitrate>,

    /// Data bit rate of CAN FD: 2M
    #[arg(long, value_name = "RATE", value_parser = bus_rate, requires = "bitrate")]
    pub(crate) data_bitrate: Option<Bitrate>,

    /// normal: high is recessive (RXD, CAN_L); inverted: high is dominant (CAN_H)
    #[arg(long, value_name = "POLARITY", hide_possible_values = true)]
    pub(crate) polarity: Option<PolarityArg>,

    /// The same as --polarity inverted
    #[arg(long, conflicts_with = "polarity")]
    pub(crate) invert: bool,

    /// Threshold of analogue channels in volts
    #[arg(long, value_name = "VOLTS", value_parser = volts, allow_negative_numbers = true)]
    pub(crate) threshold: Option<f64>,

    /// How far the voltage must pass the threshold, in volts
    #[arg(long, value_name = "VOLTS", value_parser = hysteresis, default_value = "0.1",
          requires = "threshold")]
    pub(crate) hysteresis: f64,
}

/// How the line maps to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PolarityArg {
    Normal,
    Inverted,
}

impl ReadingArgs {
    /// Whether anything was said.
    pub(crate) fn is_used(&self) -> bool {
        let Self { input_format, samplerate, channel, bitrate, polarity, invert, .. } = self;
        input_format.is_some()
            || samplerate.is_some()
            || channel.is_some()
            || bitrate.is_some()
            || polarity.is_some()
            || self.threshold.is_some()
            || *invert
    }

    /// How to open a file.
    pub(crate) fn open_options(&self) -> OpenOptions {
        OpenOptions {
            format: self.input_format,
            samplerate: self.samplerate,
            threshold: self.threshold.map(|volts| Threshold { volts, hysteresis: self.hysteresis }),
            ..OpenOptions::default()
        }
    }

    /// How to judge its channels.
    pub(crate) fn judge_options(&self) -> JudgeOptions {
        let polarity = match (self.polarity, self.invert) {
            (Some(PolarityArg::Normal), _) => Some(Polarity::Normal),
            (Some(PolarityArg::Inverted), _) | (None, true) => Some(Polarity::Inverted),
            (None, false) => None,
        };
        JudgeOptions {
            channel: self.channel.clone(),
            bitrate: self.bitrate,
            data_bitrate: self.data_bitrate,
            polarity,
        }
    }
}

fn volts(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(volts) if volts.abs() <= 1e6 => Ok(volts),
        _ => Err("a voltage from -1000000 to 1000000 is wanted, such as 2.5".to_owned()),
    }
}

fn hysteresis(text: &str) -> Result<f64, String> {
    volts(text).and_then(|volts| match volts {
        v if v >= 0.0 => Ok(v),
        _ => Err("a hysteresis is 0 V or more".to_owned()),
    })
}

#[cfg(test)]
mod tests;
