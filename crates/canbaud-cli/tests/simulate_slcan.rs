//! `canbaud simulate --slcan`: the log that it writes, and the adapter that goes away.
#![cfg(unix)]

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdout, Command, Stdio};

const TALKING: &str = "
title = 'a talker'
duration = '60s'
[[node]]
name = 'talker'
bitrate = '250k'
[[node]]
name = 'partner'
bitrate = '250k'
[[node]]
name = 'adapter'
bitrate = '250k'
[[traffic]]
node = 'talker'
kind = 'periodic'
period = '5ms'
id = 0x123
dlc = 4
payload = 'counter'
";

/// A running adapter and the host's side of it.
struct Server {
    process: Child,
    output: BufReader<ChildStdout>,
    port: File,
    directory: tempfile::TempDir,
}

impl Server {
    fn start(args: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("bus.toml"), TALKING).unwrap();
        let mut process = Command::new(env!("CARGO_BIN_EXE_canbaud"))
            .args(["simulate", "--slcan", "adapter", "bus.toml"])
            .args(args)
            .current_dir(&directory)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(process.stdout.take().unwrap());
        let mut path = String::new();
        output.read_line(&mut path).unwrap();
        let port = OpenOptions::new().read(true).write(true).open(path.trim()).unwrap();
        Self { process, output, port, directory }
    }

    fn say(&mut self, commands: &str) {
        self.port.write_all(commands.replace(' ', "\r").as_bytes()).unwrap();
    }

    /// Everything up to the end, which is what a serial port says that was unplugged.
    fn read_to_the_end(&mut self) -> Vec<u8> {
        let mut all = Vec::new();
        let mut buffer = [0; 256];
        loop {
            match self.port.read(&mut buffer) {
                Ok(0) => return all,
                Ok(count) => all.extend(&buffer[..count]),
                // EIO, on some systems.
                Err(_) => return all,
            }
        }
    }

    /// Reads until `text` came.
    fn read_until(&mut self, text: &str) {
        let mut all = Vec::new();
        let mut byte = [0];
        while !all.ends_with(text.as_bytes()) {
            self.port.read_exact(&mut byte).unwrap();
            all.push(byte[0]);
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn adapter_that_is_unplugged_in_mid_record_ends_the_port_and_the_program() {
    for limit in [1_u64, 60, 1_000] {
        let mut server = Server::start(&["--unplug-after-bytes", &limit.to_string()]);
        server.say("C S5 L ");
        let read = server.read_to_the_end();
        // A hang-up may throw away what was not read yet.
        assert!(read.len() as u64 <= limit, "{limit}: {}", read.len());
        assert!(server.process.wait().unwrap().success());
        assert!(server.port.write_all(b"C\r").is_err());
    }
}

#[test]
fn adapter_that_is_unplugged_after_a_time_ends_the_port_and_the_program() {
    let mut server = Server::start(&["--unplug-after", "1500ms", "--log", "log"]);
    server.say("C S6 L ");
    server.read_to_the_end();
    assert!(server.process.wait().unwrap().success());
    let log = std::fs::read_to_string(server.directory.path().join("log")).unwrap();
    let lines: Vec<_> = log.lines().map(|line| line.split_once(' ').unwrap().1).collect();
    assert_eq!(lines, ["C: refused", "S6: set", "L: open listen-only"]);
}

#[test]
fn log_tells_whether_the_bus_was_disturbed_while_the_program_runs() {
    for (commands, want) in [
        ("S6 L ", "L: open listen-only"),
        ("S5 O ", "! frame acknowledged"),
        ("S6 O ", "! error flag on the bus"),
    ] {
        let mut server = Server::start(&["--log", "-"]);
        server.say(commands);
        let mut log = String::new();
        while !log.trim_end().ends_with(want) {
            assert_ne!(server.output.read_line(&mut log).unwrap(), 0, "{log}");
        }
        assert_eq!(log.contains('!'), want.starts_with('!'), "{log}");
    }
}

#[test]
fn firmware_and_m1_are_those_that_were_asked_for() {
    for (args, commands, want) in [
        (&["--firmware", "canable1"][..], "V ", "canable-fw.git\r"),
        (&["--firmware", "canable2"], "V ", "VL2K1\r"),
        (&["--firmware", "canable2-stock"], "V ", "canable2-fw.git\r"),
        (&["--firmware", "usbtin"], "V ", "V0100\r"),
        (&[], "V ", "V1013\r"),
        (&["--errors", "records"], "S6 L ", "\re1s\r"),
        (&["--firmware", "canable1"], "S5 M1 O ", "\rt1234"),
    ] {
        let mut server = Server::start(args);
        server.say(commands);
        server.read_until(want);
    }
    let mut server = Server::start(&["--firmware", "canable1", "--m1", "ignored", "--log", "-"]);
    server.say("S6 M1 O ");
    let mut log = String::new();
    while !log.contains("error flag") {
        assert_ne!(server.output.read_line(&mut log).unwrap(), 0, "{log}");
    }
    assert!(log.contains("O: open normal"), "{log}");
}
