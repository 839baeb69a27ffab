use std::path::PathBuf;

use clap::Parser;

use super::*;
use crate::args::{Cli, Command};
use crate::report::samples::{classic, conflict, fd, silent, undecided};

fn arguments(line: &[&str]) -> DetectArgs {
    match Cli::try_parse_from(["canbaud", "detect"].iter().chain(line)).unwrap().command {
        Command::Detect(args) => args,
        _ => unreachable!("detect was asked for"),
    }
}

fn empty() -> Judged {
    Err(CaptureError::Empty)
}

#[test]
fn first_channel_decides_the_exit_code() {
    let args = arguments(&["a.sr"]);
    let exit = |channels: Vec<ChannelReport>| {
        View::new(&args, Paint::Plain).show(0, "a.sr", &Ok(channels)).exit
    };
    assert_eq!(exit(vec![fd(), silent(), undecided()]), Exit::Found);
    assert_eq!(exit(vec![undecided(), silent()]), Exit::Undecided);
    assert_eq!(exit(vec![conflict()]), Exit::Undecided);
    assert_eq!(exit(vec![silent()]), Exit::NoTraffic);
    assert_eq!(exit(vec![]), Exit::NoTraffic);
}

#[test]
fn unreadable_source_names_file_and_reason_and_is_an_object_in_json() {
    let args = arguments(&["--json", "a.sr", "b.sr"]);
    let shown = View::new(&args, Paint::Plain).show(0, "a.sr", &empty());
    assert_eq!(shown.stderr, "canbaud: a.sr: the file is empty\n");
    assert_eq!(shown.stdout, "{\"source\":\"a.sr\",\"error\":\"the file is empty\"}\n");
    assert_eq!(shown.exit, Exit::Unreadable);
}

#[test]
fn json_is_one_line_per_channel_with_the_bus_first() {
    let args = arguments(&["--json", "a.sr"]);
    let shown = View::new(&args, Paint::Plain).show(0, "a.sr", &Ok(vec![fd(), silent()]));
    let channels: Vec<String> = shown
        .stdout
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()["channel"].to_string())
        .collect();
    assert_eq!(channels, ["\"CAN_RX\"", "\"D2\""]);
}

#[test]
fn several_sources_are_named_and_set_apart() {
    let args = arguments(&["a.sr", "b.sr"]);
    let view = View::new(&args, Paint::Plain);
    let first = view.show(0, "a.sr", &Ok(vec![classic()])).stdout;
    let second = view.show(1, "b.sr", &Ok(vec![classic()])).stdout;
    assert!(first.starts_with("a.sr: 125 kbit/s"));
    assert!(second.starts_with("\nb.sr: 125 kbit/s"));
    let quiet = arguments(&["-q", "a.sr", "b.sr"]);
    let brief = View::new(&quiet, Paint::Plain).show(1, "b.sr", &Ok(vec![classic()])).stdout;
    assert_eq!(brief, "b.sr: 125 kbit/s — proven by 286 frames\n");
}

#[test]
fn jobs_default_to_the_cores() {
    assert_eq!(threads(&arguments(&["-j", "3", "a.sr"])), 3);
    assert!(threads(&arguments(&["a.sr"])) >= 1);
    assert_eq!(arguments(&["a", "b"]).sources, [PathBuf::from("a"), PathBuf::from("b")]);
}
