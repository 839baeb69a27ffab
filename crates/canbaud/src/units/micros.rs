//! Time in microseconds, for what waits: scans, protocols, nodes.

use core::fmt;
use core::ops::{Add, Sub};

use super::frequency::Bitrate;

/// An instant or a span in microseconds; instants count from a start that the caller chooses.
///
/// Arithmetic saturates: a clock that wraps or jumps makes no panic.
///
/// ```
/// use canbaud::units::{Bitrate, Micros};
/// let start = Micros::from_ms(20);
/// assert_eq!(start + Micros(500), Micros(20_500));
/// assert_eq!(Micros(5) - Micros(9), Micros(0));
/// // 128 bits at 500 kbit/s.
/// assert_eq!(Micros::of_bits(128, Bitrate::new(500_000).unwrap()), Micros(256));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Micros(pub u64);

impl Micros {
    /// The latest instant there is: never.
    pub const MAX: Self = Self(u64::MAX);

    /// `milliseconds` as microseconds.
    #[must_use]
    pub const fn from_ms(milliseconds: u64) -> Self {
        Self(milliseconds.saturating_mul(1000))
    }

    /// Whole milliseconds, rounded down.
    #[must_use]
    pub const fn ms(self) -> u64 {
        self.0 / 1000
    }

    /// How long `bits` last at `bitrate`, rounded up.
    // One copy: there is no 64-bit division in a microcontroller.
    #[inline(never)]
    #[must_use]
    pub const fn of_bits(bits: u64, bitrate: Bitrate) -> Self {
        let rate = bitrate.bits_per_second() as u64;
        Self(bits.saturating_mul(1_000_000).saturating_add(rate - 1) / rate)
    }

    /// `times` of these one after another.
    #[inline(never)]
    #[must_use]
    pub const fn times(self, times: u64) -> Self {
        Self(self.0.saturating_mul(times))
    }
}

impl Add for Micros {
    type Output = Self;

    #[inline(never)]
    fn add(self, span: Self) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Sub for Micros {
    type Output = Self;

    #[inline(never)]
    fn sub(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}

impl fmt::Display for Micros {
    /// Seconds with three decimals from 1 s on, else milliseconds, else microseconds.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            us @ 0..1_000 => write!(f, "{us} us"),
            us @ 1_000..1_000_000 => write!(f, "{}.{:03} ms", us / 1000, us % 1000),
            us => write!(f, "{}.{:03} s", us / 1_000_000, us / 1000 % 1000),
        }
    }
}
