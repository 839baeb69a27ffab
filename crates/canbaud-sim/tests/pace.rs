//! Computing many bits at a time changes nothing: every run is compared with the same one computed
//! sample point by sample point.

mod common;

use std::collections::BTreeMap;
use std::marker::PhantomData;

use canbaud::wire::{FdCrc, Level};
use canbaud_sim::{
    BitTiming, Event, FdSupport, Gate, Mode, NodeConfig, NodeId, Observer, Pace, Rng, Sample,
    SampleRun, Sampling, Simulation, Span, Stop, Tdc, Time, Transceiver,
};
use common::{any_frame, data, node};

/// Something that an observer is told.
#[derive(Debug, Clone, PartialEq)]
enum Told {
    Bus(Time, Level),
    Txd(Time, NodeId, Level),
    Event(Time, NodeId, Event),
    Sample(Time, NodeId, Sample),
    Samples(NodeId, SampleRun),
}

/// What of samples an observer wants to be told.
trait Wish {
    const SAMPLING: Sampling;
}

#[derive(Default)]
struct Untold;
#[derive(Default)]
struct InRuns;
#[derive(Default)]
struct InTime;

impl Wish for Untold {
    const SAMPLING: Sampling = Sampling::Untold;
}

impl Wish for InRuns {
    const SAMPLING: Sampling = Sampling::InRuns;
}

impl Wish for InTime {
    const SAMPLING: Sampling = Sampling::InTime;
}

/// Everything that it is told, in order; samples only if it wants them.
#[derive(Default)]
struct All<W>(Vec<Told>, PhantomData<W>);

impl<W: Wish> Observer for All<W> {
    const SAMPLING: Sampling = W::SAMPLING;

    fn bus(&mut self, at: Time, level: Level) {
        self.0.push(Told::Bus(at, level));
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        self.0.push(Told::Txd(at, node, level));
    }

    fn sample(&mut self, at: Time, node: NodeId, sample: &Sample) {
        self.0.push(Told::Sample(at, node, *sample));
    }

    fn samples(&mut self, node: NodeId, run: &SampleRun) {
        self.0.push(Told::Samples(node, *run));
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        self.0.push(Told::Event(at, node, event.clone()));
    }
}

/// How a bus is set up from a seed, and what is done to it.
type SetUp = fn(&mut Simulation, &mut Rng) -> Vec<NodeId>;

/// What a run comes to: what is told, and what the nodes say of themselves in the end.
fn run<W: Wish + Default>(seed: u64, pace: Pace, set_up: SetUp) -> (Vec<Told>, String) {
    let mut sim = Simulation::new(seed);
    sim.set_pace(pace);
    let mut rng = Rng::new(seed);
    let ids = set_up(&mut sim, &mut rng);
    let slices = [Span::from_us(500), Span::from_ns(1_750), Span::from_ms(20)];
    let slice = slices[rng.below(3) as usize];
    let mut all = All::<W>::default();
    while sim.now() < Time::ZERO + Span::from_ms(20) {
        if sim.run(sim.now() + slice, &mut all) == Stop::News {
            for (at, _, event) in sim.take_news() {
                if matches!(event, Event::Transmitted { .. }) {
                    sim.send_at(at, ids[0], data(0x155, &[0x55]));
                }
            }
        }
    }
    let node = |id: &NodeId| {
        let node = sim.node(*id);
        let timing = (node.sync_corners(), node.last_sync(), node.loop_delay());
        format!("{:?} {} {timing:?}\n", node.fault(), node.pending())
    };
    (all.0, ids.iter().map(node).collect())
}

fn is_no_sample(told: &&Told) -> bool {
    !matches!(told, Told::Sample(..) | Told::Samples(..))
}

/// Each sample of each node, out of the plain run.
fn samples_of(plain: &[Told]) -> BTreeMap<NodeId, Vec<(Time, Sample)>> {
    let mut nodes = BTreeMap::<_, Vec<_>>::new();
    for told in plain {
        if let Told::Sample(at, node, sample) = told {
            nodes.entry(*node).or_default().push((*at, *sample));
        }
    }
    nodes
}

