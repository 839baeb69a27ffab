//! The corners of synchronization: phase error below, at and above SJW, of both signs, in each
//! segment; and the edges that must not synchronize.

mod common;

use canbaud::wire::{Frame, FrameKind, Id, Level};
use canbaud_sim::{
    BitTiming, Blind, NodeConfig, NodeId, Observer, Sample, Sampling, Simulation, Span,
    SyncOutcome, Time, Transceiver,
};
use common::node;

/// A quantum of the tests: 10 periods of 80 MHz.
const QUANTUM_NS: u64 = 125;
const PROP_SEG: i64 = 4;
const PHASE_SEG1: i64 = 6;
const PHASE_SEG2: i64 = 5;
const QUANTA: i64 = 1 + PROP_SEG + PHASE_SEG1 + PHASE_SEG2;
const SAMPLE: i64 = 1 + PROP_SEG + PHASE_SEG1;

#[derive(Default)]
struct Samples(Vec<(Time, Level)>);

impl Observer for Samples {
    const SAMPLING: Sampling = Sampling::InTime;
    fn sample(&mut self, at: Time, _: NodeId, sample: &Sample) {
        self.0.push((at, sample.level));
    }
}

fn quanta(count: i64) -> Span {
    Span::from_ns(QUANTUM_NS * count as u64)
}

fn config(sjw: i64) -> NodeConfig {
    let timing = [10, PROP_SEG, PHASE_SEG1, PHASE_SEG2, sjw].map(|value| value as u32);
    NodeConfig {
        nominal: BitTiming::new(timing[0], timing[1], timing[2], timing[3], timing[4]).unwrap(),
        transceiver: Transceiver::symmetrical(Span::ZERO),
        ..node("ear")
    }
}

/// SOF, two recessive bits, and an edge that lies `error` quanta from where the fourth bit should
/// start. Returns what that edge did, and how many quanta after the third sample the fourth came.
fn phase_error(error: i64, sjw: i64) -> (SyncOutcome, i64) {
    let mut sim = Simulation::new(1);
    let ear = sim.add_node(config(sjw)).unwrap();
    // In the middle of a quantum, so that the quantum that holds the edge is plain.
    let sof = Time::ZERO + quanta(QUANTA * 20) + Span::from_ns(QUANTUM_NS / 2);
    sim.dominant_at(sof, quanta(QUANTA));
    let edge = sof + quanta(3 * QUANTA + error);
    sim.dominant_at(edge, quanta(QUANTA));
    let mut samples = Samples::default();
    sim.run(sof + quanta(5 * QUANTA), &mut samples);
    let outcome = sim.node(ear).last_sync().unwrap();
    let fourth = samples.0.iter().position(|(at, _)| *at > sof + quanta(3 * QUANTA)).unwrap();
    let (third, fourth) = (samples.0[fourth - 1].0, samples.0[fourth].0);
    (outcome, (fourth.since(third).femtoseconds() / (QUANTUM_NS * 1_000_000)) as i64)
}

fn lengthened(error: i64, by: i64) -> (SyncOutcome, i64) {
    (SyncOutcome::Lengthened { error: error as u32, by: by as u32 }, QUANTA + by)
}

fn shortened(error: i64, by: i64) -> (SyncOutcome, i64) {
    (SyncOutcome::Shortened { error: error as u32, by: by as u32 }, QUANTA - by)
}

#[test]
fn edge_in_sync_seg_changes_nothing() {
    assert_eq!(phase_error(0, 3), (SyncOutcome::InSyncSeg, QUANTA));
}

#[test]
fn positive_error_below_sjw_in_prop_seg_lengthens_by_the_error() {
    assert_eq!(phase_error(2, 3), lengthened(2, 2));
}

#[test]
fn positive_error_equal_to_sjw_in_prop_seg_lengthens_by_sjw() {
    assert_eq!(phase_error(3, 3), lengthened(3, 3));
}

#[test]
fn positive_error_above_sjw_in_prop_seg_lengthens_by_sjw() {
    assert_eq!(phase_error(4, 3), lengthened(4, 3));
}

