//! Whole networks with everything at random, for many seeds.

use canbaud::detect::scan::Evidence;
use canbaud::lss::RateSetting;
use canbaud_sim::{Blind, Observer, Rng, Span, Time};

use crate::config::{DeviceConfig, Listener};
use crate::device::Company;
use crate::network::Network;

/// What the devices of a network can look for the rate with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mix {
    /// A timer and bus monitoring.
    Both,
    /// Bus monitoring alone, of three kinds, or the gate circuit.
    Controllers,
    /// A timer alone.
    Timers,
    /// Any of these.
    Any,
}

impl Mix {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Both, Self::Controllers, Self::Timers, Self::Any];
}

/// What came of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// When the last device became operational, since the first power-on.
    pub all_operational: Option<Span>,
    /// Dominant levels of devices that had to be silent.
    pub broken_silence: u64,
    /// Times that a device took part at a rate at which nobody else did.
    pub wrong_joins: u64,
}

/// A network of devices, all automatic but the manager.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plant {
    /// Devices, the manager included.
    pub nodes: u8,
    /// Its bit rate.
    pub bitrate: u32,
    /// What the devices have.
    pub mix: Mix,
    /// Of all chance.
    pub seed: u64,
}

/// Rates that a device may remember from another life.
const MEMORIES: [u32; 4] = [1_000_000, 500_000, 125_000, 50_000];

impl Plant {
    /// The network, switched off, and when each device is to get power.
    ///
    /// # Panics
    /// If a clock is impossible, which none here is.
    #[must_use]
    pub fn build(&self) -> (Network, Vec<Time>) {
        self.build_with(|_| {})
    }

    /// The same with `edit` applied to each device.
    ///
    /// # Panics
    /// If a clock is impossible.
    #[must_use]
    pub fn build_with(&self, edit: impl Fn(&mut DeviceConfig)) -> (Network, Vec<Time>) {
        let mut rng = Rng::for_purpose(self.seed, 1);
        let mut network = Network::new(self.seed);
        let mut times = Vec::new();
        for id in 1..=self.nodes {
            let mut config = match id {
                1 => DeviceConfig::mini_master(1, self.bitrate, Span::from_ms(20)),
                _ => self.device(id, &mut rng),
            };
            config.ppb = rng.below(400_000) as i64 - 200_000;
            config.settings.seed = rng.bits();
            edit(&mut config);
            let place = network.add(config).expect("a clock within range");
            // Some were here before, some come from another network, some are new.
            let memory = match rng.below(4) {
                0 => Some(self.bitrate),
                1 => Some(MEMORIES[rng.below(4) as usize]),
                _ => None,
            };
            if let Some(bits) = memory {
                let memory = network.device_mut(place).memory();
                canbaud::node::save(memory, &bits.to_le_bytes()).expect("a memory with power");
            }
            times.push(Time::ZERO + Span::from_us(rng.below(500_000)));
        }
        (network, times)
    }

    fn device(&self, id: u8, rng: &mut Rng) -> DeviceConfig {
        let mut config = DeviceConfig::automatic(id);
        config.clock_hz = [8_000_000, 16_000_000, 40_000_000, 80_000_000][rng.below(4) as usize];
        config.reconfiguration = Span::from_us(20 + rng.below(2_000));
        config.pdo = Some(Span::from_us(20_000 + rng.below(80_000)));
        let timer = Some([2_000_000, 8_000_000, 24_000_000, 72_000_000][rng.below(4) as usize]);
        let evidence = match rng.below(3) {
            0 => Evidence::Errors,
            1 => Evidence::Counter,
            _ => Evidence::FramesOnly,
        };
        let monitoring = Listener::Monitoring(evidence);
        let gate = if rng.below(4) == 0 { Listener::Gate } else { monitoring };
        let (listener, timer) = match (self.mix, rng.below(3)) {
            (Mix::Both, _) | (Mix::Any, 0) => (Listener::Monitoring(Evidence::Errors), timer),
            (Mix::Controllers, _) | (Mix::Any, 1) => (gate, None),
            (Mix::Timers, _) | (Mix::Any, _) => (Listener::None, timer),
        };
        config.with(listener, timer)
    }

    /// Powers everything on and waits until all are operational, for `limit` at most.
    #[must_use]
    pub fn run(&self, limit: Span) -> Outcome {
        self.run_under(limit, &mut Blind)
    }

    /// The same under an observer, made for the network.
    #[must_use]
    pub fn run_under<O: Observer>(&self, limit: Span, observer: &mut O) -> Outcome {
        let (mut network, times) = self.build();
        self.bring_up(&mut network, &times, limit, observer)
    }

    /// Powers a network on and waits until all are operational, for `limit` at most.
    #[must_use]
    pub fn bring_up<O: Observer>(
        &self,
        network: &mut Network,
        times: &[Time],
        limit: Span,
        observer: &mut O,
    ) -> Outcome {
        let mut order: Vec<usize> = (0..times.len()).collect();
        order.sort_by_key(|place| times[*place]);
        for place in order {
            network.run_until(times[place], observer);
            network.power_on(place);
        }
        let all = |network: &Network| network.devices().iter().all(|d| d.is_operational());
        let done = network.run_while(limit, observer, all);
        Outcome {
            all_operational: done.then(|| network.sim().now().since(Time::ZERO)),
            broken_silence: network.tally().broken_silence,
            wrong_joins: wrong_joins(network),
        }
    }
}

/// How often a device with automatic detection took part at a rate at which nobody else did.
#[must_use]
pub(crate) fn wrong_joins(network: &Network) -> u64 {
    let automatic =
        |device: &&crate::Device| device.config().settings.rate == RateSetting::Automatic;
    let joins = network.devices().iter().filter(automatic).flat_map(|device| device.joined());
    joins.filter(|joined| joined.company == Company::Nobody).count() as u64
}
