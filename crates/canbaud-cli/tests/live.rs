//! `canbaud detect` on a virtual slcan adapter: verdicts, events, signals, and the adapter's log.
#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// A bus at 250 kbit/s; `period` is the time between two frames.
fn bus(period: &str) -> String {
    format!(
        "title = 'a talker'\nduration = '60s'\n\
         [[node]]\nname = 'talker'\nbitrate = '250k'\n\
         [[node]]\nname = 'partner'\nbitrate = '250k'\n\
         [[node]]\nname = 'adapter'\nbitrate = '250k'\n\
         [[traffic]]\nnode = 'talker'\nkind = 'periodic'\nperiod = '{period}'\nid = 0x123\n\
         dlc = 4\npayload = 'counter'\n"
    )
}

/// A running adapter.
struct Adapter {
    process: Child,
    source: String,
    log: PathBuf,
    _directory: tempfile::TempDir,
}

impl Adapter {
    fn start(period: &str, args: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let log = directory.path().join("adapter.log");
        std::fs::write(directory.path().join("bus.toml"), bus(period)).unwrap();
        let mut process = Command::new(env!("CARGO_BIN_EXE_canbaud"))
            .args(["simulate", "--quiet", "--slcan", "adapter", "--log"])
            .arg(&log)
            .args(args)
            .arg("bus.toml")
            .current_dir(&directory)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut path = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
        let source = format!("slcan:{}", path.trim());
        Self { process, source, log, _directory: directory }
    }

    fn detect(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_canbaud"));
        command.args(["detect", &self.source]).args(args);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Everything that the adapter was told and did, without the times.
    fn log(mut self) -> Vec<String> {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
        let text = std::fs::read_to_string(&self.log).unwrap();
        text.lines().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// It listened, did nothing else, and closed behind itself.
#[track_caller]
fn assert_only_listened(log: &[String]) {
    for line in log {
        let bad = line.starts_with('!') || line.ends_with(": sent") || line.contains("open normal");
        assert!(!bad, "{line} in {log:#?}");
    }
    assert!(log.iter().any(|line| line == "L: open listen-only"), "{log:#?}");
    assert_eq!(log.last().unwrap(), "C: closed", "{log:#?}");
}

#[test]
fn a_rate_is_found_and_shown_like_that_of_a_capture() {
    let adapter = Adapter::start("5ms", &[]);
    let output = adapter.detect(&["--rates", "500k,250k,125k"]).output().unwrap();
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}{}", stderr(&output));
    assert!(text.starts_with("250 kbit/s — proven by "), "{text}");
    for part in ["adapter      /dev/", "nominal      250 kbit/s", "took ", "tried "] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(text.contains("ip link set can0 type can bitrate 250000 sample-point 0.875"), "{text}");
    assert_only_listened(&adapter.log());
}

#[test]
fn quiet_is_the_verdict_alone() {
    let adapter = Adapter::start("5ms", &[]);
    let output = adapter.detect(&["--quiet", "--rates", "250k"]).output().unwrap();
    let text = stdout(&output);
    assert!(text.starts_with("250 kbit/s") && text.lines().count() == 1, "{text}");
    assert_eq!(stderr(&output), "");
}

#[test]
fn events_come_a_line_each_and_end_with_the_verdict() {
    let adapter = Adapter::start("5ms", &[]);
    let output = adapter.detect(&["--json", "--rates", "canopen"]).output().unwrap();
    let events: Vec<Value> =
        stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events[0]["event"], "start");
    assert_eq!(events[0]["candidates"].as_array().unwrap().len(), 8);
    assert!(events.iter().any(|event| event["event"] == "listening"));
    let verdict = events.last().unwrap();
    assert_eq!((&verdict["event"], &verdict["verdict"]), (&"verdict".into(), &"found".into()));
    assert_eq!(verdict["found"]["nominal"], 250_000);
    assert_eq!(stderr(&output), "");
    assert_only_listened(&adapter.log());
}

/// A visit counts while it is under way, and as it is broken off.
#[test]
fn time_under_way_is_time_listened() {
    let adapter = Adapter::start("40ms", &[]);
    let args = ["--json", "--rates", "500k", "--timeout", "1s"];
    let output = adapter.detect(&args).output().unwrap();
    let text = stdout(&output);
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let last = events.iter().rfind(|event| event["event"] == "evidence").unwrap();
    let (t, listened) =
        (last["t"].as_f64().unwrap(), last["standing"]["listened_s"].as_f64().unwrap());
    assert!(listened > 0.0 && listened <= t, "{text}");
    let verdict = events.last().unwrap();
    let tried = verdict["tried"][0]["listened_s"].as_f64().unwrap();
    assert!(tried > listened / 2.0 && tried <= verdict["elapsed_s"].as_f64().unwrap(), "{text}");
}

#[test]
fn a_sweep_finds_a_rate_that_is_in_no_list() {
    let adapter = Adapter::start("5ms", &[]);
    let output = adapter.detect(&["--json", "--sweep", "150k..350k"]).output().unwrap();
    let text = stdout(&output);
    let verdict: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert_eq!(verdict["found"]["nominal"], 250_000, "{text}");
    assert_only_listened(&adapter.log());
}

#[test]
fn signals_in_mid_scan_close_the_channel() {
    for (name, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        if common::is_ignored(code - 128) {
            continue;
        }
        // Nobody talks: the scan goes on.
        let adapter = Adapter::start("50s", &[]);
        let mut command = adapter.detect(&["--json", "--timeout", "never"]);
        let mut child = command.spawn().unwrap();
        let mut events = BufReader::new(child.stdout.take().unwrap()).lines();
        // It listens, for the second time.
        for _ in 0..2 {
            events.find(|line| line.as_ref().unwrap().contains("\"listening\"")).unwrap().unwrap();
        }
        signal(name, &child);
        let rest = std::thread::spawn(move || events.count());
        let status = child.wait().unwrap();
        rest.join().unwrap();
        assert_eq!(status.code(), Some(code), "SIG{name}");
        assert_only_listened(&adapter.log());
    }
}

/// As `nohup` starts it.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_it_was_started_to_ignore_is_ignored() {
    let adapter = Adapter::start("50s", &[]);
    let script = "trap '' HUP; exec \"$0\" detect \"$1\" --json --timeout never";
    let mut child = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_canbaud"), &adapter.source])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut events = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut listens = || {
        let found = events.find(|line| line.as_ref().unwrap().contains("\"listening\""));
        found.map(|line| line.unwrap())
    };
    listens().unwrap();
    signal("HUP", &child);
    // It goes on listening, at one rate after the other.
    for _ in 0..3 {
        assert!(listens().is_some());
    }
    signal("TERM", &child);
    let rest = std::thread::spawn(move || events.count());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    rest.join().unwrap();
    assert_only_listened(&adapter.log());
}

