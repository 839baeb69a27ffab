//! A recording as a controller.

use std::path::Path;
use std::time::Duration;

use canbaud::detect::scan::{Candidates, Driver, Outcome, Progress, Scan, Settings};
use canbaud::units::Bitrate;
use canbaud_link::replay::ReplayListener;
use canbaud_link::{Clock, Listener};

fn example(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/captures").join(name)
}

fn scan(rates: &[u32]) -> Outcome {
    let clock = Clock::start();
    let file = example("demo-classic-83k3.csv");
    let mut replay = ReplayListener::open(&file, None, clock).unwrap();
    let rates: Vec<_> = rates.iter().map(|rate| Bitrate::new(*rate).unwrap()).collect();
    let candidates = Candidates::<8>::of_rates(&rates).unwrap();
    let listener: &mut dyn Listener = &mut replay;
    let scan: Scan<8> = Scan::new(&candidates, &listener.capabilities(), Settings::default());
    let mut driver = Driver::new(listener, scan, |_: &&mut dyn Listener| clock.now());
    loop {
        match driver.turn().unwrap() {
            Progress::Done(outcome) => return outcome,
            Progress::Listening(_) => {
                driver.controller_mut().wait(Duration::from_millis(2)).unwrap();
            }
        }
    }
}

/// What the example says of itself: 83.333 kbit/s.
#[test]
fn the_rate_of_the_recording_is_found_and_no_other() {
    let Outcome::Found(found) = scan(&[500_000, 125_000, 83_333, 50_000]) else { panic!() };
    assert_eq!(found.nominal().bits_per_second(), 83_333);
    assert!(matches!(scan(&[500_000, 250_000]), Outcome::NoCandidateFits(_)));
}

/// A controller loses count of the bits a few percent off; a recording must not forgive more.
#[test]
fn a_neighbouring_rate_is_not_taken_for_the_rate_of_the_recording() {
    for rate in [80_000, 81_000, 86_000, 90_000] {
        let outcome = scan(&[rate]);
        assert!(matches!(outcome, Outcome::NoCandidateFits(_)), "{rate}: {outcome:?}");
    }
    assert!(matches!(scan(&[83_000]), Outcome::Found(_)));
}

#[test]
fn a_file_that_is_none_and_a_channel_that_is_not_there_are_errors() {
    let open = |name, channel| ReplayListener::open(&example(name), channel, Clock::start());
    for (name, channel, wanted) in [
        ("make.py", None, "make.py: no known capture format fits the content"),
        (
            "demo-classic-83k3.csv",
            Some("nope"),
            "demo-classic-83k3.csv: no channel \"nope\"; there",
        ),
    ] {
        let error = open(name, channel).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
        // It is the file that is wrong, not an adapter.
        assert_eq!(error.kind(), canbaud_link::ErrorKind::Unreadable);
    }
}
