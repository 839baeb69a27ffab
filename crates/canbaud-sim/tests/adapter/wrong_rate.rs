//! What each firmware says, and does, at a wrong rate.

use canbaud_sim::slcan::{ErrorReports, Firmware};

use crate::bus::{Bus, at};

/// A bus of 250 kbit/s that is heard at 500 kbit/s while ten frames pass.
fn heard(firmware: Firmware, reports: Option<ErrorReports>) -> (Bus, String) {
    let mut bus = at(250_000, firmware);
    if let Some(reports) = reports {
        bus.adapter = bus.adapter.with_error_reports(reports);
    }
    bus.says(if matches!(firmware, Firmware::Canable1 | Firmware::Canable2Stock) {
        "S6 M1 O"
    } else {
        "S6 L"
    });
    bus.talk(10);
    let output = bus.run_ms(15);
    (bus, output)
}

#[test]
fn listen_only_is_silent_at_every_rate_and_the_log_says_so() {
    for firmware in Firmware::ALL {
        let (bus, _) = heard(firmware, None);
        assert_eq!(bus.dominant, 0, "{firmware:?}");
        assert_eq!(bus.sim.node(bus.talkers[0]).fault().tec(), 0);
        assert!(bus.log().iter().all(|line| !line.starts_with('!')), "{firmware:?}");
    }
}

#[test]
fn records_are_error_records_and_the_flag() {
    for firmware in Firmware::ALL {
        let (mut bus, output) = heard(firmware, Some(ErrorReports::Records));
        let records: Vec<_> = output.split_terminator(';').collect();
        assert!(records.len() >= 10, "{firmware:?} {output}");
        // A controller that counts in listen-only mode becomes error passive.
        let known = ["e1s", "e1f", "e1B", "e1b", "e1c", "sp128000"];
        assert!(records.iter().all(|record| known.contains(record)), "{output}");
        if firmware == Firmware::Lawicel {
            assert_eq!(bus.says("F F"), "F80;F00;");
        }
    }
}

#[test]
fn flags_mean_what_the_firmware_means() {
    // Ten frames are some hundred errors at twice the rate: the counter of a receiver rises.
    for (firmware, want) in [
        (Firmware::Lawicel, "F80;F00;"),
        (Firmware::Canable1, ""),
        (Firmware::Canable2Stock, ""),
        (Firmware::Usbtin, "F00;F00;"),
    ] {
        let (mut bus, output) = heard(firmware, None);
        assert_eq!(output, "", "{firmware:?}");
        assert_eq!(bus.says("F F"), want, "{firmware:?}");
    }
    let (mut bus, _) = heard(Firmware::Canable2, None);
    let flags = bus.says("F F");
    assert!(["F80;F00;", "F84;F00;", "FA4;F00;"].contains(&flags.as_str()), "{flags}");
    let words = bus.says("f");
    assert!(words.starts_with("f: node_sts=ER_") && !words.contains("=NONE"), "{words}");
}

#[test]
fn silence_looks_like_an_idle_bus() {
    for firmware in [Firmware::Lawicel, Firmware::Canable2, Firmware::Usbtin] {
        let (mut bus, output) = heard(firmware, Some(ErrorReports::Silent));
        assert_eq!(output, "", "{firmware:?}");
        assert_eq!(bus.says("F"), "F00;", "{firmware:?}");
    }
}

#[test]
fn normal_mode_at_a_wrong_rate_disturbs_and_ends_error_passive() {
    for firmware in Firmware::ALL {
        let mut bus = at(250_000, firmware);
        bus.adapter = bus.adapter.with_error_reports(ErrorReports::Records);
        bus.says("S6 O");
        bus.talk(40);
        let output = bus.run_ms(60);
        assert!(output.contains("sp128"), "{firmware:?} {output}");
        assert!(bus.dominant > 10, "{firmware:?}");
        let flags = bus.log().iter().filter(|line| *line == "! error flag on the bus").count();
        // REC is 128 after 128 flags at the latest: each counts 1, and 8 for each dominant bit
        // after it that the rules name.
        assert!((1..=128).contains(&flags), "{firmware:?} {flags}");
        assert!(bus.sim.node(bus.talkers[0]).fault().tec() > 0, "{firmware:?}");
    }
}

#[test]
fn normal_mode_at_the_right_rate_acknowledges_and_the_log_says_so() {
    let mut bus = at(250_000, Firmware::Lawicel);
    bus.says("S5 O");
    bus.talk(2);
    bus.run_ms(5);
    assert_eq!(bus.log()[2..], ["! frame acknowledged", "! frame acknowledged"]);
    assert_eq!(bus.dominant, 2);
}

#[test]
fn log_tells_every_command_whatever_it_was() {
    let mut bus = at(250_000, Firmware::Lawicel);
    bus.says("S5 L t1230 F ");
    bus.adapter.command(&[0xFF, b'\\', b'\r'], &mut bus.sim);
    bus.says("C O t1230 C");
    let want = [
        "S5: set",
        "L: open listen-only",
        "t1230: refused",
        "F: answered",
        ": set",
        "\\xff\\\\: refused",
        "C: closed",
        "O: open normal",
        "t1230: sent",
        "C: closed",
    ];
    assert_eq!(bus.log(), want);
    bus.run_ms(2);
    bus.says("V");
    let log = bus.adapter.take_log();
    assert_eq!(log.last().unwrap().to_string(), "0.002000 V: answered");
    assert!(bus.adapter.log().is_empty());
}
