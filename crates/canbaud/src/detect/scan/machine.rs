//! The machine: it is told what was heard, and says what to do next.

use super::burst::Burst;
use super::policy::Decision;
use super::track::Track;
use super::{
    Candidate, Candidates, Capabilities, Configured, End, Evidence, FdSupport, Outcome, Policy,
    Settings, bounds,
};
use crate::units::Micros;

/// What a scan asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Set the controller to this and start to listen; then call [`Scan::handle_listening`], or
    /// [`Scan::handle_refused`] if the controller cannot.
    Listen(Candidate),
    /// Stop listening: there is an outcome.
    Stop,
}

/// Listening to one candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Step {
    /// Which.
    pub(super) at: usize,
    pub(super) since: Micros,
    pub(super) configured: Configured,
    /// The last good frame or error, or when listening began.
    pub(super) heard: Micros,
    /// How long before that nothing was heard.
    pub(super) pause: Micros,
    /// The first good frame since the last error; one at the ACK delimiter does not count as such.
    pub(super) good: Option<Micros>,
    /// Good frames in this step.
    pub(super) frames: u32,
    pub(super) burst: Option<Burst>,
    /// Edges since the last frame or error.
    pub(super) edges: u32,
    /// The first of them.
    pub(super) edges_since: Option<Micros>,
    /// The last error.
    pub(super) last_error: Option<Micros>,
    /// Bursts of errors after a good frame.
    pub(super) doubts: u32,
    /// A frame was destroyed at its ACK delimiter.
    pub(super) unacknowledged: bool,
    /// The nominal rate is proven; only the data rate is not.
    pub(super) awaits_switch: bool,
    pub(super) decision: Decision,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    Waiting,
    /// [`Action::Listen`] is to be told, or was told.
    Switching {
        to: usize,
        since: Micros,
        told: bool,
    },
    Listening(Step),
    Done {
        told: bool,
    },
}

/// What is known about the traffic, whatever its rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Traffic {
    /// The last sign of it.
    pub(super) last: Option<Micros>,
    /// How long it takes until something is heard, of late: about how far frames are apart.
    pub(super) pause: Micros,
    /// The controller has told an error or a counter that moved: it does tell.
    pub(super) tells: bool,
    /// It has told edges.
    pub(super) edges: bool,
    /// The controller has told an error in the arbitration field: it tells that apart.
    pub(super) tells_arbitration: bool,
}

/// A scan for the rate of a bus, in fixed memory.
///
/// The caller owns clock and controller. [`Driver`](super::Driver) does what stands here; a loop of
/// one's own looks like this:
///
/// ```
/// use canbaud::detect::scan::*;
/// use canbaud::units::{Bitrate, Micros};
/// let capabilities = Capabilities {
///     rates: RateChoice::Between(Bitrate::new(10_000).unwrap(), Bitrate::new(1_000_000).unwrap()),
///     evidence: Evidence::Errors,
///     fd: FdSupport::Classic,
///     reconfiguration: Micros(500),
///     latency: Micros(0),
/// };
/// let candidates = Candidates::<8>::canopen().unwrap();
/// let mut scan = Scan::new(&candidates, &capabilities, Settings::default());
/// // It begins with the fastest rate: there an error shows soonest.
/// let Some(Action::Listen(first)) = scan.poll(Micros(0)) else { panic!() };
/// assert_eq!(first.nominal.to_string(), "1M");
/// scan.handle_listening(Micros(400), Configured { nominal: first.nominal, data: None });
/// // Nothing to do before this, unless the controller has something to tell.
/// assert!(scan.deadline().unwrap() > Micros(400));
/// assert_eq!(scan.poll(Micros(500)), None);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan<const N: usize> {
    pub(super) candidates: Candidates<N>,
    pub(super) tracks: [Track; N],
    pub(super) settings: Settings,
    pub(super) evidence: Evidence,
    pub(super) fd: FdSupport,
    pub(super) latency: Micros,
    /// The longest it may take, then the longest it took.
    pub(super) reconfiguration: Micros,
    pub(super) bound: Option<Micros>,
    pub(super) state: State,
    /// The candidate that was last told.
    pub(super) last_at: Option<usize>,
    pub(super) started: Micros,
    pub(super) visits: u32,
    pub(super) traffic: Traffic,
    /// The receive error counter as it was last told.
    pub(super) counter: Option<u16>,
    /// Told since listening began.
    pub(super) counter_is_fresh: bool,
    pub(super) outcome: Option<Outcome>,
}

impl<const N: usize> Scan<N> {
    /// A scan over those of `candidates` that the controller can be set to.
    #[must_use]
    pub fn new(
        candidates: &Candidates<N>,
        capabilities: &Capabilities<'_>,
        settings: Settings,
    ) -> Self {
        let candidates = candidates.within(&capabilities.rates);
        let mut scan = Self {
            bound: bounds::total(candidates.as_slice(), capabilities, &settings),
            candidates,
            tracks: [Track::default(); N],
            settings,
            evidence: capabilities.evidence,
            fd: capabilities.fd,
            latency: capabilities.latency,
            reconfiguration: capabilities.reconfiguration,
            state: State::Waiting,
            last_at: None,
            started: Micros(0),
            visits: 0,
            traffic: Traffic::default(),
            counter: None,
            counter_is_fresh: false,
            outcome: None,
        };
        scan.weigh_prior();
        scan
    }

