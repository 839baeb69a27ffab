//! What the tests of the simulator share.
#![allow(dead_code, reason = "each test file uses its part")]

use canbaud::wire::{Frame, FrameKind, Id, Level};
use canbaud_sim::check::Checker;
use canbaud_sim::{Event, NodeConfig, NodeId, Observer, Rng, Rule, Simulation, Span, Time};

/// Everything that happened.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    pub(crate) events: Vec<(Time, NodeId, Event)>,
    pub(crate) edges: Vec<(Time, Level)>,
    pub(crate) txd: Vec<(Time, NodeId, Level)>,
}

impl Observer for Journal {
    fn bus(&mut self, at: Time, level: Level) {
        self.edges.push((at, level));
    }

    fn txd(&mut self, at: Time, node: NodeId, level: Level) {
        self.txd.push((at, node, level));
    }

    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        self.events.push((at, node, event.clone()));
    }
}

impl Journal {
    pub(crate) fn of(&self, node: NodeId) -> impl Iterator<Item = &Event> {
        self.events.iter().filter(move |(_, n, _)| *n == node).map(|(_, _, event)| event)
    }

    pub(crate) fn received(&self, node: NodeId) -> Vec<Frame> {
        self.of(node)
            .filter_map(|event| match event {
                Event::Received { frame } => Some(*frame),
                _ => None,
            })
            .collect()
    }

    pub(crate) fn transmitted(&self, node: NodeId) -> usize {
        self.of(node).filter(|event| matches!(event, Event::Transmitted { .. })).count()
    }

    /// (TEC, REC) after each time that `rule` counted at `node`.
    pub(crate) fn counted(&self, node: NodeId, rule: Rule) -> Vec<(u16, u16)> {
        self.of(node)
            .filter_map(|event| match event {
                Event::Counted { rule: by, tec, rec } if *by == rule => Some((*tec, *rec)),
                _ => None,
            })
            .collect()
    }

    pub(crate) fn errors(&self, node: NodeId) -> usize {
        self.of(node).filter(|event| matches!(event, Event::Error { .. })).count()
    }

    /// When the `count`th edge (0 is the first) to dominant came.
    pub(crate) fn dominant_edge(&self, count: usize) -> Time {
        self.edges.iter().filter(|(_, level)| *level == Level::Dominant).nth(count).unwrap().0
    }
}

/// A bus under all checkers.
pub(crate) struct Bench {
    pub(crate) sim: Simulation,
    pub(crate) checker: Checker,
    pub(crate) journal: Journal,
}

impl Bench {
    pub(crate) fn new(seed: u64, configs: Vec<NodeConfig>) -> (Self, Vec<NodeId>) {
        let mut sim = Simulation::new(seed);
        let ids = configs.into_iter().map(|config| sim.add_node(config).unwrap()).collect();
        (Self::around(sim), ids)
    }

    pub(crate) fn around(sim: Simulation) -> Self {
        Self { checker: Checker::new(&sim), sim, journal: Journal::default() }
    }

    pub(crate) fn run_for(&mut self, span: Span) {
        let until = self.sim.now() + span;
        while self.sim.run(until, &mut (&mut self.checker, &mut self.journal))
            == canbaud_sim::Stop::News
        {}
    }

    /// In bit times of 500 kbit/s.
    pub(crate) fn run_bits(&mut self, bits: u64) {
        self.run_for(Span::from_us(2 * bits));
    }

    pub(crate) fn finish(&self) {
        self.checker.assert_clean();
    }
}

pub(crate) fn node(name: &str) -> NodeConfig {
    NodeConfig::at(name, 500_000).unwrap()
}

pub(crate) fn data(id: u16, bytes: &[u8]) -> Frame {
    Frame::new(Id::Base(id), FrameKind::Data, bytes.len() as u8, bytes).unwrap()
}

/// A frame of any format and content; `fd` says whether CAN FD ones are among them.
pub(crate) fn any_frame(rng: &mut Rng, fd: bool) -> Frame {
    let id = match rng.below(2) {
        0 => Id::Base(rng.below(0x800) as u16),
        _ => Id::Extended(rng.below(0x2000_0000) as u32),
    };
    let kind = match (fd, rng.below(4)) {
        (true, n) => FrameKind::Fd { brs: n % 2 == 0, esi: n > 2 },
        (false, 0) => FrameKind::Remote,
        (false, _) => FrameKind::Data,
    };
    let dlc = rng.below(16) as u8;
    let style = rng.below(4);
    let bytes: Vec<u8> = (0..Frame::data_length(kind, dlc))
        .map(|_| match style {
            0 => 0,
            1 => 0xFF,
            _ => rng.bits() as u8,
        })
        .collect();
    Frame::new(id, kind, dlc, &bytes).unwrap()
}
