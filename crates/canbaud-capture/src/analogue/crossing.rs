//! Threshold crossings, interpolated between samples.

use canbaud::wire::Logic;

use super::{Levels, Threshold};
use crate::error::Halt;
use crate::sink::Output;

/// Follows one analogue channel across its threshold.
///
/// An edge counts once the voltage is beyond the hysteresis; it is placed where the voltage last
/// crossed the threshold itself, on the straight line between two samples.
pub(crate) struct Crossing {
    channel: usize,
    threshold: f64,
    /// Beyond these the level is certain.
    low: f64,
    high: f64,
    level: Option<Logic>,
    /// The sample before, unless it was no number.
    before: Option<(u64, f64)>,
    /// Where the threshold was last crossed, away from `level`.
    crossed: u64,
    begun: Option<u64>,
}

impl Crossing {
    pub(crate) fn new(channel: usize, Threshold { volts, hysteresis }: Threshold) -> Self {
        let hysteresis = hysteresis.max(0.0);
        Self {
            channel,
            threshold: volts,
            low: volts - hysteresis,
            high: volts + hysteresis,
            level: None,
            before: None,
            crossed: 0,
            begun: None,
        }
    }

    /// The levels that a threshold given by hand stands for.
    pub(crate) const fn levels(threshold: Threshold) -> Levels {
        let Threshold { volts, hysteresis } = threshold;
        Levels { low: volts - hysteresis, high: volts + hysteresis, threshold }
    }

    /// Samples at tick `at`, `at + step`, ….
    pub(crate) fn block(
        &mut self,
        at: u64,
        step: u64,
        values: &[f32],
        out: &mut Output<'_>,
    ) -> Result<(), Halt> {
        let mut now = at;
        for chunk in values.chunks(64) {
            if self.is_quiet(chunk) {
                let end = now + step * (chunk.len() as u64 - 1);
                self.before = chunk.last().map(|&v| (end, f64::from(v)));
                now = end + step;
                continue;
            }
            for &value in chunk {
                self.sample(now, f64::from(value), out)?;
                now += step;
            }
        }
        Ok(())
    }

    /// All values are numbers on the near side of the threshold.
    fn is_quiet(&self, values: &[f32]) -> bool {
        let threshold = self.threshold as f32;
        match self.level {
            None => false,
            Some(Logic::Low) => {
                self.before.is_some_and(|(_, v)| v < self.threshold)
                    && values.iter().fold(true, |quiet, &v| quiet & (v < threshold))
            }
            Some(Logic::High) => {
                self.before.is_some_and(|(_, v)| v >= self.threshold)
                    && values.iter().fold(true, |quiet, &v| quiet & (v > threshold))
            }
        }
    }

    /// One sample; ticks never fall. What is not a finite number is skipped.
    pub(crate) fn sample(&mut self, at: u64, value: f64, out: &mut Output<'_>) -> Result<(), Halt> {
        self.begun.get_or_insert(at);
        if !value.is_finite() {
            self.before = None;
            return Ok(());
        }
        let before = self.before.replace((at, value));
        let Some(level) = self.level else { return self.first(at, value, out) };
        let is_high = value >= self.threshold;
        if is_high == (level == Logic::High) {
            return Ok(());
        }
        // Crossed just now, or before and still on the far side.
        match before {
            Some((_, v)) if (v >= self.threshold) == is_high => {}
            Some((then, v)) => self.crossed = interpolate(then, v, at, value, self.threshold),
            None => self.crossed = at,
        }
        let certain = if is_high { value >= self.high } else { value <= self.low };
        if certain {
            self.level = Some(level.toggled());
            out.edge(self.channel, self.crossed)?;
        }
        Ok(())
    }

    /// The level is unknown until a sample is beyond the hysteresis; it then holds from the start.
    fn first(&mut self, at: u64, value: f64, out: &mut Output<'_>) -> Result<(), Halt> {
        let level = if value >= self.high {
            Logic::High
        } else if value <= self.low {
            Logic::Low
        } else {
            return Ok(());
        };
        self.level = Some(level);
        out.level(self.channel, self.begun.unwrap_or(at), level)
    }

    /// The recording ends at tick `at`.
    pub(crate) fn end(&mut self, at: u64, out: &mut Output<'_>) -> Result<(), Halt> {
        self.level = None;
        self.before = None;
        self.begun = None;
        out.end(self.channel, at)
    }
}

/// Where the line from (`t0`, `v0`) to (`t1`, `v1`) meets `threshold`, rounded to a tick.
fn interpolate(t0: u64, v0: f64, t1: u64, v1: f64, threshold: f64) -> u64 {
    let span = t1.saturating_sub(t0);
    let share = ((threshold - v0) / (v1 - v0)).clamp(0.0, 1.0);
    // The share is 0 to 1, so the product fits; NaN becomes 0.
    t0 + ((share * span as f64).round() as u64).min(span)
}
