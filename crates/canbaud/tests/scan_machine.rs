//! The scan machine, told by hand what was heard: each trap of real adapters by itself.

use canbaud::detect::scan::*;
use canbaud::units::{Bitrate, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

fn rate(bits_per_second: u32) -> Bitrate {
    Bitrate::new(bits_per_second).expect("above 0")
}

const fn ms(milliseconds: u64) -> Micros {
    Micros::from_ms(milliseconds)
}

fn capabilities(evidence: Evidence, latency: Micros) -> Capabilities<'static> {
    Capabilities {
        rates: RateChoice::Between(Bitrate::new(1).unwrap(), Bitrate::new(1_000_000).unwrap()),
        evidence,
        fd: FdSupport::Classic,
        reconfiguration: ms(1),
        latency,
    }
}

/// A scan with a clock, in the hands of a test.
struct Hand {
    scan: Scan<8>,
    now: Micros,
}

impl Hand {
    fn new(evidence: Evidence, latency: Micros, settings: Settings) -> Self {
        let candidates = Candidates::canopen().expect("eight");
        let scan = Scan::new(&candidates, &capabilities(evidence, latency), settings);
        Self { scan, now: ms(1000) }
    }

    /// Begins at this rate.
    fn at(evidence: Evidence, latency: Micros, nominal: u32) -> Self {
        let settings = Settings { last_known: Some(rate(nominal)), ..Settings::default() };
        let mut hand = Self::new(evidence, latency, settings);
        assert_eq!(hand.poll(), Some(rate(nominal)));
        hand
    }

    /// Lets the scan do what it wants to; returns the rate that it goes to.
    fn poll(&mut self) -> Option<Bitrate> {
        match self.scan.poll(self.now) {
            Some(Action::Listen(candidate)) => {
                self.now = self.now + ms(1);
                let configured = Configured { nominal: candidate.nominal, data: candidate.data };
                self.scan.handle_listening(self.now, configured);
                Some(candidate.nominal)
            }
            Some(Action::Stop) | None => None,
        }
    }

    fn wait(&mut self, time: Micros) {
        self.now = self.now + time;
    }

    fn frame(&mut self, data: &[u8], received: Option<Micros>, origin: Origin) {
        let length = u8::try_from(data.len()).expect("at most 8");
        let frame = Frame::new(Id::Base(0x181), FrameKind::Data, length, data).expect("a frame");
        self.scan.handle(self.now, &Observation::Frame(FrameSeen { frame, origin, received }));
    }

    fn good(&mut self, data: &[u8]) {
        self.frame(data, Some(self.now), Origin::Bus);
    }

    fn error(&mut self, class: ErrorClass, place: ErrorPlace) {
        let received = Some(self.now);
        self.scan.handle(self.now, &Observation::Error(ErrorSeen { class, place, received }));
    }

    /// Polls at every deadline for so long; true if it stays and says nothing.
    fn stays_for(&mut self, time: Micros) -> bool {
        let end = self.now + time;
        while let Some(due) = self.scan.deadline().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            if self.poll().is_some() || self.scan.outcome().is_some() {
                return false;
            }
        }
        self.now = end;
        true
    }

    fn found(&mut self) -> Option<Found> {
        self.poll();
        match self.scan.outcome() {
            Some(Outcome::Found(found)) => Some(*found),
            _ => None,
        }
    }
}

#[test]
fn two_different_frames_are_announced_at_once() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    hand.wait(ms(5));
    hand.good(&[1]);
    assert_eq!(hand.found(), None);
    hand.wait(Micros(300));
    hand.good(&[2]);
    let found = hand.found().expect("two different frames");
    assert_eq!((found.nominal(), found.frames, found.distinct), (rate(500_000), 2, 2));
    // From the first poll: 1 ms of reconfiguration, 5 ms, 0.3 ms.
    assert_eq!(found.elapsed, Micros(6_300));
    assert_eq!(hand.scan.poll(hand.now), None, "stop is told once");
}

