//! The timer's part of a search: edges to a rate of the device.

use crate::detect::{DataPhase, Found, PulseDetector, Verdict};
use crate::units::{Bitrate, Micros, Timebase};
use crate::wire::Logic;

/// So long without an edge ends a recording: ten bits and more at any rate in use.
const QUIET: Micros = Micros::from_ms(5);
/// How far a bus may be from a rate of the device: two clocks and the measurement.
const REACH_PPM: u64 = 20_000;
/// Proof that suffices without a controller that confirms it: two different frames.
const CERTAIN_BITS: u32 = 20;
/// Or this many that may be alike, as a lone sender repeats one for ever.
const CERTAIN_FRAMES: u32 = 4;

/// Edges without a verdict after which a measurement begins anew. What was tried in vain counts
/// against a proof, and a lone sender repeats one frame for ever: after noise at the beginning it
/// would never do.
const EDGES_MAX: u32 = 5_000;

/// What the timer knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measured {
    /// Nothing yet.
    Nothing,
    /// A rate of the device.
    Rate {
        rate: Bitrate,
        /// Proven by more than one frame.
        certain: bool,
    },
    /// A rate that the device does not have, or a CAN FD bus.
    Foreign,
}

/// A measurement under way.
#[derive(Debug, Clone)]
pub(super) struct Measure<const N: usize> {
    detector: PulseDetector<N>,
    timebase: Timebase,
    recording: bool,
    /// Ticks of the last edge.
    last: u64,
    /// There were edges since the last look at the verdict.
    fresh: bool,
    edges: u32,
    /// There were edges since the recording was last ended.
    open: bool,
    deadline: Option<Micros>,
}

impl<const N: usize> Measure<N> {
    pub(super) const fn new(timebase: Timebase) -> Self {
        Self {
            detector: PulseDetector::new(),
            timebase,
            recording: false,
            last: 0,
            fresh: false,
            edges: 0,
            open: false,
            deadline: None,
        }
    }

    /// Forgets everything, as AP2925 asks for after an error.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.timebase);
    }

    /// RXD changed to `level` at `ticks`.
    pub(super) fn edge(&mut self, ticks: u64, level: Logic) {
        if self.recording {
            self.detector.push(ticks);
        } else {
            self.detector.begin(ticks, level);
            self.recording = true;
        }
        self.last = ticks;
        self.fresh = true;
        self.edges = self.edges.saturating_add(1);
        self.open = true;
    }

    /// The timer stands at `ticks`, and RXD is at `level`.
    pub(super) fn timer(&mut self, ticks: u64, level: Logic) {
        let quiet = self.timebase.nanoseconds(ticks.saturating_sub(self.last));
        if !self.recording {
            self.detector.begin(ticks, level);
            self.recording = true;
            self.last = ticks;
        } else if self.open && quiet.is_none_or(|ns| ns / 1000 >= QUIET.0) {
            self.detector.finish(ticks);
            self.detector.begin(ticks, level);
            self.open = false;
            self.fresh = true;
        }
    }

    pub(super) const fn deadline(&self) -> Option<Micros> {
        self.deadline
    }

    /// What the verdict is, if there is something new to look at.
    pub(super) fn poll(&mut self, now: Micros, rates: &[Bitrate]) -> Option<Measured> {
        if !self.fresh {
            if !self.open {
                self.deadline = None;
            } else if self.deadline.is_some_and(|at| at <= now) {
                self.deadline = Some(now + QUIET);
            }
            return None;
        }
        self.fresh = false;
        self.deadline = Some(now + QUIET);
        match self.detector.verdict() {
            Verdict::Found(found) => self.rate(&found, rates),
            // The rate has changed under way.
            Verdict::Conflict { .. } => {
                self.restart();
                Some(Measured::Nothing)
            }
            Verdict::Undecided(_) if self.edges > EDGES_MAX => {
                self.restart();
                Some(Measured::Nothing)
            }
            Verdict::Undecided(_) | Verdict::NoTraffic => None,
        }
    }

    fn rate(&self, found: &Found, rates: &[Bitrate]) -> Option<Measured> {
        let measured = found.nominal.millibits_per_second(self.timebase)?;
        let apart = |rate: &Bitrate| {
            measured.abs_diff(u64::from(rate.bits_per_second()).saturating_mul(1000))
        };
        let nearest = rates.iter().min_by_key(|rate| apart(rate))?;
        let reach = measured / 1_000_000 * REACH_PPM;
        if found.data != DataPhase::NoFd || apart(nearest) > reach {
            return Some(Measured::Foreign);
        }
        let certain = found.proof_bits >= CERTAIN_BITS || found.proven_frames >= CERTAIN_FRAMES;
        Some(Measured::Rate { rate: *nearest, certain })
    }
}
