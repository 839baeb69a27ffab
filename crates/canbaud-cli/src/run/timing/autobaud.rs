//! `canbaud timing --autobaud-table`: timer counts to registers, the method of AP2925.

use std::fmt::Write as _;

use canbaud::timing::Rate;
use canbaud::timing::controllers::{Configuration, Controller};
use canbaud::timing::tables::{AutobaudError, AutobaudRow, AutobaudTable, Deviation};
use canbaud::units::Bitrate;
use serde::Serialize;

use super::args::TimingArgs;
use super::json::{self, RegisterRecord, SettingRecord};
use super::refusal::Refusal;
use super::{plan, text};

/// Most bit rates in one table.
const RATES_MAX: usize = 16;

/// Builds the table.
pub(super) fn run(args: &TimingArgs) -> Result<String, Refusal> {
    let controller = plan::controller(args)?;
    let rows = rows(args, &controller)?;
    let timer = args.timer.or(args.clock).map_or(0, canbaud::units::Hertz::hertz);
    if args.json {
        json::line(&TableRecord {
            kind: "autobaud_table",
            controller: controller.name,
            timer_hz: timer,
            rows: rows.iter().map(|row| record(&controller, row)).collect(),
        })
    } else {
        Ok(describe(&controller, timer, &rows))
    }
}

/// Dispatches on the number of rates, which the library wants to know at compile time.
fn rows(args: &TimingArgs, controller: &Controller) -> Result<Vec<AutobaudRow>, Refusal> {
    macro_rules! by_length {
        ($($length:literal)*) => {
            match args.rates.len() {
                $($length => build::<$length>(args, controller),)*
                given => Err(Refusal::usage(
                    format!("{given} bit rates given, 1 to {RATES_MAX} allowed"), None)),
            }
        };
    }
    by_length!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16)
}

fn build<const N: usize>(
    args: &TimingArgs,
    controller: &Controller,
) -> Result<Vec<AutobaudRow>, Refusal> {
    let clock = plan::clock(args)?;
    let rates: [Bitrate; N] = args.rates.clone().try_into().map_err(|rates: Vec<Bitrate>| {
        Refusal::usage(format!("{} bit rates given", rates.len()), None)
    })?;
    let mut rows = Vec::with_capacity(N);
    let deviation = args.deviation.map_or(Deviation::Widest, Deviation::Ticks);
    let timer = args.timer.unwrap_or(clock);
    let refuse = |error: AutobaudError| match error {
        AutobaudError::Solve(bitrate, inner) => {
            let refusal = Refusal::from(inner);
            Refusal {
                line: format!("{}: {}", Rate::from(bitrate).words(), refusal.line),
                ..refusal
            }
        }
        _ => Refusal::impossible(error.to_string(), None),
    };
    let Some(first) = rates.first() else { return Ok(rows) };
    let settings = plan::request(args, clock, *first, args.sample_point);
    let table = AutobaudTable::build(timer, rates, deviation, &settings, &controller.nominal)
        .map_err(refuse)?;
    rows.extend(table.rows().copied());
    Ok(rows)
}

fn describe(controller: &Controller, timer: u64, rows: &[AutobaudRow]) -> String {
    let mut text = format!("{}, timer {timer} Hz\n", controller.name);
    let _ =
        writeln!(text, "{:>12}  {:>20}  {:>12}  registers", "bit rate", "ticks", "sample point");
    for row in rows {
        let window = &row.window;
        let expected = window.expected.scaled(100);
        let ticks = format!(
            "{} <= {}.{:02} <= {}",
            window.low,
            expected / 100,
            expected % 100,
            window.high
        );
        let configuration = Configuration::classic(row.solution.timing);
        let words: Vec<String> = controller
            .pack(&configuration)
            .into_iter()
            .flatten()
            .filter_map(|(r, word)| Some(format!("{}={}", r.name, text::hex(r, word.ok()?))))
            .collect();
        let point = row.solution.timing.sample_point().to_string();
        let _ = writeln!(
            text,
            "{:>12}  {ticks:>20}  {point:>12}  {}",
            Rate::from(window.bitrate).words().to_string(),
            words.join(" ")
        );
    }
    text
}

#[derive(Debug, Serialize)]
struct TableRecord<'a> {
    kind: &'static str,
    controller: &'a str,
    timer_hz: u64,
    rows: Vec<RowRecord>,
}

#[derive(Debug, Serialize)]
struct RowRecord {
    bitrate: u32,
    ticks_low: u64,
    ticks_expected: f64,
    ticks_high: u64,
    setting: SettingRecord,
    registers: Vec<RegisterRecord>,
}

fn record(controller: &Controller, row: &AutobaudRow) -> RowRecord {
    let timing = &row.solution.timing;
    let rate = row.solution.rate.millibits_per_second() as f64 / 1e3;
    RowRecord {
        bitrate: row.window.bitrate.bits_per_second(),
        ticks_low: row.window.low,
        ticks_expected: row.window.expected.scaled(1_000) as f64 / 1e3,
        ticks_high: row.window.high,
        setting: SettingRecord::of(timing).with_bitrate(rate),
        registers: json::registers(controller, &Configuration::classic(*timing)),
    }
}
