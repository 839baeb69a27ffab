//! Measures how often the edge detector finds the bit rate of one random frame, how often it is
//! wrong, and how precise it is.
//!
//! ```text
//! cargo run --release -p canbaud --example accuracy -- --trials 1000000
//! cargo run --release -p canbaud --example accuracy -- --scene clean --ticks-per-bit 1.5
//! cargo run --release -p canbaud --example accuracy -- --seed 1 --trial 4711
//! ```
//!
//! Exit code 1 if a verdict was wrong, 2 for a mistake on the command line.

mod args;
mod report;
mod run;
mod tally;

#[path = "../../tests/support/mod.rs"]
mod support;

use std::io::Write;
use std::process::ExitCode;
use support::judge::Judgement;

fn main() -> ExitCode {
    let args = match args::parse(std::env::args().skip(1)) {
        Ok(args) => args,
        Err(reason) => {
            eprintln!("{reason}\n{}", args::USAGE);
            return ExitCode::from(2);
        }
    };
    let (text, wrong) = match args.only {
        Some(trial) => {
            let outcome = run::one(&args, trial);
            let wrong = u64::from(matches!(outcome.judgement, Judgement::Wrong(_)));
            (report::one(&args, &outcome), wrong)
        }
        None => {
            let tally = run::all(&args);
            (report::table(&args, &tally), tally.wrong_count())
        }
    };
    // A reader that closes the pipe early has seen enough.
    let _ = std::io::stdout().write_all(text.as_bytes());
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
