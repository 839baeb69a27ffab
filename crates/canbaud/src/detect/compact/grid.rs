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
/// The last edge to dominant may be that of an acknowledge, which comes from other nodes, later: it
/// says nothing about the sender's grid. So many runs lie between it and the one before, with it.
const ACKNOWLEDGE_RUNS: usize = 2;
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
}

/// What a frame said about the bit time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Measured {
    /// Least squares over the edges to dominant, in ticks times 2^20.
    pub(super) ticks_q20: u64,
    /// The farthest that one of them strays, in ticks, rounded down.
    pub(super) stray_ticks: u32,
    /// Another for another frame, mostly.
    pub(super) print: u32,
}

/// The grids that suit a stretch, from the longest bit time down.
pub(super) fn grids(runs: &[u32], gaps: Gaps) -> impl Iterator<Item = Grid> {
    let total: u64 = runs.iter().map(|&run| u64::from(run)).sum();
    let own = runs.get(..runs.len().saturating_sub(ACKNOWLEDGE_RUNS)).unwrap_or(&[]);
    let shortest = periods(own).min().unwrap_or(0);
    let fits = total < STRETCH_TICKS_MAX;
    PERIOD_BITS
        .filter(move |&bits| {
            // The period may be a tick shorter or longer than its bits.
            let longest = u64::from(shortest) + 1;
            let is_short = total * u64::from(bits) <= longest * u64::from(FRAME_BITS_MAX);
            let least = Grid { ticks: shortest.saturating_sub(1), bits };
            fits && is_short && longest >= u64::from(bits * TICKS_MIN) && least.suits(gaps)
        })
        .filter_map(move |bits| Grid::follow(own, shortest, bits))
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
        let rough = Self::count_periods(runs, (period, bits), Pass::Rough)?;
        let all = Self::count_periods(runs, rough, Pass::All)?;
        let (ticks, bits) = (all.0 - rough.0, all.1 - rough.1);
        (bits <= FRAME_BITS_MAX).then_some(Self { ticks, bits })
    }

    /// Adds the ticks and bits of the periods to those known so far.
    fn count_periods(
        runs: &[u32],
        (mut ticks, mut bits): (u32, u32),
        pass: Pass,
    ) -> Option<(u32, u32)> {
        for next in periods(runs) {
            let scaled = next * bits;
            let whole = (scaled + ticks / 2).checked_div(ticks)?;
            let off = scaled.abs_diff(whole * ticks);
            match pass {
                Pass::Rough if off > ticks / 3 => continue,
                // A quarter of a bit and a tick.
                Pass::All if off > ticks / 4 + bits => return None,
                _ if whole > PERIOD_BITS_MAX || bits + whole > COUNT_MAX => return None,
                _ => (ticks, bits) = (ticks + next, bits + whole),
            }
        }
        Some((ticks, bits))
    }

    /// Reads the frame if all edges lie on the grid and the CRC is right; counts in `compared` if it
    /// came to the comparison.
    pub(super) fn read(&self, runs: &[u32], compared: &mut u32) -> Option<Measured> {
        // Places are counted in ticks times the bits of the grid, whose lines are `ticks` apart.
        let limit = self.ticks / 4 + self.bits;
        let mut reader = Reader::new();
        let mut rising = Spread::default();
        let mut line = Line::default();
        let (mut off, mut stray) = (0, 0);
        let own = runs.len().saturating_sub(ACKNOWLEDGE_RUNS) / 2;
        for (index, pair) in runs.chunks(2).enumerate() {
            let &[dominant, ref recessive @ ..] = pair else { return None };
            let (low, late) = self.nearest(dominant, off);
            reader.take(Level::Dominant, low);
            let &[recessive] = recessive else { break };
            rising.take(late);
            let whole;
            (whole, off) = self.nearest(dominant + recessive, off);
            let high = whole.saturating_sub(low);
            reader.take(Level::Recessive, high);
            if index < own {
                stray = off.unsigned_abs().max(stray);
                line.take(whole, dominant + recessive);
            }
            // Edges to recessive are late by what the transceivers make of them, but all alike.
            if reader.is_wrong() || stray > limit || rising.width() > 2 * limit {
                return None;
            }
        }
        if !reader.ends_in_gap() {
            return None;
        }
        *compared = compared.saturating_add(1);
        let ticks_q20 = line.slope_q20().filter(|_| reader.crc_is_right())?;
        let print = reader.print();
        Some(Measured { ticks_q20, stray_ticks: stray.checked_div(self.bits)?, print })
    }

    /// The line that is nearest to a place `ticks` behind one that is `off` behind its line, and how
    /// far it is behind that; counts up to [`PERIOD_BITS_MAX`] lines. Without a division, which is
    /// dear on small controllers.
    fn nearest(&self, ticks: u32, off: i32) -> (u32, i32) {
        let step = self.ticks as i32;
        let mut rest = (ticks * self.bits) as i32 + off;
        let mut lines = 0;
        while rest > step / 2 && lines <= PERIOD_BITS_MAX {
            rest -= step;
            lines += 1;
        }
        (lines, rest)
    }
}

/// Least squares over the edges to dominant; the first is at the origin.
#[derive(Default)]
struct Line {
    bits: u32,
    ticks: u32,
    edges: u32,
    sum_bits: u32,
    sum_ticks: u64,
    squares: u32,
    products: u64,
}

impl Line {
    fn take(&mut self, bits: u32, ticks: u32) {
        self.bits += bits;
        self.ticks += ticks;
        self.edges += 1;
        self.sum_bits += self.bits;
        self.sum_ticks += u64::from(self.ticks);
        self.squares += self.bits * self.bits;
        self.products += u64::from(self.bits * self.ticks);
    }

    fn slope_q20(&self) -> Option<u64> {
        let count = self.edges + 1;
        let covariance =
            u64::from(count) * self.products - u64::from(self.sum_bits) * self.sum_ticks;
        let variance = count * self.squares - self.sum_bits * self.sum_bits;
        (covariance << 20).checked_div(u64::from(variance))
    }
}

/// Which periods count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pass {
    /// Those that are clearly whole bits: the bit time is still rough.
    Rough,
    /// All of them.
    All,
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
