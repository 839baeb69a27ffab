//! `canbaud simulate --bridge`: how it leaves the adapter that it transmits on.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

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

/// An adapter on a bus of its own.
struct Adapter {
    process: Child,
    channel: String,
    log: PathBuf,
    directory: tempfile::TempDir,
}

impl Adapter {
    fn start() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("adapter.log");
        std::fs::write(directory.path().join("bus.toml"), BUS).unwrap();
        let mut process = common::command(&["simulate", "bus.toml", "-q", "--slcan", "end"])
            .args(["--log", "adapter.log"])
            .current_dir(&directory)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut path = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
        Self { process, channel: format!("slcan:{}", path.trim()), log, directory }
    }

    /// A bridge on it that has sent a frame.
    fn bridge(&self, args: &[&str]) -> Child {
        let line = ["simulate", "bus.toml", "--bridge", "end", "--on", &self.channel];
        let child = common::command(&line)
            .args(["--bitrate", "250k", "--transmit"])
            .args(args)
            .current_dir(&self.directory)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        while !self.log().iter().any(|line| line.ends_with(": sent")) {
            std::thread::sleep(Duration::from_millis(20));
        }
        child
    }

    fn log(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.log).unwrap();
        text.lines().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
    }

    /// It was open, and is closed; nothing follows.
    #[track_caller]
    fn assert_closed(&self) {
        let log = self.log();
        assert!(log.iter().any(|line| line == "O: open normal"), "{log:#?}");
        assert_eq!(log.last().unwrap(), "C: closed", "{log:#?}");
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn signal(name: &str, process: &Child) {
    let pid = process.id().to_string();
    assert!(Command::new("kill").args(["-s", name, &pid]).status().unwrap().success());
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
        let adapter = Adapter::start();
        let output = ended_by(name, adapter.bridge(&[]));
        assert_eq!(output.status.code(), Some(128 + number), "{}", stderr(&output));
        let said = format!("canbaud: stopped by signal {number}\n");
        assert!(stderr(&output).ends_with(&said), "{}", stderr(&output));
        adapter.assert_closed();
    }
}

#[test]
fn the_end_of_the_scenario_closes_the_adapter_of_a_bridge() {
    let adapter = Adapter::start();
    let output = adapter.bridge(&["--for", "1s"]).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    adapter.assert_closed();
}

#[test]
fn an_adapter_that_cannot_be_closed_is_named_with_the_way_out() {
    let adapter = Adapter::start();
    let child = adapter.bridge(&[]);
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
