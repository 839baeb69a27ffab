//! What precedes the first row of numbers, and what the columns mean.

use super::cells::{Dialect, hex, iso_8601, level};
use super::labels::Head;
use crate::Format;
use crate::error::CaptureError;
use crate::input::Input;
use crate::lines::Lines;
use crate::number::Decimal;
use canbaud::units::Hertz;

/// Bytes of the head that are looked at.
const HEAD: u64 = 64 * 1024;
/// Header lines of the longest known header, with room.
const MAX_HEADER: usize = 400;
/// More columns than any instrument writes.
const MAX_COLUMNS: usize = 128;

/// What one column holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Content {
    /// Time, a counter, or nothing of use.
    Ignored,
    /// 0, 1 or X.
    Digital,
    /// A number of lines as one hexadecimal number.
    Hex(u32),
    /// Numbers, times this factor volts.
    Volts(f64),
}

/// How rows get their times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Timing {
    /// Every row is one sample period after the row before.
    Period(Decimal),
    /// A column holds times; they count in `10^exponent` seconds.
    Column { column: usize, exponent: i32 },
    /// Whole numbers, one sample late, in the unit that makes the first one the sample period.
    Sigrok { column: usize },
    /// Nothing tells: the sample rate must be given.
    Unknown,
}

/// Everything the head tells.
#[derive(Debug)]
pub(crate) struct Header {
    pub(crate) format: Format,
    pub(crate) dialect: Dialect,
    /// Lines before the first row of numbers.
    pub(crate) lines: u64,
    /// Those among them that are not empty.
    pub(crate) filled: u64,
    pub(crate) columns: Vec<(String, Content)>,
    pub(crate) timing: Timing,
    /// A sample period from the header, even where a column holds times.
    pub(crate) period: Option<Decimal>,
    pub(crate) samplerate: Option<Hertz>,
    /// The first rows of numbers.
    pub(crate) head: Vec<Vec<Vec<u8>>>,
}

/// Finds the header; `None` if this is no table of numbers.
pub(crate) fn sniff(input: &Input) -> Result<Option<Header>, CaptureError> {
    // A binary file has no lines to complain about.
    if input.bytes(0, HEAD as usize)?.contains(&0) {
        return Ok(None);
    }
    let mut lines = Lines::new(input);
    let mut above: Vec<Vec<u8>> = Vec::new();
    while above.len() <= MAX_HEADER && lines.done() < HEAD {
        let Some(line) = lines.next()? else { return Ok(None) };
        if !line.starts_with(b";") && is_row(line) {
            let first = line.to_vec();
            return build(&above, first, &mut lines);
        }
        above.push(line.to_vec());
    }
    Ok(None)
}

/// Whether all cells hold what a row of samples may hold, and at least one a number.
fn is_row(line: &[u8]) -> bool {
    let dialect = Dialect::of(line);
    let mut numbers = 0;
    for cell in dialect.cells(line) {
        let number =
            dialect.decimal(cell).is_some() || hex(cell).is_some() || iso_8601(cell).is_some();
        numbers += usize::from(number);
        let fits = number || cell.is_empty() || level(cell).is_some();
        if !fits && dialect.volts(cell).is_none() {
            return false;
        }
    }
    numbers > 0
}

fn build(
    above: &[Vec<u8>],
    first: Vec<u8>,
    lines: &mut Lines,
) -> Result<Option<Header>, CaptureError> {
    let dialect = Dialect::of(&first);
    let split = |line: &[u8]| dialect.cells(line).map(<[u8]>::to_vec).collect::<Vec<_>>();
    let mut head = vec![split(&first)];
    while lines.done() < HEAD {
        let Some(line) = lines.next()? else { break };
        if !line.trim_ascii().is_empty() {
            head.push(split(line));
        }
    }
    let width = head.iter().map(Vec::len).max().unwrap_or(0);
    if width > MAX_COLUMNS {
        return Err(CaptureError::Limit {
            what: "the number of columns",
            value: width as u64,
            max: MAX_COLUMNS as u64,
        });
    }
    // A name in a header is text, whatever its encoding.
    let text = |line: &Vec<u8>| -> Vec<String> {
        dialect.cells(line).map(|cell| String::from_utf8_lossy(cell).into_owned()).collect()
    };
    let rows: Vec<Vec<String>> = above.iter().map(text).collect();
    let comments: Vec<String> = above
        .iter()
        .filter_map(|line| line.strip_prefix(b";"))
        .map(|rest| String::from_utf8_lossy(rest).trim().to_owned())
        .collect();
    let head = Head { above: &rows, comments: &comments, head: &head, width, dialect };
    let columns = head.columns();
    let (format, timing) = (head.format(), head.timing(&columns));
    let (period, samplerate) = (head.period(), head.samplerate());
    let lines = above.len() as u64;
    let filled = above.iter().filter(|line| !line.trim_ascii().is_empty()).count() as u64;
    if head.has_segments() {
        return Err(CaptureError::unsupported(
            format,
            "a file with several segments (export one segment)",
        ));
    }
    let named = columns
        .iter()
        .enumerate()
        .map(|(column, content)| (head.name(column, &columns), *content))
        .collect();
    Ok(Some(Header {
        format,
        dialect,
        lines,
        filled,
        columns: named,
        timing,
        period,
        samplerate,
        head: head.head.to_vec(),
    }))
}
