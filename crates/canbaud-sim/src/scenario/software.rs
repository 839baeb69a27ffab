//! Nodes with software from outside, while a scenario runs.

use std::collections::VecDeque;

use canbaud::wire::Level;

use super::build::Power;
use crate::event::{Event, NodeId, Observer};
use crate::simulation::Simulation;
use crate::software::{Software, Stage};
use crate::time::{Span, Time};

/// While timers follow edges, software looks at them this often.
const SLICE: Span = Span::from_us(500);
/// Software never looks twice within this.
const TURN: Span = Span::from_us(1);

/// What the nodes' timers and the account of silence hear.
#[derive(Debug, Default)]
pub(super) struct Ears {
    follows: bool,
    edges: Vec<(Time, Level)>,
    /// By node: whether it must be silent, and how often it was not.
    silent: Vec<bool>,
    broken: Vec<u64>,
}

impl Observer for Ears {
    fn bus(&mut self, at: Time, level: Level) {
        if self.follows {
            self.edges.push((at, level));
        }
    }

    fn txd(&mut self, _: Time, node: NodeId, level: Level) {
        if level == Level::Dominant && self.silent[node.0] {
            self.broken[node.0] += 1;
        }
    }
}

/// A node and its software.
#[derive(Debug)]
struct Installed {
    node: NodeId,
    software: Box<dyn Software>,
    power: VecDeque<(Time, Power)>,
    due: bool,
}

impl Installed {
    fn next(&self, now: Time) -> Time {
        let power = self.power.front().map_or(Time::NEVER, |(at, _)| *at);
        self.software.deadline().max(now + TURN).min(power)
    }

    fn turn(&mut self, sim: &mut Simulation) {
        while let Some((_, power)) = self.power.front().filter(|(at, _)| *at <= sim.now()) {
            match power {
                Power::On => self.software.power_on(sim),
                Power::Off => self.software.power_off(sim),
            }
            self.power.pop_front();
            self.due = true;
        }
        if core::mem::take(&mut self.due) || self.software.deadline() <= sim.now() {
            self.software.wake(sim);
        }
    }
}

/// All nodes with software from outside.
#[derive(Debug, Default)]
pub(super) struct Installation {
    all: Vec<Installed>,
    pub(super) ears: Ears,
}

impl Installation {
    pub(super) fn new(nodes: usize) -> Self {
        let ears = Ears { silent: vec![false; nodes], broken: vec![0; nodes], ..Ears::default() };
        Self { all: Vec::new(), ears }
    }

    /// `power`: when it comes and goes, in order.
    pub(super) fn add(
        &mut self,
        node: NodeId,
        software: Box<dyn Software>,
        power: VecDeque<(Time, Power)>,
    ) {
        self.ears.silent[node.0] = true;
        self.all.push(Installed { node, software, power, due: false });
    }

    /// When something has to be done next.
    pub(super) fn next(&self, now: Time) -> Time {
        let nodes = self.all.iter().map(|installed| installed.next(now));
        let slice = if self.ears.edges.is_empty() { Time::NEVER } else { now + SLICE };
        nodes.min().unwrap_or(Time::NEVER).min(slice)
    }

    /// Before the bus goes on.
    pub(super) fn listen(&mut self) {
        self.ears.edges.clear();
        self.ears.follows = self.all.iter().any(|installed| installed.software.follows_edges());
    }

    /// Edges go to the timers.
    pub(super) fn deliver_edges(&mut self) {
        for installed in self.all.iter_mut().filter(|i| i.software.follows_edges()) {
            for (at, level) in &self.ears.edges {
                installed.software.edge(*at, *level);
            }
            installed.due |= !self.ears.edges.is_empty();
        }
    }

    /// Something happened in the controller of `node`.
    pub(super) fn notice(&mut self, at: Time, node: NodeId, event: &Event, sim: &mut Simulation) {
        for installed in self.all.iter_mut().filter(|installed| installed.node == node) {
            installed.software.notice(at, event, sim);
            installed.due = true;
        }
    }

    /// Everybody does what is due, and tells of it.
    pub(super) fn turn<O: Observer>(&mut self, sim: &mut Simulation, observer: &mut O) {
        for installed in &mut self.all {
            installed.turn(sim);
            let stage = installed.software.standing().stage;
            self.ears.silent[installed.node.0] = stage.must_be_silent();
            for what in installed.software.take_told() {
                observer.told(sim.now(), installed.node, &what);
            }
        }
    }

    /// Of each node: its software, and how often it drove the bus while it had to be silent.
    pub(super) fn accounts(&self) -> impl Iterator<Item = (NodeId, &dyn Software, u64)> {
        let broken = |node: NodeId| self.ears.broken[node.0];
        self.all.iter().map(move |i| (i.node, &*i.software, broken(i.node)))
    }

    /// Where `node` is, if its software is from outside.
    pub(super) fn stage(&self, node: NodeId) -> Option<Stage> {
        let installed = self.all.iter().find(|installed| installed.node == node)?;
        Some(installed.software.standing().stage)
    }
}
