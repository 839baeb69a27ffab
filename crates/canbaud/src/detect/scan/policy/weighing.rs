//! The default: what is heard at one candidate is evidence for and against all of them.

use super::Decision;
use crate::detect::scan::burst::Burst;
use crate::detect::scan::likelihood::{error_bits, explain, log2};
use crate::detect::scan::machine::{Scan, Step};
use crate::detect::scan::track::{BIT, Track};
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
/// Further bursts of errors after which a rate with one good frame is left.
const DOUBTS: u32 = 3;
/// A candidate that much less likely than the best is out of the question, for now.
const IN_QUESTION: i32 = 12 * BIT;
/// What other rates can say against one, at most.
const LEAST_HINT: i32 = -14 * BIT;
/// Bursts of errors after which a data rate is taken for wrong: one may be a destroyed frame.
const TRIED: u32 = 2;
/// Slower than this against the bus, a receiver may hear nothing at all on a loaded bus.
const DEAF: u32 = 4;
/// Faster than this against the bus, six bits of the receiver lie within one of the bus: no frame
/// can look good.
const NO_ACCIDENT: u32 = 6;
/// Edges that may be a disturbance.
const FEW_EDGES: u32 = 20;
/// The first time that a controller which tells no errors listens to a candidate.
const FIRST_LOOK: Micros = Micros::from_ms(20);

/// Whether a receiver may hear nothing at all of a loaded bus.
const fn is_deaf(receiver: Bitrate, bus: Bitrate) -> bool {
    bus.bits_per_second() / DEAF >= receiver.bits_per_second()
}

impl<const N: usize> Scan<N> {
    pub(in super::super) fn weigh_prior(&mut self) {
        for (candidate, track) in self.candidates.as_slice().iter().zip(&mut self.tracks) {
            if self.settings.last_known == Some(candidate.nominal) {
                track.weight = LAST_KNOWN;
            }
        }
    }

    /// What the controller tells: nothing, if it had nothing to tell during a whole step and never
    /// told an error. Some that promise to do not.
    fn telling(&self) -> Evidence {
        let mute = !self.traffic.tells && self.tracks.iter().any(|track| track.silences > 0);
        if mute { Evidence::FramesOnly } else { self.evidence }
    }

    fn rate(&self, at: usize) -> Option<Bitrate> {
        self.candidates.as_slice().get(at).map(|candidate| candidate.nominal)
    }

