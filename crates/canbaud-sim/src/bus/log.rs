//! The latest edges at the star point.

use canbaud::wire::Level;

use crate::time::Time;

/// Edges kept. The slowest node (10 kbit/s) sees some 50 edges of the fastest bus between two of
/// its samples; of a storm of glitches that outruns even this, it sees the latest.
const CAPACITY: usize = 4096;

/// An edge at the star point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    pub(crate) at: Time,
    pub(crate) to: Level,
}

/// Edges that may be taken back: they were entered before their time has come.
const AHEAD: usize = 4096;
const RING: usize = CAPACITY + AHEAD;

/// A ring of edges, numbered from the start of the run.
#[derive(Debug, Clone)]
pub(crate) struct EdgeLog {
    ring: Vec<Edge>,
    head: u64,
}

impl EdgeLog {
    pub(crate) fn new() -> Self {
        Self { ring: vec![Edge { at: Time::ZERO, to: Level::Recessive }; RING], head: 0 }
    }

    /// The number that the next edge will have.
    #[inline]
    pub(crate) const fn head(&self) -> u64 {
        self.head
    }

    /// The number of the oldest edge that is kept.
    #[inline]
    pub(crate) const fn oldest(&self) -> u64 {
        self.head.saturating_sub(CAPACITY as u64)
    }

    pub(crate) fn push(&mut self, edge: Edge) {
        self.ring[self.head as usize % RING] = edge;
        self.head += 1;
    }

    /// Takes the latest edges back, from edge `head` on.
    pub(crate) fn take_back(&mut self, head: u64) {
        debug_assert!(self.head - head <= AHEAD as u64);
        self.head = head;
    }

    /// Edge `number`; `None` if it has not happened.
    #[inline]
    pub(crate) fn get(&self, number: u64) -> Option<Edge> {
        (number < self.head).then(|| {
            debug_assert!(self.head - number <= CAPACITY as u64, "edge {number} is forgotten");
            self.ring[number as usize % RING]
        })
    }
}
