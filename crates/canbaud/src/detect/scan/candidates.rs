//! The list of candidates.

use core::fmt;

use super::{Candidate, Capture, Found, RateChoice};
use crate::rates;
use crate::units::Bitrate;

/// A list without room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooMany {
    /// Candidates that the list holds at most.
    pub room: usize,
}

impl fmt::Display for TooMany {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "more candidates than the list holds ({} at most)", self.room)
    }
}

impl core::error::Error for TooMany {}

/// Up to `N` candidates, in the order of the list.
///
/// ```
/// use canbaud::detect::scan::Candidates;
/// use canbaud::units::Bitrate;
/// let canopen = Candidates::<8>::canopen().unwrap();
/// assert_eq!(canopen.as_slice().len(), 8);
/// // A sweep from 10 kbit/s to 1 Mbit/s with the widest bit timing.
/// let (low, high) = (Bitrate::new(10_000).unwrap(), Bitrate::new(1_000_000).unwrap());
/// let sweep = Candidates::<100>::sweep(low, high).unwrap();
/// assert_eq!(sweep.as_slice().len(), 96);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Candidates<const N: usize> {
    entries: [Candidate; N],
    length: usize,
}

/// What fills unused places.
const UNUSED: Candidate = Candidate::classic(match Bitrate::new(1) {
    Some(rate) => rate,
    None => unreachable!(),
});

/// CiA 301.
const CANOPEN: [u32; 8] = [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
/// SAE J1939-11, -14, -15 and -16, with what tools add.
const J1939: [u32; 4] = [250_000, 500_000, 666_667, 1_000_000];
/// ODVA DeviceNet.
const DEVICENET: [u32; 3] = [125_000, 250_000, 500_000];

/// A sweep's step in thousandths: inside what the widest bit timing captures (-2 to +4 %).
const SWEEP_PERMILLE: u64 = 1_050;

impl<const N: usize> Candidates<N> {
    /// No candidates.
    #[must_use]
    pub const fn new() -> Self {
        Self { entries: [UNUSED; N], length: 0 }
    }

    /// The candidates.
    #[must_use]
    pub fn as_slice(&self) -> &[Candidate] {
        self.entries.get(..self.length).unwrap_or_default()
    }

    /// Adds a candidate, unless it is in the list.
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn push(&mut self, candidate: Candidate) -> Result<(), TooMany> {
        if self.as_slice().contains(&candidate) {
            return Ok(());
        }
        let place = self.entries.get_mut(self.length).ok_or(TooMany { room: N })?;
        *place = candidate;
        self.length += 1;
        Ok(())
    }

    fn of(rates: impl IntoIterator<Item = Bitrate>) -> Result<Self, TooMany> {
        let mut list = Self::new();
        for rate in rates {
            list.push(Candidate::classic(rate))?;
        }
        Ok(list)
    }

    /// These rates.
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn of_rates(rates: &[Bitrate]) -> Result<Self, TooMany> {
        Self::of(rates.iter().copied())
    }

    /// The eight rates of CANopen \[CiA 301\].
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn canopen() -> Result<Self, TooMany> {
        Self::of(CANOPEN.into_iter().filter_map(Bitrate::new))
    }

    /// 250, 500, 666.667 kbit/s and 1 Mbit/s \[SAE J1939\].
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn j1939() -> Result<Self, TooMany> {
        Self::of(J1939.into_iter().filter_map(Bitrate::new))
    }

    /// 125, 250 and 500 kbit/s \[DeviceNet\].
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn devicenet() -> Result<Self, TooMany> {
        Self::of(DEVICENET.into_iter().filter_map(Bitrate::new))
    }

    /// Every rate of [`rates::nominal`].
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn known() -> Result<Self, TooMany> {
        Self::of(rates::nominal().iter().map(rates::KnownRate::bitrate))
    }

    /// From `low` to `high` in steps of 5 % with the widest bit timing, so that any rate between
    /// them is captured by one.
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn sweep(low: Bitrate, high: Bitrate) -> Result<Self, TooMany> {
        let mut list = Self::new();
        let (mut rate, high) =
            (u64::from(low.bits_per_second()), u64::from(high.bits_per_second()));
        loop {
            let nominal = Bitrate::new(u32::try_from(rate.min(high)).unwrap_or(u32::MAX));
            if let Some(nominal) = nominal {
                list.push(Candidate { nominal, data: None, capture: Capture::Wide })?;
            }
            if rate >= high {
                return Ok(list);
            }
            rate = (rate * SWEEP_PERMILLE / 1000).max(rate + 1);
        }
    }

    /// What [`Policy::Survey`](super::Policy::Survey) listens at to know a rate more exactly that a
    /// sweep has found: the rates around it in steps of 1 %, with the usual bit timing.
    ///
    /// # Errors
    /// [`TooMany`] if there is no room; 17 are enough.
    pub fn around(found: &Found) -> Result<Self, TooMany> {
        let middle = u64::from(found.nominal().bits_per_second());
        let rate = |percent: u64| Bitrate::new(u32::try_from(middle * percent / 100).ok()?);
        Self::of((92..=108).filter_map(rate))
    }

    /// Each nominal rate with each of these data rates that is above it.
    ///
    /// # Errors
    /// [`TooMany`] if there is no room.
    pub fn with_data(&self, rates: &[Bitrate]) -> Result<Self, TooMany> {
        let mut list = Self::new();
        for candidate in self.as_slice() {
            for &data in rates.iter().filter(|rate| **rate > candidate.nominal) {
                list.push(Candidate { data: Some(data), ..*candidate })?;
            }
        }
        Ok(list)
    }

    /// Only what a controller can be set to, as far as it says.
    #[must_use]
    pub fn within(&self, choice: &RateChoice<'_>) -> Self {
        let mut list = Self::new();
        let fits = |candidate: &&Candidate| match choice {
            RateChoice::Between(low, high) => (*low..=*high).contains(&candidate.nominal),
            RateChoice::Only(rates) => rates.contains(&candidate.nominal),
        };
        for candidate in self.as_slice().iter().filter(fits) {
            // There is room: it comes from a list of the same size.
            let _ = list.push(*candidate);
        }
        list
    }
}

impl<const N: usize> Default for Candidates<N> {
    fn default() -> Self {
        Self::new()
    }
}
