//! The twelve rules of error confinement [ISO 11898-1], one test (or more) each, under all checkers.

mod common;

use canbaud::wire::{Frame, Level};
use canbaud_sim::{
    ErrorKind, Event, FaultConfinement, FaultState, NodeConfig, NodeId, Place, Role, Rule,
    Simulation, Span, Time,
};
use common::{Bench, data, node};

/// Bit time of the tests, 500 kbit/s.
const BIT_NS: u64 = 2_000;
/// No stuff bit in identifier or data, every other bit recessive.
fn zebra() -> Frame {
    data(0x555, &[0x55; 8])
}

fn bits(count: u64) -> Span {
    Span::from_ns(count * BIT_NS)
}

/// Nodes with counters; the first one sends `frame`; up to its SOF, whose time is returned.
fn sending(frame: Frame, nodes: Vec<(NodeConfig, u16, u16)>) -> (Bench, Vec<NodeId>, Time) {
    let mut sim = Simulation::new(1);
    let ids: Vec<_> = nodes
        .into_iter()
        .map(|(config, tec, rec)| {
            sim.add_node_with(config, FaultConfinement::with_counters(tec, rec)).unwrap()
        })
        .collect();
    let mut bench = Bench::around(sim);
    bench.sim.send_at(Time::ZERO + bits(50), ids[0], frame);
    bench.run_for(bits(52));
    let sof = bench.journal.dominant_edge(0);
    (bench, ids, sof)
}

fn three() -> Vec<(NodeConfig, u16, u16)> {
    vec![(node("a"), 0, 0), (node("b"), 0, 0), (node("c"), 0, 0)]
}

fn with(tec: u16, rec: u16) -> Vec<(NodeConfig, u16, u16)> {
    vec![(node("a"), tec, rec), (node("b"), 0, 0)]
}

/// Destroys the frame at its bit 40, a recessive one of the data field.
fn destroy(bench: &mut Bench, sof: Time) {
    // Bit 0 is SOF; the identifier 101…, so odd bits are recessive up to RTR, IDE and r0; DLC
    // 1000 begins at 15, the data 0101… at 19: even bits are recessive there.
    bench.sim.dominant_at(sof + bits(40), bits(1));
}

#[test]
fn rule_1_receiver_that_detects_an_error_adds_1_to_rec() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    bench.sim.force_rxd_at(sof + bits(40), ids[1], Level::Dominant, bits(8));
    bench.run_bits(60);
    assert_eq!(bench.journal.counted(ids[1], Rule::ReceiverError), [(0, 1)]);
    assert_eq!(bench.journal.counted(ids[2], Rule::ReceiverError), [(0, 1)]);
    bench.finish();
}

#[test]
fn rule_2_receiver_that_sees_a_dominant_bit_after_its_error_flag_adds_8() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    // Node 1 alone sees an error, so its flag comes first and the flags of the others follow it.
    bench.sim.force_rxd_at(sof + bits(40), ids[1], Level::Dominant, bits(8));
    bench.run_bits(80);
    assert_eq!(bench.journal.counted(ids[1], Rule::DominantAfterFlag), [(0, 9)]);
    assert_eq!(bench.journal.counted(ids[2], Rule::DominantAfterFlag), []);
    bench.finish();
}

#[test]
fn rule_3_transmitter_that_sends_an_error_flag_adds_8_to_tec() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    destroy(&mut bench, sof);
    bench.run_bits(60);
    assert_eq!(bench.journal.counted(ids[0], Rule::TransmitterError), [(8, 0)]);
    bench.finish();
}

#[test]
fn rule_3_exception_passive_transmitter_without_acknowledgement_keeps_tec() {
    let (mut bench, ids, _) = sending(zebra(), vec![(node("a"), 128, 0)]);
    bench.run_bits(1_000);
    assert_eq!(bench.journal.counted(ids[0], Rule::TransmitterError), []);
    assert_eq!(bench.sim.node(ids[0]).fault().tec(), 128);
    assert!(bench.journal.errors(ids[0]) > 5);
    bench.finish();
}

