//! The gate circuit, the controller as software sees it, the capture timer, the polling loop and
//! the benchmark set.

mod common;

use canbaud::wire::Level::{self, Dominant, Recessive};
use canbaud_sim::around::{CaptureTimer, Controller, ControllerSettings, Fifo, PollingLoop};
use canbaud_sim::benchmark::{Case, PLAIN, Scene, Traffic, grid};
use canbaud_sim::{Blind, Gate, Mode, NodeConfig, Observer, Rng, Simulation, Span, Stop, Time};
use common::{Bench, data, node};

#[test]
fn gate_circuit_is_table_3_of_koppe() {
    // Tx-CAN, Rx of the transceiver, Rx-CAN.
    let table = [
        (Recessive, Recessive, Recessive),
        (Recessive, Dominant, Dominant),
        (Dominant, Recessive, Dominant),
        (Dominant, Dominant, Dominant),
    ];
    for gate in [Gate::Open, Gate::Closed] {
        for (txd, rxd, want) in table {
            assert_eq!(gate.controller_rxd(txd, rxd), want, "{gate:?} {txd:?} {rxd:?}");
        }
    }
    assert_eq!(Gate::Closed.transceiver_txd(Dominant), Recessive);
    assert_eq!(Gate::Open.transceiver_txd(Dominant), Dominant);
}

#[test]
fn closed_gate_lets_a_normal_controller_read_and_drive_nothing() {
    let mut gated = node("gated");
    gated.gate = Gate::Closed;
    let mut wrong = NodeConfig::at("wrong", 250_000).unwrap();
    wrong.gate = Gate::Closed;
    let (mut bench, ids) = Bench::new(1, vec![node("a"), node("b"), gated, wrong]);
    for n in 0..20 {
        bench.sim.send_at(Time::ZERO + Span::from_us(300 * n), ids[0], data(0x123, &[n as u8; 8]));
    }
    bench.run_for(Span::from_ms(8));
    assert_eq!(bench.journal.received(ids[2]).len(), 20);
    assert_eq!(bench.journal.errors(ids[0]), 0);
    assert!(bench.journal.errors(ids[3]) > 0);
    assert!(bench.journal.txd.iter().all(|(_, n, _)| *n != ids[2] && *n != ids[3]));
    bench.finish();
}

fn pump(sim: &mut Simulation, controller: &mut Controller, until: Time) {
    while sim.run(until, &mut Blind) == Stop::News {
        for (at, _, event) in sim.take_news() {
            controller.notice(at, &event);
        }
    }
    for (at, _, event) in sim.take_news() {
        controller.notice(at, &event);
    }
}

#[test]
fn controller_keeps_stale_frames_and_hears_nothing_during_reconfiguration() {
    for (fifo, stale) in [(Fifo::Kept, 3), (Fifo::Cleared, 0)] {
        let mut sim = Simulation::new(1);
        let talkers = [0, 1].map(|_| sim.add_node(node("t")).unwrap());
        let id = sim.add_node(node("scanner").with_mode(Mode::BusMonitoring)).unwrap();
        sim.watch(id);
        let settings = ControllerSettings { reconfiguration: Span::from_ms(1), depth: 3, fifo };
        let mut controller = Controller::new(id, settings);
        for n in 0..20 {
            sim.send_at(Time::ZERO + Span::from_us(100 + 250 * n), talkers[0], data(1, &[n as u8]));
        }
        pump(&mut sim, &mut controller, Time::ZERO + Span::from_us(2_000));
        // One of them was received while the FIFO was full.
        assert!(controller.overruns() > 0);
        let before = sim.now();
        let timing = NodeConfig::at("", 250_000).unwrap().nominal;
        let ready = controller.reconfigure(timing, Mode::BusMonitoring, &mut sim).unwrap();
        assert_eq!(ready, before + Span::from_ms(1));
        pump(&mut sim, &mut controller, ready);
        let mut left = 0;
        while let Some(received) = controller.read() {
            assert!(received.at <= before, "a frame came in while it was off");
            left += 1;
        }
        assert_eq!(left, stale, "{fifo:?}");
        assert_eq!(controller.errors(), 0);
        pump(&mut sim, &mut controller, ready + Span::from_ms(3));
        let error = controller.take_error().expect("250 kbit/s on a bus of 500 kbit/s");
        assert!(error.at > ready);
        assert_eq!(controller.counters(&sim), (0, 0));
    }
}

