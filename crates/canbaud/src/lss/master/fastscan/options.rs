//! What a fastscan is told, and what it tells.

use core::fmt;

use crate::lss::{LssAddress, Pace};
use crate::units::Micros;

/// Which questions a fastscan asks. A slave compares all bits from 31 down to BitChecked, so a
/// question may be about many bits at once, and about either value of a bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Strategy {
    /// Bit by bit, "is it 0?", as the document draws it: 133 requests, and the full time-out for
    /// each bit that is 1.
    Document,
    /// What is likely first: known addresses, runs of zeros, the value of the bit before; waits for
    /// silence as long as the answers so far suggest. What silence told is proven by an answer.
    #[default]
    Adaptive,
}

/// How to scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FastscanOptions<'a> {
    /// Which questions to ask.
    pub strategy: Strategy,
    /// Time-outs and pauses.
    pub pace: Pace,
    /// Addresses that are likely, or that the one sought shares its first parts with: those of
    /// devices found before. Tried in order, so the list should be short.
    pub known: &'a [LssAddress],
}

impl Default for FastscanOptions<'_> {
    fn default() -> Self {
        Self { strategy: Strategy::Adaptive, pace: Pace::default(), known: &[] }
    }
}

/// What a scan took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FastscanStatistics {
    /// Requests sent.
    pub requests: u32,
    /// Requests that nobody answered in time.
    pub silences: u32,
    /// Answers that came too late, or twice, and were recognised.
    pub stray_answers: u32,
    /// Times that answers contradicted each other and the scan began again, more carefully.
    pub restarts: u32,
    /// Longest time from a request to its first answer.
    pub longest_answer: Micros,
}

/// A device that was found; it is in configuration now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Found {
    /// Its address.
    pub address: LssAddress,
    /// What the scan took.
    pub statistics: FastscanStatistics,
}

/// Why a scan ended without an address although somebody answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FastscanError {
    /// The device does not answer any more.
    Lost,
    /// Answers went on contradicting each other, however slowly it was asked.
    Inconsistent,
}

impl fmt::Display for FastscanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lost => "the device stopped answering",
            Self::Inconsistent => "the answers contradict each other",
        })
    }
}

impl core::error::Error for FastscanError {}