#[test]
fn rule_3_exception_ends_when_the_passive_flag_meets_a_dominant_bit() {
    let (mut bench, ids, sof) = sending(zebra(), vec![(node("a"), 128, 0)]);
    // 19 + 64 + 15 bits and their stuff bits, if any in the CRC, then CRC delimiter, ACK slot.
    bench.run_bits(95);
    let until = bench.journal.events.len();
    while bench.journal.events.len() == until {
        bench.run_bits(1);
    }
    assert!(bench.sim.now() > sof);
    let now = bench.sim.now();
    bench.sim.dominant_at(now + bits(2), bits(1));
    bench.run_bits(4);
    assert_eq!(bench.journal.counted(ids[0], Rule::TransmitterError), [(136, 0)]);
    bench.finish();
}

#[test]
fn rule_3_exception_recessive_stuff_bit_overwritten_in_arbitration_keeps_tec() {
    // SOF and 0000 of the identifier make five dominant bits; the stuff bit is bit 5.
    let (mut bench, ids, sof) = sending(data(0x00F, &[]), three());
    bench.sim.dominant_at(sof + bits(5), bits(1));
    bench.run_bits(12);
    let error = Event::Error {
        kind: ErrorKind::Stuff,
        place: Place::Arbitration,
        role: Role::Transmitter,
        exempt: true,
    };
    assert!(bench.journal.of(ids[0]).any(|event| *event == error));
    assert_eq!(bench.sim.node(ids[0]).fault().tec(), 0);
    bench.run_bits(300);
    assert_eq!(bench.journal.transmitted(ids[0]), 1);
    bench.finish();
}

#[test]
fn rule_4_transmitter_with_a_bit_error_in_its_flag_adds_8_to_tec() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    destroy(&mut bench, sof);
    bench.sim.recessive_at(sof + bits(43), bits(1));
    bench.run_bits(45);
    assert_eq!(bench.journal.counted(ids[0], Rule::TransmitterFlagError), [(16, 0)]);
    bench.finish();
}

#[test]
fn rule_5_receiver_with_a_bit_error_in_its_flag_adds_8_to_rec() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    // Six dominant bits from bit 40 (bits 41, 43 are dominant anyway), so the flag begins by 46.
    bench.sim.force_rxd_at(sof + bits(40), ids[1], Level::Dominant, bits(6));
    bench.sim.force_rxd_at(sof + bits(48), ids[1], Level::Recessive, bits(1));
    bench.run_bits(52);
    assert_eq!(bench.journal.counted(ids[1], Rule::ReceiverFlagError), [(0, 9)]);
    bench.finish();
}

#[test]
fn rule_6_eighth_dominant_bit_after_an_active_flag_and_each_further_eight_add_8() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    // Error at bit 40, flag in 41 to 46; dominant up to bit 62: 16 bits after the flag.
    bench.sim.dominant_at(sof + bits(40), bits(23));
    bench.run_bits(70);
    assert_eq!(bench.journal.counted(ids[0], Rule::DominantRun), [(16, 0), (24, 0)]);
    assert_eq!(bench.journal.counted(ids[1], Rule::DominantRun).len(), 1);
    bench.finish();
}

#[test]
fn rule_6_seven_dominant_bits_after_an_active_flag_are_tolerated() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    bench.sim.dominant_at(sof + bits(40), bits(14));
    bench.run_bits(70);
    assert_eq!(bench.journal.counted(ids[0], Rule::DominantRun), []);
    bench.finish();
}

#[test]
fn rule_6_eighth_dominant_bit_after_a_passive_flag_adds_8() {
    let (mut bench, ids, sof) = sending(zebra(), with(128, 0));
    // Error at bit 40; the passive flag ends after six equal bits, 41 to 46, the run goes on.
    bench.sim.dominant_at(sof + bits(40), bits(16));
    bench.run_bits(70);
    assert_eq!(bench.journal.counted(ids[0], Rule::TransmitterError), [(136, 0)]);
    assert_eq!(bench.journal.counted(ids[0], Rule::DominantRun), [(144, 0)]);
    bench.finish();
}