fn signal(name: &str, process: &Child) {
    let pid = process.id().to_string();
    assert!(Command::new("kill").args(["-s", name, &pid]).status().unwrap().success());
}

/// Waits until it listens, and reads on so that nothing is held up.
fn listens(child: &mut Child) -> std::thread::JoinHandle<usize> {
    let mut events = BufReader::new(child.stdout.take().unwrap()).lines();
    events.find(|line| line.as_ref().unwrap().contains("\"listening\"")).unwrap().unwrap();
    std::thread::spawn(move || events.count())
}

#[test]
fn a_signal_does_not_hide_that_the_adapter_was_not_put_back() {
    let adapter = Adapter::start("50s", &[]);
    let mut child = adapter.detect(&["--json", "--timeout", "never"]).spawn().unwrap();
    let rest = listens(&mut child);
    // It answers nothing any more.
    signal("STOP", &adapter.process);
    signal("TERM", &child);
    let output = child.wait_with_output().unwrap();
    rest.join().unwrap();
    let errors = stderr(&output);
    assert_eq!(output.status.code(), Some(7), "{errors}");
    assert!(errors.contains("could not be put back as it was found: "), "{errors}");
    assert!(errors.contains("  hint: put it back by hand: "), "{errors}");
    assert!(!errors.contains("; put back as it was found"), "{errors}");
}

#[test]
fn what_was_put_back_is_said() {
    let adapter = Adapter::start("50s", &[]);
    let mut child = adapter.detect(&["--json", "--timeout", "never"]).spawn().unwrap();
    let rest = listens(&mut child);
    signal("TERM", &child);
    let output = child.wait_with_output().unwrap();
    rest.join().unwrap();
    assert!(
        stderr(&output).ends_with(": stopped by signal 15; put back as it was found\n"),
        "{}",
        stderr(&output)
    );
    assert_only_listened(&adapter.log());
}

