//! The star point is the AND of all that drive it, and each node samples what came to it.

use std::collections::VecDeque;

use canbaud::wire::Level;

use super::Findings;
use crate::bus::Transceiver;
use crate::event::{Disturbance, NodeId, Sample};
use crate::node::{Gate, Mode, NodeConfig};
use crate::time::Time;

/// A driver: where it is, and where it will be.
#[derive(Debug, Default)]
struct Driver {
    dominant: bool,
    coming: VecDeque<(Time, bool)>,
}

/// What one node hears.
#[derive(Debug)]
struct Ear {
    transceiver: Transceiver,
    hears_itself: bool,
    hears_bus: bool,
    forced: Option<Level>,
    /// Edges at the star point that have not come in; arrivals without jitter.
    coming: VecDeque<(Time, Level)>,
    level: Level,
    /// Until then jitter leaves the level open.
    open_until: Time,
}

impl Ear {
    fn new(config: &NodeConfig, level: Level) -> Self {
        let connected = config.wire == crate::node::Wire::Connected;
        let hears_bus = connected && !matches!(config.mode, Mode::Loopback | Mode::Disabled);
        Self {
            transceiver: config.transceiver,
            hears_itself: matches!(config.mode, Mode::BusMonitoring | Mode::Loopback)
                || config.gate != Gate::Absent,
            hears_bus,
            forced: None,
            coming: VecDeque::new(),
            level: if hears_bus { level } else { Level::Recessive },
            open_until: Time::ZERO,
        }
    }

    fn edge(&mut self, at: Time, to: Level) {
        if !self.hears_bus {
            return;
        }
        let delay = match to {
            Level::Dominant => self.transceiver.rx_dominant,
            Level::Recessive => self.transceiver.rx_recessive,
        };
        let arrival = at + delay + self.transceiver.propagation;
        // A pulse shorter than the asymmetry never comes in.
        match self.coming.back() {
            Some(&(before, _)) if before >= arrival => {
                self.coming.pop_back();
            }
            Some(_) | None => self.coming.push_back((arrival, to)),
        }
    }

    /// The level at `time`; `None` while jitter leaves it open.
    fn level_at(&mut self, time: Time) -> Option<Level> {
        let jitter = self.transceiver.jitter;
        while let Some(&(arrival, to)) = self.coming.front().filter(|(at, _)| *at <= time + jitter)
        {
            self.coming.pop_front();
            self.level = to;
            self.open_until = arrival + jitter;
        }
        (jitter.femtoseconds() == 0 || time > self.open_until).then_some(self.level)
    }
}

/// Checks levels at the star point and at every sample.
#[derive(Debug)]
pub(super) struct Wire {
    transceivers: Vec<Transceiver>,
    nodes: Vec<Driver>,
    ears: Vec<Ear>,
    disturbing: i64,
    shorts: i64,
    disturbed_at: Option<Time>,
    /// When the bus changed last, and whether several drivers changed then.
    crowded_at: Time,
    crowded: bool,
    bus: Level,
    bits: u64,
}

impl Wire {
    pub(super) fn new(configs: &[NodeConfig]) -> Self {
        Self {
            transceivers: configs.iter().map(|config| config.transceiver).collect(),
            nodes: configs.iter().map(|_| Driver::default()).collect(),
            ears: configs.iter().map(|config| Ear::new(config, Level::Recessive)).collect(),
            disturbing: 0,
            shorts: 0,
            disturbed_at: None,
            crowded_at: Time::NEVER,
            crowded: false,
            bus: Level::Recessive,
            bits: 0,
        }
    }

    pub(super) const fn bits(&self) -> u64 {
        self.bits
    }

    fn wired_and(&mut self, now: Time) -> Level {
        let mut dominant = self.disturbing > 0;
        for node in &mut self.nodes {
            while let Some(&(_, to)) = node.coming.front().filter(|(at, _)| *at <= now) {
                node.coming.pop_front();
                node.dominant = to;
            }
            dominant |= node.dominant;
        }
        if dominant && self.shorts == 0 { Level::Dominant } else { Level::Recessive }
    }

    /// Nothing may have changed at the star point strictly before `now` without being told.
    fn settle_before(&mut self, now: Time, findings: &mut Findings) {
        let due = self.nodes.iter().any(|n| n.coming.front().is_some_and(|(at, _)| *at < now));
        if due {
            let just_before = now - crate::time::Span::from_fs(1);
            let want = self.wired_and(just_before);
            if want != self.bus {
                let what = format!("stays {:?} where all drivers make {want:?}", self.bus);
                findings.add(now, None, what);
                self.bus = want;
            }
        }
    }

    pub(super) fn bus(&mut self, at: Time, level: Level, findings: &mut Findings) {
        self.settle_before(at, findings);
        // Where several drivers change in this same femtosecond, the bus may blink in between.
        let changing = self.nodes.iter().filter(|n| n.coming.iter().any(|(t, _)| *t == at)).count();
        let want = self.wired_and(at);
        if self.crowded_at != at {
            self.crowded_at = at;
            self.crowded = changing > 1 || self.disturbed_at == Some(at);
        }
        if want != level && !self.crowded {
            findings.add(at, None, format!("is {level:?} where all drivers make {want:?}"));
        }
        self.bus = level;
        for ear in &mut self.ears {
            ear.edge(at, level);
        }
    }

    pub(super) fn txd(&mut self, at: Time, node: NodeId, level: Level, findings: &mut Findings) {
        self.settle_before(at, findings);
        let transceiver = &self.transceivers[node.0];
        let delay = match level {
            Level::Dominant => transceiver.tx_dominant,
            Level::Recessive => transceiver.tx_recessive,
        };
        let arrival = at + delay + transceiver.propagation;
        let coming = &mut self.nodes[node.0].coming;
        match coming.back() {
            Some(&(before, _)) if before >= arrival => {
                coming.pop_back();
            }
            Some(_) | None => coming.push_back((arrival, level == Level::Dominant)),
        }
    }

    pub(super) fn disturbed(
        &mut self,
        at: Time,
        disturbance: Disturbance,
        findings: &mut Findings,
    ) {
        self.settle_before(at, findings);
        self.disturbed_at = Some(at);
        match disturbance {
            Disturbance::Driven(Level::Dominant) => self.disturbing += 1,
            Disturbance::Driven(Level::Recessive) => self.disturbing -= 1,
            Disturbance::Shorted => self.shorts += 1,
            Disturbance::Unshorted => self.shorts -= 1,
            Disturbance::ForcedRxd(node, level) => self.ears[node.0].forced = level,
        }
    }

    pub(super) fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        self.transceivers[node.0] = config.transceiver;
        let driver = &mut self.nodes[node.0];
        // Whatever it drove is gone at once.
        driver.coming.clear();
        if driver.dominant {
            driver.coming.push_back((at, false));
        }
        self.ears[node.0] = Ear::new(config, self.bus);
    }

    pub(super) fn sample(
        &mut self,
        at: Time,
        node: NodeId,
        sample: &Sample,
        findings: &mut Findings,
    ) {
        self.bits += 1;
        let ear = &mut self.ears[node.0];
        let mut want = ear.level_at(at);
        if ear.forced.is_some() {
            want = ear.forced;
        }
        if ear.hears_itself && sample.driven == Level::Dominant {
            want = Some(Level::Dominant);
        }
        if want.is_some_and(|want| want != sample.level) {
            let what = format!("samples {:?} where {want:?} came in", sample.level);
            findings.add(at, Some(node), what);
        }
    }
}
