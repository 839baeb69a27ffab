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
        // A run excludes from `at / FRAME_BITS_MIN` to `(run - 1) * 4 / RUN_QUARTER_BITS_MAX`; of
        // the runs whose ranges reach up from zero without a gap, `longest` has the highest end.
        let (mut max_q20, mut longest, mut at) = (max_q20, 0, 0_u64);
        let mut ends = Ends::of(max_q20);
        for &run in runs {
            let begin = at;
            if begin >= ends.at {
                break;
            }
            at += u64::from(run);
            let less_one = run.saturating_sub(1);
            if less_one > longest
                && begin * RUN_QUARTER_BITS_MAX <= u64::from(longest) * 4 * FRAME_BITS_MIN
            {
                longest = less_one;
            }
            if less_one >= ends.less_one {
                max_q20 = div_small(begin << 20, FRAME_BITS_MIN as u32);
                ends = Ends::of(max_q20);
            }
        }
        let longest = u64::from(longest);
        let min_q20 = div_small(longest << 22, RUN_QUARTER_BITS_MAX as u32);
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

/// From where on runs do not matter, and how long a run excludes the longest bit time.
struct Ends {
    at: u64,
    less_one: u32,
}

impl Ends {
    fn of(max_q20: u64) -> Self {
        let at = (FRAME_BITS_MIN.saturating_mul(max_q20)).div_ceil(1 << 20);
        let less_one = (RUN_QUARTER_BITS_MAX.saturating_mul(max_q20)).div_ceil(1 << 22);
        Self { at, less_one: u32::try_from(less_one).unwrap_or(u32::MAX) }
    }
}
