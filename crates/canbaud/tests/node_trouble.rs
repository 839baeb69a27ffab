//! The autonomous node when its controller refuses, and when its own rate does not fit and it can
//! hear nothing: there is always a way forward, and never a quick one.

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, ErrorClass, ErrorPlace, ErrorSeen, Evidence, FdSupport,
    FrameSeen, Observation, Origin, RateChoice,
};
use canbaud::fault::State;
use canbaud::lss::{NodeId, RateSetting};
use canbaud::node::{
    Action, Input, Means, NmtState, Node, Pattern, Sending, Settings, Stage, Startup, boot_up,
};
use canbaud::units::{Bitrate, Hertz, Micros, Timebase};
use canbaud::wire::{Frame, FrameKind, Id};

fn rate(bits_per_second: u32) -> Bitrate {
    Bitrate::new(bits_per_second).unwrap()
}

fn timer() -> Timebase {
    Timebase::from_frequency(Hertz::new(8_000_000).unwrap())
}

fn controller(evidence: Evidence) -> Means {
    Means::Controller(Capabilities {
        rates: RateChoice::Only(Settings::CANOPEN_RATES),
        evidence,
        fd: FdSupport::Classic,
        reconfiguration: Micros(200),
        latency: Micros(0),
    })
}

fn settings(rate: RateSetting, means: Means, startup: Startup) -> Settings {
    Settings { rate, startup, ..Settings::automatic(NodeId::new(5).unwrap(), means) }
}

fn fixed() -> RateSetting {
    RateSetting::Fixed(rate(250_000))
}

fn heard(byte: u8) -> Input {
    let frame = Frame::new(Id::Base(0x181), FrameKind::Data, 1, &[byte]).unwrap();
    let seen = FrameSeen { frame, origin: Origin::Bus, received: None };
    Input::Heard(Observation::Frame(seen))
}

fn error() -> Input {
    let (class, place) = (ErrorClass::Stuff, ErrorPlace::BeforeCrcEnd);
    Input::Heard(Observation::Error(ErrorSeen { class, place, received: None }))
}

const BUS_OFF: Input = Input::Fault { state: State::BusOff, tec: 256, rec: 0 };

/// A device may answer every action alike.
#[test]
fn refusing_to_stop_makes_no_loop() {
    let automatic = settings(RateSetting::Automatic, Means::Timer(timer()), Startup::Slave);
    let mut node = Node::<160, 8>::new(automatic, None, Micros(0)).unwrap();
    let mut stops = 0;
    while let Some(action) = node.poll(Micros(0)) {
        stops += u32::from(action == Action::Stop);
        assert!(stops <= 1, "it goes on asking");
        node.handle(Micros(0), &Input::Refused);
    }
    assert_eq!(stops, 1);
}

/// A device around a node, without a bus: it carries out what is asked and keeps the time.
struct Device {
    node: Node,
    now: Micros,
    /// Whether the controller does what it is asked.
    obeys: bool,
    /// When it was to take part, to listen.
    took_part: Vec<(Micros, Bitrate)>,
    listened: Vec<Micros>,
}

impl Device {
    fn new(settings: Settings) -> Self {
        let node = Node::new(settings, None, Micros(0)).unwrap();
        let (took_part, listened) = (Vec::new(), Vec::new());
        Self { node, now: Micros(0), obeys: true, took_part, listened }
    }

    /// Carries out what is due; the node asks for an end of it.
    fn turn(&mut self) {
        for _ in 0..100 {
            let Some(action) = self.node.poll(self.now) else { return };
            let candidate = match action {
                Action::Listen(candidate) => {
                    self.listened.push(self.now);
                    candidate
                }
                Action::TakePart(candidate) => {
                    self.took_part.push((self.now, candidate.nominal));
                    candidate
                }
                _ => continue,
            };
            self.answer(candidate);
        }
        panic!("it asks without end at {}", self.now);
    }

    fn answer(&mut self, candidate: Candidate) {
        let configured = Configured { nominal: candidate.nominal, data: None };
        let input = if self.obeys { Input::Ready(configured) } else { Input::Refused };
        self.node.handle(self.now, &input);
    }

    fn hear(&mut self, input: &Input) {
        self.node.handle(self.now, input);
        self.turn();
    }

    /// Lets time pass from deadline to deadline; false if there was none.
    fn wait_until(&mut self, end: Micros) -> bool {
        while self.now < end {
            self.turn();
            let Some(due) = self.node.deadline() else { return false };
            self.now = due.max(self.now + Micros(1)).min(end);
        }
        self.turn();
        true
    }

