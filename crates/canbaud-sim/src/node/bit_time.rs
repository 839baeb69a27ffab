//! Bit time and synchronisation [ISO 11898-1 bit timing].

use core::cmp::Ordering;

use super::segments::Segments;
use crate::clock::{Clock, Tick};
use crate::time::{Span, Time};
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

/// Where a node is in its bit: the bit whose sample point comes next.
///
/// Everything is counted in quanta from `origin`, the last sample point; edges only move counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Position {
    origin: Tick,
    /// Quanta from the origin to the start of the bit.
    start: u64,
    /// Quanta from the origin to its sample point.
    to_sample: u64,
    sample: Tick,
    last: Option<SyncOutcome>,
}

/// The clock and the bit timings of a node, and where it is.
#[derive(Debug, Clone)]
pub(crate) struct BitTime {
    clock: Clock,
    nominal: Segments,
    data: Segments,
    timings: (BitTiming, BitTiming),
    rate: Rate,
    at: Position,
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
        let origin = Tick::at(start);
        Self {
            data: Segments::new(&clock, &data),
            timings: (nominal, data),
            rate: Rate::Nominal,
            at: Position {
                origin,
                start: 0,
                to_sample: segments.sample,
                sample: clock.after(origin, &segments.quantum, segments.sample),
                last: None,
            },
            nominal: segments,
            clock,
        }
    }

    /// Another clock from the last sample point on: a piece of a drift.
    pub(crate) fn change_clock(&mut self, clock: Clock) {
        self.nominal = Segments::new(&clock, &self.timings.0);
        self.data = Segments::new(&clock, &self.timings.1);
        self.clock = clock;
        self.at.origin = self.at.origin.rebased();
        self.place_sample();
    }

    /// Where the node is.
    pub(crate) const fn position(&self) -> Position {
        self.at
    }

    /// Back to where the node was, at the same rate.
    pub(crate) const fn go_back(&mut self, at: Position) {
        self.at = at;
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
    pub(crate) fn start(&self) -> Time {
        self.tick(self.at.start).time()
    }

    #[inline]
    pub(crate) const fn sample(&self) -> Time {
        self.at.sample.time()
    }

    #[inline]
    pub(crate) const fn sample_tick(&self) -> Tick {
        self.at.sample
    }

    /// The last sample point.
    #[inline]
    pub(crate) const fn origin(&self) -> Tick {
        self.at.origin
    }

    /// The tick `bits` whole bits after `from`.
    #[inline]
    pub(crate) fn bits_after(&self, from: Tick, bits: u32) -> Tick {
        let segments = self.segments();
        match segments.bits.get(bits as usize) {
            Some(length) => self.clock.next(from, length),
            None => self.clock.after(from, &segments.bits[1], bits.into()),
        }
    }

    /// How many whole bits after `from` end at or before `time`, which is not before `from`.
    pub(crate) fn bits_until(&self, from: Tick, time: Time) -> u64 {
        self.clock.locate(from, &self.segments().bits[1], time)
    }

    /// The start of the bit that follows the sample point `last`.
    #[inline]
    pub(crate) fn start_after(&self, last: Tick) -> Tick {
        self.clock.next(last, &self.segments().to_start)
    }

    /// The end of SYNC_SEG of a bit that starts at `start`.
    #[inline]
    pub(crate) fn end_of_sync_seg(&self, start: Tick) -> Tick {
        self.clock.next(start, &self.segments().quantum)
    }

    /// At least this lies between the start of a bit and its sample point.
    pub(crate) const fn least_to_sample(&self) -> Span {
        let segments = self.segments();
        Span::from_fs(segments.quantum.femtoseconds() * segments.sample)
    }

    /// Whole bits went by in which edges did nothing but `sync`, up to the sample point `last`;
    /// the one after that is `next`.
    pub(crate) const fn go_by(&mut self, last: Tick, next: Tick, sync: Option<SyncOutcome>) {
        self.begin_after(last, next);
        self.at.last = sync;
    }

    #[inline]
    fn tick(&self, quanta: u64) -> Tick {
        self.clock.after(self.at.origin, &self.segments().quantum, quanta)
    }

    /// A time before the sample point that follows the next `bits` ones, however edges shorten the
    /// bits until then; `None` if that is not later than the next sample point.
    #[inline]
    pub(crate) fn before_sample(&self, bits: u32) -> Option<Time> {
        let segments = self.segments();
        let bits = u64::from(bits);
        // A pulse between two sample points may shorten any bit.
        let shortened = (bits + 1) * segments.sjw;
        let quanta = (bits * segments.total()).checked_sub(shortened)?;
        Some(self.clock.after(self.at.sample, &segments.quantum, quanta).time())
    }

    /// The sample point after the next `bits` ones, if no edge comes.
    #[inline]
    pub(crate) fn sample_after(&self, bits: u32) -> Time {
        let segments = self.segments();
        self.clock
            .after(self.at.sample, &segments.quantum, u64::from(bits) * segments.total())
            .time()
    }

    #[inline]
    fn place_sample(&mut self) {
        self.at.sample = self.tick(self.at.to_sample);
    }

    /// Past the sample point: the rest of the bit and the next one have `rate`.
    #[inline]
    pub(crate) fn advance(&mut self, rate: Rate) {
        self.rate = rate;
        let next = self.clock.next(self.at.sample, &self.segments().bits[1]);
        self.begin_after(self.at.sample, next);
    }

    /// Past the sample point `last`, the one of the next bit being `next`.
    #[inline]
    const fn begin_after(&mut self, last: Tick, next: Tick) {
        self.at.origin = last;
        self.at.sample = next;
        let (start, to_sample) = (self.segments().phase_seg2, self.segments().total());
        self.at.start = start;
        self.at.to_sample = to_sample;
    }

    /// Past `bits` (at least 1) sample points, no edge coming in between.
    #[inline]
    pub(crate) fn skip(&mut self, bits: u32) {
        let last = self.bits_after(self.at.sample, bits - 1);
        let next = self.clock.next(last, &self.segments().bits[1]);
        self.begin_after(last, next);
    }

    /// Past all sample points before `limit`, no edge coming in between; returns how many they are.
    #[inline]
    pub(crate) fn pass(&mut self, limit: Time) -> u32 {
        let (mut last, mut next, mut count) = (self.at.origin, self.at.sample, 0);
        while next.time() < limit {
            last = next;
            next = self.clock.next(next, &self.segments().bits[1]);
            count += 1;
        }
        if count > 0 {
            self.begin_after(last, next);
        }
        count
    }

    /// Lets whole bits pass until one starts at or after `time`: the bus was idle.
    pub(crate) fn skip_to(&mut self, time: Time) {
        if self.start() >= time {
            return;
        }
        let segments = self.segments();
        let (total, sample) = (segments.total(), segments.sample);
        let gone = self.clock.locate(self.at.origin, &segments.quantum, time) - self.at.start;
        // The origin stays behind `time`: an edge may come before the bit starts.
        self.at.origin = self.tick(self.at.start + gone / total * total);
        self.at.start = if self.at.origin.time() < time { total } else { 0 };
        self.at.to_sample = self.at.start + sample;
        self.place_sample();
    }

    /// A recessive to dominant edge at `time`, which is after the last sample point. Returns what
    /// it did, and when a change of TXD that waits for the start of the bit takes place now.
    #[inline]
    pub(crate) fn edge(&mut self, time: Time, rule: SyncRule) -> (SyncOutcome, u64) {
        let segments = self.segments();
        let (sjw, sample) = (segments.sjw, segments.sample);
        let position = self.clock.locate(self.at.origin, &segments.quantum, time);
        let outcome = match (rule, position.cmp(&self.at.start)) {
            (SyncRule::Off, _) | (SyncRule::NegativeOnly, Ordering::Greater) => {
                SyncOutcome::Ignored
            }
            (SyncRule::Hard, _) => {
                self.at.start = position;
                self.at.to_sample = position + sample;
                self.place_sample();
                SyncOutcome::Hard
            }
            (_, Ordering::Equal) => SyncOutcome::InSyncSeg,
            (_, Ordering::Greater) => {
                let error = position - self.at.start;
                let by = error.min(sjw);
                self.at.to_sample += by;
                self.place_sample();
                SyncOutcome::Lengthened { error: error as u32, by: by as u32 }
            }
            (_, Ordering::Less) => {
                let error = self.at.start - position;
                let by = error.min(sjw);
                self.at.start -= by;
                self.at.to_sample -= by;
                self.place_sample();
                SyncOutcome::Shortened { error: error as u32, by: by as u32 }
            }
        };
        self.at.last = Some(outcome);
        (outcome, position)
    }

    /// A recessive to dominant edge at `time`, at which the node resynchronises, in the first bit
    /// after a sample point: true, and done, if it is sure to lie in SYNC_SEG.
    #[inline]
    pub(crate) fn edge_in_sync_seg(&mut self, time: Time) -> bool {
        let start = self.start_after(self.at.origin).time().femtoseconds();
        let since = time.femtoseconds().wrapping_sub(start);
        let surely = since < self.segments().quantum.femtoseconds();
        if surely {
            self.at.last = Some(SyncOutcome::InSyncSeg);
        }
        surely
    }

    /// SJW in quanta.
    pub(crate) const fn sjw(&self) -> u32 {
        self.segments().sjw as u32
    }

    /// When a change of TXD that waits for the start of the bit takes place, after an edge in
    /// quantum `position`: the edge is seen at the end of its quantum.
    pub(crate) fn change_after_edge(&self, position: u64) -> Time {
        self.tick(self.at.start.max(position + 1)).time()
    }

    /// What the last edge did.
    pub(crate) const fn last_sync(&self) -> Option<SyncOutcome> {
        self.at.last
    }

    /// `quanta` quanta of the present rate after `time`, for the secondary sample point.
    pub(crate) fn quanta_after(&self, time: Time, quanta: u32) -> Time {
        self.clock.after(Tick::at(time), &self.segments().quantum, quanta.into()).time()
    }
}
