//! `canbaud decode` on recordings of known frames.

mod common;

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use canbaud::wire::{Frame, FrameKind, Id};
use common::{canbaud, command, file, frames, schema, starts, stderr, stdout, vcd};

/// The part of a candump line behind the interface, put together by hand.
fn log_body(frame: &Frame) -> String {
    let id = match frame.id() {
        Id::Base(id) => format!("{id:03X}"),
        Id::Extended(id) => format!("{id:08X}"),
    };
    let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
    match frame.kind() {
        FrameKind::Data => format!("{id}#{data}"),
        FrameKind::Remote => format!("{id}#R{}", frame.dlc()),
        FrameKind::Fd { brs: false, .. } => format!("{id}##4{data}"),
        FrameKind::Fd { brs: true, .. } => format!("{id}##5{data}"),
    }
}

#[test]
fn candump_lines_are_the_frames_in_order() {
    let directory = tempfile::tempdir().unwrap();
    let frames = frames();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames));
    let output = canbaud(&["decode", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let wanted: String = frames
        .iter()
        .zip(starts(&frames))
        .map(|(frame, ns)| {
            format!("(0000000000.{:06}) can0 {}\n", (ns + 500) / 1_000, log_body(frame))
        })
        .collect();
    assert_eq!(stdout(&output), wanted);
    assert!(stderr(&output).contains("channel RX: 500 kbit/s, CAN FD data 2 Mbit/s"));
}

#[test]
fn start_raw_dlc_and_quiet_do_what_they_say() {
    let directory = tempfile::tempdir().unwrap();
    let frames = frames();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames));
    let path = path.to_str().unwrap();
    let output = canbaud(&["decode", "-q", "-8", "--start", "1700000000", path]);
    assert_eq!(stderr(&output), "");
    let text = stdout(&output);
    assert!(text.starts_with("(1700000000.000040) can0 123#"), "{text}");
    let long = log_body(&frames[3]) + "_C";
    assert!(text.lines().any(|line| line.ends_with(&long)), "{text}");
}

#[test]
fn json_lines_fit_the_schema_and_the_frames() {
    let directory = tempfile::tempdir().unwrap();
    let frames = frames();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames));
    let output = canbaud(&["decode", "--json", path.to_str().unwrap()]);
    let objects: Vec<serde_json::Value> =
        stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(objects.len(), frames.len());
    for ((object, frame), ns) in objects.iter().zip(&frames).zip(starts(&frames)) {
        schema::assert_valid(schema::DECODE, object);
        assert_eq!(object["id"], frame.id().raw());
        assert_eq!(object["dlc"], frame.dlc());
        assert_eq!(object["fd"], frame.kind().is_fd());
        assert_eq!(object["ack"], true);
        let seconds = object["t"].as_f64().unwrap();
        assert!((seconds - ns as f64 * 1e-9).abs() < 1e-12, "{seconds} for {ns} ns");
    }
}

#[test]
fn pcapng_goes_to_a_file_that_is_not_the_capture() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames()));
    let path = path.to_str().unwrap();
    let target = directory.path().join("bus.pcapng");
    let output = canbaud(&["decode", "-f", "pcapng", "-o", target.to_str().unwrap(), path]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let bytes = std::fs::read(&target).unwrap();
    assert_eq!(bytes[..4], [0x0A, 0x0D, 0x0D, 0x0A]);
    let before = std::fs::read(path).unwrap();
    let output = canbaud(&["decode", "-o", path, path]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("would overwrite the capture itself"));
    assert_eq!(std::fs::read(path).unwrap(), before);
}

#[test]
fn unwritable_output_is_one_line_and_code_5() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), "bus.vcd", &vcd(&frames()));
    let target = directory.path().join("missing/bus.log");
    let output = canbaud(&["decode", "-o", target.to_str().unwrap(), path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(5));
    assert_eq!(stderr(&output).lines().count(), 1, "{}", stderr(&output));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let directory = tempfile::tempdir().unwrap();
    // Far more than a pipe holds.
    let many: Vec<Frame> = frames().into_iter().cycle().take(8_000).collect();
    let path = file(directory.path(), "bus.vcd", &vcd(&many));
    for form in ["candump", "json"] {
        let mut child = command(&["decode", "-f", form, path.to_str().unwrap()])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut first = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{form}");
        assert_eq!(stderr(&output), "", "{form}");
        assert!(!first.is_empty());
    }
}