/// Two frames that look good by accident come in hours at a rate that is not the right one.
#[test]
fn two_frames_among_thousands_of_errors_are_no_proof() {
    let settings = Settings { end: End::Never, ..Settings::default() };
    let only = Candidates::<8>::of_rates(&[rate(500_000)]).expect("one");
    let limits = capabilities(Evidence::Errors, Micros(0));
    let mut hand = Hand { scan: Scan::new(&only, &limits, settings), now: ms(1000) };
    for burst in 0..9_000u32 {
        hand.poll();
        hand.wait(ms(5));
        if burst == 0 || burst == 8_999 {
            hand.good(&burst.to_be_bytes());
            assert_eq!(hand.found(), None, "at burst {burst}");
            hand.wait(Micros(300));
        }
        hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
        hand.wait(Micros(300));
        assert_eq!(hand.found(), None, "at burst {burst}");
    }
    assert_eq!(hand.scan.standings().next().expect("one").frames, 2);
}

/// The same with an adapter that tells frames only, by the time that it has listened.
#[test]
fn two_frames_in_many_minutes_are_no_proof_without_errors() {
    let settings =
        Settings { end: End::Never, last_known: Some(rate(500_000)), ..Settings::default() };
    let mut hand = Hand::new(Evidence::FramesOnly, Micros(0), settings);
    let (mut frames, begin) = (0u8, hand.now);
    while hand.now < begin + ms(4_000_000) {
        let at = hand.poll().unwrap_or(rate(1));
        if at == rate(500_000) && hand.now > begin + ms(2_000_000 * u64::from(frames)) {
            hand.wait(ms(20));
            frames += 1;
            hand.good(&[frames]);
        }
        assert_eq!(hand.found(), None, "after {frames} frames");
        hand.now = hand.now.max(hand.scan.deadline().expect("always a next step"));
    }
    assert_eq!(frames, 2);
}

#[test]
fn one_frame_needs_a_quiet_time_in_which_a_slower_bus_would_have_shown_an_error() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    hand.wait(ms(5));
    hand.good(&[1]);
    // 125 kbit/s is the slowest candidate whose frames may look good at 500 kbit/s: 160 bits.
    assert!(hand.stays_for(Micros(1_200)));
    hand.wait(Micros(100));
    assert_eq!(hand.found().expect("quiet for 1.3 ms").distinct, 1);
}

/// A piece of a frame of a slower bus looks good, and its rest shows as an error. Then comes a pause.
#[test]
fn an_error_behind_the_only_frame_takes_its_worth_until_a_frame_is_followed_by_none() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    hand.wait(ms(5));
    hand.good(&[1]);
    hand.wait(Micros(1_000));
    hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
    assert!(hand.stays_for(ms(50)), "quiet alone proves nothing");
    hand.good(&[1]);
    assert!(hand.stays_for(Micros(1_200)));
    hand.wait(Micros(100));
    assert!(hand.found().is_some());
}

#[test]
fn identical_frames_count_once_however_many() {
    for evidence in [Evidence::Errors, Evidence::FramesOnly] {
        let mut hand = Hand::at(evidence, Micros(0), 500_000);
        hand.wait(ms(5));
        for _ in 0..5 {
            hand.good(&[5]);
            assert_eq!(hand.found(), None, "{evidence:?}");
            hand.wait(Micros(200));
        }
    }
}

#[test]
fn stale_frames_never_count_by_time_stamp() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    let before = hand.now - Micros(1);
    hand.wait(ms(5));
    hand.frame(&[1], Some(before), Origin::Bus);
    hand.frame(&[2], Some(before), Origin::Bus);
    assert_eq!(hand.found(), None);
    let standing = hand.scan.standings().find(|s| s.candidate.nominal == rate(500_000));
    assert_eq!(standing.expect("a candidate").frames, 0);
}

#[test]
fn stale_frames_never_count_by_latency() {
    let mut hand = Hand::at(Evidence::Errors, ms(20), 500_000);
    hand.wait(ms(19));
    hand.frame(&[1], None, Origin::Bus);
    hand.frame(&[2], None, Origin::Bus);
    assert_eq!(hand.found(), None, "they may be 20 ms old");
    hand.wait(ms(2));
    hand.frame(&[1], None, Origin::Bus);
    hand.frame(&[2], None, Origin::Bus);
    assert!(hand.found().is_some());
}

