//! What can be said after `canbaud lss`.

use std::time::Duration;

use canbaud::lss::{LssAddress, NodeId, Strategy};
use canbaud::units::{Bitrate, Micros};
use clap::{Args, Subcommand, ValueEnum};

use super::channel::Channel;
use super::parse::{TableIndex, address, node_id, table_index};
use crate::values::{answer_time, bus_rate, pause, switch_delay, wait};

pub(crate) const LSS_HELP: &str = "\
Examples:
  canbaud lss scan --on can0 --transmit
  canbaud lss scan --on can0 --transmit --assign 10 --store
  canbaud lss inquire --on /dev/ttyACM0 --bitrate 250k --transmit
  canbaud lss set-bitrate 500k --on can0 --transmit --store --activate 1s
  canbaud lss auto --on can0 --dry-run

An LSS master transmits (identifier 7E5h) and must be the only one on its bus. A channel is an
interface of Linux in normal mode (can0, vcan0), a serial adapter (slcan:/dev/ttyACM0,
slcan:COM3@1000000), or udp:GROUP:PORT (python-can's udp_multicast). docs/lss.md is the guide.

Exit codes:
  0  done                                   4  no device answered
  2  wrong command line                     6  no permission for the channel
  3  a device refused, or answers           7  the channel cannot be used, or put back
     contradict each other                  128 and the number of a signal: interrupted";

/// `canbaud lss`.
#[derive(Debug, Args)]
pub(crate) struct LssArgs {
    #[command(subcommand)]
    pub(crate) action: LssAction,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum LssAction {
    /// Find devices without node-ID, one after another (fastscan)
    Scan(ScanArgs),
    /// Ask a device for its address and node-ID
    Inquire(InquireArgs),
    /// Set the node-ID of a device
    SetNodeId(SetNodeIdArgs),
    /// Set the bit rate of a device, to be activated afterwards
    SetBitrate(SetBitrateArgs),
    /// Let all devices switch to what was set, and go along
    Activate(ActivateArgs),
    /// Let a device keep what was set
    Store(StoreArgs),
    /// Let a device find the bit rate by itself (index 9), and wait until it is back
    Auto(AutoArgs),
    /// Be devices for a master to be tried against
    Serve(ServeArgs),
}

impl LssAction {
    pub(super) const fn line(&self) -> &LineArgs {
        match self {
            Self::Scan(args) => &args.line,
            Self::Inquire(args) => &args.line,
            Self::SetNodeId(args) => &args.line,
            Self::SetBitrate(args) => &args.line,
            Self::Activate(args) => &args.line,
            Self::Store(args) => &args.line,
            Self::Auto(args) => &args.line,
            Self::Serve(args) => &args.line,
        }
    }
}

/// The channel, and leave to transmit on it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Channel")]
pub(crate) struct LineArgs {
    /// can0, slcan:/dev/ttyACM0@115200, udp:239.74.163.2:43113
    #[arg(long, value_name = "CHANNEL")]
    pub(crate) on: Channel,

    /// Bit rate of the channel. A serial adapter needs it; an interface of Linux is set to it and put
    /// back afterwards [default: as the interface is set up]
    #[arg(long = "bitrate", value_name = "RATE", value_parser = bus_rate)]
    pub(crate) own_bitrate: Option<Bitrate>,

    /// Yes, transmit: without this nothing is opened
    #[arg(long, conflicts_with = "dry_run")]
    pub(crate) transmit: bool,

    /// Show the frames, open nothing
    #[arg(long)]
    pub(crate) dry_run: bool,

    /// How long an answer may take
    #[arg(long, value_name = "TIME", default_value = "500ms", value_parser = answer_time)]
    pub(crate) timeout: Micros,

    /// Pause between two frames
    #[arg(long, value_name = "TIME", default_value = "1ms", value_parser = pause)]
    pub(crate) inhibit: Micros,

    /// Print one JSON object a line: per device, per thing done, per frame of a dry run
    #[arg(long)]
    pub(crate) json: bool,
}

/// Which device.
#[derive(Debug, Args)]
pub(crate) struct DeviceArgs {
    /// Vendor-ID, product code, revision and serial number, hexadecimal: 29C:1:10002:1267. Without
    /// it there must be one device alone on the bus
    #[arg(long, value_name = "V:P:R:S", value_parser = address)]
    pub(crate) address: Option<LssAddress>,
}

/// `scan`.
#[derive(Debug, Args)]
pub(crate) struct ScanArgs {
    /// Give the devices node-IDs from this one on
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u8).range(1..=127))]
    pub(crate) assign: Option<u8>,

    /// Let them keep these
    #[arg(long, requires = "assign")]
    pub(crate) store: bool,

    /// Stop after so many devices
    #[arg(long, value_name = "N", default_value_t = 127,
          value_parser = clap::value_parser!(u8).range(1..=127))]
    pub(crate) max: u8,

    /// Addresses to try first
    #[arg(long, value_name = "V:P:R:S", value_parser = address)]
    pub(crate) known: Vec<LssAddress>,

    /// document: bit by bit, 133 requests, for devices that know no other order
    #[arg(long, value_name = "NAME", default_value = "adaptive", hide_possible_values = true)]
    pub(crate) strategy: StrategyName,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// The order of questions of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StrategyName {
    Adaptive,
    Document,
}

