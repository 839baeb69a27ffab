//! The machine: from power-on to operation, and back to silence.

use super::active::{Active, Leave, Trust};
use super::led::{Leds, Pattern};
use super::nmt::{NmtCommand, NmtState};
use super::patience::{Patience, Refusal};
use super::recovering::Recovering;
use super::search::{Search, Wish};
use super::settings::{Means, Settings, SettingsError, Startup};
use super::signal::{Action, Input, Sending};
use crate::detect::scan::{Candidate, Candidates, FrameSeen, Observation, Origin};
use crate::lss::{NodeId, RateSetting};
use crate::units::{Bitrate, Micros};
use crate::wire::Logic;

/// Where a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// It listens for the rate and drives nothing.
    Detecting,
    /// It is in bus-off, listens, and counts 128 times 11 recessive bits.
    Recovering,
    /// It takes part, or the controller is being set to.
    TakingPart {
        /// At this rate.
        bitrate: Bitrate,
        /// Its state, once the boot-up message was acknowledged.
        nmt: Option<NmtState>,
    },
}

/// What a node is at.
#[derive(Debug, Clone)]
enum Phase {
    /// Looks for the rate; after bus-off it must not take part before recovery.
    Silent(After),
    /// Counts recessive bits, to take part then with so much trust.
    Recovering(Recovering, Trust),
    /// Takes part.
    Active(Active),
}

/// What a search comes after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum After {
    BusOff,
    Other,
}

/// How the controller is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Off,
    Listening(Candidate),
    TakingPart(Candidate),
}

/// What the device knows of the mode that is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    No,
    Yes,
    /// It has done it.
    Ready,
}

/// A CANopen node that finds its way into any network: one machine from power-on to operation.
///
/// `N` is the number of runs that its measurement can hold ([`crate::detect::PulseDetector`]), `R`
/// that of the rates that it can be set to.
///
/// It does no I/O. The device tells it what happens ([`Self::handle`], [`Self::edge`],
/// [`Self::timer`]), then calls [`Self::poll`] until that gives nothing more to do, and again at
/// [`Self::deadline`].
///
/// ```
/// use canbaud::detect::scan::{Candidate, Configured, FrameSeen, Observation, Origin};
/// use canbaud::lss::NodeId;
/// use canbaud::node::{Action, Input, Means, Node, Settings, Stage};
/// use canbaud::units::{Bitrate, Hertz, Micros, Timebase};
/// use canbaud::wire::{Frame, FrameKind, Id};
///
/// let timer = Timebase::from_frequency(Hertz::new(8_000_000).unwrap());
/// let settings = Settings::automatic(NodeId::new(5).unwrap(), Means::Both(timer));
/// let remembered = Bitrate::new(250_000);
/// let mut node: Node = Node::new(settings, remembered, Micros(0)).unwrap();
///
/// // It begins in silence, at the rate that was right last.
/// let candidate = Candidate::classic(remembered.unwrap());
/// assert_eq!(node.poll(Micros(0)), Some(Action::Listen(candidate)));
/// assert_eq!(node.poll(Micros(0)), None);
/// node.handle(Micros(100), &Input::Ready(Configured { nominal: candidate.nominal, data: None }));
///
/// // Two different frames at that rate are enough even if the timer has seen nothing.
/// for byte in [1, 2] {
///     let frame = Frame::new(Id::Base(0x181), FrameKind::Data, 1, &[byte]).unwrap();
///     let seen = FrameSeen { frame, origin: Origin::Bus, received: None };
///     node.handle(Micros(900), &Input::Heard(Observation::Frame(seen)));
/// }
/// assert_eq!(node.poll(Micros(900)), Some(Action::TakePart(candidate)));
/// assert_eq!(node.stage(), Stage::TakingPart { bitrate: candidate.nominal, nmt: None });
/// ```
#[derive(Debug, Clone)]
pub struct Node<const N: usize = 160, const R: usize = 8> {
    settings: Settings,
    /// The rate that was right last.
    remembered: Option<Bitrate>,
    /// That has to be kept.
    keep: bool,
    search: Search<N, R>,
    phase: Phase,
    wanted: Mode,
    told: Told,
    sending: Sending,
    patience: Patience,
    refusal: Refusal,
    reset: Option<NmtCommand>,
}

