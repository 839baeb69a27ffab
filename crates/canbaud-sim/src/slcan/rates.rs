//! Which bit rate a command stands for.

use canbaud::units::Permille;

use super::adapter::Dialect;
use crate::node::Oscillator;
use crate::timing::BitTiming;

/// `Sn`.
pub(super) fn nominal(digit: &str, dialect: Dialect, oscillator: Oscillator) -> Option<BitTiming> {
    let rate = match (digit, dialect) {
        ("0", _) => 10_000,
        ("1", _) => 20_000,
        ("2", _) => 50_000,
        ("3", _) => 100_000,
        ("4", _) => 125_000,
        ("5", _) => 250_000,
        ("6", _) => 500_000,
        ("7", Dialect::Lawicel) => 800_000,
        ("7", Dialect::Canable) => 750_000,
        ("8", _) => 1_000_000,
        ("9", Dialect::Canable) => 83_333,
        _ => return None,
    };
    let sample_point = Permille::new(875)?;
    BitTiming::find(oscillator.hertz, rate, sample_point).ok()
}

/// `Yn`: the data bit rate in Mbit/s.
pub(super) fn data(digit: &str, oscillator: Oscillator) -> Option<BitTiming> {
    let rate = match digit {
        "1" | "2" | "4" | "5" | "8" => digit.parse::<u32>().ok()? * 1_000_000,
        _ => return None,
    };
    BitTiming::find(oscillator.hertz, rate, Permille::new(800)?).ok()
}

/// `sxxyy`: BTR0 and BTR1 of a SJA1000 whose quanta come from 8 MHz.
pub(super) fn registers(digits: &str, oscillator: Oscillator) -> Option<BitTiming> {
    if digits.len() != 4 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let value = u32::from_str_radix(digits, 16).ok()?;
    let (btr0, btr1) = (value >> 8, value & 0xFF);
    let per_8mhz = u32::try_from(oscillator.hertz / 8_000_000).ok()?;
    let prescaler = ((btr0 & 0x3F) + 1) * per_8mhz;
    let segment1 = (btr1 & 0x0F) + 1;
    let segment2 = ((btr1 >> 4) & 7) + 1;
    // The controller has no PROP_SEG of its own.
    let phase_seg1 = segment1.min(segment2);
    let sjw = ((btr0 >> 6) + 1).min(phase_seg1);
    BitTiming::new(prescaler, segment1 - phase_seg1, phase_seg1, segment2, sjw).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCK: Oscillator = Oscillator { hertz: 80_000_000, ppb: 0 };

    fn rate(timing: BitTiming) -> u32 {
        (CLOCK.hertz / u64::from(timing.prescaler() * timing.quanta())) as u32
    }

    #[test]
    fn register_values_of_the_can232_manual_give_their_rates() {
        for (digits, want) in
            [("031C", 125_000), ("001C", 500_000), ("0014", 1_000_000), ("311C", 10_000)]
        {
            assert_eq!(rate(registers(digits, CLOCK).unwrap()), want, "{digits}");
        }
    }

    #[test]
    fn digits_7_and_9_depend_on_the_dialect() {
        assert_eq!(rate(nominal("7", Dialect::Lawicel, CLOCK).unwrap()), 800_000);
        assert!(rate(nominal("7", Dialect::Canable, CLOCK).unwrap()).abs_diff(750_000) < 3_000);
        assert_eq!(nominal("9", Dialect::Lawicel, CLOCK), None);
    }
}
