//! Nothing is heard: how long that is waited for, and what it says.

use super::super::Decision;
use crate::detect::scan::likelihood::error_bits;
use crate::detect::scan::machine::{Scan, Step};
use crate::detect::scan::track::BIT;
use crate::detect::scan::{Evidence, bounds};
use crate::units::{Bitrate, Micros};

/// Edges that may be a disturbance.
const FEW_EDGES: u32 = 20;
/// Slower than this against the bus, a receiver may hear nothing at all on a loaded bus.
const DEAF: u32 = 3;
/// Whether a receiver may hear nothing at all of a loaded bus.
const fn is_deaf(receiver: Bitrate, bus: Bitrate) -> bool {
    bus.bits_per_second() / DEAF >= receiver.bits_per_second()
}

impl<const N: usize> Scan<N> {
    /// When edges in which nothing could be read are proof that the receiver is too slow: the next
    /// frame would have ended.
    pub(super) fn stalled_at(step: &Step) -> Micros {
        let frames = Micros::of_bits(2 * bounds::LONGEST_FRAME, step.configured.nominal);
        match step.edges_since {
            Some(since) if step.edges > FEW_EDGES => since + frames,
            _ => Micros::MAX,
        }
    }

    /// How long nothing may be heard before another candidate is listened to.
    pub(super) fn patience(&self, step: &Step) -> Micros {
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
                (frames + self.usual_pause() + self.reconfiguration).min(most)
            }
            Evidence::Errors | Evidence::Counter => most,
        }
    }

    /// A pause that would be no surprise: as long as all of the scan up to the last sign of traffic,
    /// or eight times the usual one.
    fn usual_pause(&self) -> Micros {
        let until_last = self.traffic.last.map_or(Micros(0), |last| last - self.started);
        self.traffic.pause.times(8).max(until_last)
    }

    fn may_be_deaf_at(&self, at: usize) -> bool {
        self.rate(at).is_some_and(|rate| self.may_be_deaf(rate))
    }

    /// A candidate in question is so much faster that a receiver at `rate` may hear nothing of it.
    pub(super) fn may_be_deaf(&self, rate: Bitrate) -> bool {
        let faster = |at: usize| self.rate(at).is_some_and(|other| is_deaf(rate, other));
        self.in_question().any(faster)
    }

    /// Nothing was heard for that long.
    #[inline(never)]
    pub(super) fn silence(&mut self, step: &mut Step, now: Micros) -> Decision {
        let stalled = step.edges > FEW_EDGES;
        let known = self.traffic.tells && self.traffic.last.is_some();
        let stalled = stalled || (known && self.may_be_deaf_at(step.at));
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
}
