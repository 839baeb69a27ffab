//! The command that sets a bit rate; no I/O.

use canbaud::detect::scan::{Candidate, Capture};
use canbaud::timing::controllers::{Configuration, mcp2515, sja1000};
use canbaud::timing::{
    BitTiming, Limits, Prescalers, Request, SamplePointPolicy, SjwPolicy, Solution, Span, solve,
};
use canbaud::units::{Bitrate, Hertz, Permille};

use super::firmware::{Digit, Firmware};

/// Crystals.
const LAWICEL: Hertz = Hertz::new(16_000_000).unwrap();
const USBTIN: Hertz = Hertz::new(24_000_000).unwrap();
/// Wider than the usual 80 to 87.5 %: edges may come early and late alike.
const WIDE_SAMPLE_POINT: Permille = Permille::new(600).unwrap();

/// A step of a sweep is 5 %: where a slow clock has no divisor nearby, a neighbour has to do.
const WIDE_TOLERANCE_PPM: u32 = 30_000;

/// What `sddxxyyzz` takes: as it is, one byte each.
const CANABLE2: Limits =
    Limits::new(Span::new(1, 255), Span::new(1, 128), 128, Prescalers::range(1, 255));

/// A command without its CR, and the rate that it makes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RateCommand {
    pub(crate) text: String,
    pub(crate) rate: Bitrate,
}

/// How to set `firmware` to the nominal rate of `candidate`; `None` if it cannot be.
pub(crate) fn command(firmware: Firmware, candidate: &Candidate) -> Option<RateCommand> {
    let usual = candidate.capture == Capture::Usual;
    let known = firmware.digits().iter().find(|digit| digit.1 == candidate.nominal);
    if let Some(Digit(digit, rate)) = known.filter(|_| usual) {
        return Some(RateCommand { text: format!("S{}", char::from(*digit)), rate: *rate });
    }
    let (solution, text) = registers(firmware, candidate)?;
    Some(RateCommand { text, rate: rate_of(&solution)? })
}

/// Slowest and fastest rate that registers make; `None` without registers.
pub(super) fn range(firmware: Firmware) -> Option<(Bitrate, Bitrate)> {
    let slowest = match firmware {
        // 8 MHz / 64 / 25, 12 MHz / 64 / 25, 160 MHz / 255 / 385.
        Firmware::Lawicel => 5_000,
        Firmware::Usbtin => 7_500,
        Firmware::Canable2 { clock: Some(clock) } => {
            u32::try_from(clock.hertz().div_ceil(255 * 385)).ok()?
        }
        Firmware::Canable2 { clock: None } | Firmware::CanableStock | Firmware::Other => {
            return None;
        }
    };
    Bitrate::new(slowest).zip(Bitrate::new(1_000_000))
}

/// Registers for `s`.
fn registers(firmware: Firmware, candidate: &Candidate) -> Option<(Solution, String)> {
    let (clock, limits) = match firmware {
        Firmware::Lawicel => (LAWICEL, &sja1000::NOMINAL),
        Firmware::Usbtin => (USBTIN, &mcp2515::NOMINAL),
        Firmware::Canable2 { clock } => (clock?, &CANABLE2),
        Firmware::CanableStock | Firmware::Other => return None,
    };
    let mut request = Request::new(clock, candidate.nominal);
    if candidate.capture == Capture::Wide {
        request = request
            .with_sample_point(WIDE_SAMPLE_POINT, SamplePointPolicy::Nearest)
            .with_sjw(SjwPolicy::Largest)
            .with_tolerance_ppm(WIDE_TOLERANCE_PPM);
    }
    let solution = solve(&request, limits).ok()?;
    let text = match firmware {
        Firmware::Usbtin => packed(&mcp2515::CONTROLLER, solution.timing)?,
        Firmware::Canable2 { .. } => plain(solution.timing)?,
        _ => packed(&sja1000::CONTROLLER, solution.timing)?,
    };
    Some((solution, text))
}

/// The registers of a controller, in their order.
fn packed(
    controller: &canbaud::timing::controllers::Controller,
    timing: BitTiming,
) -> Option<String> {
    let mut text = "s".to_owned();
    for (_, word) in controller.pack(&Configuration::classic(timing)).ok()? {
        text.push_str(&format!("{:02X}", word.ok()?));
    }
    Some(text)
}

/// Real values, two digits each.
fn plain(timing: BitTiming) -> Option<String> {
    let values =
        [u32::from(timing.prescaler), timing.tseg1(), timing.tseg2(), u32::from(timing.sjw)];
    let mut text = "s".to_owned();
    for value in values {
        text.push_str(&format!("{:02X}", u8::try_from(value).ok()?));
    }
    Some(text)
}

