//! Time as a count of ticks, and how long a tick is.

use super::frequency::Hertz;

/// A duration or an instant in ticks of a timer; how long a tick is says its [`Timebase`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Ticks(pub u64);

/// How many ticks a second has: the exact ratio `ticks / seconds`.
///
/// A ratio, because the sample period of a capture need not be a whole number of hertz.
///
/// ```
/// use canbaud::units::{Hertz, Timebase};
/// let timer = Timebase::from_frequency(Hertz::new(8_000_000).unwrap());
/// assert_eq!(timer.nanoseconds(12), Some(1_500));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Timebase {
    ticks: u64,
    seconds: u64,
}

impl Timebase {
    /// `ticks` ticks in `seconds` seconds; `None` if either is 0 or above 10^15.
    #[must_use]
    pub const fn new(ticks: u64, seconds: u64) -> Option<Self> {
        let max = Hertz::MAX.hertz();
        if ticks == 0 || seconds == 0 || ticks > max || seconds > max {
            None
        } else {
            Some(Self { ticks, seconds })
        }
    }

    /// One tick a period of `frequency`.
    #[must_use]
    pub const fn from_frequency(frequency: Hertz) -> Self {
        Self { ticks: frequency.hertz(), seconds: 1 }
    }

    /// The numerator of the ratio.
    #[must_use]
    pub const fn ticks(self) -> u64 {
        self.ticks
    }

    /// The denominator of the ratio.
    #[must_use]
    pub const fn seconds(self) -> u64 {
        self.seconds
    }

    /// `ticks` in whole nanoseconds, rounded half up; `None` if that overflows.
    #[must_use]
    pub const fn nanoseconds(self, ticks: u64) -> Option<u64> {
        let product = ticks as u128 * self.seconds as u128;
        let Some(scaled) = product.checked_mul(1_000_000_000) else { return None };
        let Some(sum) = scaled.checked_add(self.ticks as u128 / 2) else { return None };
        match sum.checked_div(self.ticks as u128) {
            Some(rounded) if rounded <= u64::MAX as u128 => Some(rounded as u64),
            _ => None,
        }
    }
}