#[test]
fn a_frame_sooner_than_any_can_end_is_stale_whatever_its_time_stamp() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 10_000);
    // 11 recessive bits and 43 of the shortest frame are 5.4 ms at 10 kbit/s.
    hand.wait(Micros(4_900));
    hand.good(&[1]);
    hand.good(&[2]);
    assert_eq!(hand.found(), None);
    hand.wait(Micros(600));
    hand.good(&[1]);
    hand.good(&[2]);
    assert!(hand.found().is_some());
}

#[test]
fn local_frames_never_count() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    hand.wait(ms(5));
    hand.frame(&[1], Some(hand.now), Origin::Local);
    hand.frame(&[2], Some(hand.now), Origin::Local);
    assert_eq!(hand.found(), None);
    assert!(hand.stays_for(ms(100)), "a local frame is no sign of traffic either");
}

#[test]
fn stale_errors_do_not_speak_against_a_rate() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    let received = Some(hand.now - Micros(1));
    hand.wait(Micros(100));
    for _ in 0..20 {
        let seen = ErrorSeen { class: ErrorClass::Stuff, place: ErrorPlace::Arbitration, received };
        hand.scan.handle(hand.now, &Observation::Error(seen));
    }
    assert!(hand.stays_for(ms(100)));
    assert!(hand.scan.standings().all(|standing| standing.errors == 0));
}

#[test]
fn errors_at_a_wrong_rate_move_the_scan_on_within_milliseconds() {
    let mut hand = Hand::new(Evidence::Errors, Micros(0), Settings::default());
    assert_eq!(hand.poll(), Some(rate(1_000_000)));
    hand.wait(ms(50));
    // As of a frame of 8 bytes at 10 kbit/s: an error at each edge to dominant, 2 to 6 bits apart.
    let bits = [0, 2, 6, 11, 14, 20, 23, 29, 31, 35, 41, 45, 51, 54, 60, 64];
    let start = hand.now;
    for bit in bits {
        hand.now = start + Micros(bit * 100);
        assert_eq!(hand.poll(), None);
        hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
    }
    // The distance says which rate it was, without trying the others.
    assert_eq!(hand.poll(), Some(rate(10_000)));
}

#[test]
fn frames_destroyed_at_the_ack_delimiter_keep_the_scan_at_the_rate() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    // 16 attempts of a lone sender until it is error passive, one every 0.25 ms.
    for _ in 0..16 {
        hand.wait(Micros(250));
        hand.error(ErrorClass::Form, ErrorPlace::AckDelimiter);
        assert_eq!(hand.poll(), None);
    }
    for _ in 0..8 {
        hand.wait(Micros(250));
        hand.good(&[1]);
        hand.poll();
    }
    let found = hand.found().expect("good frames");
    assert_eq!(found.acknowledgement, Acknowledgement::Missing);
    assert_eq!((found.visits, found.errors), (1, 0));
}

#[test]
fn a_crc_error_at_the_ack_delimiter_is_no_missing_acknowledgement() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 500_000);
    for _ in 0..16 {
        hand.wait(Micros(250));
        hand.error(ErrorClass::Crc, ErrorPlace::AckDelimiter);
    }
    assert!(hand.scan.standings().all(|standing| standing.unacknowledged == 0));
    assert!(hand.poll().is_some(), "16 errors and no frame: next rate");
}

#[test]
fn a_counter_is_evidence_only_from_its_first_reading_on() {
    let mut hand = Hand::at(Evidence::Counter, Micros(0), 500_000);
    hand.wait(Micros(10));
    // What it counted before, at another rate or before the scan.
    hand.scan.handle(hand.now, &Observation::ReceiveErrors(90));
    assert!(hand.stays_for(ms(50)));
    assert!(hand.scan.standings().all(|standing| standing.errors == 0));
    for reading in 91..130 {
        hand.wait(Micros(50));
        hand.scan.handle(hand.now, &Observation::ReceiveErrors(reading));
    }
    assert!(!hand.stays_for(ms(20)), "it moves: a wrong rate");
}

