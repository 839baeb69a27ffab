//! The simulator's time and canbaud's.

use canbaud::units::Micros;
use canbaud_sim::Time;

/// Femtoseconds in a microsecond.
pub(crate) const FS_PER_US: u64 = 1_000_000_000;

/// Whole microseconds since the start.
pub(crate) const fn micros(time: Time) -> Micros {
    Micros(time.femtoseconds() / FS_PER_US)
}

/// That many microseconds after the start.
pub(crate) const fn time(micros: Micros) -> Time {
    Time::from_fs(micros.0.saturating_mul(FS_PER_US))
}
