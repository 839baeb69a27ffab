//! Frames of every kind arrive, under all checkers.

mod common;

use canbaud::wire::{FdCrc, Frame, FrameKind, Id};
use canbaud_sim::{Event, Mode, NodeConfig, Rng, Span, Time};
use common::{Bench, any_frame, data, node};

#[test]
fn thousand_frames_of_every_kind_arrive_at_nodes_with_different_clocks() {
    for (seed, fd, fd_crc) in
        [(1, false, FdCrc::Iso), (2, true, FdCrc::Iso), (3, true, FdCrc::NonIso)]
    {
        let configs = (0..4)
            .map(|n| {
                let mut config = node("n").with_ppb(n * 400_000 - 600_000);
                config.fd_crc = fd_crc;
                config.with_data_bitrate(2_000_000).unwrap()
            })
            .collect();
        let (mut bench, ids) = Bench::new(seed, configs);
        let mut rng = Rng::new(seed);
        let mut sent = Vec::new();
        for n in 0..1_000 {
            let frame = any_frame(&mut rng, fd);
            // Same identifier from two nodes at a time would be a mistake of the test.
            let sender = ids[n % 4];
            bench.sim.send_at(Time::ZERO + Span::from_us(100), sender, frame);
            sent.push((sender, frame));
        }
        bench.run_for(Span::from_s(1));
        for id in &ids {
            let mine = sent.iter().filter(|(sender, _)| sender == id).count();
            assert_eq!(bench.journal.transmitted(*id), mine, "seed {seed}");
            assert_eq!(bench.journal.received(*id).len(), sent.len() - mine, "seed {seed}");
        }
        assert_eq!(bench.checker.decoded(), 1_000);
        bench.finish();
    }
}

#[test]
fn lower_identifier_wins_and_the_loser_sends_afterwards() {
    let (mut bench, ids) = Bench::new(1, vec![node("a"), node("b"), node("c")]);
    let at = Time::ZERO + Span::from_us(50);
    bench.sim.send_at(at, ids[0], data(0x456, &[1]));
    bench.sim.send_at(at, ids[1], data(0x455, &[2]));
    bench.run_bits(400);
    let seen: Vec<_> = bench.journal.received(ids[2]).iter().map(|f| f.id().raw()).collect();
    assert_eq!(seen, [0x455, 0x456]);
    // 0x456 and 0x455 differ in the last two bits: the loser sends 1 where the winner sends 0 in
    // the tenth bit of the identifier. SOF is bit 0, and 1000101 needs no stuff bit.
    assert!(bench.journal.of(ids[0]).any(|e| *e == Event::ArbitrationLost { bit: 10 }));
    bench.finish();
}

#[test]
fn standard_format_wins_over_extended_of_the_same_first_eleven_bits() {
    let (mut bench, ids) = Bench::new(1, vec![node("a"), node("b"), node("c")]);
    let extended = Frame::new(Id::Extended(0x123 << 18), FrameKind::Data, 0, &[]).unwrap();
    let remote = Frame::new(Id::Base(0x123), FrameKind::Remote, 4, &[]).unwrap();
    let at = Time::ZERO + Span::from_us(50);
    bench.sim.send_at(at, ids[0], extended);
    bench.sim.send_at(at, ids[1], remote);
    bench.run_bits(400);
    assert_eq!(bench.journal.received(ids[2]), [remote, extended]);
    bench.finish();
}

#[test]
fn one_seed_is_one_run_bit_for_bit() {
    let run = |seed| {
        let mut config = node("a");
        config.transceiver.jitter = Span::from_ns(30);
        let (mut bench, ids) = Bench::new(seed, vec![config.clone(), config]);
        let mut rng = Rng::new(7);
        for _ in 0..50 {
            bench.sim.send_at(Time::ZERO, ids[0], any_frame(&mut rng, false));
            bench.sim.send_at(Time::ZERO, ids[1], any_frame(&mut rng, false));
        }
        bench.run_for(Span::from_ms(30));
        bench.finish();
        (bench.journal.edges, bench.journal.events)
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1).0, run(2).0);
}

#[test]
fn monitoring_node_receives_and_drives_nothing() {
    let mode = |mode| node("m").with_mode(mode);
    let configs = vec![node("a"), node("b"), mode(Mode::BusMonitoring), mode(Mode::Disabled)];
    let (mut bench, ids) = Bench::new(1, configs);
    bench.sim.send_at(Time::ZERO, ids[0], data(1, &[0; 8]));
    bench.sim.send_at(Time::ZERO, ids[2], data(2, &[0; 8]));
    bench.run_bits(500);
    assert_eq!(bench.journal.received(ids[2]), [data(1, &[0; 8])]);
    assert!(bench.journal.received(ids[3]).is_empty());
    assert!(bench.journal.txd.iter().all(|(_, node, _)| *node != ids[2]));
    assert_eq!(bench.sim.node(ids[2]).pending(), 1);
    bench.finish();
}

