//! The policies: one interface, one file each.

mod fixed_dwell;
mod koppe;
mod survey;
mod weighing;

use super::machine::{Scan, Step};
use super::track::Track;
use super::{ErrorClass, ErrorPlace, Policy, bounds};
use crate::units::{Bitrate, Micros};

/// What to do with the present step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Decision {
    /// Go on listening.
    Stay,
    /// To the next candidate.
    Leave,
    /// This is the rate.
    Announce,
    /// No verdict.
    GiveUp,
}

impl<const N: usize> Scan<N> {
    /// The candidate to listen to next; `None` if the controller can be set to none.
    pub(super) fn next(&self) -> Option<usize> {
        match self.policy() {
            Policy::Weighing => self.weighing_next(),
            Policy::Koppe => self.koppe_next(),
            Policy::FixedDwell => self.fixed_dwell_next(),
            Policy::Survey => self.survey_next(),
        }
    }

    /// A good frame was received.
    pub(super) fn frame(&mut self, step: &mut Step, at: Micros) -> Decision {
        match self.policy() {
            Policy::Weighing => self.weighing_frame(step, at),
            Policy::Koppe | Policy::FixedDwell => Decision::Announce,
            Policy::Survey => self.survey_frame(step),
        }
    }

    /// A protocol error was told.
    pub(super) fn error(
        &mut self,
        step: &mut Step,
        at: Micros,
        class: ErrorClass,
        place: ErrorPlace,
    ) -> Decision {
        match self.policy() {
            Policy::Weighing => self.weighing_error(step, at, class, place),
            Policy::Koppe => self.koppe_error(step),
            Policy::FixedDwell => Decision::Stay,
            Policy::Survey => self.survey_error(step),
        }
    }

    /// The receive error counter rose by `rise`, perhaps as far as it goes.
    pub(super) fn counted(
        &mut self,
        step: &mut Step,
        at: Micros,
        rise: u16,
        saturated: bool,
    ) -> Decision {
        match self.policy() {
            Policy::Weighing => self.weighing_counted(step, at, rise, saturated),
            Policy::Koppe => self.koppe_error(step),
            Policy::FixedDwell => Decision::Stay,
            Policy::Survey => self.survey_error(step),
        }
    }

    /// It is `now`, and nothing was heard.
    pub(super) fn time(&mut self, step: &mut Step, now: Micros) -> Decision {
        if now < self.wake(step) {
            return Decision::Stay;
        }
        match self.policy() {
            Policy::Weighing => self.weighing_time(step, now),
            Policy::Koppe => Decision::Stay,
            Policy::FixedDwell | Policy::Survey => Decision::Leave,
        }
    }

    /// When [`Self::time`] has something to do.
    pub(super) fn wake(&self, step: &Step) -> Micros {
        if step.decision != Decision::Stay {
            return Micros(0);
        }
        match self.policy() {
            Policy::Weighing => self.weighing_wake(step),
            Policy::Koppe => Micros::MAX,
            Policy::FixedDwell => step.since + self.settings.dwell,
            Policy::Survey => step.since + self.longest_step(step),
        }
    }

    /// How long a step may listen at most while nothing is heard.
    #[inline(never)]
    fn longest_step(&self, step: &Step) -> Micros {
        let own = self.candidates.as_slice().get(step.at);
        own.map_or(Micros(0), |own| bounds::patience(own, &self.settings))
    }

    /// Every candidate that can be had has met so many errors that it cannot be the rate.
    pub(super) fn all_refuted(&self) -> bool {
        self.policy() == Policy::Weighing && self.weighing_all_refuted()
    }

    /// The places of the candidates that may be the rate and that the controller has not refused.
    pub(super) fn usable(&self) -> impl Iterator<Item = usize> {
        (0..N).filter(|at| self.is_usable(*at))
    }

    // Of these there is one copy each: policies go over the candidates in twenty places.

    #[inline(never)]
    fn is_usable(&self, at: usize) -> bool {
        let usable = |track: &Track| !track.refused && !track.ruled_out;
        at < self.candidates.as_slice().len() && self.tracks.get(at).is_some_and(usable)
    }

    /// How likely a candidate is, as a logarithm.
    #[inline(never)]
    fn standing(&self, at: usize) -> i32 {
        self.tracks.get(at).map_or(i32::MIN, Track::standing)
    }

    /// The standing of the likeliest.
    #[inline(never)]
    fn best_standing(&self) -> Option<i32> {
        self.usable().map(|at| self.standing(at)).max()
    }

    #[inline(never)]
    fn rate(&self, at: usize) -> Option<Bitrate> {
        self.candidates.as_slice().get(at).map(|candidate| candidate.nominal)
    }
}