impl From<StrategyName> for Strategy {
    fn from(name: StrategyName) -> Self {
        match name {
            StrategyName::Adaptive => Self::Adaptive,
            StrategyName::Document => Self::Document,
        }
    }
}

/// `inquire`.
#[derive(Debug, Args)]
pub(crate) struct InquireArgs {
    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `set-node-id`.
#[derive(Debug, Args)]
pub(crate) struct SetNodeIdArgs {
    /// 1 to 127, or 255: none
    #[arg(value_name = "ID", value_parser = node_id)]
    pub(crate) node_id: NodeId,

    /// Let the device keep it
    #[arg(long)]
    pub(crate) store: bool,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `set-bitrate`.
#[derive(Debug, Args)]
pub(crate) struct SetBitrateArgs {
    /// 1M, 800k, 500k, 250k, 125k, 50k, 20k, 10k, auto, or an index of the table as it is: index:5
    #[arg(value_name = "RATE", value_parser = table_index, required_unless_present = "table")]
    pub(crate) rate: Option<TableIndex>,

    /// A bit timing table of the manufacturer instead of that of CiA
    #[arg(long, value_name = "N", requires = "index", conflicts_with = "rate",
          value_parser = clap::value_parser!(u8).range(128..=255))]
    pub(crate) table: Option<u8>,

    /// The index in that table
    #[arg(long, value_name = "M", requires = "table")]
    pub(crate) index: Option<u8>,

    /// The bit rate that it stands for, for the own channel to go along to with --activate
    #[arg(long, value_name = "RATE", requires = "table")]
    pub(crate) to: Option<Bitrate>,

    /// Let the device keep it
    #[arg(long)]
    pub(crate) store: bool,

    /// Activate it in this device alone, with this switch delay, and go along
    #[arg(long, value_name = "TIME", value_parser = switch_delay)]
    pub(crate) activate: Option<u16>,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `activate`.
#[derive(Debug, Args)]
pub(crate) struct ActivateArgs {
    /// Switch delay, longer than the slowest device takes to process a command
    #[arg(long, value_name = "TIME", default_value = "1s", value_parser = switch_delay)]
    pub(crate) delay: u16,

    /// Bit rate of the own channel afterwards, which an interface keeps; without it, it stays
    #[arg(long, value_name = "RATE", value_parser = bus_rate)]
    pub(crate) to: Option<Bitrate>,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `store`.
#[derive(Debug, Args)]
pub(crate) struct StoreArgs {
    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `auto`.
#[derive(Debug, Args)]
pub(crate) struct AutoArgs {
    /// Let the device keep it, too
    #[arg(long)]
    pub(crate) store: bool,

    /// Switch delay
    #[arg(long, value_name = "TIME", default_value = "1s", value_parser = switch_delay)]
    pub(crate) delay: u16,

    /// How long to wait for the device to be back
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = wait)]
    pub(crate) wait: Duration,

    #[command(flatten)]
    pub(crate) device: DeviceArgs,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}

/// `serve`.
#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Address of the first device; the others have the serial numbers behind
    #[arg(long, value_name = "V:P:R:S", value_parser = address)]
    pub(crate) address: LssAddress,

    /// How many devices
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u8).range(1..=127))]
    pub(crate) count: u8,

    /// Node-ID of the first device; the others have those behind [default: none]
    #[arg(long, value_name = "ID", value_parser = node_id)]
    pub(crate) node_id: Option<NodeId>,

    /// How long a device takes to answer
    #[arg(long, value_name = "TIME", default_value = "0ms", value_parser = pause)]
    pub(crate) latency: Micros,

    /// The devices cannot store
    #[arg(long)]
    pub(crate) no_storage: bool,

    /// End after this time [default: when interrupted]
    #[arg(long = "for", value_name = "TIME", value_parser = wait)]
    pub(crate) duration: Option<Duration>,

    #[command(flatten)]
    pub(crate) line: LineArgs,
}
