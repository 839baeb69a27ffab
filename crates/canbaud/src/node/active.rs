//! A node that takes part: boot-up message, heartbeat, network management, and doubt.

use super::nmt::{NmtCommand, NmtState, boot_up, heartbeat, is_asking_for_start, start};
use super::settings::{Settings, Silence, Startup};
use super::signal::{Input, Sending};
use crate::detect::scan::{
    Candidate, ErrorClass, ErrorPlace, ErrorSeen, FrameSeen, Observation, Origin,
};
use crate::fault::{ERROR_ACTIVE_MAX, State, WARNING_LIMIT};
use crate::units::Micros;
use crate::wire::Frame;

/// So long a node may be error passive as a receiver, without a good frame, before it doubts its
/// rate. Error passive it disturbs nobody.
const DOUBT: Micros = Micros::from_ms(100);

/// So long a frame may wait for an acknowledgement before the node listens again: alone on its rate
/// it would keep others, at another one, from ever sending.
const ANSWER: Micros = Micros::from_ms(1000);

/// How sure a node is of its rate when it begins to take part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trust {
    /// The controller has received at it, or it must not be left.
    Sure,
    /// The first error before a good frame sends it back to listening.
    OnTrial,
}

/// Why a node stops taking part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leave {
    /// The controller is in bus-off.
    BusOff,
    /// The rate does not seem to fit.
    Misfit,
    /// Nobody has answered.
    NobodyThere,
}

/// What is under way in the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnderWay {
    Nothing,
    BootUp,
    Other,
}

/// A node that takes part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Active {
    pub(super) candidate: Candidate,
    trust: Trust,
    /// A frame was received or sent at this rate.
    good: bool,
    /// `None` before the boot-up message is out.
    nmt: Option<NmtState>,
    under_way: UnderWay,
    /// Since when.
    sending_since: Micros,
    heartbeat_at: Option<Micros>,
    /// Node-IDs that the mini-master has to start, one bit each; bit 0 is all.
    starts: u128,
    /// REC is past the passive limit.
    deaf: bool,
    doubt_at: Option<Micros>,
    warning: bool,
}

impl Active {
    pub(super) const fn new(candidate: Candidate, trust: Trust) -> Self {
        Self {
            candidate,
            trust,
            good: false,
            nmt: None,
            under_way: UnderWay::Nothing,
            sending_since: Micros(0),
            heartbeat_at: None,
            starts: 0,
            deaf: false,
            doubt_at: None,
            warning: false,
        }
    }

    pub(super) const fn nmt(&self) -> Option<NmtState> {
        self.nmt
    }

    /// Whether a counter has reached the warning limit.
    pub(super) const fn warns(&self) -> bool {
        self.warning
    }

    /// Whether a frame was received or sent at this rate.
    pub(super) const fn is_good(&self) -> bool {
        self.good
    }

    /// What was under way was taken back.
    pub(super) const fn take_back(&mut self) {
        self.under_way = UnderWay::Nothing;
    }

    /// As before the boot-up message; one that is under way is of the past.
    pub(super) const fn reset_communication(&mut self) {
        self.nmt = None;
        self.heartbeat_at = None;
        if matches!(self.under_way, UnderWay::BootUp) {
            self.under_way = UnderWay::Other;
        }
    }

    /// Something happened. An NMT reset is for the application, too.
    pub(super) fn handle(
        &mut self,
        now: Micros,
        input: &Input,
        settings: &Settings,
        reset: &mut Option<NmtCommand>,
    ) -> Option<Leave> {
        match input {
            Input::Heard(Observation::Frame(FrameSeen { frame, origin: Origin::Bus, .. })) => {
                self.note_good(now);
                self.receive(now, frame, settings, reset);
                None
            }
            Input::Heard(Observation::Error(error)) => {
                let misfit = !self.good && self.trust != Trust::Sure && speaks_against(error);
                misfit.then_some(Leave::Misfit)
            }
            Input::Heard(_) | Input::Ready(_) | Input::Refused => None,
            Input::Sent => {
                self.sent(now, settings);
                None
            }
            Input::Fault { state, tec, rec } => self.fault(now, *state, *tec, *rec),
        }
    }

    fn note_good(&mut self, now: Micros) {
        self.good = true;
        self.plan_doubt(now);
    }

    fn plan_doubt(&mut self, now: Micros) {
        self.doubt_at = self.deaf.then(|| now + DOUBT);
    }

