//! What a scan is doing, for people who watch.

use super::Candidate;
use crate::units::Micros;

/// What a scan is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Activity {
    /// It has not been polled yet.
    Waiting,
    /// The controller is being set up.
    Switching(Candidate),
    /// It listens.
    Listening(Candidate),
    /// A frame was received without an error; more is awaited.
    Confirming(Candidate),
    /// There is an outcome.
    Done,
}

/// Where a scan is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// What it is doing.
    pub activity: Activity,
    /// Since the first poll.
    pub elapsed: Micros,
    /// Until the scan has an outcome at the latest; `None` if there is no such time.
    pub left: Option<Micros>,
    /// Candidates listened to so far.
    pub visits: u32,
}

/// What speaks for and against a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standing {
    /// The candidate.
    pub candidate: Candidate,
    /// Whether the controller cannot be set to it.
    pub refused: bool,
    /// How often it was listened to.
    pub visits: u32,
    /// How long.
    pub listened: Micros,
    /// Good frames.
    pub frames: u32,
    /// How many of them differ, counted up to 2.
    pub distinct: u8,
    /// Bursts of protocol errors that speak against it.
    pub errors: u32,
    /// Frames destroyed at their ACK delimiter.
    pub unacknowledged: u32,
    /// Sixteenths of a bit: how much likelier than the least likely candidate.
    pub weight: u32,
}
