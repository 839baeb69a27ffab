//! Voltages to edges: find the two levels, then the instants between them.

mod crossing;
mod driver;
mod histogram;
mod levels;
mod pair;

pub(crate) use crossing::Crossing;
pub(crate) use driver::{Blocks, Difference, Floats, Job, Segment};
pub(crate) use histogram::Histogram;
pub(crate) use levels::{Chooser, candidates};
pub use levels::{Levels, Threshold};
pub(crate) use pair::differences;

/// Ticks per sample of an analogue channel: crossings are interpolated to a 16th of a sample.
pub(crate) const TICKS_PER_SAMPLE: u64 = 16;
