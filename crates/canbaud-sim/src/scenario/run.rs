//! Runs a scenario.

use super::build::{Change, Power, Scenario, Trouble, gate, mode, wire};
use super::expect::Miss;
use super::model::DisturbanceKind;
use super::software::Installation;
use super::stats::Statistics;
use crate::clock::ClockError;
use crate::device::{Device, Program};
use crate::event::{Event, NodeId, Observer};
use crate::lss_device::LssDevice;
use crate::node::{FaultConfinement, Mode, NodeConfig};
use crate::rng::Rng;
use crate::simulation::Simulation;
use crate::software::Supplier;
use crate::time::{Span, Time};
use crate::timing::BitTiming;
use crate::traffic::Source;
use canbaud::wire::Level;

/// Glitches at random.
#[derive(Debug)]
struct Glitches {
    trouble: Trouble,
    rng: Rng,
    next: Time,
}

impl Glitches {
    fn plan(&mut self) {
        let wait = self.rng.exponential() * self.trouble.every.femtoseconds() as f64;
        self.next += Span::from_fs(wait as u64);
        if self.next >= self.trouble.stop {
            self.next = Time::NEVER;
        }
    }

    fn fire(&mut self, sim: &mut Simulation) {
        let width = Span::from_fs(1 + self.rng.below(self.trouble.width.femtoseconds()));
        let dominant = self.rng.below(2) == 0;
        match (self.trouble.node, dominant) {
            (Some(node), true) => sim.force_rxd_at(self.next, node, Level::Dominant, width),
            (Some(node), false) => sim.force_rxd_at(self.next, node, Level::Recessive, width),
            (None, true) => sim.dominant_at(self.next, width),
            (None, false) => sim.recessive_at(self.next, width),
        }
        self.plan();
    }
}

/// A scenario under way.
///
/// ```
/// use canbaud_sim::scenario::{Run, Scenario};
/// use canbaud_sim::Blind;
/// let text = "title = 'x'\nduration = '10ms'\n\
///     [[node]]\nname = 'a'\nbitrate = '500k'\n[[node]]\nname = 'b'\nbitrate = '500k'\n\
///     [[traffic]]\nnode = 'a'\nkind = 'periodic'\nperiod = '1ms'\nid = 0x123\ndlc = 8\n";
/// let mut run = Run::new(&Scenario::parse("x.toml", text).unwrap(), 1).unwrap();
/// run.finish(&mut Blind);
/// assert_eq!(run.statistics().nodes[1].received, 10);
/// ```
#[derive(Debug)]
pub struct Run {
    scenario: Scenario,
    sim: Simulation,
    sources: Vec<Source>,
    devices: Vec<Device>,
    lss_devices: Vec<LssDevice>,
    installation: Installation,
    glitches: Vec<Glitches>,
    statistics: Statistics,
    /// News of these nodes are kept for the caller.
    held: Vec<NodeId>,
    news: Vec<(Time, NodeId, Event)>,
}

/// Why a scenario cannot be set up.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RunError {
    /// A clock would be impossible.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// Nobody supplies the software of this node.
    #[error("node \"{0}\" is autonomous, and nobody supplies its software")]
    NoSoftware(String),
}

fn bitrate(config: &NodeConfig, timing: &BitTiming) -> u32 {
    let periods = u64::from(timing.prescaler() * timing.quanta());
    ((config.oscillator.hertz + periods / 2) / periods) as u32
}

