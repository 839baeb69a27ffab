//! The bit times that the edges of one frame allow at all.
//!
//! Edges on whole ticks are late by less than one tick, so any two of them bound the bit time.
//! Where the bit time is close to a whole number of ticks, the rounding errors of a frame are all
//! alike, and least squares takes their common pattern for the bit time; the bounds do not.

use super::places::{Extent, Place, Places};
use crate::fixed::div_small;

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
        div_small(u64::from(self.ticks) << 20, self.bits)
    }
}

/// Which bound is sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The greatest lower bound: two edges were at least their ticks less one apart.
    Low,
    /// The least upper bound: they were at most one more apart.
    High,
}

impl Side {
    /// What two edges say about the bit time.
    fn bound(self, first: Place, second: Place) -> Bound {
        let ticks = second.ticks - first.ticks;
        let ticks = match self {
            Self::Low => ticks.saturating_sub(1),
            Self::High => ticks.saturating_add(1),
        };
        Bound { ticks, bits: second.bits - first.bits }
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
    // Every other edge has the same polarity; none may be on the same bit.
    let mut pairs = places.iter().zip(places.iter().skip(2));
    if places.len() < 3 || pairs.any(|(first, second)| first.bits == second.bits) {
        return None;
    }
    let (low, high) = (tightest(places, Side::Low)?, tightest(places, Side::High)?);
    high.exceeds(low).then(|| Interval { low_q20: low.q20(), high_q20: high.q20() })
}

/// The tightest bound that two edges of one polarity set.
///
/// Not by trying all pairs but by Newton's method: at a bound, each edge has a distance from the
/// grid; the two with the greatest difference violate it most and set the next, tighter bound.
fn tightest(places: &[Place], side: Side) -> Option<Bound> {
    let (&first, &last) = (places.first()?, places.iter().step_by(2).next_back()?);
    let mut bound = side.bound(first, last);
    for _ in 0..places.len() {
        let tighter = [0, 1].into_iter().fold(None, |most, parity| {
            violation(places.get(parity..).unwrap_or(&[]), side, bound, most)
        });
        match tighter {
            Some(violation) => bound = side.bound(violation.first, violation.second),
            None => break,
        }
    }
    Some(bound)
}

/// Two edges that are closer, or farther apart, than a bound says.
#[derive(Debug, Clone, Copy)]
struct Violation {
    first: Place,
    second: Place,
    /// By how much, in ticks times the bits of the bound.
    by: i64,
}

/// The two of every other edge that violate `bound` most, if more than `most` does.
fn violation(
    places: &[Place],
    side: Side,
    bound: Bound,
    mut most: Option<Violation>,
) -> Option<Violation> {
    let (mut first, mut least) = (*places.first()?, i64::MAX);
    let mut by_most = most.map_or(i64::from(bound.bits), |most| most.by);
    for &place in places.iter().step_by(2) {
        // How far the edge is behind the grid of the bound, or ahead of it.
        let behind = i64::from(place.ticks) * i64::from(bound.bits)
            - i64::from(place.bits) * i64::from(bound.ticks);
        let off = if side == Side::Low { behind } else { -behind };
        if off < least {
            (first, least) = (place, off);
        } else if off - least > by_most {
            by_most = off - least;
            most = Some(Violation { first, second: place, by: by_most });
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Edges of a bit time of `ticks_q20`, each on the first tick at or after its time.
    fn places(ticks_q20: u64, mut state: u64) -> Vec<Place> {
        let mut at = 0;
        (0..60)
            .map(|_| {
                let place =
                    Place { ticks: (at * ticks_q20).div_ceil(1 << 20) as u32, bits: at as u32 };
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                at += 1 + state % 5;
                place
            })
            .collect()
    }

    /// The definition: all pairs of a polarity.
    fn by_all_pairs(places: &[Place], side: Side) -> Bound {
        let pairs = (0..places.len()).flat_map(|first| {
            (first + 2..places.len()).step_by(2).map(move |second| (first, second))
        });
        let bounds = pairs.map(|(first, second)| side.bound(places[first], places[second]));
        bounds
            .reduce(|best, bound| match side {
                Side::Low if bound.exceeds(best) => bound,
                Side::High if best.exceeds(bound) => bound,
                _ => best,
            })
            .unwrap()
    }

    #[test]
    fn bounds_are_those_of_all_pairs_and_hold_the_bit_time() {
        for seed in 1..=200_u64 {
            let ticks_q20 = (3 << 19) + seed * 777_777;
            let places = places(ticks_q20, seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
            for side in [Side::Low, Side::High] {
                let (all, newton) = (by_all_pairs(&places, side), tightest(&places, side).unwrap());
                assert!(!all.exceeds(newton) && !newton.exceeds(all), "seed {seed} {side:?}");
            }
            let interval = bounds(&places).unwrap();
            assert!(interval.low_q20 <= ticks_q20 && ticks_q20 <= interval.high_q20, "seed {seed}");
        }
    }
}
