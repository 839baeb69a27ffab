//! The calculation tables of Infineon AP2925 (1999), with every misprint beside the right value.
//!
//! Row A4. The document measures the shortest dominant level with a timer at f_CPU and looks the
//! count up. A register is right exactly when `2 * (BRP + 1) * (1 + TSEG1 + TSEG2)` with real
//! segment values equals f_CPU / bit rate \[AP2925 1.2.3\].

use crate::timing::BitTiming;
use crate::timing::Ratio;
use crate::timing::controllers::{Configuration, c167};

/// One line of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ap2925Row {
    /// f_CPU in MHz; the timer runs at f_CPU.
    pub cpu_mhz: u16,
    /// Bit rate in kbit/s.
    pub kbits_per_second: u16,
    /// The bit timing that the segment columns say, with SJW 1.
    pub timing: BitTiming,
    /// Register value as printed in the table.
    pub printed_btr: u16,
    /// Sample point as printed, in thousandths.
    pub printed_sample_point: u16,
    /// Lowest, expected and highest count as printed.
    pub printed_ticks: [u16; 3],
    /// Register value in the C program of the document.
    pub code_btr: u16,
}

/// Where a printed value is wrong, and what is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misprint {
    /// The register does not hold the printed segments.
    Register {
        /// The right value.
        right: u16,
    },
    /// The sample point is not that of the printed segments.
    SamplePoint {
        /// The right value.
        right: Ratio,
    },
    /// The counts are not those of this bit rate.
    Ticks {
        /// The right counts: lowest and highest as the C program has them.
        right: [u16; 3],
    },
}

impl Ap2925Row {
    /// Timer ticks in a bit: f_CPU / bit rate.
    #[must_use]
    pub const fn ticks(&self) -> u32 {
        self.cpu_mhz as u32 * 1_000 / self.kbits_per_second as u32
    }

    /// The right register value for the printed segments.
    #[must_use]
    pub const fn btr(&self) -> u16 {
        match c167::BTR.pack(&Configuration::classic(self.timing)) {
            Ok(word) => word as u16,
            // Every row holds segments that fit; a test packs each.
            Err(_) => 0,
        }
    }

    /// The right counts: lowest, expected, highest.
    #[must_use]
    pub const fn right_ticks(&self) -> [u16; 3] {
        if self.printed_ticks[1] as u32 == self.ticks() {
            return self.printed_ticks;
        }
        // 8 MHz, 125 kbit/s, a copy of the 16 MHz row; the C program has 56 to 69.
        [56, self.ticks() as u16, 69]
    }

    /// What is wrong in this line of the document.
    pub fn misprints(&self) -> impl Iterator<Item = Misprint> {
        let right = self.btr();
        let register = (right != self.printed_btr).then_some(Misprint::Register { right });
        let right = self.timing.sample_point();
        // 81,2 is 81.25 cut off.
        let cut_off = right.numerator() * 1_000 / right.denominator();
        let sample_point = (cut_off != u64::from(self.printed_sample_point))
            .then_some(Misprint::SamplePoint { right });
        let right = self.right_ticks();
        let ticks = (right != self.printed_ticks).then_some(Misprint::Ticks { right });
        [register, sample_point, ticks].into_iter().flatten()
    }
}

const fn row(
    (cpu_mhz, kbits_per_second): (u16, u16),
    (prescaler, tseg1, tseg2): (u16, u16, u16),
    (printed_btr, printed_sample_point, printed_ticks): (u16, u16, [u16; 3]),
    code_btr: u16,
) -> Ap2925Row {
    let (prop_seg, phase_seg1) = c167::NOMINAL.split(tseg1 as u32, tseg2 as u32);
    let timing = BitTiming { prescaler, prop_seg, phase_seg1, phase_seg2: tseg2, sjw: 1 };
    Ap2925Row {
        cpu_mhz,
        kbits_per_second,
        timing,
        printed_btr,
        printed_sample_point,
        printed_ticks,
        code_btr,
    }
}

