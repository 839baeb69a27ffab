//! How long answers take, learned from those that came.

use crate::lss::Pace;
use crate::units::Micros;

/// What is known of the way there and back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rhythm {
    shortest: Micros,
    longest: Micros,
    /// Mean and mean deviation, by the weights of RFC 6298.
    mean: Micros,
    deviation: Micros,
    /// From the first answer to a question to the last one, where several devices answer it.
    spread: Micros,
}

/// Added to the silence time-out: one turn of a slow main loop.
const MARGIN: Micros = Micros::from_ms(10);

impl Rhythm {
    pub(super) const fn new() -> Self {
        let zero = Micros(0);
        Self { shortest: Micros::MAX, longest: zero, mean: zero, deviation: zero, spread: zero }
    }

    /// A first answer took so long.
    pub(super) fn note(&mut self, round_trip: Micros) {
        if self.is_new() {
            (self.mean, self.deviation) = (round_trip, Micros(round_trip.0 / 2));
        } else {
            let away = Micros(self.mean.0.abs_diff(round_trip.0));
            self.deviation = weighted(self.deviation, 3, away);
            self.mean = weighted(self.mean, 7, round_trip);
        }
        self.shortest = self.shortest.min(round_trip);
        self.longest = self.longest.max(round_trip);
    }

    /// A further answer to the same question came so long behind the first.
    pub(super) fn note_further(&mut self, behind: Micros) {
        self.spread = self.spread.max(behind);
    }

    /// Whether an answer comes sooner than any device could have given it; where answers take less
    /// than 2 ms, they vary too much to tell.
    pub(super) fn is_too_early(&self, round_trip: Micros) -> bool {
        !self.is_new() && self.shortest >= Micros::from_ms(2) && round_trip.0 < self.shortest.0 / 2
    }

    fn is_new(&self) -> bool {
        self.shortest == Micros::MAX
    }

    pub(super) const fn longest(&self) -> Micros {
        self.longest
    }

    /// How long without an answer is silence: four mean deviations behind the mean, as a time-out
    /// of TCP, so that one slow answer is not waited for ever after; the slowest device included.
    pub(super) fn silence(&self, pace: &Pace) -> Micros {
        let usual = self.mean + self.deviation.times(4) + self.settle() + MARGIN;
        usual.min(pace.answer_timeout)
    }

    /// How long to wait for further answers; nothing where one device answers, or all at once.
    pub(super) const fn settle(&self) -> Micros {
        Micros(self.spread.0.saturating_add(self.spread.0 / 4))
    }
}

/// The mean of so many parts of `old` and one of `new`.
const fn weighted(old: Micros, parts: u64, new: Micros) -> Micros {
    Micros(old.0.saturating_mul(parts).saturating_add(new.0) / (parts + 1))
}
