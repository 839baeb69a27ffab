//! Whoever does not read what is printed does not hold the adapter.
#![cfg(unix)]

mod common;

use std::process::{Child, Stdio};
use std::time::Duration;

use common::adapter::{Adapter, signal};
use common::{code, fill, unread};

/// A bus that is silent.
const SILENT: &str = "
title = 'a silent bus'
duration = '10min'
[[node]]
name = 'partner'
bitrate = '250k'
[[node]]
name = 'adapter'
bitrate = '250k'
";

fn adapter() -> Adapter {
    Adapter::start(SILENT, "adapter")
}

fn terminate(child: &Child) {
    signal("TERM", child);
}

#[test]
fn a_signal_ends_a_scan_that_nobody_reads() {
    for stream in ["stdout", "stderr"] {
        let adapter = adapter();
        let (reader, writer) = unread();
        let line = ["detect", &adapter.channel, "--timeout", "never", "--pause", "50ms"];
        let mut command = common::command(&line);
        if stream == "stdout" {
            command.arg("--json").stdout(writer.try_clone().unwrap()).stderr(Stdio::null());
        } else {
            command.stdout(Stdio::null()).stderr(writer.try_clone().unwrap());
        }
        let mut child = command.spawn().unwrap();
        adapter.wait_for("L: open listen-only");
        fill(writer);
        terminate(&child);
        assert_eq!(code(&mut child), Some(143), "{stream}");
        adapter.assert_closed();
        drop(reader);
    }
}

#[test]
fn the_time_that_was_given_ends_a_scan_that_nobody_reads() {
    let adapter = adapter();
    let (reader, writer) = unread();
    let mut child = common::command(&["detect", &adapter.channel, "--json", "--timeout", "2s"])
        .args(["--pause", "50ms"])
        .stdout(writer.try_clone().unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    adapter.wait_for("L: open listen-only");
    fill(writer);
    adapter.wait_until_it_stays_closed();
    // The verdict is for a reader who comes late: only that is waited for.
    assert!(child.try_wait().unwrap().is_none());
    drop(reader);
    assert!(code(&mut child).is_some());
    adapter.assert_closed();
}

#[test]
fn a_signal_ends_lss_that_nobody_reads() {
    let adapter = adapter();
    let (reader, writer) = unread();
    let mut child = common::command(&["lss", "serve", "--address", "1:2:3:4", "--count", "100"])
        .args(["--on", &adapter.channel, "--bitrate", "250k", "--transmit"])
        .stdout(writer)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    adapter.wait_for("O: open normal");
    std::thread::sleep(Duration::from_millis(300));
    terminate(&child);
    assert_eq!(code(&mut child), Some(143));
    adapter.assert_closed();
    drop(reader);
}
