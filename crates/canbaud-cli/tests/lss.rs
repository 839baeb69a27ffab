//! `canbaud lss`: what it refuses, what it shows, and what it does on a simulated bus.

mod common;

use common::{canbaud, schema, stderr, stdout};

#[test]
fn nothing_is_opened_without_leave_to_transmit() {
    // The channel does not exist: opening it would be another error.
    for words in [
        &["scan"][..],
        &["inquire"],
        &["set-node-id", "5"],
        &["set-bitrate", "500k"],
        &["activate"],
        &["store"],
        &["auto"],
        &["serve", "--address", "1:2:3:4"],
    ] {
        let line = [&["lss"], words, &["--on", "can7"]].concat();
        let output = canbaud(&line);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert_eq!(
            stderr(&output),
            "canbaud: this transmits on can7: say --transmit\n  \
             hint: --dry-run shows the frames and opens nothing\n",
        );
        assert_eq!(stdout(&output), "");
    }
}

/// The frames of a dry run, without what they are.
fn dry(words: &[&str]) -> Vec<String> {
    let output = canbaud(&[&["lss"], words, &["--on", "can7", "--dry-run"]].concat());
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    assert_eq!(stderr(&output), "", "{words:?}");
    stdout(&output).lines().map(|line| line.split_once("  ").unwrap().0.to_owned()).collect()
}

#[test]
fn a_dry_run_shows_the_frames() {
    let enter = "7E5#0401000000000000";
    let leave = "7E5#0400000000000000";
    let begin = "7E5#5100000000800000";
    assert_eq!(dry(&["scan"]), [leave, begin, leave]);
    assert_eq!(dry(&["set-node-id", "127"]), [leave, enter, "7E5#117F000000000000", leave]);
    let address = ["--address", "11223344:55667788:20001:99AABBCC"];
    let select = [
        "7E5#4044332211000000",
        "7E5#4188776655000000",
        "7E5#4201000200000000",
        "7E5#43CCBBAA99000000",
    ];
    let mut wanted = vec![leave];
    wanted.extend(select);
    wanted.extend(["7E5#1300090000000000", "7E5#1700000000000000", leave]);
    assert_eq!(dry(&[&["set-bitrate", "auto", "--store"][..], &address].concat()), wanted);
    assert_eq!(
        dry(&["activate", "--delay", "1s", "--to", "500k"]),
        [enter, "7E5#15E8030000000000", leave]
    );
    let table = ["set-bitrate", "--table", "128", "--index", "3"];
    assert_eq!(dry(&table), [leave, enter, "7E5#1380030000000000", leave]);
    let table = ["set-bitrate", "--table", "255", "--index", "255", "--store"];
    assert_eq!(dry(&table), [leave, enter, "7E5#13FFFF0000000000", "7E5#1700000000000000", leave]);
    let reserved = dry(&["set-bitrate", "index:5"]);
    assert_eq!(reserved, [leave, enter, "7E5#1300050000000000", leave]);
}

