//! `docs/mission.md`.

use super::{Finding, ROWS, Row};

const HEAD: &str = "\
# The source documents, reproduced

Made by `cargo run --release -p canbaud-lab --example mission`; `-- --check` says whether it is up to date. Every figure comes from a seeded run
of the simulator, so it is the same everywhere. Each row is also a test of the same number in `crates/canbaud-lab/tests/mission.rs`.

- A: Infineon AP2925, \"CAN Baudrate Detection with Infineon CAN devices\", 1999
- K: U. Koppe, \"Automatic Baudrate Detection in CANopen Networks\", iCC 2003
- D: Maxim, High-Speed Microcontroller User's Guide, DS80C390 Supplement
";

/// Runs every row; gives the page and what did not hold.
#[must_use]
pub fn page() -> (String, Vec<String>) {
    let findings: Vec<(&Row, Finding)> = ROWS.iter().map(|row| (row, (row.run)())).collect();
    let mut text = HEAD.to_owned();
    text.push_str("\n## Where the documents are wrong\n\n");
    for (row, finding) in &findings {
        for erratum in &finding.errata {
            text.push_str(&format!("- {}: {erratum}.\n", row.number));
        }
    }
    for (row, finding) in &findings {
        text.push_str(&format!("\n## {}\n{}\n\n", row.number, row.describes));
        text.push_str(&format!(
            "Shown by `{}` in `crates/canbaud-lab/tests/mission.rs`; also {}.\n\n",
            test_name(row),
            row.tested
        ));
        for line in &finding.lines {
            text.push_str(line);
            text.push('\n');
        }
    }
    while text.contains("\n\n\n") {
        text = text.replace("\n\n\n", "\n\n");
    }
    let fails = |(row, finding): &(&Row, Finding)| {
        let number = row.number;
        finding.failures.iter().map(move |what| format!("{number}: {what}")).collect::<Vec<_>>()
    };
    (text, findings.iter().flat_map(fails).collect())
}

/// The test of a row.
fn test_name(row: &Row) -> String {
    format!("{}_holds", row.number.to_lowercase())
}
