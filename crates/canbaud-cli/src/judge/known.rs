//! What is known beforehand: ticks of the capture, rates that the user gives.

use canbaud::units::{Bitrate, Timebase};
use canbaud::wire::{BusTiming, DataTiming};

/// Ticks finer than this (in 1/s) are made coarser, so that runs of the slowest bus fit 32 bits.
const TICKS_PER_SECOND_MAX: u64 = 1 << 34;

/// How many bits to shift the ticks of a capture to the right.
pub(super) const fn tick_shift(timebase: Timebase) -> u32 {
    let mut shift = 0;
    while (timebase.ticks() / timebase.seconds()) >> shift > TICKS_PER_SECOND_MAX {
        shift += 1;
    }
    shift
}

/// One bit of `bitrate` in ticks of the capture shifted right by `shift`, times 2^20.
pub(super) fn ticks_q20(timebase: Timebase, shift: u32, bitrate: Bitrate) -> Option<u64> {
    let per_second = u128::from(timebase.seconds()) * u128::from(bitrate.bits_per_second());
    u64::try_from(((u128::from(timebase.ticks()) << 20) >> shift) / per_second).ok()
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
        (Some(given), Some(found)) if !same(given.ticks_q20, found.ticks_q20) => Some(given),
        (given, found) => found.or(given),
    };
    BusTiming { data, ..found }
}
