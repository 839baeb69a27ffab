//! A stream of requests of one node.

use canbaud::wire::Frame;

use super::payload::{FrameFormat, Payload, PayloadError};
use crate::event::NodeId;
use crate::rng::Rng;
use crate::time::{Span, Time};

/// When requests come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Arrivals {
    /// Every `period`, each up to `jitter` late.
    Periodic {
        /// From one to the next.
        period: Span,
        /// Largest delay.
        jitter: Span,
    },
    /// At random, this long apart on average.
    Poisson {
        /// Mean time between two.
        mean: Span,
    },
    /// `size` at once, every `period`.
    Burst {
        /// Requests at once.
        size: u32,
        /// From one burst to the next.
        period: Span,
    },
    /// One.
    Single,
    /// As soon as one is sent, the next.
    Saturate,
    /// Given frames at given times after the start.
    Replay(Vec<(Span, Frame)>),
}

/// A stream of requests: when the next one comes, and what it asks for.
#[derive(Debug, Clone)]
pub struct Source {
    node: NodeId,
    arrivals: Arrivals,
    format: FrameFormat,
    payload: Payload,
    start: Time,
    stop: Time,
    rng: Rng,
    /// Requests so far.
    count: u64,
    /// Periods so far.
    periods: u64,
    next: Time,
}

impl Source {
    /// A stream from `start` up to `stop`.
    ///
    /// # Errors
    /// [`PayloadError`] if format and payload do not fit together.
    pub fn new(
        node: NodeId,
        arrivals: Arrivals,
        format: FrameFormat,
        payload: Payload,
        (start, stop): (Time, Time),
        rng: Rng,
    ) -> Result<Self, PayloadError> {
        payload.frame(format, 0, &mut rng.clone())?;
        let mut source = Self {
            node,
            arrivals,
            format,
            payload,
            start,
            stop,
            rng,
            count: 0,
            periods: 0,
            next: start,
        };
        source.plan();
        Ok(source)
    }

    /// Who sends.
    #[must_use]
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// When the next request comes; [`Time::NEVER`] if none does.
    #[must_use]
    pub const fn next(&self) -> Time {
        self.next
    }

    /// Whether a request follows each transmission.
    #[must_use]
    pub const fn saturates(&self) -> bool {
        matches!(self.arrivals, Arrivals::Saturate)
    }

    fn plan(&mut self) {
        let after = |periods: u64, period: Span| {
            Span::from_fs(period.femtoseconds().saturating_mul(periods))
        };
        self.next = match &self.arrivals {
            Arrivals::Periodic { period, jitter } => {
                let late = Span::from_fs(self.rng.below(jitter.femtoseconds() + 1));
                self.start + after(self.periods, *period) + late
            }
            Arrivals::Poisson { mean } => {
                let wait = self.rng.exponential() * mean.femtoseconds() as f64;
                self.next + Span::from_fs(wait as u64)
            }
            Arrivals::Burst { period, .. } => self.start + after(self.periods, *period),
            Arrivals::Single | Arrivals::Saturate if self.count == 0 => self.start,
            Arrivals::Single | Arrivals::Saturate => Time::NEVER,
            Arrivals::Replay(frames) => match frames.get(self.count as usize) {
                Some((at, _)) => self.start + *at,
                None => Time::NEVER,
            },
        };
        if self.next >= self.stop {
            self.next = Time::NEVER;
        }
    }

    fn frame(&mut self) -> Option<Frame> {
        let count = self.count;
        self.count += 1;
        match &self.arrivals {
            Arrivals::Replay(frames) => frames.get(count as usize).map(|(_, frame)| *frame),
            // Checked when the source was made.
            _ => self.payload.frame(self.format, count, &mut self.rng).ok(),
        }
    }

    /// The requests that come now.
    pub fn fire(&mut self) -> Vec<Frame> {
        let size = match self.arrivals {
            Arrivals::Burst { size, .. } => size,
            // Two, so that one waits while the other is sent.
            Arrivals::Saturate => 2,
            _ => 1,
        };
        let frames = (0..size).filter_map(|_| self.frame()).collect();
        self.periods += 1;
        self.plan();
        frames
    }

    /// A frame of this stream was sent; returns the one that follows it.
    pub fn refill(&mut self, now: Time) -> Option<Frame> {
        if self.saturates() && now < self.stop { self.frame() } else { None }
    }
}
