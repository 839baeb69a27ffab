//! A bus with its nodes, and what is to be done to it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use canbaud::wire::{Frame, Level};

use crate::bus::Line;
use crate::clock::ClockError;
use crate::event::{Event, NodeId};
use crate::node::{FaultConfinement, Node, NodeConfig, Oscillator};
use crate::time::{Span, Time};

mod act;
mod ahead;
mod events;

use act::{Act, Entry};
use ahead::Ahead;

/// Why [`Simulation::run`] came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The time asked for has come.
    Reached,
    /// Something happened in a node that is watched: [`Simulation::take_news`].
    News,
}

/// How a run is computed; what comes out is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pace {
    /// Bits of which nothing can come are computed many at a time.
    #[default]
    Ahead,
    /// Every sample point of every node in its turn: slow, and plain.
    EveryBit,
}

/// A bus with its nodes.
///
/// ```
/// use canbaud::wire::{Frame, FrameKind, Id};
/// use canbaud_sim::{Blind, NodeConfig, Simulation, Time, Span};
/// let mut sim = Simulation::new(1);
/// let sender = sim.add_node(NodeConfig::at("sender", 500_000).unwrap()).unwrap();
/// let receiver = sim.add_node(NodeConfig::at("receiver", 500_000).unwrap()).unwrap();
/// let frame = Frame::new(Id::Base(0x123), FrameKind::Data, 1, &[0x55]).unwrap();
/// sim.send_at(Time::ZERO, sender, frame);
/// sim.run(Time::ZERO + Span::from_ms(1), &mut Blind);
/// assert_eq!(sim.node(sender).pending(), 0);
/// assert_eq!(sim.node(receiver).fault().rec(), 0);
/// ```
#[derive(Debug)]
pub struct Simulation {
    now: Time,
    seed: u64,
    line: Line,
    nodes: Vec<Node>,
    /// The next event of each node, beside each other for a quick search.
    next: Vec<Time>,
    watched: Vec<bool>,
    /// Drivers of the line: one for each node, and one for each kind of disturbance.
    drivers: Vec<usize>,
    agenda: BinaryHeap<Reverse<Entry>>,
    entries: u64,
    news: Vec<(Time, NodeId, Event)>,
    steps: u64,
    pace: Pace,
    ahead: Ahead,
}

impl Simulation {
    /// An empty bus; `seed` decides on jitter.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            now: Time::ZERO,
            seed,
            line: Line::new(),
            nodes: Vec::new(),
            next: Vec::new(),
            watched: Vec::new(),
            drivers: Vec::new(),
            agenda: BinaryHeap::new(),
            entries: 0,
            news: Vec::new(),
            steps: 0,
            pace: Pace::default(),
            ahead: Ahead::default(),
        }
    }

    /// Adds a node; it integrates from now on.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such oscillator.
    pub fn add_node(&mut self, config: NodeConfig) -> Result<NodeId, ClockError> {
        self.add_node_with(config, FaultConfinement::default())
    }

    /// Adds a node whose error counters are not zero.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such oscillator.
    pub fn add_node_with(
        &mut self,
        config: NodeConfig,
        fault: FaultConfinement,
    ) -> Result<NodeId, ClockError> {
        let id = NodeId(self.nodes.len());
        let node = self.build(id, config, fault)?;
        self.next.push(node.next());
        self.nodes.push(node);
        self.watched.push(false);
        self.drivers.push(self.line.add_driver());
        Ok(id)
    }

    fn build(
        &self,
        id: NodeId,
        config: NodeConfig,
        fault: FaultConfinement,
    ) -> Result<Node, ClockError> {
        Node::new(config, &self.line, self.now, Node::salt(self.seed, id.0), fault)
    }

    /// The time up to which the run has come.
    #[must_use]
    pub const fn now(&self) -> Time {
        self.now
    }

    /// A node.
    #[must_use]
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0]
    }

    /// All nodes in order.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The level at the star point.
    #[must_use]
    pub const fn bus_level(&self) -> Level {
        self.line.level()
    }

    /// Events dealt with so far: the work done.
    #[must_use]
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Makes [`Simulation::run`] come back whenever something happens in `node`.
    pub fn watch(&mut self, node: NodeId) {
        self.watched[node.0] = true;
    }

    /// What happened in watched nodes since the last call.
    pub fn take_news(&mut self) -> Vec<(Time, NodeId, Event)> {
        core::mem::take(&mut self.news)
    }

    fn enter(&mut self, at: Time, act: Act) {
        self.entries += 1;
        self.agenda.push(Reverse(Entry { at: at.max(self.now), number: self.entries, act }));
    }

    /// Asks `node` to send `frame` at `at` (or now, if that is past).
    pub fn send_at(&mut self, at: Time, node: NodeId, frame: Frame) {
        self.enter(at, Act::Send { node, frame });
    }

    /// Takes back all requests of `node` that are not being sent.
    pub fn abort_requests(&mut self, node: NodeId) {
        self.nodes[node.0].abort_requests();
    }

    /// Drives the line dominant for `width` from `at` on.
    pub fn dominant_at(&mut self, at: Time, width: Span) {
        let driver = self.line.add_driver();
        self.enter(at, Act::Drive { driver, level: Level::Dominant });
        self.enter(at + width, Act::Drive { driver, level: Level::Recessive });
    }

    /// Shorts the line to recessive for `width` from `at` on.
    pub fn recessive_at(&mut self, at: Time, width: Span) {
        self.enter(at, Act::Short);
        self.enter(at + width, Act::Unshort);
    }

    /// Holds RXD of `node` at `level` for `width` from `at` on.
    pub fn force_rxd_at(&mut self, at: Time, node: NodeId, level: Level, width: Span) {
        self.enter(at, Act::ForceRxd { node, level: Some(level) });
        self.enter(at + width, Act::ForceRxd { node, level: None });
    }

    /// Lets the clock of `node` run `ppb` parts per billion fast from the first bit after `at` on.
    ///
    /// # Errors
    /// [`ClockError`] if the deviation is out of range.
    pub fn drift_at(&mut self, at: Time, node: NodeId, ppb: i64) -> Result<(), ClockError> {
        Oscillator { ppb, ..self.nodes[node.0].config().oscillator }.check()?;
        self.enter(at, Act::Drift { node, ppb });
        Ok(())
    }

    /// Sets `node` up anew at `at`: it is reset, its requests and counters are gone, and it
    /// integrates.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such oscillator.
    pub fn reconfigure_at(
        &mut self,
        at: Time,
        node: NodeId,
        config: NodeConfig,
    ) -> Result<(), ClockError> {
        config.oscillator.check()?;
        self.enter(at, Act::Reconfigure { node, config: Box::new(config) });
        Ok(())
    }

    /// How runs are computed from now on.
    pub const fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
    }
}
