//! Times and bit rates as every command takes them.

use std::time::Duration;

use canbaud::units::{Bitrate, Hertz, Micros};

/// Nobody runs CAN below this; a smaller number wants its `k`.
const SLOWEST: u32 = 1_000;
const MS: u64 = 1_000;
const MINUTE: u64 = 60_000_000;
const DAY: u64 = 86_400_000_000;
const UNITS: [(&str, u64); 4] = [("ms", MS), ("us", 1), ("min", MINUTE), ("s", 1_000_000)];

/// `30s`, `500ms`, `2min`; up to a day. A number alone is none: of seconds or of milliseconds?
pub(crate) fn time(text: &str) -> Result<Micros, String> {
    within(text, 1, DAY, "30s, 500ms, 2min, up to a day")
}

/// How long an answer may take.
pub(crate) fn answer_time(text: &str) -> Result<Micros, String> {
    within(text, MS, MINUTE, "500ms or 2s, from 1ms to 60s")
}

/// A pause or a latency, which there may be none of.
pub(crate) fn pause(text: &str) -> Result<Micros, String> {
    within(text, 0, 10_000_000, "10ms, from 0ms to 10s")
}

/// How long something is waited for.
pub(crate) fn wait(text: &str) -> Result<Duration, String> {
    let time = within(text, MS, DAY, "30s or 2min, from 1ms to a day")?;
    Ok(Duration::from_micros(time.0))
}

/// A switch delay, in ms [CiA 305].
pub(crate) fn switch_delay(text: &str) -> Result<u16, String> {
    let wanted = "500ms or 1s, in whole ms from 1ms to 65535ms";
    let time = within(text, MS, 65_535 * MS, wanted)?;
    match u16::try_from(time.0 / MS) {
        Ok(ms) if time.0 % MS == 0 => Ok(ms),
        _ => Err(format!("a time is wanted, such as {wanted}")),
    }
}

fn within(text: &str, least: u64, most: u64, wanted: &str) -> Result<Micros, String> {
    let none = || format!("a time is wanted, such as {wanted}");
    if !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(format!("{text} of what? write {text}ms or {text}s ({})", none()));
    }
    let (number, unit) = UNITS
        .into_iter()
        .find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit)))
        .ok_or_else(none)?;
    let digits = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    let number: Option<u64> = if digits { number.parse().ok() } else { None };
    match number.and_then(|number| number.checked_mul(unit)) {
        Some(us) if (least..=most).contains(&us) => Ok(Micros(us)),
        _ => Err(none()),
    }
}

/// The sample rate of a recording: below the slowest bit rate nothing can be read.
pub(crate) fn sample_rate(text: &str) -> Result<Hertz, String> {
    let rate: Hertz = text.parse().map_err(|error| format!("{error}"))?;
    match rate.hertz() {
        slow if slow < u64::from(SLOWEST) => {
            Err(format!("{slow} is {slow} Hz; {slow}M is {slow} MHz"))
        }
        _ => Ok(rate),
    }
}

/// A bit rate.
pub(crate) fn bus_rate(text: &str) -> Result<Bitrate, String> {
    let rate: Bitrate = text.parse().map_err(|error| format!("{error}"))?;
    match rate.bits_per_second() {
        ..SLOWEST => Err(format!("{rate} is {rate} bit/s; {rate}k is {rate} kbit/s")),
        _ => Ok(rate),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        assert_eq!(time("30s"), Ok(Micros(30_000_000)));
        assert_eq!(time("500ms"), Ok(Micros(500_000)));
        assert_eq!(time("2min"), Ok(Micros(120_000_000)));
        for wrong in ["", "s", "0s", "5", "-1s", "+1s", "1.5s", "99999999999999s", "25h"] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
        assert!(time("500").unwrap_err().starts_with("500 of what? write 500ms or 500s"));
        assert_eq!(pause("0ms"), Ok(Micros(0)));
        assert_eq!(answer_time("60s"), Ok(Micros(60_000_000)));
        assert!(answer_time("61s").is_err() && answer_time("0ms").is_err());
    }

    #[test]
    fn a_switch_delay_is_in_whole_ms_of_16_bits() {
        assert_eq!((switch_delay("1s"), switch_delay("65535ms")), (Ok(1000), Ok(65_535)));
        for wrong in ["0ms", "65536ms", "1500us", "66s", "1000"] {
            assert!(switch_delay(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_rate_without_its_k_is_asked_about() {
        assert_eq!(bus_rate("125").unwrap_err(), "125 is 125 bit/s; 125k is 125 kbit/s");
        for good in ["125k", "1000", "33.333k", "1M"] {
            assert!(bus_rate(good).is_ok(), "{good}");
        }
        assert!(bus_rate("fast").is_err());
        assert_eq!(sample_rate("24").unwrap_err(), "24 is 24 Hz; 24M is 24 MHz");
        assert!(sample_rate("24M").is_ok() && sample_rate("1000").is_ok());
    }
}
