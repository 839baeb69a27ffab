//! Ticks to bits by one multiplication.

use crate::fixed::{div_wide, ratio_q20};

/// One bit in the fixed-point form that this module and its users count in.
pub(crate) const BIT_Q20: i32 = 1 << 20;

/// Spans beyond this many bits (times 2^20) are counted as this many, so that sums fit: 256.
const SPAN_MAX_Q20: u64 = 1 << 28;

/// A bit time, prepared so that a run of ticks becomes a number of bits without a division.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BitClock {
    /// Bit time in ticks, times 2^20.
    ticks_q20: u64,
    /// 2^(20 + `shift`) divided by the bit time in ticks: 31 significant bits.
    factor: u32,
    shift: u32,
    /// Longer runs count as this many ticks: about a thousand bits.
    ticks_max: u32,
}

impl BitClock {
    /// The shortest bit time that edges on whole ticks can resolve at all: one tick.
    const TICKS_Q20_MIN: u64 = 1 << 20;
    /// The longest: 2^28 ticks, 16 ms of a 16 GHz clock.
    const TICKS_Q20_MAX: u64 = 1 << 48;

    /// A clock for `ticks_q20` ticks a bit (times 2^20); `None` outside 1 to 2^28 ticks.
    pub(crate) fn new(ticks_q20: u64) -> Option<Self> {
        if !(Self::TICKS_Q20_MIN..=Self::TICKS_Q20_MAX).contains(&ticks_q20) {
            return None;
        }
        // ticks_q20 has 21 to 49 bits; choose the shift that leaves a factor of 31 bits.
        let shift = ticks_q20.ilog2() - 20 + 10;
        let factor = div_wide(1 << (40 + shift), u128::from(ticks_q20));
        let ticks_max = (ticks_q20 >> 10).min(u64::from(u32::MAX));
        Some(Self { ticks_q20, factor: factor as u32, shift, ticks_max: ticks_max as u32 })
    }

    /// Bit time in ticks, times 2^20.
    pub(crate) const fn ticks_q20(self) -> u64 {
        self.ticks_q20
    }

    /// `ticks` in bits, times 2^20; saturates near a thousand bits.
    #[inline]
    pub(crate) fn bits_q20(self, ticks: u32) -> i32 {
        let ticks = if ticks < self.ticks_max { ticks } else { self.ticks_max };
        ((u64::from(ticks) * u64::from(self.factor)) >> self.shift) as i32
    }

    /// `bits` whole bits in ticks, rounded to the nearest tick.
    pub(crate) fn ticks(self, bits: u32) -> u64 {
        ((self.ticks_q20 * u64::from(bits)) + (1 << 19)) >> 20
    }

    /// A signed number of ticks (times 2^20) in bits, times 2^20; saturates at 256 bits.
    pub(crate) fn signed_bits_q20(self, ticks_q20: i64) -> i32 {
        let bits = match ticks_q20 {
            0 => 0,
            _ => ratio_q20(ticks_q20.unsigned_abs(), self.ticks_q20).unwrap_or(SPAN_MAX_Q20),
        };
        let bits = bits.min(SPAN_MAX_Q20) as i32;
        if ticks_q20 < 0 { -bits } else { bits }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_of_whole_bit_runs_are_exact_to_a_millionth() {
        for ticks in [1.5_f64, 2.0, 2.5, 16.0, 100.0, 200_000.0, 3_200_000.0] {
            let clock = BitClock::new((ticks * f64::from(1 << 20)) as u64).unwrap();
            for bits in 1..200_u32 {
                let run = f64::from(bits) * ticks;
                let expected = run.floor() / ticks;
                let got = f64::from(clock.bits_q20(run.floor() as u32)) / f64::from(BIT_Q20);
                assert!((got - expected).abs() < 2e-6, "{ticks} ticks, {bits} bits: {got}");
            }
        }
    }

    #[test]
    fn long_runs_saturate() {
        let clock = BitClock::new(3 << 19).unwrap();
        assert_eq!(clock.bits_q20(u32::MAX), clock.bits_q20(1 << 20));
        assert!(clock.bits_q20(u32::MAX) > 900 * BIT_Q20);
    }

    #[test]
    fn absurd_bit_times_are_refused() {
        assert_eq!(BitClock::new(0), None);
        assert_eq!(BitClock::new((1 << 20) - 1), None);
        assert_eq!(BitClock::new(u64::MAX), None);
    }
}
