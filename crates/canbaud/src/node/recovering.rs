//! The way out of bus-off, counted by software \[ISO 11898-1, rule 12; mission D2\].
//!
//! The controller listens meanwhile, so that it hears whether its rate still fits, and software
//! sees no single bits. It counts what is certain: each accepted frame ends with 11 recessive bits
//! (ACK delimiter, EOF, intermission), and the time without frames is recessive but for the length
//! of one frame that may just be under way. A device whose controller cannot listen counts with its
//! timer how long the line is recessive.

use crate::detect::scan::Candidate;
use crate::fault::{RECOVERY_BITS, RECOVERY_OCCURRENCES, Recovery};
use crate::units::{Micros, Timebase};
use crate::wire::Logic;

/// The longest classic frame, every bit stuffed, with its intermission; or an error frame.
const FRAME_BITS: u64 = 163;
/// Errors in a row, without a frame, after which the rate does not fit any more.
const ERRORS_MAX: u32 = 8;

/// How often a device that counts with its timer looks whether it is done.
const LOOK: Micros = Micros::from_ms(2);

/// The timer's view of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Line {
    timebase: Timebase,
    /// The last edge, or the last look; `None` before the first.
    last: Option<(u64, Logic)>,
    /// Bits of the recessive run under way that were counted.
    counted: u32,
    look_at: Option<Micros>,
}

/// A wait for the end of bus-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Recovering {
    pub(super) candidate: Candidate,
    recovery: Recovery,
    /// Bits are counted up to here; the controller listens from here on.
    since: Option<Micros>,
    errors: u32,
    /// Of a device that counts with its timer.
    line: Option<Line>,
}

impl Recovering {
    pub(super) const fn new(candidate: Candidate) -> Self {
        Self { candidate, recovery: Recovery::new(), since: None, errors: 0, line: None }
    }

    /// For a device whose controller cannot listen.
    pub(super) const fn by_timer(candidate: Candidate, timebase: Timebase) -> Self {
        let line = Line { timebase, last: None, counted: 0, look_at: None };
        Self { line: Some(line), ..Self::new(candidate) }
    }

    /// The line was at one level up to `ticks`, and is at `level` from then on.
    pub(super) fn line(&mut self, ticks: u64, level: Logic) {
        let rate = u128::from(self.candidate.nominal.bits_per_second());
        let Some(line) = &mut self.line else { return };
        if let Some((since, Logic::High)) = line.last {
            let run = u128::from(ticks.saturating_sub(since));
            let bits = run
                .saturating_mul(rate * u128::from(line.timebase.seconds()))
                .checked_div(u128::from(line.timebase.ticks()));
            let bits = bits.map_or(0, |bits| u32::try_from(bits).unwrap_or(u32::MAX));
            self.recovery.recessive(bits.saturating_sub(line.counted));
            line.counted = bits.max(line.counted);
        }
        if line.last.is_none_or(|(_, before)| before != level) {
            if level == Logic::Low {
                self.recovery.dominant();
            }
            line.last = Some((ticks, level));
            line.counted = 0;
        }
    }

    /// Plans the next look of a device that counts with its timer.
    pub(super) fn look(&mut self, now: Micros) {
        if let Some(line) = &mut self.line
            && line.look_at.is_none_or(|at| at <= now)
        {
            line.look_at = Some(now + LOOK);
        }
    }

    /// The controller listens.
    pub(super) fn listening(&mut self, now: Micros) {
        self.since = Some(now);
    }

    /// Bits that were certainly recessive in a row, up to `now`.
    fn recessive(&self, now: Micros) -> u32 {
        let Some(since) = self.since else { return 0 };
        let rate = u128::from(self.candidate.nominal.bits_per_second());
        let bits = u128::from((now - since).0) * rate / 1_000_000;
        u32::try_from(bits.saturating_sub(u128::from(FRAME_BITS))).unwrap_or(u32::MAX)
    }

