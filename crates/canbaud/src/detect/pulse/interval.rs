//! The bit times that the edges of one frame allow at all.
//!
//! Edges on whole ticks are late by less than one tick, so any two of them bound the bit time.
//! Where the bit time is close to a whole number of ticks, the rounding errors of a frame are all
//! alike, and least squares takes their common pattern for the bit time; the bounds do not.

use super::places::{Extent, Place, Places};

/// Bounds of a bit time in ticks times 2^20.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Interval {
    pub(super) low_q20: u64,
    pub(super) high_q20: u64,
}

/// A bound as a fraction of ticks over bits.
#[derive(Debug, Clone, Copy)]
struct Bound {
    ticks: u32,
    bits: u32,
}

impl Bound {
    fn exceeds(self, other: Self) -> bool {
        u64::from(self.ticks) * u64::from(other.bits)
            > u64::from(other.ticks) * u64::from(self.bits)
    }

    fn q20(self) -> u64 {
        (u64::from(self.ticks) << 20) / u64::from(self.bits.max(1))
    }
}

/// The bit times that all pairs of edges of one polarity allow; `None` if there are none, because
/// jitter or a second sender moved an edge by more than rounding does, or if there are so many
/// edges that rounding averages out.
pub(super) fn of(places: &Places) -> Option<Interval> {
    match places.extent {
        Extent::Whole => bounds(places.as_slice()),
        Extent::FirstPart => None,
    }
}

fn bounds(places: &[Place]) -> Option<Interval> {
    let mut low = Bound { ticks: 0, bits: 1 };
    let mut high: Option<Bound> = None;
    for (index, first) in places.iter().enumerate() {
        // Every other edge has the same polarity.
        for second in places.iter().skip(index + 2).step_by(2) {
            let ticks = second.ticks - first.ticks;
            let bits = second.bits - first.bits;
            if bits == 0 {
                return None;
            }
            let at_least = Bound { ticks: ticks.saturating_sub(1), bits };
            let at_most = Bound { ticks: ticks.saturating_add(1), bits };
            if at_least.exceeds(low) {
                low = at_least;
            }
            if high.is_none_or(|high| high.exceeds(at_most)) {
                high = Some(at_most);
            }
        }
    }
    let high = high?;
    high.exceeds(low).then(|| Interval { low_q20: low.q20(), high_q20: high.q20() })
}
