//! What most tools do: each candidate for the same time, in the order of the list, over and over.

use crate::detect::scan::machine::Scan;

impl<const N: usize> Scan<N> {
    pub(super) fn fixed_dwell_next(&self) -> Option<usize> {
        let behind = |at: &usize| self.last_at.is_none_or(|last| *at > last);
        self.usable().find(behind).or_else(|| self.usable().next())
    }
}
