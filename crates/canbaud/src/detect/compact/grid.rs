//! The bit times at which all edges of a stretch lie on one grid.
//!
//! The time between two edges to dominant is a whole number of bits, whatever the transceivers do to
//! the edge between. The shortest such period of a frame is two to ten bits; each of these gives a
//! bit time, which the other periods make exact one after the other or refute.

use super::frame::Reader;
use crate::wire::Level;

/// Bits of the shortest period: two runs of one to five bits.
const PERIOD_BITS: core::ops::RangeInclusive<u32> = 2..=10;
/// Bits of the longest: five dominant ones, five of a CRC, its delimiter, an acknowledge that nobody
/// gave.
const PERIOD_BITS_MAX: u32 = 12;
/// Fewest ticks a bit; below, rounding a period to bits is a gamble.
const TICKS_MIN: u32 = 3;
/// Longest stretch in ticks, so that products with a number of bits have 32 bits.
const STRETCH_TICKS_MAX: u64 = 1 << 22;
/// Most bits of a classic frame, stuffed, and some.
const FRAME_BITS_MAX: u32 = 160;
/// Bits of two such frames.
const COUNT_MAX: u32 = 320;

/// The recessive runs around a stretch, in ticks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaps {
    pub(super) before: u32,
    pub(super) behind: u32,
}

/// A bit time: so many ticks are so many bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) ticks: u32,
    pub(super) bits: u32,
    /// The farthest that an edge to dominant strays, in ticks, rounded down.
    pub(super) stray_ticks: u32,
}

/// The grids that suit a stretch, from the longest bit time down.
pub(super) fn grids(runs: &[u32], gaps: Gaps) -> impl Iterator<Item = Grid> {
    let total: u64 = runs.iter().map(|&run| u64::from(run)).sum();
    let shortest = periods(runs).min().unwrap_or(0);
    let fits = total < STRETCH_TICKS_MAX;
    PERIOD_BITS
        .filter(move |&bits| {
            // The period may be a tick shorter or longer than its bits.
            let least = Grid { ticks: shortest.saturating_sub(1), bits, stray_ticks: 0 };
            fits && shortest + 1 >= bits * TICKS_MIN && least.suits(gaps)
        })
        .filter_map(move |bits| Grid::follow(runs, shortest, bits))
        .filter(move |grid| grid.suits(gaps))
}

/// The times from each edge to dominant to the next.
fn periods(runs: &[u32]) -> impl Iterator<Item = u32> {
    runs.chunks_exact(2).map(|pair| pair.iter().fold(0, |sum, &run| u32::wrapping_add(sum, run)))
}

impl Grid {
    /// Whether bits are this long between these gaps: at least nine and a half were recessive
    /// before, seven and a half behind, where an overload flag may follow.
    fn suits(&self, gaps: Gaps) -> bool {
        let halves = |gap: u32| 2 * u64::from(gap) * u64::from(self.bits);
        halves(gaps.before) >= 19 * u64::from(self.ticks)
            && halves(gaps.behind) >= 15 * u64::from(self.ticks)
    }

    /// Counts the bits of all periods, beginning with a bit time of `period / bits`; `None` if one
    /// is no whole number of bits.
    fn follow(runs: &[u32], period: u32, bits: u32) -> Option<Self> {
        // At first only periods that are clearly whole: the bit time is still rough.
        let rough = Self::count_periods(runs, (period, bits), |off, ticks| off <= ticks / 3)?;
        let all = Self::count_periods(runs, rough, |_, _| true)?;
        let (ticks, bits) = (all.0 - rough.0, all.1 - rough.1);
        Self { ticks, bits, stray_ticks: 0 }.with_stray(runs)
    }

    /// Adds the ticks and bits of the periods that are so close to whole bits that `takes` them, to
    /// those known so far.
    fn count_periods(
        runs: &[u32],
        (mut ticks, mut bits): (u32, u32),
        takes: impl Fn(u32, u32) -> bool,
    ) -> Option<(u32, u32)> {
        for next in periods(runs) {
            let whole = (next * bits + ticks / 2).checked_div(ticks)?;
            let off = (next * bits).abs_diff(whole * ticks);
            if !takes(off, ticks) {
                continue;
            }
            if whole > PERIOD_BITS_MAX || bits + whole > COUNT_MAX {
                return None;
            }
            (ticks, bits) = (ticks + next, bits + whole);
        }
        Some((ticks, bits))
    }

