//! One scan on one simulated bus, and what came of it.

use canbaud::detect::scan::{
    Candidates, Controller, Driver, Outcome, Progress, Scan, Settings, Standing,
};
use canbaud::units::Micros;
use canbaud::wire::{FrameKind, Id, Level};
use canbaud_sim::traffic::{Arrivals, FrameFormat, Payload, Source};
use canbaud_sim::{Mode, NodeConfig, NodeId, Observer, Rng, Simulation, Span, Time};

use super::bus::time;
use super::{Adapter, Destroyer, SimBus, SimController, SimError};

/// What is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Content {
    /// Identifiers, lengths and bytes at random.
    Random,
    /// One frame over and over: a heartbeat.
    Same,
}

/// Who hears the frames besides the scanner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Audience {
    /// A node that acknowledges.
    Acknowledges,
    /// Nobody: the sender repeats its first frame.
    Nobody,
}

/// How often frames are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Load {
    /// At random, so that they take this share of the time, in thousandths.
    Permille(u32),
    /// With this period, from a random phase on.
    Every(Micros),
    /// Never.
    None,
}

/// A scan on a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trial {
    /// Bit rate of the bus in bit/s.
    pub bitrate: u32,
    /// How often frames are sent.
    pub load: Load,
    /// What is sent.
    pub content: Content,
    /// Who acknowledges.
    pub audience: Audience,
    /// Of a thousand frames, so many are destroyed.
    pub destroyed: u64,
    /// The adapter.
    pub adapter: Adapter,
    /// What the scan is told.
    pub settings: Settings,
    /// Chance.
    pub seed: u64,
}

/// What came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// What the scan said; `None` if it was cut off at the end of the trial.
    pub outcome: Option<Outcome>,
    /// It found the bit rate of the bus.
    pub right: bool,
    /// It found another one.
    pub wrong: bool,
    /// It met errors at the bit rate of the bus, and left it.
    pub left: bool,
    /// From the first poll to the outcome.
    pub elapsed: Micros,
    /// What the scan had promised.
    pub bound: Option<Micros>,
    /// Transmissions on the bus until then.
    pub transmissions: u64,
    /// Those of them that began while the scanner listened.
    pub heard: u64,
    /// Candidates listened to.
    pub visits: u32,
    /// Dominant bits that the scanner put on the bus.
    pub dominant: u64,
}

/// Counts dominant levels of one node.
#[derive(Debug, Clone, Copy)]
struct Watchman {
    node: NodeId,
    dominant: u64,
}

impl Observer for Watchman {
    fn txd(&mut self, _: Time, node: NodeId, level: Level) {
        self.dominant += u64::from(node == self.node && level == Level::Dominant);
    }
}

/// Streams of different identifiers and lengths that random traffic consists of.
const STREAMS: u64 = 6;
/// Bits of an average frame with its stuff bits.
const FRAME_BITS: u64 = 100;

impl Trial {
    fn bit(&self) -> Span {
        Span::from_fs(1_000_000_000_000_000 / u64::from(self.bitrate))
    }

    fn sources(&self, sender: NodeId) -> Vec<Source> {
        let mut rng = Rng::for_purpose(self.seed, 1);
        let streams = match (self.content, self.load) {
            (_, Load::None) => 0,
            (Content::Random, _) => STREAMS,
            (Content::Same, _) => 1,
        };
        let apart = match self.load {
            Load::Permille(share) => {
                self.bit().femtoseconds() * FRAME_BITS * 1000 / u64::from(share.max(1))
            }
            Load::Every(period) => time(period).femtoseconds(),
            Load::None => 0,
        };
        let source = |n: u64| {
            let format = match self.content {
                Content::Same => FrameFormat { id: Id::Base(0x705), kind: FrameKind::Data, dlc: 1 },
                Content::Random => FrameFormat {
                    id: match rng.below(4) {
                        0 => Id::Extended(rng.below(0x2000_0000) as u32),
                        _ => Id::Base(rng.below(0x800) as u16),
                    },
                    kind: FrameKind::Data,
                    dlc: rng.below(9) as u8,
                },
            };
            let payload = match self.content {
                Content::Same => Payload::Fixed(vec![5]),
                Content::Random => Payload::Random,
            };
            let mean = Span::from_fs(apart * streams);
            let arrivals = match self.load {
                Load::Permille(_) | Load::None => Arrivals::Periodic { period: mean, jitter: mean },
                Load::Every(_) => Arrivals::Periodic { period: mean, jitter: Span::ZERO },
            };
            let phase = Time::from_fs(rng.below(apart.max(1)) + n * apart);
            let rng = Rng::for_purpose(self.seed, 2 + n);
            Source::new(sender, arrivals, format, payload, (phase, Time::NEVER), rng).ok()
        };
        (0..streams).filter_map(source).collect()
    }

