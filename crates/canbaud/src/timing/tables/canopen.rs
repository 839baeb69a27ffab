//! Tables of Koppe, "Automatic Baudrate Detection in CANopen Networks" (iCC 2003), row K1.

use crate::timing::Ratio;

/// A CANopen bit rate with its bit layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CanopenRow {
    /// Bit rate in bit/s.
    pub bits_per_second: u32,
    /// Time quanta in a bit.
    pub quanta: u16,
    /// Sample point in thousandths.
    pub sample_point_permille: u16,
}

const fn row(bits_per_second: u32, quanta: u16, sample_point_permille: u16) -> CanopenRow {
    CanopenRow { bits_per_second, quanta, sample_point_permille }
}

/// Table 1, "CANopen bitrates". Consistent: 1 + 5 + 2, 1 + 7 + 2 and 1 + 13 + 2 quanta.
pub const CANOPEN: [CanopenRow; 8] = [
    row(1_000_000, 8, 750),
    row(800_000, 10, 800),
    row(500_000, 16, 875),
    row(250_000, 16, 875),
    row(125_000, 16, 875),
    row(50_000, 16, 875),
    row(20_000, 16, 875),
    row(10_000, 16, 875),
];

/// Ticks that a timer counts in one dominant bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimerTicksRow {
    /// Timer clock in MHz.
    pub timer_mhz: u32,
    /// Bit rate in kbit/s.
    pub kbits_per_second: u32,
    /// Count as printed.
    pub printed: u32,
}

impl TimerTicksRow {
    /// The exact count.
    #[must_use]
    pub const fn ticks(&self) -> Ratio {
        Ratio::over(self.timer_mhz as u64 * 1_000, self.kbits_per_second as u64)
    }

    /// Whether the printed count is not the exact one.
    #[must_use]
    pub const fn is_misprint(&self) -> bool {
        self.printed * self.kbits_per_second != self.timer_mhz * 1_000
    }
}

const fn ticks(timer_mhz: u32, kbits_per_second: u32, printed: u32) -> TimerTicksRow {
    TimerTicksRow { timer_mhz, kbits_per_second, printed }
}

/// Table 2, "Timer ticks for measuring a single dominant bit". 10 MHz and 800 kbit/s are 12.5
/// ticks, not 12.
pub const CANOPEN_TIMER_TICKS: [TimerTicksRow; 6] = [
    ticks(10, 500, 20),
    ticks(10, 800, 12),
    ticks(10, 1_000, 10),
    ticks(24, 500, 48),
    ticks(24, 800, 30),
    ticks(24, 1_000, 24),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::{Request, controllers::sja1000, default_sample_point, solve};
    use crate::units::{Bitrate, Hertz};

    #[test]
    fn an_sja1000_at_16_mhz_gets_every_row_exactly() {
        for row in &CANOPEN {
            let bitrate = Bitrate::new(row.bits_per_second).unwrap();
            assert_eq!(default_sample_point(bitrate).permille(), row.sample_point_permille);
            let request = Request::new(Hertz::new(16_000_000).unwrap(), bitrate);
            let solution = solve(&request, &sja1000::NOMINAL).unwrap();
            assert_eq!(solution.bitrate_error_ppb(), 0);
            assert_eq!(solution.timing.quanta(), u32::from(row.quanta), "{row:?}");
            let point = solution.timing.sample_point().permille();
            assert_eq!(point, u64::from(row.sample_point_permille));
        }
    }

    #[test]
    fn only_the_800_kbit_row_at_10_mhz_is_misprinted() {
        let wrong: std::vec::Vec<_> =
            CANOPEN_TIMER_TICKS.iter().filter(|row| row.is_misprint()).collect();
        assert_eq!(wrong.len(), 1);
        assert_eq!(wrong[0].ticks(), Ratio::new(25, 2).unwrap());
    }
}
