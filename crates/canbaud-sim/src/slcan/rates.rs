//! Which bit timing a command stands for.

use super::firmware::Firmware;
use crate::timing::BitTiming;

/// PROP_SEG and PHASE_SEG1 together, PHASE_SEG2, SJW: what most controllers have.
fn joined(prescaler: u32, segment1: u32, segment2: u32, sjw: u32) -> Option<BitTiming> {
    let phase_seg1 = segment1.min(segment2);
    let sjw = sjw.min(phase_seg1);
    BitTiming::new(prescaler, segment1 - phase_seg1, phase_seg1, segment2, sjw).ok()
}

/// BTR0 and BTR1 of a SJA1000.
fn btr(btr0: u32, btr1: u32) -> Option<BitTiming> {
    joined((btr0 & 0x3F) + 1, (btr1 & 0x0F) + 1, ((btr1 >> 4) & 7) + 1, (btr0 >> 6) + 1)
}

/// CNF1 to CNF3 of a MCP2515.
fn cnf(cnf1: u32, cnf2: u32, cnf3: u32) -> Option<BitTiming> {
    let phase_seg1 = ((cnf2 >> 3) & 7) + 1;
    // BTLMODE chooses whether CNF3 counts; the information processing time is two quanta.
    let phase_seg2 = if cnf2 & 0x80 == 0 { phase_seg1.max(2) } else { ((cnf3 & 7) + 1).max(2) };
    let sjw = ((cnf1 >> 6) + 1).min(phase_seg1).min(phase_seg2);
    BitTiming::new((cnf1 & 0x3F) + 1, (cnf2 & 7) + 1, phase_seg1, phase_seg2, sjw).ok()
}

/// What the firmware starts with, before any `S` or `s`.
pub(super) fn at_power_on(firmware: Firmware) -> Option<BitTiming> {
    match firmware {
        Firmware::Lawicel => None,
        Firmware::Canable1 | Firmware::Canable2 | Firmware::Canable2Stock => nominal("4", firmware),
        // The reset values of the registers, which are of no use.
        Firmware::Usbtin => cnf(0, 0, 0),
    }
}

/// What the data phase starts with.
pub(super) fn data_at_power_on(firmware: Firmware) -> Option<BitTiming> {
    data("2", firmware)
}

/// `Sn`: the settings that each firmware makes of it.
pub(super) fn nominal(digit: &str, firmware: Firmware) -> Option<BitTiming> {
    let digit = match digit.as_bytes() {
        [digit @ b'0'..=b'9'] => usize::from(digit - b'0'),
        _ => return None,
    };
    match firmware {
        Firmware::Lawicel => {
            const BTR: [(u32, u32); 9] = [
                (0x31, 0x1C),
                (0x18, 0x1C),
                (0x09, 0x1C),
                (0x04, 0x1C),
                (0x03, 0x1C),
                (0x01, 0x1C),
                (0x00, 0x1C),
                (0x00, 0x16),
                (0x00, 0x14),
            ];
            BTR.get(digit).and_then(|&(btr0, btr1)| btr(btr0, btr1))
        }
        Firmware::Canable1 => {
            const PRESCALERS: [u32; 9] = [600, 300, 120, 60, 48, 24, 12, 8, 6];
            PRESCALERS.get(digit).and_then(|&prescaler| joined(prescaler, 4, 3, 1))
        }
        Firmware::Canable2 | Firmware::Canable2Stock => fdcan_nominal(digit, firmware),
        Firmware::Usbtin => {
            const CNF: [(u32, u32, u32); 9] = [
                (0x3B, 0xB6, 0x04),
                (0x1D, 0xB6, 0x04),
                (0x0B, 0xB6, 0x04),
                (0x05, 0xB6, 0x04),
                (0x05, 0xAC, 0x03),
                (0x02, 0xAC, 0x03),
                (0x01, 0x9B, 0x02),
                (0x00, 0xA4, 0x03),
                (0x00, 0x9B, 0x02),
            ];
            CNF.get(digit).and_then(|&(cnf1, cnf2, cnf3)| cnf(cnf1, cnf2, cnf3))
        }
    }
}

fn fdcan_nominal(digit: usize, firmware: Firmware) -> Option<BitTiming> {
    const PRESCALERS: [u32; 7] = [200, 100, 40, 20, 16, 8, 4];
    match (digit, firmware) {
        (7, Firmware::Canable2) => joined(2, 88, 11, 10),
        // Meant as 750 kbit/s: 160 MHz / (4 * 53).
        (7, _) => joined(4, 46, 6, 5),
        (8, _) => joined(2, 70, 9, 8),
        (9, Firmware::Canable2Stock) => joined(24, 70, 9, 8),
        _ => PRESCALERS.get(digit).and_then(|&prescaler| joined(prescaler, 70, 9, 8)),
    }
}

/// `Yn`: the data bit rate.
pub(super) fn data(digit: &str, firmware: Firmware) -> Option<BitTiming> {
    match (digit, firmware) {
        (_, Firmware::Lawicel | Firmware::Canable1 | Firmware::Usbtin) => None,
        ("0", Firmware::Canable2) => joined(8, 30, 9, 8),
        ("1", _) => joined(4, 30, 9, 8),
        ("2", _) => joined(2, 30, 9, 8),
        ("4", _) => joined(1, 30, 9, 8),
        ("5", _) => joined(1, 24, 7, 6),
        ("8", Firmware::Canable2) => joined(1, 14, 5, 3),
        _ => None,
    }
}

/// Two hexadecimal digits each.
fn bytes<const N: usize>(digits: &str) -> Option<[u32; N]> {
    if digits.len() != 2 * N || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let mut values = [0; N];
    for (at, value) in values.iter_mut().enumerate() {
        *value = u32::from_str_radix(digits.get(2 * at..2 * at + 2)?, 16).ok()?;
    }
    Some(values)
}