#[test]
fn rule_6_holds_after_an_overload_flag_too() {
    let (mut bench, ids, sof) = sending(zebra(), three());
    bench.run_bits(100);
    assert_eq!(bench.journal.transmitted(ids[0]), 0);
    while bench.journal.transmitted(ids[0]) == 0 {
        bench.run_bits(1);
    }
    assert!(bench.sim.now() > sof);
    // The first bit of the intermission is under way: overload flag, then 8 more dominant bits.
    let now = bench.sim.now();
    bench.sim.dominant_at(now, bits(2 + 6 + 8));
    bench.run_bits(40);
    assert!(bench.journal.of(ids[1]).any(|event| *event == Event::Overload));
    assert_eq!(bench.journal.counted(ids[1], Rule::DominantRun), [(0, 8)]);
    assert_eq!(bench.journal.errors(ids[1]), 0);
    bench.finish();
}

#[test]
fn rule_7_success_takes_1_from_tec_but_not_below_0() {
    for (before, after) in [(0, 0), (1, 0), (100, 99), (255, 254)] {
        let (mut bench, ids, _) = sending(zebra(), with(before, 0));
        bench.run_bits(130);
        assert_eq!(bench.journal.transmitted(ids[0]), 1);
        assert_eq!(bench.sim.node(ids[0]).fault().tec(), after);
        bench.finish();
    }
}

#[test]
fn rule_8_good_reception_takes_1_from_rec_or_sets_it_below_the_limit() {
    for (before, after) in [(0, 0), (1, 0), (127, 126), (128, 119), (135, 119)] {
        let nodes = vec![(node("a"), 0, 0), (node("b"), 0, before)];
        let (mut bench, ids, _) = sending(zebra(), nodes);
        bench.run_bits(130);
        assert_eq!(bench.journal.received(ids[1]), [zebra()]);
        // D1: "set again to a value between 119 and 127".
        assert_eq!(bench.sim.node(ids[1]).fault().rec(), after);
        bench.finish();
    }
}

#[test]
fn rule_9_counter_above_127_is_error_passive_and_its_flag_still_an_active_one() {
    for (tec, passive) in [(119, false), (120, true)] {
        let (mut bench, ids, sof) = sending(zebra(), with(tec, 0));
        bench.sim.dominant_at(sof + bits(40), bits(1));
        bench.run_bits(44);
        let node = bench.sim.node(ids[0]);
        assert_eq!(node.fault().tec(), tec + 8);
        assert_eq!(node.state() == FaultState::ErrorPassive, passive);
        // Six dominant bits of its own: TXD to dominant at bit 41, back six bits later.
        bench.run_bits(8);
        let own: Vec<_> = bench.journal.txd.iter().filter(|(_, n, _)| *n == ids[0]).collect();
        let last = &own[own.len() - 2..];
        assert_eq!((last[0].2, last[1].2), (Level::Dominant, Level::Recessive));
        let length = last[1].0.since(last[0].0).femtoseconds() / (BIT_NS * 1_000_000);
        assert_eq!(length, 6);
        bench.finish();
    }
}

#[test]
fn rule_10_tec_256_is_bus_off_and_255_is_not() {
    for (tec, state) in [(247, FaultState::ErrorPassive), (248, FaultState::BusOff)] {
        let (mut bench, ids, sof) = sending(zebra(), with(tec, 0));
        destroy(&mut bench, sof);
        bench.run_bits(44);
        assert_eq!(bench.sim.node(ids[0]).state(), state);
        let before = bench.journal.txd.len();
        bench.run_bits(60);
        let sends = bench.journal.txd[before..].iter().any(|(_, node, _)| *node == ids[0]);
        assert_eq!(sends, state != FaultState::BusOff);
        bench.finish();
    }
}

#[test]
fn rule_11_error_active_again_when_both_counters_are_at_most_127() {
    for (tec, rec, state) in [
        (128, 0, FaultState::ErrorActive),
        (129, 0, FaultState::ErrorPassive),
        (128, 128, FaultState::ErrorPassive),
    ] {
        let (mut bench, ids, _) = sending(zebra(), with(tec, rec));
        bench.run_bits(130);
        assert_eq!(bench.journal.transmitted(ids[0]), 1);
        assert_eq!(bench.sim.node(ids[0]).state(), state, "TEC {tec} REC {rec}");
        bench.finish();
    }
}

