//! Bit timing table 0 [CiA 301, CiA 305; index 9: Koppe].

use core::fmt;

use crate::units::{Bitrate, Permille};

/// What a device is set to by an index of bit timing table 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RateSetting {
    /// One bit rate.
    Fixed(Bitrate),
    /// Index 9: the device finds the bit rate by listening.
    Automatic,
}

/// A row of bit timing table 0.
///
/// Index 5 is reserved: some devices and tools take it for 100 kbit/s. It may be seen on a bus and
/// is shown as what it is; a master sends it only when told to by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableRow {
    /// The index on the wire.
    pub index: u8,
    /// What it stands for; `None` is reserved.
    pub setting: Option<RateSetting>,
    /// TQ in a bit [Koppe, table 1]; 0 where there is no bit rate.
    pub quanta: u16,
    /// Where to sample [Koppe, table 1]; 0 where there is no bit rate.
    pub sample_point: Permille,
}

const fn fixed(index: u8, bits_per_second: u32, quanta: u16, permille: u16) -> TableRow {
    // Evaluated while compiling: an impossible row does not build.
    let (Some(rate), Some(sample_point)) = (Bitrate::new(bits_per_second), Permille::new(permille))
    else {
        panic!("no such row")
    };
    TableRow { index, setting: Some(RateSetting::Fixed(rate)), quanta, sample_point }
}

const fn other(index: u8, setting: Option<RateSetting>) -> TableRow {
    TableRow { index, setting, quanta: 0, sample_point: Permille::ZERO }
}

/// Bit timing table 0, in the order of its indices.
///
/// ```
/// use canbaud::lss::{RateSetting, TABLE};
/// for row in &TABLE {
///     if let Some(RateSetting::Fixed(rate)) = row.setting {
///         println!("{}: {rate}bit/s, sample point {}", row.index, row.sample_point);
///     }
/// }
/// assert_eq!(TABLE[5].setting, None);
/// assert_eq!(TABLE[9].setting, Some(RateSetting::Automatic));
/// ```
pub const TABLE: [TableRow; 10] = [
    fixed(0, 1_000_000, 8, 750),
    fixed(1, 800_000, 10, 800),
    fixed(2, 500_000, 16, 875),
    fixed(3, 250_000, 16, 875),
    fixed(4, 125_000, 16, 875),
    other(5, None),
    fixed(6, 50_000, 16, 875),
    fixed(7, 20_000, 16, 875),
    fixed(8, 10_000, 16, 875),
    other(9, Some(RateSetting::Automatic)),
];

impl RateSetting {
    /// What `index` of table 0 stands for; `None` for 5 (reserved) and above 9.
    ///
    /// ```
    /// use canbaud::lss::RateSetting;
    /// assert_eq!(RateSetting::from_index(3).unwrap().to_string(), "250k");
    /// assert_eq!(RateSetting::from_index(9), Some(RateSetting::Automatic));
    /// assert_eq!(RateSetting::from_index(5), None);
    /// ```
    #[must_use]
    pub fn from_index(index: u8) -> Option<Self> {
        TABLE.get(usize::from(index)).and_then(|row| row.setting)
    }

    /// Its index in table 0; `None` for a bit rate that is not in the table.
    #[must_use]
    pub fn index(self) -> Option<u8> {
        TABLE.iter().find(|row| row.setting == Some(self)).map(|row| row.index)
    }

    /// The bit rate, where it is a fixed one.
    #[must_use]
    pub const fn bitrate(self) -> Option<Bitrate> {
        match self {
            Self::Fixed(rate) => Some(rate),
            Self::Automatic => None,
        }
    }
}

impl fmt::Display for RateSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(rate) => rate.fmt(f),
            Self::Automatic => f.pad("automatic"),
        }
    }
}

/// Bit rates of table 0 that a device can be set to.
///
/// ```
/// use canbaud::lss::RateSet;
/// use canbaud::units::Bitrate;
/// let [slow, fast] = [125_000, 500_000].map(|rate| Bitrate::new(rate).unwrap());
/// let rates = RateSet::NONE.with(fast);
/// assert!(rates.has(fast) && !rates.has(slow) && RateSet::ALL.has(slow));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct RateSet(u16);

impl RateSet {
    /// No bit rate at all: the device's is fixed.
    pub const NONE: Self = Self(0);
    /// The eight of the table.
    pub const ALL: Self = Self(0b1_1101_1111);

    fn bit(rate: Bitrate) -> u16 {
        RateSetting::Fixed(rate).index().map_or(0, |index| 1 << index)
    }

    /// The same and `rate`; a rate that is not in the table changes nothing.
    #[must_use]
    pub fn with(self, rate: Bitrate) -> Self {
        Self(self.0 | Self::bit(rate))
    }

    /// Whether `rate` is one of them.
    #[must_use]
    pub fn has(self, rate: Bitrate) -> bool {
        self.0 & Self::bit(rate) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::tables::CANOPEN;

    #[test]
    fn rows_have_their_index_and_the_bit_layout_of_koppe() {
        for (place, row) in TABLE.iter().enumerate() {
            assert_eq!(usize::from(row.index), place);
            let Some(RateSetting::Fixed(rate)) = row.setting else { continue };
            let printed =
                CANOPEN.iter().find(|k| k.bits_per_second == rate.bits_per_second()).unwrap();
            assert_eq!(row.quanta, printed.quanta);
            assert_eq!(row.sample_point.permille(), printed.sample_point_permille);
        }
        assert_eq!(TABLE.iter().filter(|row| row.quanta > 0).count(), CANOPEN.len());
    }

    #[test]
    fn the_whole_set_is_the_table_without_5_and_9() {
        for index in 0..=u8::MAX {
            let fixed = RateSetting::from_index(index).and_then(RateSetting::bitrate);
            let listed = index < 16 && RateSet::ALL.0 >> index & 1 == 1;
            assert_eq!(fixed.is_some(), listed, "index {index}");
            assert_eq!(fixed.is_some_and(|rate| RateSet::ALL.has(rate)), listed);
        }
    }
}
