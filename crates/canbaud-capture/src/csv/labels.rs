//! What the words above the numbers mean.

use super::cells::{Dialect, hex, iso_8601, level};
use super::header::{Content, Timing};
use crate::Format;
use crate::number::{self, Decimal};
use canbaud::units::Hertz;

/// The head of a file, cell by cell.
pub(super) struct Head<'a> {
    /// Rows above the numbers.
    pub(super) above: &'a [Vec<String>],
    /// Lines above that start with `;`.
    pub(super) comments: &'a [String],
    /// Rows of numbers.
    pub(super) head: &'a [Vec<Vec<u8>>],
    pub(super) width: usize,
    pub(super) dialect: Dialect,
}

/// Words that stand for a unit or a kind of value, not for a channel.
const UNITS: [&str; 20] = [
    "s",
    "ms",
    "us",
    "µs",
    "ns",
    "ps",
    "v",
    "mv",
    "uv",
    "volt",
    "volts",
    "second",
    "seconds",
    "sequence",
    "value",
    "ampl",
    "amplitude",
    "nanoseconds",
    "logic",
    "hex",
];

impl Head<'_> {
    fn is_sigrok(&self) -> bool {
        self.comments.iter().any(|c| c.contains("libsigrok") || c.starts_with("Channels ("))
    }

    pub(super) fn format(&self) -> Format {
        if self.is_sigrok() {
            return Format::SigrokCsv;
        }
        let is_saleae = |cell: &String| matches!(cell.as_str(), "Time [s]" | "Trigger [s]");
        if self.above.first().and_then(|row| row.first()).is_some_and(is_saleae) {
            Format::SaleaeCsv
        } else {
            Format::ScopeCsv
        }
    }

    /// The words above a column, the nearest first.
    fn above(&self, column: usize) -> impl Iterator<Item = &str> {
        // Rows that are shorter than the numbers tell about the file, not about a column.
        let is_label = |row: &&Vec<String>| {
            let first = row.first().map_or("", String::as_str);
            // `#1` and `Segment` head the list of segments of a LeCroy.
            row.len() + 1 >= self.width && !first.starts_with('#') && !first.starts_with("Segment")
        };
        let label_rows = self.above.iter().rev().take(4).filter(is_label);
        label_rows.filter_map(move |row| row.get(column)).map(String::as_str)
    }

    /// The value of a header key: `Sample Interval,2e-08`, `Sample Interval,Analog:5.0E-05`,
    /// `tInc = 4e-08s`, or `Increment` above its value.
    fn value(&self, keys: &[&str]) -> Option<Decimal> {
        let matches = |cell: &str, key: &str| {
            let cell = cell.trim().trim_start_matches(['"', '#']).to_ascii_lowercase();
            cell == key || cell.split(['(', '[']).next().is_some_and(|stem| stem.trim() == key)
        };
        for (number, row) in self.above.iter().enumerate() {
            for (column, cell) in row.iter().enumerate() {
                if let Some((name, value)) = cell.split_once('=')
                    && keys.iter().any(|key| matches(name, key))
                {
                    return quantity(value);
                }
                if keys.iter().any(|key| matches(cell, key)) {
                    let beside = row.get(column + 1).and_then(|c| quantity(c));
                    let below =
                        || self.above.get(number + 1)?.get(column).and_then(|c| quantity(c));
                    if let Some(value) = beside.or_else(below) {
                        return Some(value);
                    }
                }
            }
        }
        None
    }

    /// The sample period that the header states.
    pub(super) fn period(&self) -> Option<Decimal> {
        let keys = ["sample interval", "increment", "tinc", "sampling period", "horint", "dt"];
        self.value(&keys).filter(|period| period.mantissa > 0)
    }

    /// More than one stretch of samples one after the other (LeCroy).
    pub(super) fn has_segments(&self) -> bool {
        let count = self.value(&["segments"]).and_then(|n| n.scaled(0));
        count.is_some_and(|n| n > 1)
    }

    pub(super) fn samplerate(&self) -> Option<Hertz> {
        let comment = |c: &String| {
            c.get(..11)?.eq_ignore_ascii_case("samplerate:").then(|| number::hertz(c.get(11..)?))?
        };
        self.comments.iter().find_map(comment).or_else(|| {
            let rate = self.value(&["sample rate", "sampling rate", "samplerate"])?.scaled(0)?;
            Hertz::new(u64::try_from(rate).ok()?)
        })
    }

    /// What each column holds.
    pub(super) fn columns(&self) -> Vec<Content> {
        (0..self.width).map(|column| self.content(column)).collect()
    }

    fn content(&self, column: usize) -> Content {
        // What is neither is reported with its line when the rows are read.
        let is_value = |cell: &&Vec<u8>| {
            let known = level(cell).is_some() || hex(cell).is_some() || iso_8601(cell).is_some();
            known || self.dialect.volts(cell).is_some()
        };
        let cells = || self.head.iter().filter_map(move |row| row.get(column)).filter(is_value);
        if cells().next().is_none() || self.time_unit(column).is_some() || self.is_counter(column) {
            return Content::Ignored;
        }
        if let Some(bits) = self.hex_bits(column) {
            return Content::Hex(bits);
        }
        if cells().any(|cell| iso_8601(cell).is_some()) {
            return Content::Ignored;
        }
        let factor = self.above(column).find_map(volt_unit);
        if factor.is_none() && cells().all(|cell| level(cell).is_some()) {
            return Content::Digital;
        }
        Content::Volts(factor.unwrap_or(1.0))
    }

    fn hex_bits(&self, column: usize) -> Option<u32> {
        let mut cells = self.head.iter().filter_map(|row| row.get(column));
        let digits = cells.clone().map(|cell| cell.len().saturating_sub(2)).max()?;
        cells.all(|cell| hex(cell).is_some()).then_some(4 * digits.min(16) as u32)
    }

    /// The exponent of the unit in seconds if this is a column of times.
    fn time_unit(&self, column: usize) -> Option<i32> {
        let labelled = self.above(column).find_map(time_unit);
        if labelled.is_some() || self.above(column).next().is_some_and(|l| volt_unit(l).is_some()) {
            return labelled;
        }
        // Without a word: the first column with anything in it, if its numbers rise all the way.
        let first = self.head.first()?.iter().position(|cell| !cell.is_empty())?;
        if column != first || self.width < 2 || self.is_sigrok() || self.is_counter(column) {
            return None;
        }
        let values: Option<Vec<f64>> = self
            .head
            .iter()
            .map(|row| Some(self.dialect.decimal(row.get(column)?)?.to_f64()))
            .collect();
        let values = values?;
        let rises = values.iter().zip(values.iter().skip(1)).all(|(a, b)| a < b);
        (rises && values.len() >= 3).then_some(0)
    }

    /// `Sequence` or `X` counts samples where the increment is stated.
    fn is_counter(&self, column: usize) -> bool {
        let words = ["sequence", "x", "index", "sample", "no.", "point"];
        self.above(column).any(|label| words.contains(&label.trim().to_ascii_lowercase().as_str()))
    }

    pub(super) fn timing(&self, columns: &[Content]) -> Timing {
        if self.is_sigrok() {
            let data = columns.len();
            let channels = self.channel_list().map_or(data, |list| list.len());
            let timed = self.above(0).any(|label| label == "Time" || time_unit(label).is_some());
            return match self.samplerate() {
                Some(_) if timed || data == channels + 1 => Timing::Sigrok { column: 0 },
                _ => Timing::Unknown,
            };
        }
        // Of `Trigger [s],Time [s]` the last is the time of the row.
        let column = (0..columns.len()).rev().find(|&column| {
            columns.get(column) == Some(&Content::Ignored)
                && self.has_values(column)
                && (self.time_unit(column).is_some() || self.is_stamped(column))
        });
        match (column, self.period()) {
            (Some(column), _) => {
                Timing::Column { column, exponent: self.time_unit(column).unwrap_or(0) }
            }
            (None, Some(period)) => Timing::Period(period),
            (None, None) => Timing::Unknown,
        }
    }

    fn has_values(&self, column: usize) -> bool {
        self.head.iter().any(|row| row.get(column).is_some_and(|cell| !cell.is_empty()))
    }

    fn is_stamped(&self, column: usize) -> bool {
        self.head.iter().filter_map(|row| row.get(column)).any(|cell| iso_8601(cell).is_some())
    }

    /// The channel names in `; Channels (2/16): RX, TX`.
    fn channel_list(&self) -> Option<Vec<&str>> {
        let comment = self.comments.iter().find_map(|c| c.strip_prefix("Channels ("))?;
        Some(comment.split_once("):")?.1.split(',').map(str::trim).collect())
    }

    /// The name of a column.
    pub(super) fn name(&self, column: usize, columns: &[Content]) -> String {
        if let Some(list) = self.channel_list() {
            let before = columns.len().saturating_sub(list.len());
            if let Some(name) = column.checked_sub(before).and_then(|n| list.get(n)) {
                return (*name).to_owned();
            }
        }
        let named = self.above(column).find_map(channel_name);
        named.unwrap_or_else(|| {
            format!(
                "CH{}",
                1 + column
                    - columns.iter().take(column).filter(|c| **c == Content::Ignored).count()
            )
        })
    }
}

