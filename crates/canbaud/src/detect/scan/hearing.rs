//! What was heard, and whether it counts.

use super::machine::{Scan, State, Step};
use super::policy::Decision;
use super::{ErrorSeen, FrameSeen, Observation, Origin, bounds};
use crate::units::Micros;

/// A receive error counter goes no further, or not in a way that tells something.
const SATURATED: u16 = 120;

impl<const N: usize> Scan<N> {
    /// The controller has told this.
    pub fn handle(&mut self, now: Micros, observation: &Observation) {
        let State::Listening(mut step) = self.state else { return };
        if step.decision == Decision::Stay {
            step.decision = match observation {
                Observation::Frame(seen) => self.frame_seen(&mut step, now, seen),
                Observation::Error(seen) => self.error_seen(&mut step, now, seen),
                Observation::ReceiveErrors(count) => self.counter_seen(&mut step, now, *count),
                Observation::Edges(count) => self.edges_seen(&mut step, now, *count),
                Observation::Lost => Decision::Stay,
            };
            self.state = State::Listening(step);
        }
    }

    /// When it was heard, if that was since listening began: a time stamp says so, or that no
    /// observation is that long under way.
    fn since_listening(
        &self,
        step: &Step,
        now: Micros,
        received: Option<Micros>,
    ) -> Option<Micros> {
        match received {
            Some(at) => (at >= step.since).then_some(at.min(now)),
            None => (now >= step.since + self.latency).then_some(now),
        }
    }

    fn frame_seen(&mut self, step: &mut Step, now: Micros, seen: &FrameSeen) -> Decision {
        let at = self.since_listening(step, now, seen.received);
        let soonest = step.since + Micros::of_bits(bounds::FIRST_FRAME, step.configured.nominal);
        let Some(at) = at.filter(|at| *at >= soonest && seen.origin == Origin::Bus) else {
            return Decision::Stay;
        };
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.note_frame(&seen.frame);
        }
        step.frames = step.frames.saturating_add(1);
        self.sign_of_traffic(step, at);
        self.frame(step, at)
    }

    fn error_seen(&mut self, step: &mut Step, now: Micros, seen: &ErrorSeen) -> Decision {
        self.traffic.tells = true;
        let Some(at) = self.since_listening(step, now, seen.received) else {
            return Decision::Stay;
        };
        step.last_error = Some(at);
        self.sign_of_traffic(step, at);
        self.error(step, at, seen.class, seen.place)
    }

    fn counter_seen(&mut self, step: &mut Step, now: Micros, count: u16) -> Decision {
        // A counter that is lower than before was reset by the switch, and counts from 0.
        let before = match self.counter {
            Some(before) if self.counter_is_fresh || count >= before => before,
            Some(_) => 0,
            None => count,
        };
        let stale = !self.counter_is_fresh && count > before && before > 0;
        self.counter = Some(count);
        self.counter_is_fresh = true;
        if count <= before || stale {
            return Decision::Stay;
        }
        self.traffic.tells = true;
        step.last_error = Some(now);
        self.sign_of_traffic(step, now);
        self.counted(step, now, count - before, count >= SATURATED)
    }

    fn edges_seen(&mut self, step: &mut Step, now: Micros, count: u32) -> Decision {
        if count > 0 && now >= step.since + self.latency {
            step.edges = step.edges.saturating_add(count);
            step.edges_since = step.edges_since.or(Some(now));
            self.traffic.last = Some(now);
            self.traffic.edges = true;
        }
        Decision::Stay
    }

    fn sign_of_traffic(&mut self, step: &mut Step, at: Micros) {
        step.pause = at - step.heard;
        if step.heard == step.since {
            let known = if self.traffic.last.is_some() { self.traffic.pause } else { step.pause };
            self.traffic.pause = Micros((known + step.pause).0 / 2);
        }
        self.traffic.last = Some(at);
        step.heard = step.heard.max(at);
        (step.edges, step.edges_since) = (0, None);
    }
}
