//! Buses on which nobody sends, or not yet, and adapters that tell nothing.

use canbaud_sim::MonitoringCounters;

use crate::stage::*;

#[test]
fn a_silent_bus_is_silent_or_open_and_every_candidate_had_its_turn() {
    for (evidence, want) in [
        (Evidence::Errors, Outcome::Silent),
        (Evidence::Counter, Outcome::StillOpen),
        (Evidence::FramesOnly, Outcome::StillOpen),
    ] {
        let controller = Scene::pair(500_000).controller(Adapter::usb(evidence));
        let (outcome, scan) = canopen(controller, Settings::default());
        assert_eq!(outcome, Some(want), "{evidence:?}");
        assert!(scan.standings().all(|standing| standing.visits > 0), "{evidence:?}");
    }
}

#[test]
fn traffic_that_begins_in_the_middle_of_the_scan_is_found() {
    for evidence in [Evidence::Errors, Evidence::Counter, Evidence::FramesOnly] {
        let mut scene = Scene::pair(20_000);
        scene.talk(at_ms(3_000), Span::from_ms(100), Payload::Random);
        let (outcome, _) = canopen(scene.controller(Adapter::usb(evidence)), Settings::default());
        assert_eq!(found(outcome).nominal(), rate(20_000), "{evidence:?}");
    }
}

#[test]
fn a_frozen_counter_is_found_out_and_the_rate_all_the_same() {
    let adapter =
        Adapter { counters: MonitoringCounters::Frozen, ..Adapter::usb(Evidence::Counter) };
    let mut scene = Scene::pair(50_000);
    scene.talk(at_ms(3), Span::from_ms(20), Payload::Random);
    let (outcome, _) = canopen(scene.controller(adapter), Settings::default());
    assert_eq!(found(outcome).nominal(), rate(50_000));
}

#[test]
fn who_may_listen_for_ever_finds_a_bus_that_wakes_up_after_a_minute() {
    let mut scene = Scene::pair(125_000);
    scene.talk(at_ms(61_000), Span::from_ms(200), Payload::Random);
    let settings = Settings { end: End::Never, ..Settings::default() };
    let candidates = Candidates::<8>::canopen().unwrap();
    let controller = scene.controller(Adapter::usb(Evidence::FramesOnly));
    let (outcome, _) = scan(controller, &candidates, settings, ms(90_000));
    assert_eq!(found(outcome).nominal(), rate(125_000));
}
