//! From dominant intervals to what a timer with input capture, or a logic analyser, records.

use super::prng::Prng;
use canbaud::wire::{Level, Logic, Polarity};

/// Where an edge lies on its sender's grid of bit times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Edges of one block share one unknown start.
    pub block: u32,
    /// Which bit time counts here.
    pub phase: Phase,
    /// Bit times since the start of the block.
    pub index: u32,
    /// Whether this is the end of a dominant interval, which asymmetry shifts.
    pub dominant_end: bool,
}

/// The two phases of a CAN FD frame; a classic frame has only the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    Nominal,
    Data,
}

/// One end of a dominant interval; without a grid if it is no edge of a sender's bit grid.
#[derive(Debug, Clone, Copy)]
pub struct End {
    pub at: f64,
    pub grid: Option<Grid>,
}

impl End {
    /// An end off the grid.
    pub const fn free(at: f64) -> Self {
        Self { at, grid: None }
    }
}

/// A dominant interval that one node drives, in ticks.
#[derive(Debug, Clone, Copy)]
pub struct Dominant {
    pub start: End,
    pub end: End,
}

/// A change of the recorded line.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    pub at: u64,
    pub grid: Option<Grid>,
}

/// How time stamps come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Capture {
    /// Input capture: every edge is stamped, two edges may share a stamp.
    Timer,
    /// Periodic samples: what happens between two samples is not seen.
    Sampled,
}

/// What the recorder does to the bus.
#[derive(Debug, Clone, Copy)]
pub struct Recorder {
    pub capture: Capture,
    pub polarity: Polarity,
    /// By how much a dominant interval is lengthened (negative: shortened), in ticks.
    pub asymmetry: f64,
    /// Standard deviation of every edge, in ticks.
    pub jitter: f64,
    /// Start and end of the recording on the axis of the bus, in ticks.
    pub window: (f64, f64),
    /// The time stamp at the start of the window.
    pub epoch: u64,
}

/// What a detector sees.
#[derive(Debug, Clone)]
pub struct Recording {
    pub begin: u64,
    pub initial: Logic,
    pub edges: Vec<Edge>,
    pub finish: u64,
}

/// A short pulse that inverts the line.
#[derive(Debug, Clone, Copy)]
pub struct Glitch {
    pub at: f64,
    pub width: f64,
}

impl Recorder {
    /// Records the wired-AND of `intervals`, with `glitches` on top.
    pub fn record(
        &self,
        intervals: &[Dominant],
        glitches: &[Glitch],
        prng: &mut Prng,
    ) -> Recording {
        let mut ends = Vec::with_capacity(intervals.len() * 2 + glitches.len() * 2);
        for interval in wired_and(intervals) {
            let mut start = interval.start;
            let mut end = interval.end;
            end.at += self.asymmetry;
            if self.jitter > 0.0 {
                start.at += self.jitter * prng.gauss();
                end.at += self.jitter * prng.gauss();
            }
            if start.at < end.at {
                ends.extend([start, end]);
            }
        }
        for glitch in glitches {
            ends.extend([End::free(glitch.at), End::free(glitch.at + glitch.width)]);
        }
        ends.sort_by(|a, b| a.at.total_cmp(&b.at));
        self.quantise(&ends)
    }

    /// Every end toggles the line; the stamp is the first tick at or after it.
    fn quantise(&self, ends: &[End]) -> Recording {
        let (from, to) = self.window;
        let toggles_before = ends.iter().filter(|end| end.at <= from).count();
        let mut level = Level::Recessive;
        if toggles_before % 2 == 1 {
            level = level.toggled();
        }
        let mut edges: Vec<Edge> = Vec::with_capacity(ends.len());
        for end in ends.iter().filter(|end| end.at > from && end.at <= to) {
            let at = self.epoch + (end.at - from).ceil() as u64;
            match edges.last() {
                Some(last) if last.at == at && self.capture == Capture::Sampled => {
                    edges.pop();
                }
                _ => edges.push(Edge { at, grid: end.grid }),
            }
        }
        Recording {
            begin: self.epoch,
            initial: logic(self.polarity, level),
            edges,
            finish: self.epoch + (to - from).ceil() as u64,
        }
    }
}

/// The level of the line for a level of the bus.
fn logic(polarity: Polarity, level: Level) -> Logic {
    if polarity.level(Logic::High) == level { Logic::High } else { Logic::Low }
}

/// The union of the intervals, in order; an end that lies inside another interval disappears.
fn wired_and(intervals: &[Dominant]) -> Vec<Dominant> {
    let mut sorted = intervals.to_vec();
    sorted.sort_by(|a, b| a.start.at.total_cmp(&b.start.at));
    let mut union: Vec<Dominant> = Vec::with_capacity(sorted.len());
    for next in sorted {
        match union.last_mut() {
            Some(last) if next.start.at <= last.end.at => {
                if next.end.at > last.end.at {
                    last.end = next.end;
                }
            }
            _ => union.push(next),
        }
    }
    union
}
