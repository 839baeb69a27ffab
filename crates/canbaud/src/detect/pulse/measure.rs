//! A bit time with its uncertainty, from the edges of proven frames.

use super::interval::Interval;
use crate::detect::BitTime;
use crate::fixed::{div_small, div_wide, ratio_q20, sqrt};
use crate::wire::{Fit, PhaseSums};

/// Least squares over any number of frames; each frame has its own origin.
///
/// ```
/// use canbaud::detect::Measurement;
/// assert_eq!(Measurement::default().bit_time(), None);
/// ```
// Its 128-bit numbers would align a detector to 16 bytes on some hosts, more than C does by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(Rust, packed(8))]
pub struct Measurement {
    sxx_q8: u128,
    sxy_q8: u128,
    /// The bit time of the first frame in ticks times 2^20; deviations are counted from it.
    pivot_q20: u64,
    /// Weighted sum of the deviations of the frames' bit times, times 2^28.
    deviation_q28: i128,
    /// The same of their squares, times 2^48.
    squares_q48: u128,
    frames: u32,
    edges: u64,
    asymmetry_q8: i64,
    /// Variance of an edge in ticks^2 times 2^20, where it was measured.
    noise_q20: u64,
    /// The bit time of the first frame from its bounds, in ticks times 2^20.
    bounded_q20: Option<u64>,
}

/// Variance of an edge on whole ticks: a twelfth of a tick squared, times 2^20.
const QUANTISATION_Q20: u64 = (1 << 20) / 12;

impl Measurement {
    /// Takes the edges of one frame.
    pub fn add(&mut self, sums: &PhaseSums) {
        self.add_fit(&sums.fit());
    }

    /// Takes what least squares said of one frame.
    pub fn add_fit(&mut self, fit: &Fit) {
        let Some(ticks_q20) = fit.ticks_q20() else { return };
        self.sxx_q8 += u128::from(fit.sxx_q8);
        self.sxy_q8 += u128::from(fit.sxy_q8);
        if self.frames == 0 {
            self.pivot_q20 = ticks_q20;
        }
        let off = i128::from(ticks_q20) - i128::from(self.pivot_q20);
        let weighted = off.saturating_mul(i128::from(fit.sxx_q8));
        self.deviation_q28 = self.deviation_q28.saturating_add(weighted);
        let square = weighted.unsigned_abs().saturating_mul(off.unsigned_abs());
        self.squares_q48 = self.squares_q48.saturating_add(square);
        self.frames = self.frames.saturating_add(1);
        self.edges += u64::from(fit.edges);
        self.asymmetry_q8 = self.asymmetry_q8.saturating_add(i64::from(fit.asymmetry_q8));
    }

    /// Says how much the edges scatter: their variance in ticks squared, times 2^20.
    pub(super) fn set_noise(&mut self, noise_q20: u64) {
        self.noise_q20 = noise_q20;
    }

    /// Says which bit times the first frame allows.
    pub(super) fn set_interval(&mut self, interval: &Interval) {
        let width = u128::from(interval.high_q20 - interval.low_q20);
        self.bounded_q20 = Some(interval.low_q20 + (interval.high_q20 - interval.low_q20) / 2);
        // Any bit time in the interval is as likely: as noise of the edges that has this effect.
        let variance_q40 = div_wide(width * width, 12);
        let noise = (variance_q40.saturating_mul(self.sxx_q8)) >> 28;
        self.noise_q20 = self.noise_q20.max(u64::try_from(noise).unwrap_or(u64::MAX));
    }

    /// Frames taken.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Mean of the edges to recessive being late against those to dominant, in ticks times 2^8.
    #[must_use]
    pub const fn asymmetry_q8(&self) -> i64 {
        match self.frames {
            0 => 0,
            1 => self.asymmetry_q8,
            frames => self.asymmetry_q8 / frames as i64,
        }
    }

    /// The bit time; `None` without at least two edges of one polarity in a frame.
    #[must_use]
    pub fn bit_time(&self) -> Option<BitTime> {
        let ticks_q20 = self.ticks_q20()?;
        let variance = self.theory_q40().max(self.scatter_q40());
        let deviation = u128::from(sqrt(variance));
        let uncertainty = div_wide(deviation * 1_000_000_000, u128::from(ticks_q20));
        let uncertainty_ppb = u32::try_from(uncertainty).unwrap_or(u32::MAX);
        Some(BitTime { ticks_q20, uncertainty_ppb })
    }