impl Run {
    /// Sets the scenario up with `seed`.
    ///
    /// # Errors
    /// [`RunError`] if a change would make an oscillator impossible, or a node is autonomous.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, RunError> {
        Self::set_up(scenario, seed, None)
    }

    /// Sets the scenario up with `seed`; the software of its autonomous nodes is of `supplier`.
    ///
    /// # Errors
    /// [`RunError`] if a clock would be impossible.
    pub fn with(scenario: &Scenario, seed: u64, supplier: &dyn Supplier) -> Result<Self, RunError> {
        Self::set_up(scenario, seed, Some(supplier))
    }

    fn set_up(
        scenario: &Scenario,
        seed: u64,
        supplier: Option<&dyn Supplier>,
    ) -> Result<Self, RunError> {
        let mut run = Self {
            sim: Simulation::new(seed),
            sources: Vec::new(),
            devices: Vec::new(),
            lss_devices: Vec::new(),
            installation: Installation::new(scenario.members.len()),
            glitches: Vec::new(),
            held: Vec::new(),
            news: Vec::new(),
            statistics: Statistics::new(&scenario.node_names(), seed),
            scenario: scenario.clone(),
        };
        run.add_nodes()?;
        run.add_traffic(seed);
        run.add_troubles(seed);
        run.add_changes()?;
        run.add_software(seed, supplier)?;
        Ok(run)
    }

    fn add_nodes(&mut self) -> Result<(), ClockError> {
        for member in &self.scenario.members {
            let config = Device::first_config(&member.program, member.config.clone());
            let fault = FaultConfinement::with_counters(member.tec, member.rec);
            let id = match member.joins {
                // Power comes by its software.
                _ if member.autonomous.is_some() => self.sim.add_node(config)?,
                None => self.sim.add_node_with(config, fault)?,
                Some(at) => {
                    let off = NodeConfig { mode: Mode::Disabled, ..config.clone() };
                    let id = self.sim.add_node(off)?;
                    self.sim.reconfigure_at(at, id, config)?;
                    id
                }
            };
            if let Some(setup) = &member.lss {
                self.sim.watch(id);
                self.lss_devices.push(LssDevice::new(id, setup.clone()));
            }
            if member.program != Program::Fixed || !member.replies.is_empty() {
                self.sim.watch(id);
                let (program, replies) = (member.program.clone(), member.replies.clone());
                self.devices.push(Device::new(id, program, replies, member.boot_up));
            }
        }
        Ok(())
    }

    fn add_software(&mut self, seed: u64, supplier: Option<&dyn Supplier>) -> Result<(), RunError> {
        for (index, member) in self.scenario.members.iter().enumerate() {
            let (Some(plan), node) = (&member.autonomous, NodeId(index)) else { continue };
            let name = || RunError::NoSoftware(member.config.name.clone());
            let supplier = supplier.ok_or_else(name)?;
            let mut rng = Rng::for_purpose(seed, 2_000_000 + index as u64);
            let late = match member.joins_spread.femtoseconds() {
                0 => Span::ZERO,
                spread => Span::from_fs(rng.below(spread)),
            };
            let joins = member.joins.unwrap_or(Time::ZERO) + late;
            let mut power = vec![(joins, Power::On)];
            power.extend(self.scenario.changes.iter().filter_map(
                |(at, of, change)| match change {
                    Change::Power(power) if *of == node => Some((*at, *power)),
                    _ => None,
                },
            ));
            power.sort_by_key(|(at, _)| *at);
            let software = supplier.software(plan, node, &member.config, rng.bits())?;
            self.sim.watch(node);
            self.installation.add(node, software, power.into());
        }
        Ok(())
    }

    fn add_traffic(&mut self, seed: u64) {
        for (index, stream) in self.scenario.streams.iter().enumerate() {
            let rng = Rng::for_purpose(seed, index as u64);
            let source = Source::new(
                stream.node,
                stream.arrivals.clone(),
                stream.format,
                stream.payload.clone(),
                stream.span,
                rng,
            );
            // Format and payload were checked when the scenario was read.
            let Ok(source) = source else { continue };
            if source.saturates() {
                self.sim.watch(stream.node);
            }
            self.sources.push(source);
        }
    }

    fn add_troubles(&mut self, seed: u64) {
        for (index, trouble) in self.scenario.troubles.iter().enumerate() {
            let (at, width) = (trouble.at, trouble.width);
            match (trouble.kind, trouble.node) {
                (DisturbanceKind::Dominant, _) => self.sim.dominant_at(at, width),
                (DisturbanceKind::Recessive, _) => self.sim.recessive_at(at, width),
                (DisturbanceKind::RxdDominant, Some(node)) => {
                    self.sim.force_rxd_at(at, node, Level::Dominant, width);
                }
                (DisturbanceKind::RxdRecessive, Some(node)) => {
                    self.sim.force_rxd_at(at, node, Level::Recessive, width);
                }
                (DisturbanceKind::Glitches, _) => {
                    let rng = Rng::for_purpose(seed, 1_000_000 + index as u64);
                    let mut glitches = Glitches { trouble: trouble.clone(), rng, next: at };
                    glitches.plan();
                    self.glitches.push(glitches);
                }
                // Refused when the scenario was read.
                (DisturbanceKind::RxdDominant | DisturbanceKind::RxdRecessive, None) => {}
            }
        }
    }

    fn add_changes(&mut self) -> Result<(), ClockError> {
        for (at, node, change) in &self.scenario.changes {
            match change {
                // By the node's software.
                Change::Power(_) => {}
                Change::Drift { ppb } => self.sim.drift_at(*at, *node, *ppb)?,
                Change::SetUp { edit, timing } => {
                    // Changes of one node build on one another, in the order of the file.
                    let member = &self.scenario.members[node.0].config;
                    let mut config = member.clone();
                    for (_, _, earlier) in
                        self.scenario.changes.iter().filter(|(t, n, _)| n == node && t < at)
                    {
                        if let Change::SetUp { edit, timing } = earlier {
                            apply(&mut config, edit, *timing);
                        }
                    }
                    apply(&mut config, edit, *timing);
                    self.sim.reconfigure_at(*at, *node, config)?;
                }
            }
        }
        Ok(())
    }

    /// The bus.
    #[must_use]
    pub const fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// The bus, for more nodes, requests and disturbances.
    pub const fn sim_mut(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// The end of the scenario.
    #[must_use]
    pub fn end(&self) -> Time {
        Time::ZERO + self.scenario.duration
    }

    /// The numbers so far; complete after [`Run::finish`].
    #[must_use]
    pub const fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The devices that are configured over the bus.
    #[must_use]
    pub fn lss_devices(&self) -> &[LssDevice] {
        &self.lss_devices
    }

    /// Keeps what happens in `node` for [`Run::take_held_news`].
    pub fn hold_news(&mut self, node: NodeId) {
        self.sim.watch(node);
        self.held.push(node);
    }

    /// What happened in nodes whose news are held, since the last call.
    pub fn take_held_news(&mut self) -> Vec<(Time, NodeId, Event)> {
        core::mem::take(&mut self.news)
    }

    fn next(&self) -> Time {
        let sources = self.sources.iter().map(Source::next);
        let glitches = self.glitches.iter().map(|glitches| glitches.next);
        let deadlines = self.devices.iter().map(Device::deadline);
        let deadlines = deadlines.chain(self.lss_devices.iter().map(LssDevice::deadline));
        let next = sources.chain(glitches).chain(deadlines).min().unwrap_or(Time::NEVER);
        next.min(self.installation.next(self.sim.now()))
    }

    /// Runs up to `until`.
    pub fn advance<O: Observer>(&mut self, until: Time, observer: &mut O) {
        loop {
            let next = self.next().min(until);
            self.installation.listen();
            let own = (&mut self.statistics, &mut self.installation.ears);
            self.sim.run(next, &mut (own, &mut *observer));
            self.installation.deliver_edges();
            self.deliver();
            self.installation.turn(&mut self.sim, observer);
            if self.sim.now() < next {
                continue;
            }
            let now = self.sim.now();
            for source in self.sources.iter_mut().filter(|source| source.next() <= now) {
                let node = source.node();
                for frame in source.fire() {
                    self.sim.send_at(now, node, frame);
                }
            }
            for glitches in self.glitches.iter_mut().filter(|glitches| glitches.next <= now) {
                glitches.fire(&mut self.sim);
            }
            for device in self.devices.iter_mut().filter(|device| device.deadline() <= now) {
                device.lose_patience(now, &mut self.sim);
            }
            for device in self.lss_devices.iter_mut().filter(|device| device.deadline() <= now) {
                device.wake(now, &mut self.sim);
            }
            if now >= until && self.next() > until {
                return;
            }
        }
    }

    /// What happened in watched nodes goes to their software.
    fn deliver(&mut self) {
        for (at, node, event) in self.sim.take_news() {
            for device in self.devices.iter_mut().filter(|device| device.node() == node) {
                device.notice(at, &event, &mut self.sim);
            }
            for device in self.lss_devices.iter_mut().filter(|device| device.node() == node) {
                device.notice(at, &event, &mut self.sim);
            }
            self.installation.notice(at, node, &event, &mut self.sim);
            if matches!(event, Event::Transmitted { .. }) {
                let mut sources =
                    self.sources.iter_mut().filter(|s| s.node() == node && s.saturates());
                if let Some(frame) = sources.find_map(|source| source.refill(at)) {
                    self.sim.send_at(at, node, frame);
                }
            }
            if self.held.contains(&node) {
                self.news.push((at, node, event));
            }
        }
    }

    /// Runs up to the end of the scenario and closes the statistics.
    pub fn finish<O: Observer>(&mut self, observer: &mut O) {
        self.advance(self.end(), observer);
        self.statistics.close(self.sim.now());
        for (stats, node) in self.statistics.nodes.iter_mut().zip(self.sim.nodes()) {
            stats.state = node.state().to_string();
        }
        for (node, software, broken) in self.installation.accounts() {
            let (stats, standing) = (&mut self.statistics.nodes[node.0], software.standing());
            stats.stage = Some(standing.stage.to_string());
            stats.broken_silence = broken;
            if let Some((bitrate, since)) = standing.takes_part {
                stats.found_bitrate = Some(bitrate.bits_per_second());
                stats.found_at_s = Some(since.seconds());
            }
        }
        for device in &self.lss_devices {
            let stats = &mut self.statistics.nodes[device.node().0];
            if let Some((at, timing)) = device.found() {
                let config = self.sim.node(device.node()).config();
                stats.found_bitrate = Some(bitrate(config, &timing));
                stats.found_at_s = Some(at.seconds());
            }
        }
        for device in &self.devices {
            let stats = &mut self.statistics.nodes[device.node().0];
            stats.messages = device.messages();
            if let Some((at, timing)) = device.found() {
                let config = self.sim.node(device.node()).config();
                stats.found_bitrate = Some(bitrate(config, &timing));
                stats.found_at_s = Some(at.seconds());
            }
        }
    }

    /// Expectations of the scenario that were not met; after [`Run::finish`].
    #[must_use]
    pub fn misses(&self) -> Vec<Miss> {
        let check = |expectation: &super::expect::Expectation| {
            let node = expectation.node;
            let stage = self.installation.stage(node);
            expectation.check(&self.statistics.nodes[node.0], self.sim.node(node).state(), stage)
        };
        self.scenario.expectations.iter().flat_map(check).collect()
    }
}

fn apply(config: &mut NodeConfig, edit: &super::model::ChangeTable, timing: Option<BitTiming>) {
    config.nominal = timing.unwrap_or(config.nominal);
    config.mode = edit.mode.map_or(config.mode, mode);
    config.gate = edit.gate.map_or(config.gate, gate);
    config.wire = edit.wire.map_or(config.wire, wire);
}
