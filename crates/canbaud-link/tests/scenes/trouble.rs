//! Trouble on the bus and in the adapter.

use canbaud_sim::Mode;
use canbaud_sim::around::Fifo;

use crate::stage::*;

#[test]
fn every_rate_is_found_and_the_scanner_is_silent() {
    for candidate in Candidates::<8>::canopen().unwrap().as_slice() {
        let mut scene = Scene::pair(candidate.nominal.bits_per_second());
        scene.talk(at_ms(3), Span::from_ms(100), Payload::Random);
        let (outcome, _) = canopen(scene.controller(Adapter::embedded()), Settings::default());
        assert_eq!(found(outcome).nominal(), candidate.nominal);
    }
}

fn lonely(bitrate: u32, policy: Policy) -> (Option<Outcome>, Scan<8>) {
    let mut scene = Scene::new([node(bitrate)]);
    scene.talk(at_ms(5), Span::from_ms(1000), Payload::Random);
    let settings = Settings { policy, ..beginning_at(bitrate) };
    canopen(scene.controller(Adapter::embedded()), settings)
}

#[test]
fn lone_sender_is_waited_for_until_it_is_error_passive() {
    for bitrate in [10_000, 125_000, 1_000_000] {
        let found = found(lonely(bitrate, Policy::Weighing).0);
        assert_eq!(found.nominal(), rate(bitrate));
        assert_eq!(found.acknowledgement, Acknowledgement::Missing);
        assert_eq!(found.visits, 1, "it left the right rate");
    }
    // Koppe's way begins at 10 kbit/s, too, and leaves it at the first error.
    let (_, scan) = lonely(10_000, Policy::Koppe);
    assert!(scan.status(ms(60_000)).visits > 1);
}

/// A bus of 100 kbit/s that never rests for 11 bits of a receiver ten times too slow. One that
/// knows CAN FD begins to count anew at each edge while it integrates [ISO 11898-1].
fn crowded() -> Scanner {
    let mut scene = Scene::pair(100_000);
    let mut rng = Rng::new(7);
    // In the middle of a frame when the scan begins to listen.
    let mut at = 0;
    let frames = (0..6000).map(|_| {
        let data = rng.bits().to_be_bytes();
        let frame = Frame::new(Id::Base(0x123), FrameKind::Data, 8, &data).expect("8 bytes");
        // 125 bits with the intermission, then up to 60 of pause, 10 us each.
        let start = at;
        at += 1_250 + rng.below(600);
        (Span::from_us(start), frame)
    });
    let arrivals = Arrivals::Replay(frames.collect());
    scene.talk_when(FrameKind::Data, arrivals, Time::ZERO, Payload::Random);
    scene.controller(Adapter { fd: FdSupport::Fd, ..Adapter::embedded() })
}

#[test]
fn a_stall_ten_times_too_slow_ends_at_its_bound_where_koppe_waits_for_ever() {
    let candidates = Candidates::<2>::of_rates(&[rate(10_000), rate(100_000)]).unwrap();
    let koppe = Settings { policy: Policy::Koppe, ..Settings::default() };
    let (outcome, _) = scan(crowded(), &candidates, koppe, ms(8_000));
    assert_eq!(outcome, None, "Koppe's way hears neither a frame nor an error at 10 kbit/s");
    let (outcome, _) = scan(crowded(), &candidates, beginning_at(10_000), ms(8_000));
    let found = found(outcome);
    assert_eq!(found.nominal(), rate(100_000));
    // One step of 1 s at 10 kbit/s, and shorter ones until its head start is used up.
    assert!(found.elapsed < ms(1_500), "{}", found.elapsed);
}

#[test]
fn frames_of_the_rate_before_stay_in_the_fifo_and_do_not_count() {
    // The bus is at 500 kbit/s; what is received there reaches the host up to 40 ms later.
    for stamps in [Stamps::None, Stamps::Hardware] {
        let adapter = Adapter {
            batch: ms(40),
            stamps,
            fifo: Fifo::Kept,
            depth: 64,
            evidence: Evidence::FramesOnly,
            ..Adapter::embedded()
        };
        let mut scene = Scene::pair(500_000);
        scene.talk(at_ms(1), Span::from_ms(7), Payload::Random);
        let mut controller = scene.controller(adapter);
        // Somebody listened at 500 kbit/s before the scan, which knows 250 kbit/s only.
        controller.configure(&Candidate::classic(rate(500_000))).unwrap();
        controller.start_monitoring().unwrap();
        controller.wait(ms(35));
        let candidates = Candidates::<2>::of_rates(&[rate(250_000)]).unwrap();
        let (outcome, _) = scan(controller, &candidates, Settings::default(), ms(5_000));
        assert_eq!(outcome, Some(Outcome::StillOpen), "{stamps:?}");
    }
}

