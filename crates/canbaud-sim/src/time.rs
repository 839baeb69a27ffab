//! Instants and durations, in whole femtoseconds.

use core::fmt;
use core::ops::{Add, AddAssign, Sub};

/// A duration in femtoseconds.
///
/// ```
/// use canbaud_sim::Span;
/// assert_eq!(Span::from_ns(2).femtoseconds(), 2_000_000);
/// assert_eq!("1.5ms".parse(), Ok(Span::from_us(1_500)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span(u64);

impl Span {
    /// No time at all.
    pub const ZERO: Self = Self(0);
    /// The longest span, and so the longest run: 5 hours.
    pub const MAX: Self = Self(18_000_000_000_000_000_000);

    /// `fs` femtoseconds.
    #[must_use]
    pub const fn from_fs(fs: u64) -> Self {
        Self(fs)
    }

    /// `ns` nanoseconds, saturating.
    #[must_use]
    pub const fn from_ns(ns: u64) -> Self {
        Self(ns.saturating_mul(1_000_000))
    }

    /// `us` microseconds, saturating.
    #[must_use]
    pub const fn from_us(us: u64) -> Self {
        Self(us.saturating_mul(1_000_000_000))
    }

    /// `ms` milliseconds, saturating.
    #[must_use]
    pub const fn from_ms(ms: u64) -> Self {
        Self(ms.saturating_mul(1_000_000_000_000))
    }

    /// `s` seconds, saturating.
    #[must_use]
    pub const fn from_s(s: u64) -> Self {
        Self(s.saturating_mul(1_000_000_000_000_000))
    }

    /// The duration in femtoseconds.
    #[must_use]
    pub const fn femtoseconds(self) -> u64 {
        self.0
    }

    /// The duration in seconds, rounded.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / 1e15
    }
}

/// An instant: femtoseconds since the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Time(u64);

impl Time {
    /// The start of the run.
    pub const ZERO: Self = Self(0);
    /// After every event.
    pub const NEVER: Self = Self(u64::MAX);

    /// `fs` femtoseconds after the start.
    #[must_use]
    pub const fn from_fs(fs: u64) -> Self {
        Self(fs)
    }

    /// Femtoseconds since the start.
    #[must_use]
    pub const fn femtoseconds(self) -> u64 {
        self.0
    }

    /// Seconds since the start, rounded.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / 1e15
    }

    /// The span since `earlier`, zero if that lies later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Span {
        Span(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Span> for Time {
    type Output = Self;
    fn add(self, span: Span) -> Self {
        Self(self.0.saturating_add(span.0))
    }
}

impl Sub<Span> for Time {
    type Output = Self;
    fn sub(self, span: Span) -> Self {
        Self(self.0.saturating_sub(span.0))
    }
}

impl AddAssign<Span> for Time {
    fn add_assign(&mut self, span: Span) {
        *self = *self + span;
    }
}

impl Add for Span {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl fmt::Display for Time {
    /// Seconds with microseconds, the form of a timeline.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let us = self.0 / 1_000_000_000;
        let ns = self.0 / 1_000_000 % 1_000;
        write!(f, "{}.{:06}{:03}", us / 1_000_000, us % 1_000_000, ns)
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [("s", 1_000_000_000_000_000), ("ms", 1_000_000_000_000)];
        let small = [("us", 1_000_000_000), ("ns", 1_000_000), ("ps", 1_000), ("fs", 1)];
        for (name, unit) in units.into_iter().chain(small) {
            if self.0 >= unit {
                return write!(f, "{} {name}", self.0 as f64 / unit as f64);
            }
        }
        f.write_str("0 s")
    }
}

/// Why a text is not a duration.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no duration: write a number and a unit (s, ms, us, ns, ps, fs), up to 5 h")]
pub struct ParseSpanError(String);

impl core::str::FromStr for Span {
    type Err = ParseSpanError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let bad = || ParseSpanError(text.to_owned());
        let trimmed = text.trim();
        let split = trimmed.find(|c: char| c.is_ascii_alphabetic() || c == 'µ').ok_or_else(bad)?;
        let (number, unit) = trimmed.split_at(split);
        let unit: u128 = match unit {
            "h" => 3_600_000_000_000_000_000,
            "min" => 60_000_000_000_000_000,
            "s" => 1_000_000_000_000_000,
            "ms" => 1_000_000_000_000,
            "us" | "µs" => 1_000_000_000,
            "ns" => 1_000_000,
            "ps" => 1_000,
            "fs" => 1,
            _ => return Err(bad()),
        };
        let number = number.trim().replace('_', "");
        let (whole, fraction) = number.split_once('.').unwrap_or((&number, ""));
        if whole.is_empty() || fraction.len() > 18 {
            return Err(bad());
        }
        let whole: u128 = whole.parse().map_err(|_| bad())?;
        let scale = 10_u128.pow(fraction.len() as u32);
        let part: u128 =
            if fraction.is_empty() { 0 } else { fraction.parse().map_err(|_| bad())? };
        let fs = whole.checked_mul(unit).ok_or_else(bad)? + part * unit / scale;
        match u64::try_from(fs) {
            Ok(fs) if fs <= Self::MAX.0 => Ok(Self(fs)),
            _ => Err(bad()),
        }
    }
}
