//! The clock doctor: what a bit rate that is off by a simple factor says about a node's clock.

use core::fmt;

use super::Ratio;
use crate::units::Bitrate;

/// Deviation that clocks explain by themselves: 0.5 %, in 10⁻⁶.
const CLOCK_TOLERANCE_PPM: u64 = 5_000;

/// What explains the factor between the measured and the expected bit rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// The rate is the expected one.
    AsExpected,
    /// Right but for a clock outside 0.5 %: an RC oscillator, or a PLL step.
    ClockOff,
    /// Half: fosc / 2 not accounted for, or half the crystal.
    Half,
    /// Twice: a division by 2 counted twice, or twice the crystal.
    Twice,
    /// A quarter.
    Quarter,
    /// Four times.
    FourTimes,
    /// An eighth: DIV8 set.
    Eighth,
    /// Eight times: DIV8 expected but not set.
    EightTimes,
    /// Another crystal or PLL output than configured.
    OtherClock {
        /// Clock that is there, in kHz.
        actual_khz: u32,
        /// Clock that was configured for, in kHz.
        configured_khz: u32,
    },
    /// A prescaler or bit length stored without its minus one, or with one too many.
    OffByOne {
        /// Value that is in effect.
        actual: u8,
        /// Value that was meant.
        meant: u8,
    },
    /// No simple factor.
    Unexplained,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AsExpected => f.write_str("the bit rate is the expected one"),
            Self::ClockOff => f.write_str(
                "nearly the expected bit rate, but further off than 0.5 %: an RC oscillator, a \
                 wrong PLL factor, or a prescaler that does not divide the clock evenly",
            ),
            Self::Half => f.write_str(
                "half the expected bit rate: the controller divides its clock by 2 and the \
                 configuration does not know (SJA1000, MCP2515, C167), or an 8 MHz crystal where \
                 16 MHz was configured",
            ),
            Self::Twice => f.write_str(
                "twice the expected bit rate: a division by 2 counted that is not there (CPS, \
                 fosc against fosc/2), or a 16 MHz crystal where 8 MHz was configured",
            ),
            Self::Quarter => f.write_str(
                "a quarter of the expected bit rate: an undivided clock assumed behind a \
                 divider by 4, or a 4 MHz crystal where 16 MHz was configured",
            ),
            Self::FourTimes => f.write_str(
                "four times the expected bit rate: a clock divider by 4 that is not in effect, or \
                 a 16 MHz clock where 4 MHz was configured",
            ),
            Self::Eighth => f.write_str(
                "an eighth of the expected bit rate: DIV8 (TwinCAN, MultiCAN) is set and should \
                 not be, or an 8 MHz crystal instead of the 64 MHz PLL output",
            ),
            Self::EightTimes => f.write_str(
                "eight times the expected bit rate: DIV8 (TwinCAN, MultiCAN) is not set and \
                 should be",
            ),
            Self::OtherClock { actual_khz, configured_khz } => write!(
                f,
                "as if the clock were {} MHz where {} MHz was configured (or another pair in this \
                 ratio)",
                Megahertz(*actual_khz),
                Megahertz(*configured_khz)
            ),
            Self::OffByOne { actual, meant } => write!(
                f,
                "as if a prescaler or a bit length of {meant} took effect as {actual}: a \
                 minus-one register value written wrongly, or SYNC_SEG not counted"
            ),
            Self::Unexplained => f.write_str(
                "no simple factor lies between the two: not the expected bus, or a clock far off",
            ),
        }
    }
}

/// A frequency in kHz, printed in MHz.
struct Megahertz(u32);

impl fmt::Display for Megahertz {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 % 1_000 {
            0 => write!(f, "{}", self.0 / 1_000),
            rest => write!(f, "{}.{}", self.0 / 1_000, rest / 100),
        }
    }
}

/// The doctor's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Diagnosis {
    /// Measured / expected as a factor of small numbers (1/1 when unexplained).
    pub factor: (u32, u32),
    /// The most plausible explanation.
    pub cause: Cause,
    /// What is left after the factor, in 10⁻⁶, signed; saturates.
    pub residual_ppm: i32,
}

