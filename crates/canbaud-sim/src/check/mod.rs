//! Checkers: observers that derive the law of the bus anew, with code of their own.
//!
//! They share no code with nodes, bus or `canbaud::wire`, so that a mistake there shows here.

mod counters;
mod decoder;
mod frames;
mod silence;
mod wire;

use canbaud::wire::Level;

use crate::event::{Disturbance, Event, NodeId, Observer, SampleRun, Sampling};
use crate::node::NodeConfig;
use crate::simulation::Simulation;
use crate::time::Time;

/// A broken law.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// When.
    pub at: Time,
    /// At which node; `None` for the bus.
    pub node: Option<NodeId>,
    /// What, for people.
    pub what: String,
}

impl core::fmt::Display for Violation {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.node {
            Some(NodeId(node)) => write!(f, "{} node {node}: {}", self.at, self.what),
            None => write!(f, "{} bus: {}", self.at, self.what),
        }
    }
}

/// Violations kept; the rest is only counted.
const KEPT: usize = 50;

/// The violations of a run.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    kept: Vec<Violation>,
    count: u64,
}

impl Findings {
    fn add(&mut self, at: Time, node: Option<NodeId>, what: String) {
        self.count += 1;
        if self.kept.len() < KEPT {
            self.kept.push(Violation { at, node, what });
        }
    }
}

/// All checkers together.
///
/// ```
/// use canbaud_sim::{check::Checker, NodeConfig, Simulation, Span, Time};
/// let mut sim = Simulation::new(1);
/// sim.add_node(NodeConfig::at("alone", 500_000).unwrap()).unwrap();
/// let mut checker = Checker::new(&sim);
/// sim.run(Time::ZERO + Span::from_ms(1), &mut checker);
/// assert_eq!(checker.violations(), 0);
/// ```
#[derive(Debug)]
pub struct Checker {
    findings: Findings,
    wire: wire::Wire,
    silence: silence::Silence,
    frames: frames::Frames,
    decoder: decoder::Decoder,
    counters: Vec<counters::Counters>,
}

impl Checker {
    /// Checkers for a simulation whose nodes have all been added, before its first step.
    #[must_use]
    pub fn new(sim: &Simulation) -> Self {
        let configs: Vec<_> = sim.nodes().iter().map(|node| node.config().clone()).collect();
        Self {
            findings: Findings::default(),
            wire: wire::Wire::new(&configs),
            silence: silence::Silence::new(&configs),
            frames: frames::Frames::new(&configs),
            decoder: decoder::Decoder::new(&configs),
            counters: sim.nodes().iter().map(counters::Counters::new).collect(),
        }
    }

    /// How many violations there were.
    #[must_use]
    pub const fn violations(&self) -> u64 {
        self.findings.count
    }

    /// The first violations.
    #[must_use]
    pub fn first(&self) -> &[Violation] {
        &self.findings.kept
    }

    /// Frames accepted at a wrong bit rate that nobody had sent: bad luck, not a violation.
    #[must_use]
    pub const fn phantoms(&self) -> u64 {
        self.frames.phantoms()
    }

    /// Frames whose bits at the star point were read back and compared.
    #[must_use]
    pub const fn decoded(&self) -> u64 {
        self.decoder.decoded()
    }

    /// Bits whose level was derived anew and compared.
    #[must_use]
    pub const fn bits(&self) -> u64 {
        self.wire.bits()
    }

    /// # Panics
    /// If there was a violation; prints the first ones.
    pub fn assert_clean(&self) {
        let list: Vec<_> = self.findings.kept.iter().map(ToString::to_string).collect();
        assert!(
            self.findings.count == 0,
            "{} violations:\n{}",
            self.findings.count,
            list.join("\n")
        );
    }
}

impl Observer for Checker {
    const SAMPLING: Sampling = Sampling::InRuns;

    fn bus(&mut self, at: Time, level: Level) {
        self.wire.bus(at, level, &mut self.findings);
        self.decoder.bus(at, level);
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        self.wire.txd(at, node, level, &mut self.findings);
        self.silence.txd(at, node, level, &mut self.findings);
        self.counters[node.0].txd(at, node, level, &mut self.findings);
    }

    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        self.wire.samples(node, run, &mut self.findings);
        self.counters[node.0].samples(run);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        self.frames.event(at, node, event, &mut self.findings);
        self.decoder.event(at, node, event, &mut self.findings);
        self.counters[node.0].event(at, node, event, &mut self.findings);
    }

    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        self.wire.reconfigured(at, node, config);
        self.silence.reconfigured(node, config);
        self.frames.reconfigured(node, config);
        self.decoder.reconfigured(node, config);
        self.counters[node.0].reconfigured(config);
    }

    fn disturbed(&mut self, at: Time, disturbance: Disturbance) {
        self.wire.disturbed(at, disturbance, &mut self.findings);
        if !matches!(disturbance, Disturbance::ForcedRxd(..)) {
            self.decoder.disturbed(at);
        }
    }
}
