//! How well the edges of a frame lie on the grid of a bit time.
//!
//! A CRC alone is right by chance once in 32768 readings. At two thirds of a bit time, say, many
//! runs still round to bits; but then the edges stray from the grid, and nothing in a bus moves
//! them so far.

use super::places::{Place, Places};
use crate::fixed::div_small;

/// How far an edge strays from the grid, in ticks times 2^10.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stray {
    /// Variance of the edges about their polarity's mean, in ticks^2 times 2^20.
    pub(super) variance_q20: u64,
    /// The farthest edge.
    farthest_q10: u64,
    /// Edges to recessive against edges to dominant.
    asymmetry_q10: u64,
}

impl Stray {
    /// Of the edges at `places` from the grid of `ticks_q20` ticks a bit (times 2^20).
    pub(super) fn of(places: &Places, ticks_q20: u64) -> Self {
        let falling = Group::of(places.as_slice().iter().step_by(2), ticks_q20);
        let rising = Group::of(places.as_slice().iter().skip(1).step_by(2), ticks_q20);
        // The slope and two means are fitted.
        let freedom = (falling.count + rising.count).saturating_sub(3).max(1);
        Self {
            variance_q20: div_small(falling.squares.saturating_add(rising.squares), freedom as u32),
            farthest_q10: falling.farthest.max(rising.farthest),
            asymmetry_q10: match (falling.count, rising.count) {
                (0, _) | (_, 0) => 0,
                _ => falling.mean.abs_diff(rising.mean),
            },
        }
    }

    /// Whether a bus with `ticks_q20` ticks a bit does that: jitter, delays between senders and
    /// rounding move an edge by up to a quarter of a bit and a tick, transceivers move the
    /// polarities apart by up to three tenths of a bit.
    pub(super) const fn is_of_a_bus(&self, ticks_q20: u64) -> bool {
        let bit_q10 = ticks_q20 >> 10;
        let tick_q10 = 1 << 10;
        self.farthest_q10 <= bit_q10 / 4 + tick_q10
            && self.asymmetry_q10 <= bit_q10 * 3 / 10 + tick_q10
            && self.variance_q20
                <= (bit_q10.saturating_mul(bit_q10)) / 64 + (tick_q10 * tick_q10) / 6
    }
}

/// The edges of one polarity; deviations in ticks times 2^10.
struct Group {
    count: u64,
    mean: i64,
    squares: u64,
    farthest: u64,
}

impl Group {
    fn of<'a>(places: impl Iterator<Item = &'a Place> + Clone, ticks_q20: u64) -> Self {
        let deviation = |place: &Place| {
            let bits = u64::from(place.bits);
            // In two parts, because the product may have more than 64 bits.
            let grid = bits * (ticks_q20 >> 10) + ((bits * (ticks_q20 & 0x3FF)) >> 10);
            (i64::from(place.ticks) << 10) - grid as i64
        };
        let (mut count, mut sum, mut least, mut greatest) = (0_u64, 0_i64, i64::MAX, i64::MIN);
        for off in places.clone().map(deviation) {
            count += 1;
            sum += off;
            least = least.min(off);
            greatest = greatest.max(off);
        }
        if count == 0 {
            return Self { count, mean: 0, squares: 0, farthest: 0 };
        }
        let mean = div_small(sum.unsigned_abs(), count as u32) as i64 * sum.signum();
        let off = places.map(|place| deviation(place).abs_diff(mean));
        let squares = off.fold(0_u64, |sum, o| sum.saturating_add(o.saturating_mul(o)));
        Self { count, mean, squares, farthest: mean.abs_diff(least).max(mean.abs_diff(greatest)) }
    }
}
