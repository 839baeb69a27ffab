//! Every rate is found, in each of the three ways of telling errors.

use canbaud_sim::slcan::{ErrorReports, Firmware};

use crate::bench::{Setup, assert_silent, find};

const CANOPEN: [u32; 8] = [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

#[test]
fn every_rate_of_canopen_is_found_by_flags() {
    for rate in CANOPEN {
        let (found, log) = find(Setup::at(rate), &[]);
        assert_eq!(found, Some(rate), "{log:#?}");
        assert_silent(&log);
        assert!(log.iter().any(|line| line == "L: open listen-only"));
    }
}

#[test]
fn every_rate_of_canopen_is_found_by_records() {
    for rate in CANOPEN {
        let setup = Setup { reports: Some(ErrorReports::Records), ..Setup::at(rate) };
        let (found, log) = find(setup, &[]);
        assert_eq!(found, Some(rate), "{log:#?}");
        assert_silent(&log);
    }
}

#[test]
fn rates_are_found_by_an_adapter_that_tells_no_errors() {
    for rate in [20_000, 125_000, 500_000, 1_000_000] {
        let setup = Setup { firmware: Firmware::Usbtin, ..Setup::at(rate) };
        let (found, log) = find(setup, &[]);
        assert_eq!(found, Some(rate), "{log:#?}");
        assert_silent(&log);
    }
}

#[test]
fn rates_without_a_digit_are_set_by_registers() {
    for (firmware, letter) in
        [(Firmware::Lawicel, "s"), (Firmware::Usbtin, "s"), (Firmware::Canable2, "s")]
    {
        let setup = Setup { firmware, ..Setup::at(83_333) };
        let (found, log) = find(setup, &[125_000, 83_333, 33_333]);
        let found = found.unwrap_or(0);
        assert!(found.abs_diff(83_333) < 400, "{found} {log:#?}");
        let set = |line: &&String| line.starts_with(letter) && line.ends_with(": set");
        assert!(log.iter().any(|line| set(&line)), "{log:#?}");
        assert_silent(&log);
    }
}
