//! From edges to a verdict about the bit rate.

mod compact;
mod pulse;
pub mod scan;
mod verdict;

pub use compact::CompactDetector;
pub use pulse::{Measurement, MinimumPulse, PulseDetector, find_data_rate};
pub use verdict::{BitTime, DataPhase, Found, Need, Phase, Verdict};
