//! Bit times for frames with few ticks a bit: the lattice that holds all edges.
//!
//! With one to four ticks a bit a single run says little, but all edges of a frame lie on one
//! grid, each late by less than a tick. For every bit time in question, the edges are wrapped
//! around one bit; where they fit on an arc no longer than a tick, the bit time is possible.

use super::prove::Proposals;
use crate::wire::phase::{bucket, smallest_arc};

/// Bits of the longest classic frame with all its stuff bits.
const FRAME_BITS_MAX: u64 = 140;
/// Steps of the search in which the last edge moves by one bit.
const STEPS_A_BIT: u64 = 10;
/// Longest arc that is still a pattern, in 64ths of a bit.
const ARC_MAX: u32 = 56;
/// Shortest bit that edges on whole ticks can carry, in ticks times 2^8.
const TICKS_Q8_MIN: u64 = 320;
/// Longest bit that this search is for, in ticks times 2^8.
const TICKS_Q8_MAX: u64 = 8 << 8;

/// Proposes bit times for the frame with these `runs`.
pub(super) fn propose(runs: &[u32], proposals: &mut Proposals) {
    let duration: u64 = runs.iter().map(|&run| u64::from(run)).sum();
    let shortest = u64::from(runs.iter().copied().min().unwrap_or(0));
    let longest = u64::from(runs.iter().copied().max().unwrap_or(0));
    // No run is longer than five bits and a tick, none shorter than a bit less a tick.
    let low = ((longest.saturating_sub(1) << 8) / 5 - ((longest << 8) / 100))
        .max(TICKS_Q8_MIN)
        .max((duration << 8) / FRAME_BITS_MAX);
    let high = ((shortest + 1) << 8).saturating_add(64).min(TICKS_Q8_MAX);
    scan(runs, duration, low << 12, high << 12, proposals);
}

/// Tries bit times from `high` down to `low` (ticks times 2^20).
fn scan(runs: &[u32], duration: u64, low: u64, high: u64, proposals: &mut Proposals) {
    let mut bit_q20 = high;
    let mut valley: Option<Valley> = None;
    while bit_q20 >= low && bit_q20 > 0 {
        let arc = arc_length(runs, bit_q20);
        // An arc of one tick, and a little for jitter.
        let limit = ((64_u64 << 20) / bit_q20) as u32 + 6;
        if arc <= limit.min(ARC_MAX) {
            valley = Some(match valley {
                Some(open) if open.arc < arc => open,
                Some(open) if open.arc == arc => Valley { low: bit_q20, ..open },
                _ => Valley { arc, high: bit_q20, low: bit_q20 },
            });
        } else if let Some(done) = valley.take() {
            proposals.add(done.middle());
        }
        // One step moves the last edge by a tenth of a bit.
        let bits = ((duration << 20) / bit_q20).max(20);
        bit_q20 -= (bit_q20 / (bits * STEPS_A_BIT)).max(1);
    }
    if let Some(done) = valley {
        proposals.add(done.middle());
    }
}

/// Neighbouring bit times that fit; the best of them.
#[derive(Debug, Clone, Copy)]
struct Valley {
    arc: u32,
    high: u64,
    low: u64,
}

impl Valley {
    const fn middle(self) -> u64 {
        self.low + (self.high - self.low) / 2
    }
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
