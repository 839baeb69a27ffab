//! What can be said to `canbaud timing` and `canbaud controllers`.

use canbaud::timing::{Request, SamplePointPolicy, SjwPolicy};
use canbaud::units::{Bitrate, Hertz, Permille};
use clap::{Args, ValueEnum};

use crate::values::bus_rate;

/// Behind the help of `canbaud timing`.
pub(crate) const TIMING_HELP: &str = "\
Examples:
  canbaud timing --clock 80M --bitrate 500k --controller m_can
  canbaud timing --clock 40M --bitrate 500k --data-bitrate 2M --controller mcp251xfd
  canbaud timing --clock 16M --bitrate 250k --all          every controller, a line each
  canbaud timing --clock 8M --bitrate 125k --length 400m --ppm 100 --controller sja1000
  canbaud timing --clock 8M --controller mcp2515 --decode 0x01,0xB8,0x05
  canbaud timing --clock 20M --controller c167 --autobaud-table --sample-point 80% --sjw 1
  canbaud timing --table ap2925

The clock is the one that the data sheet starts from (canbaud controllers names it): for an SJA1000
or MCP2515 the crystal, not half of it. Without --controller the setting is one that any
ISO 11898-1 controller can hold.

Exit codes: 0 an answer, 2 wrong command line, 3 impossible (with the nearest reachable rate).";

/// `canbaud timing`.
#[derive(Debug, Args)]
pub(crate) struct TimingArgs {
    /// Clock of the controller: 80M, 16.666667MHz
    #[arg(long, value_name = "HZ")]
    pub(super) clock: Option<Hertz>,

    /// Bit rate: 500k, 83.333k, 1M
    #[arg(long, value_name = "RATE", value_parser = bus_rate)]
    pub(super) bitrate: Option<Bitrate>,

    /// Bit rate of the CAN FD data phase: 2M
    #[arg(long, value_name = "RATE", value_parser = bus_rate, requires = "bitrate")]
    pub(super) data_bitrate: Option<Bitrate>,

    /// Bit rate of the CAN XL data phase: 10M
    #[arg(long, value_name = "RATE", value_parser = bus_rate, requires = "bitrate")]
    pub(super) xl_bitrate: Option<Bitrate>,

    /// Sample point: 80% [default: 87.5% up to 500k, 80% up to 800k, 75% above]
    #[arg(long, value_name = "PERCENT", value_parser = sample_point)]
    pub(super) sample_point: Option<Permille>,

    /// Sample point of the data phases
    #[arg(long, value_name = "PERCENT", value_parser = sample_point)]
    pub(super) data_sample_point: Option<Permille>,

    /// nearest, not-later or not-earlier than the sample point
    #[arg(long, value_name = "POLICY", default_value = "nearest", hide_possible_values = true)]
    pub(super) policy: Policy,

    /// Prefer equal sample points in all phases
    #[arg(long)]
    pub(super) equal_sample_points: bool,

    /// Synchronization jump width in time quanta, or largest
    #[arg(long, value_name = "N", default_value = "largest", value_parser = sjw)]
    pub(super) sjw: SjwPolicy,

    /// Largest accepted bit rate error in ppm
    #[arg(long, value_name = "PPM", default_value_t = Request::DEFAULT_TOLERANCE_PPM)]
    pub(super) tolerance: u32,

    /// Controller, as canbaud controllers lists it
    #[arg(long, short, value_name = "NAME")]
    pub(super) controller: Option<String>,

    /// Every controller, a line each
    #[arg(long, conflicts_with_all = ["controller", "decode"])]
    pub(super) all: bool,

    /// Fixed division between clock and prescaler instead of the controller's own (C167 with
    /// CPS: 1, DS80C390: CCD)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) clock_divider: Option<u16>,

    /// How many settings to list
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u8).range(1..=20))]
    pub(super) count: u8,

    /// Turn registers back into a bit rate: words in the order of canbaud controllers, or NAME=WORD
    #[arg(long, value_name = "REGISTERS", requires = "controller")]
    pub(super) decode: Option<String>,

    /// Print a table of the source documents: ap2925, canopen or ds80c390
    #[arg(long, value_name = "NAME", hide_possible_values = true)]
    #[arg(conflicts_with_all = ["bitrate", "decode", "all", "autobaud_table"])]
    pub(super) table: Option<TableName>,

    /// Print which timer counts mean which bit rate, with the registers for each
    #[arg(long, conflicts_with_all = ["bitrate", "decode", "all"])]
    pub(super) autobaud_table: bool,

    /// Bit rates of the autobaud table
    #[arg(
        long,
        value_name = "RATES",
        value_delimiter = ',',
        value_parser = bus_rate,
        requires = "autobaud_table",
        default_value = "1M,500k,250k,125k,50k",
        num_args = 1
    )]
    pub(super) rates: Vec<Bitrate>,

    /// Clock of the timer of the autobaud table [default: --clock]
    #[arg(long, value_name = "HZ", requires = "autobaud_table")]
    pub(super) timer: Option<Hertz>,

    /// How many ticks a count may be off [default: an eighth of a bit, at most half way to the
    /// neighbour]
    #[arg(long, value_name = "TICKS", requires = "autobaud_table")]
    pub(super) deviation: Option<u32>,

    /// One JSON object, described by schemas/timing.schema.json
    #[arg(long)]
    pub(super) json: bool,

    // Last: its heading holds for everything that follows.
    #[command(flatten)]
    pub(super) bus: BusArgs,
}

