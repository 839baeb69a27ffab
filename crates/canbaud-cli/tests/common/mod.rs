//! Recordings of known frames, and the command to judge them.

#![allow(dead_code, reason = "every test file is a crate of its own and uses its part")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use canbaud::wire::{FdCrc, Frame, FrameKind, Id, Level, encode};

#[cfg(unix)]
pub(crate) mod adapter;

#[path = "../../src/schema.rs"]
pub(crate) mod schema;

/// Nominal bit time of the recordings in ns: 500 kbit/s.
const NOMINAL_NS: u64 = 2_000;
/// Data bit time: 2 Mbit/s.
const DATA_NS: u64 = 500;
/// Idle between frames, and at both ends, in ns.
pub(crate) const GAP_NS: u64 = 40_000;

pub(crate) fn canbaud(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canbaud"));
    command.args(arguments);
    command
}

pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// One frame of every kind that a decoder must print.
pub(crate) fn frames() -> Vec<Frame> {
    let bytes: Vec<u8> = (0..64).map(|i: u8| i.wrapping_mul(37) ^ 0x5A).collect();
    let new = |id, kind, dlc| {
        let length = Frame::data_length(kind, dlc);
        Frame::new(id, kind, dlc, &bytes[..length]).unwrap()
    };
    let fd = |brs| FrameKind::Fd { brs, esi: false };
    vec![
        new(Id::Base(0x123), FrameKind::Data, 4),
        new(Id::Extended(0x18FE_F100), FrameKind::Data, 8),
        new(Id::Base(0x7E0), FrameKind::Remote, 3),
        new(Id::Base(0x0A5), FrameKind::Data, 12),
        new(Id::Base(0x321), fd(false), 5),
        new(Id::Extended(0x0000_0042), fd(true), 15),
    ]
}

/// When the SOF of each frame of [`vcd`] begins, in ns.
pub(crate) fn starts(frames: &[Frame]) -> Vec<u64> {
    let mut at = GAP_NS;
    frames
        .iter()
        .map(|frame| {
            let start = at;
            at += levels(frame).iter().map(|(_, ns)| ns).sum::<u64>() + GAP_NS;
            start
        })
        .collect()
}

/// The levels of a frame on the wire, acknowledged, with how long each bit lasts.
fn levels(frame: &Frame) -> Vec<(Level, u64)> {
    let encoded = encode(frame, FdCrc::Iso).acknowledged();
    encoded
        .bits
        .iter()
        .enumerate()
        .map(|(index, level)| {
            let ns = match encoded.brs {
                // Both sample points at 80 %: the rate switches there.
                Some(brs) if index == brs => (NOMINAL_NS * 8 + DATA_NS * 2) / 10,
                Some(_) if index == encoded.crc_delimiter => (DATA_NS * 8 + NOMINAL_NS * 2) / 10,
                Some(brs) if index > brs && index < encoded.crc_delimiter => DATA_NS,
                _ => NOMINAL_NS,
            };
            (level, ns)
        })
        .collect()
}

/// A recording of `frames` on channel RX, with an idle channel beside it.
pub(crate) fn vcd(frames: &[Frame]) -> String {
    let mut text = String::from(
        "$timescale 1 ns $end $scope module top $end $var wire 1 ! RX $end \
         $var wire 1 \" LED $end $upscope $end $enddefinitions $end\n#0 1! 0\"\n",
    );
    let mut at = GAP_NS;
    let mut last = Level::Recessive;
    for frame in frames {
        for (level, ns) in levels(frame) {
            if level != last {
                let bit = if level == Level::Recessive { 1 } else { 0 };
                let _ = writeln!(text, "#{at} {bit}!");
                last = level;
            }
            at += ns;
        }
        at += GAP_NS;
    }
    let _ = writeln!(text, "#{at}");
    text
}

/// Writes a file and gives its path.
pub(crate) fn file(directory: &Path, name: &str, content: &str) -> PathBuf {
    let path = directory.join(name);
    std::fs::write(&path, content).unwrap();
    path
}

/// A pipe that nobody reads: it takes a page more, and then nothing.
#[cfg(unix)]
pub(crate) fn unread() -> (std::io::PipeReader, std::io::PipeWriter) {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use std::io::{Read, Write};
    let (mut reader, mut writer) = std::io::pipe().unwrap();
    let page = [b'\n'; 4096];
    while poll(&mut [PollFd::new(&writer, PollFlags::OUT)], Some(&Timespec::default())) == Ok(1) {
        writer.write_all(&page).unwrap();
    }
    reader.read_exact(&mut page.clone()).unwrap();
    (reader, writer)
}

/// Fills what is left of the page; goes on until the reader is gone.
#[cfg(unix)]
pub(crate) fn fill(mut writer: std::io::PipeWriter) {
    use std::io::Write;
    std::thread::spawn(move || while writer.write_all(&[b'\n'; 64]).is_ok() {});
    std::thread::sleep(std::time::Duration::from_millis(500));
}

/// The exit code of a process that has to end now.
#[cfg(unix)]
#[track_caller]
pub(crate) fn code(child: &mut std::process::Child) -> Option<i32> {
    for _ in 0..1500 {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().unwrap();
    panic!("it does not end");
}

/// Whether these tests run where a signal is ignored (in the background of a shell, under `nohup`),
/// which what they start takes over.
pub(crate) fn is_ignored(number: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.map_or(0, |mask| u64::from_str_radix(mask.trim(), 16).unwrap());
    if mask >> (number - 1) & 1 == 1 {
        eprintln!("not run: signal {number} is ignored here");
    }
    mask >> (number - 1) & 1 == 1
}