/// Known factors by plausibility: a doubled or halved clock before an odd pair of crystals.
#[rustfmt::skip]
const FACTORS: [(u32, u32, Cause); 34] = [
    (1, 2, Cause::Half), (2, 1, Cause::Twice),
    (1, 8, Cause::Eighth), (8, 1, Cause::EightTimes),
    (1, 4, Cause::Quarter), (4, 1, Cause::FourTimes),
    (3, 2, clock(24_000, 16_000)), (2, 3, clock(16_000, 24_000)),
    (5, 4, clock(10_000, 8_000)), (4, 5, clock(8_000, 10_000)),
    (3, 4, clock(12_000, 16_000)), (4, 3, clock(16_000, 12_000)),
    (5, 2, clock(20_000, 8_000)), (2, 5, clock(8_000, 20_000)),
    (3, 1, clock(24_000, 8_000)), (1, 3, clock(8_000, 24_000)),
    (5, 3, clock(20_000, 12_000)), (3, 5, clock(12_000, 20_000)),
    (5, 1, clock(40_000, 8_000)), (1, 5, clock(8_000, 40_000)),
    (6, 5, clock(24_000, 20_000)), (5, 6, clock(20_000, 24_000)),
    (9, 8, clock(36_000, 32_000)), (8, 9, clock(32_000, 36_000)),
    (25, 16, clock(25_000, 16_000)), (16, 25, clock(16_000, 25_000)),
    (25, 24, clock(25_000, 24_000)), (24, 25, clock(24_000, 25_000)),
    (21, 20, clock(84_000, 80_000)), (20, 21, clock(80_000, 84_000)),
    (21, 16, clock(84_000, 64_000)), (16, 21, clock(64_000, 84_000)),
    (17, 16, clock(170_000, 160_000)), (16, 17, clock(160_000, 170_000)),
];

const fn clock(actual_khz: u32, configured_khz: u32) -> Cause {
    Cause::OtherClock { actual_khz, configured_khz }
}

/// Names the likely cause of a measured bit rate other than the expected one.
///
/// `measured_millibits` is in 1/1000 bit/s, `uncertainty_ppm` that of the measurement.
///
/// ```
/// use canbaud::timing::doctor::{diagnose, Cause};
/// use canbaud::units::Bitrate;
/// let expected = Bitrate::new(500_000).unwrap();
/// let diagnosis = diagnose(expected, 250_012_000, 20);
/// assert_eq!((diagnosis.factor, diagnosis.cause), ((1, 2), Cause::Half));
/// assert_eq!(diagnosis.residual_ppm, 48);
/// assert_eq!(diagnose(expected, 499_990_000, 20).cause, Cause::AsExpected);
/// // 25 MHz where 24 MHz was configured
/// assert_eq!(diagnose(expected, 520_833_000, 20).factor, (25, 24));
/// ```
#[must_use]
pub fn diagnose(expected: Bitrate, measured_millibits: u64, uncertainty_ppm: u32) -> Diagnosis {
    let asked = u64::from(expected.bits_per_second()) * 1_000;
    let residual = |numerator: u32, denominator: u32| {
        residual_ppm(asked, measured_millibits, numerator, denominator)
    };
    let allowed = CLOCK_TOLERANCE_PPM + u64::from(uncertainty_ppm);
    let is_near = |ppm: i32, within: u64| u64::from(ppm.unsigned_abs()) <= within;
    let answer = |factor: (u32, u32), cause| Diagnosis {
        factor,
        cause,
        residual_ppm: residual(factor.0, factor.1),
    };
    if is_near(residual(1, 1), allowed) {
        return answer((1, 1), Cause::AsExpected);
    }
    // The nearest of those within reach; the more plausible of two that are equally near.
    let known = FACTORS
        .iter()
        .map(|known| (residual(known.0, known.1), known))
        .filter(|(ppm, _)| is_near(*ppm, allowed))
        .min_by_key(|(ppm, _)| ppm.unsigned_abs());
    if let Some((_, (numerator, denominator, cause))) = known {
        return answer((*numerator, *denominator), *cause);
    }
    // A prescaler or bit length from 2 to 26, one too long or too short.
    for value in 2..=25_u8 {
        for (meant, actual) in [(value, value + 1), (value + 1, value)] {
            let factor = (u32::from(meant), u32::from(actual));
            if is_near(residual(factor.0, factor.1), allowed) {
                return answer(factor, Cause::OffByOne { actual, meant });
            }
        }
    }
    if is_near(residual(1, 1), 33_000 + u64::from(uncertainty_ppm)) {
        return answer((1, 1), Cause::ClockOff);
    }
    answer((1, 1), Cause::Unexplained)
}

