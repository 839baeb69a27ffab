//! A burst of errors is over: what it says.

use super::super::Decision;
use crate::detect::scan::burst::Burst;
use crate::detect::scan::likelihood::{error_bits, explain};
use crate::detect::scan::machine::{Scan, Step};
use crate::detect::scan::track::BIT;

/// What other rates can say against one, at most.
const LEAST_HINT: i32 = -14 * BIT;
/// Further bursts of errors after which a rate with one good frame is left.
const DOUBTS: u32 = 3;

impl<const N: usize> Scan<N> {
    /// A burst is over.
    #[inline(never)]
    pub(super) fn conclude(&mut self, step: &mut Step, burst: Burst) -> Decision {
        step.burst = None;
        let Some(listened_at) = self.rate(step.at) else { return Decision::Leave };
        let against = error_bits(self.settings.destroyed);
        for (at, candidate) in self.candidates.as_slice().iter().enumerate() {
            let Some(track) = self.tracks.get_mut(at) else { continue };
            if at == step.at {
                track.errors = track.errors.saturating_add(1);
                track.in_arbitration =
                    track.in_arbitration.saturating_add(u32::from(burst.in_arbitration));
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
    pub(super) fn level_hints(&mut self) {
        let best = self.usable().filter_map(|at| Some(self.tracks.get(at)?.hint)).max();
        for track in &mut self.tracks {
            track.hint = (track.hint - best.unwrap_or(0)).clamp(LEAST_HINT, 0);
        }
    }
}
