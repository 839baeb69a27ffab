//! What is captured.

use canbaud::wire::Logic;

/// An edge that was captured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The counter of the timer, in ticks.
    pub stamp: u32,
    /// The level behind it: a falling edge leads to `Low`.
    pub level: Logic,
    /// What was captured before it.
    pub before: Before,
}

/// Whether something is missing before an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Before {
    /// Nothing: the edge that was put before is the one before.
    Complete,
    /// At least one edge was overwritten before it was read (overcapture).
    Missing,
}

impl Edge {
    /// An edge to `level` with none missing before it.
    #[must_use]
    pub const fn new(stamp: u32, level: Logic) -> Self {
        Self { stamp, level, before: Before::Complete }
    }

    /// The same edge, with at least one missing before it.
    #[must_use]
    pub const fn behind_missing(self) -> Self {
        Self { before: Before::Missing, ..self }
    }
}