    fn sent(&mut self, now: Micros, settings: &Settings) {
        let was = core::mem::replace(&mut self.under_way, UnderWay::Nothing);
        if was == UnderWay::Nothing {
            return;
        }
        self.note_good(now);
        if was == UnderWay::BootUp {
            self.heartbeat_at = settings.heartbeat.map(|period| now + period);
            self.nmt = Some(NmtState::PreOperational);
            if settings.startup == Startup::MiniMaster {
                self.nmt = Some(NmtState::Operational);
                self.starts |= 1;
            }
        }
    }

    fn receive(
        &mut self,
        now: Micros,
        frame: &Frame,
        settings: &Settings,
        reset: &mut Option<NmtCommand>,
    ) {
        if settings.startup == Startup::MiniMaster {
            if let Some(node) = is_asking_for_start(frame) {
                self.starts |= 1 << (node.get() & 0x7F);
            }
            return;
        }
        // Before the boot-up message a device is initialising and obeys nobody.
        if self.nmt.is_none() {
            return;
        }
        match NmtCommand::for_node(settings.node_id, frame) {
            Some(NmtCommand::Enter(state)) => {
                self.nmt = Some(state);
                // The master learns of it at once.
                self.heartbeat_at = self.heartbeat_at.map(|_| now);
            }
            Some(command @ (NmtCommand::ResetNode | NmtCommand::ResetCommunication)) => {
                self.nmt = None;
                *reset = Some(command);
            }
            None => {}
        }
    }

    fn fault(&mut self, now: Micros, state: State, tec: u16, rec: u16) -> Option<Leave> {
        self.warning = tec >= WARNING_LIMIT || rec >= WARNING_LIMIT;
        if state == State::BusOff {
            return Some(Leave::BusOff);
        }
        let deaf = state == State::ErrorPassive && rec > ERROR_ACTIVE_MAX;
        if core::mem::replace(&mut self.deaf, deaf) != deaf {
            self.plan_doubt(now);
        }
        None
    }

    /// When nobody has answered for too long. A mini-master goes on: its first message is what the
    /// others find the rate by \[Koppe\].
    fn unanswered_at(&self, settings: &Settings) -> Option<Micros> {
        let patience = match settings.silence {
            Silence::Break { hold, .. } => hold,
            Silence::Wait => ANSWER,
        };
        let waits = self.under_way != UnderWay::Nothing && settings.may_detect();
        waits.then(|| self.sending_since + patience)
    }

    /// Whether it is time to leave.
    pub(super) fn leave(&self, now: Micros, settings: &Settings) -> Option<Leave> {
        let over = |at: Option<Micros>| at.is_some_and(|at| at <= now);
        if over(self.doubt_at) {
            Some(Leave::Misfit)
        } else if over(self.unanswered_at(settings)) {
            Some(Leave::NobodyThere)
        } else {
            None
        }
    }

    /// What is to be sent now.
    pub(super) fn next_frame(&mut self, now: Micros, settings: &Settings) -> Option<Frame> {
        if self.under_way != UnderWay::Nothing {
            return None;
        }
        let Some(nmt) = self.nmt else {
            let frame = boot_up(settings.node_id)?;
            self.under_way = UnderWay::BootUp;
            self.sending_since = now;
            return Some(frame);
        };
        let frame = if self.starts != 0 {
            let node = self.starts.trailing_zeros();
            self.starts &= self.starts - 1;
            start(node as u8)?
        } else {
            let at = self.heartbeat_at.filter(|at| *at <= now)?;
            let period = settings.heartbeat?;
            // After a long wait there is one heartbeat, not all that were missed.
            self.heartbeat_at = Some((at + period).max(now));
            heartbeat(settings.node_id, nmt)?
        };
        self.under_way = UnderWay::Other;
        self.sending_since = now;
        Some(frame)
    }

    /// When there is something to do.
    pub(super) fn deadline(&self, sending: Sending, settings: &Settings) -> Option<Micros> {
        let heartbeat = match (self.under_way, sending) {
            (UnderWay::Nothing, Sending::Allowed) => self.heartbeat_at,
            _ => None,
        };
        let unanswered = self.unanswered_at(settings);
        // A mini-master cannot leave, so doubt is nothing to wake up for.
        let doubt = self.doubt_at.filter(|_| settings.may_detect());
        [heartbeat, unanswered, doubt].into_iter().flatten().min()
    }
}

/// An error that a node at the right rate would not meet when it is alone.
const fn speaks_against(error: &ErrorSeen) -> bool {
    !matches!(
        (error.class, error.place),
        (ErrorClass::Acknowledge, _) | (_, ErrorPlace::AckDelimiter | ErrorPlace::AckSlot)
    )
}
