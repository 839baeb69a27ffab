//! The machine: it is told what was heard, and says what to do next.

use super::burst::Burst;
use super::policy::Decision;
use super::track::Track;
use super::{
    Acknowledgement, Activity, Candidate, Candidates, Capabilities, Configured, End, ErrorSeen,
    Evidence, FdSeen, FdSupport, Found, FrameSeen, Misfit, Observation, Origin, Outcome, Policy,
    Settings, Standing, Status, bounds,
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
    /// The last good frame or error at the ACK delimiter.
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
enum State {
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
    /// The longest time listened without a sign of it, once there was one: about how far frames
    /// are apart.
    pub(super) pause: Micros,
    /// The controller has told an error or a counter that moved: it does tell.
    pub(super) tells: bool,
    /// The controller has told an error in the arbitration field: it tells that apart.
    pub(super) tells_arbitration: bool,
}

/// How far the bus may be from the middle of the rates that could be read, in thousandths.
const SURVEYED_PERMILLE: u16 = 17;

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
    fd: FdSupport,
    pub(super) latency: Micros,
    /// The longest it may take, then the longest it took.
    pub(super) reconfiguration: Micros,
    pub(super) bound: Option<Micros>,
    state: State,
    /// The candidate that was last told.
    pub(super) last_at: Option<usize>,
    pub(super) started: Micros,
    pub(super) visits: u32,
    pub(super) traffic: Traffic,
    /// The receive error counter as it was last told.
    counter: Option<u16>,
    /// Told since listening began.
    counter_is_fresh: bool,
    outcome: Option<Outcome>,
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
            None if self.traffic.last.is_some() => return self.end(self.without_verdict()),
            None => return self.end(Outcome::Refused),
            Some(_) if late || self.all_refuted() => return self.end(self.without_verdict()),
            Some(to) => State::Switching { to, since: now, told: false },
        };
    }

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
        self.counted(step, now, count - before)
    }

    fn edges_seen(&mut self, step: &mut Step, now: Micros, count: u32) -> Decision {
        if count > 0 && now >= step.since + self.latency {
            step.edges = step.edges.saturating_add(count);
            step.edges_since = step.edges_since.or(Some(now));
            self.traffic.last = Some(now);
        }
        Decision::Stay
    }

    fn sign_of_traffic(&mut self, step: &mut Step, at: Micros) {
        self.traffic.pause = self.traffic.pause.max(at - step.heard);
        self.traffic.last = Some(at);
        step.heard = step.heard.max(at);
        (step.edges, step.edges_since) = (0, None);
    }

    fn finish_step(&mut self, step: &Step, now: Micros) {
        if let Some(track) = self.tracks.get_mut(step.at) {
            track.listened = track.listened + (now - step.since);
        }
    }

    fn found(&self, step: &Step, now: Micros) -> Outcome {
        let track = self.tracks.get(step.at).copied().unwrap_or_default();
        let candidate = self.candidates.as_slice().get(step.at).copied();
        let suspected = self.fd == FdSupport::Classic && track.errors > 1;
        let fd = match (track.fd, track.switched) {
            (true, true) => FdSeen::Switched,
            (true, false) => FdSeen::NeverSwitched,
            (false, _) if suspected && track.in_arbitration == 0 => FdSeen::Suspected,
            (false, _) => FdSeen::No,
        };
        let reach_permille = match self.settings.policy {
            Policy::Survey => SURVEYED_PERMILLE,
            _ => candidate.map_or(0, |candidate| candidate.capture.reach_permille()),
        };
        Outcome::Found(Found {
            reach_permille,
            candidate: candidate.unwrap_or(Candidate::classic(step.configured.nominal)),
            configured: step.configured,
            frames: track.frames,
            distinct: track.distinct,
            errors: track.errors,
            elapsed: now - self.started,
            visits: self.visits,
            acknowledgement: if track.unacknowledged > 0 {
                Acknowledgement::Missing
            } else {
                Acknowledgement::Presumed
            },
            fd,
        })
    }

    fn without_verdict(&self) -> Outcome {
        if self.traffic.last.is_some() {
            return Outcome::NoCandidateFits(Misfit { perhaps_fd: self.perhaps_fd() });
        }
        match self.evidence {
            Evidence::Errors => Outcome::Silent,
            // A counter that never moved may be a frozen one.
            Evidence::Counter | Evidence::FramesOnly => Outcome::StillOpen,
        }
    }

    fn perhaps_fd(&self) -> Option<Candidate> {
        if self.fd == FdSupport::Fd || !self.traffic.tells_arbitration {
            return None;
        }
        let past = |track: &Track| track.errors >= 4 && track.in_arbitration == 0;
        let mut all = self.candidates.as_slice().iter().zip(&self.tracks).filter(|(_, t)| past(t));
        match (all.next(), all.next()) {
            (Some((candidate, _)), None) => Some(*candidate),
            _ => None,
        }
    }

    /// Where the scan is.
    #[must_use]
    pub fn status(&self, now: Micros) -> Status {
        let candidate = |at: usize| self.candidates.as_slice().get(at).copied();
        let activity = match &self.state {
            State::Waiting => Some(Activity::Waiting),
            State::Switching { to, .. } => candidate(*to).map(Activity::Switching),
            State::Listening(step) if step.frames > 0 => {
                candidate(step.at).map(Activity::Confirming)
            }
            State::Listening(step) => candidate(step.at).map(Activity::Listening),
            State::Done { .. } => Some(Activity::Done),
        };
        let elapsed = match self.state {
            State::Waiting => Micros(0),
            _ => now - self.started,
        };
        Status {
            activity: activity.unwrap_or(Activity::Done),
            elapsed,
            left: self.bound().map(|bound| bound - elapsed),
            visits: self.visits,
        }
    }

    /// What speaks for and against each candidate, in the order of the list.
    pub fn standings(&self) -> impl Iterator<Item = Standing> {
        let lowest = self.tracks.iter().take(self.candidates.as_slice().len());
        let lowest = lowest.map(|track| track.standing()).min().unwrap_or(0);
        self.candidates.as_slice().iter().zip(&self.tracks).map(move |(candidate, track)| {
            Standing {
                candidate: *candidate,
                refused: track.refused,
                visits: track.visits,
                listened: track.listened,
                frames: track.frames,
                distinct: track.distinct,
                errors: track.errors,
                unacknowledged: track.unacknowledged,
                weight: track.standing().abs_diff(lowest),
            }
        })
    }

    pub(super) const fn policy(&self) -> Policy {
        self.settings.policy
    }
}
