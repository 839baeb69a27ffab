//! The oscillator of a node: time quanta as an exact ratio.

use crate::time::Time;

/// Why there is no such oscillator.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ClockError {
    /// The frequency is out of range.
    #[error("clock {0} Hz outside 1 kHz to 1 GHz")]
    Frequency(u64),
    /// The deviation is out of range.
    #[error("clock deviation {0} ppb outside ±500000000 (±50 %)")]
    Deviation(i64),
}

/// An oscillator of a nominal frequency that is off by some parts per billion.
///
/// A period is `10^24 / (hz · (10^9 + ppb))` femtoseconds; the ratio is kept, reduced.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clock {
    /// Femtoseconds of a period, times `den`.
    num: u128,
    den: u64,
    /// floor(2^64 / den), to divide by multiplying.
    inverse: u64,
}

/// One time quantum, or any other whole number of periods: `whole + fraction/den` fs.
#[derive(Debug, Clone, Copy)]
pub struct Quantum {
    whole: u64,
    fraction: u64,
    /// Up to this many quanta a step fits 64 bits.
    fast_max: u64,
    per_fs: f64,
}

impl Quantum {
    /// Its length in femtoseconds, rounded down.
    #[must_use]
    #[inline]
    pub(crate) const fn femtoseconds(&self) -> u64 {
        self.whole
    }
}

/// A tick: the instant `fs + rem/den`, which counts as `fs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tick {
    fs: u64,
    rem: u64,
}

impl Tick {
    /// A tick at a whole femtosecond.
    #[must_use]
    pub const fn at(time: Time) -> Self {
        Self { fs: time.femtoseconds(), rem: 0 }
    }

    /// The instant, rounded down.
    #[must_use]
    #[inline]
    pub const fn time(self) -> Time {
        Time::from_fs(self.fs)
    }

    /// The same instant without its fraction: where a new piece of a drifting clock begins.
    #[must_use]
    pub(crate) const fn rebased(self) -> Self {
        Self { fs: self.fs, rem: 0 }
    }
}

const fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Clock {
    /// An oscillator of `hertz` (1 kHz to 1 GHz) that runs `ppb` parts per billion fast (±50 %).
    ///
    /// # Errors
    /// [`ClockError`] outside these ranges.
    pub const fn new(hertz: u64, ppb: i64) -> Result<Self, ClockError> {
        if hertz < 1_000 || hertz > 1_000_000_000 {
            return Err(ClockError::Frequency(hertz));
        }
        if ppb < -500_000_000 || ppb > 500_000_000 {
            return Err(ClockError::Deviation(ppb));
        }
        let num = 1_000_000_000_000_000_000_000_000_u128;
        let den = hertz as u128 * (1_000_000_000 + ppb as i128) as u128;
        let common = gcd(num, den);
        // At most 1.5e18, so it fits; 1 has no inverse of 64 bits and needs none.
        let den = (den / common) as u64;
        let inverse = if den == 1 { 0 } else { ((1_u128 << 64) / den as u128) as u64 };
        Ok(Self { num: num / common, den, inverse })
    }

    /// A quantum of `prescaler` periods.
    #[must_use]
    pub fn quantum(&self, prescaler: u32) -> Quantum {
        let num = self.num * u128::from(prescaler);
        let den = u128::from(self.den);
        let (whole, fraction) = ((num / den) as u64, (num % den) as u64);
        let fast_max = (u64::MAX - self.den).checked_div(fraction).unwrap_or(u64::MAX);
        let per_fs = self.den as f64 / num as f64;
        Quantum { whole, fraction, fast_max: fast_max.min(1 << 20), per_fs }
    }

    /// The tick `count` quanta after `from`, exactly.
    #[must_use]
    #[inline]
    pub fn after(&self, from: Tick, quantum: &Quantum, count: u64) -> Tick {
        if count > quantum.fast_max {
            return self.long_after(from, quantum, count);
        }
        let sum = from.rem + count * quantum.fraction;
        // Barrett: the estimate is the quotient or one less.
        let mut carry = ((u128::from(sum) * u128::from(self.inverse)) >> 64) as u64;
        let mut rem = sum - carry * self.den;
        if rem >= self.den {
            rem -= self.den;
            carry += 1;
        }
        Tick { fs: from.fs + count * quantum.whole + carry, rem }
    }

    /// The tick one quantum after `from`, exactly.
    #[must_use]
    #[inline]
    pub(crate) const fn next(&self, from: Tick, quantum: &Quantum) -> Tick {
        let rem = from.rem + quantum.fraction;
        let carry = rem >= self.den;
        Tick {
            fs: from.fs + quantum.whole + carry as u64,
            rem: if carry { rem - self.den } else { rem },
        }
    }

    #[cold]
    fn long_after(&self, from: Tick, quantum: &Quantum, count: u64) -> Tick {
        let den = u128::from(self.den);
        let period = u128::from(quantum.whole) * den + u128::from(quantum.fraction);
        let sum = u128::from(from.rem) + period.saturating_mul(u128::from(count));
        let fs = u128::from(from.fs) + sum / den;
        Tick { fs: u64::try_from(fs).unwrap_or(u64::MAX), rem: (sum % den) as u64 }
    }

    /// The number of the quantum that `time` falls into, 0 being the one that begins at `origin`;
    /// 0 as well for times before.
    #[must_use]
    #[inline]
    pub fn locate(&self, origin: Tick, quantum: &Quantum, time: Time) -> u64 {
        let at = time.femtoseconds();
        let delta = at.saturating_sub(origin.fs);
        if delta > 1 << 40 {
            return self.locate_far(origin, quantum, at);
        }
        // The estimate is right or one off; most times one look shows that it is right.
        let mut count = (delta as f64 * quantum.per_fs) as u64;
        let tick = self.after(origin, quantum, count).fs;
        if tick > at {
            count = count.saturating_sub(1);
        } else if at - tick >= quantum.whole && self.after(origin, quantum, count + 1).fs <= at {
            count += 1;
        }
        count
    }

    #[cold]
    fn locate_far(&self, origin: Tick, quantum: &Quantum, at: u64) -> u64 {
        let den = u128::from(self.den);
        let period = u128::from(quantum.whole) * den + u128::from(quantum.fraction);
        // Tick n counts as floor(origin + n·T); the largest n with that not after `at`.
        let span = (u128::from(at) - u128::from(origin.fs) + 1) * den - u128::from(origin.rem) - 1;
        (span / period) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// floor(n·10^24 / (hz·(10^9+ppb))) by plain arithmetic on the definition.
    fn by_definition(hertz: u128, ppb: i128, periods: u128) -> u64 {
        let den = hertz * (1_000_000_000 + ppb) as u128;
        let num = 1_000_000_000_000_000_000_000_000_u128;
        // Split to stay inside 128 bits.
        let (whole, rest) = (num / den, num % den);
        (periods * whole + periods * rest / den) as u64
    }

    #[test]
    fn every_tick_is_n_periods_exactly_however_it_was_reached() {
        for (hertz, ppb) in
            [(80_000_000, 0), (24_000_000, 0), (19_660_800, -478_123), (16_666_667, 3_000_001)]
        {
            let clock = Clock::new(hertz, ppb).unwrap();
            let quantum = clock.quantum(1);
            let mut tick = Tick::default();
            let mut n = 0_u64;
            let mut step = 1;
            while n < 200_000_000 {
                tick = clock.after(tick, &quantum, step);
                n += step;
                let want = by_definition(hertz.into(), ppb.into(), n.into());
                let again = clock.next(clock.after(Tick::default(), &quantum, n - 1), &quantum);
                assert_eq!(again, tick, "{hertz} Hz {ppb} ppb tick {n}");
                assert_eq!(tick.fs, want, "{hertz} Hz {ppb} ppb tick {n}");
                assert_eq!(clock.locate(Tick::default(), &quantum, tick.time()), n);
                step = step * 13 / 7 + 1;
                if step > 3_000_000 {
                    step = 5;
                }
            }
        }
    }

    #[test]
    fn a_third_of_a_microsecond_adds_up_to_the_hour() {
        let clock = Clock::new(24_000_000, 0).unwrap();
        let quantum = clock.quantum(8);
        let mut tick = Tick::default();
        for _ in 0..3_600 {
            for _ in 0..3 {
                tick = clock.after(tick, &quantum, 1_000_000);
            }
        }
        assert_eq!(tick, Tick { fs: 3_600_000_000_000_000_000, rem: 0 });
    }

    #[test]
    fn locate_agrees_with_the_ticks_on_both_sides_of_each() {
        let clock = Clock::new(40_000_000, 123_457).unwrap();
        let quantum = clock.quantum(5);
        let origin = clock.after(Tick::default(), &quantum, 777);
        for n in 1..5_000 {
            let tick = clock.after(origin, &quantum, n);
            assert_eq!(clock.locate(origin, &quantum, tick.time()), n);
            let just_before = Time::from_fs(tick.fs - 1);
            assert_eq!(clock.locate(origin, &quantum, just_before), n - 1);
            assert_eq!(clock.locate_far(origin, &quantum, tick.fs), n);
            assert_eq!(clock.locate_far(origin, &quantum, tick.fs - 1), n - 1);
        }
    }

    #[test]
    fn out_of_range_names_the_value() {
        assert_eq!(Clock::new(10, 0), Err(ClockError::Frequency(10)));
        assert_eq!(Clock::new(1_000_000, i64::MAX), Err(ClockError::Deviation(i64::MAX)));
    }
}
