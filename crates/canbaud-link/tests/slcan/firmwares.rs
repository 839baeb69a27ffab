//! Who it is, and who is refused.

use canbaud_link::slcan::{Firmware, SilentMode, SlcanListener};
use canbaud_link::{Clock, ErrorKind, LinkError};
use canbaud_sim::slcan::Firmware as Real;

use crate::bench::{Bench, Setup, assert_silent, find, scan};

#[test]
fn every_firmware_is_known_by_its_answers() {
    let clock = canbaud::units::Hertz::new(160_000_000);
    for (real, want) in [
        (Real::Lawicel, Firmware::Lawicel),
        (Real::Usbtin, Firmware::Usbtin),
        (Real::Canable2, Firmware::Canable2 { clock }),
        (Real::Canable1, Firmware::CanableStock),
        (Real::Canable2Stock, Firmware::CanableStock),
    ] {
        let bench = Bench::start(Setup { firmware: real, ..Setup::at(250_000) });
        let opened = SlcanListener::open(&bench.port, 115_200, SilentMode::Trusted, Clock::start());
        assert_eq!(opened.unwrap().firmware(), want);
        // Nothing was opened to find out.
        let log = bench.log();
        assert!(log.iter().all(|line| !line.contains("open")), "{log:#?}");
    }
}

#[test]
fn adapters_that_forget_to_be_silent_are_refused_before_they_are_opened() {
    for firmware in [Real::Canable1, Real::Canable2Stock] {
        let bench = Bench::start(Setup { firmware, ..Setup::at(250_000) });
        let refused =
            SlcanListener::open(&bench.port, 115_200, SilentMode::Refused, Clock::start());
        let error = refused.unwrap_err();
        assert!(matches!(error, LinkError::NoListenOnly { .. }), "{error}");
        assert_eq!(error.kind(), ErrorKind::Unusable);
        let log = bench.log();
        assert!(log.iter().all(|line| line.starts_with('C') || line.starts_with('V')), "{log:#?}");
    }
}

#[test]
fn a_canable_that_is_trusted_opens_silent() {
    for firmware in [Real::Canable1, Real::Canable2Stock] {
        let (found, log) = find(Setup { firmware, ..Setup::at(500_000) }, &[]);
        assert_eq!(found, Some(500_000), "{log:#?}");
        assert_silent(&log);
        // M1 stands right before each O.
        let opened = log.iter().enumerate().filter(|(_, line)| line.starts_with('O'));
        for (place, _) in opened {
            assert_eq!(log[place - 1], "M1: set", "{log:#?}");
        }
    }
}

#[test]
fn leaving_by_a_panic_closes_the_channel() {
    let bench = Bench::start(Setup::at(250_000));
    let port = bench.port.clone();
    let clock = Clock::start();
    let left = std::thread::spawn(move || {
        let opened = SlcanListener::open(&port, 115_200, SilentMode::Refused, clock);
        let mut listener = opened.unwrap();
        use canbaud::detect::scan::{Candidate, Controller};
        let rate = canbaud::units::Bitrate::new(250_000).unwrap();
        listener.configure(&Candidate::classic(rate)).unwrap();
        listener.start_monitoring().unwrap();
        panic!("on purpose");
    });
    assert!(left.join().is_err());
    assert_silent(&bench.log());
}

#[test]
fn what_is_no_serial_port_is_said_to_be_none() {
    for (path, wanted) in [
        ("/dev/nothing", "there is no serial port /dev/nothing"),
        ("/dev/null", "/dev/null is no serial port"),
        ("/etc/passwd", "/etc/passwd is no serial port"),
    ] {
        let opened = SlcanListener::open(path, 115_200, SilentMode::Refused, Clock::start());
        assert_eq!(opened.unwrap_err().to_string(), wanted);
    }
}

#[test]
fn a_slow_adapter_is_waited_for() {
    let delay = std::time::Duration::from_millis(60);
    let bench = Bench::start(Setup { delay, ..Setup::at(125_000) });
    let clock = Clock::start();
    let opened = SlcanListener::open(&bench.port, 115_200, SilentMode::Refused, clock);
    let mut listener = opened.unwrap();
    let outcome = scan(&mut listener, clock, &[500_000, 125_000]).unwrap();
    drop(listener);
    let log = bench.log();
    assert!(matches!(outcome, canbaud::detect::scan::Outcome::Found(_)), "{outcome:?} {log:#?}");
    assert_silent(&log);
}