impl<const N: usize, const R: usize> Node<N, R> {
    /// A node at power-on, with the rate that [`Action::Remember`] told last time.
    ///
    /// # Errors
    /// [`SettingsError`] if it cannot be set like that.
    pub fn new(
        settings: Settings,
        remembered: Option<Bitrate>,
        now: Micros,
    ) -> Result<Self, SettingsError> {
        let first = settings.check()?;
        if Candidates::<R>::of_rates(settings.rates).is_err() {
            return Err(SettingsError::TooManyRates { room: R });
        }
        let mut node = Self {
            search: Search::new(&settings, first),
            settings,
            remembered: remembered.filter(|rate| settings.rates.contains(rate)),
            keep: false,
            phase: Phase::Silent(After::Other),
            wanted: Mode::Off,
            told: Told::No,
            sending: Sending::Allowed,
            patience: Patience::new(settings.seed),
            refusal: Refusal::default(),
            reset: None,
        };
        node.begin(now, first);
        Ok(node)
    }

    /// Begins as at power-on with another rate or index 9: what LSS "activate bit timing" asks for.
    ///
    /// # Errors
    /// [`SettingsError`] if it cannot be set like that; it goes on as it was.
    pub fn set_rate(&mut self, rate: RateSetting, now: Micros) -> Result<(), SettingsError> {
        let settings = Settings { rate, ..self.settings };
        let first = settings.check()?;
        self.settings = settings;
        self.patience.renew();
        self.begin(now, first);
        Ok(())
    }

    /// Allows or forbids sending, as LSS does around an activation. When it is forbidden, the device
    /// takes back what waits in the controller.
    pub const fn set_sending(&mut self, sending: Sending) {
        self.sending = sending;
        if let (Sending::Forbidden, Phase::Active(active)) = (sending, &mut self.phase) {
            active.take_back();
        }
    }

    /// The NMT state reset communication, with this node-ID from then on: what LSS and the NMT
    /// master ask for. If the node takes part it sends its boot-up message anew.
    pub const fn reset_communication(&mut self, node_id: NodeId) {
        self.settings.node_id = node_id;
        if let Phase::Active(active) = &mut self.phase {
            active.reset_communication();
        }
    }

    fn begin(&mut self, now: Micros, first: Bitrate) {
        self.refusal = Refusal::default();
        match (self.settings.rate, self.settings.may_detect()) {
            (RateSetting::Automatic, _) => self.go_silent(now, After::Other),
            (RateSetting::Fixed(_), may_detect) => {
                let trust = if may_detect { Trust::OnTrial } else { Trust::Sure };
                self.take_part(Candidate::classic(first), trust);
            }
        }
    }

    /// The rate to try first: the one that was right last.
    fn first(&self) -> Bitrate {
        self.remembered.unwrap_or_else(|| self.settings.first_rate())
    }

    fn go_silent(&mut self, now: Micros, after: After) {
        self.search = Search::new(&self.settings, self.first());
        self.phase = Phase::Silent(after);
        self.want(Mode::Off);
        self.patience.plan(now, &self.settings);
    }

    fn take_part(&mut self, candidate: Candidate, trust: Trust) {
        self.phase = Phase::Active(Active::new(candidate, trust));
        self.patience.cancel();
        self.want(Mode::TakingPart(candidate));
    }

    fn recover(&mut self, candidate: Candidate, trust: Trust) {
        self.patience.cancel();
        let (recovering, mode) = match self.settings.means {
            Means::Timer(timebase) => (Recovering::by_timer(candidate, timebase), Mode::Off),
            Means::Controller(_) | Means::Both(_) => {
                (Recovering::new(candidate), Mode::Listening(candidate))
            }
        };
        self.phase = Phase::Recovering(recovering, trust);
        self.want(mode);
    }

    /// Has the controller set up anew, even if it is so already.
    const fn want(&mut self, mode: Mode) {
        self.wanted = mode;
        self.told = Told::No;
    }

    /// An edge of RXD (high is recessive): the timer was at `ticks`, the line is at `level` from now
    /// on. To be told while the stage is [`Stage::Detecting`] or [`Stage::Recovering`].
    pub fn edge(&mut self, ticks: u64, level: Logic) {
        match &mut self.phase {
            Phase::Silent(_) => self.search.edge(ticks, level),
            Phase::Recovering(recovering, _) => recovering.line(ticks, level),
            Phase::Active(_) => {}
        }
    }

    /// The timer stands at `ticks` and the line is at `level`: to be told at every wake-up by a
    /// device with a timer, so that the end of the last frame is noticed.
    pub fn timer(&mut self, ticks: u64, level: Logic) {
        match &mut self.phase {
            Phase::Silent(_) => self.search.timer(ticks, level),
            Phase::Recovering(recovering, _) => recovering.line(ticks, level),
            Phase::Active(_) => {}
        }
    }

