//! A day in a plant: devices lose power at any moment, the rate changes, lines are shorted.

use canbaud::lss::RateSetting;
use canbaud::units::Bitrate;
use canbaud_sim::{Blind, Rng, Span, Time};

use crate::config::DeviceConfig;
use crate::device::Joined;
use crate::memory::Memory;
use crate::network::Network;
use crate::plant::{Mix, Plant};

/// What happened in a stretch of time, and what came of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Devices that lost power.
    pub power_cycles: u64,
    /// Of these, in the middle of a write to their memory.
    pub cuts_while_writing: u64,
    /// Power failures of the whole plant.
    pub blackouts: u64,
    /// Times that the manager came back with another rate.
    pub rate_changes: u64,
    /// Times that the line was shorted.
    pub shorts: u64,
    /// Waits for all devices to be operational again.
    pub waits: u64,
    /// Of these, how many ended without: a device is lost.
    pub lost: u64,
    /// The longest of these waits that ended well.
    pub longest: Span,
    /// Dominant levels of devices that had to be silent.
    pub broken_silence: u64,
    /// Times that a device took part at a rate that the network neither had nor had had.
    pub wrong_joins: u64,
    /// Simulated time in whole seconds: a day is longer than a [`Span`] can be.
    pub seconds: u64,
}

impl Report {
    /// Both stretches together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            power_cycles: self.power_cycles + other.power_cycles,
            cuts_while_writing: self.cuts_while_writing + other.cuts_while_writing,
            blackouts: self.blackouts + other.blackouts,
            rate_changes: self.rate_changes + other.rate_changes,
            shorts: self.shorts + other.shorts,
            waits: self.waits + other.waits,
            lost: self.lost + other.lost,
            longest: self.longest.max(other.longest),
            broken_silence: self.broken_silence + other.broken_silence,
            wrong_joins: self.wrong_joins + other.wrong_joins,
            seconds: self.seconds + other.seconds,
        }
    }
}

/// A stretch of plant life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shift {
    /// Devices, the manager included.
    pub nodes: u8,
    /// Of all chance.
    pub seed: u64,
    /// How long, five hours at most.
    pub span: Span,
    /// Mean time between two events.
    pub pause: Span,
}

/// A device that is not back by then is lost.
const PATIENCE: Span = Span::from_s(120);
/// Rates that a network of 20 devices uses.
const RATES: [u32; 6] = [1_000_000, 800_000, 500_000, 250_000, 125_000, 50_000];

/// A shift under way.
struct Work {
    network: Network,
    rng: Rng,
    report: Report,
    bitrate: u32,
    /// The rate before the last change.
    before: u32,
    /// Joins of each device that were judged.
    judged: Vec<usize>,
}

impl Shift {
    /// Works through it; memories come from the shift before and go to the next.
    ///
    /// # Panics
    /// If a clock is impossible, which none here is.
    #[must_use]
    pub fn run(&self, memories: &mut Vec<Memory>) -> Report {
        let plant = Plant { nodes: self.nodes, bitrate: 250_000, mix: Mix::Any, seed: self.seed };
        let (mut network, _) = plant.build_with(quieter);
        memories.resize(network.devices().len(), Memory::new());
        for (place, memory) in memories.iter().enumerate() {
            network.device_mut(place).insert_memory(memory.clone());
            network.power_on(place);
        }
        let mut work = Work {
            judged: vec![0; network.devices().len()],
            network,
            rng: Rng::for_purpose(self.seed, 77),
            report: Report::default(),
            bitrate: 250_000,
            before: 250_000,
        };
        work.wait();
        let end = Time::ZERO + self.span;
        while work.network.sim().now() < end {
            let wait = work.rng.exponential() * self.pause.femtoseconds() as f64;
            work.network.run_for(Span::from_fs(1 + wait as u64));
            work.happen();
            work.wait();
        }
        for (place, memory) in memories.iter_mut().enumerate() {
            *memory = work.network.device_mut(place).memory().clone();
        }
        work.report.seconds = work.network.sim().now().seconds() as u64;
        work.report.broken_silence = work.network.tally().broken_silence;
        work.report
    }
}

