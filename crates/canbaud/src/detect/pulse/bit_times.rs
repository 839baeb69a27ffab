//! Which bit times a stretch of runs can have at all, before any is worked out.
//!
//! Stuffing allows five equal bits. A run excludes the bit times at which it is longer, and at
//! which it begins so early that no frame can have ended: from its start over the length of the
//! shortest frame, up to its length over the longest of runs.

use crate::fixed::div_small;

/// The shortest frame has more bits than this, counted at the nominal bit rate.
const FRAME_BITS_MIN: u64 = 20;
/// A run has less than 5 3/4 bits and a tick: five, and what transceivers add.
const RUN_QUARTER_BITS_MAX: u64 = 23;

/// The bit times that are worth trying, in ticks times 2^20: some between these bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BitTimes {
    pub(super) min_q20: u64,
    pub(super) max_q20: u64,
}

impl BitTimes {
    /// For a frame with these `runs`, up to `max_q20`; `None` if there are none.
    pub(super) fn of(runs: &[u32], max_q20: u64) -> Option<Self> {
        let (mut min_q20, mut max_q20) = (0, max_q20);
        let mut at = 0_u64;
        for &run in runs {
            let begin_q20 = div_small(at << 20, FRAME_BITS_MIN as u32);
            if begin_q20 >= max_q20 {
                break;
            }
            // Between `begin` and `end` the run excludes all.
            let end_q20 = longest_q20(run);
            if begin_q20 <= min_q20 {
                min_q20 = end_q20.max(min_q20);
            }
            if end_q20 >= max_q20 {
                max_q20 = begin_q20;
            }
            at += u64::from(run);
        }
        (min_q20 < max_q20).then_some(Self { min_q20, max_q20 })
    }

    /// Whether no run excludes this one.
    pub(super) fn allow(&self, runs: &[u32], bit_q20: u64) -> bool {
        let mut at = 0_u64;
        for &run in runs {
            if at << 20 >= FRAME_BITS_MIN * bit_q20 {
                break;
            }
            if u64::from(run.saturating_sub(1)) << 22 > RUN_QUARTER_BITS_MAX * bit_q20 {
                return false;
            }
            at += u64::from(run);
        }
        (self.min_q20..=self.max_q20).contains(&bit_q20)
    }

    /// Whether a first guess may come out as one of them: an eighth more or less.
    pub(super) fn are_near(&self, bit_q20: u64) -> bool {
        bit_q20 <= self.max_q20 + self.max_q20 / 8 && bit_q20 + bit_q20 / 8 >= self.min_q20
    }
}

/// The bit time at which a run is just too long.
fn longest_q20(run: u32) -> u64 {
    div_small(u64::from(run.saturating_sub(1)) << 22, RUN_QUARTER_BITS_MAX as u32)
}
