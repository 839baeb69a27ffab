//! When each row was sampled.

use canbaud::units::{Hertz, Timebase};

use super::cells::{Dialect, iso_8601};
use super::header::{Content, Header, Timing};
use crate::analogue::TICKS_PER_SAMPLE;
use crate::capture::OpenOptions;
use crate::error::{CaptureError, Place};
use crate::input::Input;
use crate::number::{Decimal, period_timebase};
use crate::{grid, lines, sr};

/// Fewer rows than this show no regular period.
const MIN_ROWS: usize = 8;

/// How a row gets its tick.
#[derive(Debug, Clone, Copy)]
pub(super) enum Clock {
    /// The number of the row times this.
    Rows { step: u64 },
    /// sigrok's integers: `(value + 1) * unit * rate - 1` samples, each of `step` ticks.
    Sigrok { column: usize, exponent: i32, rate: Hertz, step: u64 },
    /// The value of a column in units of `10^-digits` seconds, from `origin` on.
    Stamps { column: usize, exponent: i32, digits: i32, origin: i128 },
}

/// The clock of a file and what it means for the capture.
pub(super) struct Timed {
    pub(super) clock: Clock,
    pub(super) timebase: Timebase,
    pub(super) samplerate: Option<Hertz>,
    /// Quantisation step of digital channels in ticks.
    pub(super) digital_step: u64,
}

impl Timed {
    /// Rows at a rate.
    fn at_rate(rate: Hertz, interpolated: bool) -> Self {
        let (timebase, step) = sr::timebase(rate, interpolated);
        Self { clock: Clock::Rows { step }, timebase, samplerate: Some(rate), digital_step: step }
    }

    fn at_period(period: Decimal, interpolated: bool, line: u64) -> Result<Self, CaptureError> {
        let step = if interpolated { TICKS_PER_SAMPLE } else { 1 };
        let (timebase, rate) = period_timebase(period, step).ok_or_else(|| {
            let reason = format!("a sample period of {:e} s is out of range", period.to_f64());
            CaptureError::damaged(Place::Line(line), reason)
        })?;
        let clock = Clock::Rows { step };
        Ok(Self { clock, timebase, samplerate: Some(rate), digital_step: step })
    }
}

/// Finds the clock of a file.
pub(super) fn find(
    header: &Header,
    input: &Input,
    options: &OpenOptions,
    interpolated: bool,
) -> Result<Timed, CaptureError> {
    let line = header.lines + 1;
    let rate = options.samplerate.or(header.samplerate);
    match header.timing {
        Timing::Sigrok { column } => {
            let rate = rate.ok_or(CaptureError::NoSamplerate(header.format))?;
            sigrok(header, column, rate, interpolated)
        }
        Timing::Period(period) => match options.samplerate {
            Some(rate) => Ok(Timed::at_rate(rate, interpolated)),
            None => Timed::at_period(period, interpolated, line),
        },
        Timing::Unknown => match rate {
            Some(rate) => Ok(Timed::at_rate(rate, interpolated)),
            None => Err(CaptureError::NoSamplerate(header.format)),
        },
        Timing::Column { column, exponent } => {
            let regular = Regular::of_head(header, column, exponent);
            let Some(head) = regular.filter(|_| !is_change_list(header)) else {
                return stamps(header, column, exponent, options);
            };
            if let Some(rate) = options.samplerate {
                return Ok(Timed::at_rate(rate, interpolated));
            }
            if let Some(period) = header.period.filter(|p| head.agrees(p.to_f64())) {
                return Timed::at_period(period, interpolated, line);
            }
            if let Some(rate) = header.samplerate.filter(|r| head.agrees(1.0 / r.hertz() as f64)) {
                return Ok(Timed::at_rate(rate, interpolated));
            }
            match head.over_file(header, column, exponent, input)? {
                Some(period) => Timed::at_period(period, interpolated, line),
                None => stamps(header, column, exponent, options),
            }
        }
    }
}

/// Whether every row is a change: levels only, and no row repeats the one above. That such rows
/// come at regular times at first does not mean that they go on so.
fn is_change_list(header: &Header) -> bool {
    let data: Vec<usize> = (0..header.columns.len())
        .filter(|&n| header.columns.get(n).is_some_and(|(_, c)| *c != Content::Ignored))
        .collect();
    let volts = |&n: &usize| matches!(header.columns.get(n), Some((_, Content::Volts(_))));
    // The last row may be the end of the recording.
    let mut pairs = header.head.iter().zip(header.head.iter().skip(1)).rev().skip(1);
    let differs =
        |(a, b): (&Vec<Vec<u8>>, &Vec<Vec<u8>>)| data.iter().any(|&n| a.get(n) != b.get(n));
    !data.iter().any(volts) && pairs.all(differs)
}

/// The unit of sigrok's time column: the first row is one sample period.
fn sigrok(
    header: &Header,
    column: usize,
    rate: Hertz,
    interpolated: bool,
) -> Result<Timed, CaptureError> {
    let first = header.head.first().and_then(|row| row.get(column));
    let first = first.and_then(|cell| header.dialect.decimal(cell)).map_or(0.0, Decimal::to_f64);
    let period = 1.0 / rate.hertz() as f64;
    let exponent = [0, -3, -6, -9, -12, -15]
        .into_iter()
        .find(|&exponent| {
            let unit = 10_f64.powi(exponent);
            first >= 1.0 && (first * unit - period).abs() < unit && first * unit < 2.0 * period
        })
        .ok_or_else(|| {
            let reason = format!("the first time is not one sample period of {period:e} s");
            CaptureError::damaged(Place::Line(header.lines + 1), reason)
        })?;
    let timed = Timed::at_rate(rate, interpolated);
    let step = timed.digital_step;
    Ok(Timed { clock: Clock::Sigrok { column, exponent, rate, step }, ..timed })
}

