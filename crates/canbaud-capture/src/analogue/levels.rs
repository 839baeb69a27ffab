//! The two levels of a line, from how often each voltage occurs.

use super::Histogram;

/// A threshold given by hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold {
    /// The voltage at which an edge is placed.
    pub volts: f64,
    /// How far beyond it the voltage must go for the edge to count, in volts, 0 or more.
    pub hysteresis: f64,
}

/// The two levels that an analogue channel rests at.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Levels {
    /// Mean voltage of the lower level.
    pub low: f64,
    /// Mean voltage of the higher level.
    pub high: f64,
    /// Where edges are placed, and the hysteresis.
    pub threshold: Threshold,
}

/// The levels must be this many standard deviations of the wider one apart: pure noise gives 2.7,
/// a triangle 3.5, a sine 4.1.
const MIN_SEPARATION: f64 = 4.5;
/// A group smaller than this share that is no level is spikes, and what remains is searched again.
const OUTLIERS: f64 = 0.02;
/// The hysteresis as a share of the distance between the levels.
const HYSTERESIS: f64 = 0.15;
/// A level that a spike makes can hide the one below it; so many are looked at.
const MAX_CANDIDATES: usize = 4;

/// Splits that are tried; each that is no candidate takes spikes away.
const MAX_SPLITS: usize = 16;
/// The shortest frame has about as many edges.
const MIN_CROSSINGS: u64 = 12;

struct Class {
    count: f64,
    mean: f64,
    deviation: f64,
}

impl Class {
    fn of(bins: &[(f64, u64)]) -> Option<Self> {
        let count: f64 = bins.iter().map(|&(_, n)| n as f64).sum();
        if count <= 0.0 {
            return None;
        }
        let mean = bins.iter().map(|&(v, n)| v * (n as f64)).sum::<f64>() / count;
        let variance =
            bins.iter().map(|&(v, n)| (v - mean).powi(2) * (n as f64)).sum::<f64>() / count;
        // Within a bin the values are spread evenly; without this, two bins were two levels.
        let bin = mean.abs() / 256.0;
        Some(Self { count, mean, deviation: (variance + bin * bin / 12.0).sqrt() })
    }
}

/// Places where the voltages fall into two groups.
///
/// Each group is a level with its noise; how many samples it has does not matter, because a bus is
/// idle most of the time. The larger group is then searched again: a few samples of a spike or of
/// the supply coming up must not hide the bus.
pub(crate) fn candidates(histogram: &Histogram) -> Vec<Levels> {
    let all = histogram.bins();
    let mut bins = all.as_slice();
    let mut found: Vec<Levels> = Vec::new();
    for _ in 0..MAX_SPLITS {
        if found.len() >= MAX_CANDIDATES {
            break;
        }
        let Some(at) = split(bins) else { break };
        let (below, above) = bins.split_at(at);
        let (Some(low), Some(high)) = (Class::of(below), Class::of(above)) else { break };
        let swing = high.mean - low.mean;
        let two = swing >= MIN_SEPARATION * low.deviation.max(high.deviation) && swing.is_finite();
        if !two && low.count.min(high.count) > OUTLIERS * (low.count + high.count) {
            break;
        }
        if two {
            found.push(Levels {
                low: low.mean,
                high: high.mean,
                threshold: Threshold {
                    volts: low.mean.midpoint(high.mean),
                    hysteresis: HYSTERESIS * swing,
                },
            });
        }
        bins = if low.count >= high.count { below } else { above };
    }
    found
}

/// The first bin of the upper group: where the threshold lies midway between the group means.
fn split(bins: &[(f64, u64)]) -> Option<usize> {
    let (first, last) = (bins.first()?.0, bins.last()?.0);
    if bins.len() < 2 {
        return None;
    }
    let mut threshold = first.midpoint(last);
    let mut at = 0;
    // Converges within a few rounds; the bound is for voltages that oscillate between two splits.
    for _ in 0..32 {
        at = bins.partition_point(|&(v, _)| v <= threshold).clamp(1, bins.len() - 1);
        let (below, above) = bins.split_at(at);
        let next = Class::of(below)?.mean.midpoint(Class::of(above)?.mean);
        if (next - threshold).abs() <= (last - first) * 1e-6 {
            break;
        }
        threshold = next;
    }
    Some(at)
}

/// Chooses among candidates by how often the signal crosses each.
pub(crate) struct Chooser {
    counters: Vec<Counter>,
}

struct Counter {
    levels: Levels,
    high: Option<bool>,
    crossings: u64,
}

impl Chooser {
    pub(crate) fn new(candidates: Vec<Levels>) -> Self {
        let counters = candidates
            .into_iter()
            .map(|levels| Counter { levels, high: None, crossings: 0 })
            .collect();
        Self { counters }
    }

    pub(crate) fn add(&mut self, values: &[f32]) {
        for counter in &mut self.counters {
            let Threshold { volts, hysteresis } = counter.levels.threshold;
            let (low, high) = ((volts - hysteresis) as f32, (volts + hysteresis) as f32);
            for &value in values {
                let now = if value > high {
                    true
                } else if value < low {
                    false
                } else {
                    continue;
                };
                if counter.high != Some(now) {
                    counter.crossings += 1;
                    counter.high = Some(now);
                }
            }
        }
    }

    /// The widest swing that is the bus.
    ///
    /// A spike or the supply coming up is wide but rare. What is much more frequent is only
    /// believed if it is not much smaller: the last bit of the converter flickers all the time.
    pub(crate) fn choice(&self) -> Option<Levels> {
        let swing = |c: &Counter| c.levels.high - c.levels.low;
        let is_bus = |c: &&Counter| {
            c.crossings >= MIN_CROSSINGS
                && !self.counters.iter().any(|other| {
                    other.crossings / 4 >= c.crossings && swing(other) >= swing(c) / 16.0
                })
        };
        let widest = |a: &&Counter, b: &&Counter| swing(a).total_cmp(&swing(b));
        let bus = self.counters.iter().filter(is_bus).max_by(widest);
        bus.or_else(|| self.counters.iter().max_by(widest)).map(|c| c.levels)
    }
}
