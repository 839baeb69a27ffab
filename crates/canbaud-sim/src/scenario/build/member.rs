//! Nodes and their software.

use canbaud::lss::RateSetting;
use canbaud::wire::{FdCrc, Frame, FrameKind};

use super::timing::{ppb, timing_for, timings, usual_sample_point};
use super::traffic::{hex, id};
use super::{Outcome, Scenario};
use crate::bus::Transceiver;
use crate::device::{Program, Reply};
use crate::lss_device::LssSetup;
use crate::node::{
    FdSupport, Gate, Mode, MonitoringCounters, NodeConfig, Oscillator, Recovery, Retransmission,
    Tdc, Wire,
};
use crate::scenario::model::{
    AutobaudTable, CountersName, FdCrcName, FdName, GateName, ModeName, NodeTable, RecoveryName,
    ReplyTable, RetransmissionName, WireName,
};
use crate::scenario::text::Text;
use crate::scenario::{autonomous, lss};
use crate::software::AutonomousPlan;
use crate::time::{Span, Time};
use crate::timing::BitTiming;

/// T_cc where a scenario does not say.
const RECONFIGURATION: Span = Span::from_us(100);

/// A node of a scenario.
#[derive(Debug, Clone)]
pub(in crate::scenario) struct Member {
    pub(in crate::scenario) config: NodeConfig,
    pub(in crate::scenario) tec: u16,
    pub(in crate::scenario) rec: u16,
    pub(in crate::scenario) joins: Option<Time>,
    pub(in crate::scenario) program: Program,
    pub(in crate::scenario) replies: Vec<Reply>,
    pub(in crate::scenario) boot_up: Option<u8>,
    pub(in crate::scenario) lss: Option<LssSetup>,
    pub(in crate::scenario) autonomous: Option<AutonomousPlan>,
    /// Power comes up to so much later than `joins`.
    pub(in crate::scenario) joins_spread: Span,
}

pub(super) fn member(table: &NodeTable, scenario: &Scenario) -> Outcome<Member> {
    if scenario.node(&table.name).is_some() {
        return Err(format!("there are two nodes \"{}\"", table.name));
    }
    let hertz = table.clock.map_or(80_000_000, |clock| clock.0.hertz());
    let oscillator = Oscillator { hertz, ppb: ppb(table.ppm)? };
    oscillator.check().map_err(|error| error.to_string())?;
    let autonomous = table.autonomous.as_ref();
    let autonomous = autonomous.map(|plan| autonomous::plan(table, plan, hertz)).transpose()?;
    let (nominal, data) = match autonomous {
        Some(_) => (out_of_reset(hertz)?, None),
        None => timings(table, hertz)?,
    };
    let config = NodeConfig {
        name: table.name.clone(),
        oscillator,
        nominal,
        data,
        mode: match autonomous {
            Some(_) => Mode::Disabled,
            None => table.mode.map_or(Mode::Normal, mode),
        },
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
        Some(_) if autonomous.is_some() => None,
        Some(_) if program != Program::Fixed || !replies.is_empty() => {
            return Err("give lss, or autobaud, fallback and reply, not both".into());
        }
        Some(lss) => Some(lss::setup(lss, table.bitrate.map(|rate| rate.0), hertz)?),
        None => None,
    };
    let (tec, rec) = (table.tec, table.rec);
    let joins_spread = table.autonomous.as_ref().and_then(|table| table.joins_spread);
    let joins_spread = joins_spread.map_or(Span::ZERO, |span| span.0);
    Ok(Member { config, tec, rec, joins, program, replies, boot_up, lss, autonomous, joins_spread })
}

/// Any timing that a clock of `hertz` can make: the software will set another.
fn out_of_reset(hertz: u64) -> Outcome<BitTiming> {
    let rates = canbaud::lss::TABLE.iter().rev();
    let rates = rates.filter_map(|row| row.setting.and_then(RateSetting::bitrate));
    let mut timings = rates.map(|rate| timing_for(hertz, rate, usual_sample_point(rate)));
    let found = timings.find_map(Result::ok);
    found.ok_or_else(|| format!("a clock of {hertz} Hz can make no bit rate of CANopen"))
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

pub(in crate::scenario) const fn mode(name: ModeName) -> Mode {
    match name {
        ModeName::Normal => Mode::Normal,
        ModeName::BusMonitoring => Mode::BusMonitoring,
        ModeName::Restricted => Mode::Restricted,
        ModeName::Loopback => Mode::Loopback,
        ModeName::Disabled => Mode::Disabled,
    }
}

pub(in crate::scenario) const fn gate(name: GateName) -> Gate {
    match name {
        GateName::Absent => Gate::Absent,
        GateName::Open => Gate::Open,
        GateName::Closed => Gate::Closed,
    }
}

pub(in crate::scenario) const fn wire(name: WireName) -> Wire {
    match name {
        WireName::Connected => Wire::Connected,
        WireName::Cut => Wire::Cut,
    }
}

fn program(table: &NodeTable, hertz: u64) -> Outcome<Program> {
    let reconfiguration = |span: Option<Text<Span>>| span.map_or(RECONFIGURATION, |s| s.0);
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

fn reply(table: &ReplyTable) -> Outcome<Reply> {
    let bytes = hex(&table.data)?;
    let dlc = bytes.len() as u8;
    let frame = Frame::new(id(table.id, table.id > 0x7FF)?, FrameKind::Data, dlc, &bytes);
    let frame =
        frame.map_err(|_| format!("reply has {} bytes, allowed are 0 to 8", bytes.len()))?;
    Ok(Reply { to: id(table.to, table.to > 0x7FF)?, frame })
}