    /// The controller on its bus.
    ///
    /// # Errors
    /// [`SimError`] if no node can have the rates.
    pub fn controller(&self) -> Result<SimController<impl Observer + use<>>, SimError> {
        self.watched_controller()
    }

    fn watched_controller(&self) -> Result<SimController<Watchman>, SimError> {
        let mut sim = Simulation::new(self.seed);
        let mut rng = Rng::for_purpose(self.seed, 0);
        let mut ppb = || rng.below(400_000) as i64 - 200_000;
        let sender = sim.add_node(NodeConfig::at("sender", self.bitrate)?.with_ppb(ppb()))?;
        let listener = NodeConfig::at("listener", self.bitrate)?.with_ppb(ppb());
        sim.add_node(match self.audience {
            Audience::Acknowledges => listener,
            Audience::Nobody => listener.with_mode(Mode::Disabled),
        })?;
        let node = SimController::<Watchman>::add_to(&mut sim, &self.adapter)?;
        let watchman = Watchman { node, dominant: 0 };
        let mut bus = SimBus::new(sim, self.sources(sender), watchman);
        let destroyer =
            Destroyer::new(self.destroyed, self.bit(), Rng::for_purpose(self.seed, 100));
        bus.watch(&[sender], (self.destroyed > 0).then_some(destroyer));
        Ok(SimController::new(bus, node, self.adapter))
    }

    /// Scans `candidates`, for `limit` at most; `lean` leaves out traffic that nobody hears.
    ///
    /// # Errors
    /// [`SimError`] if no node can have the rates.
    pub fn run<const N: usize>(
        &self,
        candidates: &Candidates<N>,
        limit: Micros,
        lean: Traffic,
    ) -> Result<Report, SimError> {
        let mut controller = self.watched_controller()?;
        if lean == Traffic::WhereHeard && self.audience == Audience::Acknowledges {
            let lead = self.bit().femtoseconds() * 300;
            controller = controller.lean(Span::from_fs(lead));
        }
        let scan = Scan::new(candidates, &controller.capabilities(), self.settings);
        let mut driver = Driver::new(controller, scan, SimController::now);
        loop {
            match driver.turn()? {
                Progress::Done(_) => break,
                Progress::Listening(_) if driver.controller().now() >= limit => break,
                Progress::Listening(until) => {
                    let until = until.map_or(limit, |until| until.min(limit));
                    let next = driver.controller().now() + Micros(1);
                    driver.controller_mut().wait(until.max(next));
                }
            }
        }
        Ok(self.report(driver))
    }

    fn report<T: FnMut(&SimController<Watchman>) -> Micros, const N: usize>(
        &self,
        driver: Driver<SimController<Watchman>, T, N>,
    ) -> Report {
        let outcome = driver.scan().outcome().copied();
        let now = driver.controller().now();
        let found = match &outcome {
            Some(Outcome::Found(found)) => Some(found.nominal().bits_per_second()),
            _ => None,
        };
        let near = |rate: u32| u64::from(rate.abs_diff(self.bitrate)) * 100 <= u64::from(rate);
        let right = found.is_some_and(near);
        let is_right = |s: &Standing| near(s.candidate.nominal.bits_per_second());
        let at_rate = driver.scan().standings().find(is_right);
        Report {
            outcome,
            right,
            wrong: found.is_some() && !right,
            left: at_rate.is_some_and(|s| s.errors > 0 && s.visits > u32::from(right)),
            elapsed: driver.scan().status(now).elapsed,
            bound: driver.scan().bound(),
            transmissions: driver.controller().bus().transmissions(),
            heard: driver.controller().heard(),
            visits: driver.scan().status(now).visits,
            dominant: driver.controller().bus().observer().dominant,
        }
    }
}

/// Which traffic is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Traffic {
    /// All of it.
    Always,
    /// Not what passes while the controller is being set up.
    WhereHeard,
}