    fn takes_part(&self) -> bool {
        matches!(self.node.stage(), Stage::TakingPart { .. })
    }
}

/// A4: a fixed rate that is wrong, and a controller that hears nothing at a wrong rate: each time
/// that it takes part again destroys a frame of others, so the waits grow.
#[test]
fn a4_breaks_that_end_in_an_error_are_backed_off() {
    let means = controller(Evidence::FramesOnly);
    for way_out in [error(), BUS_OFF] {
        let mut device = Device::new(settings(fixed(), means, Startup::Slave));
        device.turn();
        let mut waits = Vec::new();
        for _ in 0..9 {
            assert!(device.takes_part(), "{way_out:?}");
            device.hear(&way_out);
            assert!(!device.takes_part());
            let since = device.now;
            while !device.takes_part() {
                let due = device.node.deadline().unwrap();
                device.now = due.max(device.now + Micros(1));
                device.turn();
            }
            waits.push((device.now - since).0);
        }
        // One to two seconds, doubled each time up to 64 times.
        for (times, wait) in waits.iter().enumerate() {
            let least = 1_000_000 << times.min(5);
            assert!(*wait >= least, "{way_out:?}: wait {times} of {waits:?}");
        }
        // Six hours of that are few disturbances.
        assert!(waits[8] >= 64_000_000, "{waits:?}");
        // A good frame says that the rate fits: patience is new.
        device.hear(&heard(1));
        device.hear(&BUS_OFF);
        let since = device.now;
        while !device.takes_part() {
            device.now = device.node.deadline().unwrap().max(device.now + Micros(1));
            device.turn();
        }
        assert!((device.now - since).0 < 3_000_000);
    }
}

/// A4, D2: breaking the silence after bus-off goes through recovery: 128 times 11 recessive bits.
#[test]
fn a4_a_break_after_bus_off_waits_for_recovery_and_is_on_trial() {
    let means = controller(Evidence::FramesOnly);
    let mut device = Device::new(settings(fixed(), means, Startup::Slave));
    device.turn();
    device.hear(&BUS_OFF);
    let mut recovering = None;
    while !device.takes_part() {
        device.now = device.node.deadline().unwrap().max(device.now + Micros(1));
        device.turn();
        if device.node.stage() == Stage::Recovering {
            recovering.get_or_insert(device.now);
        }
    }
    let began = recovering.expect("it takes part without recovery");
    // 4 us a bit.
    assert!(device.now - began >= Micros(4 * 1408), "{} to {}", began, device.now);
    // The rate is still a guess: the first error ends it.
    device.hear(&error());
    assert_eq!(device.node.stage(), Stage::Detecting);
}

/// D1: a controller that refuses for a while: asked again, less and less often, and then all is
/// well; whatever the node was at.
#[test]
fn d1_a_controller_that_refuses_is_asked_again() {
    for startup in [Startup::Slave, Startup::MiniMaster] {
        for means in [Means::Timer(timer()), controller(Evidence::Errors), Means::Both(timer())] {
            let what = format!("{startup:?} {means:?}");
            // To take part.
            let mut device = Device::new(settings(fixed(), means, startup));
            device.obeys = false;
            assert!(device.wait_until(Micros::from_ms(20_000)), "no deadline: {what}");
            let tries = device.took_part.len() + device.listened.len();
            assert!((3..400).contains(&tries), "{tries} tries in 20 s: {what}");
            device.obeys = true;
            device.wait_until(Micros::from_ms(160_000));
            // A slave on a silent bus takes part at its rate again after a while.
            assert!(device.took_part.len() > 1, "{what}");

            // In bus-off.
            let mut device = Device::new(settings(fixed(), means, startup));
            device.turn();
            device.hear(&heard(1));
            device.obeys = false;
            device.hear(&BUS_OFF);
            let tries = device.took_part.len();
            device.wait_until(Micros::from_ms(5_000));
            device.obeys = true;
            device.wait_until(Micros::from_ms(400_000));
            // With a timer alone the line would have to be told; the others hear silence.
            if !matches!(means, Means::Timer(_)) {
                assert!(device.took_part.len() > tries, "{what}");
            }
        }
    }
}