/// Trap: printing to a pipe that nobody reads panics unless it is told not to.
#[test]
fn nobody_reads_what_is_printed_and_the_adapter_is_closed_all_the_same() {
    for (redirections, code) in [
        // Closed, a pipe without a reader, a full disk.
        ("2>&-", 0),
        (">&-", 0),
        ("2>&- >&-", 0),
        ("2> >(true)", 0),
        ("> >(true)", 0),
        ("2> >(true) > >(true)", 0),
        ("2>/dev/full", 0),
        (">/dev/full", 5),
    ] {
        if redirections.contains("/dev/full") && !std::path::Path::new("/dev/full").exists() {
            continue;
        }
        let adapter = Adapter::start("5ms", &[]);
        // The readers are gone when the scan begins.
        let script =
            format!("exec {redirections}; sleep 0.2; exec \"$0\" detect \"$1\" --rates 500k,250k");
        let output = Command::new("bash")
            .args(["-c", &script, env!("CARGO_BIN_EXE_canbaud"), &adapter.source])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(code), "{redirections}: {}", stderr(&output));
        assert_only_listened(&adapter.log());
    }
}

#[test]
fn a_program_that_reads_no_events_any_more_ends_the_scan() {
    let adapter = Adapter::start("50s", &[]);
    let mut child = adapter.detect(&["--json", "--timeout", "never"]).spawn().unwrap();
    let mut events = BufReader::new(child.stdout.take().unwrap());
    events.read_line(&mut String::new()).unwrap();
    drop(events);
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()));
    assert_only_listened(&adapter.log());
}

#[test]
fn an_unplugged_adapter_is_one_line_and_exit_code_7() {
    let adapter = Adapter::start("50s", &["--unplug-after", "1500ms"]);
    let output = adapter.detect(&["--timeout", "30s"]).output().unwrap();
    let errors = stderr(&output);
    assert_eq!(output.status.code(), Some(7), "{errors}");
    let said: Vec<&str> = errors.lines().filter(|line| line.starts_with("canbaud:")).collect();
    assert_eq!(said.len(), 1, "{errors}");
    assert!(said[0].ends_with("is gone: unplugged, or its driver was removed"), "{errors}");
}

#[test]
fn a_silent_bus_and_an_unlikely_one_have_their_exit_codes() {
    let adapter = Adapter::start("50s", &[]);
    let args = ["--rates", "250k,500k", "--pause", "100ms"];
    let output = adapter.detect(&args).output().unwrap();
    let text = stdout(&output);
    // The one frame at the start of the bus may have been there, or not.
    assert!(matches!(output.status.code(), Some(3 | 4)), "{text}");
    let adapter = Adapter::start("5ms", &[]);
    let output = adapter.detect(&["--rates", "500k,1M"]).output().unwrap();
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(3), "{text}");
    assert!(text.starts_with("undecided — there is traffic"), "{text}");
}

#[test]
fn a_canable_is_refused_unless_it_is_trusted() {
    let adapter = Adapter::start("5ms", &["--firmware", "canable1", "--m1", "ignored"]);
    let output = adapter.detect(&[]).output().unwrap();
    let errors = stderr(&output);
    assert_eq!(output.status.code(), Some(7), "{errors}");
    assert!(errors.contains("cannot listen without disturbing the bus"), "{errors}");
    assert!(errors.contains("--trust-m1"), "{errors}");
    let log = adapter.log();
    assert!(log.iter().all(|line| !line.contains("open")), "{log:#?}");
    let adapter = Adapter::start("5ms", &["--firmware", "canable1"]);
    let output = adapter.detect(&["--trust-m1", "--rates", "250k"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

/// CAN FD frames come in, and no data bit rate was asked for.
#[test]
fn a_can_fd_bus_is_told_without_a_command_for_classic_nodes() {
    let node =
        |name: &str| format!("[[node]]\nname = '{name}'\nbitrate = '500k'\ndata_bitrate = '2M'\n");
    let traffic = "[[traffic]]\nnode = 'a'\nkind = 'periodic'\nperiod = '6ms'\nid = 0x321\n\
                   format = 'fd-brs'\ndlc = 9\npayload = 'counter'\n";
    let nodes = ["a", "b", "adapter"].map(node).concat();
    let bus = format!("title = 'CAN FD alone'\nduration = '10min'\n{nodes}{traffic}");
    let adapter = common::adapter::Adapter::start_as(&bus, "adapter", &["--firmware", "canable2"]);
    let output = common::canbaud(&["detect", &adapter.channel, "--rates", "500k"]);
    let text = common::stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{text}{}", common::stderr(&output));
    assert!(
        text.starts_with("500 kbit/s, CAN FD (data rate unknown) \u{2014} proven by "),
        "{text}"
    );
    assert!(text.contains("--fd finds it") && !text.contains("ip link"), "{text}");
    adapter.assert_closed();
}
