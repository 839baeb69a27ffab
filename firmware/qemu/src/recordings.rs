//! Recordings to work on: those of `vectors/detect`, and frames of `vectors/bits` as a timer of
//! any frequency sees them.

use canbaud::detect::Verdict;
use canbaud::units::{Hertz, Timebase};
use canbaud::wire::Logic;

/// A recording with the verdict that it must lead to.
#[derive(Debug, Clone, Copy)]
pub struct Recording {
    /// File name in `vectors/detect`.
    pub name: &'static str,
    /// Ticks per second.
    pub timebase_hz: u64,
    /// The level at tick 0.
    pub initial: Logic,
    /// The line stays put until this tick.
    pub end: u64,
    /// Ticks of the edges.
    pub edges: &'static [u32],
    /// The verdict: `found`, `undecided`, `no_traffic` or `conflict`.
    pub verdict: &'static str,
    /// Least and greatest right rate, in thousandths of a bit/s.
    pub nominal_millibits: [u64; 2],
}

include!(concat!(env!("OUT_DIR"), "/recordings.rs"));
include!(concat!(env!("OUT_DIR"), "/frames.rs"));

impl Recording {
    /// Whether `verdict` is the right one.
    #[must_use]
    pub fn expects(&self, verdict: &Verdict) -> bool {
        match verdict {
            Verdict::Found(found) => {
                let rate = Hertz::new(self.timebase_hz)
                    .map(Timebase::from_frequency)
                    .and_then(|timer| found.nominal.millibits_per_second(timer));
                let [low, high] = self.nominal_millibits;
                self.verdict == "found" && rate.is_some_and(|rate| (low..=high).contains(&rate))
            }
            Verdict::Undecided(_) => self.verdict == "undecided",
            Verdict::NoTraffic => self.verdict == "no_traffic",
            Verdict::Conflict { .. } => self.verdict == "conflict",
        }
    }
}

/// The recording of that name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Recording> {
    RECORDINGS.iter().find(|recording| recording.name == name)
}

/// The edges of the frame `name` of `vectors/bits`, sent at `bitrate` and seen by a timer of
/// `timer_hz`; the first after 20 bits of idle. Bit `n` begins on the first tick at or after its
/// time. Gives the number of edges, and the time at which 20 more bits are over.
#[must_use]
pub fn sample(name: &str, bitrate: u64, timer_hz: u64, edges: &mut [u32]) -> (usize, u64) {
    let bits = FRAMES.iter().find(|frame| frame.0 == name).map_or("", |frame| frame.1);
    let tick = |bit: u64| (bit * timer_hz).div_ceil(bitrate.max(1));
    let mut count = 0;
    let mut level = b'1';
    for (bit, next) in (20..).zip(bits.bytes()) {
        if next != level {
            level = next;
            if let Some(slot) = edges.get_mut(count) {
                *slot = tick(bit) as u32;
                count += 1;
            }
        }
    }
    (count, tick(40 + bits.len() as u64))
}
