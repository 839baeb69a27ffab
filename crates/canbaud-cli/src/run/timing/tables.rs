//! `canbaud timing --table`: the tables of the source documents, misprints marked.

use std::fmt::Write as _;

use canbaud::timing::tables::{
    AP2925, CANOPEN, CANOPEN_TIMER_TICKS, DS80C390, Ds80c390Misprint, Misprint,
};
use serde::Serialize;

use super::args::TableName;
use super::json;
use super::refusal::Refusal;

/// A printed table: columns and rows of text, and what is wrong in each row of the document.
#[derive(Debug, Serialize)]
pub(super) struct Table {
    kind: &'static str,
    name: &'static str,
    source: &'static str,
    columns: Vec<&'static str>,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    cells: Vec<String>,
    misprints: Vec<String>,
}

/// The table with this name.
pub(super) fn run(name: TableName, as_json: bool) -> Result<String, Refusal> {
    let tables = match name {
        TableName::Ap2925 => vec![ap2925()],
        TableName::Canopen => vec![canopen(), canopen_ticks()],
        TableName::Ds80c390 => vec![ds80c390()],
    };
    if as_json {
        return json::line(&Tables { kind: "tables", tables });
    }
    let mut text = String::new();
    for table in &tables {
        table.describe(&mut text);
    }
    Ok(text)
}

#[derive(Debug, Serialize)]
struct Tables {
    kind: &'static str,
    tables: Vec<Table>,
}

impl Table {
    fn describe(&self, text: &mut String) {
        let _ = writeln!(text, "{} ({})", self.name, self.source);
        let width = |column: usize| {
            let cells = self.rows.iter().map(|row| row.cells[column].len());
            cells.chain([self.columns[column].len()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut line = |cells: &[&str], misprints: &[String]| {
            for (cell, width) in cells.iter().zip(&widths) {
                let _ = write!(text, "  {cell:>width$}");
            }
            if !misprints.is_empty() {
                let _ = write!(text, "  <- {}", misprints.join("; "));
            }
            text.push('\n');
        };
        line(&self.columns, &[]);
        for row in &self.rows {
            let cells: Vec<&str> = row.cells.iter().map(String::as_str).collect();
            line(&cells, &row.misprints);
        }
        text.push('\n');
    }
}

fn ap2925() -> Table {
    let rows = AP2925.iter().map(|row| {
        let [low, _, high] = row.right_ticks();
        let misprints = row.misprints().map(|misprint| match misprint {
            Misprint::Register { right } => {
                format!("printed 0x{:04X}, right 0x{right:04X}", row.printed_btr)
            }
            Misprint::SamplePoint { right } => format!(
                "printed sample point {}.{} %, right {right}",
                row.printed_sample_point / 10,
                row.printed_sample_point % 10
            ),
            Misprint::Ticks { right } => {
                format!("printed ticks {:?}, right {right:?}", row.printed_ticks)
            }
        });
        Row {
            cells: vec![
                row.cpu_mhz.to_string(),
                row.kbits_per_second.to_string(),
                format!(
                    "{} x (1 + {} + {})",
                    row.timing.prescaler,
                    row.timing.tseg1(),
                    row.timing.tseg2()
                ),
                format!("0x{:04X}", row.btr()),
                row.timing.sample_point().to_string(),
                format!("{low} <= {} <= {high}", row.ticks()),
                format!("0x{:04X}", row.code_btr),
            ],
            misprints: misprints.collect(),
        }
    });
    Table {
        kind: "table",
        name: "AP2925 calculation tables",
        source: "Infineon AP2925, 1999; C167, SJW 1, timer at f_CPU; the values shown are the right ones",
        columns: vec![
            "f_CPU/MHz",
            "kbit/s",
            "prescaler x TQ",
            "BTR",
            "sample point",
            "ticks",
            "BTR in the C code",
        ],
        rows: rows.collect(),
    }
}

fn canopen() -> Table {
    let rows = CANOPEN.iter().map(|row| Row {
        cells: vec![
            (row.bits_per_second / 1_000).to_string(),
            row.quanta.to_string(),
            format!("{}.{} %", row.sample_point_permille / 10, row.sample_point_permille % 10),
        ],
        misprints: Vec::new(),
    });
    Table {
        kind: "table",
        name: "CANopen bit rates",
        source: "Koppe, iCC 2003, table 1",
        columns: vec!["kbit/s", "TQ", "sample point"],
        rows: rows.collect(),
    }
}

fn canopen_ticks() -> Table {
    let rows = CANOPEN_TIMER_TICKS.iter().map(|row| {
        let hundredths = row.ticks().scaled(100);
        let ticks = format!("{}.{:02}", hundredths / 100, hundredths % 100);
        let misprints = if row.is_misprint() {
            vec![format!("printed {}, right {ticks}", row.printed)]
        } else {
            Vec::new()
        };
        Row {
            cells: vec![row.timer_mhz.to_string(), row.kbits_per_second.to_string(), ticks],
            misprints,
        }
    });
    Table {
        kind: "table",
        name: "Timer ticks in a dominant bit",
        source: "Koppe, iCC 2003, table 2",
        columns: vec!["f_Timer/MHz", "kbit/s", "ticks"],
        rows: rows.collect(),
    }
}

fn ds80c390() -> Table {
    let rows = DS80C390.iter().map(|row| {
        let timing = row.timing();
        let misprint = row.misprint().map(|misprint| match misprint {
            Ds80c390Misprint::Prescaler { right } => {
                format!("printed BRPV {}, right {right}", row.printed_brpv)
            }
            Ds80c390Misprint::Sjw { max } => {
                format!("printed SJW {}, which may not exceed TS2_LEN {max}", row.printed_sjw)
            }
        });
        Row {
            cells: vec![
                row.oscillator_mhz.to_string(),
                row.kbits_per_second.to_string(),
                timing.prescaler.to_string(),
                row.ccd.to_string(),
                timing.tseg1().to_string(),
                timing.tseg2().to_string(),
                timing.sjw.to_string(),
                timing.sample_point().to_string(),
                if row.allows_triple_sampling() { "yes" } else { "no" }.to_owned(),
            ],
            misprints: misprint.into_iter().collect(),
        }
    });
    Table {
        kind: "table",
        name: "DS80C390 bit timing examples",
        source: "DS80C390 supplement page 155; the values shown are the right ones",
        columns: vec![
            "F_OSC/MHz",
            "kbit/s",
            "BRPV",
            "CCD",
            "TS1_LEN",
            "TS2_LEN",
            "SJW",
            "sample point",
            "triple sampling",
        ],
        rows: rows.collect(),
    }
}