/// A number that may carry a prefix (`Analog:5.0E-05`) and a unit (`4e-08s`).
fn quantity(text: &str) -> Option<Decimal> {
    let text = text.rsplit(':').next()?.trim();
    let text = text.trim_end_matches(|c: char| c.is_ascii_alphabetic() || c == '/').trim_end();
    Decimal::parse(text.as_bytes())
}

/// `Time(s)`, `(us)`, `Second`, `TIME`, `x-axis`: the exponent of the unit in seconds.
fn time_unit(label: &str) -> Option<i32> {
    let label = label.trim().to_lowercase();
    let unit = |text: &str| match text.trim_matches(['(', ')', '[', ']', ' ']) {
        "s" | "sec" | "second" | "seconds" => Some(0),
        "ms" | "millisecond" | "milliseconds" => Some(-3),
        "us" | "µs" | "μs" | "microsecond" | "microseconds" => Some(-6),
        "ns" | "nanosecond" | "nanoseconds" => Some(-9),
        "ps" | "picosecond" | "picoseconds" => Some(-12),
        _ => None,
    };
    if let Some(exponent) = unit(&label) {
        return Some(exponent);
    }
    let rest = label
        .strip_prefix("time")
        .or_else(|| label.strip_prefix("trigger"))
        .or_else(|| label.strip_prefix("x-axis"))?;
    if rest.trim().is_empty() {
        Some(0)
    } else {
        unit(rest.trim_start_matches([' ', '_', '/', '-', ',']))
    }
}