/// Times as they are printed, for files with a row per change.
fn stamps(
    header: &Header,
    column: usize,
    exponent: i32,
    options: &OpenOptions,
) -> Result<Timed, CaptureError> {
    let cells = || header.head.iter().filter_map(|row| row.get(column));
    let places = cells().filter_map(|cell| header.dialect.decimal(cell));
    let digits =
        places.map(|d| -d.exponent.saturating_add(exponent)).max().unwrap_or(9).clamp(9, 12);
    let value = |cell: &Vec<u8>| stamp(header.dialect, cell, exponent, digits);
    let bad = || CaptureError::damaged(Place::Line(header.lines + 1), "has no time");
    let origin = cells().next().and_then(value).ok_or_else(bad)?;
    let ticks_per_second = 10_u64.pow(digits.unsigned_abs());
    let timebase = Timebase::new(ticks_per_second, 1).ok_or_else(bad)?;
    let times: Vec<u64> =
        cells().filter_map(value).filter_map(|t| u64::try_from(t - origin).ok()).collect();
    let digital_step = match options.samplerate {
        Some(rate) => (ticks_per_second / rate.hertz()).max(1),
        None => grid::step(&times, timebase),
    };
    let clock = Clock::Stamps { column, exponent, digits, origin };
    Ok(Timed { clock, timebase, samplerate: options.samplerate, digital_step })
}

/// A time in units of `10^-digits` seconds.
pub(super) fn stamp(dialect: Dialect, cell: &[u8], exponent: i32, digits: i32) -> Option<i128> {
    match dialect.decimal(cell) {
        Some(decimal) => decimal.scaled(exponent.saturating_add(digits)),
        None => iso_8601(cell).map(|ns| ns * 10_i128.pow((digits - 9).unsigned_abs())),
    }
}

/// Times that rise by a period, as far as their printed digits tell.
struct Regular {
    first: f64,
    period: f64,
    /// How much the period may be wrong.
    error: f64,
}

impl Regular {
    fn of_head(header: &Header, column: usize, exponent: i32) -> Option<Self> {
        let dialect = header.dialect;
        let rows = header.head.iter().filter(|row| !row.is_empty());
        let times: Option<Vec<Decimal>> =
            rows.map(|row| dialect.decimal(row.get(column)?)).collect();
        let times: Vec<Decimal> = times?
            .into_iter()
            .map(|t| Decimal { exponent: t.exponent.saturating_add(exponent), ..t })
            .collect();
        if times.len() < MIN_ROWS {
            return None;
        }
        let quantum = times.iter().map(|t| 10_f64.powi(t.exponent)).fold(0.0, f64::max);
        let (first, last) = (times.first()?.to_f64(), times.last()?.to_f64());
        let gaps = (times.len() - 1) as f64;
        let period = (last - first) / gaps;
        let fits = times.iter().enumerate().all(|(n, t)| {
            let expected = first + n as f64 * period;
            (t.to_f64() - expected).abs() <= 2.0 * quantum + 0.02 * period
        });
        let regular = Self { first, period, error: 2.0 * quantum / gaps };
        // NaN fails every comparison, and so is not regular.
        (fits && period + regular.error > 0.0).then_some(regular)
    }

    fn agrees(&self, period: f64) -> bool {
        (period - self.period).abs() <= self.error + 1e-3 * period
    }

    /// The period over the whole file; `None` if it does not go on as it began.
    fn over_file(
        &self,
        header: &Header,
        column: usize,
        exponent: i32,
        input: &Input,
    ) -> Result<Option<Decimal>, CaptureError> {
        let (count, last) = lines::count(input)?;
        let Some(gaps) = count.checked_sub(header.filled + 1).filter(|&gaps| gaps > 0) else {
            return Ok(None);
        };
        let Some(last) =
            header.dialect.cells(&last).nth(column).and_then(|cell| header.dialect.decimal(cell))
        else {
            return Ok(None);
        };
        let last = Decimal { exponent: last.exponent.saturating_add(exponent), ..last };
        let period = (last.to_f64() - self.first) / gaps as f64;
        let error = 2.0 * 10_f64.powi(last.exponent) / gaps as f64;
        let whole = Self { first: self.first, period, error: error.max(period * 1e-12) };
        if period <= 0.0 || !period.is_finite() || !self.agrees(period) {
            return Ok(None);
        }
        Ok(whole.roundest())
    }

    /// The period with the fewest digits, in seconds or as a rate, that the times allow.
    fn roundest(&self) -> Option<Decimal> {
        let within = |period: f64| (period - self.period).abs() <= self.error;
        for digits in 1..=9 {
            let rate = round_to(1.0 / self.period, digits)?;
            if within(1.0 / rate.to_f64()) {
                return reciprocal(rate);
            }
            let period = round_to(self.period, digits)?;
            if within(period.to_f64()) {
                return Some(period);
            }
        }
        round_to(self.period, 15)
    }
}

/// `value` with so many significant digits.
fn round_to(value: f64, digits: usize) -> Option<Decimal> {
    Decimal::parse(format!("{value:.*e}", digits - 1).as_bytes())
}

/// `1 / rate` to 15 digits, or exactly where that is short.
fn reciprocal(rate: Decimal) -> Option<Decimal> {
    round_to(1.0 / rate.to_f64(), 15)
}
