//! The part of a frame during which its sender alone drives the bus.

use canbaud::wire::{BitString, Level};

use super::machine::{Protocol, State};
use super::reader::{Reader, Step};
use super::transmit::run_in;
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

/// Bits that a sole sender sends, and what whoever reads them knows before and after them.
///
/// A listener that knows the same before, and samples the same bits, knows the same after them.
#[derive(Debug)]
pub(crate) struct Score {
    bits: BitString,
    before: Reader,
    after: Reader,
}

/// A listener may lag behind the sender by no more bits than this.
const LAG: u32 = 8;

impl Score {
    /// How many of `count` bits of `level` are the ones from bit `index` on.
    #[inline]
    pub(crate) fn agrees(&self, index: usize, level: Level, count: u32) -> u32 {
        let (sent, run) = run_in(&self.bits, index);
        if sent == level { run.min(count) } else { 0 }
    }

    /// `reader` after the bits from `from` to `to`, if nothing comes of them.
    fn read(&self, mut reader: Reader, from: u32, to: u32) -> Option<Reader> {
        let level = |bit: u32| self.bits.level(bit as usize);
        (from..to).all(|bit| reader.push(level(bit)) == Step::Continue).then_some(reader)
    }
}

impl Protocol {
    /// What the sender sends until it has come as far as `alone`.
    pub(crate) fn score(&self, alone: &Alone) -> Score {
        let bits = self.sending.as_ref().map_or(BitString::new(), |sending| *sending.bits());
        Score { bits, before: self.reader.clone(), after: alone.reader.clone() }
    }

    /// The next bit of a listener that has read what the sender has sent; `None` if it has read
    /// something else.
    pub(crate) fn in_step(&self, score: &Score) -> Option<usize> {
        let (read, sent) = (self.reader.bits(), score.before.bits());
        let may = self.state == State::Frame && (read..=read + LAG).contains(&sent);
        if !may || self.reader.expects_res() {
            return None;
        }
        let reader = score.read(self.reader.clone(), read, sent)?;
        (reader == score.before).then_some(read as usize)
    }

    /// A listener in step has sampled all bits before bit `index`. False if something came of that,
    /// or may have.
    pub(crate) fn keep_step(&mut self, score: &Score, index: usize) -> bool {
        let (read, known) = (index as u32, score.after.bits());
        if read < known {
            return false;
        }
        let reader = score.read(score.after.clone(), known, read);
        let quiet = reader.is_some();
        self.reader = reader.unwrap_or_else(|| score.after.clone());
        quiet
    }

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
