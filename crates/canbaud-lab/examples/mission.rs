//! Writes `docs/mission.md`, or with `--check` says whether it is up to date.
#![allow(missing_docs, reason = "an example")]

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/mission.md");
    let (text, failures) = canbaud_lab::mission::page();
    for failure in &failures {
        eprintln!("does not hold: {failure}");
    }
    if std::env::args().any(|argument| argument == "--check") {
        if std::fs::read_to_string(&path).is_ok_and(|there| there == text) && failures.is_empty() {
            return ExitCode::SUCCESS;
        }
        eprintln!("docs/mission.md is not what comes out: run the example mission without --check");
        return ExitCode::FAILURE;
    }
    if let Err(error) = std::fs::write(&path, text) {
        eprintln!("docs/mission.md: {error}");
        return ExitCode::FAILURE;
    }
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
