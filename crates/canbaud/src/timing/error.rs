//! Why a request cannot be met.

use core::fmt;

use super::{Rate, RateWords};
use crate::units::{Bitrate, Hertz, Permille};

/// Why no setting meets the request: the limit that stands in the way, and the nearest reachable
/// bit rate where there is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolveError {
    /// The clock is outside what the solver handles (and any CAN controller has).
    Clock {
        /// The clock asked for.
        clock: Hertz,
        /// Highest clock in Hz.
        max: u32,
    },
    /// The limits contradict each other or are empty.
    Limits,
    /// Even the smallest division of the clock is too slow.
    TooFast {
        /// The bit rate asked for.
        bitrate: Bitrate,
        /// Smallest number of clock periods in a bit.
        divisor_min: u64,
        /// The fastest reachable rate.
        nearest: Rate,
    },
    /// Even the largest division of the clock is too fast.
    TooSlow {
        /// The bit rate asked for.
        bitrate: Bitrate,
        /// Largest number of clock periods in a bit.
        divisor_max: u64,
        /// The slowest reachable rate.
        nearest: Rate,
    },
    /// The divisions around the right one are not close enough.
    NotClose {
        /// The bit rate asked for.
        bitrate: Bitrate,
        /// The nearest reachable rate.
        nearest: Rate,
        /// Largest accepted error in 10⁻⁶.
        tolerance_ppm: u32,
    },
    /// No setting has a sample point that the policy allows.
    SamplePoint {
        /// Earliest allowed.
        earliest: Permille,
        /// Latest allowed.
        latest: Permille,
    },
    /// The SJW asked for does not fit the segments found.
    Sjw {
        /// The SJW asked for.
        asked: u16,
        /// The largest that fits.
        max: u16,
    },
}

impl SolveError {
    /// One line without values, for a `const` context where nothing can be formatted.
    #[must_use]
    pub const fn reason(&self) -> &'static str {
        match self {
            Self::Clock { .. } => "bit timing: the clock is outside 1 Hz to 2147483647 Hz",
            Self::Limits => "bit timing: the limits of the controller contradict each other",
            Self::TooFast { .. } => "bit timing: the bit rate is too high for this clock",
            Self::TooSlow { .. } => "bit timing: the bit rate is too low for this clock",
            Self::NotClose { .. } => {
                "bit timing: this clock cannot be divided to the bit rate within the tolerance"
            }
            Self::SamplePoint { .. } => "bit timing: no setting has an allowed sample point",
            Self::Sjw { .. } => "bit timing: the SJW asked for does not fit the segments",
        }
    }

    /// The nearest reachable bit rate, where the bit rate is what stands in the way.
    #[must_use]
    pub const fn nearest(&self) -> Option<Rate> {
        match self {
            Self::TooFast { nearest, .. }
            | Self::TooSlow { nearest, .. }
            | Self::NotClose { nearest, .. } => Some(*nearest),
            Self::Clock { .. } | Self::Limits | Self::SamplePoint { .. } | Self::Sjw { .. } => None,
        }
    }
}

fn words(bitrate: Bitrate) -> RateWords {
    Rate::from(bitrate).words()
}

impl fmt::Display for SolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock { clock, max } => {
                write!(f, "clock {} Hz outside 1 to {max} Hz", clock.hertz())
            }
            Self::Limits => f.write_str("the limits of the controller contradict each other"),
            Self::TooFast { bitrate, divisor_min, nearest } => write!(
                f,
                "{} needs fewer than the {divisor_min} clock periods that a bit takes \
                 at least; the fastest reachable rate is {}",
                words(*bitrate),
                nearest.words()
            ),
            Self::TooSlow { bitrate, divisor_max, nearest } => write!(
                f,
                "{} needs more than the {divisor_max} clock periods that a bit takes \
                 at most (prescaler and segments at their highest); the slowest reachable rate is \
                 {}",
                words(*bitrate),
                nearest.words()
            ),
            Self::NotClose { bitrate, nearest, tolerance_ppm } => {
                let error = nearest.error_ppb(*bitrate);
                write!(
                    f,
                    "no prescaler and bit length come within {tolerance_ppm} ppm of {}; the \
                     nearest reachable rate is {} ({}{}.{:03} ppm)",
                    words(*bitrate),
                    nearest.words(),
                    if error < 0 { "-" } else { "+" },
                    error.unsigned_abs() / 1_000,
                    error.unsigned_abs() % 1_000
                )
            }
            Self::SamplePoint { earliest, latest } => {
                write!(f, "no setting has a sample point from {earliest} to {latest}")
            }
            Self::Sjw { asked, max } => {
                write!(f, "SJW {asked} outside 1 to {max}, the largest for the segments found")
            }
        }
    }
}

impl core::error::Error for SolveError {}
