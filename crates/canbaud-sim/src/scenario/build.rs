//! From the tables to nodes, traffic and disturbances; says what is impossible.

use std::path::Path;

use canbaud::units::{Bitrate, Permille};
use canbaud::wire::{FdCrc, Frame, FrameKind, Id};
use toml::Spanned;

use super::expect::Expectation;
use super::model::{
    AutobaudTable, ChangeTable, CountersName, DisturbanceKind, DisturbanceTable, FdCrcName, FdName,
    File, FormatName, GateName, ModeName, NodeTable, RecoveryName, ReplyTable, RetransmissionName,
    TimingTable, TrafficKind, TrafficTable, WireName,
};
use super::{ScenarioError, line_of, lss};
use crate::bus::Transceiver;
use crate::device::{Program, Reply};
use crate::event::NodeId;
use crate::lss_device::LssSetup;
use crate::node::{
    FdSupport, Gate, Mode, MonitoringCounters, NodeConfig, Oscillator, Recovery, Retransmission,
    Tdc, Wire,
};
use crate::time::{Span, Time};
use crate::timing::BitTiming;
use crate::traffic::{Arrivals, FrameFormat, Payload, parse_candump};

/// T_cc where a scenario does not say.
const RECONFIGURATION: Span = Span::from_us(100);

/// A node of a scenario.
#[derive(Debug, Clone)]
pub(super) struct Member {
    pub(super) config: NodeConfig,
    pub(super) tec: u16,
    pub(super) rec: u16,
    pub(super) joins: Option<Time>,
    pub(super) program: Program,
    pub(super) replies: Vec<Reply>,
    pub(super) boot_up: Option<u8>,
    pub(super) lss: Option<LssSetup>,
}

/// A stream of requests of a scenario.
#[derive(Debug, Clone)]
pub(super) struct Stream {
    pub(super) node: NodeId,
    pub(super) arrivals: Arrivals,
    pub(super) format: FrameFormat,
    pub(super) payload: Payload,
    pub(super) span: (Time, Time),
}

/// A disturbance of a scenario.
#[derive(Debug, Clone)]
pub(super) struct Trouble {
    pub(super) kind: DisturbanceKind,
    pub(super) node: Option<NodeId>,
    pub(super) at: Time,
    pub(super) width: Span,
    pub(super) every: Span,
    pub(super) stop: Time,
}

/// What changes at a node, and when.
#[derive(Debug, Clone)]
pub(super) enum Change {
    Drift { ppb: i64 },
    SetUp { edit: ChangeTable, timing: Option<BitTiming> },
}

/// A scenario that can be run.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// One line.
    pub title: String,
    /// What it shows.
    pub description: String,
    /// How long it takes.
    pub duration: Span,
    /// Its seed, where none is given.
    pub seed: u64,
    pub(super) members: Vec<Member>,
    pub(super) streams: Vec<Stream>,
    pub(super) troubles: Vec<Trouble>,
    pub(super) changes: Vec<(Time, NodeId, Change)>,
    pub(super) expectations: Vec<Expectation>,
}

impl Scenario {
    /// Names of the nodes, in order.
    #[must_use]
    pub fn node_names(&self) -> Vec<String> {
        self.members.iter().map(|member| member.config.name.clone()).collect()
    }

    /// How the node of this name is set up, and its place.
    #[must_use]
    pub fn node(&self, name: &str) -> Option<(NodeId, &NodeConfig)> {
        let place = self.members.iter().position(|member| member.config.name == name)?;
        Some((NodeId(place), &self.members[place].config))
    }
}

/// What is wrong with a table; the line is added where the table is known.
pub(super) type Outcome<T> = Result<T, String>;

