//! Ticks of a capture to decimal time, exactly and fast.

use canbaud::units::Timebase;

/// When a capture began, and how long its ticks are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    /// How long a tick is.
    pub(crate) timebase: Timebase,
    /// The time that tick 0 stands for, in s.
    pub(crate) start_s: u64,
}

/// Converts ticks to counts of a decimal part of a second, rounded half up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamp {
    clock: Clock,
    /// Parts of a second: 10^6 for microseconds.
    parts: u64,
}

impl Stamp {
    /// Time in microseconds.
    pub(super) const fn micros(clock: Clock) -> Self {
        Self { clock, parts: 1_000_000 }
    }

    /// Time in nanoseconds.
    pub(super) const fn nanos(clock: Clock) -> Self {
        Self { clock, parts: 1_000_000_000 }
    }

    /// The time of tick `ticks` in the unit of this stamp; saturates at the end of 64 bits.
    pub(super) fn count(self, ticks: u64) -> u64 {
        self.clock.start_s.saturating_mul(self.parts).saturating_add(self.since_start(ticks))
    }

    fn since_start(self, ticks: u64) -> u64 {
        let timebase = self.clock.timebase;
        let frequency = timebase.ticks();
        if timebase.seconds() == 1 {
            // Whole seconds apart, the rest stays below 2^63 for every clock up to 9 GHz: no
            // 128-bit division per frame.
            let rest = ticks % frequency;
            if let Some(scaled) = rest.checked_mul(self.parts).filter(|s| s >> 63 == 0) {
                let part = (scaled + frequency / 2) / frequency;
                return (ticks / frequency).saturating_mul(self.parts).saturating_add(part);
            }
        }
        let per_tick = u128::from(timebase.seconds()) * u128::from(self.parts);
        let Some(scaled) = u128::from(ticks).checked_mul(per_tick) else { return u64::MAX };
        let rounded = scaled.saturating_add(u128::from(frequency / 2)) / u128::from(frequency);
        u64::try_from(rounded).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud::units::Hertz;

    fn clock(hertz: u64) -> Clock {
        Clock { timebase: Timebase::from_frequency(Hertz::new(hertz).unwrap()), start_s: 0 }
    }

    fn slow(ticks: u64, seconds: u64) -> Clock {
        Clock { timebase: Timebase::new(ticks, seconds).unwrap(), start_s: 0 }
    }

    #[test]
    fn ticks_become_decimal_time() {
        assert_eq!(Stamp::micros(clock(8_000_000)).count(12), 2, "1.5 us round up");
        assert_eq!(Stamp::nanos(clock(8_000_000)).count(12), 1_500);
        // 24 MHz: a tick is 41.666… ns.
        assert_eq!(Stamp::nanos(clock(24_000_000)).count(1), 42);
        assert_eq!(Stamp::nanos(clock(24_000_000)).count(24_000_000 * 3600 + 1), 3_600_000_000_042);
    }

    #[test]
    fn odd_timebases_and_long_captures_stay_exact() {
        // A tick of 3 s.
        assert_eq!(Stamp::micros(slow(1, 3)).count(7), 21_000_000);
        // 10^15 ticks a second, one day: 86_400 s.
        let fast = clock(1_000_000_000_000_000);
        assert_eq!(Stamp::nanos(fast).count(86_400 * 100_000_000_000_000), 8_640_000_000_000);
        assert_eq!(Stamp::nanos(slow(1, 1_000_000)).count(u64::MAX), u64::MAX);
    }

    #[test]
    fn start_is_added() {
        let clock = Clock { start_s: 1_700_000_000, ..clock(1_000) };
        assert_eq!(Stamp::micros(clock).count(5), 1_700_000_000_005_000);
    }
}
