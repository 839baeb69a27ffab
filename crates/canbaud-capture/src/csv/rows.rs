//! Rows of numbers, one after the other.

use super::cells::{Dialect, hex, level};
use super::clock::{Clock, stamp};
use super::header::Content;
use crate::error::CaptureError;
use crate::input::Input;
use crate::lines::Lines;

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    /// Nothing, or nothing that is wanted.
    Empty,
    /// A level, or no data.
    Level(Option<bool>),
    /// A number of lines.
    Word(u64),
    /// Volts, or NaN.
    Volts(f64),
}

/// One row.
pub(super) struct Row {
    /// When it was sampled, in ticks.
    pub(super) at: u64,
    pub(super) cells: Vec<Cell>,
}

/// How to read the rows of a file.
#[derive(Debug, Clone)]
pub(super) struct Table {
    pub(super) dialect: Dialect,
    /// Lines above the numbers.
    pub(super) skip: u64,
    pub(super) columns: Vec<Content>,
    pub(super) clock: Clock,
}

/// The rows of a file from the first on.
pub(super) struct Rows<'a> {
    table: &'a Table,
    lines: Lines,
    /// Rows so far.
    count: u64,
    last: u64,
}

impl<'a> Rows<'a> {
    pub(super) fn new(table: &'a Table, input: &Input) -> Result<Self, CaptureError> {
        let mut lines = Lines::new(input);
        for _ in 0..table.skip {
            lines.next()?;
        }
        Ok(Self { table, lines, count: 0, last: 0 })
    }

    /// Bytes read so far.
    pub(super) const fn done(&self) -> u64 {
        self.lines.done()
    }

    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    /// Reads the next row into `row`; false at the end.
    pub(super) fn next(&mut self, row: &mut Row) -> Result<bool, CaptureError> {
        let table = self.table;
        loop {
            let Some(line) = self.lines.next()? else { return Ok(false) };
            if line.trim_ascii().is_empty()
                || (line.starts_with(b";") && table.dialect.separator != b';')
            {
                continue;
            }
            row.cells.clear();
            let mut time: &[u8] = b"";
            let mut bad = None;
            for (column, cell) in table.dialect.cells(line).enumerate().take(table.columns.len()) {
                if Some(column) == table.clock.column() {
                    time = cell;
                }
                let content = table.columns.get(column).copied().unwrap_or(Content::Ignored);
                let parsed = parse(table.dialect, content, cell);
                if parsed.is_none() {
                    bad =
                        Some(String::from_utf8_lossy(cell.get(..30).unwrap_or(cell)).into_owned());
                }
                row.cells.push(parsed.unwrap_or(Cell::Empty));
            }
            let at = table.clock.tick(table.dialect, time, self.count);
            if let Some(bad) = bad {
                let reason = format!("{bad:?} is no number");
                return Err(CaptureError::damaged(self.lines.place(), reason));
            }
            row.at = at.map_err(|reason| CaptureError::damaged(self.lines.place(), reason))?;
            if row.at < self.last {
                let reason = "the time is before that of the row above";
                return Err(CaptureError::damaged(self.lines.place(), reason));
            }
            self.last = row.at;
            self.count += 1;
            return Ok(true);
        }
    }
}

fn parse(dialect: Dialect, content: Content, cell: &[u8]) -> Option<Cell> {
    if cell.is_empty() {
        return Some(Cell::Empty);
    }
    match content {
        Content::Ignored => Some(Cell::Empty),
        Content::Digital => level(cell)
            .or_else(|| dialect.volts(cell).map(|v| (!v.is_nan()).then_some(v > 0.5)))
            .map(Cell::Level),
        Content::Hex(_) => hex(cell).map(Cell::Word),
        Content::Volts(factor) => dialect.volts(cell).map(|v| Cell::Volts(v * factor)),
    }
}

impl Clock {
    /// The column that holds times.
    const fn column(&self) -> Option<usize> {
        match *self {
            Self::Rows { .. } => None,
            Self::Sigrok { column, .. } | Self::Stamps { column, .. } => Some(column),
        }
    }

    /// The tick of a row, or what is wrong with its time.
    fn tick(&self, dialect: Dialect, time: &[u8], row: u64) -> Result<u64, &'static str> {
        const TOO_LARGE: &str = "the time is too large";
        match *self {
            Self::Rows { step } => row.checked_mul(step).ok_or(TOO_LARGE),
            Self::Sigrok { exponent, rate, step, .. } => {
                let value = dialect.decimal(time).ok_or("has no time")?;
                let seconds = crate::number::Decimal {
                    exponent: value.exponent.saturating_add(exponent),
                    ..value
                };
                // The stamp is one sample late, and cut to a whole unit.
                let sample = (seconds.to_f64() * rate.hertz() as f64).round() - 1.0;
                if !(0.0..1e18).contains(&sample) {
                    return Err(TOO_LARGE);
                }
                (sample as u64).checked_mul(step).ok_or(TOO_LARGE)
            }
            Self::Stamps { exponent, digits, origin, .. } => {
                let value = stamp(dialect, time, exponent, digits).ok_or("has no time")?;
                if value < origin {
                    return Err("the time is before that of the first row");
                }
                u64::try_from(value.saturating_sub(origin)).map_err(|_| TOO_LARGE)
            }
        }
    }
}