#[test]
fn capture_timer_wraps_and_loses_edges_that_come_too_fast() {
    let us = |n: u64| Time::ZERO + Span::from_us(n);
    let mut timer = CaptureTimer::new(1_000_000, 0, 16, Span::ZERO).unwrap();
    assert_eq!(timer.edge(us(65_535), Dominant).unwrap().ticks, 65_535);
    assert_eq!(timer.edge(us(65_536), Recessive).unwrap().ticks, 0);
    // Ten microseconds from edge to read: the edge at 103 is overwritten by the one at 105.
    let mut slow = CaptureTimer::new(1_000_000, 0, 32, Span::from_us(10)).unwrap();
    assert_eq!(slow.edge(us(80), Dominant), None);
    assert_eq!(slow.edge(us(100), Recessive).map(|c| (c.ticks, c.overrun)), Some((80, false)));
    assert_eq!(slow.edge(us(103), Dominant), None);
    assert_eq!(slow.edge(us(105), Recessive), None);
    assert_eq!(slow.finish().map(|c| (c.ticks, c.overrun)), Some((105, true)));
}

/// Dominant pulses as the loop of AP2925 measures them.
struct Loop {
    polling: PollingLoop,
    pulses: Vec<u64>,
}

impl Observer for Loop {
    fn bus(&mut self, at: Time, level: Level) {
        self.pulses.extend(self.polling.edge(at, level).map(|pulse| pulse.ticks));
    }
}

#[test]
fn polling_loop_stays_inside_the_ranges_of_ap2925_table_1() {
    // 24 MHz: bit rate, lowest and highest tick of the range.
    for (bitrate, low, high) in [
        (1_000_000, 20, 27),
        (500_000, 40, 55),
        (250_000, 86, 107),
        (125_000, 180, 201),
        (50_000, 470, 489),
    ] {
        let mut least = u64::MAX;
        let mut rng = Rng::new(u64::from(bitrate));
        for phase in 0..8 {
            let mut sim = Simulation::new(phase);
            let config = || NodeConfig::at("n", bitrate).unwrap().with_ppb(phase as i64 * 20_000);
            let ids = [sim.add_node(config()).unwrap(), sim.add_node(config()).unwrap()];
            let mut polling = Loop {
                polling: PollingLoop::new(24_000_000, 0, 4, 20, phase).unwrap(),
                pulses: Vec::new(),
            };
            for n in 0..12 {
                let at = Time::ZERO + Span::from_us(n * 4_000) + Span::from_ns(rng.below(50_000));
                sim.send_at(at, ids[0], data(0x2A5, &[rng.bits() as u8, n as u8]));
            }
            sim.run(Time::ZERO + Span::from_ms(60), &mut polling);
            assert!(polling.pulses.len() > 100);
            let shortest = *polling.pulses.iter().min().unwrap();
            assert!((low..=high).contains(&shortest), "{bitrate}: {shortest}");
            least = least.min(shortest);
        }
        // The quantisation is there: a turn of four clocks.
        let exact = 24_000_000 / u64::from(bitrate);
        assert!(least <= exact && exact - least <= 4, "{bitrate}: {least}");
    }
}

#[test]
fn benchmark_captures_are_labelled_and_repeatable() {
    let cases = grid();
    assert!(cases.len() > 600, "{}", cases.len());
    let rates: std::collections::HashSet<_> = cases.iter().map(|case| case.bitrate).collect();
    assert_eq!(rates.len(), 24);
    for case in cases.iter().step_by(7) {
        let frames = if case.load_permille == 1 { 2 } else { 6 };
        let capture = case.generate(9, frames).unwrap_or_else(|| panic!("{case:?}"));
        assert_eq!(capture.truth.bitrate, case.bitrate);
        assert!(!capture.edges.is_empty(), "{case:?}");
        assert!(capture.edges.windows(2).all(|pair| pair[0].0 < pair[1].0), "{case:?}");
        assert!(capture.edges.windows(2).all(|pair| pair[0].1 != pair[1].1), "{case:?}");
        assert_eq!(Some(capture), case.generate(9, frames), "{case:?}");
    }
}

#[test]
fn benchmark_scenes_are_what_they_say() {
    let with = |scene| Case { scene, ..PLAIN }.generate(3, 40).unwrap();
    assert_eq!(with(Scene::Acknowledged).truth.frames.len(), 40);
    assert_eq!(with(Scene::OneFrame).truth.frames.len(), 1);
    assert!(with(Scene::Unacknowledged).truth.frames.is_empty());
    assert!(!with(Scene::Inverted).starts_high);
    assert!(with(Scene::Glitches(10)).edges.len() > with(Scene::Acknowledged).edges.len() + 200);
    // An error flag with its echo lasts for six bits and more: 96 ticks of 8 MHz.
    let flags = with(Scene::ErrorFlags).edges;
    assert!(flags.windows(2).any(|pair| !pair[0].1 && pair[1].0 - pair[0].0 >= 95));
    let fd = Case { traffic: Traffic::FdBrs(2_000_000), timer_hz: 72_000_000, ..PLAIN };
    let capture = fd.generate(3, 20).unwrap();
    assert_eq!((capture.truth.data_bitrate, capture.truth.frames.len()), (Some(2_000_000), 20));
    // The shortest pulses are data bits of 36 ticks.
    let shortest = capture.edges.windows(2).map(|pair| pair[1].0 - pair[0].0).min().unwrap();
    assert!((33..=37).contains(&shortest), "{shortest}");
}