/// `s` and registers.
pub(super) fn registers(digits: &str, firmware: Firmware) -> Option<BitTiming> {
    match firmware {
        Firmware::Lawicel => bytes(digits).and_then(|[btr0, btr1]| btr(btr0, btr1)),
        Firmware::Usbtin => bytes(digits).and_then(|[cnf1, cnf2, cnf3]| cnf(cnf1, cnf2, cnf3)),
        Firmware::Canable2 => fields(digits, [0xFF, 0xFF, 0x80, 0x80]),
        Firmware::Canable1 | Firmware::Canable2Stock => None,
    }
}

/// `y` and registers.
pub(super) fn data_registers(digits: &str, firmware: Firmware) -> Option<BitTiming> {
    match firmware {
        Firmware::Canable2 => fields(digits, [0x20, 0x20, 0x10, 0x10]),
        Firmware::Lawicel | Firmware::Canable1 | Firmware::Canable2Stock | Firmware::Usbtin => None,
    }
}

/// Prescaler, both segments and SJW as they are, from 1 to `most`.
fn fields(digits: &str, most: [u32; 4]) -> Option<BitTiming> {
    let values: [u32; 4] = bytes(digits)?;
    if values.iter().zip(most).any(|(&value, most)| value == 0 || value > most) {
        return None;
    }
    let [prescaler, segment1, segment2, sjw] = values;
    joined(prescaler, segment1, segment2, sjw)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In bit/s, rounded.
    fn rate(timing: Option<BitTiming>, firmware: Firmware) -> Option<u64> {
        let timing = timing?;
        let periods = u64::from(timing.prescaler() * timing.quanta());
        Some((firmware.clock_hz() + periods / 2) / periods)
    }

    #[test]
    fn digits_of_s_are_the_rates_that_each_firmware_documents() {
        const FIRST: [u64; 7] = [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000];
        let last = [
            (Firmware::Lawicel, [Some(800_000), Some(1_000_000), None]),
            (Firmware::Canable1, [Some(750_000), Some(1_000_000), None]),
            (Firmware::Canable2, [Some(800_000), Some(1_000_000), None]),
            // 750 kbit/s is asked for; 160 MHz have no better divisor of that kind.
            (Firmware::Canable2Stock, [Some(754_717), Some(1_000_000), Some(83_333)]),
            (Firmware::Usbtin, [Some(800_000), Some(1_000_000), None]),
        ];
        for (firmware, last) in last {
            let want = FIRST.map(Some).into_iter().chain(last);
            for (digit, want) in want.enumerate() {
                let got = rate(nominal(&digit.to_string(), firmware), firmware);
                assert_eq!(got, want, "{firmware:?} S{digit}");
            }
        }
    }

    #[test]
    fn registers_of_the_can232_manual_give_their_rates() {
        for (digits, want) in
            [("031C", 125_000), ("001C", 500_000), ("0014", 1_000_000), ("311C", 10_000)]
        {
            assert_eq!(rate(registers(digits, Firmware::Lawicel), Firmware::Lawicel), Some(want));
        }
        for digits in ["12", "ZZZZ", "031C00"] {
            assert_eq!(registers(digits, Firmware::Lawicel), None, "{digits}");
        }
    }

    #[test]
    fn registers_of_a_mcp2515_count_from_24_mhz() {
        // 24 MHz / 2 / 12 / 12 quanta: 1 + 4 + 4 + 3; SJW 2.
        let timing = registers("4B9B02", Firmware::Usbtin).unwrap();
        assert_eq!(rate(Some(timing), Firmware::Usbtin), Some(83_333));
        assert_eq!((timing.quanta(), timing.sample_quanta(), timing.sjw()), (12, 9, 2));
        // Without BTLMODE the second phase segment is as long as the first.
        assert_eq!(registers("051B00", Firmware::Usbtin).unwrap().quanta(), 1 + 4 + 4 + 4);
        assert_eq!(registers("051B", Firmware::Usbtin), None);
    }

    #[test]
    fn fields_of_a_fdcan_are_what_the_document_says() {
        // Its examples: 125 kbit/s at 88.75 %, 2 Mbit/s at 77.5 %.
        let timing = registers("10460908", Firmware::Canable2).unwrap();
        assert_eq!(rate(Some(timing), Firmware::Canable2), Some(125_000));
        assert_eq!((timing.sample_quanta(), timing.quanta(), timing.sjw()), (71, 80, 8));
        let timing = data_registers("021E0908", Firmware::Canable2).unwrap();
        assert_eq!(rate(Some(timing), Firmware::Canable2), Some(2_000_000));
        assert_eq!((timing.sample_quanta(), timing.quanta()), (31, 40));
        for digits in ["00460908", "10468108", "1046090", "10460981"] {
            assert_eq!(registers(digits, Firmware::Canable2), None, "{digits}");
        }
        assert_eq!(data_registers("211E0908", Firmware::Canable2), None);
    }

    #[test]
    fn data_rates_of_both_canable2() {
        let rates = |firmware| {
            (0..=9).filter_map(|n| rate(data(&n.to_string(), firmware), firmware)).collect()
        };
        let mut want = vec![500_000, 1_000_000, 2_000_000, 4_000_000, 5_000_000, 8_000_000];
        let got: Vec<_> = rates(Firmware::Canable2);
        assert_eq!(got, want);
        want.pop();
        want.remove(0);
        let got: Vec<_> = rates(Firmware::Canable2Stock);
        assert_eq!(got, want);
        for firmware in [Firmware::Lawicel, Firmware::Canable1, Firmware::Usbtin] {
            let got: Vec<_> = rates(firmware);
            assert_eq!(got, []);
        }
    }
}