#[test]
fn what_a_counter_counted_before_the_switch_is_no_evidence_behind_it() {
    let mut hand = Hand::new(Evidence::Counter, Micros(0), Settings::default());
    assert_eq!(hand.poll(), Some(rate(1_000_000)));
    let next = (10..60).find_map(|reading| {
        hand.wait(Micros(20));
        hand.scan.handle(hand.now, &Observation::ReceiveErrors(reading));
        hand.poll()
    });
    // The last errors at 1 Mbit/s were counted after the last reading.
    let next = next.expect("it moved");
    hand.scan.handle(hand.now, &Observation::ReceiveErrors(100));
    hand.poll();
    while hand.scan.standings().all(|s| s.candidate.nominal != next || s.listened == Micros(0)) {
        hand.now = hand.scan.deadline().expect("it listens");
        hand.poll();
    }
    let standing = hand.scan.standings().find(|standing| standing.candidate.nominal == next);
    assert_eq!(standing.expect("a candidate").errors, 0, "it left for silence");
}

#[test]
fn no_candidate_is_lost_to_hints_without_having_been_listened_to() {
    let mut hand = Hand::new(Evidence::Errors, Micros(0), Settings::default());
    // At every rate a burst that looks like 10 kbit/s, 10 kbit/s itself included.
    for _ in 0..25 {
        let start = hand.now + ms(1);
        for bit in [0, 2, 6, 11, 14, 20, 23, 29, 31, 35, 41, 45, 51, 54, 60, 64] {
            hand.now = start + Micros(bit * 100);
            hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
        }
        assert!(hand.poll().is_some() || hand.scan.outcome().is_some());
    }
    let visits = |nominal| {
        let of = |standing: &Standing| standing.candidate.nominal == rate(nominal);
        hand.scan.standings().find(of).expect("a candidate").visits
    };
    for nominal in [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000] {
        assert!(visits(nominal) > 0, "{nominal} was never listened at");
    }
}

#[test]
fn edges_without_frames_and_errors_mean_a_much_faster_bus() {
    let mut hand = Hand::at(Evidence::Errors, Micros(0), 10_000);
    let next = loop {
        hand.wait(ms(1));
        hand.scan.handle(hand.now, &Observation::Edges(50));
        if let Some(next) = hand.poll() {
            break next;
        }
        assert!(hand.now < ms(1_300), "two frames at 10 kbit/s last 32 ms");
    };
    assert!(next >= rate(50_000), "{next}");
}

#[test]
fn a_refused_candidate_is_skipped_and_nothing_but_refusals_is_an_outcome() {
    let mut hand = Hand::new(Evidence::Errors, Micros(0), Settings::default());
    for _ in 0..8 {
        assert!(matches!(hand.scan.poll(hand.now), Some(Action::Listen(_))));
        hand.scan.handle_refused(hand.now);
    }
    assert_eq!(hand.scan.poll(hand.now), Some(Action::Stop));
    assert_eq!(hand.scan.outcome(), Some(&Outcome::Refused));
}

#[test]
fn a_controller_with_few_rates_is_asked_for_no_others() {
    let only = [rate(125_000), rate(250_000)];
    let choice =
        Capabilities { rates: RateChoice::Only(&only), ..capabilities(Evidence::Errors, ms(0)) };
    let scan = Scan::new(&Candidates::<8>::canopen().unwrap(), &choice, Settings::default());
    let left: Vec<_> = scan.candidates().iter().map(|candidate| candidate.nominal).collect();
    assert_eq!(left, only);
}

#[test]
fn silence_is_said_only_by_a_controller_that_would_have_told_errors() {
    for (evidence, want) in [
        (Evidence::Errors, Outcome::Silent),
        (Evidence::Counter, Outcome::StillOpen),
        (Evidence::FramesOnly, Outcome::StillOpen),
    ] {
        let mut hand = Hand::new(evidence, Micros(0), Settings::default());
        let (start, bound) = (hand.now, hand.scan.bound().expect("a bound"));
        while hand.scan.outcome().is_none() {
            hand.poll();
            if let Some(due) = hand.scan.deadline() {
                hand.now = hand.now.max(due);
            }
        }
        assert_eq!(hand.scan.outcome(), Some(&want), "{evidence:?}");
        assert!(hand.now - start <= bound, "{} of {bound}", hand.now - start);
        let heard = hand.scan.standings().map(|standing| standing.visits);
        assert!(heard.min() >= Some(1), "{evidence:?}: a candidate was never listened to");
    }
}

