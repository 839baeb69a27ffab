//! Measures: every candidate is listened to once, and the middle of those that can be read is the
//! answer.

use super::Decision;
use crate::detect::scan::machine::{Scan, Step};

/// Errors in a step after which a candidate cannot be read: one may be a destroyed frame.
const ERRORS: u32 = 2;

impl<const N: usize> Scan<N> {
    fn survey_is_complete(&self) -> bool {
        self.usable().all(|at| self.tracks.get(at).is_some_and(|track| track.visits > 0))
    }

    /// One that was not listened to yet; then the middle of those that were read.
    pub(super) fn survey_next(&self) -> Option<usize> {
        let fresh = |at: &usize| self.tracks.get(*at).is_some_and(|track| track.visits == 0);
        if let Some(next) = self.usable().find(fresh) {
            return Some(next);
        }
        let read = |at: &usize| self.tracks.get(*at).is_some_and(|track| track.frames > 0);
        let rate = |at: &usize| self.candidates.as_slice().get(*at).map(|c| c.nominal);
        let rank = |at: &usize| self.usable().filter(read).filter(|o| rate(o) < rate(at)).count();
        let middle = self.usable().filter(read).count().saturating_sub(1) / 2;
        self.usable().filter(read).find(|at| rank(at) == middle)
    }

    pub(super) fn survey_frame(&self, step: &Step) -> Decision {
        let again = self.tracks.get(step.at).is_some_and(|track| track.visits > 1);
        if again && self.survey_is_complete() { Decision::Announce } else { Decision::Leave }
    }

    pub(super) fn survey_error(&mut self, step: &mut Step) -> Decision {
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.errors = track.errors.saturating_add(1);
        }
        step.doubts += 1;
        if step.doubts >= ERRORS { Decision::Leave } else { Decision::Stay }
    }
}
