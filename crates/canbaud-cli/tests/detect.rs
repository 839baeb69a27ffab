//! `canbaud detect` on one and on many files.

mod common;

use std::io::Read;
use std::process::Stdio;

use common::{canbaud, command, file, frames, schema, stderr, stdout, vcd};
use serde_json::Value;

const FLAT: &str =
    "$timescale 1 us $end $var wire 1 ! RX $end $enddefinitions $end\n#0 1!\n#5000\n";

fn objects(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn json_fits_the_schema_with_the_bus_first() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames()));
    let output = canbaud(&["detect", "--json", "--expected", "500k", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
    let objects = objects(&stdout(&output));
    for object in &objects {
        schema::assert_valid(schema::DETECT, object);
    }
    let bus = &objects[0];
    assert_eq!(bus["channel"], "RX");
    assert_eq!(bus["verdict"], "found");
    assert_eq!(bus["nominal"]["bitrate"], 500_000);
    assert_eq!(bus["data"]["bitrate"], 2_000_000);
    let counts = ["classic", "fd", "remote", "error"].map(|kind| &bus["frames"][kind]);
    assert_eq!(counts, [3, 2, 1, 0]);
    assert!(bus["expected"]["deviation_ppm"].as_f64().unwrap().abs() < 1_500.0);
    assert_eq!(objects[1]["channel"], "LED");
    assert_eq!(objects[1]["verdict"], "no_traffic");
}

#[test]
fn no_traffic_has_its_own_exit_code() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "flat.vcd", FLAT);
    let output = canbaud(&["detect", "-q", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(stdout(&output).starts_with("no traffic"), "{}", stdout(&output));
}

#[test]
fn one_bad_file_does_not_stop_the_others() {
    let directory = tempfile::tempdir().unwrap();
    let good = vcd(&frames());
    let mut paths = Vec::new();
    for index in 0..24 {
        let content = match index {
            7 => "",
            11 => FLAT,
            _ => &good,
        };
        let path = file(directory.path(), &format!("{index:02}.vcd"), content);
        paths.push(path.to_str().unwrap().to_owned());
    }
    let mut arguments = vec!["detect", "--json", "--jobs", "4"];
    arguments.extend(paths.iter().map(String::as_str));
    let output = canbaud(&arguments);
    assert_eq!(output.status.code(), Some(5));
    let messages = stderr(&output);
    assert_eq!(messages.lines().count(), 1, "{messages}");
    assert!(messages.contains("07.vcd: the file is empty"), "{messages}");
    let objects = objects(&stdout(&output));
    for object in &objects {
        schema::assert_valid(schema::DETECT, object);
    }
    // In the order given, and every file is there.
    let mut sources: Vec<&str> = objects.iter().map(|o| o["source"].as_str().unwrap()).collect();
    sources.dedup();
    assert_eq!(sources, paths);
    let first = |index: usize| objects.iter().find(|o| o["source"] == paths[index]).unwrap();
    assert_eq!(first(7)["error"], "the file is empty");
    assert_eq!(first(11)["verdict"], "no_traffic");
    assert_eq!(first(23)["verdict"], "found");
}

#[test]
fn unreadable_sources_are_one_line_each() {
    let directory = tempfile::tempdir().unwrap();
    let missing = directory.path().join("missing.sr");
    let folder = directory.path().to_str().unwrap();
    let output = canbaud(&["detect", missing.to_str().unwrap(), folder]);
    assert_eq!(output.status.code(), Some(5));
    assert_eq!(stdout(&output), "");
    let text = stderr(&output);
    assert!(text.contains("missing.sr: cannot open: "), "{text}");
    assert!(text.contains(&format!("{folder}: is a directory")), "{text}");
    assert_eq!(text.lines().filter(|line| line.starts_with("canbaud: ")).count(), 2, "{text}");
}

#[test]
fn no_colours_and_no_bar_in_a_pipe() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames()));
    let output = canbaud(&["detect", path.to_str().unwrap()]);
    assert!(!stdout(&output).contains('\x1b'));
    assert_eq!(stderr(&output), "");
    let output = canbaud(&["detect", "--color", "always", path.to_str().unwrap()]);
    assert!(stdout(&output).starts_with("\x1b["));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames()));
    let path = path.to_str().unwrap();
    let mut arguments = vec!["detect"];
    // Far more text than a pipe holds.
    arguments.resize(401, path);
    let mut child =
        command(&arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut some = [0; 16];
    child.stdout.take().unwrap().read_exact(&mut some).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
}
