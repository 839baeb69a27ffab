//! Bit time and synchronisation [ISO 11898-1 bit timing].

use crate::clock::{Clock, Quantum, Tick};
use crate::time::Time;
use crate::timing::BitTiming;

/// Which of the two bit rates a bit has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Rate {
    Nominal,
    Data,
}

/// What an edge may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum SyncRule {
    /// Hard synchronisation.
    Hard,
    /// Resynchronisation with both signs of phase error.
    Both,
    /// Resynchronisation, but a positive phase error does nothing: the node sends dominant.
    NegativeOnly,
    /// Nothing.
    Off,
}

/// What an edge did; the corners of resynchronisation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SyncOutcome {
    /// Hard synchronisation.
    Hard,
    /// The edge lies in SYNC_SEG.
    InSyncSeg,
    /// Positive phase error, PHASE_SEG1 was lengthened by `by` quanta.
    Lengthened {
        /// Phase error in quanta.
        error: u32,
        /// At most SJW.
        by: u32,
    },
    /// Negative phase error, PHASE_SEG2 was shortened by `by` quanta.
    Shortened {
        /// Phase error in quanta, without its sign.
        error: u32,
        /// At most SJW.
        by: u32,
    },
    /// The node sends dominant and the phase error is positive, or it does not synchronise now.
    Ignored,
}

/// A bit timing in the quanta of one clock.
#[derive(Debug, Clone)]
struct Segments {
    quantum: Quantum,
    sample: u64,
    phase_seg2: u64,
    sjw: u64,
}

impl Segments {
    fn new(clock: &Clock, timing: &BitTiming) -> Self {
        Self {
            quantum: clock.quantum(timing.prescaler()),
            sample: timing.sample_quanta().into(),
            phase_seg2: timing.phase_seg2().into(),
            sjw: timing.sjw().into(),
        }
    }

    const fn total(&self) -> u64 {
        self.sample + self.phase_seg2
    }
}

/// Where a node is in its bit: the bit whose sample point comes next.
#[derive(Debug, Clone)]
pub(crate) struct BitTime {
    clock: Clock,
    nominal: Segments,
    data: Segments,
    timings: (BitTiming, BitTiming),
    rate: Rate,
    start: Tick,
    sample: Tick,
    last: Option<SyncOutcome>,
}

impl BitTime {
    pub(crate) fn new(
        clock: Clock,
        nominal: BitTiming,
        data: Option<BitTiming>,
        start: Time,
    ) -> Self {
        let data = data.unwrap_or(nominal);
        let segments = Segments::new(&clock, &nominal);
        let start = Tick::at(start);
        let sample = clock.after(start, &segments.quantum, segments.sample);
        Self {
            data: Segments::new(&clock, &data),
            nominal: segments,
            timings: (nominal, data),
            clock,
            rate: Rate::Nominal,
            start,
            sample,
            last: None,
        }
    }

    /// Another clock from the start of the next bit on: a piece of a drift.
    pub(crate) fn change_clock(&mut self, clock: Clock) {
        self.nominal = Segments::new(&clock, &self.timings.0);
        self.data = Segments::new(&clock, &self.timings.1);
        self.clock = clock;
        self.start = self.start.rebased();
        self.place_sample(0);
    }

    #[inline]
    const fn segments(&self) -> &Segments {
        match self.rate {
            Rate::Nominal => &self.nominal,
            Rate::Data => &self.data,
        }
    }

    pub(crate) const fn rate(&self) -> Rate {
        self.rate
    }

    /// The start of the bit whose sample point comes next.
    #[inline]
    pub(crate) const fn start(&self) -> Time {
        self.start.time()
    }

    #[inline]
    pub(crate) const fn sample(&self) -> Time {
        self.sample.time()
    }

    /// A time before the sample point that follows the next `bits` ones, however edges shorten the
    /// bits until then; `None` if that is not later than the next sample point.
    #[inline]
    pub(crate) fn before_sample(&self, bits: u32) -> Option<Time> {
        let segments = self.segments();
        let bits = u64::from(bits);
        // An edge to dominant comes every other bit at most.
        let shortened = (bits / 2 + 2) * segments.sjw;
        let quanta = (bits * segments.total()).checked_sub(shortened)?;
        Some(self.clock.after(self.sample, &segments.quantum, quanta).time())
    }

    #[inline]
    fn place_sample(&mut self, lengthened: u64) {
        let segments = self.segments();
        self.sample =
            self.clock.after(self.start, &segments.quantum, segments.sample + lengthened);
    }

    /// Past the sample point: the rest of the bit and the next one have `rate`.
    #[inline]
    pub(crate) fn advance(&mut self, rate: Rate) {
        self.rate = rate;
        let segments = self.segments();
        self.start = self.clock.after(self.sample, &segments.quantum, segments.phase_seg2);
        self.place_sample(0);
    }

    /// Lets whole bits pass until one starts at or after `time`: the bus was idle.
    pub(crate) fn skip_to(&mut self, time: Time) {
        if self.start.time() >= time {
            return;
        }
        let segments = self.segments();
        let quanta = self.clock.locate(self.start, &segments.quantum, time).unsigned_abs();
        let bits = quanta / segments.total();
        let at = self.clock.after(self.start, &segments.quantum, bits * segments.total());
        self.start = if at.time() < time {
            self.clock.after(at, &segments.quantum, segments.total())
        } else {
            at
        };
        self.place_sample(0);
    }

    /// A recessive to dominant edge at `time`. Returns what it did, and when a change of TXD that
    /// waits for the start of the bit takes place now.
    pub(crate) fn edge(&mut self, time: Time, rule: SyncRule) -> (SyncOutcome, Time) {
        let quantum = self.segments().quantum;
        let position = self.clock.locate(self.start, &quantum, time);
        let outcome = match (rule, position) {
            (SyncRule::Off, _) | (SyncRule::NegativeOnly, 1..) => SyncOutcome::Ignored,
            (SyncRule::Hard, _) => {
                self.start = if position >= 0 {
                    self.clock.after(self.start, &quantum, position.unsigned_abs())
                } else {
                    self.clock.before(self.start, &quantum, position.unsigned_abs())
                };
                self.place_sample(0);
                SyncOutcome::Hard
            }
            (_, 0) => SyncOutcome::InSyncSeg,
            (_, 1..) => {
                let error = position.unsigned_abs();
                let by = error.min(self.segments().sjw);
                self.place_sample(by);
                SyncOutcome::Lengthened { error: error as u32, by: by as u32 }
            }
            (_, _) => {
                let error = position.unsigned_abs();
                let by = error.min(self.segments().sjw);
                self.start = self.clock.before(self.start, &quantum, by);
                self.place_sample(0);
                SyncOutcome::Shortened { error: error as u32, by: by as u32 }
            }
        };
        self.last = Some(outcome);
        // The edge is seen at the end of its quantum.
        let seen = if self.start.time() > time {
            self.start.time()
        } else {
            let into = self.clock.locate(self.start, &quantum, time).unsigned_abs();
            self.clock.after(self.start, &quantum, into + 1).time()
        };
        (outcome, seen)
    }

    /// What the last edge did.
    pub(crate) const fn last_sync(&self) -> Option<SyncOutcome> {
        self.last
    }

    /// `quanta` quanta of the present rate after `time`, for the secondary sample point.
    pub(crate) fn quanta_after(&self, time: Time, quanta: u32) -> Time {
        self.clock.after(Tick::at(time), &self.segments().quantum, quanta.into()).time()
    }
}