/// The bus that a setting must suit.
#[derive(Debug, Args)]
#[command(next_help_heading = "The bus")]
pub(crate) struct BusArgs {
    /// Length between the two farthest nodes: 40m
    #[arg(long, value_name = "METRES", value_parser = length)]
    pub(super) length: Option<u32>,

    /// How far each clock may be off, in ppm
    #[arg(long, value_name = "PPM", value_parser = ppm)]
    pub(super) ppm: Option<u32>,

    /// Delay through a node, out and in: 250ns
    #[arg(long, value_name = "NS", default_value = "250ns", value_parser = nanoseconds)]
    pub(super) node_delay: u32,

    /// Delay of the cable per metre in ps
    #[arg(long, value_name = "PS", default_value_t = 5_000,
          value_parser = clap::value_parser!(u32).range(3_000..=20_000))]
    pub(super) cable_delay: u32,
}

/// `canbaud controllers`.
#[derive(Debug, Args)]
pub(crate) struct ControllersArgs {
    /// Everything known of this one
    #[arg(value_name = "NAME")]
    pub(super) name: Option<String>,

    /// One JSON object, described by schemas/timing.schema.json
    #[arg(long)]
    pub(super) json: bool,
}

/// Where the sample point may lie beside the one asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Policy {
    Nearest,
    NotLater,
    NotEarlier,
}

impl From<Policy> for SamplePointPolicy {
    fn from(policy: Policy) -> Self {
        match policy {
            Policy::Nearest => Self::Nearest,
            Policy::NotLater => Self::NotLater,
            Policy::NotEarlier => Self::NotEarlier,
        }
    }
}

/// A table of the source documents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum TableName {
    Ap2925,
    Canopen,
    Ds80c390,
}

fn sample_point(text: &str) -> Result<Permille, String> {
    const RANGE: &str = "allowed: 1% to 99.9%";
    let Some(number) = text.strip_suffix('%') else {
        let suggestion = match text.parse::<f64>() {
            Ok(share) if share > 0.0 && share < 1.0 => share * 100.0,
            Ok(permille) if (100.0..1_000.0).contains(&permille) => permille / 10.0,
            Ok(percent) if (1.0..100.0).contains(&percent) => percent,
            _ => return Err(format!("a sample point is written as 80% ({RANGE})")),
        };
        return Err(format!("the percent sign is missing: {suggestion}% ({RANGE})"));
    };
    let percent: f64 = number.trim().parse().map_err(|_| format!("no number ({RANGE})"))?;
    let permille = percent * 10.0;
    if !(10.0..=999.0).contains(&permille) || (permille - permille.round()).abs() > 1e-6 {
        return Err(format!("outside the range or finer than 0.1% ({RANGE})"));
    }
    Permille::new(permille.round() as u16).ok_or_else(|| RANGE.to_owned())
}

fn sjw(text: &str) -> Result<SjwPolicy, String> {
    match (text, text.parse::<u16>()) {
        ("largest", _) => Ok(SjwPolicy::Largest),
        (_, Ok(quanta @ 1..=128)) => Ok(SjwPolicy::Exactly(quanta)),
        _ => Err("a number of time quanta from 1 to 128, or largest".to_owned()),
    }
}

fn length(text: &str) -> Result<u32, String> {
    match text.strip_suffix('m').unwrap_or(text).trim().parse() {
        Ok(metres @ 0..=100_000) => Ok(metres),
        _ => Err("whole metres from 0m to 100000m".to_owned()),
    }
}

fn ppm(text: &str) -> Result<u32, String> {
    match text.strip_suffix("ppm").unwrap_or(text).trim().parse() {
        Ok(ppm @ 1..=50_000) => Ok(ppm),
        _ => Err("a clock tolerance from 1 to 50000 ppm".to_owned()),
    }
}

fn nanoseconds(text: &str) -> Result<u32, String> {
    match text.strip_suffix("ns").unwrap_or(text).trim().parse() {
        Ok(nanoseconds @ 0..=100_000) => Ok(nanoseconds),
        _ => Err("a delay from 0ns to 100000ns".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_points_need_their_percent_sign() {
        assert_eq!(sample_point("87.5%"), Ok(Permille::new(875).unwrap()));
        for wrong in ["80", "0.8", "800"] {
            let error = sample_point(wrong).unwrap_err();
            assert_eq!(error, "the percent sign is missing: 80% (allowed: 1% to 99.9%)");
        }
        for wrong in ["", "%", "eighty", "0%", "100%", "-5%", "nan%", "80.55%", "1e9%"] {
            assert!(sample_point(wrong).unwrap_err().contains("1% to 99.9%"), "{wrong}");
        }
    }

    #[test]
    fn lengths_delays_and_tolerances_say_their_range() {
        assert_eq!((length("40m"), length("40"), ppm("100ppm")), (Ok(40), Ok(40), Ok(100)));
        assert_eq!(nanoseconds("250ns"), Ok(250));
        assert!(length("4km").unwrap_err().contains("100000m"));
        assert!(ppm("0").unwrap_err().contains("50000"));
        assert!(nanoseconds("-1ns").unwrap_err().contains("100000ns"));
        assert!(sjw("0").unwrap_err().contains("1 to 128"));
    }
}