    /// The one with the best chance for the time that it takes.
    pub(super) fn weighing_next(&self) -> Option<usize> {
        let score = |at: usize| {
            let rate = self.rate(at)?;
            let listening = Micros::of_bits(2 * bounds::LONGEST_FRAME, rate) + self.first_look(at);
            let weight = self.tracks.get(at)?.standing();
            Some((weight - log2((self.reconfiguration + listening).0), rate, at))
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
        step.good = step.good.or(Some(at));
        if track.distinct > 1 { self.settle(step, at) } else { Decision::Stay }
    }

    /// The nominal rate is right. Whether the data rate is, only frames that switch to it tell.
    fn settle(&mut self, step: &mut Step, now: Micros) -> Decision {
        let all = self.candidates.as_slice();
        let (Some(own), Some(track)) = (all.get(step.at), self.tracks.get(step.at)) else {
            return Decision::Leave;
        };
        let tried = |track: &Track| track.errors >= TRIED;
        let sibling = |at: usize| {
            let same = all.get(at).is_some_and(|other| other.nominal == own.nominal);
            same && at != step.at && self.tracks.get(at).is_some_and(|track| !tried(track))
        };
        if own.data.is_none() || track.switched || !self.usable().any(sibling) {
            return Decision::Announce;
        }
        if !tried(track) {
            let until = step.since + self.longest_step(step);
            step.awaits_switch = now < until;
            return if now < until { Decision::Stay } else { Decision::Announce };
        }
        let nominal = own.nominal;
        for (candidate, track) in all.iter().zip(&mut self.tracks) {
            track.ruled_out |= candidate.nominal != nominal;
            track.weight = track.weight.min(0);
        }
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.weight = -GOOD_FRAME;
        }
        Decision::Leave
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

    pub(super) fn weighing_counted(&mut self, step: &mut Step, at: Micros, rise: u16) -> Decision {
        let burst = Self::hear_error(step, at);
        // An error counts 1, and 8 more if the bus is still dominant behind the flag.
        burst.count = burst.count.saturating_add(u32::from(rise / 9));
        burst.closest = Micros(0);
        burst.counted = true;
        self.after_error(step)
    }

    /// When edges in which nothing could be read are proof that the receiver is too slow: the next
    /// frame would have ended.
    fn stalled_at(step: &Step) -> Micros {
        let frames = Micros::of_bits(2 * bounds::LONGEST_FRAME, step.configured.nominal);
        match step.edges_since {
            Some(since) if step.edges > FEW_EDGES => since + frames,
            _ => Micros::MAX,
        }
    }

    fn hear_error(step: &mut Step, at: Micros) -> &mut Burst {
        match &mut step.burst {
            Some(burst) => {
                burst.add(at);
                burst
            }
            none => none.insert(Burst::new(at)),
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
        let standing = |at: usize| self.tracks.get(at).map_or(i32::MIN, |track| track.standing());
        let best = self.usable().map(standing).max().unwrap_or(0);
        self.usable().filter(move |at| standing(*at) > best.saturating_sub(IN_QUESTION))
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

    /// A burst is over.
    fn conclude(&mut self, step: &mut Step, burst: Burst) -> Decision {
        step.burst = None;
        let Some(listened_at) = self.rate(step.at) else { return Decision::Leave };
        let against = error_bits(self.settings.destroyed);
        for (at, candidate) in self.candidates.as_slice().iter().enumerate() {
            let Some(track) = self.tracks.get_mut(at) else { continue };
            if at == step.at {
                track.errors = track.errors.saturating_add(1);
                track.in_arbitration += u32::from(burst.in_arbitration);
                let times = if burst.count > 1 { 2 } else { 1 };
                track.weight = track.weight.saturating_sub(times * against);
            } else if step.frames == 0 {
                track.hint += explain(&burst, listened_at, candidate.nominal, self.latency);
            }
        }
        self.level_hints();
        if step.awaits_switch {
            return self.settle(step, burst.last);
        }
        if step.frames > 0 && step.doubts < DOUBTS {
            step.doubts += 1;
            return Decision::Stay;
        }
        self.stay_or_leave(step.at)
    }

    /// The best hint is 0 and none goes below the least: a rate that was never listened to is
    /// never lost to hints.
    fn level_hints(&mut self) {
        let best = self.usable().filter_map(|at| Some(self.tracks.get(at)?.hint)).max();
        for track in &mut self.tracks {
            track.hint = (track.hint - best.unwrap_or(0)).clamp(LEAST_HINT, 0);
        }
    }

    fn stay_or_leave(&self, at: usize) -> Decision {
        if self.weighing_next() == Some(at) && !self.weighing_all_refuted() {
            Decision::Stay
        } else {
            Decision::Leave
        }
    }

    /// How long nothing may be heard before another candidate is listened to.
    fn patience(&self, step: &Step) -> Micros {
        let Some(candidate) = self.candidates.as_slice().get(step.at) else { return Micros(0) };
        let most = self.longest_step(step);
        if step.unacknowledged {
            return Micros::of_bits(2 * bounds::RETRANSMISSION, candidate.nominal).min(most);
        }
        let frames = Micros::of_bits(2 * bounds::LONGEST_FRAME, candidate.nominal);
        match self.telling() {
            Evidence::FramesOnly => (frames + self.first_look(step.at)).min(most),
            Evidence::Errors | Evidence::Counter
                if self.traffic.last.is_some() && self.may_be_deaf(candidate.nominal) =>
            {
                (frames + self.traffic.pause.times(8) + self.reconfiguration).min(most)
            }
            Evidence::Errors | Evidence::Counter => most,
        }
    }

    /// A candidate in question is so much faster that a receiver at `rate` may hear nothing of it.
    fn may_be_deaf(&self, rate: Bitrate) -> bool {
        let faster = |at: usize| self.rate(at).is_some_and(|other| is_deaf(rate, other));
        self.in_question().any(faster)
    }

    /// Nothing was heard for that long.
    fn silence(&mut self, step: &mut Step, now: Micros) -> Decision {
        let stalled = step.edges > FEW_EDGES;
        let known = self.traffic.tells && self.traffic.last.is_some();
        let Some(listened_at) = self.rate(step.at) else { return Decision::Leave };
        let against = error_bits(self.settings.destroyed);
        for (at, candidate) in self.candidates.as_slice().iter().enumerate() {
            let Some(track) = self.tracks.get_mut(at) else { continue };
            let much_faster =
                candidate.nominal.bits_per_second() / DEAF >= listened_at.bits_per_second();
            if at == step.at {
                track.silences = track.silences.saturating_add(1);
                let bits = if stalled { against } else { BIT };
                track.weight = track.weight.saturating_sub(bits);
            } else if much_faster && (known || stalled) {
                track.hint += BIT;
            }
        }
        self.level_hints();
        step.heard = now;
        (step.edges, step.edges_since) = (0, None);
        self.stay_or_leave(step.at)
    }

    /// The last error in this step.
    fn quiet_since(&self, step: &Step) -> Micros {
        step.last_error.unwrap_or_default()
    }

    /// After one good frame: no error for so long confirms it. If it looked good by accident, the
    /// rest of what is a longer frame of a slower bus has shown an error by then.
    fn confirmation(&self, step: &Step) -> Micros {
        let rate = step.configured.nominal;
        let slower = |at: usize| {
            self.rate(at).filter(|other| {
                *other <= rate && other.bits_per_second() >= rate.bits_per_second() / NO_ACCIDENT
            })
        };
        let slowest = self.usable().filter_map(slower).min().unwrap_or(rate);
        match self.telling() {
            Evidence::Errors | Evidence::Counter => {
                Micros::of_bits(bounds::LONGEST_FRAME, slowest) + self.latency
            }
            Evidence::FramesOnly => self.settings.pause,
        }
    }

    /// One good frame, perhaps several times, and no error since.
    fn confirmed(&mut self, step: &mut Step, now: Micros) -> Decision {
        let alone = step.frames < 3;
        match self.telling() {
            // On a busy bus, that is how an accident looks.
            Evidence::FramesOnly if alone => {
                step.good = None;
                if let Some(track) = self.tracks.get_mut(step.at) {
                    track.weight = track.weight.min(2 * BIT);
                }
                self.silence(step, now)
            }
            Evidence::Errors | Evidence::Counter | Evidence::FramesOnly => self.settle(step, now),
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