/// Runs of a node are its samples one after the other, and come before what the node does next.
fn compare_runs(plain: &[Told], told: &[Told], seed: u64) {
    let samples = samples_of(plain);
    let mut done = BTreeMap::<NodeId, usize>::new();
    for one in told {
        match one {
            Told::Samples(node, run) => {
                let from = done.entry(*node).or_default();
                let these = &samples[node][*from..*from + run.bits as usize];
                *from += these.len();
                let (first, last) = (these[0], these[these.len() - 1]);
                assert_eq!((run.first, run.last), (first.0, last.0), "seed {seed}: {run:?}");
                assert!(these.iter().all(|(_, one)| *one == run.sample), "seed {seed}: {run:?}");
            }
            Told::Txd(at, node, _) | Told::Event(at, node, _) => {
                // A change of TXD between two samples of a run that is told later is no surprise.
                let event = matches!(one, Told::Event(..));
                let next = samples[node].get(done.get(node).copied().unwrap_or(0));
                let late = event && next.is_some_and(|(next, _)| next < at);
                assert!(!late, "seed {seed}: {one:?} before {next:?}");
            }
            Told::Bus(..) | Told::Sample(..) => {}
        }
    }
    let told: BTreeMap<_, _> = samples.iter().map(|(node, all)| (*node, all.len())).collect();
    assert_eq!(told, done, "seed {seed}: samples of each node");
}

/// Compares a run with and without samples with the plain one; returns how much was told.
fn compare(seed: u64, set_up: SetUp) -> usize {
    let (plain, end) = run::<InTime>(seed, Pace::EveryBit, set_up);
    let (in_time, in_time_end) = run::<InTime>(seed, Pace::Ahead, set_up);
    let differs = plain.iter().zip(&in_time).position(|(a, b)| a != b);
    assert_eq!(differs.map(|at| (&plain[at], &in_time[at])), None, "seed {seed}");
    assert_eq!((plain.len(), &end), (in_time.len(), &in_time_end), "seed {seed}");

    let (untold, untold_end) = run::<Untold>(seed, Pace::Ahead, set_up);
    let (in_runs, in_runs_end) = run::<InRuns>(seed, Pace::Ahead, set_up);
    let count = plain.iter().filter(is_no_sample).count();
    for (told, told_end) in [(&untold, untold_end), (&in_runs, in_runs_end)] {
        let (ours, theirs) = (plain.iter().filter(is_no_sample), told.iter().filter(is_no_sample));
        assert_eq!(ours.zip(theirs).find(|(a, b)| a != b), None, "seed {seed}");
        assert_eq!(told.iter().filter(is_no_sample).count(), count, "seed {seed}");
        assert_eq!(told_end, end, "seed {seed}");
    }
    compare_runs(&plain, &in_runs, seed);
    count
}

/// A bus on which nothing goes wrong.
fn quiet(sim: &mut Simulation, rng: &mut Rng) -> Vec<NodeId> {
    let fd = rng.below(2) == 0;
    let delay = Span::from_ns([0, 1, 60, 180, 700][rng.below(5) as usize]);
    let nodes = 1 + rng.below(5);
    let ids: Vec<_> = (0..nodes)
        .map(|_| {
            let mut config = node("n").with_ppb(rng.below(400_000) as i64 - 200_000);
            config.transceiver = Transceiver::symmetrical(delay);
            if fd {
                config = config.with_data_bitrate(2_000_000).unwrap();
            }
            sim.add_node(config).unwrap()
        })
        .collect();
    for _ in 0..50 {
        let at = Time::ZERO + Span::from_us(rng.below(19_000));
        sim.send_at(at, ids[rng.below(nodes) as usize], any_frame(rng, fd));
    }
    ids
}

