//! From what is known to what is said in the end.

use super::machine::{Scan, Step};
use super::track::Track;
use super::{
    Acknowledgement, Candidate, Evidence, FdSeen, FdSupport, Found, Ground, Misfit, Outcome, Policy,
};
use crate::units::Micros;

/// How far the bus may be from the middle of the rates that could be read, in thousandths.
const SURVEYED_PERMILLE: u16 = 17;

impl<const N: usize> Scan<N> {
    pub(super) fn found(&self, step: &Step, now: Micros) -> Outcome {
        let track = self.tracks.get(step.at).copied().unwrap_or_default();
        let candidate = self.candidates.as_slice().get(step.at).copied();
        let suspected = self.fd == FdSupport::Classic && track.errors > 1;
        let fd = match (track.fd, track.switched) {
            (true, true) => FdSeen::Switched,
            (true, false) => FdSeen::NeverSwitched,
            (false, _) if suspected && track.in_arbitration == 0 => FdSeen::Suspected,
            (false, _) => FdSeen::No,
        };
        let reach_permille = match self.settings.policy {
            Policy::Survey => SURVEYED_PERMILLE,
            _ => candidate.map_or(0, |candidate| candidate.capture.reach_permille()),
        };
        Outcome::Found(Found {
            reach_permille,
            candidate: candidate.unwrap_or(Candidate::classic(step.configured.nominal)),
            configured: step.configured,
            frames: track.frames,
            distinct: track.distinct,
            errors: track.errors,
            elapsed: now - self.started,
            visits: self.visits,
            acknowledgement: if track.unacknowledged > 0 {
                Acknowledgement::Missing
            } else {
                Acknowledgement::Presumed
            },
            fd,
        })
    }

    pub(super) fn without_verdict(&self) -> Outcome {
        // A lone frame that nothing confirmed is no sign that the others were missed.
        if self.traffic.tells || self.traffic.edges {
            let ground = if self.all_refuted() { Ground::Refuted } else { Ground::OutOfTime };
            return Outcome::NoCandidateFits(Misfit { perhaps_fd: self.perhaps_fd(), ground });
        }
        match self.evidence {
            Evidence::Errors => Outcome::Silent,
            // A counter that never moved may be a frozen one.
            Evidence::Counter | Evidence::FramesOnly => Outcome::StillOpen,
        }
    }

    fn perhaps_fd(&self) -> Option<Candidate> {
        if self.fd == FdSupport::Fd || !self.traffic.tells_arbitration {
            return None;
        }
        let past = |track: &Track| track.errors >= 4 && track.in_arbitration == 0;
        let mut all = self.candidates.as_slice().iter().zip(&self.tracks).filter(|(_, t)| past(t));
        match (all.next(), all.next()) {
            (Some((candidate, _)), None) => Some(*candidate),
            _ => None,
        }
    }
}