    /// Looks how far the edges are from the grid of the whole stretch; `None` if that is too far.
    fn with_stray(mut self, runs: &[u32]) -> Option<Self> {
        if self.bits > FRAME_BITS_MAX {
            return None;
        }
        let (mut ticks, mut most) = (0, 0);
        let mut rising = Spread::default();
        for pair in runs.chunks_exact(2) {
            let &[dominant, recessive] = pair else { break };
            rising.take(self.off(ticks + dominant));
            ticks += dominant + recessive;
            most = most.max(self.off(ticks).unsigned_abs());
        }
        let limit = self.ticks / 4 + self.bits;
        // Edges to recessive are late by what the transceivers make of them, but all alike.
        if most > limit || rising.width() > 2 * limit {
            return None;
        }
        self.stray_ticks = most.checked_div(self.bits)?;
        Some(self)
    }

    /// How far `ticks` are behind the nearest line of the grid, in ticks times its bits.
    fn off(&self, ticks: u32) -> i32 {
        let scaled = ticks * self.bits;
        let lines = (scaled + self.ticks / 2).checked_div(self.ticks).unwrap_or(0);
        scaled.wrapping_sub(lines * self.ticks) as i32
    }

    /// Whole bits of `ticks`.
    fn count(&self, ticks: u32) -> u32 {
        (ticks * self.bits + self.ticks / 2).checked_div(self.ticks).unwrap_or(0)
    }

    /// The bit time in ticks times 2^20: least squares over the edges to dominant.
    pub(super) fn fit(&self, runs: &[u32]) -> Option<u64> {
        let mut y = 0;
        let (mut n, mut sx, mut sy, mut sxx, mut sxy) = (1, 0, 0, 0, 0);
        for next in periods(runs) {
            y += next;
            let (x, y) = (u64::from(self.count(y)), u64::from(y));
            (n, sx, sy) = (n + 1, sx + x, sy + y);
            (sxx, sxy) = (sxx + x * x, sxy + x * y);
        }
        ((n * sxy - sx * sy) << 20).checked_div(n * sxx - sx * sx)
    }

    /// Whether the runs are a frame with its CRC right; counts it in `compared` if it came to the
    /// comparison.
    pub(super) fn reads(&self, runs: &[u32], compared: &mut u32) -> bool {
        let mut reader = Reader::new();
        let (mut divisor, mut bits) = (0, 0);
        for pair in runs.chunks(2) {
            let &[dominant, ref recessive @ ..] = pair else { return false };
            let low = self.count(dominant);
            let high = match recessive {
                &[recessive] => self.count(dominant + recessive),
                _ => low,
            };
            let high = high.saturating_sub(low);
            bits += if recessive.is_empty() { 0 } else { low + high };
            divisor = gcd(gcd(divisor, low), high);
            reader.take(Level::Dominant, low);
            reader.take(Level::Recessive, high);
        }
        // If all runs are multiples, a longer bit time says the same. One by one the periods have to have
        // the bits that they had on the grid.
        if divisor != 1 || bits != self.bits || !reader.ends_in_gap() {
            return false;
        }
        *compared += 1;
        reader.crc_is_right()
    }
}

/// The range of some values.
#[derive(Default)]
struct Spread {
    range: Option<(i32, i32)>,
}

impl Spread {
    fn take(&mut self, value: i32) {
        let (low, high) = self.range.unwrap_or((value, value));
        self.range = Some((low.min(value), high.max(value)));
    }

    fn width(&self) -> u32 {
        self.range.map_or(0, |(low, high)| high.abs_diff(low))
    }
}

fn gcd(mut a: u32, mut b: u32) -> u32 {
    while let Some(rest) = a.checked_rem(b) {
        (a, b) = (b, rest);
    }
    a
}
