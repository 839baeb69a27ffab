//! Figure 1 of Koppe: ascending, the first message without an error is the answer, an error means
//! the next candidate.

use super::Decision;
use crate::detect::scan::machine::{Scan, Step};

impl<const N: usize> Scan<N> {
    /// The next faster one; from the fastest on to the slowest.
    pub(super) fn koppe_next(&self) -> Option<usize> {
        let rate = |at: usize| self.candidates.as_slice().get(at).map(|c| (c.nominal, at));
        let ascending = || self.usable().filter_map(rate);
        let last = self.last_at.and_then(rate);
        let faster = ascending().filter(|next| Some(*next) > last).min();
        faster.or_else(|| ascending().min()).map(|(_, at)| at)
    }

    pub(super) fn koppe_error(&mut self, step: &Step) -> Decision {
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.errors = track.errors.saturating_add(1);
        }
        Decision::Leave
    }
}
