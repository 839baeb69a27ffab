//! Error and overload frames: flag, superposition, delimiter.

use canbaud::wire::Level;

use super::machine::{Protocol, State};
use crate::event::{ErrorKind, Event, FaultState, Place, Role, Rule};
use crate::node::config::Mode;

/// Bits of a flag.
const FLAG_BITS: u8 = 6;
/// Bits of a delimiter.
const DELIMITER_BITS: u8 = 8;

impl Protocol {
    /// An overload condition: a dominant bit in the intermission, or as the last bit of EOF or of
    /// a delimiter.
    pub(super) fn overload(&mut self) {
        self.events.push(Event::Overload);
        if self.setup.mode == Mode::Restricted {
            self.state = State::Integrating { recessive: 0 };
            return;
        }
        self.drive = Level::Dominant;
        self.state = State::OverloadFlag { sent: 0 };
    }

    pub(super) fn active_flag_bit(&mut self, level: Level, sent: u8) {
        match level {
            Level::Recessive => self.flag_error(),
            Level::Dominant if sent + 1 < FLAG_BITS => {
                self.state = State::ActiveFlag { sent: sent + 1 };
            }
            Level::Dominant => self.end_flag(false),
        }
    }

    pub(super) fn overload_flag_bit(&mut self, level: Level, sent: u8) {
        match level {
            Level::Recessive => self.flag_error(),
            Level::Dominant if sent + 1 < FLAG_BITS => {
                self.state = State::OverloadFlag { sent: sent + 1 };
            }
            Level::Dominant => self.end_flag(true),
        }
    }

    /// Rules 4 and 5: a dominant bit of one's own flag reads recessive; the flag starts anew.
    fn flag_error(&mut self) {
        let (kind, place, role) = (ErrorKind::Bit, Place::Flag, self.role);
        self.events.push(Event::Error { kind, place, role, exempt: false });
        self.drive = Level::Recessive;
        let active = self.is_error_active();
        self.count(match self.role {
            Role::Transmitter => Rule::TransmitterFlagError,
            Role::Receiver => Rule::ReceiverFlagError,
        });
        self.begin_flag(active, false);
    }

    pub(super) fn passive_flag_bit(
        &mut self,
        level: Level,
        run: u8,
        last: Option<Level>,
        tec_pending: bool,
    ) {
        let mut tec_pending = tec_pending;
        if tec_pending && level == Level::Dominant {
            tec_pending = false;
            self.count(Rule::TransmitterError);
            if self.fault.state() == FaultState::BusOff {
                return self.enter_bus_off();
            }
        }
        let run = if last == Some(level) { run + 1 } else { 1 };
        if run == FLAG_BITS {
            self.end_flag(false);
        } else {
            self.state = State::PassiveFlag { run, last: Some(level), tec_pending };
        }
    }

    fn end_flag(&mut self, overload: bool) {
        self.drive = Level::Recessive;
        self.state = State::AfterFlag { dominant: 0, overload };
    }

    pub(super) fn after_flag_bit(&mut self, level: Level, dominant: u32, overload: bool) {
        if level == Level::Recessive {
            self.state = State::Delimiter { recessive: 1 };
            return;
        }
        let dominant = dominant + 1;
        self.state = State::AfterFlag { dominant, overload };
        if dominant == 1 && !overload && self.role == Role::Receiver {
            self.count(Rule::DominantAfterFlag);
        }
        if dominant.is_multiple_of(8) {
            self.count(Rule::DominantRun);
            if self.fault.state() == FaultState::BusOff {
                self.enter_bus_off();
            }
        }
    }

    pub(super) fn delimiter_bit(&mut self, level: Level, recessive: u8) {
        match level {
            Level::Recessive if recessive + 1 < DELIMITER_BITS => {
                self.state = State::Delimiter { recessive: recessive + 1 };
            }
            Level::Recessive => self.state = State::Intermission { bit: 1 },
            // The last bit of the delimiter dominant is an overload condition.
            Level::Dominant if recessive + 1 == DELIMITER_BITS => self.overload(),
            Level::Dominant => self.error(ErrorKind::Form, Place::Delimiter, false),
        }
    }
}