    /// The bit time alone: the mean, in two steps so that no length of capture overflows.
    pub(super) fn ticks_q20(&self) -> Option<u64> {
        if self.sxx_q8 == 0 {
            return None;
        }
        if let (Some(bounded), 1) = (self.bounded_q20, self.frames) {
            return Some(bounded);
        }
        let ticks = match (u64::try_from(self.sxy_q8), u64::try_from(self.sxx_q8)) {
            (Ok(sxy), Ok(sxx)) => ratio_q20(sxy, sxx)?,
            _ => {
                let whole = div_wide(self.sxy_q8, self.sxx_q8);
                let rest = self.sxy_q8 - whole * self.sxx_q8;
                let rest_q20 = rest.checked_shl(20).filter(|_| rest.leading_zeros() >= 20)?;
                u64::try_from((whole << 20) + div_wide(rest_q20, self.sxx_q8)).ok()?
            }
        };
        (ticks > 0).then_some(ticks)
    }

    /// Variance of the mean from that of a single edge, in ticks^2 times 2^40.
    fn theory_q40(&self) -> u128 {
        let noise = u128::from(self.noise_q20.max(QUANTISATION_Q20));
        div_wide(noise << 28, self.sxx_q8)
    }

    /// Variance of the mean from how far frames disagree, in ticks^2 times 2^40.
    fn scatter_q40(&self) -> u128 {
        if self.frames < 2 {
            return 0;
        }
        let sum = self.deviation_q28.unsigned_abs();
        // sum^2 / weight, divided first: the mean deviation is at most a few ticks.
        let common = div_wide(sum, self.sxx_q8).saturating_mul(sum);
        let scatter = self.squares_q48.saturating_sub(common);
        div_wide(div_wide(scatter, u128::from(self.frames - 1)), self.sxx_q8)
    }
}

/// Whole ratios of nominal and data bit time that are looked for.
const RATIOS: core::ops::RangeInclusive<u64> = 2..=32;

/// Less certain bit times agree with any ratio: 0.3 %.
const POOL_UNCERTAINTY_MAX_PPB: u128 = 3_000_000;

/// Makes one measurement of two: one oscillator makes both bit times of a node, nearly always in
/// a whole ratio. If nominal and data bit time agree with one within four standard deviations,
/// each sharpens the other.
pub(super) fn pool(nominal: BitTime, data: BitTime) -> (BitTime, BitTime) {
    let ratio = (nominal.ticks_q20 + data.ticks_q20 / 2) / data.ticks_q20.max(1);
    let scaled = data.ticks_q20 * ratio;
    let apart_ppb = div_wide(
        u128::from(scaled.abs_diff(nominal.ticks_q20)) * 1_000_000_000,
        u128::from(nominal.ticks_q20),
    );
    let (first, second) =
        (u128::from(nominal.uncertainty_ppb.max(1)), u128::from(data.uncertainty_ppb.max(1)));
    let variance = first * first + second * second;
    let sharp = first.max(second) <= POOL_UNCERTAINTY_MAX_PPB;
    if !sharp || !RATIOS.contains(&ratio) || apart_ppb * apart_ppb > 16 * variance {
        return (nominal, data);
    }
    // Weights are inverse variances.
    let weighted =
        u128::from(nominal.ticks_q20) * second * second + u128::from(scaled) * first * first;
    let mean = div_wide(weighted, variance);
    let uncertainty = div_wide(first * second, u128::from(sqrt(variance)));
    let ticks_q20 = u64::try_from(mean).unwrap_or(nominal.ticks_q20);
    let uncertainty_ppb = u32::try_from(uncertainty).unwrap_or(u32::MAX);
    let data = BitTime { ticks_q20: div_small(ticks_q20, ratio as u32), uncertainty_ppb };
    (BitTime { ticks_q20, uncertainty_ppb }, data)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bit(ticks_q20: u64, uncertainty_ppb: u32) -> BitTime {
        BitTime { ticks_q20, uncertainty_ppb }
    }

    #[test]
    fn bit_times_in_a_whole_ratio_sharpen_each_other() {
        // 1000 and 4 x 250.5: 0.2 % apart, at 0.1 % each.
        let (nominal, data) = pool(bit(1_000_000, 1_000_000), bit(250_500, 1_000_000));
        assert_eq!((nominal.ticks_q20, data.ticks_q20), (1_001_000, 250_250));
        // 0.1 % divided by the root of two.
        assert!(nominal.uncertainty_ppb.abs_diff(707_107) <= 1);
    }

    #[test]
    fn bit_times_that_do_not_agree_stay_as_they_are() {
        let (nominal, data) = (bit(1_000_000, 1_000), bit(250_500, 1_000));
        assert_eq!(pool(nominal, data), (nominal, data));
    }
}
