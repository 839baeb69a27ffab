//! A bit time with its uncertainty, from the edges of proven frames.

use crate::detect::BitTime;
use crate::wire::{Fit, PhaseSums};

/// Least squares over any number of frames; each frame has its own origin.
///
/// ```
/// use canbaud::detect::Measurement;
/// assert_eq!(Measurement::default().bit_time(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measurement {
    sxx_q8: u128,
    sxy_q8: u128,
    /// Sum of bit time times mixed sum, frame by frame, times 2^28: how far frames disagree.
    weighted_q28: u128,
    frames: u32,
    edges: u64,
    asymmetry_q8: i64,
    /// Variance of an edge in ticks^2 times 2^20, where it was measured.
    noise_q20: u64,
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
        self.weighted_q28 =
            self.weighted_q28.saturating_add(u128::from(ticks_q20) * u128::from(fit.sxy_q8));
        self.frames = self.frames.saturating_add(1);
        self.edges += u64::from(fit.edges);
        self.asymmetry_q8 = self.asymmetry_q8.saturating_add(i64::from(fit.asymmetry_q8));
    }

    /// Says how much the edges scatter: their variance in ticks squared, times 2^20.
    pub(crate) fn set_noise(&mut self, noise_q20: u64) {
        self.noise_q20 = noise_q20;
    }

    /// Frames taken.
    #[must_use]
    pub const fn frames(&self) -> u32 {
        self.frames
    }

    /// Mean of the edges to recessive being late against those to dominant, in ticks times 2^8.
    #[must_use]
    pub const fn asymmetry_q8(&self) -> i64 {
        if self.frames == 0 { 0 } else { self.asymmetry_q8 / self.frames as i64 }
    }

    /// The bit time; `None` without at least two edges of one polarity in a frame.
    #[must_use]
    pub fn bit_time(&self) -> Option<BitTime> {
        if self.sxx_q8 == 0 {
            return None;
        }
        let ticks_q20 = self.ticks_q20()?;
        let variance = self.theory_q40().max(self.scatter_q40());
        let uncertainty = variance.isqrt().saturating_mul(1_000_000_000) / u128::from(ticks_q20);
        let uncertainty_ppb = u32::try_from(uncertainty).unwrap_or(u32::MAX);
        Some(BitTime { ticks_q20, uncertainty_ppb })
    }

    /// The mean, in two steps so that no length of capture overflows.
    fn ticks_q20(&self) -> Option<u64> {
        let whole = self.sxy_q8 / self.sxx_q8;
        let rest = self.sxy_q8 % self.sxx_q8;
        let fraction = rest.checked_shl(20).filter(|_| rest.leading_zeros() >= 20)? / self.sxx_q8;
        let ticks = u64::try_from((whole << 20) + fraction).ok()?;
        (ticks > 0).then_some(ticks)
    }

    /// Variance of the mean from that of a single edge, in ticks^2 times 2^40.
    fn theory_q40(&self) -> u128 {
        let noise = u128::from(self.noise_q20.max(QUANTISATION_Q20));
        (noise << 28) / self.sxx_q8
    }

    /// Variance of the mean from how far frames disagree, in ticks^2 times 2^40.
    fn scatter_q40(&self) -> u128 {
        let (Some(ticks_q20), 2..) = (self.ticks_q20(), self.frames) else { return 0 };
        let common = self.sxy_q8.saturating_mul(u128::from(ticks_q20));
        let scatter_q28 = self.weighted_q28.saturating_sub(common);
        let per_frame = scatter_q28 / u128::from(self.frames - 1);
        per_frame.saturating_mul(1 << 20) / self.sxx_q8
    }
}
