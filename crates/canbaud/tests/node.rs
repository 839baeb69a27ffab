//! The autonomous node on its own: what it asks for, and what it must not.

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, ErrorClass, ErrorPlace, ErrorSeen, Evidence, FdSupport,
    FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::fault::State;
use canbaud::lss::{NodeId, RateSetting};
use canbaud::node::{
    Action, Input, Means, NmtState, Node, Sending, Settings, SettingsError, Silence, Stage,
    Startup, boot_up,
};
use canbaud::units::{Bitrate, Hertz, Micros, Timebase};
use canbaud::wire::{Frame, FrameKind, Id, Logic};

fn rate(bits_per_second: u32) -> Bitrate {
    Bitrate::new(bits_per_second).unwrap()
}

fn id() -> NodeId {
    NodeId::new(5).unwrap()
}

fn timer() -> Timebase {
    Timebase::from_frequency(Hertz::new(8_000_000).unwrap())
}

fn controller() -> Means {
    Means::Controller(Capabilities {
        rates: RateChoice::Only(Settings::CANOPEN_RATES),
        evidence: Evidence::Errors,
        fd: FdSupport::Classic,
        reconfiguration: Micros(200),
        latency: Micros(0),
    })
}

fn ready(bits_per_second: u32) -> Input {
    Input::Ready(Configured { nominal: rate(bits_per_second), data: None })
}

fn heard(identifier: u16, data: &[u8]) -> Input {
    let frame = Frame::new(Id::Base(identifier), FrameKind::Data, data.len() as u8, data).unwrap();
    let seen = FrameSeen { frame, origin: Origin::Bus, received: None };
    Input::Heard(Observation::Frame(seen))
}

fn error(class: ErrorClass, place: ErrorPlace) -> Input {
    Input::Heard(Observation::Error(ErrorSeen { class, place, received: None }))
}

/// All that it asks for now.
fn actions(node: &mut Node, now: Micros) -> Vec<Action> {
    std::iter::from_fn(|| node.poll(now)).collect()
}

/// A node with a fixed rate, taking part.
fn taking_part(settings: Settings, now: Micros) -> Node {
    let mut node = Node::new(settings, None, now).unwrap();
    let candidate = Candidate::classic(rate(250_000));
    assert_eq!(actions(&mut node, now), [Action::TakePart(candidate)]);
    node.handle(now, &ready(250_000));
    node
}

fn fixed(startup: Startup) -> Settings {
    let rate = RateSetting::Fixed(rate(250_000));
    Settings { rate, startup, ..Settings::automatic(id(), Means::Both(timer())) }
}

/// K9: object 1F80h makes automatic detection impossible, at power-on and by LSS.
#[test]
fn k9_a_mini_master_refuses_automatic_detection() {
    assert_eq!(Startup::from_1f80(0b1001), Startup::MiniMaster);
    assert_eq!(Startup::from_1f80(0b0100), Startup::Slave);
    let mut settings = Settings::automatic(id(), Means::Both(timer()));
    settings.startup = Startup::MiniMaster;
    let refused = Node::<160, 8>::new(settings, None, Micros(0)).unwrap_err();
    assert_eq!(refused, SettingsError::MiniMasterAutomatic);
    assert!(refused.to_string().contains("1F80h"));

    let mut node = taking_part(fixed(Startup::MiniMaster), Micros(0));
    let refused = node.set_rate(RateSetting::Automatic, Micros(9));
    assert_eq!(refused, Err(SettingsError::MiniMasterAutomatic));
    let stage = Stage::TakingPart { bitrate: rate(250_000), nmt: None };
    assert_eq!(node.stage(), stage);
}

#[test]
fn settings_that_cannot_be_are_named() {
    let settings = Settings::automatic(id(), controller());
    let none = Settings { rates: &[], ..settings };
    assert_eq!(Node::<160, 8>::new(none, None, Micros(0)).unwrap_err(), SettingsError::NoRates);
    let other = Settings { rate: RateSetting::Fixed(rate(83_333)), ..settings };
    let refused = Node::<160, 8>::new(other, None, Micros(0)).unwrap_err();
    assert_eq!(refused, SettingsError::NotOneOfTheRates(rate(83_333)));
    assert!(refused.to_string().contains("83.333k"));
    let refused = Node::<160, 4>::new(settings, None, Micros(0)).unwrap_err();
    assert_eq!(refused, SettingsError::TooManyRates { room: 4 });
    // A rate remembered by another device is not tried.
    let mut node = Node::<160, 8>::new(settings, Some(rate(83_333)), Micros(0)).unwrap();
    assert_eq!(
        actions(&mut node, Micros(0)),
        [Action::Listen(Candidate::classic(rate(1_000_000)))]
    );
}

