//! Numbers in text, as instruments and programs write them.

use canbaud::units::{Hertz, Timebase};

/// A frequency: `500 kHz`, `16.666667 MHz`, `4000000 Hz`, `25000000.0`, `2.5e7`; the prefixes are
/// read in any case, as sigrok does.
pub(crate) fn hertz(text: &str) -> Option<Hertz> {
    let text = text.trim();
    let lower = text.to_ascii_lowercase();
    let lower = ["hz", "sa/s", "s/s", "sps"]
        .iter()
        .find_map(|unit| lower.strip_suffix(unit))
        .unwrap_or(&lower)
        .trim_end();
    let (digits, exponent) = match lower.as_bytes().last()? {
        b'k' => (lower.get(..lower.len() - 1)?, 3),
        b'm' => (lower.get(..lower.len() - 1)?, 6),
        b'g' => (lower.get(..lower.len() - 1)?, 9),
        b't' => (lower.get(..lower.len() - 1)?, 12),
        _ => (lower, 0),
    };
    let decimal = Decimal::parse(digits.trim().as_bytes())?;
    u64::try_from(decimal.scaled(exponent)?).ok().and_then(Hertz::new)
}

/// A decimal number, exact: `mantissa * 10^exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Decimal {
    pub(crate) mantissa: i64,
    pub(crate) exponent: i32,
}

impl Decimal {
    /// Reads `-1.25e-3`, `+4`, `.5`; digits beyond the 18th are dropped. The whole text must fit.
    pub(crate) fn parse(text: &[u8]) -> Option<Self> {
        let (negative, text) = match text {
            [b'-', rest @ ..] => (true, rest),
            [b'+', rest @ ..] => (false, rest),
            rest => (false, rest),
        };
        let mut mantissa: i64 = 0;
        let mut exponent: i32 = 0;
        let mut point = false;
        let mut digits = 0_usize;
        let mut rest = text;
        while let [byte, next @ ..] = rest {
            match byte {
                b'0'..=b'9' => {
                    digits += 1;
                    if mantissa < 100_000_000_000_000_000 {
                        mantissa = mantissa * 10 + i64::from(byte - b'0');
                        exponent = exponent.saturating_sub(i32::from(point));
                    } else {
                        exponent = exponent.saturating_add(i32::from(!point));
                    }
                }
                b'.' if !point => point = true,
                _ => break,
            }
            rest = next;
        }
        if digits == 0 {
            return None;
        }
        match rest {
            [] => {}
            [b'e' | b'E', power @ ..] => {
                let power: i32 = core::str::from_utf8(power).ok()?.parse().ok()?;
                exponent = exponent.checked_add(power)?;
            }
            _ => return None,
        }
        Some(Self { mantissa: if negative { -mantissa } else { mantissa }, exponent })
    }

    /// The value times `10^power`, rounded half away from zero; `None` if it does not fit.
    pub(crate) fn scaled(self, power: i32) -> Option<i128> {
        let shift = self.exponent.checked_add(power)?;
        let value = i128::from(self.mantissa);
        if value == 0 {
            return Some(0);
        }
        let factor = 10_i128.checked_pow(shift.unsigned_abs());
        match (shift >= 0, factor) {
            (true, Some(factor)) => value.checked_mul(factor),
            (true, None) => None,
            (false, None) => Some(0),
            (false, Some(factor)) => Some((value + value.signum() * (factor / 2)) / factor),
        }
    }

    /// The nearest float, to a part in 10^15.
    pub(crate) fn to_f64(self) -> f64 {
        let value = self.mantissa as f64;
        if value == 0.0 || self.exponent == 0 {
            return value;
        }
        // Beyond these powers an f64 is zero or infinite anyway.
        let power = self.exponent.clamp(-400, 400);
        match power {
            0..=22 => value * 10_f64.powi(power),
            -22..0 => value / 10_f64.powi(-power),
            _ => value * 10_f64.powi(power),
        }
    }
}

/// The timebase whose tick is `period / divisor` seconds, and the rate `1 / period` rounded to
/// 1 Hz; `None` if the period is not above zero or out of range.
pub(crate) fn period_timebase(period: Decimal, divisor: u64) -> Option<(Timebase, Hertz)> {
    let mantissa = u128::try_from(period.mantissa).ok().filter(|m| *m > 0)?;
    let (mut ticks, mut seconds) = if period.exponent >= 0 {
        (1, mantissa.checked_mul(10_u128.checked_pow(period.exponent.unsigned_abs())?)?)
    } else {
        (10_u128.checked_pow(period.exponent.unsigned_abs())?, mantissa)
    };
    let rate = Hertz::new(u64::try_from((ticks + seconds / 2) / seconds).ok()?.max(1))?;
    ticks = ticks.checked_mul(u128::from(divisor))?;
    let common = gcd(ticks, seconds);
    ticks /= common;
    seconds /= common;
    // A ratio of more digits than a timebase holds loses its last ones.
    while ticks.max(seconds) > u128::from(Hertz::MAX.hertz()) {
        ticks = (ticks + 5) / 10;
        seconds = (seconds + 5) / 10;
    }
    Some((Timebase::new(u64::try_from(ticks).ok()?, u64::try_from(seconds).ok()?)?, rate))
}

pub(crate) const fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sigrok_rates() {
        let rate = |text| hertz(text).map(Hertz::hertz);
        assert_eq!(rate("500 kHz"), Some(500_000));
        assert_eq!(rate("100 MHz"), Some(100_000_000));
        assert_eq!(rate("16.666667 mhz"), Some(16_666_667));
        assert_eq!(rate("4000000 Hz"), Some(4_000_000));
        assert_eq!(rate("25000000.0"), Some(25_000_000));
        assert_eq!(rate("1G"), Some(1_000_000_000));
        for bad in ["", "Hz", "0", "-4 MHz", "1e400 Hz", "nan", "99999999 GHz", "4 MHz x"] {
            assert_eq!(rate(bad), None, "{bad}");
        }
    }

    #[test]
    fn decimals_are_exact() {
        let scaled =
            |text: &str, power| Decimal::parse(text.as_bytes()).and_then(|d| d.scaled(power));
        assert_eq!(scaled("0.000050140", 9), Some(50_140));
        assert_eq!(scaled("-2.000000e-04", 9), Some(-200_000));
        assert_eq!(scaled("+1.240000E+01", 12), Some(12_400_000_000_000));
        assert_eq!(scaled("1234567890.123456789", 9), Some(1_234_567_890_123_456_780));
        assert_eq!(scaled(".5", 0), Some(1));
        assert_eq!(scaled("1e-400", 9), Some(0));
        for bad in ["", "-", ".", "1e", "1.2.3", "0x10", "inf", "nan", "1 "] {
            assert_eq!(scaled(bad, 0), None, "{bad}");
        }
        assert_eq!(scaled("1e300", 0), None);
    }

    #[test]
    fn periods() {
        let timebase =
            |text: &str, n| Decimal::parse(text.as_bytes()).and_then(|d| period_timebase(d, n));
        let (t, rate) = timebase("4e-08", 16).unwrap();
        assert_eq!((t.ticks(), t.seconds(), rate.hertz()), (400_000_000, 1, 25_000_000));
        let (t, rate) = timebase("1.5", 1).unwrap();
        assert_eq!((t.ticks(), t.seconds(), rate.hertz()), (2, 3, 1));
        for bad in ["0", "-1e-9", "1e-40", "1e40"] {
            assert!(timebase(bad, 16).is_none(), "{bad}");
        }
    }
}
