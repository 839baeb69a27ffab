//! Bits of which nothing comes but that they are read.

use canbaud::wire::Level;

use super::machine::{Protocol, State};
use super::reader::{Reader, Step};

/// Bits of which nothing can come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quiet {
    /// So many, whatever their levels.
    Anyway(u32),
    /// So many, as long as no edge to dominant comes.
    WhileRecessive(u32),
}

/// The part of protocol control that reading changes.
#[derive(Debug, Clone)]
pub(crate) struct Reading {
    state: State,
    reader: Reader,
}

impl Protocol {
    /// How many bits may be read late, because nothing can come of them: no flag, no event.
    #[inline]
    pub(crate) fn quiet(&self) -> Quiet {
        match self.state {
            State::Frame if self.sending.is_none() => Quiet::Anyway(self.reader.quiet_bits()),
            // EOF of a receiver has an event at bit 6, that of the transmitter one at bit 7.
            State::EndOfFrame { bit: bit @ ..=5 } if self.sending.is_none() => {
                Quiet::WhileRecessive(6 - u32::from(bit))
            }
            State::EndOfFrame { bit: 7 } if self.sending.is_none() => Quiet::WhileRecessive(3),
            State::EndOfFrame { bit } if self.sending.is_some() => {
                Quiet::WhileRecessive(7 - u32::from(bit))
            }
            State::Intermission { bit } => Quiet::WhileRecessive(3 - u32::from(bit)),
            State::Delimiter { recessive } => Quiet::WhileRecessive(10 - u32::from(recessive)),
            State::Suspend { bit } => Quiet::WhileRecessive(8 - u32::from(bit)),
            State::Integrating { recessive } | State::BusOff { recessive, .. } => {
                Quiet::WhileRecessive(10 - u32::from(recessive))
            }
            _ => Quiet::Anyway(0),
        }
    }

    /// Takes up to `bits` bits of one level, as long as nothing comes of them; returns how many
    /// were taken. If they are fewer than `bits`, the one after them was begun and must be undone.
    #[inline]
    pub(crate) fn read_quiet(&mut self, level: Level, bits: u32) -> u32 {
        if matches!(self.state, State::Frame) {
            let (taken, step) = self.reader.push_run(level, bits);
            return if taken < bits && self.goes_on_quietly(step) { taken + 1 } else { taken };
        }
        for taken in 0..bits {
            match (self.state, level) {
                // The acknowledgement is decided on, or eleven recessive bits are complete.
                (State::CrcDelimiter, _)
                | (State::Integrating { recessive: 10 }, Level::Recessive)
                | (State::BusOff { recessive: 10, .. }, Level::Recessive) => return taken,
                _ => self.sample(level, None),
            }
            debug_assert!(self.events.is_empty() && self.drive == Level::Recessive);
        }
        bits
    }

    /// Whether it takes bits in and gives nothing out until something comes of one of them.
    pub(crate) fn listens(&self) -> bool {
        match self.state {
            State::Frame => self.sending.is_none(),
            State::Integrating { .. } | State::BusOff { .. } => true,
            _ => false,
        }
    }

    /// What reading may change, to be kept.
    pub(crate) fn reading(&self) -> Reading {
        Reading { state: self.state, reader: self.reader.clone() }
    }

    /// Back to what was kept.
    pub(crate) fn read_anew(&mut self, kept: Reading) {
        self.state = kept.state;
        self.reader = kept.reader;
    }

    /// Whether nothing came of a bit of a frame but, perhaps, the end of the CRC field.
    pub(super) fn goes_on_quietly(&mut self, step: Step) -> bool {
        match step {
            Step::Continue => true,
            Step::End => {
                self.state = State::CrcDelimiter;
                true
            }
            Step::DataRate | Step::Error(..) | Step::Exception => false,
        }
    }
}