    /// Something happened.
    pub fn handle(&mut self, now: Micros, input: &Input) {
        match (input, self.told) {
            // An answer to something that is not wanted any more, or what came in before.
            (Input::Ready(_) | Input::Refused, Told::No) => return,
            (Input::Heard(_) | Input::Sent | Input::Fault { .. }, Told::No | Told::Yes) => return,
            (Input::Refused, Told::Ready) => return,
            // To stop is nothing that a controller can refuse.
            (Input::Refused, Told::Yes) if self.wanted == Mode::Off => return,
            (Input::Refused, Told::Yes) => return self.refuse(now),
            (Input::Ready(_), _) => {
                self.told = Told::Ready;
                self.refusal = Refusal::default();
            }
            (_, _) => {}
        }
        match &mut self.phase {
            Phase::Silent(_) => match input {
                Input::Ready(configured) => self.search.listening(now, *configured),
                Input::Heard(observation) => self.search.heard(now, observation),
                Input::Refused | Input::Sent | Input::Fault { .. } => {}
            },
            Phase::Recovering(recovering, _) => {
                if wait(recovering, now, input) && self.settings.may_detect() {
                    self.go_silent(now, After::BusOff);
                }
            }
            Phase::Active(active) => {
                let leave = active.handle(now, input, &self.settings, &mut self.reset);
                let good = active.is_good().then_some(active.candidate.nominal);
                self.note_good_rate(good);
                self.leave(now, leave);
            }
        }
    }

    /// The controller cannot, or cannot now: it is asked again after a while, less and less often.
    fn refuse(&mut self, now: Micros) {
        // A scan goes on with its other rates first.
        let at_once = match &self.phase {
            Phase::Silent(_) => self.search.refused(now),
            Phase::Recovering(..) | Phase::Active(_) => 0,
        };
        let rate = match self.wanted {
            Mode::Listening(candidate) | Mode::TakingPart(candidate) => Some(candidate.nominal),
            Mode::Off => None,
        };
        self.refusal.note(now, rate, at_once);
        let stubborn = self.refusal.is_stubborn() && self.settings.may_detect();
        match (&self.phase, stubborn) {
            (Phase::Recovering(..), true) => self.go_silent(now, After::BusOff),
            (Phase::Active(_), true) => self.go_silent(now, After::Other),
            (Phase::Silent(_) | Phase::Recovering(..) | Phase::Active(_), _) => {
                self.told = Told::No;
            }
        }
    }

    fn note_good_rate(&mut self, rate: Option<Bitrate>) {
        if rate.is_some() {
            self.patience.renew();
            self.keep |= self.remembered != rate;
            self.remembered = rate;
        }
    }

    fn leave(&mut self, now: Micros, leave: Option<Leave>) {
        let (Some(leave), Phase::Active(active)) = (leave, &self.phase) else { return };
        let candidate = active.candidate;
        match (leave, self.settings.may_detect()) {
            (Leave::BusOff, true) => self.go_silent(now, After::BusOff),
            (Leave::BusOff, false) => self.recover(candidate, Trust::Sure),
            (Leave::Misfit | Leave::NobodyThere, true) => self.go_silent(now, After::Other),
            // A mini-master keeps its rate.
            (Leave::Misfit | Leave::NobodyThere, false) => {}
        }
    }

    /// What the device has to do next; to be called until it says `None`.
    pub fn poll(&mut self, now: Micros) -> Option<Action> {
        self.go_on(now);
        if self.told == Told::No {
            if now < self.refusal.over() {
                return None;
            }
            self.told = Told::Yes;
            return Some(match self.wanted {
                Mode::Off => Action::Stop,
                Mode::Listening(candidate) => Action::Listen(candidate),
                Mode::TakingPart(candidate) => Action::TakePart(candidate),
            });
        }
        if core::mem::take(&mut self.keep)
            && let Some(rate) = self.remembered
        {
            return Some(Action::Remember(rate));
        }
        if let Some(command) = self.reset.take() {
            return Some(Action::Reset(command));
        }
        match (&mut self.phase, self.told, self.sending) {
            (Phase::Active(active), Told::Ready, Sending::Allowed) => {
                active.next_frame(now, &self.settings).map(Action::Send)
            }
            _ => None,
        }
    }