#[test]
fn a_local_frame_at_a_wrong_rate_is_not_the_answer() {
    let mut controller = Scene::pair(500_000).controller(Adapter::embedded());
    for data in 0..4 {
        let frame = Frame::new(Id::Base(0x123), FrameKind::Data, 1, &[data]).unwrap();
        controller.loop_back(ms(20), frame);
    }
    let (outcome, _) = canopen(controller, Settings::default());
    assert_eq!(outcome, Some(Outcome::Silent));
}

#[test]
fn one_heartbeat_of_constant_content_is_enough() {
    for evidence in [Evidence::Errors, Evidence::Counter, Evidence::FramesOnly] {
        let mut scene = Scene::pair(250_000);
        scene.talk(at_ms(400), Span::from_ms(900), Payload::Fixed(vec![5; 8]));
        let (outcome, _) = canopen(scene.controller(Adapter::usb(evidence)), Settings::default());
        let found = found(outcome);
        assert_eq!((found.nominal(), found.distinct), (rate(250_000), 1), "{evidence:?}");
    }
}

#[test]
fn a_burst_of_disturbance_does_not_lose_the_right_rate() {
    let mut scene = Scene::pair(250_000);
    scene.talk(at_ms(2), Span::from_ms(5), Payload::Random);
    let mut rng = Rng::new(3);
    // 30 ms of it, over six frames.
    for _ in 0..100 {
        let at = Time::ZERO + Span::from_us(1_000 + rng.below(30_000));
        scene.sim.dominant_at(at, Span::from_us(1 + rng.below(30)));
    }
    let (outcome, _) = canopen(scene.controller(Adapter::embedded()), beginning_at(250_000));
    let found = found(outcome);
    assert_eq!(found.nominal(), rate(250_000));
    assert!(found.elapsed < ms(300), "{}", found.elapsed);
}

#[test]
fn error_frames_of_a_node_at_another_rate_do_not_lose_the_right_one() {
    for settings in [beginning_at(250_000), Settings::default()] {
        // It sends active error flags until it is error passive, is reset, and does so again.
        let stranger = node(125_000);
        let mut scene = Scene::new([node(250_000), node(250_000), stranger.clone()]);
        scene.talk(at_ms(2), Span::from_ms(5), Payload::Random);
        for n in 1..10 {
            scene.sim.reconfigure_at(at_ms(30 * n), scene.nodes[2], stranger.clone()).unwrap();
        }
        let (outcome, _) = canopen(scene.controller(Adapter::embedded()), settings);
        assert_eq!(found(outcome).nominal(), rate(250_000));
    }
}

#[test]
fn another_listening_node_changes_nothing() {
    // Two autobaud nodes and one sender: nobody acknowledges until one of them knows the rate.
    let mut scene = Scene::new([node(125_000), node(500_000).with_mode(Mode::BusMonitoring)]);
    scene.talk(at_ms(1), Span::from_ms(50), Payload::Random);
    let (outcome, _) = canopen(scene.controller(Adapter::embedded()), Settings::default());
    assert_eq!(found(outcome).nominal(), rate(125_000));
}

#[test]
fn traffic_at_no_candidate_fits_none_long_before_the_bound() {
    for adapter in [Adapter::embedded(), Adapter::usb(Evidence::Counter)] {
        let mut scene = Scene::pair(400_000);
        scene.talk(at_ms(3), Span::from_ms(5), Payload::Random);
        let (outcome, scan) = canopen(scene.controller(adapter), Settings::default());
        assert!(matches!(outcome, Some(Outcome::NoCandidateFits(_))), "{outcome:?}");
        assert!(scan.standings().all(|standing| standing.errors >= 6 && standing.frames == 0));
    }
}
