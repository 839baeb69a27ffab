//! How long answers take, learned from those that came.

use crate::lss::Pace;
use crate::units::Micros;

/// What is known of the way there and back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rhythm {
    shortest: Micros,
    longest: Micros,
    /// From the first answer to a question to the last one, where several devices answer it.
    spread: Micros,
}

/// Added to the longest answer for the silence time-out: one turn of a slow main loop.
const MARGIN: Micros = Micros::from_ms(10);

impl Rhythm {
    pub(super) const fn new() -> Self {
        Self { shortest: Micros::MAX, longest: Micros(0), spread: Micros(0) }
    }

    /// A first answer took so long.
    pub(super) fn note(&mut self, round_trip: Micros) {
        self.shortest = self.shortest.min(round_trip);
        self.longest = self.longest.max(round_trip);
    }

    /// A further answer to the same question came so long behind the first.
    pub(super) fn note_further(&mut self, behind: Micros) {
        self.spread = self.spread.max(behind);
    }

    /// Whether an answer comes sooner than any device could have given it.
    pub(super) fn is_too_early(&self, round_trip: Micros) -> bool {
        self.longest > Micros(0) && round_trip.0 < self.shortest.0 / 2
    }

    pub(super) const fn longest(&self) -> Micros {
        self.longest
    }

    /// How long without an answer is silence.
    pub(super) fn silence(&self, pace: &Pace) -> Micros {
        let usual = Micros(self.longest.0.saturating_add(self.longest.0 / 2)) + MARGIN;
        usual.min(pace.answer_timeout)
    }

    /// How long to wait for further answers; nothing where one device answers, or all at once.
    pub(super) const fn settle(&self) -> Micros {
        Micros(self.spread.0.saturating_add(self.spread.0 / 4))
    }
}
