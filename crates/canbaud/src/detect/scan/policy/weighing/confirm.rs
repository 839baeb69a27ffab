//! A good frame was received: when that is enough.

use super::super::Decision;
use super::{ERRORS_A_FRAME, GOOD_FRAME, LISTENED_A_FRAME};
use crate::detect::scan::machine::{Scan, Step};
use crate::detect::scan::track::{BIT, Track};
use crate::detect::scan::{Evidence, bounds};
use crate::units::Micros;

/// Faster than this against the bus, six bits of the receiver lie within one of the bus: no frame
/// can look good.
const NO_ACCIDENT: u32 = 6;
/// Bursts of errors after which a data rate is taken for wrong: one may be a destroyed frame.
const TRIED: u32 = 2;

impl<const N: usize> Scan<N> {
    /// The nominal rate is right. Whether the data rate is, only frames that switch to it tell.
    pub(super) fn settle(&mut self, step: &mut Step, now: Micros) -> Decision {
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

    /// Two different good frames, and not in so long a time that both may be accidents.
    pub(super) fn is_no_accident(&self, step: &Step, at: Micros) -> bool {
        let Some(track) = self.tracks.get(step.at) else { return false };
        let seldom = match self.telling() {
            Evidence::Errors | Evidence::Counter => track.errors / ERRORS_A_FRAME > track.frames,
            Evidence::FramesOnly => {
                let listened = track.listened + (at - step.since);
                listened > LISTENED_A_FRAME.times(track.frames.into())
            }
        };
        track.distinct > 1 && !seldom
    }

    /// The last error in this step.
    pub(super) fn quiet_since(&self, step: &Step) -> Micros {
        step.last_error.unwrap_or_default()
    }

    /// After one good frame: no error for so long confirms it. If it looked good by accident, the
    /// rest of what is a longer frame of a slower bus has shown an error by then.
    pub(super) fn confirmation(&self, step: &Step) -> Micros {
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
    pub(super) fn confirmed(&mut self, step: &mut Step, now: Micros) -> Decision {
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
}