/// D1: what is refused is told, by the node and by its ERROR LED, until the controller obeys.
#[test]
fn d1_a_refusal_is_told() {
    let mut device = Device::new(settings(fixed(), Means::Both(timer()), Startup::MiniMaster));
    device.obeys = false;
    device.turn();
    assert_eq!(device.node.refused(), Some(rate(250_000)));
    assert_eq!(device.node.leds().error, Pattern::Blinking);
    // 50 ms, 100 ms, 200 ms, … up to 3.2 s.
    device.wait_until(Micros::from_ms(20_000));
    let waits: Vec<_> = device.took_part.windows(2).map(|pair| (pair[1].0 - pair[0].0).0).collect();
    assert_eq!(waits[..8], [50, 100, 200, 400, 800, 1600, 3200, 3200].map(|ms: u64| ms * 1000));
    device.obeys = true;
    device.now = device.node.deadline().unwrap();
    device.turn();
    assert_eq!((device.node.refused(), device.node.leds().error), (None, Pattern::Off));
}

/// D1: a slave whose controller can listen but not take part looks for another rate in the end.
#[test]
fn d1_a_slave_that_is_not_let_in_detects() {
    let mut device = Device::new(settings(fixed(), Means::Both(timer()), Startup::Slave));
    device.obeys = false;
    device.turn();
    while device.took_part.len() < 3 {
        assert!(device.takes_part() && device.listened.is_empty());
        device.now = device.node.deadline().unwrap();
        device.turn();
    }
    assert_eq!(device.node.stage(), Stage::Detecting);
    device.obeys = true;
    device.wait_until(Micros::from_ms(500));
    assert_eq!((device.listened.len(), device.node.refused()), (1, None));
}

/// D1: a scan whose controller refuses every rate does not ask without end, and goes on when the
/// controller is well again.
#[test]
fn d1_a_scan_that_is_refused_everywhere_waits_and_goes_on() {
    for means in [controller(Evidence::Errors), Means::Both(timer())] {
        let mut device = Device::new(settings(RateSetting::Automatic, means, Startup::Slave));
        device.obeys = false;
        assert!(device.wait_until(Micros::from_ms(60_000)));
        assert!((3..1_000).contains(&device.listened.len()), "{}", device.listened.len());
        device.obeys = true;
        device.wait_until(Micros::from_ms(70_000));
        let (begin, mut byte) = (device.now, 0);
        while !device.takes_part() {
            byte += 1;
            device.hear(&heard(byte));
            device.wait_until(begin + Micros::from_ms(10 * u64::from(byte)));
            assert!(byte < 200, "it does not come back");
        }
    }
}

/// CiA 305: what waited in the controller when sending was forbidden was taken back; nobody's answer
/// is missed for it, however long the switch delay is.
#[test]
fn a_frame_that_was_taken_back_is_not_waited_for() {
    let mut device = Device::new(settings(fixed(), Means::Both(timer()), Startup::Slave));
    device.turn();
    device.hear(&heard(1));
    device.node.set_sending(Sending::Forbidden);
    device.wait_until(Micros::from_ms(60_000));
    assert!(device.takes_part());
    assert_eq!((device.took_part.len(), device.listened.len()), (1, 0));
    device.now = Micros::from_ms(60_000);
    device.node.set_sending(Sending::Allowed);
    // Its boot-up message was among it.
    assert!(matches!(device.node.poll(device.now), Some(Action::Send(_))));
}

/// LSS gives a node-ID: the boot-up message is sent with it, and one that is under way with the old
/// one does not count.
#[test]
fn a_new_node_id_boots_up() {
    let unconfigured = Settings {
        node_id: NodeId::UNCONFIGURED,
        ..settings(fixed(), Means::Both(timer()), Startup::Slave)
    };
    let mut device = Device::new(unconfigured);
    device.turn();
    device.hear(&heard(1));
    assert_eq!(device.node.poll(device.now), None);
    for id in [9, 10] {
        let id = NodeId::new(id).unwrap();
        device.node.reset_communication(id);
        if id.get() == 10 {
            // The message of 9 is still under way.
            assert_eq!(device.node.poll(device.now), None);
            device.node.handle(device.now, &Input::Sent);
        }
        assert_eq!(device.node.poll(device.now), boot_up(id).map(Action::Send));
    }
    device.node.handle(device.now, &Input::Sent);
    let nmt = Some(NmtState::PreOperational);
    assert_eq!(device.node.stage(), Stage::TakingPart { bitrate: rate(250_000), nmt });
}
