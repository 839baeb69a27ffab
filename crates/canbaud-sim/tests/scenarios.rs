//! Every scenario of the library runs under all checkers and meets its expectations.

use std::collections::BTreeSet;
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
        if scenario.needs_software() {
            // Run by canbaud-lab, which has it.
            let error = Run::new(&scenario, scenario.seed).unwrap_err().to_string();
            assert!(error.contains("nobody supplies its software"), "{error}");
            continue;
        }
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
        (format!("{node}autonomous = {{ start_up = 'mini-master' }}\n"), 3, "needs a bitrate"),
        (format!("{node}autonomous = {{ listener = 'none' }}\n"), 3, "could never find a bitrate"),
        (format!("{node}autonomous = {{ timer = '1k' }}\n"), 3, "allowed are 1M to 200M"),
        (format!("{node}autonomous = {{ node_id = 128 }}\n"), 3, "allowed are 1 to 127"),
        (format!("{node}mode = 'normal'\nautonomous = {{}}\n"), 3, "mode is decided by"),
        (format!("{node}bitrate = '100k'\nautonomous = {{}}\n"), 3, "bitrate is 100k, allowed"),
        (
            format!("{node}autonomous = {{}}\n[[change]]\nat = '1ms'\nnode = 'a'\nppm = 1\n"),
            6,
            "only power can be changed",
        ),
        (
            format!("{node}bitrate = '1M'\n[[change]]\nat = '1ms'\nnode = 'a'\npower = 'off'\n"),
            6,
            "power is of autonomous nodes",
        ),
        (
            format!("{node}autonomous = {{}}\n[[traffic]]\nnode = 'a'\nkind = 'single'\n"),
            6,
            "give it pdo, sync or heartbeat",
        ),
    ] {
        let error = complaint(&format!("{HEAD}{body}"));
        assert!(error.starts_with(&format!("bad.toml:{line}: ")), "{error}");
        assert!(error.contains(part), "{error}");
    }
}

/// The keys that a table allows, as the reader itself says when it meets one that it does not know.
fn allowed_keys(before: &str) -> BTreeSet<String> {
    let error = complaint(&format!("{HEAD}{before}"));
    let list = error.split_once("expected one of ").expect(&error).1;
    list.split(", ").map(|key| key.trim().trim_matches('`').to_owned()).collect()
}

#[test]
fn schema_and_documentation_have_every_key_and_no_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let schema = std::fs::read_to_string(root.join("schemas/scenario.schema.json")).unwrap();
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    let documentation = std::fs::read_to_string(root.join("docs/scenarios.md")).unwrap();
    let keys = |table: &serde_json::Value| -> BTreeSet<String> {
        table["properties"].as_object().unwrap().keys().cloned().collect()
    };
    let node = &schema["$defs"]["node"];
    let a = "[[node]]\nname = 'a'\n";
    for (table, text) in [
        (&schema, "zzz = 1\n".to_owned()),
        (node, format!("{a}zzz = 1\n")),
        (&schema["$defs"]["timing"], format!("{a}timing = {{ zzz = 1 }}\n")),
        (&node["properties"]["delay"], format!("{a}delay = {{ zzz = 1 }}\n")),
        (&node["properties"]["lss"], format!("{a}lss = {{ zzz = 1 }}\n")),
        (&node["properties"]["autobaud"], format!("{a}autobaud = {{ zzz = 1 }}\n")),
        (&node["properties"]["autonomous"], format!("{a}autonomous = {{ zzz = 1 }}\n")),
        (&schema["$defs"]["silence"], format!("{a}autonomous = {{ silence = {{ zzz = 1 }} }}\n")),
        (&schema["$defs"]["traffic"], format!("{a}[[traffic]]\nzzz = 1\n")),
        (&schema["$defs"]["disturbance"], format!("{a}[[disturbance]]\nzzz = 1\n")),
        (&schema["$defs"]["change"], format!("{a}[[change]]\nzzz = 1\n")),
        (&schema["$defs"]["expect"], format!("{a}[[expect]]\nzzz = 1\n")),
    ] {
        let allowed = allowed_keys(&text);
        assert_eq!(keys(table), allowed, "{text}");
        for key in &allowed {
            let named = documentation.contains(&format!("`{key}`"))
                || documentation.contains(&format!("[[{key}]]"))
                || documentation.contains(&format!("{key},"))
                || documentation.contains(&format!("{key} "));
            assert!(named, "docs/scenarios.md does not name {key}");
        }
    }
}
