//! Bits of a frame: SOF to EOF.

use canbaud::wire::Level;

use super::machine::{Protocol, State};
use super::reader::Step;
use crate::event::{ErrorKind, Event, Place, Role, Rule};
use crate::node::bit_time::Rate;
use crate::node::config::Mode;

impl Protocol {
    #[inline]
    pub(super) fn frame_bit(&mut self, level: Level, late_error: Option<bool>) {
        let mut read = level;
        if let Some(sending) = &self.sending {
            let sent = sending.level();
            let differs = match late_error {
                Some(found) => {
                    read = sent;
                    found
                }
                None => sent != level,
            };
            if differs && !self.loses_arbitration(sent) {
                return;
            }
        }
        let place = self.reader.place();
        match self.reader.push(read) {
            Step::Continue => {}
            Step::DataRate => self.rate = Rate::Data,
            Step::End => self.state = State::CrcDelimiter,
            Step::Error(kind, at) => return self.error(kind, at, false),
            Step::Exception if self.sending.is_some() => {
                return self.error(ErrorKind::Form, place, false);
            }
            Step::Exception => {
                self.events.push(Event::ProtocolException);
                self.state = State::Integrating { recessive: 0 };
            }
        }
        self.drive = match &mut self.sending {
            Some(sending) => sending.advance(),
            None => Level::Recessive,
        };
    }

    /// The transmitter reads another level than it sent. True if it goes on as a receiver.
    fn loses_arbitration(&mut self, sent: Level) -> bool {
        let extended = self.sending.as_ref().is_some_and(|s| s.frame().id().is_extended());
        let arbitrates = self.reader.in_arbitration(extended) && sent == Level::Recessive;
        if !arbitrates {
            self.error(ErrorKind::Bit, self.reader.place(), false);
            return false;
        }
        if self.reader.stuff_bit_is_due() {
            // Exception to rule 3: a recessive stuff bit before RTR that reads dominant.
            self.error(ErrorKind::Stuff, Place::Arbitration, true);
            return false;
        }
        let bit = self.sending.as_ref().map_or(0, |s| s.index());
        self.events.push(Event::ArbitrationLost { bit });
        self.give_up_attempt();
        self.role = Role::Receiver;
        true
    }

    /// A bit that must be recessive is dominant.
    fn form_error(&mut self, place: Place) {
        let kind = match self.sending {
            Some(_) => ErrorKind::Bit,
            None => ErrorKind::Form,
        };
        self.error(kind, place, false);
    }

    pub(super) fn crc_delimiter_bit(&mut self, level: Level, late_error: Option<bool>) {
        self.rate = Rate::Nominal;
        // With TDC the pin still shows bits from before the delimiter.
        if late_error.unwrap_or(level == Level::Dominant) {
            return self.form_error(Place::CrcDelimiter);
        }
        self.state = State::AckSlot;
        let acknowledges = match self.sending {
            Some(_) => self.setup.mode == Mode::Loopback,
            None => self.reader.crc_is_good(),
        };
        if acknowledges {
            self.drive = Level::Dominant;
        }
    }

    pub(super) fn ack_slot_bit(&mut self, level: Level) {
        let drove = core::mem::replace(&mut self.drive, Level::Recessive);
        let late_ack = self.reader.is_fd();
        self.state = State::AckDelimiter { late_ack };
        match (self.sending.is_some(), level) {
            (true, Level::Dominant) => {}
            (true, Level::Recessive) if late_ack => self.state = State::LateAckSlot,
            (true, Level::Recessive) => self.error(ErrorKind::Ack, Place::AckSlot, false),
            (false, Level::Recessive) if drove == Level::Dominant => {
                self.error(ErrorKind::Bit, Place::AckSlot, false);
            }
            (false, _) if self.reader.crc_is_good() => self.count(Rule::Received),
            (false, _) => {}
        }
    }

    pub(super) fn late_ack_slot_bit(&mut self, level: Level) {
        match level {
            Level::Dominant => self.state = State::AckDelimiter { late_ack: false },
            Level::Recessive => self.error(ErrorKind::Ack, Place::AckSlot, false),
        }
    }

    pub(super) fn ack_delimiter_bit(&mut self, level: Level, late_ack: bool) {
        match level {
            Level::Dominant if late_ack => self.state = State::AckDelimiter { late_ack: false },
            Level::Dominant => self.form_error(Place::AckDelimiter),
            Level::Recessive if self.sending.is_none() && !self.reader.crc_is_good() => {
                self.error(ErrorKind::Crc, Place::AckDelimiter, false);
            }
            Level::Recessive => self.state = State::EndOfFrame { bit: 1 },
        }
    }

    pub(super) fn end_of_frame_bit(&mut self, level: Level, bit: u8) {
        match (level, bit) {
            (Level::Recessive, 1..=5) => self.state = State::EndOfFrame { bit: bit + 1 },
            (Level::Recessive, 6) => {
                self.state = State::EndOfFrame { bit: 7 };
                if self.sending.is_none()
                    && let Some(frame) = self.reader.frame()
                {
                    self.events.push(Event::Received { frame });
                }
            }
            (Level::Recessive, _) => {
                self.state = State::Intermission { bit: 1 };
                self.succeed();
            }
            // For a receiver the frame is good already: this is an overload condition.
            (Level::Dominant, 7) if self.sending.is_none() => self.overload(),
            (Level::Dominant, _) => self.form_error(Place::EndOfFrame),
        }
    }
}
