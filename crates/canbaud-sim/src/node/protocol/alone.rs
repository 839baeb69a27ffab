//! The part of a frame during which its sender alone drives the bus.

use core::ops::Range;

use canbaud::wire::{BitString, Level};

use super::machine::{Protocol, State};
use super::reader::{Reader, Step};
use crate::node::bit_time::Rate;

/// How far a sender has come that nobody interferes with.
#[derive(Debug, Clone)]
pub(crate) struct Alone {
    reader: Reader,
    /// The bit that is sent next, counted from SOF.
    index: usize,
}

impl Alone {
    /// The bit that is sent next, counted from SOF.
    pub(crate) const fn bit(&self) -> u32 {
        self.index as u32
    }

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

/// A listener may be off the sender by no more bits than this.
const LAG: u32 = 8;

impl Score {
    /// Whether these bits have this level.
    pub(crate) fn has(&self, level: Level, mut bits: Range<u32>) -> bool {
        bits.all(|bit| self.bits.level(bit as usize) == level)
    }

    /// Whether what is sent leads from `early` to `late`.
    fn leads(&self, early: &Reader, late: &Reader) -> bool {
        let read = self.read(early.clone(), early.bits(), late.bits());
        read.is_some_and(|(reader, step)| step == Step::Continue && reader == *late)
    }

    /// `reader` after the bits from `from` to `to`, and what came of the last one; nothing may
    /// come of the others.
    fn read(&self, mut reader: Reader, from: u32, to: u32) -> Option<(Reader, Step)> {
        let mut step = Step::Continue;
        for bit in from..to {
            if step != Step::Continue {
                return None;
            }
            step = reader.push(self.bits.level(bit as usize));
        }
        Some((reader, step))
    }
}

impl Protocol {
    /// What the sender sends until it has come as far as `alone`.
    pub(crate) fn score(&self, alone: &Alone) -> Score {
        let bits = self.sending.as_ref().map_or(BitString::new(), |sending| *sending.bits());
        Score { bits, before: self.reader.clone(), after: alone.reader.clone() }
    }

    /// The next bit of a listener that has read what the sender has sent, counted from SOF; `None`
    /// if it has read something else.
    pub(crate) fn in_step(&self, score: &Score) -> Option<u32> {
        if self.state != State::Frame || self.reader.expects_res() {
            return None;
        }
        let read = self.reader.bits();
        let (early, late) = (&self.reader, &score.before);
        let same = if read <= late.bits() {
            late.bits() - read <= LAG && score.leads(early, late)
        } else {
            read - late.bits() <= LAG && score.leads(late, early)
        };
        same.then_some(read)
    }

    /// A listener in step has sampled all bits before `bit`. False if something came of that, or
    /// may have.
    pub(crate) fn keep_step(&mut self, score: &Score, bit: u32) -> bool {
        let known = if bit < score.after.bits() { &self.reader } else { &score.after };
        let read = score.read(known.clone(), known.bits(), bit);
        let Some((reader, step)) = read else { return false };
        self.reader = reader;
        self.goes_on_quietly(step)
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