#[test]
fn no_candidate_fits_is_sure_only_if_each_was_refuted() {
    // An error wherever it listens, or one alone and then nothing.
    for (every_time, want) in [(true, Ground::Refuted), (false, Ground::OutOfTime)] {
        let mut hand = Hand::new(Evidence::Errors, Micros(0), Settings::default());
        let mut errors = 0;
        while hand.scan.outcome().is_none() {
            hand.poll();
            if hand.scan.listens() && (every_time || errors == 0) {
                hand.wait(ms(5));
                hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
                errors += 1;
            }
            if let Some(due) = hand.scan.deadline() {
                hand.now = hand.now.max(due);
            }
        }
        let Some(Outcome::NoCandidateFits(misfit)) = hand.scan.outcome() else {
            panic!("{:?}", hand.scan.outcome());
        };
        assert_eq!(misfit.ground, want, "after {errors} errors");
    }
}

#[test]
fn without_an_end_it_goes_on_listening() {
    let settings = Settings { end: End::Never, ..Settings::default() };
    let mut hand = Hand::new(Evidence::FramesOnly, Micros(0), settings);
    assert_eq!(hand.scan.bound(), None);
    hand.poll();
    for _ in 0..2_000 {
        hand.now = hand.now.max(hand.scan.deadline().expect("always a next step"));
        hand.poll();
    }
    assert!(hand.now > ms(600_000));
    assert_eq!(hand.scan.outcome(), None);
}

#[test]
fn koppe_is_figure_1() {
    let settings = Settings { policy: Policy::Koppe, ..Settings::default() };
    let mut hand = Hand::new(Evidence::Errors, Micros(0), settings);
    assert_eq!(hand.scan.bound(), None, "silence waits for ever");
    // Ascending, one error each; a second round begins at the slowest.
    for want in [10, 20, 50, 125, 250, 500, 800, 1000, 10, 20] {
        assert_eq!(hand.poll(), Some(rate(want * 1000)));
        assert!(hand.stays_for(ms(1000)), "it has no time-out");
        hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
    }
    assert_eq!(hand.poll(), Some(rate(50_000)));
    hand.wait(ms(10));
    hand.good(&[1]);
    assert_eq!(hand.found().expect("the first message").nominal(), rate(50_000));
}

#[test]
fn fixed_dwell_takes_the_first_frame_and_600_ms_at_each_rate() {
    let settings = Settings { policy: Policy::FixedDwell, ..Settings::default() };
    let mut hand = Hand::new(Evidence::Errors, Micros(0), settings);
    // Three rounds of eight times 600 ms and a reconfiguration.
    assert_eq!(hand.scan.bound(), Some(ms(3 * 8 * 601)));
    assert_eq!(hand.poll(), Some(rate(10_000)));
    hand.error(ErrorClass::Stuff, ErrorPlace::Arbitration);
    assert!(hand.stays_for(ms(599)), "errors do not matter");
    hand.wait(ms(1));
    assert_eq!(hand.poll(), Some(rate(20_000)));
    hand.wait(ms(10));
    hand.good(&[1]);
    assert_eq!(hand.found().expect("one frame").frames, 1);
}

#[test]
fn the_bound_is_the_sum_of_what_each_candidate_may_take() {
    let hand = Hand::new(Evidence::Errors, ms(2), Settings::default());
    // Two longest frames (2 x 160 bits) at each rate, rounded up, 1 s of pause, 1 ms to switch,
    // 2 ms of latency; three rounds.
    let frames = 32_000 + 16_000 + 6_400 + 2_560 + 1_280 + 640 + 400 + 320;
    assert_eq!(hand.scan.bound(), Some(Micros(3 * (frames + 8 * 1_003_000))));
}
