//! Bit times for frames with few ticks a bit: the lattice that holds all edges.
//!
//! With one to four ticks a bit a single run says little, but all edges of a frame lie on one
//! grid, each late by less than a tick. For every bit time in question, the edges are wrapped
//! around one bit; where they fit on an arc no longer than a tick, the bit time is possible.

use super::prove::Proposals;
use crate::wire::phase::{bucket, smallest_arc};

/// Most bits that these runs have.
const BITS_MAX: u64 = 250;
/// Runs that are looked at.
const RUNS_MAX: usize = 100;
/// Steps of the search in which the last edge moves by one bit.
const STEPS_A_BIT: u64 = 10;
/// Longest arc that is still a pattern, in 64ths of a bit.
const ARC_MAX: u32 = 56;
/// Shortest bit that edges on whole ticks can carry, in ticks times 2^8.
const TICKS_Q8_MIN: u64 = 320;
/// Longest bit that this search is for, in ticks times 2^8.
const TICKS_Q8_MAX: u64 = 8 << 8;

/// Proposes bit times for the frame with these `runs`.
pub(super) fn propose(runs: &[u32], slack: Slack, proposals: &mut Proposals) {
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
        .max((duration << 8) / BITS_MAX);
    let high = ((shortest + 1) << 8).saturating_add(64).min(TICKS_Q8_MAX);
    scan(runs, duration, low << 12, high << 12, slack, proposals);
}

/// Tries bit times from `high` down to `low` (ticks times 2^20).
fn scan(runs: &[u32], duration: u64, low: u64, high: u64, slack: Slack, out: &mut Proposals) {
    let mut bit_q20 = high;
    // The last bit time that was proposed.
    let mut proposed = u64::MAX;
    while bit_q20 >= low && bit_q20 > 0 {
        let bits = ((duration << 20) / bit_q20).max(20);
        let step = (bit_q20 / (bits * STEPS_A_BIT)).max(1);
        // Edges on whole ticks take an arc of one tick, and the edge of a bucket on both sides.
        let limit = ((64_u64 << 20) / bit_q20) as u32 + slack as u32;
        if arc_length(runs, bit_q20) <= limit.min(ARC_MAX) && proposed - bit_q20 >= 2 * step {
            out.add(bit_q20, bit_q20 / (bits * 8));
            proposed = bit_q20;
        }
        bit_q20 -= step;
    }
}

/// How much longer than one tick the arc may be, in 64ths of a bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slack {
    /// Nothing but quantisation moves the edges.
    Tight = 2,
    /// Jitter, and transceivers that shift the polarities apart.
    Loose = 10,
}

/// The arc that the edges take at this bit time, in 64ths of a bit.
fn arc_length(runs: &[u32], bit_q20: u64) -> u32 {
    // 2^32 is one bit: wrapping arithmetic is the circle.
    let step = ((1_u64 << 52) / bit_q20.max(1)) as u32;
    let mut mask = 1_u64;
    let mut at = 0_u32;
    for &run in runs {
        at = at.wrapping_add(run.wrapping_mul(step));
        mask |= 1_u64 << bucket(at >> 12);
    }
    smallest_arc(mask).length
}
