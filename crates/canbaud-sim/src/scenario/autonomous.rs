//! A node that finds its own way into the network, as a scenario describes it.

use canbaud::lss::{Automatic, NodeId, RateSet, RateSetting};
use canbaud::units::Bitrate;

use super::build::{Outcome, timing_for, usual_sample_point};
use super::lss;
use super::model::{AutonomousTable, ListenerName, NodeTable, SilenceTable, StartUpName};
use super::text::Text;
use crate::software::{AutonomousPlan, BreakSilence, Listening, LssPlan, StartUp};
use crate::time::Span;

/// T_cc where a scenario does not say.
const RECONFIGURATION: Span = Span::from_us(100);
/// Time between heartbeats where a scenario does not say.
const HEARTBEAT: Span = Span::from_ms(1_000);
/// How long a node that breaks the silence waits for an answer where a scenario does not say.
const HOLD: Span = Span::from_ms(100);

pub(super) fn plan(
    node: &NodeTable,
    table: &AutonomousTable,
    clock: u64,
) -> Outcome<AutonomousPlan> {
    refuse_what_software_decides(node)?;
    let allowed = |key: &str, rate: Bitrate| known(key, rate, clock);
    let rate = match node.bitrate {
        Some(rate) => RateSetting::Fixed(allowed("bitrate", rate.0)?),
        None => RateSetting::Automatic,
    };
    let start_up = match table.start_up {
        Some(StartUpName::MiniMaster) => StartUp::MiniMaster,
        Some(StartUpName::Slave) | None => StartUp::Slave,
    };
    if (start_up, rate) == (StartUp::MiniMaster, RateSetting::Automatic) {
        let what = "a mini-master (object 1F80h) needs a bitrate: with automatic detection the \
                    network would never start";
        return Err(what.into());
    }
    let listening = match table.listener {
        Some(ListenerName::Errors) | None => Listening::Errors,
        Some(ListenerName::Counter) => Listening::Counter,
        Some(ListenerName::FramesOnly) => Listening::FramesOnly,
        Some(ListenerName::Gate) => Listening::Gate,
        Some(ListenerName::None) => Listening::None,
    };
    let timer_hz = match table.timer.map(|hertz| hertz.0.hertz()) {
        None => None,
        Some(hertz @ 1_000_000..=200_000_000) => Some(hertz),
        Some(hertz) => return Err(format!("autonomous.timer is {hertz}, allowed are 1M to 200M")),
    };
    if (listening, timer_hz) == (Listening::None, None) {
        return Err("without a timer and without a listener it could never find a bitrate".into());
    }
    let node_id = match (table.node_id, node.lss.as_ref().and_then(|lss| lss.node_id)) {
        (_, Some(_)) => return Err("give autonomous.node_id instead of lss.node_id".into()),
        (None, None) => NodeId::UNCONFIGURED,
        (Some(id), None) => {
            NodeId::new(id).ok_or("autonomous.node_id: allowed are 1 to 127, and 255 for none")?
        }
    };
    let span = |span: Option<Text<Span>>| span.map(|span| span.0).filter(|s| *s > Span::ZERO);
    if node.lss.as_ref().is_some_and(|lss| lss.reconfiguration.is_some()) {
        return Err("give autonomous.reconfiguration instead of lss.reconfiguration".into());
    }
    Ok(AutonomousPlan {
        node_id,
        rate,
        remembers: table.remembers.map(|rate| allowed("remembers", rate.0)).transpose()?,
        start_up,
        listening,
        timer_hz,
        reconfiguration: table.reconfiguration.map_or(RECONFIGURATION, |span| span.0),
        silence: table.silence.as_ref().map(|table| silence(table, clock)).transpose()?,
        heartbeat: table.heartbeat.map_or(Some(HEARTBEAT), |period| span(Some(period))),
        pdo: span(table.pdo),
        sync: span(table.sync),
        lss: node.lss.as_ref().map(|table| LssPlan {
            address: lss::address(table),
            automatic: if table.automatic { Automatic::Offered } else { Automatic::Refused },
            processing: table.processing.map_or(Span::ZERO, |span| span.0),
            storage: lss::storage(table.storage),
        }),
    })
}

fn silence(table: &SilenceTable, clock: u64) -> Outcome<BreakSilence> {
    let (after, spread) = (table.after.0, table.spread.map_or(table.after.0, |span| span.0));
    if after == Span::ZERO {
        return Err("autonomous.silence.after is 0, allowed is more than 0".into());
    }
    Ok(BreakSilence {
        default: known("silence.default", table.default.0, clock)?,
        after,
        spread,
        hold: table.hold.map_or(HOLD, |span| span.0),
    })
}

/// A bit rate of the table of CiA that its clock can make.
fn known(key: &str, rate: Bitrate, clock: u64) -> Outcome<Bitrate> {
    if !RateSet::ALL.has(rate) {
        let allowed = "1M, 800k, 500k, 250k, 125k, 50k, 20k, 10k";
        return Err(format!("{key} is {rate}, allowed for an autonomous node are {allowed}"));
    }
    timing_for(clock, rate, usual_sample_point(rate)).map(|_| rate)
}

fn refuse_what_software_decides(node: &NodeTable) -> Outcome<()> {
    let given = [
        ("sample_point", node.sample_point.is_some()),
        ("sjw", node.sjw.is_some()),
        ("timing", node.timing.is_some()),
        ("data_bitrate", node.data_bitrate.is_some()),
        ("data_timing", node.data_timing.is_some()),
        ("mode", node.mode.is_some()),
        ("fd", node.fd.is_some()),
        ("fd_crc", node.fd_crc.is_some()),
        ("tdc", node.tdc.is_some()),
        ("retransmission", node.retransmission.is_some()),
        ("recovery", node.recovery.is_some()),
        ("monitoring_counters", node.monitoring_counters.is_some()),
        ("gate", node.gate.is_some()),
        ("tec", node.tec != 0),
        ("rec", node.rec != 0),
        ("autobaud", node.autobaud.is_some()),
        ("fallback", node.fallback.is_some()),
        ("reply", !node.reply.is_empty()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((key, _)) => Err(format!("{key} is decided by the software of an autonomous node")),
        None => Ok(()),
    }
}
