//! From edges to a verdict about the bit rate.

mod verdict;

pub use verdict::{BitTime, DataPhase, Found, Need, Verdict};
