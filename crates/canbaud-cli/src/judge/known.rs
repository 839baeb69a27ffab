//! What is known beforehand: ticks of the capture, rates that the user gives.

use canbaud::units::{Bitrate, Timebase};
use canbaud::wire::{BusTiming, DataTiming};

/// Ticks finer than this (in 1/s) are made coarser, so that runs of the slowest bus fit 32 bits.
const TICKS_PER_SECOND_MAX: u64 = 1 << 34;

/// The ticks that the judges count in: the recorder's own steps, so that rounding is to one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    /// Ticks of the capture for one of ours.
    pub(super) divisor: u64,
    /// Of our ticks.
    pub(super) timebase: Timebase,
}

impl Grid {
    /// For a channel whose edges lie on multiples of `resolution_ticks`.
    pub(super) fn new(timebase: Timebase, resolution_ticks: u64) -> Self {
        let fastest = (timebase.ticks() / timebase.seconds()) / TICKS_PER_SECOND_MAX + 1;
        let divisor = resolution_ticks.max(1).max(fastest);
        let coarser = timebase
            .seconds()
            .checked_mul(divisor)
            .and_then(|seconds| Timebase::new(timebase.ticks(), seconds));
        match coarser {
            Some(timebase) => Self { divisor, timebase },
            None => Self { divisor: 1, timebase },
        }
    }

    /// A tick of the capture in ours, rounded to the nearest.
    pub(super) const fn of(self, at: u64) -> u64 {
        match self.divisor {
            1 => at,
            divisor => at.saturating_add(divisor / 2) / divisor,
        }
    }

    /// One of our ticks in those of the capture.
    pub(super) const fn back(self, at: u64) -> u64 {
        at.saturating_mul(self.divisor)
    }

    /// The same for edges; those that fall on one tick cancel out in pairs.
    pub(super) fn of_edges(self, times: &[u64]) -> Vec<u64> {
        let mut scaled: Vec<u64> = Vec::with_capacity(times.len());
        for &at in times {
            let at = self.of(at);
            if scaled.last() == Some(&at) {
                scaled.pop();
            } else {
                scaled.push(at);
            }
        }
        scaled
    }

    /// One bit of `bitrate` in our ticks, times 2^20.
    pub(super) fn ticks_q20(self, bitrate: Bitrate) -> Option<u64> {
        let per_second =
            u128::from(self.timebase.seconds()) * u128::from(bitrate.bits_per_second());
        u64::try_from((u128::from(self.timebase.ticks()) << 20) / per_second).ok()
    }
}

/// A data phase with the sample points that most controllers use, 80 %.
pub(super) const fn data_timing(nominal_q20: u64, data_q20: u64) -> DataTiming {
    DataTiming { ticks_q20: data_q20, brs_ticks_q20: (nominal_q20 * 4 + data_q20) / 5 }
}

/// A measured bit time this close to the given one is the same rate: 1/32.
const SAME_RATE_SHIFT: u32 = 5;

/// What was given, sharpened by what was found where both speak of the same rate.
pub(super) fn merge(given: BusTiming, found: BusTiming) -> BusTiming {
    let same = |a: u64, b: u64| a.abs_diff(b) <= a >> SAME_RATE_SHIFT;
    if !same(given.ticks_q20, found.ticks_q20) {
        return given;
    }
    let data = match (given.data, found.data) {
        (Some(mine), Some(theirs)) if !same(mine.ticks_q20, theirs.ticks_q20) => Some(mine),
        (given, found) => found.or(given),
    };
    BusTiming { data, ..found }
}
