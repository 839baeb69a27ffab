//! Bit times for frames with several ticks a bit, from few additions.
//!
//! The time between two recessive-to-dominant edges is a whole number of bits, whatever the
//! transceivers do to the edges between. The shortest such period of the first part of a frame
//! is two to ten bits; each of these gives a first bit time, which the other periods then make
//! exact. The first part only, because a CAN FD frame goes on at another rate.

use super::bit_times::BitTimes;
use crate::fixed::div_small;

/// Fewest ticks a bit for this method; below, rounding a period to bits is a gamble.
const TICKS_MIN: u64 = 3;
/// Periods at the start of the frame among which the shortest is sought.
const WINDOWS: [usize; 4] = [3, 5, 8, usize::MAX];
/// The shortest period is at least so many bits.
const BITS_MIN: u32 = 2;
/// And at most so many.
const BITS_MAX: u32 = 8;
/// Two edges to dominant are at most so many bits apart: five of each level.
const PERIOD_BITS_MAX: u32 = 10;

/// Bit times for one frame, the longest first; each is worked out when it is asked for.
#[derive(Debug, Clone)]
pub(super) struct Coarse<'a> {
    runs: &'a [u32],
    bit_times: BitTimes,
    /// The windows from the current one on.
    windows: &'static [usize],
    shortest: u32,
    /// Bits of the shortest period to try next.
    bits: u32,
}

impl<'a> Coarse<'a> {
    /// For the frame with these `runs`. Most bit times that are of no use are left out.
    pub(super) fn new(runs: &'a [u32], bit_times: BitTimes) -> Self {
        let mut search = Self { runs, bit_times, windows: &WINDOWS, shortest: 0, bits: BITS_MIN };
        search.enter_window();
        search
    }

    /// The next bit time, in ticks times 2^20.
    pub(super) fn next(&mut self) -> Option<u64> {
        while let &[window, ..] = self.windows {
            let first_q8 = div_small(u64::from(self.shortest) << 8, self.bits);
            if self.bits > BITS_MAX || first_q8 < TICKS_MIN << 8 {
                self.windows = match self.windows.split_first() {
                    Some((_, rest)) if window < self.runs.len() / 2 => rest,
                    _ => &[],
                };
                self.enter_window();
                continue;
            }
            self.bits += 1;
            // The bit time that comes out is a third longer or a quarter shorter at most.
            let (min_q8, max_q8) = (self.bit_times.min_q20 >> 12, self.bit_times.max_q20 >> 12);
            if first_q8 > max_q8 + max_q8 / 2 || first_q8 + first_q8 / 2 < min_q8 {
                continue;
            }
            let period = (self.shortest, first_q8);
            if let Some(bit_q20) = refine(self.runs, window, period, self.bit_times) {
                return Some(bit_q20);
            }
        }
        None
    }

    fn enter_window(&mut self) {
        let window = self.windows.first().copied().unwrap_or(0);
        match periods(self.runs).take(window).min() {
            Some(shortest) => (self.shortest, self.bits) = (shortest, BITS_MIN),
            None => self.windows = &[],
        }
    }
}

/// Times between successive edges to dominant, in ticks.
fn periods(runs: &[u32]) -> impl Iterator<Item = u32> + '_ {
    runs.chunks_exact(2).map(|pair| pair.iter().fold(0_u32, |sum, &run| sum.saturating_add(run)))
}

/// Makes the bit time `first_q8` (ticks times 2^8) exact: first from periods up to twice the
/// `shortest`, where it hardly miscounts, then from the longest stretch of edges that fits it.
fn refine(
    runs: &[u32],
    window: usize,
    (shortest, first_q8): (u32, u64),
    bit_times: BitTimes,
) -> Option<u64> {
    let (mut ticks, mut bits) = (0_u64, 0_u32);
    for period in periods(runs).take(window) {
        // At twice its length, a count off by a quarter of the shortest period is still right.
        if u64::from(period) <= 2 * u64::from(shortest) {
            ticks += u64::from(period);
            bits += count_bits(u64::from(period) << 8, first_q8, 2 * BITS_MAX);
        }
    }
    if bits == 0 {
        return None;
    }
    let mut bit_q20 = div_small(ticks << 20, bits);
    if !bit_times.are_near(bit_q20) {
        return None;
    }
    // From the first edge on, each edge that lies on the grid sharpens the bit time.
    let (mut at, mut whole) = (0_u64, 0_u32);
    for (index, period) in periods(runs).enumerate() {
        at += u64::from(period);
        let count = count_bits(u64::from(period) << 20, bit_q20, PERIOD_BITS_MAX);
        if !(BITS_MIN..=PERIOD_BITS_MAX).contains(&count) {
            return (index >= 3).then_some(bit_q20);
        }
        let off = (at << 20).abs_diff(u64::from(whole + count) * bit_q20);
        // A tick of rounding and a third of a bit.
        if 3 * off > bit_q20 + 3 * (1 << 20) {
            return (index >= 3).then_some(bit_q20);
        }
        whole += count;
        // The first periods are too short to improve on the average of several.
        if whole > bits {
            bit_q20 = div_small(at << 20, whole);
        }
    }
    Some(bit_q20)
}

/// `span / bit` rounded to the nearest whole number; more than `most` where it is more.
fn count_bits(span: u64, bit: u64, most: u32) -> u32 {
    let mut rest = span + bit / 2;
    let mut count = 0;
    // A few subtractions cost less than a division.
    while rest >= bit && count <= most {
        rest -= bit;
        count += 1;
    }
    count
}
