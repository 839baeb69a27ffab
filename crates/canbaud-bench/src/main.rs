//! Writes or checks the tables of `docs/accuracy.md`, or repeats one case of them.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use canbaud_bench::case::Draw;
use canbaud_bench::document::{section, with_section};
use canbaud_bench::judge;
use canbaud_bench::tables::{self, TABLES};
use clap::Parser;

/// The section with every wrong answer of all tables.
const MISTAKES: &str = "wrong-answers";
/// The section with the sum of all tables.
const SUM: &str = "sum";

/// Writes the tables of docs/accuracy.md.
#[derive(Debug, Parser)]
struct Args {
    /// Compare instead of writing; exit code 1 if a table is stale
    #[arg(long)]
    check: bool,

    /// Only this table; the sum and the list of wrong answers stay as they are
    #[arg(long, value_name = "NAME", value_parser = TABLES.map(|table| table.name))]
    table: Option<String>,

    /// Run one case and say what comes of it, such as timer=2000000,scene=babbler,seed=7,frames=12
    #[arg(long, value_name = "CASE", conflicts_with_all = ["check", "table"])]
    case: Option<Draw>,

    /// The document
    #[arg(long, value_name = "FILE",
          default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/accuracy.md"))]
    document: PathBuf,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    if let Some(draw) = &args.case {
        return repeat(draw);
    }
    let path = args.document.display();
    let text = std::fs::read_to_string(&args.document).with_context(|| format!("{path}"))?;
    let sections = make(args.table.as_deref());
    if args.check {
        let mut stale = Vec::new();
        for (name, body) in &sections {
            if section(&text, name)? != body.trim_matches('\n') {
                stale.push(name.as_str());
            }
        }
        if !stale.is_empty() {
            bail!(
                "{path} is stale: {}; cargo run --release -p canbaud-bench writes it anew",
                stale.join(", ")
            );
        }
        return Ok(ExitCode::SUCCESS);
    }
    let mut new = text;
    for (name, body) in &sections {
        new = with_section(&new, name, body)?;
    }
    std::fs::write(&args.document, new).with_context(|| format!("{path}"))?;
    Ok(ExitCode::SUCCESS)
}

/// Sections with what belongs into them.
fn make(only: Option<&str>) -> Vec<(String, String)> {
    let mut sections = Vec::new();
    let (mut mistakes, mut cases) = (Vec::new(), 0);
    let chosen = TABLES.iter().filter(|table| only.is_none_or(|only| only == table.name));
    for table in chosen {
        let began = Instant::now();
        let made = table.make();
        eprintln!(
            "{}: {} cases, {} wrong, {} ms",
            table.name,
            made.cases,
            made.mistakes.len(),
            began.elapsed().as_millis()
        );
        cases += made.cases;
        sections.push((table.name.to_owned(), made.text));
        mistakes.push((table.name, made.mistakes));
    }
    if only.is_none() {
        let listed: Vec<_> = mistakes.iter().map(|(name, all)| (*name, all.as_slice())).collect();
        let wrong: usize = listed.iter().map(|(_, all)| all.len()).sum();
        let seed = tables::SEED;
        sections
            .push((SUM.into(), format!("{cases} captures, {wrong} wrong answers, seed {seed}.")));
        sections.push((MISTAKES.into(), tables::mistakes(&listed)));
    }
    sections
}

fn repeat(draw: &Draw) -> Result<ExitCode> {
    let outcome = judge::run(draw).context("no node can have these rates")?;
    println!("{:?}\n{draw}", draw.case);
    println!("answer: {:?}\nfirst: {:?}, {:?}", outcome.answer, outcome.decided, outcome.first);
    println!("in the end: {:?}\nAP2925: {:?}", outcome.verdict, outcome.minimum);
    let wrong = matches!(outcome.answer, judge::Answer::Wrong(_));
    Ok(if wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