    /// From the first poll to an outcome, at most, if it is polled at its deadlines and
    /// reconfiguration and latency are what the capabilities say; `None` if there is no such time.
    #[must_use]
    pub const fn bound(&self) -> Option<Micros> {
        match self.settings.end {
            End::AtBound => self.bound,
            End::Never => None,
        }
    }

    fn ends_at(&self) -> Micros {
        self.bound().map_or(Micros::MAX, |bound| self.started + bound)
    }

    /// The candidates that are tried, in the order of the list.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        self.candidates.as_slice()
    }

    /// What there is to say, once there is something.
    #[must_use]
    pub const fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// Whether the controller is to be listened to: set up, and no outcome yet.
    #[must_use]
    pub const fn listens(&self) -> bool {
        matches!(self.state, State::Listening(_))
    }

    /// When [`Self::poll`] has to be called at the latest, if nothing is heard before.
    #[must_use]
    pub fn deadline(&self) -> Option<Micros> {
        match &self.state {
            State::Waiting => Some(Micros(0)),
            State::Switching { told: true, .. } | State::Done { told: true } => None,
            State::Switching { told: false, .. } | State::Done { told: false } => Some(Micros(0)),
            State::Listening(step) => {
                let due = self.wake(step).min(self.ends_at());
                (due < Micros::MAX).then_some(due)
            }
        }
    }

    /// What to do now.
    pub fn poll(&mut self, now: Micros) -> Option<Action> {
        match self.state {
            State::Waiting => {
                self.started = now;
                self.go_on(now);
            }
            State::Switching { .. } | State::Done { .. } => {}
            State::Listening(mut step) => {
                let decision = match step.decision {
                    Decision::Stay if now >= self.ends_at() => Decision::GiveUp,
                    Decision::Stay => self.time(&mut step, now),
                    decided => decided,
                };
                self.state = State::Listening(step);
                self.decide(decision, step, now);
            }
        }
        self.tell()
    }

    fn decide(&mut self, decision: Decision, step: Step, now: Micros) {
        match decision {
            Decision::Stay => {}
            Decision::Leave => {
                self.finish_step(&step, now);
                self.go_on(now);
            }
            Decision::Announce => {
                self.finish_step(&step, now);
                self.end(self.found(&step, now));
            }
            Decision::GiveUp => {
                self.finish_step(&step, now);
                self.end(self.without_verdict());
            }
        }
    }

    /// The action that was not told yet.
    fn tell(&mut self) -> Option<Action> {
        match &mut self.state {
            State::Switching { to, told, .. } if !*told => {
                *told = true;
                self.last_at = Some(*to);
                self.candidates.as_slice().get(*to).map(|candidate| Action::Listen(*candidate))
            }
            State::Done { told } if !*told => {
                *told = true;
                Some(Action::Stop)
            }
            _ => None,
        }
    }

    /// To the next candidate, if there is one and time for it.
    fn go_on(&mut self, now: Micros) {
        let late = self.visits > 0 && now + self.reconfiguration >= self.ends_at();
        self.state = match self.next() {
            None if self.candidates_remain() => return self.end(self.without_verdict()),
            None => return self.end(Outcome::Refused),
            Some(_) if late || self.all_refuted() => return self.end(self.without_verdict()),
            Some(to) => State::Switching { to, since: now, told: false },
        };
    }

    /// Some were not refused; others may have been ruled out.
    fn candidates_remain(&self) -> bool {
        let count = self.candidates.as_slice().len();
        self.tracks.iter().take(count).any(|track| !track.refused)
    }

    #[inline(never)]
    fn end(&mut self, outcome: Outcome) {
        self.outcome = Some(outcome);
        self.state = State::Done { told: false };
    }

    /// The controller listens, set to what it says, since `now`.
    pub fn handle_listening(&mut self, now: Micros, configured: Configured) {
        let State::Switching { to, since, .. } = self.state else { return };
        self.visits = self.visits.saturating_add(1);
        self.reconfiguration = self.reconfiguration.max(now - since);
        if let Some(track) = self.tracks.get_mut(to) {
            track.visits = track.visits.saturating_add(1);
        }
        self.counter_is_fresh = false;
        self.state = State::Listening(Step {
            at: to,
            since: now,
            configured,
            heard: now,
            pause: Micros(0),
            good: None,
            frames: 0,
            burst: None,
            edges: 0,
            edges_since: None,
            last_error: None,
            doubts: 0,
            unacknowledged: false,
            awaits_switch: false,
            decision: Decision::Stay,
        });
    }

    /// The controller cannot be set to the candidate.
    pub fn handle_refused(&mut self, now: Micros) {
        let State::Switching { to, .. } = self.state else { return };
        if let Some(track) = self.tracks.get_mut(to) {
            track.refused = true;
        }
        self.go_on(now);
    }

    #[inline(never)]
    fn finish_step(&mut self, step: &Step, now: Micros) {
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.listened = track.listened + (now - step.since);
        }
    }

    pub(super) const fn policy(&self) -> Policy {
        self.settings.policy
    }
}