#[test]
fn a_wrong_command_line_says_what_is_allowed() {
    for (words, wanted) in [
        (&["set-bitrate", "100k"][..], "1M, 800k, 500k, 250k, 125k, 50k, 20k, 10k, and auto"),
        (&["set-node-id", "128"], "1 to 127, and 255 for none"),
        (&["inquire", "--address", "1:2:3"], "four hexadecimal numbers"),
        (
            &["set-bitrate", "index:5", "--activate", "100ms"],
            "stands for no bit rate to go along to",
        ),
        (&["inquire", "--transmit", "--dry-run"], "cannot be used with"),
        (&["set-bitrate"], "required arguments were not provided"),
        (&["set-bitrate", "--table", "127", "--index", "1"], "128..=255"),
        (&["set-bitrate", "--table", "128"], "--index <M>"),
        (&["set-bitrate", "500k", "--table", "128", "--index", "1"], "cannot be used with"),
        (
            &["set-bitrate", "--table", "128", "--index", "1", "--activate", "100ms"],
            "index 1 of table 128 stands for no bit rate to go along to",
        ),
    ] {
        let dry = if words.contains(&"--dry-run") { "--json" } else { "--dry-run" };
        let output = canbaud(&[&["lss"], words, &["--on", "can7", dry]].concat());
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(stderr(&output).contains(wanted), "{words:?}: {}", stderr(&output));
    }
    let output = canbaud(&["lss", "inquire", "--on", "slcan:/dev/null", "--transmit"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("/dev/null needs --bitrate"), "{}", stderr(&output));
}

#[cfg(unix)]
mod on_a_simulated_bus {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Stdio};

    const NETWORK: &str = include_str!("../../../examples/lss/network.toml");
    const DRIVE: &str = "29C:1:10002:1267";
    const VALVE: &str = "5B:1234:3:63";

    /// A device alone: beside others at another bit rate it would destroy what they say.
    const ALONE: &str = "
title = 'a device alone'
duration = '60s'
[[node]]
name = 'master'
bitrate = '250k'
[[node]]
name = 'drive'
bitrate = '250k'
lss = { vendor_id = 0x29C, product_code = 1, revision_number = 0x10002, serial_number = 4711 }
";

    struct Bus {
        process: Child,
        channel: String,
        _directory: tempfile::TempDir,
    }

    impl Bus {
        fn new(scenario: &str) -> Self {
            let directory = tempfile::tempdir().unwrap();
            std::fs::write(directory.path().join("bus.toml"), scenario).unwrap();
            let mut process = common::command(&["simulate", "bus.toml", "--slcan", "master"])
                .current_dir(&directory)
                .stdout(Stdio::piped())
                .spawn()
                .unwrap();
            let mut path = String::new();
            BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
            let channel = format!("slcan:{}", path.trim());
            Self { process, channel, _directory: directory }
        }

        /// Exit code, standard output and standard error.
        fn lss(&self, rate: &str, words: &[&str]) -> (i32, String, String) {
            let line = ["--on", &self.channel, "--bitrate", rate, "--transmit"];
            let output = canbaud(&[&["lss"], words, &line].concat());
            (output.status.code().unwrap(), stdout(&output), stderr(&output))
        }
    }

    impl Drop for Bus {
        fn drop(&mut self) {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }

    /// What was begun is done to its end: no device is left in configuration.
    #[test]
    fn nobody_reads_what_is_printed_and_all_is_done_all_the_same() {
        for redirections in ["2>&- >&-", "2> >(true) > >(true)", "> >(true)"] {
            let bus = Bus::new(ALONE);
            let script = format!(
                "exec {redirections}; sleep 0.2; exec \"$0\" lss set-bitrate 500k --activate 300ms \
                 --on \"$1\" --bitrate 250k --transmit"
            );
            let output = std::process::Command::new("bash")
                .args(["-c", &script, env!("CARGO_BIN_EXE_canbaud"), &bus.channel])
                .output()
                .unwrap();
            assert_eq!(output.status.code(), Some(0), "{redirections}");
            let (code, _, err) = bus.lss("500k", &["inquire", "--address", DRIVE]);
            assert_eq!(code, 0, "{redirections}: {err}");
        }
    }

    fn numbers(line: &str) -> serde_json::Value {
        let value = serde_json::from_str(line).unwrap();
        schema::assert_valid(schema::LSS, &value);
        value
    }

    #[test]
    fn devices_are_found_and_get_node_ids() {
        let bus = Bus::new(NETWORK);
        let (code, out, err) = bus.lss("250k", &["scan", "--assign", "20", "--json"]);
        assert_eq!((code, err.contains("transmits on")), (0, true), "{err}");
        let mut serials: Vec<_> =
            out.lines().map(|line| numbers(line)["serial_number"].as_u64().unwrap()).collect();
        serials.sort_unstable();
        assert_eq!(serials, [815, 4711]);
        let (code, out, err) = bus.lss("250k", &["scan"]);
        assert_eq!((code, out.as_str()), (4, ""), "{err}");
        assert!(err.contains("no device without node-ID answers"), "{err}");
        let (code, out, err) = bus.lss("250k", &["inquire", "--address", VALVE, "--json"]);
        assert_eq!(code, 0, "{err}");
        assert_eq!(numbers(&out)["node_id"], 10);
        let words = ["set-node-id", "11", "--address", VALVE, "--json"];
        let (code, out, err) = bus.lss("250k", &words);
        assert_eq!(code, 0, "{err}");
        assert!(numbers(&out)["done"].as_str().unwrap().contains("11"), "{out}");
        let output = canbaud(&["lss", "inquire", "--on", "can7", "--dry-run", "--json"]);
        let out = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0), "{out}");
        assert!(
            out.lines().count() > 1 && out.lines().all(|line| !numbers(line).is_null()),
            "{out}"
        );
        let (code, _, err) = bus.lss("250k", &["set-bitrate", "auto", "--address", VALVE]);
        assert_eq!((code, err.contains("bit timing not supported (error 1)")), (3, true), "{err}");
        let table = ["set-bitrate", "--table", "128", "--index", "0", "--address", VALVE];
        let (code, _, err) = bus.lss("250k", &table);
        assert_eq!((code, err.contains("bit timing not supported (error 1)")), (3, true), "{err}");
        // Three have the same command to answer.
        let (code, _, err) = bus.lss("250k", &["inquire"]);
        assert_eq!((code, err.contains("more than one device answered")), (3, true), "{err}");
    }

    #[test]
    fn one_device_changes_its_bit_rate_and_the_adapter_goes_along() {
        let bus = Bus::new(ALONE);
        let words = ["set-bitrate", "500k", "--activate", "300ms", "--address", DRIVE];
        let (code, out, err) = bus.lss("250k", &words);
        assert_eq!(code, 0, "{err}");
        assert!(
            out.contains("bit rate 500k is set") && out.contains("the device answers"),
            "{out}"
        );
        let inquire = ["inquire", "--address", DRIVE, "--timeout", "300ms"];
        let (code, _, err) = bus.lss("250k", &inquire);
        assert_eq!((code, err.contains("no answer within 300.000 ms")), (4, true), "{err}");
    }
}