pub(super) fn build(name: &str, text: &str, file: &File) -> Result<Scenario, ScenarioError> {
    let at_line = |start: usize, what: String| ScenarioError {
        file: name.to_owned(),
        line: line_of(text, start),
        what,
    };
    let mut scenario = Scenario {
        title: file.title.clone(),
        description: file.description.clone(),
        duration: file.duration.0,
        seed: file.seed,
        members: Vec::new(),
        streams: Vec::new(),
        troubles: Vec::new(),
        changes: Vec::new(),
        expectations: Vec::new(),
    };
    for table in &file.node {
        let member = member(table.get_ref(), &scenario).map_err(|w| at_line(start(table), w))?;
        scenario.members.push(member);
    }
    let directory = Path::new(name).parent().unwrap_or_else(|| Path::new(""));
    for table in &file.traffic {
        let stream = stream(table.get_ref(), &scenario, directory);
        scenario.streams.push(stream.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.disturbance {
        let trouble = trouble(table.get_ref(), &scenario);
        scenario.troubles.push(trouble.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.change {
        let change = change(table.get_ref(), &scenario);
        scenario.changes.push(change.map_err(|w| at_line(start(table), w))?);
    }
    for table in &file.expect {
        let node = find(&scenario, &table.get_ref().node).map_err(|w| at_line(start(table), w))?;
        let line = line_of(text, start(table));
        scenario.expectations.push(Expectation::new(node, table.get_ref(), line));
    }
    Ok(scenario)
}

fn start<T>(table: &Spanned<T>) -> usize {
    table.span().start
}

fn find(scenario: &Scenario, name: &str) -> Outcome<NodeId> {
    scenario.node(name).map(|(id, _)| id).ok_or_else(|| {
        format!("no node \"{name}\", there are: {}", scenario.node_names().join(", "))
    })
}

fn explicit(table: &TimingTable) -> Outcome<BitTiming> {
    let TimingTable { prescaler, prop_seg, phase_seg1, phase_seg2, sjw } = *table;
    BitTiming::new(prescaler, prop_seg, phase_seg1, phase_seg2, sjw).map_err(|e| e.to_string())
}

pub(super) fn timing_for(clock: u64, rate: Bitrate, permille: u16) -> Outcome<BitTiming> {
    let sample_point = Permille::new(permille).unwrap_or_default();
    BitTiming::find(clock, rate.bits_per_second(), sample_point).map_err(|e| e.to_string())
}

/// Sample points of CANopen: 75 % at 1 Mbit/s, 80 % above 500 kbit/s, else 87.5 % [Koppe, table 1].
pub(super) fn usual_sample_point(rate: Bitrate) -> u16 {
    match rate.bits_per_second() {
        0..=500_000 => 875,
        500_001..=800_000 => 800,
        _ => 750,
    }
}

fn ppb(ppm: f64) -> Outcome<i64> {
    if (-500_000.0..=500_000.0).contains(&ppm) {
        Ok((ppm * 1_000.0).round() as i64)
    } else {
        Err(format!("ppm is {ppm}, allowed are -500000 to 500000"))
    }
}

fn member(table: &NodeTable, scenario: &Scenario) -> Outcome<Member> {
    if scenario.node(&table.name).is_some() {
        return Err(format!("there are two nodes \"{}\"", table.name));
    }
    let hertz = table.clock.map_or(80_000_000, |clock| clock.0.hertz());
    let oscillator = Oscillator { hertz, ppb: ppb(table.ppm)? };
    oscillator.check().map_err(|error| error.to_string())?;
    let (nominal, data) = timings(table, hertz)?;
    let config = NodeConfig {
        name: table.name.clone(),
        oscillator,
        nominal,
        data,
        mode: table.mode.map_or(Mode::Normal, mode),
        fd: match table.fd {
            Some(FdName::None) => FdSupport::None,
            Some(FdName::Tolerant) => FdSupport::Tolerant,
            Some(FdName::Enabled) | None => FdSupport::Enabled,
        },
        fd_crc: match table.fd_crc {
            Some(FdCrcName::NonIso) => FdCrc::NonIso,
            Some(FdCrcName::Iso) | None => FdCrc::Iso,
        },
        tdc: table.tdc.map_or(Tdc::Off, Tdc::Offset),
        retransmission: match table.retransmission {
            Some(RetransmissionName::OneShot) => Retransmission::OneShot,
            Some(RetransmissionName::Automatic) | None => Retransmission::Automatic,
        },
        recovery: match table.recovery {
            Some(RecoveryName::Manual) => Recovery::Manual,
            Some(RecoveryName::Automatic) | None => Recovery::Automatic,
        },
        monitoring_counters: match table.monitoring_counters {
            Some(CountersName::Counting) => MonitoringCounters::Counting,
            Some(CountersName::Frozen) | None => MonitoringCounters::Frozen,
        },
        gate: table.gate.map_or(Gate::Absent, gate),
        transceiver: transceiver(table),
        wire: Wire::Connected,
    };
    let program = program(table, hertz)?;
    let replies: Vec<_> = table.reply.iter().map(reply).collect::<Outcome<_>>()?;
    let boot_up = table.autobaud.as_ref().and_then(|autobaud| autobaud.boot_up);
    if boot_up.is_some_and(|id| !(1..=127).contains(&id)) {
        return Err("boot_up is a node-ID, allowed are 1 to 127".into());
    }
    let joins = table.joins.map(|span| Time::ZERO + span.0);
    let lss = match &table.lss {
        Some(_) if program != Program::Fixed || !replies.is_empty() => {
            return Err("give lss, or autobaud, fallback and reply, not both".into());
        }
        Some(lss) => Some(lss::setup(lss, table.bitrate.map(|rate| rate.0), hertz)?),
        None => None,
    };
    let (tec, rec) = (table.tec, table.rec);
    Ok(Member { config, tec, rec, joins, program, replies, boot_up, lss })
}

fn timings(table: &NodeTable, hertz: u64) -> Outcome<(BitTiming, Option<BitTiming>)> {
    let data = match (&table.data_timing, table.data_bitrate) {
        (Some(timing), None) => Some(explicit(timing)?),
        (None, Some(rate)) => Some(timing_for(hertz, rate.0, 800)?),
        (None, None) => None,
        (Some(_), Some(_)) => return Err("give data_bitrate or data_timing, not both".into()),
    };
    let nominal = match (&table.timing, table.bitrate) {
        (Some(timing), None) => return Ok((explicit(timing)?, data)),
        (None, Some(rate)) => {
            let permille = match table.sample_point {
                None => usual_sample_point(rate.0),
                Some(percent) if (1.0..=99.0).contains(&percent) => (percent * 10.0).round() as u16,
                Some(percent) => {
                    return Err(format!(
                        "sample_point is {percent}, allowed are 1 to 99 (percent)"
                    ));
                }
            };
            timing_for(hertz, rate.0, permille)?
        }
        _ => return Err(format!("node \"{}\" needs bitrate or timing", table.name)),
    };
    let nominal = match table.sjw {
        Some(sjw) => nominal.with_sjw(sjw).map_err(|error| error.to_string())?,
        None => nominal,
    };
    let same_quanta = data.and_then(|data| nominal.with_prescaler(data.prescaler()));
    Ok((same_quanta.unwrap_or(nominal), data))
}

fn transceiver(table: &NodeTable) -> Transceiver {
    let mut transceiver = Transceiver::default();
    if let Some(delay) = &table.delay {
        let fields = [
            (&mut transceiver.tx_dominant, delay.tx_dominant),
            (&mut transceiver.tx_recessive, delay.tx_recessive),
            (&mut transceiver.rx_dominant, delay.rx_dominant),
            (&mut transceiver.rx_recessive, delay.rx_recessive),
            (&mut transceiver.propagation, delay.propagation),
            (&mut transceiver.jitter, delay.jitter),
        ];
        for (field, given) in fields {
            if let Some(given) = given {
                *field = given.0;
            }
        }
    }
    transceiver
}

pub(super) const fn mode(name: ModeName) -> Mode {
    match name {
        ModeName::Normal => Mode::Normal,
        ModeName::BusMonitoring => Mode::BusMonitoring,
        ModeName::Restricted => Mode::Restricted,
        ModeName::Loopback => Mode::Loopback,
        ModeName::Disabled => Mode::Disabled,
    }
}

pub(super) const fn gate(name: GateName) -> Gate {
    match name {
        GateName::Absent => Gate::Absent,
        GateName::Open => Gate::Open,
        GateName::Closed => Gate::Closed,
    }
}

pub(super) const fn wire(name: WireName) -> Wire {
    match name {
        WireName::Connected => Wire::Connected,
        WireName::Cut => Wire::Cut,
    }
}

fn program(table: &NodeTable, hertz: u64) -> Outcome<Program> {
    let reconfiguration =
        |span: Option<super::text::Text<Span>>| span.map_or(RECONFIGURATION, |s| s.0);
    match (&table.autobaud, &table.fallback) {
        (None, None) => Ok(Program::Fixed),
        (Some(AutobaudTable { rates, reconfiguration: span, patience, .. }), None) => {
            let timings = rates
                .iter()
                .map(|rate| timing_for(hertz, rate.0, usual_sample_point(rate.0)))
                .collect::<Outcome<Vec<_>>>()?;
            if timings.is_empty() {
                return Err("autobaud.rates is empty, give at least one bit rate".into());
            }
            let reconfiguration = reconfiguration(*span);
            let patience = patience.map(|patience| patience.0);
            if patience == Some(Span::ZERO) {
                return Err("autobaud.patience is 0, allowed is more than 0".into());
            }
            Ok(Program::Autobaud { timings, reconfiguration, patience })
        }
        (None, Some(fallback)) => {
            let rate = fallback.bitrate.0;
            let timing = timing_for(hertz, rate, usual_sample_point(rate))?;
            let reconfiguration = reconfiguration(fallback.reconfiguration);
            Ok(Program::Fallback { timing, reconfiguration })
        }
        (Some(_), Some(_)) => Err("give autobaud or fallback, not both".into()),
    }
}

fn id(raw: u32, extended: bool) -> Outcome<Id> {
    let id = if extended { Id::extended(raw) } else { u16::try_from(raw).ok().and_then(Id::base) };
    let allowed = if extended { "0 to 0x1FFFFFFF" } else { "0 to 0x7FF" };
    id.ok_or_else(|| format!("id is {raw:#X}, allowed are {allowed}"))
}

fn hex(text: &str) -> Outcome<Vec<u8>> {
    let digits = text.replace([' ', '_', '.'], "");
    let bad = || format!("\"{text}\" is no data: write pairs of hexadecimal digits");
    if !digits.is_ascii() || !digits.len().is_multiple_of(2) {
        return Err(bad());
    }
    (0..digits.len() / 2)
        .map(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).map_err(|_| bad()))
        .collect()
}

fn reply(table: &ReplyTable) -> Outcome<Reply> {
    let bytes = hex(&table.data)?;
    let dlc = bytes.len() as u8;
    let frame = Frame::new(id(table.id, table.id > 0x7FF)?, FrameKind::Data, dlc, &bytes);
    let frame =
        frame.map_err(|_| format!("reply has {} bytes, allowed are 0 to 8", bytes.len()))?;
    Ok(Reply { to: id(table.to, table.to > 0x7FF)?, frame })
}

fn payload(text: Option<&str>) -> Outcome<Payload> {
    Ok(match text {
        None | Some("random") => Payload::Random,
        Some("zeros") => Payload::Zeros,
        Some("ones") => Payload::Ones,
        Some("worst-stuffing") => Payload::WorstStuffing,
        Some("counter") => Payload::Counter,
        Some(other) => match other.strip_prefix("hex:") {
            Some(bytes) => Payload::Fixed(hex(bytes)?),
            None => {
                return Err(format!(
                    "payload is \"{other}\", allowed are random, zeros, ones, worst-stuffing, \
                     counter, hex:…"
                ));
            }
        },
    })
}

fn stream(table: &TrafficTable, scenario: &Scenario, directory: &Path) -> Outcome<Stream> {
    let node = find(scenario, &table.node)?;
    let period = || {
        let span = table.period.ok_or("this kind of traffic needs a period")?.0;
        if span == Span::ZERO {
            Err("period is 0, allowed is more than 0".to_owned())
        } else {
            Ok(span)
        }
    };
    let kind = match table.format {
        None | Some(FormatName::Data) => FrameKind::Data,
        Some(FormatName::Remote) => FrameKind::Remote,
        Some(FormatName::Fd) => FrameKind::Fd { brs: false, esi: false },
        Some(FormatName::FdBrs) => FrameKind::Fd { brs: true, esi: false },
    };
    let arrivals = match table.kind {
        TrafficKind::Periodic => {
            let jitter = table.jitter.map_or(Span::ZERO, |jitter| jitter.0);
            Arrivals::Periodic { period: period()?, jitter }
        }
        TrafficKind::Poisson => Arrivals::Poisson { mean: period()? },
        TrafficKind::Burst => Arrivals::Burst { size: table.size.unwrap_or(10), period: period()? },
        TrafficKind::Single => Arrivals::Single,
        TrafficKind::Saturate => Arrivals::Saturate,
        TrafficKind::Replay => {
            let file = table.file.as_ref().ok_or("replay needs a file")?;
            let text = std::fs::read_to_string(directory.join(file))
                .map_err(|error| format!("file {file}: {error}"))?;
            Arrivals::Replay(parse_candump(&text).map_err(|error| format!("file {file}: {error}"))?)
        }
    };
    let format = FrameFormat { id: id(table.id, table.extended)?, kind, dlc: table.dlc };
    let payload = payload(table.payload.as_deref())?;
    let mut probe = crate::rng::Rng::new(0);
    payload.frame(format, 0, &mut probe).map_err(|error| error.to_string())?;
    let start = Time::ZERO + table.start.map_or(Span::ZERO, |start| start.0);
    let stop = table.stop.map_or(Time::NEVER, |stop| Time::ZERO + stop.0);
    Ok(Stream { node, arrivals, format, payload, span: (start, stop) })
}

fn trouble(table: &DisturbanceTable, scenario: &Scenario) -> Outcome<Trouble> {
    let node = table.node.as_ref().map(|name| find(scenario, name)).transpose()?;
    let local = matches!(table.kind, DisturbanceKind::RxdDominant | DisturbanceKind::RxdRecessive);
    if local && node.is_none() {
        return Err("a disturbance of RXD needs a node".into());
    }
    let glitches = table.kind == DisturbanceKind::Glitches;
    if glitches && table.every.is_none_or(|every| every.0 == Span::ZERO) {
        return Err("glitches need every, more than 0".into());
    }
    if !glitches && table.at.is_none() {
        return Err("this disturbance needs at".into());
    }
    Ok(Trouble {
        kind: table.kind,
        node,
        at: Time::ZERO + table.at.map_or(Span::ZERO, |at| at.0),
        width: table.width.0,
        every: table.every.map_or(Span::ZERO, |every| every.0),
        stop: table.stop.map_or(Time::NEVER, |stop| Time::ZERO + stop.0),
    })
}

fn change(table: &ChangeTable, scenario: &Scenario) -> Outcome<(Time, NodeId, Change)> {
    let node = find(scenario, &table.node)?;
    let at = Time::ZERO + table.at.0;
    let sets_up = table.bitrate.is_some()
        || table.mode.is_some()
        || table.gate.is_some()
        || table.wire.is_some();
    let change = match (table.ppm, sets_up) {
        (Some(ppm), false) => Change::Drift { ppb: ppb(ppm)? },
        (None, true) => {
            let hertz = scenario.members[node.0].config.oscillator.hertz;
            let timing = table
                .bitrate
                .map(|rate| timing_for(hertz, rate.0, usual_sample_point(rate.0)))
                .transpose()?;
            Change::SetUp { edit: table.clone(), timing }
        }
        (Some(_), true) => return Err("give ppm alone: other changes reset the node".into()),
        (None, false) => return Err("a change needs one of ppm, bitrate, mode, gate, wire".into()),
    };
    Ok((at, node, change))
}
