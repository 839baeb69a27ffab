//! The tightest arc: where on the bit grid the edges of one frame lie.

use super::clock::{BIT_Q20, BitClock};

/// Share of a bit that a bucket of the circle covers: 1/64.
pub(crate) const BUCKETS: u32 = 64;

/// The arc of the bit circle that holds all edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Arc {
    /// Its length in 64ths of a bit, 1 to 64.
    pub(crate) length: u32,
    /// Its middle, in bits times 2^20, 0 to 1.
    pub(crate) middle_q20: i32,
}

/// The smallest arc over the marked buckets of `mask`; a whole circle for an empty mask.
pub(crate) fn smallest_arc(mask: u64) -> Arc {
    if mask == 0 || mask == u64::MAX {
        return Arc { length: BUCKETS, middle_q20: 0 };
    }
    // Rotate so that bucket 0 is marked and bucket 63 is not: no gap wraps around then.
    let mut turn = 0;
    while turn < BUCKETS && (mask.rotate_right(turn) & 1 == 0 || mask.rotate_right(turn) >> 63 == 1)
    {
        turn += 1;
    }
    let turned = mask.rotate_right(turn);
    let (mut longest, mut longest_end) = (0, 0);
    let mut at = 0;
    while at < BUCKETS {
        let marked = (turned >> at).trailing_ones();
        at += marked;
        if at >= BUCKETS {
            break;
        }
        let empty = (turned >> at).trailing_zeros().min(BUCKETS - at);
        at += empty;
        if empty > longest {
            (longest, longest_end) = (empty, at);
        }
    }
    let length = BUCKETS - longest;
    // The arc begins where the longest gap ends; its middle lies half its length behind.
    let middle_128 = (2 * (longest_end + turn) + length) % (2 * BUCKETS);
    Arc { length, middle_q20: (middle_128 << 13) as i32 }
}

/// Whether `length` neighbouring buckets, or more, are empty.
pub(crate) const fn has_gap(mask: u64, length: u32) -> bool {
    // Bit n is set if `known` buckets from n on are empty.
    let mut empty = !mask;
    let mut known = 1;
    while known < length {
        let more = if length - known < known { length - known } else { known };
        empty &= empty.rotate_right(more);
        known += more;
    }
    empty != 0 || length == 0
}

/// The bucket of the circle that an edge `position_q20` bits (times 2^20) behind the origin
/// falls into.
pub(crate) const fn bucket(position_q20: u32) -> u32 {
    (position_q20 >> 14) & (BUCKETS - 1)
}

/// How late the first edge of `runs` came against the grid of `clock` that suits all edges best,
/// in bits times 2^20, and the arc that the edges take.
pub(crate) fn first_edge_error(runs: &[u32], clock: BitClock) -> (i32, Arc) {
    let mut mask = 1;
    let mut position = 0_u32;
    for &run in runs {
        position = position.wrapping_add(clock.bits_q20(run) as u32);
        mask |= 1_u64 << bucket(position);
    }
    let arc = smallest_arc(mask);
    let error =
        if arc.middle_q20 >= BIT_Q20 / 2 { BIT_Q20 - arc.middle_q20 } else { -arc.middle_q20 };
    (error, arc)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, by trying every rotation.
    fn smallest_by_trial(mask: u64) -> u32 {
        (1..=64)
            .find(|&length| {
                (0..64).any(|start| {
                    let arc = if length == 64 { u64::MAX } else { (1 << length) - 1_u64 };
                    mask & !arc.rotate_left(start) == 0
                })
            })
            .unwrap()
    }

    #[test]
    fn arcs_equal_the_definition() {
        let mut state = 0x1234_5678_9ABC_DEF1_u64;
        for round in 0..2000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            // From sparse to dense masks.
            let mut mask = state;
            for turn in 0..round % 5 {
                mask &= state.rotate_left(11 * (turn + 1));
            }
            if mask == 0 {
                continue;
            }
            let arc = smallest_arc(mask);
            assert_eq!(arc.length, smallest_by_trial(mask), "mask {mask:064b}");
            for length in 0..=64 {
                assert_eq!(
                    has_gap(mask, length),
                    length <= 64 - arc.length,
                    "{length} {mask:064b}"
                );
            }
        }
    }

    #[test]
    fn middle_lies_in_the_arc_across_the_wrap() {
        // Buckets 62, 63, 0, 1: four long, the middle at the origin.
        let arc = smallest_arc(0b11 | (0b11 << 62));
        assert_eq!((arc.length, arc.middle_q20), (4, 0));
        let arc = smallest_arc(0b1111 << 10);
        assert_eq!((arc.length, arc.middle_q20), (4, (12 << 20) / 64));
    }
}