/// `Volt`, `(mV)`, `CH1(V)`, `Channel A [V]`: the factor to volts.
fn volt_unit(label: &str) -> Option<f64> {
    let label = label.trim().to_lowercase();
    let unit = label
        .rsplit_once(['(', '['])
        .map_or(label.as_str(), |(_, unit)| unit)
        .trim_matches(['(', ')', '[', ']', ' ']);
    match unit {
        "v" | "volt" | "volts" | "ampl" | "value" => Some(1.0),
        "mv" | "millivolt" | "millivolts" => Some(1e-3),
        "uv" | "µv" => Some(1e-6),
        _ => None,
    }
}

/// The channel that a label names: `CH1(V)`, `X(CH1)`, `CH3:V`, `Channel A`.
fn channel_name(label: &str) -> Option<String> {
    let label = label.trim().trim_matches(['"', '#']).trim();
    let bare = label.trim_matches(['(', ')', '[', ']']).to_lowercase();
    if bare.is_empty() || UNITS.contains(&bare.as_str()) {
        return None;
    }
    let label = label.strip_prefix("X(").and_then(|l| l.strip_suffix(')')).unwrap_or(label);
    let name = label.split([':', '[']).next().unwrap_or(label);
    let name = match name.rsplit_once('(') {
        Some((name, unit)) if volt_unit(unit).is_some() => name,
        _ => name,
    };
    let name = name.trim();
    // A lone number names a channel only at Keysight, where it is a whole one.
    let is_value = name.parse::<f64>().is_ok() && name.parse::<u8>().is_err();
    (!name.is_empty() && !is_value && !name.contains('=')).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_labels() {
        for (label, exponent) in [
            ("Time [s]", 0),
            ("Time(s)", 0),
            ("TIME", 0),
            ("Second", 0),
            ("x-axis", 0),
            ("(us)", -6),
            ("Time (ms)", -3),
            ("nanoseconds", -9),
            ("Trigger [s]", 0),
            ("s", 0),
            ("Time[ns]", -9),
        ] {
            assert_eq!(time_unit(label), Some(exponent), "{label}");
        }
        for label in ["CH1", "Volt", "X", "timer", "Time_CAN"] {
            assert_eq!(time_unit(label), None, "{label}");
        }
    }

    #[test]
    fn channel_labels() {
        for (label, name) in [
            ("CH1(V)", "CH1"),
            ("X(CH1)", "CH1"),
            ("CH3:V", "CH3"),
            ("Channel A", "Channel A"),
            ("1", "1"),
            ("D7-D0", "D7-D0"),
            ("CAN_H (V)", "CAN_H"),
            ("\"#CH2\"", "CH2"),
        ] {
            assert_eq!(channel_name(label).as_deref(), Some(name), "{label}");
        }
        for label in ["Volt", "(V)", "", "0.000200000", "t0 = -1s", "Second"] {
            assert_eq!(channel_name(label), None, "{label}");
        }
    }
}
