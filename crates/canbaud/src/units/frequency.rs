//! Bit rates and clock frequencies.

use core::fmt;
use core::num::NonZeroU32;
use core::str::FromStr;

use super::decimal::{self, ParseQuantityError, Quantity};

/// A bit rate in bit/s, 1 to 4 294 967 295.
///
/// Reads and prints the forms people write; printing is exact.
///
/// ```
/// use canbaud::units::Bitrate;
/// let rate: Bitrate = "83.333k".parse().unwrap();
/// assert_eq!(rate.bits_per_second(), 83_333);
/// assert_eq!(rate.to_string(), "83.333k");
/// assert_eq!("1M".parse(), Ok(Bitrate::new(1_000_000).unwrap()));
/// assert_eq!("500 kbit/s".parse(), Ok(Bitrate::new(500_000).unwrap()));
/// assert_eq!("0".parse::<Bitrate>().unwrap_err().to_string(),
///            "value outside 1 to 4294967295 bit/s");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bitrate(NonZeroU32);

impl Bitrate {
    const QUANTITY: Quantity = Quantity {
        min: 1,
        max: u32::MAX as u64,
        unit: "bit/s",
        words: &["bit/s", "bits/s", "bps", "b/s", "baud", "bd", "bit"],
    };

    /// A rate of `bits_per_second`; `None` for 0.
    #[must_use]
    pub const fn new(bits_per_second: u32) -> Option<Self> {
        // `Option::map` is not const.
        match NonZeroU32::new(bits_per_second) {
            Some(rate) => Some(Self(rate)),
            None => None,
        }
    }

    /// The rate in bit/s.
    #[must_use]
    pub const fn bits_per_second(self) -> u32 {
        self.0.get()
    }
}

impl fmt::Display for Bitrate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::write_metric(f, u64::from(self.0.get()))
    }
}

impl FromStr for Bitrate {
    type Err = ParseQuantityError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let value = decimal::parse(text, &Self::QUANTITY)?;
        // The quantity bounds the value to 1..=u32::MAX.
        Ok(Self(u32::try_from(value).ok().and_then(NonZeroU32::new).unwrap_or(NonZeroU32::MAX)))
    }
}

/// A clock frequency or sample rate in Hz, 1 to 10^15.
///
/// ```
/// use canbaud::units::Hertz;
/// assert_eq!("16.666667 MHz".parse::<Hertz>().unwrap().hertz(), 16_666_667);
/// assert_eq!(Hertz::new(80_000_000).unwrap().to_string(), "80M");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Hertz(u64);

impl Hertz {
    /// The highest frequency that the type holds: 10^15 Hz, one tick a femtosecond.
    pub const MAX: Self = Self(1_000_000_000_000_000);

    const QUANTITY: Quantity =
        Quantity { min: 1, max: Self::MAX.0, unit: "Hz", words: &["hz", "s/s", "sps", "sa/s"] };

    /// A frequency of `hertz`; `None` for 0 and above [`Hertz::MAX`].
    #[must_use]
    pub const fn new(hertz: u64) -> Option<Self> {
        if hertz == 0 || hertz > Self::MAX.0 { None } else { Some(Self(hertz)) }
    }

    /// The frequency in Hz.
    #[must_use]
    pub const fn hertz(self) -> u64 {
        self.0
    }
}

impl fmt::Display for Hertz {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::write_metric(f, self.0)
    }
}

impl FromStr for Hertz {
    type Err = ParseQuantityError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        decimal::parse(text, &Self::QUANTITY).map(Self)
    }
}
