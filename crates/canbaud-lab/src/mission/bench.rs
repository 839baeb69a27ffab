//! What the rows share: modules that talk, joins, replies.

use canbaud::lss::{LssAddress, Request};
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_sim::check::Checker;
use canbaud_sim::{Event, NodeConfig, NodeId, Observer, Rng, Span, Time};

use crate::{DeviceConfig, Network};

/// A module of whatever kind, which knows its rate and no LSS.
pub(super) fn module(network: &mut Network, name: &str, bitrate: u32) -> NodeId {
    // 80 MHz makes every rate in use exactly.
    let config = NodeConfig::at(name, bitrate).unwrap_or_else(|_| unreachable!());
    network.add_plain(config).unwrap_or_else(|_| unreachable!())
}

/// A frame with nothing in it that could help; no two of the first eight nodes share an identifier.
pub(super) fn any_frame(node: NodeId, rng: &mut Rng) -> Frame {
    let id = match rng.below(2) {
        0 => Id::Base(8 * rng.below(0x100) as u16 + node.0 as u16 % 8),
        _ => Id::Extended(8 * rng.below(0x0400_0000) as u32 + node.0 as u32 % 8),
    };
    let dlc = rng.below(9) as u8;
    let data: Vec<u8> = (0..dlc).map(|_| rng.bits() as u8).collect();
    Frame::new(id, FrameKind::Data, dlc, &data).unwrap_or_else(|_| unreachable!())
}

/// `node` sends any frame about every `period` for `span`.
pub(super) fn talk(network: &mut Network, node: NodeId, period: Span, span: Span, seed: u64) {
    let mut rng = Rng::for_purpose(seed, 1000 + node.0 as u64);
    let begin = network.sim().now();
    let mut at = begin + Span::from_fs(rng.below(period.femtoseconds()));
    while at < begin + span {
        let frame = any_frame(node, &mut rng);
        network.sim_mut().send_at(at, node, frame);
        let jitter = rng.below(period.femtoseconds() / 2);
        at += Span::from_fs(period.femtoseconds() * 3 / 4 + jitter);
    }
}

/// A network with `modules` that talk every `period`, and one device switched off.
pub(super) fn running(
    bitrate: u32,
    modules: usize,
    period: Span,
    device: DeviceConfig,
    seed: u64,
) -> (Network, Vec<NodeId>, usize) {
    let mut network = Network::new(seed);
    let ids: Vec<NodeId> =
        (0..modules).map(|n| module(&mut network, &format!("module-{n}"), bitrate)).collect();
    for id in &ids {
        talk(&mut network, *id, period, Span::from_s(10), seed);
    }
    let place = network.add(device).unwrap_or_else(|_| unreachable!());
    (network, ids, place)
}

/// Plugs the device at `place` in after `wait`, and runs under all checkers until it takes part;
/// gives how long that took, and how many laws were broken.
pub(super) fn plug_in(
    network: &mut Network,
    place: usize,
    wait: Span,
    limit: Span,
) -> (Option<Span>, u64) {
    let mut checker = Checker::new(network.sim());
    let begin = network.sim().now() + wait;
    network.run_until(begin, &mut checker);
    network.power_on(place);
    let joined = |network: &Network| !network.device(place).joined().is_empty();
    let done = network.run_while(limit, &mut checker, joined);
    let took = network.sim().now().since(begin);
    network.run_until(network.sim().now() + Span::from_ms(20), &mut checker);
    (done.then_some(took), checker.violations())
}

/// Frames that a node received, with when.
#[derive(Debug)]
pub(super) struct Inbox {
    pub(super) of: NodeId,
    pub(super) frames: Vec<(Time, Frame)>,
}

impl Inbox {
    pub(super) const fn of(node: NodeId) -> Self {
        Self { of: node, frames: Vec::new() }
    }

    /// How many with this identifier and these first bytes.
    pub(super) fn count(&self, id: u16, data: &[u8]) -> usize {
        let fits = |frame: &Frame| frame.id() == Id::Base(id) && frame.data().starts_with(data);
        self.frames.iter().filter(|(_, frame)| fits(frame)).count()
    }
}

impl Observer for Inbox {
    fn event(&mut self, at: Time, node: NodeId, event: &Event) {
        if let (true, Event::Received { frame }) = (node == self.of, event) {
            self.frames.push((at, *frame));
        }
    }
}

/// The LSS address of the device under test.
pub(super) const ADDRESS: LssAddress = LssAddress::new(0x29C, 7, 1, 4711);

/// A manager sends an LSS request.
pub(super) fn ask(network: &mut Network, manager: NodeId, request: Request) {
    let now = network.sim().now();
    network.sim_mut().send_at(now, manager, request.to_frame());
}
