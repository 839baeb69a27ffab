//! A scenario as it is written: the tables of the TOML file, field by field.
//!
//! `docs/scenarios.md` says what each means; `schemas/scenario.schema.json` has the same in JSON
//! Schema. Both are checked against this file by a test.

use canbaud::units::{Bitrate, Hertz};
use serde::Deserialize;
use toml::Spanned;

use super::text::Text;
use crate::time::Span;

type Duration = Text<Span>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) title: String,
    #[serde(default)]
    pub(super) description: String,
    pub(super) duration: Duration,
    #[serde(default)]
    pub(super) seed: u64,
    pub(super) node: Vec<Spanned<NodeTable>>,
    #[serde(default)]
    pub(super) traffic: Vec<Spanned<TrafficTable>>,
    #[serde(default)]
    pub(super) disturbance: Vec<Spanned<DisturbanceTable>>,
    #[serde(default)]
    pub(super) change: Vec<Spanned<ChangeTable>>,
    #[serde(default)]
    pub(super) expect: Vec<Spanned<ExpectTable>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimingTable {
    pub(super) prescaler: u32,
    pub(super) prop_seg: u32,
    pub(super) phase_seg1: u32,
    pub(super) phase_seg2: u32,
    pub(super) sjw: u32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DelayTable {
    pub(super) tx_dominant: Option<Duration>,
    pub(super) tx_recessive: Option<Duration>,
    pub(super) rx_dominant: Option<Duration>,
    pub(super) rx_recessive: Option<Duration>,
    pub(super) propagation: Option<Duration>,
    pub(super) jitter: Option<Duration>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ModeName {
    Normal,
    BusMonitoring,
    Restricted,
    Loopback,
    Disabled,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FdName {
    None,
    Tolerant,
    Enabled,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FdCrcName {
    Iso,
    NonIso,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RetransmissionName {
    Automatic,
    OneShot,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RecoveryName {
    Automatic,
    Manual,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum CountersName {
    Frozen,
    Counting,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum GateName {
    Absent,
    Open,
    Closed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum WireName {
    Connected,
    Cut,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NodeTable {
    pub(super) name: String,
    pub(super) bitrate: Option<Text<Bitrate>>,
    pub(super) sample_point: Option<f64>,
    pub(super) sjw: Option<u32>,
    pub(super) timing: Option<TimingTable>,
    pub(super) data_bitrate: Option<Text<Bitrate>>,
    pub(super) data_timing: Option<TimingTable>,
    pub(super) clock: Option<Text<Hertz>>,
    #[serde(default)]
    pub(super) ppm: f64,
    pub(super) mode: Option<ModeName>,
    pub(super) fd: Option<FdName>,
    pub(super) fd_crc: Option<FdCrcName>,
    pub(super) tdc: Option<u32>,
    pub(super) retransmission: Option<RetransmissionName>,
    pub(super) recovery: Option<RecoveryName>,
    pub(super) monitoring_counters: Option<CountersName>,
    pub(super) gate: Option<GateName>,
    pub(super) delay: Option<DelayTable>,
    #[serde(default)]
    pub(super) tec: u16,
    #[serde(default)]
    pub(super) rec: u16,
    /// Off until then.
    pub(super) joins: Option<Duration>,
    pub(super) autobaud: Option<AutobaudTable>,
    pub(super) fallback: Option<FallbackTable>,
    pub(super) lss: Option<LssTable>,
    pub(super) autonomous: Option<AutonomousTable>,
    #[serde(default)]
    pub(super) reply: Vec<ReplyTable>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LssTable {
    pub(super) vendor_id: u32,
    pub(super) product_code: u32,
    pub(super) revision_number: u32,
    pub(super) serial_number: u32,
    /// None: not configured.
    pub(super) node_id: Option<u8>,
    #[serde(default = "offered")]
    pub(super) automatic: bool,
    pub(super) processing: Option<Duration>,
    pub(super) reconfiguration: Option<Duration>,
    pub(super) storage: Option<StorageName>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum StorageName {
    Works,
    Fails,
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ListenerName {
    Errors,
    Counter,
    FramesOnly,
    Gate,
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum StartUpName {
    Slave,
    MiniMaster,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AutonomousTable {
    pub(super) node_id: Option<u8>,
    pub(super) remembers: Option<Text<Bitrate>>,
    pub(super) start_up: Option<StartUpName>,
    pub(super) listener: Option<ListenerName>,
    pub(super) timer: Option<Text<Hertz>>,
    pub(super) reconfiguration: Option<Duration>,
    pub(super) silence: Option<SilenceTable>,
    pub(super) heartbeat: Option<Duration>,
    pub(super) pdo: Option<Duration>,
    pub(super) sync: Option<Duration>,
    /// Power comes up to so much later.
    pub(super) joins_spread: Option<Duration>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SilenceTable {
    pub(super) default: Text<Bitrate>,
    pub(super) after: Duration,
    pub(super) spread: Option<Duration>,
    pub(super) hold: Option<Duration>,
}

const fn offered() -> bool {
    true
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AutobaudTable {
    pub(super) rates: Vec<Text<Bitrate>>,
    pub(super) reconfiguration: Option<Duration>,
    pub(super) patience: Option<Duration>,
    pub(super) boot_up: Option<u8>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FallbackTable {
    pub(super) bitrate: Text<Bitrate>,
    pub(super) reconfiguration: Option<Duration>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ReplyTable {
    pub(super) to: u32,
    pub(super) id: u32,
    pub(super) data: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum TrafficKind {
    Periodic,
    Poisson,
    Burst,
    Single,
    Saturate,
    Replay,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FormatName {
    Data,
    Remote,
    Fd,
    FdBrs,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrafficTable {
    pub(super) node: String,
    pub(super) kind: TrafficKind,
    pub(super) period: Option<Duration>,
    pub(super) jitter: Option<Duration>,
    pub(super) size: Option<u32>,
    pub(super) start: Option<Duration>,
    pub(super) stop: Option<Duration>,
    #[serde(default)]
    pub(super) id: u32,
    #[serde(default)]
    pub(super) extended: bool,
    pub(super) format: Option<FormatName>,
    #[serde(default)]
    pub(super) dlc: u8,
    pub(super) payload: Option<String>,
    pub(super) file: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DisturbanceKind {
    Dominant,
    Recessive,
    RxdDominant,
    RxdRecessive,
    Glitches,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DisturbanceTable {
    pub(super) kind: DisturbanceKind,
    pub(super) at: Option<Duration>,
    pub(super) width: Duration,
    pub(super) node: Option<String>,
    /// For glitches: mean time from one to the next.
    pub(super) every: Option<Duration>,
    pub(super) stop: Option<Duration>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChangeTable {
    pub(super) at: Duration,
    pub(super) node: String,
    pub(super) ppm: Option<f64>,
    pub(super) bitrate: Option<Text<Bitrate>>,
    pub(super) mode: Option<ModeName>,
    pub(super) gate: Option<GateName>,
    pub(super) wire: Option<WireName>,
    pub(super) power: Option<PowerName>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PowerName {
    On,
    Off,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum StageName {
    Off,
    Detecting,
    Recovering,
    Initialising,
    PreOperational,
    Operational,
    Stopped,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum StateName {
    ErrorActive,
    ErrorPassive,
    BusOff,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExpectTable {
    pub(super) node: String,
    pub(super) received_min: Option<u64>,
    pub(super) received_max: Option<u64>,
    pub(super) transmitted_min: Option<u64>,
    pub(super) transmitted_max: Option<u64>,
    pub(super) errors_min: Option<u64>,
    pub(super) errors_max: Option<u64>,
    pub(super) dominant_max: Option<u64>,
    pub(super) bus_off_min: Option<u64>,
    pub(super) bus_off_max: Option<u64>,
    pub(super) state: Option<StateName>,
    /// The rate that the device has found in the end.
    pub(super) found: Option<Text<Bitrate>>,
    /// The device has found none.
    #[serde(default)]
    pub(super) lost: bool,
    pub(super) messages_max: Option<u64>,
    /// Where an autonomous node is in the end.
    pub(super) stage: Option<StageName>,
    /// Dominant levels of an autonomous node while it had to be silent.
    pub(super) broken_silence_max: Option<u64>,
}
