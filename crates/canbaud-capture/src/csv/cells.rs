//! Cells of a row and the numbers in them.

use crate::number::Decimal;

/// How numbers and cells are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dialect {
    pub(crate) separator: u8,
    /// The decimal mark.
    pub(crate) mark: u8,
}

impl Dialect {
    /// The dialect that a row of numbers is written in.
    pub(crate) fn of(row: &[u8]) -> Self {
        let separator = [b'\t', b';'].into_iter().find(|byte| row.contains(byte)).unwrap_or(b',');
        let comma = separator != b',' && row.contains(&b',');
        Self { separator, mark: if comma { b',' } else { b'.' } }
    }

    /// The cells of a row, trimmed, without quotes; empty ones at the end are left out.
    pub(crate) fn cells(self, row: &[u8]) -> impl Iterator<Item = &[u8]> {
        let is_filler = |&b: &u8| b == self.separator || b.is_ascii_whitespace();
        let end = row.iter().rposition(|b| !is_filler(b)).map_or(0, |last| last + 1);
        let row = row.get(..end).unwrap_or_default();
        row.split(move |&b| b == self.separator).map(|cell| {
            let cell = cell.trim_ascii();
            cell.strip_prefix(b"\"").and_then(|c| c.strip_suffix(b"\"")).unwrap_or(cell)
        })
    }

    /// The exact number in a cell.
    pub(crate) fn decimal(self, cell: &[u8]) -> Option<Decimal> {
        if self.mark == b'.' {
            return Decimal::parse(cell);
        }
        let mut text = [0; 40];
        let text = text.get_mut(..cell.len())?;
        text.copy_from_slice(cell);
        text.iter_mut().filter(|b| **b == b',').for_each(|b| *b = b'.');
        Decimal::parse(text)
    }

    /// The voltage in a cell; what an instrument writes for "no value" is NaN.
    pub(crate) fn volts(self, cell: &[u8]) -> Option<f64> {
        if let Some(decimal) = self.decimal(cell) {
            return Some(decimal.to_f64());
        }
        let no_value: [&[u8]; 8] =
            [b"nan", b"-nan", b"inf", b"-inf", b"+inf", b"infinity", b"-infinity", b"----"];
        no_value.iter().any(|word| word.eq_ignore_ascii_case(cell)).then_some(f64::NAN)
    }
}

/// The two levels as a digital column writes them, or no data.
pub(crate) fn level(cell: &[u8]) -> Option<Option<bool>> {
    match cell {
        b"0" => Some(Some(false)),
        b"1" => Some(Some(true)),
        b"X" | b"x" | b"Z" | b"z" => Some(None),
        _ => None,
    }
}

/// Eight or more lines in one cell: `0x1F`.
pub(crate) fn hex(cell: &[u8]) -> Option<u64> {
    let digits = cell.strip_prefix(b"0x").or_else(|| cell.strip_prefix(b"0X"))?;
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    u64::from_str_radix(core::str::from_utf8(digits).ok()?, 16).ok()
}

/// An ISO 8601 stamp in nanoseconds since 1970 (an offset from UTC only shifts the origin).
pub(crate) fn iso_8601(cell: &[u8]) -> Option<i128> {
    let text = core::str::from_utf8(cell).ok()?;
    let (date, time) = text.split_once(['T', ' '])?;
    let mut date = date.splitn(3, '-').map(|part| part.parse::<i128>().ok());
    let (year, month, day) = (date.next()??, date.next()??, date.next()??);
    if !(1970..=9999).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let end = time.find(['Z', '+', '-']).unwrap_or(time.len());
    let mut time = time.get(..end)?.splitn(3, ':');
    let (hour, minute) = (time.next()?.parse::<i128>().ok()?, time.next()?.parse::<i128>().ok()?);
    let second = Decimal::parse(time.next()?.as_bytes())?.scaled(9)?;
    if !(0..24).contains(&hour)
        || !(0..60).contains(&minute)
        || !(0..61_000_000_000).contains(&second)
    {
        return None;
    }
    // Days by the civil calendar, counted from a March so that the leap day ends the year.
    let (y, m) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let days = 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 - 719_468;
    Some(((days * 24 + hour) * 60 + minute) * 60_000_000_000 + second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iso_stamps() {
        assert_eq!(iso_8601(b"1970-01-01T00:00:00.5Z"), Some(500_000_000));
        // 2000-03-01 00:00 UTC is 951 868 800 s.
        assert_eq!(iso_8601(b"2000-03-01T00:00:01+00:00"), Some(951_868_801_000_000_000));
        assert_eq!(iso_8601(b"2024-02-29 12:00:00.000000001"), Some(1_709_208_000_000_000_001));
        for bad in ["", "2024", "2024-13-01T00:00:00", "2024-01-01T25:00:00", "0.5", "T::"] {
            assert_eq!(iso_8601(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn dialects() {
        let semicolon = Dialect::of(b"-0,5;1,25;");
        assert_eq!(semicolon, Dialect { separator: b';', mark: b',' });
        assert_eq!(semicolon.cells(b"-0,5;1,25;").count(), 2);
        assert_eq!(semicolon.volts(b"1,25"), Some(1.25));
        assert_eq!(Dialect::of(b"1\t2.5"), Dialect { separator: b'\t', mark: b'.' });
        assert!(Dialect::of(b"1,2").volts(b"NaN").is_some_and(f64::is_nan));
        assert_eq!(Dialect::of(b"1,2").volts(b"abc"), None);
    }
}
