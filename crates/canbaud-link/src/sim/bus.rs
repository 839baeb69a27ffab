//! A simulated bus with its traffic.

use canbaud::wire::Frame;
use canbaud_sim::traffic::Source;
use canbaud_sim::{Event, NodeId, Observer, Rng, Simulation, Span, Time};

/// Destroys a share of the frames, each transmission by its own chance.
#[derive(Debug, Clone)]
pub struct Destroyer {
    permille: u64,
    bit: Span,
    rng: Rng,
}

impl Destroyer {
    /// Destroys `permille` of a thousand transmissions at bits that last `bit`.
    #[must_use]
    pub const fn new(permille: u64, bit: Span, rng: Rng) -> Self {
        Self { permille, bit, rng }
    }

    fn strike(&mut self, sim: &mut Simulation, at: Time) {
        if self.rng.below(1000) < self.permille {
            let bit = self.bit.femtoseconds();
            // From the identifier on; the shortest frame reaches its CRC 36 bits later. Six
            // dominant bits break the stuffing wherever they fall.
            let offset = Span::from_fs(bit * (2 + self.rng.below(30)) + self.rng.below(bit));
            sim.dominant_at(at + offset, Span::from_fs(6 * bit));
        }
    }
}

/// A bus with nodes, streams of requests and disturbances.
#[derive(Debug)]
pub struct SimBus<O> {
    sim: Simulation,
    sources: Vec<Source>,
    destroyer: Option<Destroyer>,
    observer: O,
    /// Attempts to send a frame, by anybody who is watched.
    transmissions: u64,
    /// Requests up to then are dropped: nobody who matters listens.
    skipped_to: Time,
}

impl<O: Observer> SimBus<O> {
    /// A bus with what happens on it; `observer` sees all of it.
    pub fn new(sim: Simulation, sources: Vec<Source>, observer: O) -> Self {
        Self { sim, sources, destroyer: None, observer, transmissions: 0, skipped_to: Time::ZERO }
    }

    /// Destroys some of what `senders` send, and counts their transmissions.
    pub fn watch(&mut self, senders: &[NodeId], destroyer: Option<Destroyer>) {
        for &sender in senders {
            self.sim.watch(sender);
        }
        self.destroyer = destroyer;
    }

    /// The simulation.
    pub const fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// The simulation, to disturb it.
    pub const fn sim_mut(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// The observer.
    pub const fn observer(&self) -> &O {
        &self.observer
    }

    /// Transmissions of watched senders up to now.
    #[must_use]
    pub const fn transmissions(&self) -> u64 {
        self.transmissions
    }

    /// Leaves out all requests before `time`: the nodes stand still instead.
    pub fn skip_to(&mut self, time: Time) {
        self.skipped_to = time;
    }

    /// Runs until `until`, or until something happens in `node`; returns what.
    pub fn run(&mut self, until: Time, node: NodeId) -> Vec<(Time, Event)> {
        loop {
            let due = self.sources.iter().map(Source::next).min().unwrap_or(Time::NEVER);
            self.sim.run(until.min(due), &mut self.observer);
            let mut heard = Vec::new();
            for (at, who, event) in self.sim.take_news() {
                if who == node {
                    heard.push((at, event));
                } else {
                    self.notice_sender(at, who, &event);
                }
            }
            self.fire();
            if !heard.is_empty() || self.sim.now() >= until {
                return heard;
            }
        }
    }

    fn fire(&mut self) {
        let now = self.sim.now();
        for source in self.sources.iter_mut().filter(|source| source.next() <= now) {
            for frame in source.fire() {
                if now >= self.skipped_to {
                    self.sim.send_at(now, source.node(), frame);
                }
            }
        }
    }

    fn notice_sender(&mut self, at: Time, sender: NodeId, event: &Event) {
        match event {
            Event::TransmissionStarted { .. } => {
                self.transmissions += 1;
                if let Some(destroyer) = &mut self.destroyer {
                    destroyer.strike(&mut self.sim, at);
                }
            }
            Event::Transmitted { .. } => self.refill(sender),
            _ => {}
        }
    }

    fn refill(&mut self, sender: NodeId) {
        let now = self.sim.now();
        let refills: Vec<Frame> = self
            .sources
            .iter_mut()
            .filter(|source| source.node() == sender)
            .filter_map(|source| source.refill(now))
            .collect();
        for frame in refills {
            self.sim.send_at(now, sender, frame);
        }
    }

    /// Ends the run: the nodes have been watched to the end.
    pub fn into_observer(self) -> O {
        self.observer
    }
}

/// Microseconds of the scan's clock as a time of the simulation.
pub(super) fn time(at: canbaud::units::Micros) -> Time {
    Time::from_fs(at.0.saturating_mul(1_000_000_000))
}

/// A time of the simulation on the scan's clock, rounded down.
pub(super) const fn micros(at: Time) -> canbaud::units::Micros {
    canbaud::units::Micros(at.femtoseconds() / 1_000_000_000)
}
