//! Errors that belong together: those of one frame, or of frames without a pause.

use crate::units::{Bitrate, Micros};

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
    /// They were seen in a counter only: how many there were is not known exactly.
    pub(super) counted: bool,
    /// That counter has gone as far as it goes: more of them may have followed.
    pub(super) saturated: bool,
    /// How long nothing was heard before the first.
    pub(super) pause: Micros,
}

impl Burst {
    pub(super) const fn new(at: Micros, pause: Micros) -> Self {
        Self {
            first: at,
            last: at,
            count: 1,
            closest: Micros::MAX,
            in_arbitration: false,
            counted: false,
            saturated: false,
            pause,
        }
    }

    pub(super) fn add(&mut self, at: Micros) {
        // What came before was the end of another frame.
        if self.count == 2 && at - self.last > self.span().times(10) {
            *self = Self::new(at, at - self.last);
            return;
        }
        // Time stamps may come out of order; such a pair has no distance.
        self.closest = self.closest.min(at - self.last);
        self.last = self.last.max(at);
        self.count = self.count.saturating_add(1);
    }

    pub(super) fn span(&self) -> Micros {
        self.last - self.first
    }

    /// The time between two errors, on average.
    pub(super) fn spacing(&self) -> Micros {
        Micros(self.span().0 / u64::from(self.count.saturating_sub(1).max(1)))
    }

    /// Whether the times are those of the errors: a receiver at `rate` cannot tell two within 7 of
    /// its bits. Where they can be nearer, observations were told in a batch.
    #[inline(never)]
    pub(super) fn is_faithful(&self, rate: Bitrate) -> bool {
        self.closest + Micros(1) >= Micros::of_bits(7, rate)
    }

    /// Whether it stands by itself: one frame, not several without a pause.
    pub(super) fn is_single(&self) -> bool {
        self.pause >= self.span().times(2)
    }

    /// Whether the errors are as far apart as frames.
    pub(super) fn is_sparse(&self, rate: Bitrate) -> bool {
        self.count > 1 && self.spacing() >= Micros::of_bits(40, rate)
    }
}
