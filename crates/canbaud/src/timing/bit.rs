//! The segments of a bit, as real values.

use core::fmt;

use super::Ratio;
use crate::units::{Bitrate, Hertz};

/// How one bit is built, in real values: never the minus-one form of a register.
///
/// Names after ISO 11898-1. All lengths are in time quanta (TQ); SYNC_SEG is always 1.
///
/// ```
/// use canbaud::timing::BitTiming;
/// let timing = BitTiming { prescaler: 5, prop_seg: 11, phase_seg1: 2, phase_seg2: 2, sjw: 1 };
/// assert_eq!((timing.tseg1(), timing.tseg2(), timing.quanta()), (13, 2, 16));
/// assert_eq!(timing.sample_point().permille(), 875);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BitTiming {
    /// Clock periods in a time quantum (after a fixed divider, if the controller has one).
    pub prescaler: u16,
    /// PROP_SEG.
    pub prop_seg: u16,
    /// PHASE_SEG1.
    pub phase_seg1: u16,
    /// PHASE_SEG2.
    pub phase_seg2: u16,
    /// Synchronization jump width.
    pub sjw: u16,
}

impl BitTiming {
    /// TSEG1 = PROP_SEG + PHASE_SEG1.
    #[must_use]
    pub const fn tseg1(&self) -> u32 {
        self.prop_seg as u32 + self.phase_seg1 as u32
    }

    /// TSEG2 = PHASE_SEG2.
    #[must_use]
    pub const fn tseg2(&self) -> u32 {
        self.phase_seg2 as u32
    }

    /// Time quanta in the bit: SYNC_SEG + TSEG1 + TSEG2.
    #[must_use]
    pub const fn quanta(&self) -> u32 {
        1 + self.tseg1() + self.tseg2()
    }

    /// Where in the bit its level is taken: (SYNC_SEG + TSEG1) / quanta.
    #[must_use]
    pub const fn sample_point(&self) -> Ratio {
        Ratio::over(1 + self.tseg1() as u64, self.quanta() as u64)
    }

    /// Clock periods in a bit, for a controller with this fixed divider.
    #[must_use]
    pub const fn clocks_per_bit(&self, clock_divider: u16) -> u64 {
        self.quanta() as u64 * self.prescaler as u64 * clock_divider as u64
    }
}

/// A bit rate as the exact ratio clock / divisor.
///
/// ```
/// use canbaud::{timing::Rate, units::Hertz};
/// let rate = Rate::new(Hertz::new(42_000_000).unwrap(), 52).unwrap();
/// assert_eq!(rate.millibits_per_second(), 807_692_308);
/// assert_eq!(rate.to_string(), "807.692308k");
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Rate {
    clock: u64,
    divisor: u64,
}

impl Rate {
    /// `clock / divisor`; `None` if the divisor is 0.
    #[must_use]
    pub const fn new(clock: Hertz, divisor: u64) -> Option<Self> {
        if divisor == 0 { None } else { Some(Self { clock: clock.hertz(), divisor }) }
    }

    pub(crate) const fn over(clock: u64, divisor: u64) -> Self {
        Self { clock, divisor: if divisor == 0 { 1 } else { divisor } }
    }

    /// The clock in Hz.
    #[must_use]
    pub const fn clock(self) -> u64 {
        self.clock
    }

    /// Clock periods in a bit.
    #[must_use]
    pub const fn divisor(self) -> u64 {
        self.divisor
    }

    /// In 1/1000 bit/s, rounded half up.
    #[must_use]
    pub const fn millibits_per_second(self) -> u64 {
        Ratio::over(self.clock, self.divisor).scaled(1_000)
    }

    /// Deviation from `bitrate` in 10⁻⁹, signed (positive: faster), rounded half away from 0;
    /// saturates.
    #[must_use]
    pub const fn error_ppb(self, bitrate: Bitrate) -> i64 {
        let asked = bitrate.bits_per_second() as u128 * self.divisor as u128;
        let clock = self.clock as u128;
        let (difference, sign) =
            if clock >= asked { (clock - asked, 1) } else { (asked - clock, -1) };
        let ppb = match (difference * 1_000_000_000 + asked / 2).checked_div(asked) {
            Some(ppb) if ppb <= i64::MAX as u128 => ppb as i64,
            _ => i64::MAX,
        };
        sign * ppb
    }
}

impl PartialEq for Rate {
    fn eq(&self, other: &Self) -> bool {
        Ratio::over(self.clock, self.divisor) == Ratio::over(other.clock, other.divisor)
    }
}

impl Eq for Rate {}

impl From<Bitrate> for Rate {
    fn from(bitrate: Bitrate) -> Self {
        Self { clock: bitrate.bits_per_second().into(), divisor: 1 }
    }
}

impl Rate {
    /// As people say it, with its unit.
    ///
    /// ```
    /// use canbaud::{timing::Rate, units::Bitrate};
    /// let words = Rate::from(Bitrate::new(83_333).unwrap()).words();
    /// assert_eq!(words.to_string(), "83.333 kbit/s");
    /// ```
    #[must_use]
    pub const fn words(self) -> RateWords {
        RateWords(self)
    }

    fn write(self, f: &mut fmt::Formatter<'_>, space: &str) -> fmt::Result {
        let rate = self.millibits_per_second();
        let (unit, mut width, suffix) = match rate {
            0..1_000_000 => (1_000, 3, ""),
            1_000_000..1_000_000_000 => (1_000_000, 6, "k"),
            _ => (1_000_000_000, 9, "M"),
        };
        let mut fraction = rate % unit;
        while width > 0 && fraction.is_multiple_of(10) {
            fraction /= 10;
            width -= 1;
        }
        if width == 0 {
            write!(f, "{}{space}{suffix}", rate / unit)
        } else {
            // At most nine, said again where the compiler sees that no width is out of range.
            let width: usize = width.min(9);
            write!(f, "{}.{fraction:0width$}{space}{suffix}", rate / unit)
        }
    }
}

impl fmt::Display for Rate {
    /// To 10⁻³ bit/s, with the suffix that people write: `807.692308k`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, "")
    }
}

/// A bit rate with its unit, from [`Rate::words`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RateWords(Rate);

impl fmt::Display for RateWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.write(f, " ")?;
        f.write_str("bit/s")
    }
}
