//! Keeps the edges and the frames of a run.

use canbaud::wire::{Frame, Level};

use crate::event::{Event, NodeId, Observer};
use crate::time::Time;

/// Edges at the star point, at each TXD, and the frames that were sent.
#[derive(Debug, Clone, Default)]
pub struct Recorder {
    /// Edges at the star point; before the first one the bus is recessive.
    pub bus: Vec<(Time, Level)>,
    /// Edges at the TXD pins (after a gate).
    pub txd: Vec<(Time, NodeId, Level)>,
    /// Frames that were sent with success: when EOF ended, by whom.
    pub frames: Vec<(Time, NodeId, Frame)>,
}

impl Observer for Recorder {
    fn bus(&mut self, at: Time, level: Level) {
        self.bus.push((at, level));
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        self.txd.push((at, node, level));
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        if let Event::Transmitted { frame } = event {
            self.frames.push((at, node, *frame));
        }
    }
}