#[test]
fn positive_error_below_sjw_in_phase_seg1_lengthens_by_the_error() {
    // PHASE_SEG1 begins with quantum 5; SJW can be 5 at most here, so PROP_SEG is made short.
    let mut sim = Simulation::new(1);
    let timing = BitTiming::new(10, 1, 6, 5, 5).unwrap();
    let ear = sim.add_node(NodeConfig { nominal: timing, ..config(3) }).unwrap();
    let bit = i64::from(timing.quanta());
    let sof = Time::ZERO + quanta(bit * 20) + Span::from_ns(QUANTUM_NS / 2);
    sim.dominant_at(sof, quanta(bit));
    sim.dominant_at(sof + quanta(3 * bit + 4), quanta(bit));
    sim.run(sof + quanta(5 * bit), &mut Blind);
    let outcome = sim.node(ear).last_sync().unwrap();
    assert_eq!(outcome, SyncOutcome::Lengthened { error: 4, by: 4 });
}

#[test]
fn positive_error_equal_to_sjw_in_phase_seg1_lengthens_by_sjw() {
    assert_eq!(phase_error(5, 5), lengthened(5, 5));
}

#[test]
fn positive_error_above_sjw_in_phase_seg1_lengthens_by_sjw() {
    for error in PROP_SEG + 1..SAMPLE {
        assert_eq!(phase_error(error, 3), lengthened(error, 3));
    }
}

#[test]
fn negative_error_below_sjw_ends_phase_seg2_at_once() {
    assert_eq!(phase_error(-2, 3), shortened(2, 2));
}

#[test]
fn negative_error_equal_to_sjw_ends_phase_seg2_at_once() {
    assert_eq!(phase_error(-3, 3), shortened(3, 3));
}

#[test]
fn negative_error_above_sjw_shortens_phase_seg2_by_sjw() {
    assert_eq!(phase_error(-4, 3), shortened(4, 3));
    assert_eq!(phase_error(-5, 3), shortened(5, 3));
}

#[test]
fn every_phase_error_with_every_sjw_obeys_the_rule() {
    for sjw in 1..=PHASE_SEG2 {
        for error in -PHASE_SEG2..SAMPLE {
            let by = error.abs().min(sjw);
            let want = match error {
                0 => (SyncOutcome::InSyncSeg, QUANTA),
                1.. => lengthened(error, by),
                _ => shortened(-error, by),
            };
            assert_eq!(phase_error(error, sjw), want, "error {error} SJW {sjw}");
        }
    }
}

/// Edges at `at` (in quanta after SOF, half a quantum in) to dominant, `width` long each.
fn after_pulses(pulses: &[(i64, i64)], until: i64) -> (Simulation, NodeId) {
    let mut sim = Simulation::new(1);
    let ear = sim.add_node(config(3)).unwrap();
    let sof = Time::ZERO + quanta(QUANTA * 20) + Span::from_ns(QUANTUM_NS / 2);
    for (at, width) in pulses {
        sim.dominant_at(sof + quanta(*at), quanta(*width));
    }
    sim.run(sof + quanta(until), &mut Blind);
    (sim, ear)
}

#[test]
fn only_the_first_edge_between_two_sample_points_synchronizes() {
    // SOF, one recessive bit, a glitch of 2 quanta with error 1 and a second edge with error 5.
    let bit = 2 * QUANTA;
    let pulses = [(0, QUANTA), (bit + 1, 2), (bit + 5, QUANTA)];
    let (sim, ear) = after_pulses(&pulses, bit + QUANTA);
    assert_eq!(sim.node(ear).last_sync(), Some(SyncOutcome::Lengthened { error: 1, by: 1 }));
    let corners = sim.node(ear).sync_corners();
    assert_eq!((corners.hard, corners.positive), (1, [1, 0, 0]));
}

#[test]
fn edge_after_a_dominant_sample_does_not_synchronize() {
    // SOF was sampled dominant; the line blinks recessive in PHASE_SEG2 and comes back.
    let pulses = [(0, SAMPLE + 1), (SAMPLE + 3, QUANTA)];
    let (sim, ear) = after_pulses(&pulses, 2 * QUANTA);
    assert_eq!(sim.node(ear).sync_corners().negative, [0, 0, 0]);
    assert_eq!(sim.node(ear).last_sync(), Some(SyncOutcome::Hard));
}

#[test]
fn recessive_edges_do_not_synchronize() {
    // One and a half bits dominant: the edge back to recessive lies in the middle of a bit.
    let (sim, ear) = after_pulses(&[(0, QUANTA * 3 / 2)], 4 * QUANTA);
    let corners = sim.node(ear).sync_corners();
    assert_eq!(corners.positive.iter().chain(&corners.negative).sum::<u64>(), 0);
}

#[test]
fn glitch_on_an_idle_bus_is_a_hard_synchronization_and_nothing_more() {
    let (sim, ear) = after_pulses(&[(0, 3)], 10 * QUANTA);
    assert_eq!(sim.node(ear).sync_corners().hard, 1);
    assert_eq!(sim.node(ear).fault().rec(), 0);
}

