//! PWM coding of the CAN XL data phase (CiA 612-1), in clock periods.

use core::fmt;

use super::Ratio;
use super::controllers::Pwm;
use crate::units::Hertz;

/// Longest symbol: 200 ns.
const SYMBOLS_PER_SECOND_MIN: u64 = 5_000_000;
/// Shortest short part: 5 ns.
const SHORT_PARTS_PER_SECOND_MAX: u64 = 200_000_000;
/// Smallest difference between long and short part: 10 ns.
const DIFFERENCES_PER_SECOND_MAX: u64 = 100_000_000;

/// What the PWM fields of a controller hold, in clock periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PwmLimits {
    /// Highest short part.
    pub short_max: u16,
    /// Highest long part.
    pub long_max: u16,
    /// Highest offset.
    pub offset_max: u16,
}

impl PwmLimits {
    /// Six bits each, the parts minus one: X_CAN and NXP CAN XL.
    pub const SIX_BITS: Self = Self { short_max: 64, long_max: 64, offset_max: 63 };
}

/// Why there is no PWM coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PwmError {
    /// A bit of 0 clock periods.
    NoBit,
    /// No symbol of at most 200 ns divides the XL bit and keeps both parts apart.
    NoSymbol {
        /// Clock periods in an XL bit.
        xl_bit_clocks: u64,
    },
}

impl fmt::Display for PwmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBit => f.write_str("a bit has at least 1 clock period"),
            Self::NoSymbol { xl_bit_clocks } => write!(
                f,
                "no PWM symbol of at most 200 ns divides the XL bit of {xl_bit_clocks} clock \
                 periods and keeps its parts 10 ns apart"
            ),
        }
    }
}

impl core::error::Error for PwmError {}

/// The PWM coding for an XL bit and a nominal bit of so many clock periods: the longest symbol of
/// at most 200 ns that divides the XL bit, a quarter of it short.
///
/// ```
/// use canbaud::{timing::{controllers::Pwm, xl::{pwm, PwmLimits}}, units::Hertz};
/// let clock = Hertz::new(160_000_000).unwrap();
/// // 10 Mbit/s beside 500 kbit/s
/// let coding = pwm(clock, 16, 320, PwmLimits::SIX_BITS).unwrap();
/// assert_eq!(coding, Pwm { short: 4, long: 12, offset: 0 });
/// ```
///
/// # Errors
/// [`PwmError::NoSymbol`] when the clock is too slow for two distinct parts.
pub const fn pwm(
    clock: Hertz,
    xl_bit_clocks: u64,
    nominal_bit_clocks: u64,
    limits: PwmLimits,
) -> Result<Pwm, PwmError> {
    if xl_bit_clocks == 0 || nominal_bit_clocks == 0 {
        return Err(PwmError::NoBit);
    }
    let longest = clock.hertz() / SYMBOLS_PER_SECOND_MIN;
    let fields = limits.short_max as u64 + limits.long_max as u64;
    let mut symbol = if longest < fields { longest } else { fields };
    symbol = if symbol < xl_bit_clocks { symbol } else { xl_bit_clocks };
    while symbol > 0 {
        if xl_bit_clocks.is_multiple_of(symbol) {
            let (short, offset) = (symbol.div_ceil(4), nominal_bit_clocks % symbol);
            let long = symbol - short;
            let fits = short <= limits.short_max as u64
                && long <= limits.long_max as u64
                && offset <= limits.offset_max as u64;
            if fits && is_apart(clock, short, long) {
                let (short, long) = (short as u16, long as u16);
                return Ok(Pwm { short, long, offset: offset as u16 });
            }
        }
        symbol -= 1;
    }
    Err(PwmError::NoSymbol { xl_bit_clocks })
}

/// The short part lasts at least 5 ns and the long part at least 10 ns more.
const fn is_apart(clock: Hertz, short: u64, long: u64) -> bool {
    let clock = clock.hertz();
    long > short
        && short * SHORT_PARTS_PER_SECOND_MAX >= clock
        && (long - short) * DIFFERENCES_PER_SECOND_MAX >= clock
}

/// Share of the symbol that is short.
#[must_use]
pub const fn short_share(pwm: &Pwm) -> Ratio {
    Ratio::over(pwm.short as u64, pwm.short as u64 + pwm.long as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coding(clock_mhz: u64, xl_bits_per_second: u64) -> Result<Pwm, PwmError> {
        let hertz = clock_mhz * 1_000_000;
        let clock = Hertz::new(hertz).unwrap();
        pwm(clock, hertz / xl_bits_per_second, hertz / 500_000, PwmLimits::SIX_BITS)
    }

    /// The defaults of the Linux kernel at 80 and 160 MHz beside 500 kbit/s.
    #[test]
    fn usual_rates_get_the_usual_symbols() {
        for (clock_mhz, rate, short, long) in [
            (80, 10_000_000, 2, 6),
            (160, 10_000_000, 4, 12),
            (80, 5_000_000, 4, 12),
            (160, 5_000_000, 8, 24),
            (80, 20_000_000, 1, 3),
            (160, 20_000_000, 2, 6),
            (80, 2_000_000, 3, 7),
            (160, 2_000_000, 5, 15),
        ] {
            let expected = Pwm { short, long, offset: 0 };
            assert_eq!(coding(clock_mhz, rate), Ok(expected), "{clock_mhz} MHz, {rate} bit/s");
        }
    }

    #[test]
    fn the_offset_is_what_the_nominal_bit_leaves() {
        let clock = Hertz::new(80_000_000).unwrap();
        // 10 clocks a symbol, 96 clocks a nominal bit.
        let coding = pwm(clock, 40, 96, PwmLimits::SIX_BITS).unwrap();
        assert_eq!((coding.short + coding.long, coding.offset), (10, 6));
        assert_eq!(short_share(&coding), Ratio::over(3, 10));
    }

    #[test]
    fn parts_must_be_ten_nanoseconds_apart() {
        // 20 Mbit/s at 40 MHz: 2 clocks, one each.
        assert_eq!(coding(40, 20_000_000), Err(PwmError::NoSymbol { xl_bit_clocks: 2 }));
        let clock = Hertz::new(80_000_000).unwrap();
        assert_eq!(pwm(clock, 0, 160, PwmLimits::SIX_BITS), Err(PwmError::NoBit));
    }
}
