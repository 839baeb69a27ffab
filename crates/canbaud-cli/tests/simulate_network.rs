//! `canbaud simulate` with CANopen nodes that find their own way, and an LSS master against them.

mod common;

use common::{canbaud, command, stderr, stdout};

const NETWORK: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../canbaud-sim/scenarios/canopen-network.toml");
const WRONG_RATE: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../canbaud-sim/scenarios/canopen-wrong-rate.toml");

#[test]
fn a_run_shows_where_each_node_is_and_checks_every_bit() {
    let output = canbaud(&["simulate", WRONG_RATE, "--check"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for part in [
        "valve    power on: stored rate 125k, remembers nothing",
        "valve    listens at 500kbit/s",
        "valve    sends its boot-up message 703",
        "valve    operational (RUN on, ERROR off)",
        "error active, operational, at 500000 bit/s since ",
    ] {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}

#[test]
fn many_seeds_of_twenty_nodes_tell_where_they_end() {
    let line = ["simulate", NETWORK, "--repeat", "4", "--seed", "70", "--json"];
    let output = canbaud(&line);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let all: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(all["missed"], serde_json::json!([]));
    let nodes = all["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 21);
    for node in &nodes[1..] {
        assert_eq!(node["found_bitrate"], serde_json::json!({ "250000": 4 }), "{node}");
        assert_eq!(node["broken_silence"]["max"], 0.0, "{node}");
        let stage = if node["name"] == "node-without-id" { "initialising" } else { "operational" };
        assert_eq!(node["stage"], serde_json::json!({ stage: 4 }), "{node}");
    }
    // Power comes at random: the seeds differ.
    let times = &nodes[1]["found_at_s"];
    assert_ne!(times["min"], times["max"]);
    assert_eq!(stdout(&canbaud(&line)), stdout(&output), "the same seeds, another result");
}

#[cfg(unix)]
mod with_an_lss_master {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::process::{Child, Stdio};
    use std::time::{Duration, Instant};

    /// A manager that knows the rate; devices with timer, with a counter, with a timer alone and
    /// without node-ID; one that cannot store. `right` is the adapter.
    const PLANT: &str = "
title = 'a plant'
duration = '5min'
[[node]]
name = 'right'
bitrate = '250k'
mode = 'disabled'
[[node]]
name = 'manager'
bitrate = '250k'
autonomous = { node_id = 1, start_up = 'mini-master', sync = '50ms', timer = '8M' }
[node.lss]
vendor_id = 0x29C
product_code = 1
revision_number = 1
serial_number = 1
processing = '2ms'
[[node]]
name = 'drive'
autonomous = { node_id = 2, timer = '8M', pdo = '50ms' }
lss = { vendor_id = 0x29C, product_code = 1, revision_number = 1, serial_number = 2 }
[[node]]
name = 'valve'
autonomous = { node_id = 3, listener = 'counter', pdo = '50ms' }
[node.lss]
vendor_id = 0x29C
product_code = 1
revision_number = 1
serial_number = 3
storage = 'fails'
[[node]]
name = 'new'
autonomous = { listener = 'none', timer = '2M', pdo = '50ms' }
lss = { vendor_id = 0x29C, product_code = 1, revision_number = 1, serial_number = 4 }
";

    struct Plant {
        process: Child,
        channel: String,
        directory: tempfile::TempDir,
    }

    impl Plant {
        fn start() -> Self {
            let directory = tempfile::tempdir().unwrap();
            std::fs::write(directory.path().join("plant.toml"), PLANT).unwrap();
            let line = ["simulate", "plant.toml", "--slcan", "right", "--log", "log"];
            let mut process =
                command(&line).current_dir(&directory).stdout(Stdio::piped()).spawn().unwrap();
            let mut path = String::new();
            BufReader::new(process.stdout.take().unwrap()).read_line(&mut path).unwrap();
            Self { process, channel: format!("slcan:{}", path.trim()), directory }
        }

        fn log(&self) -> String {
            std::fs::read_to_string(self.directory.path().join("log")).unwrap_or_default()
        }

        /// Waits until `part` is in the log behind `from`; where it ends.
        fn wait_for(&self, part: &str, from: usize) -> usize {
            let begin = Instant::now();
            loop {
                let log = self.log();
                if let Some(place) = log[from..].find(part) {
                    return from + place + part.len();
                }
                // Only so that a test that fails ends.
                assert!(begin.elapsed() < Duration::from_secs(60), "no {part:?} in\n{log}");
                std::thread::sleep(Duration::from_millis(20));
            }
        }

        /// Exit code, standard output and standard error.
        fn lss(&self, rate: &str, words: &[&str]) -> (i32, String, String) {
            let line = ["--on", &self.channel, "--bitrate", rate, "--transmit"];
            let output = canbaud(&[&["lss"], words, &line].concat());
            (output.status.code().unwrap(), stdout(&output), stderr(&output))
        }
    }

    impl Drop for Plant {
        fn drop(&mut self) {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }

    const MANAGER: [&str; 2] = ["--address", "29C:1:1:1"];
    const DRIVE: [&str; 2] = ["--address", "29C:1:1:2"];
    const VALVE: [&str; 2] = ["--address", "29C:1:1:3"];
    const NEW: [&str; 2] = ["--address", "29C:1:1:4"];

    /// Found, named, refused, set to another rate with the whole network, and back by index 9.
    #[test]
    fn a_whole_network_is_configured_and_comes_back_at_the_new_rate() {
        let plant = Plant::start();
        plant.wait_for("valve: operational", 0);
        let (code, out, err) = plant.lss("250k", &["scan", "--assign", "20", "--store"]);
        assert_eq!((code, out.lines().count()), (0, 1), "{out}{err}");
        assert!(out.contains(":00000004  node-ID 20"), "{out}");
        let at = plant.wait_for("new: operational", 0);
        let log = plant.log();
        assert!(log.contains("new: sends its boot-up message 714"), "{log}");

        let refused = [&["set-bitrate", "auto"][..], &MANAGER].concat();
        let (code, _, err) = plant.lss("250k", &refused);
        assert_eq!((code, err.contains("bit timing not supported (error 1)")), (3, true), "{err}");
        let (code, _, err) = plant.lss("250k", &[&["store"][..], &VALVE].concat());
        assert_eq!((code, err.contains("(error 2)")), (3, true), "{err}");

        // The manager goes to 500 kbit/s, the others are automatic and follow.
        let words = [&["set-bitrate", "500k", "--store"][..], &MANAGER].concat();
        let (code, _, err) = plant.lss("250k", &words);
        assert_eq!(code, 0, "{err}");
        let (code, _, err) = plant.lss("250k", &["activate", "--delay", "1s", "--to", "500k"]);
        assert_eq!(code, 0, "{err}");
        for name in ["manager", "drive", "valve", "new"] {
            let at = plant.wait_for(&format!("{name}: takes part at 500kbit/s"), at);
            let at = plant.wait_for(&format!("{name}: sends its boot-up message"), at);
            plant.wait_for(&format!("{name}: operational (RUN on, ERROR off)"), at);
        }
        for (device, id) in [(VALVE, "node-ID 3"), (NEW, "node-ID 20")] {
            let (code, out, err) = plant.lss("500k", &[&["inquire"][..], &device].concat());
            assert_eq!((code, out.contains(id)), (0, true), "{out}{err}");
        }

        // One device detects anew, by index 9.
        let at = plant.log().len();
        let (code, out, err) =
            plant.lss("500k", &[&["auto", "--delay", "1s", "--store"][..], &DRIVE].concat());
        assert_eq!((code, out.contains("found the bit rate after")), (0, true), "{out}{err}");
        let at = plant.wait_for("drive: LSS: switches to automatic", at);
        let at = plant.wait_for("drive: detects: listens, drives nothing", at);
        plant.wait_for("drive: operational", at);
        // Nobody disturbed anybody: the adapter itself, too, was never at a wrong rate.
        let log = plant.log();
        assert!(!log.contains("! error flag"), "{log}");
    }

    #[test]
    fn an_autonomous_node_is_no_adapter() {
        let output = canbaud(&["simulate", NETWORK, "--slcan", "node-2"]);
        assert_eq!(output.status.code(), Some(5));
        assert!(stderr(&output).contains("\"node-2\" is autonomous"), "{}", stderr(&output));
    }
}

/// On a channel without a bit rate the node of the bridge goes along with activations.
#[cfg(target_os = "linux")]
mod behind_a_channel {
    use super::*;
    use std::process::Command;

    #[test]
    fn nothing_is_opened_without_leave_to_transmit() {
        let output = canbaud(&["simulate", NETWORK, "--bridge", "right", "--on", "can7"]);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(stderr(&output), "canbaud: this transmits on can7: say --transmit\n");
        let line = ["simulate", NETWORK, "--bridge", "node-2", "--on", "can7", "--transmit"];
        assert!(stderr(&canbaud(&line)).contains("\"node-2\" is autonomous"));
    }

    const PLANT: &str = "
title = 'a plant'
duration = '5min'
[[node]]
name = 'right'
bitrate = '250k'
mode = 'disabled'
[[node]]
name = 'manager'
bitrate = '250k'
autonomous = { node_id = 1, start_up = 'mini-master', sync = '50ms', timer = '8M' }
lss = { vendor_id = 0x29C, product_code = 1, revision_number = 1, serial_number = 1 }
[[node]]
name = 'drive'
autonomous = { node_id = 2, timer = '8M', pdo = '50ms' }
lss = { vendor_id = 0x29C, product_code = 1, revision_number = 1, serial_number = 2 }
";

    const STEPS: &str = r#"
ip link set lo up && ip route add 224.0.0.0/4 dev lo || exit 77
"$0" simulate plant.toml --bridge right --on udp:239.74.163.2:43113 --transmit > told &
plant=$!
trap 'kill $plant' EXIT
until grep -q 'drive: operational' told; do kill -0 $plant || exit 1; sleep 0.02; done
line='--on udp:239.74.163.2:43113 --transmit'
"$0" lss set-bitrate 500k --address 29C:1:1:1 $line || exit 2
"$0" lss activate --delay 1s $line || exit 3
"$0" lss inquire --address 29C:1:1:1 $line || exit 4
until grep -q 'drive: takes part at 500kbit/s' told; do kill -0 $plant || exit 5; sleep 0.02; done
"$0" lss auto --address 29C:1:1:2 --delay 1s $line || exit 6
"#;

    /// In a network namespace of its own, where the loopback carries multicast.
    #[test]
    fn a_network_behind_udp_multicast_goes_to_another_rate_and_the_bridge_with_it() {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("plant.toml"), PLANT).unwrap();
        let output = Command::new("unshare")
            .args(["--net", "--map-root-user", "sh", "-c", STEPS])
            .arg(env!("CARGO_BIN_EXE_canbaud"))
            .current_dir(&directory)
            .output();
        let Ok(output) = output else {
            eprintln!("not run: there is no unshare here");
            return;
        };
        let (out, err) = (stdout(&output), stderr(&output));
        if output.status.code() == Some(77) || err.contains("unshare:") {
            eprintln!("not run: no network namespace with a loopback here: {err}");
            return;
        }
        let told = std::fs::read_to_string(directory.path().join("told")).unwrap();
        assert_eq!(output.status.code(), Some(0), "{out}\n{err}\n{told}");
        assert!(out.contains("0000029C:00000001:00000001:00000001  node-ID 1"), "{out}");
        assert!(out.contains("found the bit rate after"), "{out}");
        assert!(told.contains("manager: LSS: switches to 500k"), "{told}");
        assert!(told.contains("drive: LSS: switches to automatic"), "{told}");
    }
}
