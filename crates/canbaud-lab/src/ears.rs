//! What the network notices on its way: edges for the timers, and who drives the bus.

use canbaud::wire::Level;
use canbaud_sim::{Event, NodeConfig, NodeId, Observer, Sample, SampleRun, Sampling, Time};

/// An observer for the devices' timers and for the tally, with room for one more observer.
pub(crate) struct Ears<'a, O> {
    pub(crate) heard: &'a mut Heard,
    pub(crate) other: &'a mut O,
}

/// What was noticed.
#[derive(Debug, Default)]
pub(crate) struct Heard {
    /// Edges at the star point since they were taken last.
    pub(crate) edges: Vec<(Time, Level)>,
    /// Nodes that must be silent now.
    pub(crate) must_be_silent: Vec<bool>,
    /// Dominant levels of nodes that must be silent.
    pub(crate) broken_silence: u64,
    /// Error flags of nodes that take part.
    pub(crate) error_flags: u64,
    /// Error flags of each node while it takes part.
    pub(crate) flags_of: Vec<u64>,
}

impl<O: Observer> Observer for Ears<'_, O> {
    const SAMPLING: Sampling = O::SAMPLING;

    fn bus(&mut self, at: Time, level: Level) {
        self.heard.edges.push((at, level));
        self.other.bus(at, level);
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        let silent = self.heard.must_be_silent.get(node.0).copied().unwrap_or(false);
        self.heard.broken_silence += u64::from(silent && level == Level::Dominant);
        self.other.txd(at, node, level);
    }

    fn sample(&mut self, at: Time, node: NodeId, sample: &Sample) {
        self.other.sample(at, node, sample);
    }

    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        self.other.samples(node, run);
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        let silent = self.heard.must_be_silent.get(node.0).copied().unwrap_or(false);
        if !silent && matches!(event, Event::Error { .. }) {
            self.heard.error_flags += 1;
            if let Some(count) = self.heard.flags_of.get_mut(node.0) {
                *count += 1;
            }
        }
        self.other.event(at, node, event);
    }

    fn reconfigured(&mut self, at: Time, node: NodeId, config: &NodeConfig) {
        self.other.reconfigured(at, node, config);
    }

    fn disturbed(&mut self, at: Time, disturbance: canbaud_sim::Disturbance) {
        self.other.disturbed(at, disturbance);
    }
}
