//! What a scan is doing, for people who watch.

use super::Candidate;
use super::machine::{Scan, State};
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

impl<const N: usize> Scan<N> {
    /// Where the scan is.
    #[must_use]
    pub fn status(&self, now: Micros) -> Status {
        let candidate = |at: usize| self.candidates.as_slice().get(at).copied();
        let activity = match &self.state {
            State::Waiting => Some(Activity::Waiting),
            State::Switching { to, .. } => candidate(*to).map(Activity::Switching),
            State::Listening(step) if step.frames > 0 => {
                candidate(step.at).map(Activity::Confirming)
            }
            State::Listening(step) => candidate(step.at).map(Activity::Listening),
            State::Done { .. } => Some(Activity::Done),
        };
        let elapsed = match self.state {
            State::Waiting => Micros(0),
            _ => now - self.started,
        };
        Status {
            activity: activity.unwrap_or(Activity::Done),
            elapsed,
            left: self.bound().map(|bound| bound - elapsed),
            visits: self.visits,
        }
    }

    /// What speaks for and against each candidate, in the order of the list.
    pub fn standings(&self) -> impl Iterator<Item = Standing> {
        let lowest = self.tracks.iter().take(self.candidates.as_slice().len());
        let lowest = lowest.map(|track| track.standing()).min().unwrap_or(0);
        self.candidates.as_slice().iter().zip(&self.tracks).map(move |(candidate, track)| {
            Standing {
                candidate: *candidate,
                refused: track.refused,
                visits: track.visits,
                listened: track.listened,
                frames: track.frames,
                distinct: track.distinct,
                errors: track.errors,
                unacknowledged: track.unacknowledged,
                weight: track.standing().abs_diff(lowest),
            }
        })
    }
}