#[test]
fn rule_12_bus_off_ends_after_128_times_11_recessive_bits_with_counters_at_zero() {
    let mut sim = Simulation::new(1);
    let off = sim.add_node_with(node("a"), FaultConfinement::with_counters(256, 0)).unwrap();
    let mut bench = Bench::around(sim);
    // The first sample is 7/8 into the first bit.
    bench.run_for(bits(128 * 11 - 1));
    assert_eq!(bench.sim.node(off).state(), FaultState::BusOff);
    bench.run_for(bits(1));
    assert_eq!(bench.sim.node(off).state(), FaultState::ErrorActive);
    assert_eq!((bench.sim.node(off).fault().tec(), bench.sim.node(off).fault().rec()), (0, 0));
    bench.finish();
}

#[test]
fn rule_12_counts_sequences_between_frames_too() {
    let mut sim = Simulation::new(1);
    let off = sim.add_node_with(node("a"), FaultConfinement::with_counters(256, 0)).unwrap();
    let ids: Vec<_> = (0..2).map(|_| sim.add_node(node("n")).unwrap()).collect();
    let mut bench = Bench::around(sim);
    // Back to back: ACK delimiter, EOF and intermission are exactly 11 recessive bits.
    for _ in 0..140 {
        bench.sim.send_at(Time::ZERO, ids[0], data(1, &[0x55]));
    }
    let mut frames = 0;
    while bench.sim.node(off).state() == FaultState::BusOff {
        bench.run_bits(10);
        frames = bench.journal.transmitted(ids[0]);
    }
    // One sequence while it starts, one after each frame.
    assert!((126..=128).contains(&frames), "{frames}");
    bench.finish();
}

#[test]
fn rec_past_the_passive_limit_is_not_increased_any_further() {
    let nodes = vec![(node("a"), 0, 0), (node("b"), 0, 128)];
    let (mut bench, ids, sof) = sending(zebra(), nodes);
    destroy(&mut bench, sof);
    bench.run_bits(60);
    assert!(bench.journal.errors(ids[1]) >= 1);
    assert_eq!(bench.sim.node(ids[1]).fault().rec(), 128);
    bench.finish();
}

#[test]
fn passive_transmitter_suspends_for_eight_bits_and_lets_others_go_first() {
    let (mut bench, ids, _) = sending(zebra(), vec![(node("a"), 130, 0), (node("b"), 0, 0)]);
    bench.sim.send_at(bench.sim.now(), ids[0], data(0x100, &[1]));
    bench.sim.send_at(bench.sim.now(), ids[1], data(0x700, &[2]));
    bench.run_bits(400);
    let order: Vec<_> = bench
        .journal
        .events
        .iter()
        .filter_map(|(_, n, e)| match e {
            Event::Transmitted { frame } => Some((*n, frame.id().raw())),
            _ => None,
        })
        .collect();
    // Identifier 0x700 loses against 0x100, but 0x100 has to wait.
    assert_eq!(order, [(ids[0], 0x555), (ids[1], 0x700), (ids[0], 0x100)]);
    bench.finish();
}

#[test]
fn last_bit_of_eof_dominant_is_overload_for_a_receiver_and_an_error_for_the_transmitter() {
    let (mut bench, ids, _) = sending(zebra(), three());
    while bench.journal.received(ids[1]).is_empty() {
        bench.run_for(Span::from_ns(BIT_NS / 4));
    }
    // Bit 6 of EOF has been sampled; the next one starts within a quarter of a bit.
    let now = bench.sim.now();
    bench.sim.dominant_at(now + Span::from_ns(BIT_NS / 4), bits(1));
    bench.run_bits(160);
    assert!(bench.journal.of(ids[1]).any(|event| *event == Event::Overload));
    assert_eq!(bench.journal.errors(ids[1]), 0);
    assert_eq!(bench.journal.errors(ids[0]), 1);
    // The well known consequence: the frame arrives twice.
    assert_eq!(bench.journal.received(ids[1]), [zebra(), zebra()]);
    bench.finish();
}
