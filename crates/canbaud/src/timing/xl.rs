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