/// `measured / (expected * numerator / denominator) - 1` in 10⁻⁶, rounded down in size; saturates.
fn residual_ppm(expected: u64, measured: u64, numerator: u32, denominator: u32) -> i32 {
    let exact = u128::from(expected) * u128::from(numerator);
    let actual = u128::from(measured) * u128::from(denominator);
    let size = actual.abs_diff(exact) * 1_000_000 / exact.max(1);
    let size = i32::try_from(size).unwrap_or(i32::MAX);
    if actual < exact { -size } else { size }
}

impl Diagnosis {
    /// Measured / expected as a ratio.
    #[must_use]
    pub const fn ratio(&self) -> Ratio {
        Ratio::over(self.factor.0 as u64, self.factor.1 as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Bitrate {
        Bitrate::new(500_000).unwrap()
    }

    /// 500 kbit/s times the factor, off by so many ppm, in 1/1000 bit/s.
    fn measured(numerator: u64, denominator: u64, ppm: i64) -> u64 {
        let exact = 500_000_000 * numerator / denominator;
        exact.saturating_add_signed(exact as i64 * ppm / 1_000_000)
    }

    #[test]
    fn every_known_factor_is_named_with_clocks_that_are_off() {
        for (numerator, denominator, cause) in FACTORS {
            for ppm in [-3_000, 0, 3_000] {
                let rate = measured(numerator.into(), denominator.into(), ppm);
                let diagnosis = diagnose(expected(), rate, 100);
                assert_eq!(diagnosis.factor, (numerator, denominator), "{ppm} ppm");
                assert_eq!(diagnosis.cause, cause);
                assert!(diagnosis.residual_ppm.abs() <= 3_001);
            }
        }
    }

    #[test]
    fn factors_are_far_enough_apart_for_the_nearest_to_decide() {
        for (index, (n, d, _)) in FACTORS.iter().enumerate() {
            for (m, e, _) in FACTORS.iter().skip(index + 1) {
                let (a, b) = (n * e, m * d);
                assert!(a.abs_diff(b) * 1_000 > a.max(b) * 7, "{n}/{d} {m}/{e}");
            }
        }
    }

    #[test]
    fn minus_one_slips_are_named() {
        // A prescaler of 6 written as it is takes effect as 7.
        let diagnosis = diagnose(expected(), measured(6, 7, 100), 50);
        assert_eq!(diagnosis.cause, Cause::OffByOne { actual: 7, meant: 6 });
        // 16 quanta configured, SYNC_SEG forgotten: see the pair 170 and 160 MHz, the same ratio.
        assert_eq!(diagnose(expected(), measured(16, 17, 0), 50).factor, (16, 17));
    }

    #[test]
    fn a_poor_clock_is_told_from_another_rate() {
        assert_eq!(diagnose(expected(), measured(1, 1, 4_900), 0).cause, Cause::AsExpected);
        assert_eq!(diagnose(expected(), measured(1, 1, -15_000), 0).cause, Cause::ClockOff);
        assert_eq!(diagnose(expected(), measured(1, 1, 200_000), 0).factor, (6, 5));
        assert_eq!(diagnose(expected(), measured(7, 1, 0), 0).cause, Cause::Unexplained);
    }

    #[test]
    fn extremes_saturate() {
        assert_eq!(diagnose(expected(), 0, 0).cause, Cause::Unexplained);
        let fastest = diagnose(Bitrate::new(1).unwrap(), u64::MAX, 0);
        assert_eq!((fastest.cause, fastest.residual_ppm), (Cause::Unexplained, i32::MAX));
        let _ = diagnose(Bitrate::new(u32::MAX).unwrap(), u64::MAX, u32::MAX);
    }
}