    fn count(&mut self, now: Micros) {
        self.recovery.recessive(self.recessive(now));
        self.recovery.dominant();
        self.since = self.since.map(|_| now);
    }

    /// A frame was accepted.
    pub(super) fn frame(&mut self, now: Micros) {
        self.count(now);
        self.recovery.recessive(RECOVERY_BITS.into());
        self.errors = 0;
    }

    /// An error was heard. True if the rate does not fit any more.
    pub(super) fn error(&mut self, now: Micros) -> bool {
        self.count(now);
        self.errors = self.errors.saturating_add(1);
        self.errors >= ERRORS_MAX
    }

    /// Whether bus-off is over, if nothing more was heard up to `now`.
    pub(super) fn is_complete(&self, now: Micros) -> bool {
        let mut recovery = self.recovery;
        recovery.recessive(self.recessive(now));
        recovery.is_complete()
    }

    /// When bus-off is over if nothing more is heard.
    pub(super) fn deadline(&self) -> Option<Micros> {
        if let Some(line) = &self.line {
            return line.look_at;
        }
        let left = RECOVERY_OCCURRENCES - self.recovery.occurrences();
        let bits = u64::from(left) * u64::from(RECOVERY_BITS) + FRAME_BITS;
        // One microsecond more: the other way it is rounded down.
        Some(self.since? + Micros::of_bits(bits, self.candidate.nominal) + Micros(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Bitrate;

    fn at_250k() -> Recovering {
        let mut wait = Recovering::new(Candidate::classic(Bitrate::new(250_000).unwrap()));
        assert_eq!(wait.deadline(), None);
        wait.listening(Micros(1000));
        wait
    }

    #[test]
    fn silence_ends_it_after_1408_bits_and_a_frame() {
        let wait = at_250k();
        // 4 us a bit.
        let end = Micros(1000 + 4 * (1408 + 163) + 1);
        assert_eq!(wait.deadline(), Some(end));
        assert!(wait.is_complete(end));
        assert!(!wait.is_complete(Micros(1000 + 4 * 1408)));
    }

    #[test]
    fn a_full_bus_ends_it_after_128_frames() {
        let mut wait = at_250k();
        for frame in 1..=128_u64 {
            assert!(!wait.is_complete(Micros(1000 + frame * 520)));
            wait.frame(Micros(1000 + frame * 520));
        }
        assert!(wait.is_complete(Micros(1000 + 128 * 520)));
    }

    #[test]
    fn the_timer_counts_recessive_bits_one_by_one() {
        let timer = Timebase::new(8_000_000, 1).unwrap();
        let candidate = Candidate::classic(Bitrate::new(250_000).unwrap());
        let mut wait = Recovering::by_timer(candidate, timer);
        // 32 ticks a bit.
        wait.line(0, Logic::High);
        let mut ticks = 0;
        for occurrence in 1..=127 {
            // Ten bits are none, eleven are one.
            for bits in [10, 11] {
                ticks += 32 * bits;
                wait.line(ticks, Logic::Low);
                ticks += 32;
                wait.line(ticks, Logic::High);
            }
            assert_eq!(wait.recovery.occurrences(), occurrence);
        }
        // Looking twice counts nothing twice.
        for bits in 1..11 {
            wait.line(ticks + 32 * bits, Logic::High);
            assert!(!wait.is_complete(Micros(0)), "{bits}");
        }
        wait.line(ticks + 32 * 11, Logic::High);
        assert!(wait.is_complete(Micros(0)));
    }

    #[test]
    fn errors_in_a_row_say_that_the_rate_does_not_fit() {
        let mut wait = at_250k();
        let mut now = Micros(1000);
        for _ in 0..3 {
            for error in 1..=7 {
                now = now + Micros(100);
                assert!(!wait.error(now), "{error}");
            }
            wait.frame(now);
        }
        assert!((1..=8).any(|_| wait.error(now)));
    }
}
