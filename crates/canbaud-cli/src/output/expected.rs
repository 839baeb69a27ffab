//! The measured bit rate beside the one that was expected.

use canbaud::timing::doctor::{Cause, diagnose};
use canbaud::units::Bitrate;

use super::number::{bitrate, deviation_ppm, signed_ppm};
use crate::report::Rate;

/// A clock that far off is none: no two nodes of one bus could talk.
const ANOTHER_RATE_PPM: f64 = 50_000.0;

/// How far off the measured rate is; for another rate, what a node's clock may have to do with it.
pub(super) fn words(expected: Bitrate, rate: &Rate) -> String {
    let wanted = expected.bits_per_second();
    let offset = deviation_ppm(rate.measured, wanted);
    if offset.abs() < ANOTHER_RATE_PPM {
        return format!("{}: measured {}", bitrate(wanted), signed_ppm(offset));
    }
    // Rates below 0 do not occur, and what is too large to be a rate saturates.
    let millibits = (rate.measured * 1_000.0).round() as u64;
    let diagnosis = diagnose(expected, millibits, rate.uncertainty_ppm.ceil() as u32);
    let (numerator, denominator) = diagnosis.factor;
    match diagnosis.cause {
        Cause::Unexplained => format!("{}: this is another rate", bitrate(wanted)),
        cause => format!(
            "{}: this is another rate, {numerator}/{denominator} of it. If a node was meant to run at \
             it: {cause}",
            bitrate(wanted)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(measured: f64) -> Rate {
        Rate { bitrate: measured.round() as u32, measured, uncertainty_ppm: 3.0, known_as: None }
    }

    #[test]
    fn a_simple_factor_is_explained() {
        let expected = Bitrate::new(500_000).unwrap();
        let text = words(expected, &measured(250_010.0));
        assert!(text.starts_with("500 kbit/s: this is another rate, 1/2 of it."), "{text}");
        assert!(text.contains("8 MHz crystal where 16 MHz was configured"), "{text}");
        let text = words(expected, &measured(333_333.3));
        assert!(text.contains("2/3 of it") && text.contains("16 MHz where 24 MHz"), "{text}");
    }

    #[test]
    fn no_simple_factor_is_not_explained() {
        let text = words(Bitrate::new(500_000).unwrap(), &measured(95_238.0));
        assert_eq!(text, "500 kbit/s: this is another rate");
    }

    #[test]
    fn a_clock_that_is_a_little_off_is_measured() {
        let text = words(Bitrate::new(500_000).unwrap(), &measured(500_005.0));
        assert_eq!(text, "500 kbit/s: measured +10 ppm");
    }
}