/// Less traffic, so that a day is soon over.
fn quieter(config: &mut DeviceConfig) {
    config.sync = config.sync.map(|_| Span::from_ms(200));
    config.pdo = config.pdo.map(|_| Span::from_ms(1_000));
}

impl Work {
    fn happen(&mut self) {
        match self.rng.below(10) {
            0 => self.blackout(),
            1 | 2 => self.change_rate(),
            3 | 4 => self.short(),
            _ => self.cycle(),
        }
        self.judge();
    }

    /// Some devices lose power, some while they write.
    fn cycle(&mut self) {
        let count = self.network.devices().len() as u64;
        for _ in 0..=self.rng.below(4) {
            let place = self.rng.below(count) as usize;
            self.report.power_cycles += 1;
            if self.rng.below(2) == 0 {
                self.cut_while_writing(place);
            }
            self.network.power_off(place);
            self.pause();
            self.network.power_on(place);
            self.pause();
        }
    }

    /// Power goes in the middle of writing another rate than the one that is kept.
    fn cut_while_writing(&mut self, place: usize) {
        let bytes = self.rng.below(16) as u32;
        let rate = RATES[self.rng.below(RATES.len() as u64) as usize];
        let memory = self.network.device_mut(place).memory();
        memory.cut_after(bytes);
        let cut = canbaud::node::save(memory, &rate.to_le_bytes()).is_err();
        self.report.cuts_while_writing += u64::from(cut);
    }

    fn blackout(&mut self) {
        self.report.blackouts += 1;
        let count = self.network.devices().len();
        for place in 0..count {
            self.network.power_off(place);
        }
        self.pause();
        for place in 0..count {
            self.network.power_on(place);
            self.network.run_for(Span::from_us(self.rng.below(100_000)));
        }
    }

    /// The manager comes back with another rate while all others go on at the old one.
    fn change_rate(&mut self) {
        self.report.rate_changes += 1;
        self.judge();
        self.before = self.bitrate;
        self.bitrate = RATES[self.rng.below(RATES.len() as u64) as usize];
        self.network.power_off(0);
        self.network.run_for(Span::from_us(self.rng.below(100_000)));
        let settings = self.network.device_mut(0).settings();
        settings.rate = Bitrate::new(self.bitrate).map_or(settings.rate, RateSetting::Fixed);
        self.network.power_on(0);
    }

    fn short(&mut self) {
        self.report.shorts += 1;
        let (at, width) = (self.network.sim().now(), Span::from_us(self.rng.below(50_000)));
        match self.rng.below(2) {
            0 => self.network.sim_mut().recessive_at(at, width),
            _ => self.network.sim_mut().dominant_at(at, width),
        }
        self.network.run_for(width);
    }

    fn pause(&mut self) {
        let scale = [1_000, 100_000, 3_000_000][self.rng.below(3) as usize];
        self.network.run_for(Span::from_us(self.rng.below(scale)));
    }

    /// Until all are operational.
    fn wait(&mut self) {
        let begin = self.network.sim().now();
        let all = |network: &Network| network.devices().iter().all(|d| d.is_operational());
        let done = self.network.run_while(PATIENCE, &mut Blind, all);
        self.report.waits += 1;
        self.report.lost += u64::from(!done);
        let waited = self.network.sim().now().since(begin);
        if done {
            self.report.longest = self.report.longest.max(waited);
        }
        self.judge();
    }

    /// Counts joins at a rate that the network has not, and had not before the last change.
    fn judge(&mut self) {
        let rates = [self.bitrate, self.before].map(Bitrate::new);
        let wrong = |joined: &&Joined| !rates.contains(&Some(joined.bitrate));
        for (device, judged) in self.network.devices().iter().zip(&mut self.judged).skip(1) {
            let new = device.joined().get(*judged..).unwrap_or_default();
            self.report.wrong_joins += new.iter().filter(wrong).count() as u64;
            *judged = device.joined().len();
        }
    }
}
