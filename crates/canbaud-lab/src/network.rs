//! A bus with devices on it.

use canbaud_sim::{Blind, ClockError, NodeConfig, NodeId, Observer, Simulation, Span, Time};

use crate::config::DeviceConfig;
use crate::device::Device;
use crate::ears::{Ears, Heard};

/// While timers follow edges, software looks at them this often.
const SLICE: Span = Span::from_us(500);
/// Software never looks twice within this.
const TURN: Span = Span::from_us(1);

/// What went wrong, counted over a whole run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Dominant levels that a device drove while it had to be silent.
    pub broken_silence: u64,
    /// Errors that nodes noticed while they took part.
    pub errors: u64,
}

/// A bus with devices.
///
/// ```
/// use canbaud_lab::{DeviceConfig, Network};
/// use canbaud_sim::Span;
/// let mut network = Network::new(1);
/// let manager = DeviceConfig::mini_master(1, 250_000, Span::from_ms(20));
/// let manager = network.add(manager).unwrap();
/// let device = network.add(DeviceConfig::automatic(2)).unwrap();
/// network.power_on(manager);
/// network.power_on(device);
/// network.run_for(Span::from_ms(200));
/// assert!(network.device(device).is_operational());
/// assert_eq!(network.tally().broken_silence, 0);
/// ```
#[derive(Debug)]
pub struct Network {
    sim: Simulation,
    devices: Vec<Device>,
    /// The device of each node of the bus.
    owners: Vec<Option<usize>>,
    heard: Heard,
    due: Vec<bool>,
}

impl Network {
    /// A bus without anybody on it; `seed` decides on jitter.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            sim: Simulation::new(seed),
            devices: Vec::new(),
            owners: Vec::new(),
            heard: Heard::default(),
            due: Vec::new(),
        }
    }

    /// Puts a device on the bus, switched off; gives its place.
    ///
    /// # Errors
    /// [`ClockError`] if its clock is impossible.
    pub fn add(&mut self, config: DeviceConfig) -> Result<usize, ClockError> {
        let device = Device::new(config, &mut self.sim)?;
        self.devices.push(device);
        self.note_node(Some(self.devices.len() - 1), true);
        Ok(self.devices.len() - 1)
    }

    /// Puts a node without canbaud on the bus: a module of whatever kind.
    ///
    /// # Errors
    /// [`ClockError`] if its clock is impossible.
    pub fn add_plain(&mut self, config: NodeConfig) -> Result<NodeId, ClockError> {
        let id = self.sim.add_node(config)?;
        self.sim.watch(id);
        self.note_node(None, false);
        Ok(id)
    }

    fn note_node(&mut self, owner: Option<usize>, silent: bool) {
        self.owners.push(owner);
        self.heard.must_be_silent.push(silent);
        self.heard.flags_of.push(0);
        self.due.push(false);
    }

    /// The bus.
    #[must_use]
    pub const fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// The bus, for requests and disturbances.
    pub const fn sim_mut(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// A device.
    #[must_use]
    pub fn device(&self, place: usize) -> &Device {
        &self.devices[place]
    }

    /// A device, to be changed.
    pub fn device_mut(&mut self, place: usize) -> &mut Device {
        &mut self.devices[place]
    }

    /// All devices.
    #[must_use]
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// What went wrong so far.
    #[must_use]
    pub const fn tally(&self) -> Tally {
        Tally { broken_silence: self.heard.broken_silence, errors: self.heard.error_flags }
    }

    /// Errors that a node noticed while it took part.
    #[must_use]
    pub fn errors_of(&self, node: NodeId) -> u64 {
        self.heard.flags_of[node.0]
    }

    /// Gives a device power.
    pub fn power_on(&mut self, place: usize) {
        self.devices[place].power_on(&mut self.sim);
        self.note_silence(place);
    }

    /// Takes a device its power.
    pub fn power_off(&mut self, place: usize) {
        self.devices[place].power_off(&mut self.sim);
        self.note_silence(place);
    }

    /// Lets a device do what its software wants now.
    pub fn turn(&mut self, place: usize) {
        self.devices[place].turn(&mut self.sim);
        self.note_silence(place);
    }

    fn note_silence(&mut self, place: usize) {
        let device = &self.devices[place];
        self.heard.must_be_silent[device.id().0] = device.must_be_silent();
    }

    /// Runs for `span`.
    pub fn run_for(&mut self, span: Span) {
        self.run_until(self.sim.now() + span, &mut Blind);
    }

    /// Runs for `span` or until `done`; true if that came.
    pub fn run_while<O: Observer>(
        &mut self,
        span: Span,
        observer: &mut O,
        mut done: impl FnMut(&Self) -> bool,
    ) -> bool {
        let until = self.sim.now() + span;
        while self.sim.now() < until {
            if done(self) {
                return true;
            }
            self.go_on(until, observer);
        }
        done(self)
    }

    /// Runs up to `until`.
    pub fn run_until<O: Observer>(&mut self, until: Time, observer: &mut O) {
        while self.sim.now() < until {
            self.go_on(until, observer);
        }
    }

    /// Up to the next thing that happens, at most to `until`.
    fn go_on<O: Observer>(&mut self, until: Time, observer: &mut O) {
        let now = self.sim.now();
        let wake = self.devices.iter().map(Device::wake).min().unwrap_or(Time::NEVER);
        let mut next = wake.max(now + TURN).min(until);
        if !self.heard.edges.is_empty() {
            next = next.min(now + SLICE);
        }
        self.heard.edges.clear();
        self.sim.run(next, &mut Ears { heard: &mut self.heard, other: observer });
        self.deliver();
    }

    /// Edges and news go to the devices, and those do what is due.
    fn deliver(&mut self) {
        let now = self.sim.now();
        for device in self.devices.iter_mut().filter(|device| device.follows_edges()) {
            for (at, level) in &self.heard.edges {
                device.edge(*at, *level);
            }
        }
        for (at, node, event) in self.sim.take_news() {
            if let Some(place) = self.owners[node.0] {
                self.devices[place].notice(at, &event, &self.sim);
                self.due[place] = true;
            }
        }
        for place in 0..self.devices.len() {
            let device = &self.devices[place];
            let edges = !self.heard.edges.is_empty() && device.follows_edges();
            if core::mem::take(&mut self.due[place]) || edges || device.wake() <= now {
                self.turn(place);
            }
        }
    }
}
