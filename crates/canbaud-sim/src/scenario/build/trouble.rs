//! Disturbances and changes.

use super::timing::{ppb, timing_for, usual_sample_point};
use super::{Outcome, Scenario, find};
use crate::event::NodeId;
use crate::scenario::model::{ChangeTable, DisturbanceKind, DisturbanceTable, PowerName};
use crate::time::{Span, Time};
use crate::timing::BitTiming;

/// A disturbance of a scenario.
#[derive(Debug, Clone)]
pub(in crate::scenario) struct Trouble {
    pub(in crate::scenario) kind: DisturbanceKind,
    pub(in crate::scenario) node: Option<NodeId>,
    pub(in crate::scenario) at: Time,
    pub(in crate::scenario) width: Span,
    pub(in crate::scenario) every: Span,
    pub(in crate::scenario) stop: Time,
}

/// What changes at a node, and when.
#[derive(Debug, Clone)]
pub(in crate::scenario) enum Change {
    Drift {
        ppb: i64,
    },
    SetUp {
        edit: ChangeTable,
        timing: Option<BitTiming>,
    },
    /// Of an autonomous node.
    Power(Power),
}

/// Whether a device has power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scenario) enum Power {
    On,
    Off,
}

pub(super) fn trouble(table: &DisturbanceTable, scenario: &Scenario) -> Outcome<Trouble> {
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

pub(super) fn change(table: &ChangeTable, scenario: &Scenario) -> Outcome<(Time, NodeId, Change)> {
    let node = find(scenario, &table.node)?;
    let at = Time::ZERO + table.at.0;
    let sets_up = table.bitrate.is_some()
        || table.mode.is_some()
        || table.gate.is_some()
        || table.wire.is_some();
    let autonomous = scenario.members[node.0].autonomous.is_some();
    match (autonomous, table.power, table.ppm.is_some() || sets_up) {
        (true, Some(PowerName::On), false) => return Ok((at, node, Change::Power(Power::On))),
        (true, Some(PowerName::Off), false) => return Ok((at, node, Change::Power(Power::Off))),
        (true, ..) => return Err("of an autonomous node only power can be changed".into()),
        (false, Some(_), _) => {
            return Err("power is of autonomous nodes; others have mode = \"disabled\"".into());
        }
        (false, None, _) => {}
    }
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
