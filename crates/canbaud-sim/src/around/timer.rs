//! A timer that captures the edges of RXD, with its clock, its width and the time that the
//! interrupt takes.

use canbaud::wire::Level;

use crate::clock::{Clock, ClockError, Quantum, Tick};
use crate::time::{Span, Time};

/// An edge as software gets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capture {
    /// The timer at the edge, in its own width.
    pub ticks: u64,
    /// The level after the edge.
    pub level: Level,
    /// An earlier edge was overwritten before software had read it.
    pub overrun: bool,
}

/// A free-running timer with one capture register.
///
/// ```
/// use canbaud::wire::Level;
/// use canbaud_sim::around::CaptureTimer;
/// use canbaud_sim::{Span, Time};
/// let mut timer = CaptureTimer::new(8_000_000, 0, 16, Span::ZERO).unwrap();
/// let capture = timer.edge(Time::ZERO + Span::from_us(10_000), Level::Dominant).unwrap();
/// assert_eq!(capture.ticks, 80_000 % 65_536);
/// ```
#[derive(Debug, Clone)]
pub struct CaptureTimer {
    clock: Clock,
    period: Quantum,
    mask: u64,
    latency: Span,
    /// In the register, and when software has read it.
    waiting: Option<(Time, Capture)>,
}

impl CaptureTimer {
    /// A timer of `hertz`, `ppb` parts per billion fast, `width` bits wide (1 to 64), whose
    /// register is read `latency` after an edge; with no latency every edge counts.
    ///
    /// # Errors
    /// [`ClockError`] if there is no such clock.
    pub fn new(hertz: u64, ppb: i64, width: u32, latency: Span) -> Result<Self, ClockError> {
        let clock = Clock::new(hertz, ppb)?;
        let mask = u64::MAX >> (64 - width.clamp(1, 64));
        Ok(Self { period: clock.quantum(1), clock, mask, latency, waiting: None })
    }

    /// The timer at `time`.
    #[must_use]
    pub fn ticks(&self, time: Time) -> u64 {
        self.clock.locate(Tick::default(), &self.period, time) & self.mask
    }

    /// An edge of RXD. Returns what software has read by now: with a latency the edge before.
    pub fn edge(&mut self, at: Time, level: Level) -> Option<Capture> {
        let capture = Capture { ticks: self.ticks(at), level, overrun: false };
        if self.latency == Span::ZERO {
            return Some(capture);
        }
        match self.waiting.take() {
            Some((read_at, before)) if read_at <= at => {
                self.waiting = Some((at + self.latency, capture));
                Some(before)
            }
            Some((read_at, _)) => {
                self.waiting = Some((read_at, Capture { overrun: true, ..capture }));
                None
            }
            None => {
                self.waiting = Some((at + self.latency, capture));
                None
            }
        }
    }

    /// What is in the register in the end.
    pub fn finish(&mut self) -> Option<Capture> {
        self.waiting.take().map(|(_, capture)| capture)
    }
}