/// A single talker whom nobody acknowledges: its error flags are form errors to a listener.
#[test]
fn lone_talker_ends_error_passive_and_a_monitor_gets_its_frames_only_then() {
    let (mut bench, ids) = Bench::new(1, vec![node("a"), node("m").with_mode(Mode::BusMonitoring)]);
    bench.sim.send_at(Time::ZERO, ids[0], data(0x321, &[1, 2, 3]));
    bench.run_for(Span::from_ms(20));
    assert_eq!(bench.sim.node(ids[0]).fault().tec(), 128);
    let first = bench
        .journal
        .events
        .iter()
        .position(|(_, n, e)| *n == ids[1] && matches!(e, Event::Received { .. }));
    let attempts = bench.journal.events[..first.unwrap()]
        .iter()
        .filter(|(_, _, e)| matches!(e, Event::TransmissionStarted { .. }))
        .count();
    // 16 active error flags raise TEC by 8 each to 128; the 17th attempt ends in a passive one.
    assert_eq!(attempts, 17);
    assert_eq!(bench.sim.node(ids[1]).fault().rec(), 0);
    bench.finish();
}

#[test]
fn loopback_talks_to_itself_alone() {
    let configs = vec![node("a").with_mode(Mode::Loopback), node("b")];
    let (mut bench, ids) = Bench::new(1, configs);
    bench.sim.send_at(Time::ZERO, ids[0], data(0x321, &[1, 2, 3]));
    bench.run_bits(300);
    assert_eq!(bench.journal.transmitted(ids[0]), 1);
    assert!(bench.journal.edges.is_empty());
    bench.finish();
}

#[test]
fn restricted_node_acknowledges_and_sends_nothing_else() {
    let configs = vec![node("a"), node("r").with_mode(Mode::Restricted)];
    let (mut bench, ids) = Bench::new(1, configs);
    bench.sim.send_at(Time::ZERO, ids[0], data(0x321, &[1, 2, 3]));
    bench.sim.send_at(Time::ZERO, ids[1], data(0x322, &[]));
    bench.run_bits(300);
    assert_eq!(bench.journal.transmitted(ids[0]), 1);
    assert_eq!(bench.journal.transmitted(ids[1]), 0);
    // One ACK: to dominant and back.
    assert_eq!(bench.journal.txd.iter().filter(|(_, n, _)| *n == ids[1]).count(), 2);
    bench.finish();
}

#[test]
fn one_shot_gives_up_after_the_first_error() {
    let mut config = node("a");
    config.retransmission = canbaud_sim::Retransmission::OneShot;
    let (mut bench, ids) = Bench::new(1, vec![config]);
    bench.sim.send_at(Time::ZERO, ids[0], data(0x321, &[1]));
    bench.run_bits(1_000);
    assert_eq!(bench.sim.node(ids[0]).pending(), 0);
    assert_eq!(bench.sim.node(ids[0]).fault().tec(), 8);
    assert!(bench.journal.of(ids[0]).any(|e| matches!(e, Event::Abandoned { .. })));
    bench.finish();
}

#[test]
fn data_phase_faster_than_the_loop_delay_needs_tdc() {
    for (tdc, want) in [(canbaud_sim::Tdc::Off, 0), (canbaud_sim::Tdc::Offset(8), 1)] {
        let config = |name| -> NodeConfig {
            let mut config = node(name).with_data_bitrate(8_000_000).unwrap();
            // 240 ns there and back, almost two bits of 8 Mbit/s.
            config.transceiver = canbaud_sim::Transceiver::symmetrical(Span::from_ns(120));
            config.tdc = tdc;
            config
        };
        let (mut bench, ids) = Bench::new(1, vec![config("a"), config("b")]);
        let kind = FrameKind::Fd { brs: true, esi: false };
        let frame = Frame::new(Id::Base(0x55), kind, 15, &[0xA5; 64]).unwrap();
        bench.sim.send_at(Time::ZERO, ids[0], frame);
        bench.run_bits(150);
        assert_eq!(bench.journal.transmitted(ids[0]), want, "{tdc:?}");
        assert_eq!(bench.journal.errors(ids[0]) == 0, want == 1, "{tdc:?}");
        bench.finish();
    }
}

#[test]
fn tolerant_node_keeps_still_in_a_can_fd_frame_and_a_classic_one_destroys_it() {
    use canbaud_sim::FdSupport;
    for (support, want) in [(FdSupport::Tolerant, 1), (FdSupport::None, 0)] {
        let mut third = node("c");
        third.fd = support;
        let fd = |name| node(name).with_data_bitrate(2_000_000).unwrap();
        let (mut bench, ids) = Bench::new(1, vec![fd("a"), fd("b"), third]);
        let kind = FrameKind::Fd { brs: true, esi: false };
        let frame = Frame::new(Id::Base(0x55), kind, 8, &[0x3C; 8]).unwrap();
        bench.sim.send_at(Time::ZERO, ids[0], frame);
        bench.run_bits(120);
        assert_eq!(bench.journal.transmitted(ids[0]), want, "{support:?}");
        bench.finish();
    }
}

#[test]
fn storm_of_glitches_within_one_bit_of_a_slow_node_is_survived() {
    use canbaud_sim::{Blind, Simulation};
    let mut sim = Simulation::new(1);
    let slow = || NodeConfig::at("slow", 10_000).unwrap();
    let ids = [sim.add_node(slow()).unwrap(), sim.add_node(slow()).unwrap()];
    // Ten thousand edges in a tenth of a millisecond, which is one bit, and then a frame.
    let storm = Time::ZERO + Span::from_ms(3);
    for n in 0..5_000 {
        sim.dominant_at(storm + Span::from_ns(20 * n), Span::from_ns(10));
    }
    sim.send_at(storm + Span::from_ms(5), ids[0], data(0x123, &[1, 2]));
    sim.run(storm + Span::from_ms(30), &mut Blind);
    assert_eq!(sim.node(ids[0]).pending(), 0);
}
