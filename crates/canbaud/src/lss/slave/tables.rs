//! Bit timing tables of the manufacturer [CiA 305]: selectors 128 to 255.

use crate::lss::RateSetting;

/// The bit timing tables of a device beside table 0.
///
/// A device that has none uses [`NoTables`], which takes no memory and no code.
pub trait Tables {
    /// What an index of the table with this selector, 128 to 255, stands for; `None` (error 1) if
    /// the device has no such table or no such index. A rate in it has to be one that the device can
    /// be set to: the slave passes it on as it is, and a [`Node`](crate::node::Node) refuses what is
    /// not among its [`rates`](crate::node::Settings::rates) when it is too late.
    fn setting(&self, table_selector: u8, table_index: u8) -> Option<RateSetting>;
}

/// Table 0 alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoTables;

impl Tables for NoTables {
    fn setting(&self, _: u8, _: u8) -> Option<RateSetting> {
        None
    }
}

/// An entry of a table of the manufacturer; a slice of them is a device's [`Tables`].
///
/// ```
/// use canbaud::lss::{RateSetting, TableEntry, Tables};
/// use canbaud::units::Bitrate;
/// let entry = |index, rate| TableEntry {
///     table_selector: 128,
///     table_index: index,
///     setting: RateSetting::Fixed(Bitrate::new(rate).unwrap()),
/// };
/// let tables = [entry(0, 83_333), entry(1, 33_333)];
/// let tables = tables.as_slice();
/// assert_eq!(tables.setting(128, 1).unwrap().to_string(), "33.333k");
/// assert_eq!(tables.setting(128, 2), None);
/// assert_eq!(tables.setting(129, 0), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableEntry {
    /// 128 to 255; an entry below is never asked for.
    pub table_selector: u8,
    /// Its place in that table.
    pub table_index: u8,
    /// What it stands for.
    pub setting: RateSetting,
}

impl Tables for &[TableEntry] {
    fn setting(&self, table_selector: u8, table_index: u8) -> Option<RateSetting> {
        let wanted = (table_selector, table_index);
        let entry = self.iter().find(|row| (row.table_selector, row.table_index) == wanted);
        entry.map(|row| row.setting)
    }
}
