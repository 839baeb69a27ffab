//! The default: what is heard at one candidate is evidence for and against all of them.

mod conclude;
mod confirm;
mod silence;

use super::Decision;
use crate::detect::scan::burst::Burst;
use crate::detect::scan::likelihood::{error_bits, log2};
use crate::detect::scan::machine::{Scan, Step};
use crate::detect::scan::track::BIT;
use crate::detect::scan::{ErrorClass, ErrorPlace, Evidence, bounds};
use crate::units::{Bitrate, Micros};

/// What the last known rate is worth: four scans in five, among eight candidates.
const LAST_KNOWN: i32 = 5 * BIT;
/// What a good frame is worth: a wrong rate makes one of a million frames look good.
const GOOD_FRAME: i32 = 20 * BIT;
/// Destroyed frames that would have to be an accident at the right rate: together 2^-24.
const REFUTED: i32 = 24 * BIT;
/// Errors after which a burst says nothing new.
const ENOUGH: u32 = 16;
/// The same where they are as far apart as frames.
const ENOUGH_SPARSE: u32 = 6;
/// Frames destroyed at their ACK delimiter that are waited out: a lone sender is error passive
/// after 16 of them, and its frames are good from then on.
const UNACKNOWLEDGED: u32 = 40;
/// A candidate that much less likely than the best is out of the question, for now.
const IN_QUESTION: i32 = 12 * BIT;
/// Two frames that look good by accident come among a million that do not: more errors than this
/// for each good frame, and only a quiet time confirms it.
const ERRORS_A_FRAME: u32 = 256;
/// The same where errors are not told: on the busiest bus an accident takes two minutes.
const LISTENED_A_FRAME: Micros = Micros::from_ms(30_000);
/// The first time that a controller which tells no errors listens to a candidate.
const FIRST_LOOK: Micros = Micros::from_ms(60);

impl<const N: usize> Scan<N> {
    pub(in super::super::super) fn weigh_prior(&mut self) {
        for (candidate, track) in self.candidates.as_slice().iter().zip(&mut self.tracks) {
            if self.settings.last_known == Some(candidate.nominal) {
                track.weight = LAST_KNOWN;
            }
        }
    }

    /// What the controller tells: nothing, if it had nothing to tell during a whole step and never
    /// told an error. Some that promise to do not.
    #[inline(never)]
    fn telling(&self) -> Evidence {
        let mute = !self.traffic.tells && self.tracks.iter().any(|track| track.silences > 0);
        if mute { Evidence::FramesOnly } else { self.evidence }
    }

    /// The one with the best chance for the time that it takes. Of many that are as good as each
    /// other, the middle one: errors there say whether the bus is slower or faster.
    pub(super) fn weighing_next(&self) -> Option<usize> {
        self.middle_of_the_best().or_else(|| self.best_for_its_time())
    }

    fn middle_of_the_best(&self) -> Option<usize> {
        if self.telling() == Evidence::FramesOnly || !self.traffic.tells {
            return None;
        }
        let least = self.best_standing()?.saturating_sub(BIT);
        let equal = || self.usable().filter(|at| self.standing(*at) > least);
        let count = equal().count();
        if count < 3 {
            return None;
        }
        let faster = |at: &usize| {
            equal().filter(|other| (self.rate(*other), *other) > (self.rate(*at), *at)).count()
        };
        equal().find(|at| faster(at) == count / 2)
    }

    fn best_for_its_time(&self) -> Option<usize> {
        let score = |at: usize| {
            let rate = self.rate(at)?;
            let listening = Micros::of_bits(2 * bounds::LONGEST_FRAME, rate) + self.first_look(at);
            Some((self.standing(at) - log2((self.reconfiguration + listening).0), rate, at))
        };
        let best = self.usable().filter_map(score);
        best.max_by_key(|(score, rate, at)| (*score, *rate, usize::MAX - at)).map(|(.., at)| at)
    }

    /// How long a controller that tells no errors listens to a candidate: twice as long each time.
    fn first_look(&self, at: usize) -> Micros {
        match self.telling() {
            Evidence::Errors | Evidence::Counter => Micros(0),
            Evidence::FramesOnly => {
                let silences = self.tracks.get(at).map_or(0, |track| track.silences).min(16);
                FIRST_LOOK.max(self.reconfiguration).times(1 << silences)
            }
        }
    }

    pub(super) fn weighing_frame(&mut self, step: &mut Step, at: Micros) -> Decision {
        let Some(track) = self.tracks.get_mut(step.at) else { return Decision::Leave };
        if step.burst.take().is_some() {
            track.errors = track.errors.saturating_add(1);
        }
        if track.frames == 1 {
            track.weight = track.weight.saturating_add(GOOD_FRAME);
        }
        if self.is_no_accident(step, at) {
            return self.settle(step, at);
        }
        step.good = step.good.or(Some(at));
        Decision::Stay
    }