/// Two nodes; the second one's clock is `ppb` fast. Frames with the least edges there are.
fn long_frames(ppb: i64, sjw: u32) -> (usize, Simulation) {
    let mut sim = Simulation::new(1);
    let timing = BitTiming::new(10, 7, 4, 4, sjw).unwrap();
    let ids = [0, ppb].map(|ppb| {
        sim.add_node(NodeConfig { nominal: timing, ..node("n").with_ppb(ppb) }).unwrap()
    });
    for _ in 0..20 {
        let frame = Frame::new(Id::Base(0), FrameKind::Data, 8, &[0; 8]).unwrap();
        sim.send_at(Time::ZERO, ids[0], frame);
    }
    let mut journal = common::Journal::default();
    sim.run(Time::ZERO + Span::from_ms(8), &mut journal);
    (journal.received(ids[1]).len(), sim)
}

#[test]
fn clock_difference_within_the_capture_range_costs_no_frame() {
    // Ten bits between two edges: each SJW quantum of 16 makes good 1/160 = 0.625 %.
    for (ppb, sjw) in [(5_000_000, 1), (-5_000_000, 1), (9_000_000, 2), (-9_000_000, 2)] {
        let (received, sim) = long_frames(ppb, sjw);
        assert_eq!(received, 20, "{ppb} ppb SJW {sjw}");
        assert_eq!(sim.node(NodeId(1)).fault().rec(), 0);
    }
}

#[test]
fn clock_difference_beyond_the_capture_range_costs_frames() {
    for ppb in [25_000_000, -25_000_000] {
        let (received, sim) = long_frames(ppb, 1);
        assert!(received < 20, "{ppb} ppb: {received}");
        assert!(sim.node(NodeId(0)).fault().tec() > 0);
    }
}

#[test]
fn transmitter_that_sends_dominant_ignores_a_positive_phase_error() {
    // Its own edge comes back 500 ns (4 quanta) late: each would look like a positive error.
    let mut sim = Simulation::new(1);
    let timing = BitTiming::new(10, 7, 4, 4, 2).unwrap();
    let slow = Transceiver::symmetrical(Span::from_ns(250));
    let ids = [0, 1].map(|_| {
        sim.add_node(NodeConfig { nominal: timing, transceiver: slow, ..node("n") }).unwrap()
    });
    sim.send_at(Time::ZERO, ids[0], common::data(0x555, &[0x55; 8]));
    let mut samples = common::Journal::default();
    sim.run(Time::ZERO + Span::from_us(300), &mut samples);
    let corners = sim.node(ids[0]).sync_corners();
    assert!(corners.ignored > 30);
    assert_eq!(corners.negative, [0, 0, 0]);
    // The acknowledgement is the one edge that it does not drive.
    assert_eq!(corners.positive.iter().sum::<u64>(), 1);
    assert_eq!(samples.transmitted(ids[0]), 1);
}

#[test]
fn receivers_synchronize_hard_at_the_edge_from_fdf_to_res() {
    let mut sim = Simulation::new(1);
    let config = || node("n").with_data_bitrate(2_000_000).unwrap();
    let ids = [sim.add_node(config()).unwrap(), sim.add_node(config()).unwrap()];
    let kind = FrameKind::Fd { brs: true, esi: false };
    let frame = Frame::new(Id::Base(0x123), kind, 1, &[0xA5]).unwrap();
    sim.send_at(Time::ZERO, ids[0], frame);
    sim.run(Time::ZERO + Span::from_us(200), &mut Blind);
    // SOF and res.
    assert_eq!(sim.node(ids[1]).sync_corners().hard, 2);
    assert_eq!(sim.node(ids[0]).sync_corners().hard, 0);
}

#[test]
fn drifting_clock_is_followed_piece_by_piece() {
    let mut sim = Simulation::new(1);
    let ids = [sim.add_node(node("a")).unwrap(), sim.add_node(node("b")).unwrap()];
    for step in 0..100_i64 {
        let at = Time::ZERO + Span::from_us(100 * step as u64);
        sim.drift_at(at, ids[1], step * 50_000).unwrap();
        sim.send_at(at, ids[0], common::data(0x123, &[0x55; 2]));
    }
    let mut journal = common::Journal::default();
    sim.run(Time::ZERO + Span::from_ms(15), &mut journal);
    assert_eq!(journal.received(ids[1]).len(), 100);
    assert_eq!(sim.node(ids[1]).config().oscillator.ppb, 4_950_000);
}