    /// Time passes.
    fn go_on(&mut self, now: Micros) {
        if let Phase::Active(active) = &self.phase {
            let leave = active.leave(now, &self.settings);
            self.leave(now, leave);
        }
        match &mut self.phase {
            Phase::Silent(after) => {
                let after = *after;
                if self.search.take_sign() {
                    self.patience.plan(now, &self.settings);
                }
                match self.search.poll(now) {
                    Some(candidate) => self.fit(candidate, after),
                    None => self.follow_search(now, after),
                }
            }
            Phase::Recovering(recovering, trust) => {
                if recovering.is_complete(now) {
                    let (candidate, trust) = (recovering.candidate, *trust);
                    self.take_part(candidate, trust);
                } else {
                    recovering.look(now);
                }
            }
            Phase::Active(_) => {}
        }
    }

    /// How sure a rate is that was detected, or kept: a timer alone is on trial.
    const fn trust(&self) -> Trust {
        match (self.settings.means, self.settings.startup) {
            (Means::Timer(_), Startup::Slave) => Trust::OnTrial,
            _ => Trust::Sure,
        }
    }

    fn fit(&mut self, candidate: Candidate, after: After) {
        self.come_back(candidate, after, self.trust());
    }

    fn come_back(&mut self, candidate: Candidate, after: After, trust: Trust) {
        match after {
            After::BusOff => self.recover(candidate, trust),
            After::Other => self.take_part(candidate, trust),
        }
    }

    fn follow_search(&mut self, now: Micros, after: After) {
        if self.patience.is_over(now) {
            let rate = self.settings.rate.bitrate().unwrap_or_else(|| self.first());
            return self.come_back(Candidate::classic(rate), after, Trust::OnTrial);
        }
        match self.search.take_wish() {
            Some(Wish::Listen(candidate)) => self.want(Mode::Listening(candidate)),
            Some(Wish::Stop) => self.want(Mode::Off),
            None => {}
        }
    }

    /// When [`Self::poll`] has to be called at the latest; `None` if only something that happens
    /// can bring the node on.
    #[must_use]
    pub fn deadline(&self) -> Option<Micros> {
        match (&self.phase, self.told) {
            (_, Told::No) => Some(self.refusal.over()),
            (Phase::Silent(_), _) => {
                [self.search.deadline(), self.patience.deadline()].into_iter().flatten().min()
            }
            (Phase::Recovering(recovering, _), _) => recovering.deadline(),
            (Phase::Active(active), Told::Ready) => active.deadline(self.sending, &self.settings),
            (Phase::Active(_), Told::Yes) => None,
        }
    }

    /// Where it is.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        match &self.phase {
            Phase::Silent(_) => Stage::Detecting,
            Phase::Recovering(..) => Stage::Recovering,
            Phase::Active(active) => {
                Stage::TakingPart { bitrate: active.candidate.nominal, nmt: active.nmt() }
            }
        }
    }

    /// The rate that the controller refuses to be set to, while it does: it is asked again, at first
    /// after 50 ms, then less and less often. A slave that was to take part detects after three
    /// refusals.
    #[must_use]
    pub const fn refused(&self) -> Option<Bitrate> {
        self.refusal.rate()
    }

    /// How it is set.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What its LEDs show.
    #[must_use]
    pub const fn leds(&self) -> Leds {
        match &self.phase {
            // A rate that the device does not have: no configuration that can work.
            Phase::Silent(_) if self.search.is_foreign() || self.refused().is_some() => {
                Leds { run: Pattern::Flickering, error: Pattern::Blinking }
            }
            Phase::Silent(_) => Leds { run: Pattern::Flickering, error: Pattern::Flickering },
            Phase::Recovering(..) => Leds { run: Pattern::Off, error: Pattern::On },
            Phase::Active(active) => Leds {
                run: match active.nmt() {
                    None => Pattern::Off,
                    Some(NmtState::PreOperational) => Pattern::Blinking,
                    Some(NmtState::Operational) => Pattern::On,
                    Some(NmtState::Stopped) => Pattern::SingleFlash,
                },
                error: match (self.refused(), active.warns()) {
                    (Some(_), _) => Pattern::Blinking,
                    (None, true) => Pattern::SingleFlash,
                    (None, false) => Pattern::Off,
                },
            },
        }
    }
}

/// Waits for the end of bus-off. True if the rate does not fit any more.
fn wait(recovering: &mut Recovering, now: Micros, input: &Input) -> bool {
    match input {
        Input::Ready(_) => recovering.listening(now),
        Input::Heard(Observation::Frame(FrameSeen { origin: Origin::Bus, .. })) => {
            recovering.frame(now);
        }
        Input::Heard(Observation::Error(_)) => return recovering.error(now),
        // A refusal is for the machine.
        Input::Heard(_) | Input::Refused | Input::Sent | Input::Fault { .. } => {}
    }
    false
}
