//! The checkers can fail: each is shown a lie and must notice.

mod common;

use canbaud::wire::Level;
use canbaud_sim::check::Checker;
use canbaud_sim::{
    ErrorKind, Event, FaultState, Mode, NodeId, Observer, Place, Role, Rule, Sample, SampleRun,
    Simulation, Span, Time,
};
use common::{data, node};

const A: NodeId = NodeId(0);
const MONITOR: NodeId = NodeId(1);
/// From TXD to the star point.
const DELAY: Span = Span::from_ns(60);

/// What the checkers say of `lie` on an idle bus of two nodes, the second one monitoring.
fn caught(lie: impl FnOnce(&mut Checker, Time)) -> String {
    let mut sim = Simulation::new(1);
    sim.add_node(node("a")).unwrap();
    sim.add_node(node("m").with_mode(Mode::BusMonitoring)).unwrap();
    let mut checker = Checker::new(&sim);
    sim.run(Time::ZERO + Span::from_us(100), &mut checker);
    checker.assert_clean();
    lie(&mut checker, sim.now());
    checker.first().first().map(ToString::to_string).unwrap_or_default()
}

fn sampled(level: Level) -> Sample {
    Sample { level, driven: Level::Recessive, busy: false }
}

#[test]
fn monitoring_node_that_drives_is_caught() {
    let said = caught(|checker, now| checker.txd(now, MONITOR, Level::Dominant));
    assert!(said.contains("although it monitors the bus"), "{said}");
}

#[test]
fn dominant_bus_without_a_driver_is_caught() {
    let said = caught(|checker, now| {
        checker.bus(now, Level::Dominant);
    });
    assert!(said.contains("is Dominant where all drivers make Recessive"), "{said}");
}

#[test]
fn driver_that_the_bus_does_not_follow_is_caught() {
    let said = caught(|checker, now| {
        checker.txd(now, A, Level::Dominant);
        checker.txd(now + Span::from_us(2), A, Level::Recessive);
    });
    assert!(said.contains("stays Recessive where all drivers make Dominant"), "{said}");
}

#[test]
fn sample_that_is_not_the_level_at_rxd_is_caught() {
    let said = caught(|checker, now| {
        checker.samples(A, &SampleRun::one(now, sampled(Level::Dominant)));
    });
    assert!(said.contains("samples Dominant where"), "{said}");
}

#[test]
fn edge_that_a_run_of_samples_leaves_out_is_caught() {
    let said = caught(|checker, now| {
        let last = now + Span::from_us(6);
        checker.txd(now, A, Level::Dominant);
        checker.bus(now + DELAY, Level::Dominant);
        checker.txd(now + Span::from_us(2), A, Level::Recessive);
        checker.bus(now + Span::from_us(2) + DELAY, Level::Recessive);
        let run = SampleRun { first: now, last, bits: 4, sample: sampled(Level::Recessive) };
        checker.samples(MONITOR, &run);
    });
    assert!(said.contains("samples 4 bits without the edge among them"), "{said}");
}

#[test]
fn frame_that_nobody_sends_is_caught() {
    let frame = data(0x123, &[1]);
    let said = caught(|checker, now| {
        // Somebody sends, but something else.
        let other = Event::TransmissionStarted { frame: data(0x124, &[1]), attempt: 1 };
        checker.event(now, A, &other);
        checker.event(now, MONITOR, &Event::Received { frame });
    });
    assert!(said.contains("which nobody sends"), "{said}");
}

#[test]
fn frame_whose_bits_are_not_on_the_bus_is_caught() {
    let frame = data(0x123, &[1]);
    let said = caught(|checker, now| {
        checker.event(now, A, &Event::TransmissionStarted { frame, attempt: 1 });
        checker.event(now + Span::from_us(200), A, &Event::Transmitted { frame });
    });
    assert!(said.contains("on the bus: nothing"), "{said}");
}

#[test]
fn counter_that_breaks_a_rule_is_caught() {
    let error = Event::Error {
        kind: ErrorKind::Stuff,
        place: Place::Data,
        role: Role::Receiver,
        exempt: false,
    };
    let said = caught(|checker, now| {
        checker.event(now, A, &error);
        checker.event(now, A, &Event::Counted { rule: Rule::ReceiverError, tec: 0, rec: 2 });
    });
    assert!(said.contains("want (0, 1)"), "{said}");
    let said = caught(|checker, now| checker.event(now, A, &Event::Fault(FaultState::BusOff)));
    assert!(said.contains("bus-off at TEC 0"), "{said}");
    let exempt = Event::Error {
        kind: ErrorKind::Bit,
        place: Place::Data,
        role: Role::Transmitter,
        exempt: true,
    };
    let said = caught(|checker, now| checker.event(now, A, &exempt));
    assert!(said.contains("does not exempt"), "{said}");
}
