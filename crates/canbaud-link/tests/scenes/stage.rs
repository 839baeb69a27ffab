//! What the scenes share.

pub(crate) use canbaud::detect::scan::*;
pub(crate) use canbaud::units::{Bitrate, Micros};
pub(crate) use canbaud::wire::{Frame, FrameKind, Id};
pub(crate) use canbaud_link::sim::{Adapter, SimBus, SimController, Stamps};
use canbaud_sim::check::Checker;
pub(crate) use canbaud_sim::traffic::{Arrivals, FrameFormat, Payload, Source};
pub(crate) use canbaud_sim::{NodeConfig, NodeId, Rng, Simulation, Span, Time};

pub(crate) fn rate(bits_per_second: u32) -> Bitrate {
    Bitrate::new(bits_per_second).expect("above 0")
}

pub(crate) const fn ms(milliseconds: u64) -> Micros {
    Micros::from_ms(milliseconds)
}

pub(crate) fn at_ms(milliseconds: u64) -> Time {
    Time::ZERO + Span::from_ms(milliseconds)
}

/// A bus that is being put together.
pub(crate) struct Scene {
    pub(crate) sim: Simulation,
    pub(crate) nodes: Vec<NodeId>,
    pub(crate) sources: Vec<Source>,
}

pub(crate) type Scanner = SimController<Checker>;

impl Scene {
    pub(crate) fn new(configs: impl IntoIterator<Item = NodeConfig>) -> Self {
        let mut sim = Simulation::new(1);
        let nodes = configs.into_iter().map(|c| sim.add_node(c).expect("a good clock")).collect();
        Self { sim, nodes, sources: Vec::new() }
    }

    /// Two nodes that talk to each other.
    pub(crate) fn pair(bitrate: u32) -> Self {
        Self::new([node(bitrate), node(bitrate)])
    }

    /// Node 0 sends a frame every `period`, from `start` on.
    pub(crate) fn talk(&mut self, start: Time, period: Span, payload: Payload) {
        self.talk_as(FrameKind::Data, start, period, payload);
    }

    pub(crate) fn talk_as(&mut self, kind: FrameKind, start: Time, period: Span, payload: Payload) {
        let arrivals = Arrivals::Periodic { period, jitter: Span::ZERO };
        self.talk_when(kind, arrivals, start, payload);
    }

    pub(crate) fn talk_when(
        &mut self,
        kind: FrameKind,
        arrivals: Arrivals,
        start: Time,
        payload: Payload,
    ) {
        let count = self.sources.len();
        let format = FrameFormat { id: Id::Base(0x181 + count as u16), kind, dlc: 8 };
        let (span, rng) = ((start, Time::NEVER), Rng::new(count as u64));
        let source = Source::new(self.nodes[0], arrivals, format, payload, span, rng);
        self.sources.push(source.expect("eight bytes"));
    }

    pub(crate) fn controller(mut self, adapter: Adapter) -> Scanner {
        let node = Scanner::add_to(&mut self.sim, &adapter).expect("a good clock");
        let checker = Checker::new(&self.sim);
        SimController::new(SimBus::new(self.sim, self.sources, checker), node, adapter)
    }
}

pub(crate) fn node(bitrate: u32) -> NodeConfig {
    NodeConfig::at("node", bitrate).expect("80 MHz makes this rate")
}

/// Scans for `limit` at most; meanwhile every law of the bus holds, and so does the bound.
pub(crate) fn scan<const N: usize>(
    controller: Scanner,
    candidates: &Candidates<N>,
    settings: Settings,
    limit: Micros,
) -> (Option<Outcome>, Scan<N>) {
    let scan = Scan::new(candidates, &controller.capabilities(), settings);
    let mut driver = Driver::new(controller, scan, SimController::now);
    while let Progress::Listening(until) = driver.turn().expect("a simulated controller") {
        let now = driver.controller().now();
        if now >= limit {
            break;
        }
        let until = until.map_or(limit, |until| until.min(limit));
        driver.controller_mut().wait(until.max(now + Micros(1)));
    }
    let (scan, now) = (driver.scan().clone(), driver.controller().now());
    driver.into_controller().into_bus().into_observer().assert_clean();
    if let Some(bound) = scan.bound() {
        assert!(scan.status(now).elapsed <= bound, "{} of {bound}", scan.status(now).elapsed);
    }
    (scan.outcome().copied(), scan)
}

pub(crate) fn canopen(controller: Scanner, settings: Settings) -> (Option<Outcome>, Scan<8>) {
    scan(controller, &Candidates::canopen().expect("eight"), settings, ms(60_000))
}

pub(crate) fn found(outcome: Option<Outcome>) -> Found {
    match outcome {
        Some(Outcome::Found(found)) => found,
        other => panic!("not found: {other:?}"),
    }
}

pub(crate) fn beginning_at(bitrate: u32) -> Settings {
    Settings { last_known: Some(rate(bitrate)), ..Settings::default() }
}