/// In whole bit/s, rounded.
fn rate_of(solution: &Solution) -> Option<Bitrate> {
    let millibits = solution.rate.millibits_per_second();
    Bitrate::new(u32::try_from(millibits.saturating_add(500) / 1000).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(firmware: Firmware, rate: u32) -> Option<String> {
        command(firmware, &Candidate::classic(Bitrate::new(rate).unwrap())).map(|it| it.text)
    }

    #[test]
    fn canopen_rates_are_digits() {
        for (rate, want) in [
            (10_000, "S0"),
            (20_000, "S1"),
            (50_000, "S2"),
            (125_000, "S4"),
            (250_000, "S5"),
            (500_000, "S6"),
            (800_000, "S7"),
            (1_000_000, "S8"),
        ] {
            for firmware in
                [Firmware::Lawicel, Firmware::Usbtin, Firmware::Canable2 { clock: None }]
            {
                assert_eq!(said(firmware, rate).as_deref(), Some(want), "{firmware:?}");
            }
        }
        // 750 or 800 kbit/s: nobody knows.
        assert_eq!(said(Firmware::Other, 800_000), None);
        assert_eq!(said(Firmware::CanableStock, 83_333), None);
    }

    /// What registers make, by the data sheets: SJA1000 6.5, MCP2515 5.0.
    #[test]
    fn registers_make_the_rates_that_have_no_digit() {
        for rate in [5_000, 33_333, 47_619, 62_500, 83_333, 95_238, 200_000, 400_000, 615_385] {
            let text = said(Firmware::Lawicel, rate).unwrap();
            let word = u32::from_str_radix(&text[1..], 16).unwrap();
            let (btr0, btr1) = (word >> 8, word & 0xFF);
            let quanta = 1 + (btr1 & 15) + 1 + (btr1 >> 4 & 7) + 1;
            let made = 8_000_000 / (((btr0 & 63) + 1) * quanta);
            assert!(made.abs_diff(rate) * 200 <= rate, "{rate}: {text} makes {made}");
        }
        for rate in [33_333, 83_333, 400_000] {
            let text = said(Firmware::Usbtin, rate).unwrap();
            let word = u32::from_str_radix(&text[1..], 16).unwrap();
            let (cnf1, cnf2, cnf3) = (word >> 16, word >> 8 & 0xFF, word & 0xFF);
            assert_eq!(cnf2 & 0x80, 0x80, "PHASE_SEG2 counts");
            let quanta = 1 + (cnf2 & 7) + 1 + (cnf2 >> 3 & 7) + 1 + (cnf3 & 7) + 1;
            let made = 12_000_000 / (((cnf1 & 63) + 1) * quanta);
            assert!(made.abs_diff(rate) * 200 <= rate, "{rate}: {text} makes {made}");
        }
        let clock = Hertz::new(160_000_000);
        let text = said(Firmware::Canable2 { clock }, 83_333).unwrap();
        let word = u32::from_str_radix(&text[1..], 16).unwrap();
        let quanta = 1 + (word >> 16 & 0xFF) + (word >> 8 & 0xFF);
        assert_eq!(160_000_000 / ((word >> 24) * quanta), 83_333, "{text}");
    }

    /// 8 MHz has few divisors: a sweep that asked for its own rates alone would have gaps.
    #[test]
    fn a_sweep_has_no_gap_for_a_usual_rate() {
        let sweep: Vec<f64> = (0..)
            .map(|step| 10_000.0 * 1.05_f64.powi(step))
            .take_while(|rate| *rate < 1e6)
            .collect();
        for firmware in [Firmware::Lawicel, Firmware::Usbtin] {
            let made: Vec<u32> = sweep
                .iter()
                .filter_map(|rate| {
                    let nominal = Bitrate::new(*rate as u32)?;
                    let wide = Candidate { capture: Capture::Wide, ..Candidate::classic(nominal) };
                    Some(command(firmware, &wide)?.rate.bits_per_second())
                })
                .collect();
            for usual in
                [10_000, 20_000, 33_333, 50_000, 83_333, 100_000, 125_000, 250_000, 500_000]
            {
                let near = made.iter().any(|rate| rate.abs_diff(usual) * 40 <= usual);
                assert!(near, "{firmware:?} {usual}: {made:?}");
            }
        }
    }

    #[test]
    fn a_wide_candidate_takes_the_largest_sjw() {
        let candidate = Candidate {
            capture: Capture::Wide,
            ..Candidate::classic(Bitrate::new(125_000).unwrap())
        };
        let wide = command(Firmware::Lawicel, &candidate).unwrap();
        let word = u32::from_str_radix(&wide.text[1..], 16).unwrap();
        assert_eq!(word >> 14, 3, "{}", wide.text);
        assert_eq!(wide.rate.bits_per_second(), 125_000);
    }
}
