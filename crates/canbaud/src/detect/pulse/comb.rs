//! Bit times for frames with few ticks a bit: the lattice that holds all edges.
//!
//! With one to four ticks a bit a single run says little, but all edges of a frame lie on one
//! grid, each late by less than a tick. For every bit time in question, the edges are wrapped
//! around one bit; where they fit on an arc no longer than a tick, the bit time is possible.

use super::bit_times::BitTimes;
use crate::fixed::div_small;
use crate::wire::phase::{BUCKETS, bucket, has_gap};

/// Most bits that these runs have.
const BITS_MAX: u32 = 250;
/// Runs that are looked at.
const RUNS_MAX: usize = 100;
/// Runs after which it is looked whether the arc is too long already.
const RUNS_A_LOOK: usize = 16;
/// Steps of the search in which the last edge moves by one bit.
const STEPS_A_BIT: u32 = 10;
/// Longest arc that is still a pattern, in 64ths of a bit.
const ARC_MAX: u32 = 56;
/// Shortest bit that edges on whole ticks can carry, in ticks times 2^8.
const TICKS_Q8_MIN: u64 = 320;
/// Longest bit that this search is for, in ticks times 2^8.
const TICKS_Q8_MAX: u64 = 8 << 8;

/// How much longer than one tick the arc may be, in 64ths of a bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slack {
    /// Nothing but quantisation moves the edges.
    Tight = 2,
    /// Jitter, and transceivers that shift the polarities apart.
    Loose = 10,
}

/// Bit times for one frame, the longest first; each is sought when it is asked for.
#[derive(Debug, Clone)]
pub(super) struct Comb<'a> {
    runs: &'a [u32],
    slack: Slack,
    duration_q20: u64,
    /// The next bit time, in ticks times 2^20, at most 8 ticks.
    bit_q20: u32,
    low_q20: u32,
    /// Longer ones are not looked at.
    look_max_q20: u64,
    /// The last bit time that was proposed.
    proposed_q20: u32,
    /// Bit times that the frame lasts.
    bits: u32,
}

impl<'a> Comb<'a> {
    /// For the frame with these `runs`. Most bit times that are of no
    /// use are left out.
    pub(super) fn new(runs: &'a [u32], slack: Slack, bit_times: BitTimes) -> Self {
        // The last run may be an error flag; the first runs of a long frame suffice.
        let runs = runs.split_last().map_or(runs, |(_, before)| before);
        let runs = runs.get(..RUNS_MAX).unwrap_or(runs);
        let duration: u64 = runs.iter().map(|&run| u64::from(run)).sum();
        let shortest = u64::from(runs.iter().copied().min().unwrap_or(0));
        let longest = u64::from(runs.iter().copied().max().unwrap_or(0));
        // No run is longer than five bits and a tick, none shorter than a bit less a tick.
        let low = ((longest.saturating_sub(1) << 8) / 5)
            .saturating_sub((longest << 8) / 100)
            .max(TICKS_Q8_MIN)
            .max((duration << 8) / u64::from(BITS_MAX));
        let high = ((shortest + 1) << 8).saturating_add(64).min(TICKS_Q8_MAX);
        let high_q20 = (high << 12) as u32;
        let low_q20 = u32::try_from((low << 12).max(bit_times.min_q20)).unwrap_or(u32::MAX);
        let duration_q20 = duration << 20;
        Self {
            runs,
            slack,
            duration_q20,
            bit_q20: high_q20,
            low_q20,
            // A little above what is wanted: one found there says that the next ones are the same.
            look_max_q20: bit_times.max_q20 + (bit_times.max_q20 >> 6),
            proposed_q20: u32::MAX,
            bits: 0,
        }
    }

    /// The next bit time, in ticks times 2^20.
    pub(super) fn next(&mut self) -> Option<u64> {
        while self.bit_q20 >= self.low_q20 && self.bit_q20 > 0 {
            let bit_q20 = self.bit_q20;
            while u64::from(self.bits + 1) * u64::from(bit_q20) <= self.duration_q20 {
                self.bits += 1;
            }
            let step = bit_q20.checked_div(self.bits.max(20) * STEPS_A_BIT).unwrap_or(0).max(1);
            self.bit_q20 -= step;
            // Edges on whole ticks take an arc of one tick, and the edge of a bucket on both sides.
            let limit = ((64 << 20) / bit_q20 + self.slack as u32).min(ARC_MAX);
            let is_wanted = u64::from(bit_q20) <= self.look_max_q20;
            let is_new = self.proposed_q20 - bit_q20 >= 2 * step;
            if is_wanted && is_new && arc_is_within(self.runs, bit_q20, limit) {
                self.proposed_q20 = bit_q20;
                return Some(u64::from(bit_q20));
            }
        }
        None
    }

    /// How far a bit time must be from those already tried to be another one.
    pub(super) fn apart_q20(&self, bit_q20: u64) -> u64 {
        div_small(bit_q20, self.bits.max(20) * 8)
    }
}

/// Whether the edges take an arc of at most `limit` 64ths of a bit at this bit time.
fn arc_is_within(runs: &[u32], bit_q20: u32, limit: u32) -> bool {
    // 2^32 is one bit: wrapping arithmetic is the circle.
    let step = reciprocal_q52(bit_q20);
    let mut mask = 1_u64;
    let mut at = 0_u32;
    runs.chunks(RUNS_A_LOOK).all(|runs| {
        for &run in runs {
            at = at.wrapping_add(run.wrapping_mul(step));
            mask |= 1_u64 << bucket(at >> 12);
        }
        has_gap(mask, BUCKETS - limit)
    })
}

/// The low 32 bits of 2^52 / `divisor`, for a divisor of at most 24 bits.
fn reciprocal_q52(divisor: u32) -> u32 {
    let divisor = divisor.max(1);
    let mut quotient = (1 << 28) / divisor;
    let mut rest = (1 << 28) % divisor;
    for _ in 0..3 {
        // rest < 2^24: the step fits 32 bits.
        rest <<= 8;
        quotient = (quotient << 8) | (rest / divisor);
        rest %= divisor;
    }
    quotient
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reciprocal_is_that_of_a_long_division() {
        for divisor in (1 << 20..=8 << 20).step_by(9973) {
            assert_eq!(reciprocal_q52(divisor), ((1_u64 << 52) / u64::from(divisor)) as u32);
        }
    }
}
