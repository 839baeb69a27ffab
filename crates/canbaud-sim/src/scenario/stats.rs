//! What a run came to, in numbers.

use canbaud::wire::Level;
use serde::Serialize;

use crate::event::{Event, FaultState, NodeId, Observer};
use crate::time::Time;

/// What happened at one node.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct NodeStats {
    /// Its name.
    pub name: String,
    /// Frames accepted.
    pub received: u64,
    /// Frames sent with success.
    pub transmitted: u64,
    /// Attempts to send.
    pub attempts: u64,
    /// Arbitrations lost.
    pub arbitration_lost: u64,
    /// Errors detected.
    pub errors: u64,
    /// Overload frames begun.
    pub overloads: u64,
    /// How often it went bus-off.
    pub bus_off: u64,
    /// Highest TEC.
    pub tec_max: u16,
    /// Highest REC.
    pub rec_max: u16,
    /// Times that it made TXD dominant.
    pub dominant: u64,
    /// State at the end.
    pub state: String,
    /// Bit rate that its software has found, in bit/s.
    pub found_bitrate: Option<u32>,
    /// When, in seconds.
    pub found_at_s: Option<f64>,
    /// Messages and errors that its software looked at for that.
    pub messages: u64,
    /// Where an autonomous node is in the end.
    pub stage: Option<String>,
    /// Dominant levels of an autonomous node while it had to be silent.
    pub broken_silence: u64,
}

/// What happened on the bus.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// The seed of the run.
    pub seed: u64,
    /// How long it was, in seconds.
    pub duration_s: f64,
    /// Edges at the star point.
    pub edges: u64,
    /// Share of the time that the bus was dominant.
    pub dominant_share: f64,
    /// The nodes.
    pub nodes: Vec<NodeStats>,
    #[serde(skip)]
    dominant_since: Option<Time>,
    #[serde(skip)]
    dominant_fs: u64,
}

impl Statistics {
    /// For nodes of these names.
    #[must_use]
    pub fn new(names: &[String], seed: u64) -> Self {
        let node = |name: &String| NodeStats { name: name.clone(), ..NodeStats::default() };
        Self { seed, nodes: names.iter().map(node).collect(), ..Self::default() }
    }

    /// Closes the account at the end of the run.
    pub(super) fn close(&mut self, end: Time) {
        if let Some(since) = self.dominant_since.take() {
            self.dominant_fs += end.since(since).femtoseconds();
        }
        self.duration_s = end.seconds();
        if end > Time::ZERO {
            self.dominant_share = self.dominant_fs as f64 / end.femtoseconds() as f64;
        }
    }
}

impl Observer for Statistics {
    fn bus(&mut self, at: Time, level: Level) {
        self.edges += 1;
        match level {
            Level::Dominant => self.dominant_since = Some(at),
            Level::Recessive => {
                let since = self.dominant_since.take().unwrap_or(at);
                self.dominant_fs += at.since(since).femtoseconds();
            }
        }
    }

    fn txd(&mut self, _: Time, node: NodeId, level: Level) {
        self.nodes[node.0].dominant += u64::from(level == Level::Dominant);
    }

    fn event(&mut self, _: Time, node: NodeId, event: &Event) {
        let node = &mut self.nodes[node.0];
        match event {
            Event::TransmissionStarted { .. } => node.attempts += 1,
            Event::ArbitrationLost { .. } => node.arbitration_lost += 1,
            Event::Transmitted { .. } => node.transmitted += 1,
            Event::Received { .. } => node.received += 1,
            Event::Error { .. } => node.errors += 1,
            Event::Overload => node.overloads += 1,
            Event::Counted { tec, rec, .. } => {
                node.tec_max = node.tec_max.max(*tec);
                node.rec_max = node.rec_max.max(*rec);
            }
            Event::Fault(state) => node.bus_off += u64::from(*state == FaultState::BusOff),
            Event::Abandoned { .. }
            | Event::RecoverySequence(_)
            | Event::ProtocolException
            | Event::Integrated => {}
        }
    }
}
