//! `canbaud simulate` as its users meet it, and what other people's tools make of its output.

mod common;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use common::schema;

fn canbaud() -> Command {
    Command::new(env!("CARGO_BIN_EXE_canbaud"))
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../canbaud-sim/scenarios").join(name)
}

fn simulate(name: &str, args: &[&str]) -> Output {
    canbaud().arg("simulate").arg(scenario(name)).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The scenario `body` in a directory of its own.
fn written(body: &str) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("bus.toml");
    std::fs::write(&path, body).unwrap();
    (directory, path)
}

const THREE_FRAMES: &str = "
title = 'three frames'
duration = '20ms'
[[node]]
name = 'a'
bitrate = '500k'
data_bitrate = '2M'
[[node]]
name = 'b'
bitrate = '500k'
data_bitrate = '2M'
[[traffic]]
node = 'a'
kind = 'single'
start = '1ms'
id = 0x123
dlc = 3
payload = 'hex:DEADBE'
[[traffic]]
node = 'b'
kind = 'single'
start = '2ms'
id = 0x1ABCDEF0
extended = true
dlc = 8
payload = 'zeros'
[[traffic]]
node = 'a'
kind = 'single'
start = '3ms'
id = 0x7FF
format = 'remote'
";

#[test]
fn timeline_tells_the_story() {
    let output = simulate("silence-then-one-frame.toml", &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let story = text(&output.stdout);
    assert!(story.contains("talker   sends     2A5 [8]"), "{story}");
    assert!(story.contains("right    received  2A5 [8]"), "{story}");
    assert!(story.contains("wrong    stuff error as receiver"), "{story}");
}

#[test]
fn json_statistics_are_those_of_the_run() {
    let output = simulate("lone-talker.toml", &["--json", "--check"]);
    assert!(output.status.success());
    let statistics: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    schema::assert_valid(schema::SIMULATE, &statistics);
    assert_eq!(statistics["nodes"][0]["tec_max"], 128);
    assert_eq!(statistics["nodes"][0]["state"], "error passive");
    assert_eq!(statistics["nodes"][1]["dominant"], 0);
}

#[test]
fn repeat_sums_up_runs_of_all_seeds() {
    let output = simulate("koppe-configuration-2.toml", &["--repeat", "6", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let sum: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    schema::assert_valid(schema::SIMULATE, &sum);
    assert_eq!(sum["runs"], 6);
    assert_eq!(sum["nodes"][3]["found_bitrate"]["250000"], 6);
    let times = &sum["nodes"][3]["found_at_s"];
    assert!(times["min"].as_f64() < times["max"].as_f64());
}

#[test]
fn missed_expectation_and_bad_scenario_have_exit_codes_of_their_own() {
    let body = format!("{THREE_FRAMES}[[expect]]\nnode = 'b'\nreceived_min = 9\n");
    let (_directory, path) = written(&body);
    let output = canbaud().arg("simulate").arg(&path).arg("-q").output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("received 2, expected at least 9"));
    // What a run missed has its place in the statistics, too.
    let args = ["--repeat", "2", "--json"];
    let output = canbaud().arg("simulate").arg(&path).args(args).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    let sum: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    schema::assert_valid(schema::SIMULATE, &sum);
    assert_eq!(sum["missed"].as_array().unwrap().len(), 2);
    let (_directory, path) = written(&THREE_FRAMES.replace("remote", "remode"));
    let output = canbaud().arg("simulate").arg(&path).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let error = text(&output.stderr);
    let part = "bus.toml:32: unknown variant `remode`, expected one of `data`";
    assert!(error.contains(part), "{error}");
}

#[test]
fn candump_log_has_every_frame_and_can_be_replayed() {
    let (directory, path) = written(THREE_FRAMES);
    let log = directory.path().join("bus.log");
    let status = canbaud().args(["simulate", "-q", "--candump"]).args([&log, &path]).status();
    assert!(status.unwrap().success());
    let lines = std::fs::read_to_string(&log).unwrap();
    let frames: Vec<_> = lines.lines().map(|line| line.rsplit(' ').next().unwrap()).collect();
    assert_eq!(frames, ["123#DEADBE", "1ABCDEF0#0000000000000000", "7FF#R"]);
    let replay = "title = 'again'\nduration = '20ms'\n[[node]]\nname = 'a'\nbitrate = '500k'\n\
         [[node]]\nname = 'b'\nbitrate = '500k'\n[[traffic]]\nnode = 'a'\nkind = 'replay'\n\
         start = '1ms'\nfile = 'bus.log'\n\
         [[expect]]\nnode = 'b'\nreceived_min = 3\nreceived_max = 3\n";
    let again = directory.path().join("again.toml");
    std::fs::write(&again, replay).unwrap();
    assert!(canbaud().args(["simulate", "-q"]).arg(&again).status().unwrap().success());
}

/// Identifier and data of each frame as sigrok's CAN decoder prints them.
fn sigrok(file: &Path, format: &str, channel: &str, nominal: u32) -> Option<Vec<(u32, Vec<u8>)>> {
    let decoder = format!("can:can_rx={channel}:nominal_bitrate={nominal}:fast_bitrate=2000000");
    let output = Command::new("sigrok-cli")
        .args(["-I", format, "-i"])
        .arg(file)
        .args(["-P", &decoder, "-A", "can=id:ext-id:full-id:data"])
        .output();
    let Ok(output) = output else {
        eprintln!("sigrok-cli is absent: nothing was compared with it");
        return None;
    };
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut frames: Vec<(u32, Vec<u8>)> = Vec::new();
    for line in text(&output.stdout).lines() {
        let value = line.rsplit(' ').next().unwrap_or("").trim_matches(['(', ')']);
        let Some(digits) = value.strip_prefix("0x") else { continue };
        let number = u32::from_str_radix(digits, 16).unwrap();
        if line.contains("Full Identifier") {
            frames.last_mut().unwrap().0 = number;
        } else if line.contains("Extended Identifier") {
            // The full identifier follows.
        } else if line.contains("Identifier:") {
            frames.push((number, Vec::new()));
        } else if line.contains("Data byte") {
            frames.last_mut().unwrap().1.push(number as u8);
        }
    }
    Some(frames)
}

/// A busy bus of data frames: what sigrok can read. It cannot read remote frames with a DLC above
/// 0, classic ones with a DLC above 8, CAN FD without a gap, and frames beside errors.
fn busy(rate: &str) -> String {
    let node = |name: &str, ppm: i32| {
        format!("[[node]]\nname = '{name}'\nbitrate = '{rate}'\nppm = {ppm}\n")
    };
    let traffic = |node: &str, period: &str, rest: &str| {
        format!("[[traffic]]\nnode = '{node}'\nkind = 'poisson'\nperiod = '{period}'\n{rest}\n")
    };
    [
        "title = 'busy'\nduration = '300ms'\nseed = 5\n".to_owned(),
        node("a", 300),
        node("b", -300),
        traffic("a", "4ms", "id = 0x123\ndlc = 8\nstop = '280ms'"),
        traffic("b", "5ms", "id = 0x18DAF110\nextended = true\ndlc = 7\nstop = '280ms'"),
        traffic("b", "9ms", "id = 0x555\ndlc = 5\npayload = 'worst-stuffing'\nstop = '280ms'"),
    ]
    .concat()
}

/// Identifier and data of each line of a log.
fn logged(log: &Path) -> Vec<(u32, Vec<u8>)> {
    let frame = |line: &str| {
        let (id, data) = line.rsplit(' ').next().unwrap().split_once('#').unwrap();
        let byte = |at: usize| u8::from_str_radix(&data[2 * at..2 * at + 2], 16).unwrap();
        (u32::from_str_radix(id, 16).unwrap(), (0..data.len() / 2).map(byte).collect())
    };
    std::fs::read_to_string(log).unwrap().lines().map(frame).collect()
}

#[test]
fn sigrok_reads_every_frame_of_a_session() {
    for (rate, nominal) in [("500k", 500_000), ("125k", 125_000), ("1M", 1_000_000)] {
        let (directory, path) = written(&busy(rate));
        let (sr, log) = (directory.path().join("bus.sr"), directory.path().join("bus.log"));
        let status = canbaud()
            .args(["simulate", "-q", "--samplerate", "10M", "--sr"])
            .arg(&sr)
            .arg("--candump")
            .args([&log, &path])
            .status();
        assert!(status.unwrap().success());
        let sent = logged(&log);
        assert!(sent.len() > 100, "{}", sent.len());
        let Some(read) = sigrok(&sr, "srzip", "CAN", nominal) else { return };
        assert_eq!(read, sent, "{rate}");
    }
}

#[test]
fn sigrok_reads_can_fd_frames_with_gaps() {
    let body = "title = 'fd'\nduration = '60ms'\nseed = 5\n\
        [[node]]\nname = 'a'\nbitrate = '1M'\ndata_bitrate = '2M'\nsample_point = 75\n\
        [[node]]\nname = 'b'\nbitrate = '1M'\ndata_bitrate = '2M'\nsample_point = 75\n\
        [[traffic]]\nnode = 'a'\nkind = 'periodic'\nperiod = '4ms'\nstop = '57ms'\n\
        id = 0x123\nformat = 'fd-brs'\ndlc = 8\n\
        [[traffic]]\nnode = 'b'\nkind = 'periodic'\nperiod = '4ms'\nstart = '2ms'\nstop = '57ms'\n\
        id = 0x321\nformat = 'fd'\ndlc = 12\n";
    let (directory, path) = written(body);
    let (sr, log) = (directory.path().join("bus.sr"), directory.path().join("bus.log"));
    let status = canbaud()
        .args(["simulate", "-q", "--samplerate", "40M", "--sr"])
        .arg(&sr)
        .arg("--candump")
        .args([&log, &path])
        .status();
    assert!(status.unwrap().success());
    let lines = std::fs::read_to_string(&log).unwrap().replace("##1", "#").replace("##0", "#");
    std::fs::write(&log, lines).unwrap();
    let sent = logged(&log);
    assert_eq!(sent.len(), 29);
    let Some(read) = sigrok(&sr, "srzip", "CAN", 1_000_000) else { return };
    assert_eq!(read, sent);
}

#[test]
fn sigrok_reads_every_frame_of_a_value_change_dump() {
    let (directory, path) = written(THREE_FRAMES);
    let vcd = directory.path().join("bus.vcd");
    let status = canbaud().args(["simulate", "-q", "--vcd"]).args([&vcd, &path]).status();
    assert!(status.unwrap().success());
    // A sample a nanosecond is more than the decoder has time for.
    let Some(read) = sigrok(&vcd, "vcd:downsample=50", "can.bus", 500_000) else { return };
    let want = [(0x123, vec![0xDE, 0xAD, 0xBE]), (0x1ABC_DEF0, vec![0; 8]), (0x7FF, vec![])];
    assert_eq!(read, want);
}

/// A Python that has python-can and pyserial: `CANBAUD_PYTHON`, or `python3`.
fn python() -> Option<String> {
    let python = std::env::var("CANBAUD_PYTHON").unwrap_or_else(|_| "python3".into());
    let works = Command::new(&python)
        .args(["-c", "import can, serial"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if works {
        return Some(python);
    }
    eprintln!("python-can is absent (set CANBAUD_PYTHON): nothing was compared with it");
    None
}

const TALKING: &str = "
title = 'a talker for python-can'
duration = '20s'
[[node]]
name = 'talker'
bitrate = '250k'
[[node]]
name = 'partner'
bitrate = '250k'
[[node.reply]]
to = 0x321
id = 0x322
data = 'C0FFEE'
[[node]]
name = 'adapter'
bitrate = '250k'
[[traffic]]
node = 'talker'
kind = 'periodic'
period = '20ms'
id = 0x123
dlc = 4
payload = 'counter'
";

const PYTHON: &str = r#"
import can, sys
port = sys.argv[1]
def frames(bitrate, listen_only, wait, send=None):
    bus = can.Bus(interface="slcan", channel=port, bitrate=bitrate, listen_only=listen_only,
                  sleep_after_open=0.1)
    if send: bus.send(send)
    got = []
    for _ in range(8):
        message = bus.recv(wait)
        if message is None: break
        got.append((message.arbitration_id, bytes(message.data)))
    bus.shutdown()
    return got
wrong = frames(500000, True, 0.3)
right = frames(250000, True, 0.5)
asked = can.Message(arbitration_id=0x321, data=[1], is_extended_id=False)
active = frames(250000, False, 0.5, asked)
print("wrong", len(wrong))
print("right", len(right), {i for i, _ in right} == {0x123})
print("reply", (0x322, b"\xc0\xff\xee") in active)
"#;

#[test]
fn python_can_finds_the_rate_through_the_adapter() {
    let Some(python) = python() else { return };
    let all = "wrong 0\nright 8 True\nreply True\n";
    for (args, want) in [
        (&[][..], all),
        (&["--errors", "records"], all),
        (&["--errors", "silent"], all),
        (&["--firmware", "canable2"], all),
        (&["--firmware", "usbtin"], all),
        // There is no L, so listen-only never opens and any rate looks like an idle bus.
        (&["--firmware", "canable1"], "wrong 0\nright 0 False\nreply True\n"),
        (&["--firmware", "canable2-stock"], "wrong 0\nright 0 False\nreply True\n"),
    ] {
        let (_directory, path) = written(TALKING);
        let mut server = canbaud()
            .args(["simulate", "--slcan", "adapter"])
            .args(args)
            .arg(&path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut port = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut port).unwrap();
        let output = Command::new(&python).args(["-c", PYTHON, port.trim()]).output().unwrap();
        server.kill().unwrap();
        server.wait().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(text(&output.stdout), want, "{args:?}");
    }
}
