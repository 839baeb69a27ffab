//! Writes or checks the tables about scans in `docs/accuracy.md`, or runs very many of them.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use canbaud_bench::document::{section, with_section};
use canbaud_bench::scans::{Score, TABLES, random, run_random};
use clap::Parser;

/// Writes the tables about scans in docs/accuracy.md.
#[derive(Debug, Parser)]
struct Args {
    /// Compare instead of writing; exit code 1 if a table is stale
    #[arg(long)]
    check: bool,

    /// Only this table
    #[arg(long, value_name = "NAME", value_parser = TABLES.map(|table| table.name))]
    table: Option<String>,

    /// Run so many scans in which everything is by chance; exit code 1 if one is wrong
    #[arg(long, value_name = "COUNT", conflicts_with_all = ["check", "table"])]
    random: Option<u64>,

    /// The first of them
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    from: u64,

    /// The document
    #[arg(long, value_name = "FILE",
          default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/accuracy.md"))]
    document: PathBuf,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    if let Some(count) = args.random {
        return many(args.from, count);
    }
    let path = args.document.display();
    let mut text = std::fs::read_to_string(&args.document).with_context(|| format!("{path}"))?;
    let mut stale = Vec::new();
    for table in TABLES {
        if args.table.as_deref().is_some_and(|only| only != table.name) {
            continue;
        }
        let began = Instant::now();
        let body = (table.make)()?;
        eprintln!("{}: {} ms", table.name, began.elapsed().as_millis());
        if args.check && section(&text, table.name)? != body.trim_matches('\n') {
            stale.push(table.name);
        }
        text = with_section(&text, table.name, &body)?;
    }
    if !stale.is_empty() {
        bail!(
            "{path} is stale: {}; cargo run --release -p canbaud-bench --bin scans writes it anew",
            stale.join(", ")
        );
    }
    if !args.check {
        std::fs::write(&args.document, text).with_context(|| format!("{path}"))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn many(from: u64, count: u64) -> Result<ExitCode> {
    let began = Instant::now();
    let mut score = Score::default();
    for number in from..from + count {
        let report = run_random(number)?;
        score.add(&report);
        let late = report.elapsed > report.bound.unwrap_or_default();
        if !report.right || report.dominant > 0 || late {
            println!("number {number}: {:?}\n  {:?}", random(number), report.outcome);
        }
        if (number - from).is_multiple_of(10_000) {
            eprintln!("{number}: {score:?}, {} s", began.elapsed().as_secs());
        }
    }
    println!(
        "{} scans, {} found, {} wrong, {} dominant bits, {} later than the bound, {} thousandths \
         of it used at most, {} frames on average, {} s",
        score.trials,
        score.percent(score.right),
        score.wrong,
        score.dominant,
        score.late,
        score.of_bound,
        score.frames_text(),
        began.elapsed().as_secs()
    );
    let clean = score.wrong == 0 && score.dominant == 0 && score.late == 0;
    Ok(if clean { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