/// What came in at the rate before is no evidence, and no answer to what is not asked any more.
#[test]
fn what_was_heard_before_the_controller_was_ready_does_not_count() {
    let settings = Settings::automatic(id(), Means::Both(timer()));
    let mut node = Node::<160, 8>::new(settings, Some(rate(250_000)), Micros(0)).unwrap();
    assert_eq!(actions(&mut node, Micros(0)).len(), 1);
    for n in 0..10 {
        node.handle(Micros(n), &heard(0x181, &[n as u8]));
    }
    assert_eq!(actions(&mut node, Micros(20)), []);
    node.handle(Micros(30), &ready(250_000));
    // A frame that the host itself sent is none from the bus.
    for n in 0..10 {
        let Input::Heard(Observation::Frame(seen)) = heard(0x181, &[n]) else { panic!() };
        let local = FrameSeen { origin: Origin::Local, ..seen };
        node.handle(Micros(40), &Input::Heard(Observation::Frame(local)));
    }
    assert_eq!(actions(&mut node, Micros(50)), []);
    assert_eq!(node.stage(), Stage::Detecting);
}

/// The whole way: boot-up, remembered once, operational, heartbeat, reset.
#[test]
fn from_the_first_frame_to_operation() {
    let mut node = taking_part(fixed(Startup::Slave), Micros(0));
    let boot = Action::Send(boot_up(id()).unwrap());
    assert_eq!(actions(&mut node, Micros(10)), [boot]);
    // Before the boot-up message is out it obeys nobody.
    node.handle(Micros(20), &heard(0, &[1, 5]));
    assert_eq!(actions(&mut node, Micros(20)), [Action::Remember(rate(250_000))]);
    node.handle(Micros(30), &Input::Sent);
    let stage = |nmt| Stage::TakingPart { bitrate: rate(250_000), nmt: Some(nmt) };
    assert_eq!(node.stage(), stage(NmtState::PreOperational));
    assert_eq!(actions(&mut node, Micros(40)), []);
    assert_eq!(node.deadline(), Some(Micros(30) + Micros::from_ms(1000)));
    node.handle(Micros(50), &heard(0, &[1, 5]));
    assert_eq!(node.stage(), stage(NmtState::Operational));
    let heartbeat = |code| {
        let frame = Frame::new(Id::Base(0x705), FrameKind::Data, 1, &[code]).unwrap();
        Action::Send(frame)
    };
    assert_eq!(actions(&mut node, Micros(60)), [heartbeat(5)]);
    // One frame at a time.
    assert_eq!(actions(&mut node, Micros::from_ms(900)), []);
    node.handle(Micros::from_ms(901), &Input::Sent);
    node.handle(Micros::from_ms(902), &heard(0, &[2, 0]));
    node.set_sending(Sending::Forbidden);
    assert_eq!(actions(&mut node, Micros::from_ms(903)), []);
    node.set_sending(Sending::Allowed);
    assert_eq!(actions(&mut node, Micros::from_ms(904)), [heartbeat(4)]);
    node.handle(Micros::from_ms(905), &Input::Sent);
    node.handle(Micros::from_ms(906), &heard(0, &[130, 5]));
    let after = actions(&mut node, Micros::from_ms(906));
    assert!(matches!(after[..], [Action::Reset(_), Action::Send(_)]) && after[1] == boot);
}

/// D2: a mini-master keeps its rate and listens until 128 times 11 recessive bits are certain.
#[test]
fn d2_a_mini_master_waits_for_recovery_and_keeps_its_bit_timing() {
    let mut node = taking_part(fixed(Startup::MiniMaster), Micros(0));
    let fault = Input::Fault { state: State::BusOff, tec: 256, rec: 0 };
    node.handle(Micros(1000), &fault);
    let candidate = Candidate::classic(rate(250_000));
    assert_eq!(actions(&mut node, Micros(1000)), [Action::Listen(candidate)]);
    assert_eq!(node.stage(), Stage::Recovering);
    node.handle(Micros(1100), &ready(250_000));
    // 4 us a bit: not before 1408 bits.
    assert_eq!(actions(&mut node, Micros(1100 + 4 * 1408)), []);
    let end = node.deadline().unwrap();
    assert!(end <= Micros(1100 + 4 * (1408 + 170)), "{end}");
    assert_eq!(actions(&mut node, end), [Action::TakePart(candidate)]);
    // However often it happens.
    node.handle(end, &ready(250_000));
    node.handle(end, &fault);
    assert_eq!(actions(&mut node, end), [Action::Listen(candidate)]);
}

