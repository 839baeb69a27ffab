//! Every scenario of the library runs under all checkers and meets its expectations.

use std::path::{Path, PathBuf};

use canbaud_sim::check::Checker;
use canbaud_sim::scenario::{Run, Scenario};

fn library() -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let entries = std::fs::read_dir(directory).unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    files
}

#[test]
fn every_scenario_meets_its_expectations_under_all_checkers() {
    let files = library();
    assert!(files.len() >= 18, "{} scenarios", files.len());
    let mut misses = Vec::new();
    for path in files {
        let scenario = Scenario::read(&path).unwrap();
        let mut run = Run::new(&scenario, scenario.seed).unwrap();
        let mut checker = Checker::new(run.sim());
        run.finish(&mut checker);
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        misses.extend(run.misses().iter().map(|miss| format!("{name}: {miss}")));
        misses.extend(checker.first().iter().take(3).map(|v| format!("{name}: {v}")));
        assert_eq!(run.sim().now(), run.end());
    }
    assert!(misses.is_empty(), "{}", misses.join("\n"));
}

#[test]
fn same_seed_same_statistics_other_seed_others() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/koppe-configuration-2.toml");
    let scenario = Scenario::read(&path).unwrap();
    let statistics = |seed| {
        let mut run = Run::new(&scenario, seed).unwrap();
        run.finish(&mut canbaud_sim::Blind);
        run.statistics().clone()
    };
    assert_eq!(statistics(3), statistics(3));
    assert_ne!(statistics(3).edges, statistics(4).edges);
}

/// Line and complaint for a scenario with one mistake.
fn complaint(text: &str) -> String {
    let error = Scenario::parse("bad.toml", text).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

const HEAD: &str = "title = 't'\nduration = '1ms'\n";

#[test]
fn mistakes_are_named_with_file_line_and_allowed_values() {
    let node = "[[node]]\nname = 'a'\n";
    for (body, line, part) in [
        (
            format!("{node}bitrate = '500k'\nmode = 'silent'\n"),
            6,
            "expected one of `normal`, `bus-monitoring`",
        ),
        (format!("{node}bitrate = '500x'\n"), 5, "write 500k"),
        (format!("{node}bitrate = '3M'\nclock = '16M'\n"), 3, "cannot make 3000000 bit/s"),
        (format!("{node}bitrate = '500k'\nsjw = 9\n"), 3, "sjw is 9, allowed are 1 to 2"),
        (format!("{node}bitrate = '500k'\nclock = '10'\n"), 3, "1 kHz to 1 GHz"),
        (node.to_owned(), 3, "needs bitrate or timing"),
        (format!("{node}bitrate = '500k'\n{node}bitrate = '1M'\n"), 6, "two nodes \"a\""),
        (
            format!("{node}bitrate = '500k'\n[[traffic]]\nnode = 'b'\nkind = 'single'\n"),
            6,
            "there are: a",
        ),
        (
            format!(
                "{node}bitrate = '500k'\n[[traffic]]\nnode = 'a'\nkind = 'single'\nid = 0x800\n"
            ),
            6,
            "allowed are 0 to 0x7FF",
        ),
        (
            format!(
                "{node}bitrate = '500k'\n[[traffic]]\nnode = 'a'\nkind = 'single'\npayload = 'x'\n"
            ),
            6,
            "allowed are random, zeros, ones",
        ),
        (
            format!("{node}bitrate = '500k'\n[[traffic]]\nnode = 'a'\nkind = 'single'\ndlc = 16\n"),
            6,
            "allowed are 0 to 15",
        ),
        (format!("{node}bitrate = '500k'\nautobaud = {{ rates = [] }}\n"), 3, "at least one"),
        (format!("{node}bitrate = 500k\n"), 5, ""),
    ] {
        let error = complaint(&format!("{HEAD}{body}"));
        assert!(error.starts_with(&format!("bad.toml:{line}: ")), "{error}");
        assert!(error.contains(part), "{error}");
    }
}