/// A node of any kind.
fn any_node(rng: &mut Rng) -> NodeConfig {
    let bitrate = if rng.below(12) == 0 { 410_000 } else { 500_000 };
    let mut config = NodeConfig::at("n", bitrate).unwrap();
    config = config.with_ppb(rng.below(8_000_000) as i64 - 4_000_000);
    config.transceiver.jitter = Span::from_ns(rng.below(60));
    config.transceiver.rx_recessive = Span::from_ns(60 + rng.below(80));
    config.transceiver.propagation = Span::from_ns(rng.below(100));
    let kind = rng.below(10) as usize;
    config.mode = match kind {
        0 => Mode::BusMonitoring,
        1 => Mode::Restricted,
        2 => Mode::Loopback,
        _ => Mode::Normal,
    };
    config.fd = [FdSupport::None, FdSupport::Tolerant, FdSupport::Enabled][kind.min(2)];
    config.gate = if kind == 4 { Gate::Closed } else { Gate::Absent };
    if kind % 2 == 1 {
        config = config.with_data_bitrate([2_000_000, 8_000_000][kind / 5]).unwrap();
        config.tdc = [Tdc::Off, Tdc::Offset(8)][kind % 4 / 2];
        config.fd_crc = if kind == 9 { FdCrc::NonIso } else { FdCrc::Iso };
    }
    config
}

/// A bus on which everything goes wrong.
fn troubled(sim: &mut Simulation, rng: &mut Rng) -> Vec<NodeId> {
    let nodes = 2 + rng.below(5);
    let ids: Vec<_> = (0..nodes).map(|_| sim.add_node(any_node(rng)).unwrap()).collect();
    if rng.below(3) == 0 {
        sim.watch(ids[0]);
    }
    let fd = rng.below(2) == 0;
    for _ in 0..60 {
        let at = Time::ZERO + Span::from_us(rng.below(20_000));
        sim.send_at(at, ids[rng.below(nodes) as usize], any_frame(rng, fd));
    }
    for _ in 0..rng.below(30) {
        let at = Time::ZERO + Span::from_us(rng.below(20_000));
        let width = Span::from_ns(rng.below(5_000) + 1);
        let node = ids[rng.below(nodes) as usize];
        match rng.below(6) {
            0 => sim.dominant_at(at, width),
            1 => sim.recessive_at(at, width),
            2 => sim.force_rxd_at(at, node, Level::Dominant, width),
            3 => sim.force_rxd_at(at, node, Level::Recessive, width),
            4 => sim.drift_at(at, node, rng.below(20_000_000) as i64 - 10_000_000).unwrap(),
            _ => sim.reconfigure_at(at, node, any_node(rng)).unwrap(),
        }
    }
    ids
}

/// All clocks alike: everything happens in the same femtosecond.
fn coinciding(sim: &mut Simulation, rng: &mut Rng) -> Vec<NodeId> {
    let transceiver = Transceiver::symmetrical(Span::from_ns(250 * rng.below(3)));
    let ids: Vec<_> =
        (0..4).map(|_| sim.add_node(NodeConfig { transceiver, ..node("n") }).unwrap()).collect();
    for n in 0..40 {
        let at = Time::ZERO + Span::from_us(2 * rng.below(9_000));
        sim.send_at(at, ids[n % 4], any_frame(rng, false));
        // On sample points, and on bit boundaries.
        let at = Time::ZERO + Span::from_ns(250 * rng.below(80_000));
        match rng.below(12) {
            0 => sim.recessive_at(at, Span::from_us(2)),
            1 => sim.dominant_at(at, Span::from_us(2)),
            _ => {}
        }
    }
    ids
}

/// After some dominant bits a pulse follows each sample point, so that every bit loses its
/// PHASE_SEG2.
fn pulsed(sim: &mut Simulation, rng: &mut Rng) -> Vec<NodeId> {
    let mut config = node("n");
    config.nominal = BitTiming::new(10, 0, 10, 5, 5).unwrap();
    let ids = vec![sim.add_node(config).unwrap()];
    let pulse = Span::from_ns(50);
    for ms in 1..20 {
        let sof = Time::ZERO + Span::from_ms(ms);
        let dominant = 2_000 * (1 + rng.below(5));
        sim.dominant_at(sof, Span::from_ns(dominant));
        // The first recessive bit is sampled 1375 ns after its start, the others after a pulse.
        let first = dominant + 1_390 + rng.below(50);
        for n in 0..8 {
            sim.dominant_at(sof + Span::from_ns(first + 1_400 * n), pulse);
        }
    }
    ids
}

