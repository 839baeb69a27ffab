//! The "Additional Bit Timing Examples" of the DS80C390 supplement, page 155, row D3.

use crate::timing::BitTiming;

/// One line of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ds80c390Row {
    /// Oscillator in MHz.
    pub oscillator_mhz: u16,
    /// Bit rate in kbit/s.
    pub kbits_per_second: u16,
    /// CAN clock divide.
    pub ccd: u16,
    /// Prescaler BRPV as printed.
    pub printed_brpv: u16,
    /// Time quantum in ns as printed.
    pub printed_quantum_ns: u16,
    /// TS1_LEN.
    pub tseg1: u16,
    /// TS2_LEN.
    pub tseg2: u16,
    /// SJW as printed.
    pub printed_sjw: u16,
}

/// Where a printed value is wrong, and what is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ds80c390Misprint {
    /// BRPV and CCD do not give the bit rate.
    Prescaler {
        /// The right BRPV.
        right: u16,
    },
    /// SJW is larger than TS2_LEN.
    Sjw {
        /// The highest SJW allowed.
        max: u16,
    },
}

impl Ds80c390Row {
    /// The right prescaler: F_OSC / (bit rate * CCD * quanta).
    #[must_use]
    pub const fn brpv(&self) -> u16 {
        let quanta = 1 + self.tseg1 as u64 + self.tseg2 as u64;
        let kilohertz = self.oscillator_mhz as u64 * 1_000;
        // A row without a bit rate has no prescaler.
        match kilohertz.checked_div(self.kbits_per_second as u64 * self.ccd as u64 * quanta) {
            Some(prescaler) => prescaler as u16,
            None => 0,
        }
    }

    /// The bit timing with the misprints put right.
    #[must_use]
    pub const fn timing(&self) -> BitTiming {
        let phase = if self.tseg2 < self.tseg1 { self.tseg2 } else { self.tseg1 - 1 };
        let sjw = if self.printed_sjw < self.tseg2 { self.printed_sjw } else { self.tseg2 };
        BitTiming {
            prescaler: self.brpv(),
            prop_seg: self.tseg1 - phase,
            phase_seg1: phase,
            phase_seg2: self.tseg2,
            sjw,
        }
    }

    /// Whether triple sampling is allowed: only with BRPV above 3.
    #[must_use]
    pub const fn allows_triple_sampling(&self) -> bool {
        self.brpv() > 3
    }

    /// What is wrong in this line.
    #[must_use]
    pub const fn misprint(&self) -> Option<Ds80c390Misprint> {
        if self.printed_brpv != self.brpv() {
            return Some(Ds80c390Misprint::Prescaler { right: self.brpv() });
        }
        if self.printed_sjw > self.tseg2 {
            return Some(Ds80c390Misprint::Sjw { max: self.tseg2 });
        }
        None
    }
}

const fn row(
    (oscillator_mhz, kbits_per_second): (u16, u16),
    (printed_brpv, ccd, printed_quantum_ns): (u16, u16, u16),
    (tseg1, tseg2, printed_sjw): (u16, u16, u16),
) -> Ds80c390Row {
    Ds80c390Row {
        oscillator_mhz,
        kbits_per_second,
        ccd,
        printed_brpv,
        printed_quantum_ns,
        tseg1,
        tseg2,
        printed_sjw,
    }
}

/// The 12 lines: oscillator and kbit/s; BRPV, CCD and quantum in ns as printed; TS1_LEN,
/// TS2_LEN and SJW as printed.
///
/// ```
/// use canbaud::timing::tables::{Ds80c390Misprint, DS80C390};
/// // 8 MHz, 250 kbit/s: printed with a prescaler of 1, which would be 500 kbit/s.
/// assert_eq!(DS80C390[10].misprint(), Some(Ds80c390Misprint::Prescaler { right: 2 }));
/// ```
pub const DS80C390: [Ds80c390Row; 12] = [
    row((40, 1_000), (2, 2, 100), (5, 4, 3)),
    row((40, 500), (4, 2, 200), (5, 4, 3)),
    row((40, 250), (5, 2, 250), (10, 5, 4)),
    row((40, 125), (10, 2, 500), (10, 5, 4)),
    row((16, 1_000), (1, 2, 125), (4, 3, 4)),
    row((16, 500), (1, 2, 125), (10, 5, 4)),
    row((16, 250), (2, 2, 250), (10, 5, 4)),
    row((16, 125), (4, 2, 500), (10, 5, 4)),
    row((8, 1_000), (1, 1, 125), (4, 3, 2)),
    row((8, 500), (1, 1, 125), (10, 5, 4)),
    row((8, 250), (1, 1, 250), (10, 5, 4)),
    row((8, 125), (2, 2, 500), (10, 5, 4)),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::controllers::ds80c390;

    #[test]
    fn every_row_put_right_gives_its_bit_rate_and_quantum() {
        for row in &DS80C390 {
            let timing = row.timing();
            let clocks = timing.clocks_per_bit(row.ccd);
            let oscillator = u64::from(row.oscillator_mhz) * 1_000;
            assert_eq!(oscillator, clocks * u64::from(row.kbits_per_second), "{row:?}");
            let quantum = u32::from(timing.prescaler) * u32::from(row.ccd) * 1_000;
            let printed = u32::from(row.printed_quantum_ns) * u32::from(row.oscillator_mhz);
            assert_eq!(quantum, printed, "{row:?}");
            let limits = ds80c390::NOMINAL.with_clock_divider(row.ccd);
            assert_eq!(limits.check(&timing), Ok(()));
        }
    }

    #[test]
    fn two_of_twelve_rows_are_misprinted() {
        let wrong: std::vec::Vec<_> = DS80C390
            .iter()
            .filter_map(|r| Some((r.oscillator_mhz, r.kbits_per_second, r.misprint()?)))
            .collect();
        assert_eq!(
            wrong,
            [
                (16, 1_000, Ds80c390Misprint::Sjw { max: 3 }),
                (8, 250, Ds80c390Misprint::Prescaler { right: 2 }),
            ]
        );
    }

    #[test]
    fn triple_sampling_is_allowed_where_the_table_says_so() {
        let allowed = DS80C390.map(|row| row.allows_triple_sampling());
        let (y, n) = (true, false);
        assert_eq!(allowed, [n, y, y, y, n, n, n, y, n, n, n, n]);
    }
}
