//! `canbaud simulate --bridge`: how it leaves the adapter that it transmits on.
#![cfg(unix)]

mod common;

use std::process::{Child, Output, Stdio};

use common::adapter::{Adapter, signal};
use common::stderr;

/// A bus on which somebody talks to a partner.
const BUS: &str = "
title = 'a talker'
duration = '10min'
[[node]]
name = 'talker'
bitrate = '250k'
[[node]]
name = 'partner'
bitrate = '250k'
[[node]]
name = 'end'
bitrate = '250k'
[[traffic]]
node = 'talker'
kind = 'periodic'
period = '20ms'
id = 0x123
dlc = 4
payload = 'counter'
";

fn adapter() -> Adapter {
    Adapter::start(BUS, "end")
}

/// A bridge on it that has sent a frame.
fn bridge(adapter: &Adapter, args: &[&str]) -> Child {
    let line = ["simulate", "bus.toml", "--bridge", "end", "--on", &adapter.channel];
    let child = common::command(&line)
        .args(["--bitrate", "250k", "--transmit"])
        .args(args)
        .current_dir(&adapter.directory)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    adapter.wait_for(": sent");
    child
}

/// It was open, and is closed; nothing follows.
#[track_caller]
fn assert_closed(adapter: &Adapter) {
    assert!(adapter.log().iter().any(|line| line == "O: open normal"), "{:#?}", adapter.log());
    adapter.assert_closed();
}

fn ended_by(name: &str, child: Child) -> Output {
    signal(name, &child);
    child.wait_with_output().unwrap()
}

#[test]
fn signals_close_the_adapter_of_a_bridge() {
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        if common::is_ignored(number) {
            continue;
        }
        let adapter = adapter();
        let output = ended_by(name, bridge(&adapter, &[]));
        assert_eq!(output.status.code(), Some(128 + number), "{}", stderr(&output));
        let said = format!("canbaud: stopped by signal {number}\n");
        assert!(stderr(&output).ends_with(&said), "{}", stderr(&output));
        assert_closed(&adapter);
    }
}

#[test]
fn the_end_of_the_scenario_closes_the_adapter_of_a_bridge() {
    let adapter = adapter();
    let output = bridge(&adapter, &["--for", "1s"]).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_closed(&adapter);
}

#[test]
fn an_adapter_that_cannot_be_closed_is_named_with_the_way_out() {
    let adapter = adapter();
    let child = bridge(&adapter, &[]);
    // It answers nothing any more.
    signal("STOP", &adapter.process);
    let output = ended_by("TERM", child);
    let errors = stderr(&output);
    assert_eq!(output.status.code(), Some(7), "{errors}");
    assert!(errors.contains("could not be put back as it was found: "), "{errors}");
    assert!(errors.contains("  hint: put it back by hand: printf 'C\\r' > /dev/"), "{errors}");
}

#[test]
fn a_channel_that_is_absent_is_no_unreadable_file() {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("bus.toml"), BUS).unwrap();
    let line = ["simulate", "bus.toml", "--bridge", "end", "--on", "slcan:/dev/absent"];
    let output = common::command(&line)
        .args(["--bitrate", "250k", "--transmit"])
        .current_dir(&directory)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(7), "{}", stderr(&output));
}
