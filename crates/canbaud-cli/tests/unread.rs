//! Whoever does not read what is printed does not hold the adapter.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

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

struct Adapter {
    process: Child,
    channel: String,
    log: PathBuf,
    _directory: tempfile::TempDir,
}

impl Adapter {
    fn start() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("adapter.log");
        std::fs::write(directory.path().join("bus.toml"), SILENT).unwrap();
        let mut process = common::command(&["simulate", "bus.toml", "-q", "--slcan", "adapter"])
            .args(["--log", "adapter.log"])
            .current_dir(&directory)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut path = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
        let channel = format!("slcan:{}", path.trim());
        Self { process, channel, log, _directory: directory }
    }

    fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap()
    }

    /// Waits for a line of the log.
    #[track_caller]
    fn wait_for(&self, what: &str) {
        for _ in 0..1500 {
            if self.log().contains(what) {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("no {what}: {}", self.log());
    }

    /// Between two rates it is closed for a moment only.
    #[track_caller]
    fn wait_until_it_stays_closed(&self) {
        let mut closed = 0;
        for _ in 0..1500 {
            closed = if self.log().ends_with(" C: closed\n") { closed + 1 } else { 0 };
            if closed == 50 {
                return;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("it stays open: {}", self.log());
    }

    #[track_caller]
    fn assert_closed(&self) {
        assert!(self.log().ends_with(" C: closed\n"), "{}", self.log());
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn terminate(child: &Child) {
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-s", "TERM", &pid]).status().unwrap().success());
}

#[test]
fn a_signal_ends_a_scan_that_nobody_reads() {
    for stream in ["stdout", "stderr"] {
        let adapter = Adapter::start();
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
    let adapter = Adapter::start();
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
    let adapter = Adapter::start();
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
