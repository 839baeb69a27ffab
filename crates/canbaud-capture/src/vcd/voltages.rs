//! Voltages in a dump: values that hold until the next change.

use super::changes::Listener;
use crate::analogue::{Chooser, Crossing, Histogram, Levels};
use crate::capture::{Channel, ChannelKind};
use crate::error::Halt;
use crate::sink::Output;
use canbaud::wire::Logic;

/// The voltages and differences of a dump as they change.
struct Voltages {
    /// The value of each channel and since when it holds.
    held: Vec<Option<(u64, f64)>>,
    /// Channel, and the two it is the difference of.
    differences: Vec<(usize, usize, usize)>,
    /// Whether a voltage changed on this tick.
    changed: bool,
}

impl Voltages {
    fn new(channels: &[Channel]) -> Self {
        let differences = channels.iter().enumerate().filter_map(|(n, c)| match c.kind {
            ChannelKind::Difference(high, low) => Some((n, high, low)),
            _ => None,
        });
        let differences = differences.collect();
        Self { held: vec![None; channels.len()], differences, changed: false }
    }

    /// Replaces a value; the one before.
    fn set(&mut self, channel: usize, at: u64, volts: f64) -> Option<(u64, f64)> {
        self.changed = true;
        self.held.get_mut(channel).and_then(|slot| slot.replace((at, volts)))
    }

    /// Differences of which a part changed on this tick: channel and value.
    fn differences(&mut self, at: u64) -> Vec<(usize, f64)> {
        if !core::mem::take(&mut self.changed) {
            return Vec::new();
        }
        let value = |channel: usize| self.held.get(channel).copied().flatten();
        let changed = self.differences.iter().filter_map(|&(channel, high, low)| {
            let ((t0, high), (t1, low)) = (value(high)?, value(low)?);
            (t0 == at || t1 == at).then_some((channel, high - low))
        });
        changed.collect()
    }
}

/// What is found out about voltages before their edges are placed.
pub(super) enum Study {
    /// How often each voltage occurs.
    Count(Histogram),
    /// How often each candidate is crossed.
    Cross(Chooser),
}

impl Study {
    fn add(&mut self, volts: f64) {
        match self {
            Self::Count(histogram) => histogram.add(&[volts as f32]),
            Self::Cross(chooser) => chooser.add(&[volts as f32]),
        }
    }
}

/// Studies some channels.
pub(super) struct Scan {
    voltages: Voltages,
    pub(super) studies: Vec<(usize, Study)>,
}

impl Scan {
    pub(super) fn new(channels: &[Channel], studies: Vec<(usize, Study)>) -> Self {
        Self { voltages: Voltages::new(channels), studies }
    }

    fn add(&mut self, channel: usize, volts: f64) {
        if let Some((_, study)) = self.studies.iter_mut().find(|(n, _)| *n == channel) {
            study.add(volts);
        }
    }
}

impl Listener for Scan {
    fn level(&mut self, _: usize, _: u64, _: Option<Logic>) -> Result<(), Halt> {
        Ok(())
    }

    fn volts(&mut self, channel: usize, at: u64, volts: f64) -> Result<(), Halt> {
        self.voltages.set(channel, at, volts);
        self.add(channel, volts);
        Ok(())
    }

    fn tick_done(&mut self, at: u64) -> Result<(), Halt> {
        for (channel, volts) in self.voltages.differences(at) {
            self.add(channel, volts);
        }
        Ok(())
    }

    fn progress(&mut self, _: u64) {}
}

/// A voltage on its way to edges: its crossings, and the value it has since when.
type Held = (Crossing, Option<(u64, f64)>);

/// Makes edges of levels and of voltages.
pub(super) struct Emit<'a, 'b> {
    out: &'a mut Output<'b>,
    voltages: Voltages,
    crossings: Vec<Option<Held>>,
    /// A voltage rose within the sample period before its stamp.
    period: u64,
    total: u64,
}

impl<'a, 'b> Emit<'a, 'b> {
    /// `levels`: of each channel, if it has any.
    pub(super) fn new(
        out: &'a mut Output<'b>,
        channels: &[Channel],
        levels: &[Option<Levels>],
        period: u64,
        total: u64,
    ) -> Self {
        let crossing = |(n, levels): (usize, &Option<Levels>)| {
            levels.map(|levels| (Crossing::new(n, levels.threshold), None))
        };
        let crossings = levels.iter().enumerate().map(crossing).collect();
        Self { out, voltages: Voltages::new(channels), crossings, period, total }
    }

    fn sample(&mut self, channel: usize, at: u64, volts: f64) -> Result<(), Halt> {
        let Some(Some((crossing, held))) = self.crossings.get_mut(channel) else { return Ok(()) };
        if let Some((since, before)) = held.replace((at, volts)) {
            crossing.sample(at.saturating_sub(self.period).max(since), before, self.out)?;
        }
        crossing.sample(at, volts, self.out)
    }
}

impl Listener for Emit<'_, '_> {
    fn level(&mut self, channel: usize, at: u64, level: Option<Logic>) -> Result<(), Halt> {
        match level {
            Some(level) => self.out.level(channel, at, level),
            None => self.out.end(channel, at),
        }
    }

    fn volts(&mut self, channel: usize, at: u64, volts: f64) -> Result<(), Halt> {
        self.voltages.set(channel, at, volts);
        self.sample(channel, at, volts)
    }

    fn tick_done(&mut self, at: u64) -> Result<(), Halt> {
        for (channel, volts) in self.voltages.differences(at) {
            self.sample(channel, at, volts)?;
        }
        Ok(())
    }

    fn progress(&mut self, done: u64) {
        self.out.progress(done, self.total);
    }
}