    pub(super) fn weighing_error(
        &mut self,
        step: &mut Step,
        at: Micros,
        class: ErrorClass,
        place: ErrorPlace,
    ) -> Decision {
        let at_delimiter = place == ErrorPlace::AckDelimiter && class != ErrorClass::Crc;
        if at_delimiter && step.burst.is_none() {
            return self.unacknowledged(step);
        }
        let burst = Self::hear_error(step, at);
        burst.in_arbitration |= place == ErrorPlace::Arbitration;
        self.traffic.tells_arbitration |= place == ErrorPlace::Arbitration;
        self.after_error(step)
    }

    pub(super) fn weighing_counted(
        &mut self,
        step: &mut Step,
        at: Micros,
        rise: u16,
        saturated: bool,
    ) -> Decision {
        let burst = Self::hear_error(step, at);
        // An error counts 1, and 8 more if the bus is still dominant behind the flag.
        burst.count = burst.count.saturating_add(u32::from(rise / 9));
        burst.closest = Micros(0);
        burst.counted = true;
        burst.saturated = saturated;
        self.after_error(step)
    }

    fn hear_error(step: &mut Step, at: Micros) -> &mut Burst {
        // So soon behind a good frame, it may be the rest of what only began like one.
        step.good = None;
        match &mut step.burst {
            Some(burst) => {
                burst.add(at);
                burst
            }
            none => none.insert(Burst::new(at, step.pause)),
        }
    }

    fn after_error(&mut self, step: &mut Step) -> Decision {
        match step.burst {
            Some(burst) if burst.count >= ENOUGH => self.conclude(step, burst),
            Some(burst) if burst.count >= ENOUGH_SPARSE && self.is_one_a_frame(step, &burst) => {
                self.conclude(step, burst)
            }
            _ => Decision::Stay,
        }
    }

    /// Errors as far apart as frames, and no candidate is so slow that its bits could be.
    fn is_one_a_frame(&self, step: &Step, burst: &Burst) -> bool {
        let rate = step.configured.nominal;
        let slow = self.slowest().map_or(0, Bitrate::bits_per_second);
        burst.is_sparse(rate) && rate.bits_per_second() / 8 < slow
    }

    /// A frame that was good up to its ACK delimiter.
    fn unacknowledged(&mut self, step: &mut Step) -> Decision {
        let Some(track) = self.tracks.get_mut(step.at) else { return Decision::Leave };
        track.unacknowledged = track.unacknowledged.saturating_add(1);
        step.unacknowledged = true;
        if track.unacknowledged.is_multiple_of(UNACKNOWLEDGED) {
            track.weight = track.weight.saturating_sub(2 * BIT);
            return self.stay_or_leave(step.at);
        }
        Decision::Stay
    }

    pub(super) fn weighing_wake(&self, step: &Step) -> Micros {
        if let Some(burst) = &step.burst {
            return (burst.last + self.hush(step, burst)).min(burst.first + self.longest_burst());
        }
        if step.awaits_switch {
            return step.since + self.longest_step(step);
        }
        match step.good {
            Some(good) => good.max(self.quiet_since(step)) + self.confirmation(step),
            None => (step.heard + self.patience(step)).min(Self::stalled_at(step)),
        }
    }

    pub(super) fn weighing_time(&mut self, step: &mut Step, now: Micros) -> Decision {
        if let Some(burst) = step.burst {
            return self.conclude(step, burst);
        }
        match step.good {
            Some(_) => self.confirmed(step, now),
            None => self.silence(step, now),
        }
    }

    /// The candidates that are not out of the question.
    fn in_question(&self) -> impl Iterator<Item = usize> {
        let least = self.best_standing().unwrap_or(0).saturating_sub(IN_QUESTION);
        self.usable().filter(move |at| self.standing(*at) > least)
    }

    fn slowest(&self) -> Option<Bitrate> {
        self.in_question().filter_map(|at| self.rate(at)).min()
    }

    /// No error for so long ends a burst: no frame has a longer pause between two of its errors,
    /// and one that is sent again would have come.
    fn hush(&self, step: &Step, burst: &Burst) -> Micros {
        let within = self.slowest().map_or(Micros(0), |rate| Micros::of_bits(24, rate));
        if burst.count >= 4 && burst.is_faithful(step.configured.nominal) {
            return within.min(burst.spacing().times(6));
        }
        if burst.count > 1 {
            return within;
        }
        within.max(Micros::of_bits(bounds::RETRANSMISSION, step.configured.nominal))
    }

    fn longest_burst(&self) -> Micros {
        self.slowest().map_or(Micros(0), |rate| Micros::of_bits(bounds::LONGEST_FRAME, rate))
    }

    #[inline(never)]
    fn stay_or_leave(&self, at: usize) -> Decision {
        if self.weighing_next() == Some(at) && !self.weighing_all_refuted() {
            Decision::Stay
        } else {
            Decision::Leave
        }
    }

    pub(super) fn weighing_all_refuted(&self) -> bool {
        let against = error_bits(self.settings.destroyed);
        let refuted = |at: usize| {
            self.tracks.get(at).is_some_and(|track| {
                let errors = i32::try_from(track.errors).unwrap_or(i32::MAX);
                track.frames == 0
                    && track.unacknowledged == 0
                    && errors.saturating_mul(against) >= REFUTED
            })
        };
        self.usable().all(refuted)
    }
}
