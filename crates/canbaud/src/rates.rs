//! Bit rates that somebody uses, with who does.
//!
//! The table names a measured rate; it never decides one. Rates that are no whole number of bit/s
//! are kept as the ratio that the hardware makes them by.

use crate::units::Bitrate;

/// A bit rate in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnownRate {
    millibits_per_second: u64,
    bitrate: Bitrate,
    users: &'static str,
}

impl KnownRate {
    const fn new(numerator: u32, denominator: u32, users: &'static str) -> Self {
        let millibits = numerator as u64 * 1000;
        let rounded = (numerator + denominator / 2) / denominator;
        // Evaluated while compiling: an impossible entry does not build.
        let Some(bitrate) = Bitrate::new(rounded) else { panic!("rate below 1 bit/s") };
        Self {
            millibits_per_second: (millibits + denominator as u64 / 2) / denominator as u64,
            bitrate,
            users,
        }
    }

    /// The rate in thousandths of a bit/s, rounded.
    #[must_use]
    pub const fn millibits_per_second(&self) -> u64 {
        self.millibits_per_second
    }

    /// The rate in whole bit/s, rounded.
    ///
    /// ```
    /// use canbaud::rates::nominal;
    /// let rate = nominal().iter().find(|rate| rate.users().contains("J2411")).unwrap();
    /// assert_eq!(rate.bitrate().to_string(), "33.333k");
    /// ```
    #[must_use]
    pub const fn bitrate(&self) -> Bitrate {
        self.bitrate
    }

    /// Who uses it: standards first, then vehicles and devices.
    #[must_use]
    pub const fn users(&self) -> &'static str {
        self.users
    }
}

/// Nominal bit rates, ascending.
const NOMINAL: &[KnownRate] = &[
    KnownRate::new(5_000, 1, "the lowest rate of common transceivers"),
    KnownRate::new(10_000, 1, "CANopen (CiA 301)"),
    KnownRate::new(50_000, 3, "body electronics at 16.667k"),
    KnownRate::new(20_000, 1, "CANopen (CiA 301)"),
    KnownRate::new(25_000, 1, "industrial, older devices"),
    KnownRate::new(31_250, 1, "industrial, older devices"),
    KnownRate::new(100_000, 3, "single-wire CAN (SAE J2411), GM body"),
    KnownRate::new(40_000, 1, "industrial, older devices"),
    KnownRate::new(1_000_000, 21, "vehicle interior at 47.619k"),
    KnownRate::new(50_000, 1, "CANopen (CiA 301)"),
    KnownRate::new(62_500, 1, "industrial, vehicle body"),
    KnownRate::new(80_000, 1, "industrial, older devices"),
    KnownRate::new(
        250_000,
        3,
        "vehicle interior, single-wire CAN high speed (SAE J2411), ARINC 825",
    ),
    KnownRate::new(2_000_000, 21, "vehicle interior at 95.238k"),
    KnownRate::new(100_000, 1, "CANopen (older tables), vehicle comfort bus"),
    KnownRate::new(125_000, 1, "CANopen (CiA 301), DeviceNet, ISO 11992, ARINC 825"),
    KnownRate::new(200_000, 1, "industrial, vehicle body"),
    KnownRate::new(250_000, 1, "SAE J1939, NMEA 2000, ISO 11783, CANopen (CiA 301), DeviceNet"),
    KnownRate::new(400_000, 1, "industrial"),
    KnownRate::new(500_000, 1, "ISO 15765-4 (OBD), SAE J1939-14, CANopen (CiA 301), DeviceNet"),
    KnownRate::new(8_000_000, 13, "vehicle interior at 615.385k"),
    KnownRate::new(625_000, 1, "industrial"),
    KnownRate::new(2_000_000, 3, "SAE J1939 tools at 666.667k"),
    KnownRate::new(800_000, 1, "CANopen (CiA 301)"),
    KnownRate::new(2_500_000, 3, "industrial at 833.333k"),
    KnownRate::new(1_000_000, 1, "CANopen (CiA 301), Cyphal and DroneCAN, ARINC 825"),
];

/// Data bit rates of CAN FD, ascending.
const DATA: &[KnownRate] = &[
    KnownRate::new(500_000, 1, "CAN FD"),
    KnownRate::new(1_000_000, 1, "CAN FD"),
    KnownRate::new(1_500_000, 1, "CAN FD"),
    KnownRate::new(2_000_000, 1, "CAN FD (SAE J1939-17, CiA 601)"),
    KnownRate::new(2_500_000, 1, "CAN FD"),
    KnownRate::new(8_000_000, 3, "CAN FD"),
    KnownRate::new(3_000_000, 1, "CAN FD"),
    KnownRate::new(10_000_000, 3, "CAN FD"),
    KnownRate::new(4_000_000, 1, "CAN FD"),
    KnownRate::new(5_000_000, 1, "CAN FD (CiA 601)"),
    KnownRate::new(6_000_000, 1, "CAN FD"),
    KnownRate::new(20_000_000, 3, "CAN FD"),
    KnownRate::new(8_000_000, 1, "CAN FD (CiA 601)"),
];

/// Nominal bit rates in use, ascending.
#[must_use]
pub const fn nominal() -> &'static [KnownRate] {
    NOMINAL
}

/// Data bit rates of CAN FD in use, ascending.
#[must_use]
pub const fn data() -> &'static [KnownRate] {
    DATA
}

/// Crystals and ceramic resonators of nodes that can talk to each other: 0.6 %.
const CLOCK_PPB: u64 = 6_000_000;

/// The entry of `table` that a measured rate stands for: the only one that lies within the error
/// of a node's clock and three standard deviations of the measurement.
///
/// ```
/// use canbaud::rates::{nearest, nominal};
/// let known = nearest(nominal(), 615_379_760, 5_000).unwrap();
/// assert_eq!(known.bitrate().bits_per_second(), 615_385);
/// // 470 kbit/s is nobody's rate.
/// assert!(nearest(nominal(), 470_004_940, 5_000).is_none());
/// // 0.8 % from 615.385k and from 625k: not for a table to decide.
/// assert!(nearest(nominal(), 620_200_000, 2_000_000).is_none());
/// ```
#[must_use]
pub fn nearest(
    table: &'static [KnownRate],
    millibits_per_second: u64,
    uncertainty_ppb: u32,
) -> Option<&'static KnownRate> {
    let reach = CLOCK_PPB + 3 * u64::from(uncertainty_ppb);
    let mut within = table.iter().filter(|rate| {
        let known = u128::from(rate.millibits_per_second());
        let apart = known.abs_diff(u128::from(millibits_per_second));
        apart * 1_000_000_000 <= known * u128::from(reach)
    });
    match (within.next(), within.next()) {
        (Some(only), None) => Some(only),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_ascend_and_their_rates_can_be_told_apart() {
        for table in [nominal(), data()] {
            for pair in table.windows(2) {
                let [low, high] = pair else { panic!("a window of two") };
                let (low, high) = (low.millibits_per_second(), high.millibits_per_second());
                assert!(low > 0 && high * 1000 > low * 1012, "{low} and {high}");
            }
        }
    }
}
