//! Where time becomes bits: runs of ticks to counts of bits, with resynchronization.
//!
//! Every edge lies on the sender's bit grid plus an error: quantisation, jitter, clock
//! difference, and for edges to recessive the asymmetry of the transceivers. How much of that
//! error the grid follows is the [`Pace`].

use super::clock::{BIT_Q20, BitClock};
use super::line::Level;

/// Edges further off are no edges of that bit: one bit.
const LATE_MAX_Q20: i32 = BIT_Q20;

/// How the grid follows the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pace {
    /// Hard synchronization on every recessive-to-dominant edge: the edges rule.
    Anchored,
    /// A quarter of each edge's error moves the grid: averages quantisation.
    Gentle,
    /// The grid stays where the start put it: for a bit time known well and few ticks a bit.
    Grid,
}

/// Counts the bits of successive runs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sync {
    pace: Pace,
    clock: BitClock,
    /// How much later than the grid edges to recessive come, in bits times 2^20.
    late_q20: i32,
    /// The error of the last edge against the grid, in bits times 2^20.
    error_q20: i32,
}

impl Sync {
    /// A grid whose first edge, to dominant, came `error_q20` of a bit (times 2^20) late.
    pub(crate) fn new(pace: Pace, clock: BitClock, late_q20: i32, error_q20: i32) -> Self {
        let late_q20 = late_q20.clamp(-LATE_MAX_Q20, LATE_MAX_Q20);
        let error_q20 = error_q20.clamp(-LATE_MAX_Q20, LATE_MAX_Q20);
        Self { pace, clock, late_q20, error_q20 }
    }

    /// The bits of a run of `ticks` at `level`; the edge that ends it moves the grid.
    #[inline]
    pub(crate) fn bits(&mut self, ticks: u32, level: Level) -> u32 {
        self.bits_after(ticks, level, 0)
    }

    /// The same, when the run began with something `skip_q20` bits long that is not counted.
    #[inline]
    pub(crate) fn bits_after(&mut self, ticks: u32, level: Level, skip_q20: i32) -> u32 {
        let expected = match level {
            Level::Dominant => self.late_q20,
            Level::Recessive => 0,
        };
        let position = self.clock.bits_q20(ticks) + self.error_q20 - skip_q20;
        let bits = (position - expected + BIT_Q20 / 2) >> 20;
        let bits = if bits < 0 { 0 } else { bits };
        let error = position - (bits << 20);
        self.error_q20 = match (self.pace, level) {
            (Pace::Anchored, Level::Recessive) => 0,
            (Pace::Anchored, Level::Dominant) | (Pace::Grid, _) => error,
            (Pace::Gentle, _) => error - (error - expected) / 4,
        };
        bits as u32
    }

    /// Goes on with another bit time; the last edge becomes the origin of its grid.
    pub(crate) fn switch(&mut self, clock: BitClock, late_q20: i32) {
        self.clock = clock;
        self.late_q20 = late_q20.clamp(-LATE_MAX_Q20, LATE_MAX_Q20);
        self.error_q20 = 0;
    }
}