/// Listeners at a rate that is nearly right: they read some bits right, then others.
fn nearly(sim: &mut Simulation, rng: &mut Rng) -> Vec<NodeId> {
    let mut ids = vec![sim.add_node(node("sender")).unwrap()];
    for _ in 0..2 {
        let config = node("n").with_mode(Mode::BusMonitoring);
        let ppb = rng.below(500_000_000) as i64 - 250_000_000;
        ids.push(sim.add_node(config.with_ppb(ppb)).unwrap());
    }
    for n in 0..60 {
        let at = Time::ZERO + Span::from_ns(330_000 * n + rng.below(2_000));
        sim.send_at(at, ids[0], any_frame(rng, false));
    }
    ids
}

#[test]
fn bits_that_pulses_shorten_come_out_the_same() {
    let told: usize = (0..40).map(|seed| compare(seed, pulsed)).sum();
    assert!(told > 40 * 300, "{told}");
}

#[test]
fn listeners_at_nearly_the_right_rate_come_out_the_same() {
    let told: usize = (0..60).map(|seed| compare(seed, nearly)).sum();
    assert!(told > 60 * 1_000, "{told}");
}

#[test]
fn quiet_bus_comes_out_the_same() {
    let told: usize = (0..60).map(|seed| compare(seed, quiet)).sum();
    assert!(told > 60 * 2_000, "{told}");
}

#[test]
fn troubled_bus_comes_out_the_same() {
    let told: usize = (0..150).map(|seed| compare(seed, troubled)).sum();
    assert!(told > 150 * 1_000, "{told}");
}

#[test]
fn events_that_coincide_come_out_the_same() {
    let told: usize = (0..60).map(|seed| compare(seed, coinciding)).sum();
    assert!(told > 60 * 1_000, "{told}");
}

/// Most bits of a frame are not looked at one by one.
#[test]
fn computing_ahead_takes_a_fraction_of_the_steps() {
    let steps = |pace| {
        let mut sim = Simulation::new(1);
        sim.set_pace(pace);
        let config = |n: i64| node("n").with_ppb(10_000 * n);
        let ids: Vec<_> = (0..8).map(|n| sim.add_node(config(n)).unwrap()).collect();
        for n in 0..100_u64 {
            let at = Time::ZERO + Span::from_us(300 * n);
            sim.send_at(at, ids[n as usize % 8], data(0x100, &(n * 0x1234_5678).to_be_bytes()));
        }
        sim.run(Time::ZERO + Span::from_ms(40), &mut canbaud_sim::Blind);
        sim.steps()
    };
    let (ahead, plain) = (steps(Pace::Ahead), steps(Pace::EveryBit));
    assert!(ahead * 5 < plain, "{ahead} of {plain}");
}

/// Jitter wider than the pulses makes later edges come in before earlier ones.
#[test]
fn pulses_shorter_than_the_jitter_are_survived() {
    let mut sim = Simulation::new(3);
    let mut jittery = node("jittery");
    jittery.transceiver.jitter = Span::from_ns(60);
    let ids = [sim.add_node(jittery.clone()).unwrap(), sim.add_node(jittery).unwrap()];
    for n in 0..20_000 {
        sim.dominant_at(Time::ZERO + Span::from_ns(20 * n), Span::from_ns(10));
    }
    sim.send_at(Time::ZERO + Span::from_us(500), ids[0], data(0x123, &[1, 2]));
    sim.run(Time::ZERO + Span::from_ms(30), &mut canbaud_sim::Blind);
    assert_eq!(sim.node(ids[0]).pending(), 0);
}
