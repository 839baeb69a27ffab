//! The part of a frame during which its sender alone drives the bus.

use canbaud::wire::Level;

use super::machine::{Protocol, State};
use super::reader::Reader;
use crate::node::bit_time::Rate;

/// How far a sender has come that nobody interferes with.
#[derive(Debug, Clone)]
pub(crate) struct Alone {
    reader: Reader,
    /// The bit that is sent next, counted from SOF.
    index: usize,
}

impl Alone {
    /// The sender reads back what it sent, up to `bits` bits of `level`; returns of how many
    /// nothing comes.
    #[inline]
    pub(crate) fn read_back(&mut self, level: Level, bits: u32) -> u32 {
        let taken = self.reader.push_run(level, bits).0;
        self.index += taken as usize;
        taken
    }
}

impl Protocol {
    /// A sender inside of its frame, and how many bits lie before the end of the CRC field, where
    /// others may drive the bus, too.
    pub(crate) fn alone(&self) -> Option<(Alone, u32)> {
        let sending = self.sending.as_ref().filter(|_| self.state == State::Frame)?;
        // The edge to res measures the loop delay, and BRS changes the rate.
        let steady = !sending.frame().kind().is_fd()
            || self.rate == Rate::Data
            || (!sending.switches_rate() && self.reader.is_past_res());
        if !steady || sending.before_sof() || sending.level() != self.drive {
            return None;
        }
        let left = sending.bits_before_crc_delimiter();
        let alone = Alone { reader: self.reader.clone(), index: sending.index() as usize };
        Some((alone, left))
    }

    /// The next bit that `alone` sends, and how many equal ones it begins (up to 32).
    #[inline]
    pub(crate) fn run_of(&self, alone: &Alone) -> (Level, u32) {
        self.sending.as_ref().map_or((Level::Recessive, 0), |sending| sending.run_from(alone.index))
    }

    /// The level `bits` bits after the next one.
    pub(crate) fn level_ahead(&self, bits: u32) -> Level {
        self.sending.as_ref().map_or(Level::Recessive, |sending| sending.level_ahead(bits))
    }

    /// Goes on where `alone` has come to; returns the level of the bit before that.
    pub(crate) fn go_on_from(&mut self, alone: Alone) -> Level {
        self.reader = alone.reader;
        let Some(sending) = &mut self.sending else { return Level::Recessive };
        let before = sending.go_to(alone.index);
        self.drive = sending.level();
        before
    }
}
