//! The run: which event comes next.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use canbaud::wire::{Frame, Level};

use crate::bus::Line;
use crate::clock::ClockError;
use crate::event::{Event, NodeId, Observer};
use crate::node::{FaultConfinement, Node, NodeConfig, Oscillator, Step};
use crate::time::{Span, Time};

mod act;
mod ahead;

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

    /// Runs until `until`, or until a watched node has news.
    pub fn run<O: Observer>(&mut self, until: Time, observer: &mut O) -> Stop {
        // Whoever wants samples wants them in time.
        let late = self.pace == Pace::Ahead && !O::SAMPLES;
        for node in &mut self.nodes {
            node.set_late_reading(late);
        }
        self.refresh_all();
        let stop = self.run_on(until, observer);
        // News may come before other events of the same time.
        let done = match stop {
            Stop::Reached => self.now + Span::from_fs(1),
            Stop::News => self.now,
        };
        for node in &mut self.nodes {
            node.catch_up(done, &self.line.log);
        }
        self.refresh_all();
        stop
    }

    fn refresh_all(&mut self) {
        for (node, next) in self.nodes.iter().zip(&mut self.next) {
            *next = node.next();
        }
    }

    fn run_on<O: Observer>(&mut self, until: Time, observer: &mut O) -> Stop {
        loop {
            let (mut at, mut place, mut second) = (Time::NEVER, 0, Time::NEVER);
            for (index, &next) in self.next.iter().enumerate() {
                // Without a branch, which could not be foretold.
                second = second.min(next.max(at));
                place = if next < at { index } else { place };
                at = at.min(next);
            }
            let arrival = self.line.next();
            let entry = self.agenda.peek().map_or(Time::NEVER, |Reverse(entry)| entry.at);
            let first = at.min(arrival).min(entry);
            if first > until || first == Time::NEVER {
                self.now = self.now.max(until);
                return Stop::Reached;
            }
            self.now = first;
            self.steps += 1;
            if entry == first {
                self.act(observer);
            } else if arrival == first {
                second = second.min(self.arrive(observer));
                self.run_alone(place, second.min(entry), until, observer);
            } else if !self.step(place, until, observer) {
                self.run_alone(place, second.min(entry), until, observer);
            }
            if !self.news.is_empty() {
                return Stop::News;
            }
        }
    }

    /// Goes on with one node, and with what arrives at the star point, strictly before `horizon`:
    /// until then no other node has anything to do.
    #[inline]
    fn run_alone<O: Observer>(
        &mut self,
        place: usize,
        horizon: Time,
        until: Time,
        observer: &mut O,
    ) {
        let mut horizon = horizon.min(until);
        while self.news.is_empty() {
            let (next, arrival) = (self.next[place], self.line.next());
            let first = next.min(arrival);
            if first >= horizon {
                return;
            }
            self.now = first;
            self.steps += 1;
            if arrival <= next {
                horizon = horizon.min(self.arrive(observer));
            } else if self.step(place, until, observer) {
                return;
            }
        }
    }

    /// Something reaches the star point. Returns when the first of the nodes that heed it has to
    /// be looked at.
    fn arrive<O: Observer>(&mut self, observer: &mut O) -> Time {
        match self.line.arrive() {
            Some(edge) => self.after_edge(edge.at, edge.to, observer),
            None => Time::NEVER,
        }
    }

    /// The next event of the node at `place`. True if more than that was computed.
    #[inline]
    fn step<O: Observer>(&mut self, place: usize, until: Time, observer: &mut O) -> bool {
        let now = self.now;
        let node = &mut self.nodes[place];
        let step = node.step(now, &self.line.log);
        self.next[place] = node.next();
        match step {
            Step::Quiet => {}
            Step::Sampled(sample) => {
                if O::SAMPLES {
                    observer.sample(now, NodeId(place), &sample);
                }
            }
            Step::Txd(level) => self.drive(place, level, observer),
        }
        let node = &self.nodes[place];
        if node.has_events() {
            self.publish(place, observer);
            return false;
        }
        let sampled = matches!(step, Step::Sampled(_));
        sampled
            && self.pace == Pace::Ahead
            && self.nodes[place].is_transmitting()
            && self.compute_ahead(place, until, observer)
    }

    fn drive<O: Observer>(&mut self, place: usize, level: Level, observer: &mut O) {
        let config = self.nodes[place].config();
        if config.can_drive() {
            let at = config.transceiver.to_star(self.now, level);
            observer.txd(self.now, NodeId(place), level);
            self.line.send(at, self.drivers[place], level);
        }
    }

    #[cold]
    fn publish<O: Observer>(&mut self, place: usize, observer: &mut O) {
        while let Some(event) = self.nodes[place].take_event() {
            observer.event(self.now, NodeId(place), &event);
            if self.watched[place] {
                self.news.push((self.now, NodeId(place), event));
            }
        }
    }

    fn after_edge<O: Observer>(&mut self, at: Time, to: Level, observer: &mut O) -> Time {
        observer.bus(at, to);
        let mut first = Time::NEVER;
        if to == Level::Dominant {
            for (node, next) in self.nodes.iter_mut().zip(&mut self.next) {
                if node.notice_edge(at, &self.line.log) {
                    *next = node.next();
                    first = first.min(*next);
                }
            }
        }
        first
    }
}