/// The 26 lines in the order of the document: f_CPU and kbit/s; BRP + 1, TSEG1 + 1 and
/// TSEG2 + 1; register, sample point and counts as printed; register in the C program.
///
/// ```
/// use canbaud::timing::tables::{Misprint, AP2925};
/// // 24 MHz, 50 kbit/s: a prescaler of 20 written as hex 14, without the minus one.
/// let row = AP2925[4];
/// assert_eq!((row.printed_btr, row.btr(), row.ticks()), (0x1814, 0x1813, 480));
/// assert_eq!(row.misprints().next(), Some(Misprint::Register { right: 0x1813 }));
/// ```
#[rustfmt::skip]
pub const AP2925: [Ap2925Row; 26] = [
    row((24, 1000), (1, 9, 2), (0x1800, 800, [20, 24, 27]), 0x2700),
    row((24, 500), (2, 9, 2), (0x1801, 800, [40, 48, 55]), 0x6F00),
    row((24, 250), (4, 9, 2), (0x1803, 800, [86, 96, 107]), 0x6F01),
    row((24, 125), (8, 9, 2), (0x1807, 800, [180, 192, 201]), 0x6F03),
    row((24, 50), (20, 9, 2), (0x1814, 800, [470, 480, 489]), 0x6F09),
    row((16, 1000), (1, 5, 2), (0x1400, 750, [10, 16, 19]), 0x1400),
    row((16, 500), (1, 12, 3), (0x2B00, 812, [28, 32, 39]), 0x3A00),
    row((16, 250), (2, 12, 3), (0x2B01, 812, [56, 64, 69]), 0x3A01),
    row((16, 125), (4, 12, 3), (0x2B03, 812, [120, 128, 139]), 0x3A03),
    row((16, 50), (10, 12, 3), (0x2B09, 812, [310, 320, 329]), 0x3A09),
    row((8, 500), (1, 5, 2), (0x1400, 750, [10, 16, 19]), 0x1400),
    row((8, 250), (1, 12, 3), (0x2B00, 812, [28, 32, 39]), 0x3A00),
    row((8, 125), (2, 12, 3), (0x2B01, 812, [120, 128, 139]), 0x3A01),
    row((8, 50), (5, 12, 3), (0x2B04, 812, [150, 160, 169]), 0x3A04),
    row((20, 1000), (1, 7, 2), (0x1600, 800, [14, 20, 27]), 0x1600),
    row((20, 500), (1, 15, 4), (0x3E00, 800, [34, 40, 47]), 0x3E00),
    row((20, 250), (2, 15, 4), (0x3E01, 800, [74, 80, 87]), 0x3E01),
    row((20, 125), (4, 15, 4), (0x3E03, 800, [154, 160, 167]), 0x3E03),
    row((20, 50), (10, 15, 4), (0x3E09, 800, [390, 400, 409]), 0x3E09),
    row((10, 500), (1, 7, 2), (0x1600, 800, [14, 20, 27]), 0x1600),
    row((10, 250), (1, 15, 4), (0x3E00, 800, [34, 40, 47]), 0x3E00),
    row((10, 125), (2, 15, 4), (0x3E01, 800, [74, 80, 87]), 0x3E01),
    row((10, 50), (5, 15, 4), (0x3E04, 800, [190, 200, 209]), 0x3E04),
    row((5, 250), (1, 7, 2), (0x1600, 800, [14, 20, 27]), 0x1600),
    row((5, 125), (1, 15, 4), (0x3E00, 800, [34, 40, 47]), 0x3E00),
    row((5, 50), (5, 7, 2), (0x1604, 800, [90, 100, 109]), 0x1604),
];

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;
    use crate::timing::{Request, SamplePointPolicy, SjwPolicy, solve};
    use crate::units::{Bitrate, Hertz, Permille};

    fn request(row: &Ap2925Row) -> Request {
        let clock = Hertz::new(u64::from(row.cpu_mhz) * 1_000_000).unwrap();
        let bitrate = Bitrate::new(u32::from(row.kbits_per_second) * 1_000).unwrap();
        Request::new(clock, bitrate)
            .with_sample_point(Permille::new(800).unwrap(), SamplePointPolicy::Nearest)
            .with_sjw(SjwPolicy::Exactly(1))
    }

    /// A5: m = 2 (BRP + 1) (1 + TSEG1 + TSEG2) for every line and for every register of the code.
    #[test]
    fn every_segment_column_and_every_code_register_gives_the_bit_rate() {
        for row in &AP2925 {
            assert_eq!(row.timing.clocks_per_bit(2), u64::from(row.ticks()), "{row:?}");
            let code = c167::CONTROLLER.unpack([(&c167::BTR, u32::from(row.code_btr))]).unwrap();
            assert_eq!(code.nominal.clocks_per_bit(2), u64::from(row.ticks()), "{row:?}");
        }
    }

    #[test]
    fn misprints_are_those_found_by_hand() {
        let mut found = Vec::new();
        for row in &AP2925 {
            found.extend(row.misprints().map(|m| (row.cpu_mhz, row.kbits_per_second, m)));
        }
        let right = Ratio::new(10, 12).unwrap();
        let point = |kbits| (24, kbits, Misprint::SamplePoint { right });
        assert_eq!(
            found,
            [
                point(1000),
                point(500),
                point(250),
                point(125),
                (24, 50, Misprint::Register { right: 0x1813 }),
                point(50),
                (8, 125, Misprint::Ticks { right: [56, 64, 69] }),
            ]
        );
    }

    #[test]
    fn right_windows_do_not_overlap_for_one_clock() {
        for row in &AP2925 {
            for other in AP2925.iter().filter(|o| o.cpu_mhz == row.cpu_mhz && *o != row) {
                let ([low, _, high], [other_low, _, other_high]) =
                    (row.right_ticks(), other.right_ticks());
                assert!(high < other_low || other_high < low, "{row:?} {other:?}");
            }
        }
    }

    /// The registers nearest 80 %, worked out independently of the solver.
    #[test]
    fn solver_finds_the_registers_nearest_80_percent() {
        #[rustfmt::skip]
        let nearest = [
            0x1800, 0x1801, 0x2B02, 0x2B05, 0x3E0B,
            0x1400, 0x2B00, 0x2B01, 0x2B03, 0x3E07, 0x1400, 0x2B00, 0x2B01, 0x3E03,
            0x1600, 0x3E00, 0x3E01, 0x3E03, 0x3E09, 0x1600, 0x3E00, 0x3E01, 0x3E04,
            0x1600, 0x3E00, 0x1604,
        ];
        for (row, nearest) in AP2925.iter().zip(nearest) {
            let timing = solve(&request(row), &c167::NOMINAL).unwrap().timing;
            let word = c167::BTR.pack(&Configuration::classic(timing)).unwrap();
            assert_eq!(word, nearest, "{row:?}: {word:#06X}");
        }
    }
}
