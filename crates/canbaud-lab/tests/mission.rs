//! The rows of `docs/mission.md`, each by its number.

use std::path::{Path, PathBuf};

use canbaud_lab::mission::ROWS;

fn holds(number: &str) {
    let row = ROWS.iter().find(|row| row.number == number).expect("a row of that number");
    let finding = (row.run)();
    assert!(finding.failures.is_empty(), "{number}: {}", finding.failures.join("; "));
    assert!(!finding.lines.is_empty(), "{number} has no figure");
}

macro_rules! rows {
    ($($(#[$doc:meta])* $name:ident $number:literal)*) => {
        $($(#[$doc])* #[test] fn $name() { holds($number); })*

        #[test]
        fn there_is_a_test_for_every_row() {
            let mut tested = vec![$(($number, stringify!($name))),*];
            let mut rows: Vec<_> = ROWS.iter().map(|row| row.number).collect();
            assert!(tested.iter().all(|(number, name)| {
                *name == format!("{}_holds", number.to_lowercase())
            }));
            tested.sort_unstable();
            rows.sort_unstable();
            assert_eq!(tested.iter().map(|(number, _)| *number).collect::<Vec<_>>(), rows);
        }
    };
}

rows! {
    a1_holds "A1" a2_holds "A2" a3_holds "A3" a4_holds "A4"
    a5_holds "A5" a6_holds "A6" a7_holds "A7" a8_holds "A8"
    k1_holds "K1" k2_holds "K2" k3_holds "K3" k4_holds "K4" k5_holds "K5" k6_holds "K6"
    k7_holds "K7" k8_holds "K8" k9_holds "K9" k10_holds "K10" k11_holds "K11"
    d1_holds "D1" d2_holds "D2" d3_holds "D3"
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The page names every row once, with the name of its test. (Whether its figures are those that
/// come out is what `examples/mission --check` says.)
#[test]
fn the_page_has_every_row_and_no_other() {
    let page = std::fs::read_to_string(root().join("docs/mission.md")).unwrap();
    let heads: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let mut expected = vec!["Where the documents are wrong"];
    expected.extend(ROWS.iter().map(|row| row.number));
    assert_eq!(heads, expected);
    for row in &ROWS {
        assert!(page.contains(&format!("`{}_holds`", row.number.to_lowercase())), "{}", row.number);
        assert!(page.contains(row.describes), "{}", row.number);
    }
}

/// The files that a row points to are there.
#[test]
fn what_the_rows_point_to_exists() {
    let scenarios = root().join("crates/canbaud-sim/scenarios");
    for row in &ROWS {
        for word in row.tested.split([' ', ',', ';', '`']) {
            if word.starts_with("koppe-") && !word.ends_with('-') {
                assert!(scenarios.join(format!("{word}.toml")).exists(), "{}: {word}", row.number);
            }
        }
    }
    for file in [
        "canbaud/tests/trials.rs",
        "canbaud/tests/timing_registers.rs",
        "canbaud/tests/fault.rs",
        "canbaud-sim/tests/around.rs",
        "canbaud-sim/tests/confinement.rs",
    ] {
        assert!(root().join("crates").join(file).exists(), "{file}");
    }
}