/// D2 with a timer alone: the controller is off, and the timer counts the recessive bits.
#[test]
fn d2_a_device_that_cannot_listen_counts_with_its_timer() {
    let settings = Settings { means: Means::Timer(timer()), ..fixed(Startup::MiniMaster) };
    let mut node = taking_part(settings, Micros(0));
    node.timer(0, Logic::High);
    node.handle(Micros(0), &Input::Fault { state: State::BusOff, tec: 256, rec: 0 });
    assert_eq!(actions(&mut node, Micros(0)), [Action::Stop]);
    // 32 ticks a bit; ten recessive bits at a time are no occurrence.
    let mut ticks = 0;
    for _ in 0..500 {
        node.edge(ticks, Logic::High);
        node.edge(ticks + 320, Logic::Low);
        ticks += 352;
    }
    assert_eq!(actions(&mut node, Micros(ticks / 8)), []);
    assert!(node.deadline().is_some_and(|at| at > Micros(ticks / 8)));
    node.edge(ticks, Logic::High);
    node.timer(ticks + 32 * 1407, Logic::High);
    assert_eq!(actions(&mut node, Micros(ticks / 8 + 5_628)), []);
    node.timer(ticks + 32 * 1408, Logic::High);
    let candidate = Candidate::classic(rate(250_000));
    let now = Micros(ticks / 8 + 5_632);
    assert_eq!(actions(&mut node, now), [Action::TakePart(candidate)]);
}

/// A slave goes back to silence: at bus-off, at the first error before anything good, when it is
/// deaf for 100 ms, and when nobody answers for a second.
#[test]
fn a_slave_whose_rate_does_not_fit_is_silent_again() {
    let silent = |node: &mut Node, now| {
        let asked = actions(node, now);
        assert_eq!(node.stage(), Stage::Detecting);
        assert_eq!(asked, [Action::Listen(Candidate::classic(rate(250_000)))]);
    };
    let mut node = taking_part(fixed(Startup::Slave), Micros(0));
    node.handle(Micros(5), &Input::Fault { state: State::BusOff, tec: 256, rec: 0 });
    silent(&mut node, Micros(5));

    let mut node = taking_part(fixed(Startup::Slave), Micros(0));
    node.handle(Micros(5), &error(ErrorClass::Acknowledge, ErrorPlace::AckSlot));
    assert_ne!(node.stage(), Stage::Detecting);
    node.handle(Micros(6), &error(ErrorClass::Stuff, ErrorPlace::BeforeCrcEnd));
    silent(&mut node, Micros(6));

    let mut node = taking_part(fixed(Startup::Slave), Micros(0));
    node.handle(Micros(5), &heard(0x80, &[]));
    node.handle(Micros(6), &error(ErrorClass::Stuff, ErrorPlace::BeforeCrcEnd));
    let passive = |rec| Input::Fault { state: State::ErrorPassive, tec: 0, rec };
    node.handle(Micros(10), &passive(128));
    node.handle(Micros(20), &heard(0x80, &[]));
    assert_eq!(actions(&mut node, Micros(100_010)).len(), 2, "a good frame sets the doubt back");
    assert_ne!(node.stage(), Stage::Detecting);
    let due = node.deadline().unwrap();
    assert_eq!(due, Micros(100_020));
    assert_eq!(node.poll(due), Some(Action::Listen(Candidate::classic(rate(250_000)))));

    let mut node = taking_part(fixed(Startup::Slave), Micros(0));
    assert_eq!(actions(&mut node, Micros(0)).len(), 1);
    assert_eq!(node.deadline(), Some(Micros::from_ms(1000)));
    assert_eq!(actions(&mut node, Micros::from_ms(999)), []);
    silent(&mut node, Micros::from_ms(1000));
}

