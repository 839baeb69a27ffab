//! The part of a frame that is stuffed dynamically.

use super::super::item::{ErrorKind, Field};
use super::super::line::Level;
use super::{Failure, Reader, Stuffing};

/// Most equal bits in a row that stuffing allows.
const EQUAL_MAX: u32 = 5;

/// How the stuffed part ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StuffedEnd {
    /// Bits of the last run that lie behind the end.
    pub(super) extra: u32,
    /// The same as a time, in nominal bits times 2^20.
    pub(super) behind_q20: i32,
    /// Level of that run.
    pub(super) level: Level,
}

impl Reader<'_> {
    /// Takes whole runs until at least `target` bits without stuff bits are there.
    ///
    /// Only for targets well before the end of the stuffed part.
    pub(super) fn fill(&mut self, target: usize) -> Result<(), Failure> {
        while self.plain.len() < target {
            let Some((ticks, level)) = self.activity.run(self.next) else {
                return Err(self.fail(ErrorKind::Truncated, self.field()));
            };
            let bits = self.sync.bits(ticks, level);
            if bits == 0 || bits > EQUAL_MAX {
                return Err(self.fail(ErrorKind::Stuff, self.field()));
            }
            self.take(bits, level);
            self.edge(ticks, bits, level);
            self.next += 1;
        }
        Ok(())
    }

    /// Takes a run of one to five bits, its first a stuff bit if one is due.
    #[inline]
    pub(super) fn take(&mut self, bits: u32, level: Level) {
        let stuffed = self.stuffing.bits();
        self.stuff_bits += stuffed as usize;
        self.raw.push_run(level, bits);
        self.plain.push_run(level, bits - stuffed);
        self.stuffing = if bits == EQUAL_MAX { Stuffing::Due } else { Stuffing::Open };
    }

    /// Takes runs up to the end of the stuffed part, where `end` bits without stuff bits are
    /// there; a run may go on behind it.
    pub(super) fn fill_to_end(&mut self, end: usize) -> Result<StuffedEnd, Failure> {
        loop {
            let Some((ticks, level)) = self.activity.run(self.next) else {
                return Err(self.fail(ErrorKind::Truncated, self.field()));
            };
            let bits = self.sync.bits(ticks, level);
            let stuffed = self.stuffing.bits();
            let wanted = end.saturating_sub(self.plain.len()) as u32 + stuffed;
            if bits == 0 || bits.min(wanted) > EQUAL_MAX {
                return Err(self.fail(ErrorKind::Stuff, self.field()));
            }
            if bits < wanted {
                self.take(bits, level);
                self.edge(ticks, bits, level);
                self.next += 1;
                continue;
            }
            self.take(wanted, level);
            if bits == wanted {
                self.edge(ticks, bits, level);
            } else {
                self.bits += wanted;
            }
            self.next += 1;
            let behind_q20 = self.rates.nominal.bits_q20(ticks) - ((wanted as i32) << 20);
            return Ok(StuffedEnd { extra: bits - wanted, behind_q20, level });
        }
    }

    /// The field that the next bit belongs to, as far as it matters for a message.
    pub(super) fn field(&self) -> Field {
        let extended = self.plain.len() > 13 && self.plain.level(13) == Level::Recessive;
        let (control, data) = if extended { (32, 39) } else { (13, 19) };
        match self.plain.len() {
            len if len < control => Field::Arbitration,
            len if len < data => Field::Control,
            _ => Field::Data,
        }
    }
}
