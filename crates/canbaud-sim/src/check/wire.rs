//! The star point is the AND of all that drive it, and each node samples what came to it.

use std::collections::VecDeque;

use canbaud::wire::Level;

use super::Findings;
use crate::bus::Transceiver;
use crate::event::{Disturbance, NodeId, SampleRun};
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

    /// Whether an edge is sure to come in after `first`, at which the level was asked for, and
    /// before `last`.
    fn comes_between(&self, first: Time, last: Time) -> bool {
        let jitter = self.transceiver.jitter;
        let sure = |at: &Time| *at > first + jitter && *at + jitter < last;
        self.coming.iter().map(|(at, _)| at).take_while(|at| **at < last).any(sure)
    }
}

/// Checks levels at the star point and at every sample.
#[derive(Debug)]
pub(super) struct Wire {
    transceivers: Vec<Transceiver>,
    nodes: Vec<Driver>,
    /// When the first of what is coming from the nodes is there.
    due: Time,
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
            due: Time::NEVER,
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

    /// What all drivers make at `now`, and how many change just then.
    fn wired_and(&mut self, now: Time) -> (Level, usize) {
        let mut changing = 0;
        if self.due <= now {
            self.due = Time::NEVER;
            for node in &mut self.nodes {
                while let Some(&(at, to)) = node.coming.front().filter(|(at, _)| *at <= now) {
                    node.coming.pop_front();
                    node.dominant = to;
                    changing += usize::from(at == now);
                }
                self.due = self.due.min(node.coming.front().map_or(Time::NEVER, |(at, _)| *at));
            }
        }
        let dominant = self.disturbing > 0 || self.nodes.iter().any(|node| node.dominant);
        let level = if dominant && self.shorts == 0 { Level::Dominant } else { Level::Recessive };
        (level, changing)
    }

    /// Nothing may have changed at the star point strictly before `now` without being told.
    fn settle_before(&mut self, now: Time, findings: &mut Findings) {
        if self.due < now {
            let just_before = now - crate::time::Span::from_fs(1);
            let (want, _) = self.wired_and(just_before);
            if want != self.bus {
                let what = format!("stays {:?} where all drivers make {want:?}", self.bus);
                findings.add(now, None, what);
                self.bus = want;
            }
        }
    }

    pub(super) fn bus(&mut self, at: Time, level: Level, findings: &mut Findings) {
        self.settle_before(at, findings);
        let (want, changing) = self.wired_and(at);
        if self.crowded_at != at {
            self.crowded_at = at;
            // Where several drivers change in this same femtosecond, the bus may blink in between.
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
        self.due = self.due.min(arrival);
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
            self.due = self.due.min(at);
        }
        self.ears[node.0] = Ear::new(config, self.bus);
    }

    pub(super) fn samples(&mut self, node: NodeId, run: &SampleRun, findings: &mut Findings) {
        self.bits += u64::from(run.bits);
        let sample = &run.sample;
        let ear = &mut self.ears[node.0];
        let constant = match ear.forced {
            _ if ear.hears_itself && sample.driven == Level::Dominant => Some(Level::Dominant),
            forced => forced,
        };
        let (first, whole, last) = match constant {
            Some(level) => (Some(level), true, Some(level)),
            None if run.bits == 1 => (ear.level_at(run.first), true, None),
            None => {
                let first = ear.level_at(run.first);
                (first, !ear.comes_between(run.first, run.last), ear.level_at(run.last))
            }
        };
        for (at, want) in [(run.first, first), (run.last, last)] {
            if want.is_some_and(|want| want != sample.level) {
                let what = format!("samples {:?} where {want:?} came in", sample.level);
                findings.add(at, Some(node), what);
            }
        }
        if !whole {
            let what = format!("samples {} bits without the edge among them", run.bits);
            findings.add(run.last, Some(node), what);
        }
    }
}
