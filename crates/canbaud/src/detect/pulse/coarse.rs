//! Bit times for frames with several ticks a bit, from few additions.
//!
//! The time between two recessive-to-dominant edges is a whole number of bits, whatever the
//! transceivers do to the edges between. The shortest such period of the first part of a frame
//! is two to ten bits; each of these gives a first bit time, which the other periods then make
//! exact. The first part only, because a CAN FD frame goes on at another rate.

use super::prove::Proposals;

/// Fewest ticks a bit for this method; below, rounding a period to bits is a gamble.
const TICKS_MIN: u32 = 3;
/// Periods at the start of the frame among which the shortest is sought.
const WINDOWS: [usize; 4] = [3, 5, 8, usize::MAX];
/// The shortest period is one of these many bits.
const BITS: core::ops::RangeInclusive<u32> = 2..=8;

/// Proposes bit times for the frame with these `runs`, the longest first.
pub(super) fn propose(runs: &[u32], proposals: &mut Proposals) {
    for window in WINDOWS {
        let Some(shortest) = periods(runs).take(window).min() else { return };
        for bits in BITS {
            let first_q8 = (u64::from(shortest) << 8) / u64::from(bits);
            if first_q8 < u64::from(TICKS_MIN) << 8 {
                break;
            }
            if let Some(ticks_q20) = refine(runs, window, shortest, first_q8) {
                proposals.add(ticks_q20, ticks_q20 / 1000);
            }
        }
        if window >= runs.len() / 2 {
            break;
        }
    }
}

/// Times between successive edges to dominant, in ticks.
fn periods(runs: &[u32]) -> impl Iterator<Item = u32> + '_ {
    runs.chunks_exact(2).map(|pair| pair.iter().fold(0_u32, |sum, &run| sum.saturating_add(run)))
}

/// Makes the bit time `first_q8` (ticks times 2^8) exact: first from periods up to twice the
/// `shortest`, where it hardly miscounts, then from the longest stretch of edges that fits it.
fn refine(runs: &[u32], window: usize, shortest: u32, first_q8: u64) -> Option<u64> {
    let (mut ticks, mut bits) = (0_u64, 0_u64);
    for period in periods(runs).take(window) {
        let count = round_div(u64::from(period) << 8, first_q8);
        // At twice its length, a count off by a quarter of the shortest period is still right.
        if u64::from(period) <= 2 * u64::from(shortest) {
            ticks += u64::from(period);
            bits += count;
        }
    }
    if bits == 0 {
        return None;
    }
    let mut bit_q20 = (ticks << 20) / bits;
    // From the first edge on, each edge that lies on the grid sharpens the bit time.
    let (mut at, mut whole) = (0_u64, 0_u64);
    for (index, period) in periods(runs).enumerate() {
        at += u64::from(period);
        let count = round_div(u64::from(period) << 20, bit_q20);
        if !(2..=10).contains(&count) {
            return (index >= 3).then_some(bit_q20);
        }
        let off = (at << 20).abs_diff((whole + count) * bit_q20);
        // A tick of rounding and a third of a bit.
        if off > bit_q20 / 3 + (1 << 20) {
            return (index >= 3).then_some(bit_q20);
        }
        whole += count;
        // The first periods are too short to improve on the average of several.
        if whole > bits {
            bit_q20 = (at << 20) / whole;
        }
    }
    Some(bit_q20)
}

fn round_div(numerator: u64, denominator: u64) -> u64 {
    (numerator + denominator / 2) / denominator.max(1)
}
