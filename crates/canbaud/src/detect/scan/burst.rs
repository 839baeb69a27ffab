//! Errors that belong together: those of one frame, or of frames without a pause.

use crate::units::Micros;

/// What a candidate was heard to do since it was switched on or since the last good frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Burst {
    pub(super) first: Micros,
    pub(super) last: Micros,
    /// Errors.
    pub(super) count: u32,
    /// Shortest time between two errors.
    pub(super) closest: Micros,
    pub(super) in_arbitration: bool,
}

impl Burst {
    pub(super) const fn new(at: Micros) -> Self {
        Self { first: at, last: at, count: 1, closest: Micros::MAX, in_arbitration: false }
    }

    pub(super) fn add(&mut self, at: Micros) {
        // Time stamps may come out of order; such a pair has no distance.
        self.closest = self.closest.min(at - self.last);
        self.last = self.last.max(at);
        self.count = self.count.saturating_add(1);
    }

    pub(super) fn span(&self) -> Micros {
        self.last - self.first
    }
}