/// K2: the dead-lock of nodes that all wait, and the documented way out of it.
#[test]
fn k2_silence_is_broken_only_if_that_was_chosen() {
    let patient = Settings::automatic(id(), Means::Both(timer()));
    let mut node = Node::<160, 8>::new(patient, None, Micros(0)).unwrap();
    assert_eq!(actions(&mut node, Micros(0)).len(), 1);
    node.handle(Micros(0), &ready(1_000_000));
    assert_eq!(node.deadline(), None);
    assert_eq!(actions(&mut node, Micros::from_ms(1_000_000_000)), []);

    let (after, spread) = (Micros::from_ms(100), Micros::from_ms(50));
    let hold = Micros::from_ms(10);
    let silence = Silence::Break { default: rate(125_000), after, spread, hold };
    let mut waits = Vec::new();
    for seed in 0..50 {
        let settings = Settings { silence, seed, ..patient };
        let mut node = Node::<160, 8>::new(settings, None, Micros(0)).unwrap();
        assert_eq!(actions(&mut node, Micros(0)).len(), 1);
        node.handle(Micros(0), &ready(125_000));
        let due = node.deadline().unwrap();
        assert!((after..=after + spread).contains(&due), "{due}");
        waits.push(due);
        // A sign of life puts it off.
        node.handle(due - Micros(1), &error(ErrorClass::Stuff, ErrorPlace::BeforeCrcEnd));
        assert_eq!(actions(&mut node, due), []);
        let due = node.deadline().unwrap();
        assert_eq!(node.poll(due), Some(Action::TakePart(Candidate::classic(rate(125_000)))));
        // Nobody answers: silent again, and patient for twice as long.
        node.handle(due, &ready(125_000));
        assert!(matches!(node.poll(due), Some(Action::Send(_))));
        assert_eq!(node.deadline(), Some(due + hold));
        assert!(matches!(node.poll(due + hold), Some(Action::Listen(_))));
        let longer = node.deadline().unwrap() - (due + hold);
        assert!((after.times(2)..=(after + spread).times(2)).contains(&longer), "{longer}");
    }
    waits.sort();
    waits.dedup();
    assert!(waits.len() > 45, "waits are the same: {waits:?}");
}

/// A small generator, the same everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}

fn any_input(random: &mut Random) -> Input {
    let classes = [ErrorClass::Stuff, ErrorClass::Form, ErrorClass::Crc, ErrorClass::Acknowledge];
    let places = [ErrorPlace::BeforeCrcEnd, ErrorPlace::AckDelimiter, ErrorPlace::Unknown];
    match random.below(9) {
        0 => ready(1 + random.below(1_000_000) as u32),
        1 => Input::Refused,
        2 | 3 => heard(
            random.below(0x800) as u16,
            &[random.below(256) as u8, 0][..random.below(3) as usize],
        ),
        4 => error(classes[random.below(4) as usize], places[random.below(3) as usize]),
        5 => Input::Heard(Observation::ReceiveErrors(random.below(300) as u16)),
        6 => Input::Sent,
        7 => Input::Heard(Observation::Lost),
        _ => {
            let (tec, rec) = (random.below(300) as u16, random.below(140) as u16);
            Input::Fault { state: State::of(tec, rec), tec, rec }
        }
    }
}

/// Whatever comes in whatever order: no panic, an end to what it asks for, no frame unless it takes
/// part, and never an active controller on the strength of nothing (row A8).
#[test]
fn whatever_comes_it_asks_only_for_what_it_may() {
    let all_means = [Means::Timer(timer()), controller(), Means::Both(timer())];
    for seed in 0..300 {
        let mut random = Random(seed);
        let means = all_means[seed as usize % 3];
        let mut now = Micros(random.below(1_000_000));
        let settings = Settings::automatic(id(), means);
        let mut node = Node::<160, 8>::new(settings, None, now).unwrap();
        let (mut ticks, mut level, mut good) = (0, Logic::High, false);
        for step in 0..400 {
            now = now + Micros(random.below(30_000));
            match random.below(3) {
                0 => {
                    ticks += random.below(5_000);
                    level = if level == Logic::High { Logic::Low } else { Logic::High };
                    node.edge(ticks, level);
                }
                1 => node.timer(ticks, level),
                _ => {
                    let input = any_input(&mut random);
                    good |= matches!(input, Input::Heard(Observation::Frame(_)));
                    good |= matches!(input, Input::Heard(Observation::Error(e))
                        if e.place == ErrorPlace::AckDelimiter);
                    node.handle(now, &input);
                }
            }
            let asked = actions(&mut node, now);
            assert!(asked.len() < 8, "seed {seed} step {step}: {asked:?}");
            for action in &asked {
                let active = matches!(action, Action::Send(_) | Action::TakePart(_));
                assert!(!active || good, "seed {seed} step {step}: {action:?}");
            }
            let takes_part = matches!(node.stage(), Stage::TakingPart { .. });
            let sends = asked.iter().any(|action| matches!(action, Action::Send(_)));
            assert!(takes_part || !sends, "seed {seed} step {step}");
        }
    }
}

/// Microseconds and ticks at the end of their range make no panic.
#[test]
fn the_end_of_time_is_survived() {
    let settings = Settings::automatic(id(), Means::Both(timer()));
    let late = Micros(u64::MAX - 5);
    let mut node = Node::<160, 8>::new(settings, None, late).unwrap();
    node.edge(u64::MAX, Logic::Low);
    node.timer(0, Logic::High);
    node.edge(3, Logic::High);
    for now in [late, Micros(0), Micros::MAX] {
        node.handle(now, &ready(500_000));
        node.handle(now, &heard(1, &[1]));
        assert!(actions(&mut node, now).len() < 8);
        let _ = node.deadline();
    }
}
