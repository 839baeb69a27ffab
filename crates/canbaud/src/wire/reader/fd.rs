//! Data, stuff count and CRC of a CAN FD frame, and its tail.

use super::super::bits::BitString;
use super::super::clock::BIT_Q20;
use super::super::crc::Crc;
use super::super::encode::{fd_crc_kind, stuff_count};
use super::super::frame::Frame;
use super::super::item::{ErrorKind, FdCrc, Field};
use super::super::line::Level;
use super::classic::push_bits;
use super::header::Format;
use super::tail::{Tail, position_field};
use super::{Failure, Outcome, Phase, Reader};

/// Where the CRC field ended.
#[derive(Debug, Clone, Copy)]
struct FieldEnd {
    /// What of the last run lies behind the end, in nominal bits times 2^20.
    behind_q20: i32,
    level: Level,
}

impl Reader<'_> {
    pub(super) fn fd(&mut self, format: Format) -> Result<Outcome, Failure> {
        let length = Frame::data_length(format.kind, format.dlc);
        let data_end = format.data_at + 8 * length;
        // The first fixed stuff bit inverts the last data bit, so a run ends exactly there.
        self.fill(data_end)?;
        if self.plain.len() != data_end {
            return Err(self.fail(ErrorKind::Form, Field::Crc));
        }
        let kind = fd_crc_kind(self.rates.fd_crc, length);
        let count_bits = match self.rates.fd_crc {
            FdCrc::Iso => 4,
            FdCrc::NonIso => 0,
        };
        let covered = self.raw.len();
        let field_bits = count_bits + kind.width();
        let end = self.crc_field(field_bits + field_bits.div_ceil(4))?;
        let field = self.unstuff_field(covered, field_bits)?;
        let crc = field.bits(count_bits as usize, kind.width());
        let mut expected = Crc::new(kind);
        push_bits(&mut expected, &self.raw, covered);
        expected.push_bits(field.bits(0, count_bits), count_bits);
        self.crc_compared = true;
        self.crc_right = crc == expected.value()
            && (count_bits == 0 || field.bits(0, 4) == stuff_count(self.stuff_bits));
        let tail = self.fd_tail(end);
        self.conclude(format, crc, Some(self.rates.fd_crc), tail)
    }

    /// Takes the `count` raw bits of stuff count, CRC sequence and fixed stuff bits.
    fn crc_field(&mut self, count: u32) -> Result<FieldEnd, Failure> {
        let mut left = count;
        loop {
            let Some((ticks, level)) = self.activity.run(self.next) else {
                return Err(self.fail(ErrorKind::Truncated, Field::Crc));
            };
            let bits = self.sync.bits(ticks, level);
            if bits == 0 || (bits > left && level == Level::Dominant) {
                return Err(self.fail(ErrorKind::Form, Field::Crc));
            }
            self.next += 1;
            if bits < left {
                self.raw.push_run(level, bits);
                self.edge(ticks, bits, level);
                left -= bits;
                continue;
            }
            self.raw.push_run(level, left);
            self.crc_run = self.next - 1;
            if bits == left && level == Level::Dominant {
                self.edge(ticks, bits, level);
            } else {
                self.bits += left;
            }
            match self.phase {
                Phase::Nominal => self.nominal_bits = self.bits,
                Phase::Data => self.data_bits += self.bits,
            }
            let clock = match (self.phase, self.rates.data) {
                (Phase::Data, Some(data)) => data.clock,
                _ => self.rates.nominal,
            };
            // The tail is nominal again: what is behind the field, in nominal bits.
            let behind = ticks.saturating_sub(clock.ticks(left).min(u64::from(u32::MAX)) as u32);
            let behind_q20 = match level {
                Level::Recessive => self.rates.nominal.bits_q20(behind),
                Level::Dominant => 0,
            };
            return Ok(FieldEnd { behind_q20, level });
        }
    }

    /// The field without its fixed stuff bits, each of which must invert the bit before.
    fn unstuff_field(&self, start: usize, bits: u32) -> Result<BitString, Failure> {
        let mut field = BitString::new();
        let mut at = start;
        let mut left = bits;
        while left > 0 {
            if self.raw.level(at) == self.raw.level(at.saturating_sub(1)) {
                return Err(self.fail(ErrorKind::Form, Field::Crc));
            }
            let group = left.min(4);
            field.push(self.raw.bits(at + 1, group), group);
            at += 1 + group as usize;
            left -= group;
        }
        Ok(field)
    }

    /// The tail: its delimiter is part data rate, part nominal, and the acknowledge comes from
    /// nodes that are a propagation delay away, so edges are judged by time, not counted.
    fn fd_tail(&mut self, end: FieldEnd) -> Result<Tail, Failure> {
        let behind = match end.level {
            Level::Recessive => end.behind_q20,
            Level::Dominant => self.next_run_q20(Level::Recessive)?,
        };
        if self.next > self.activity.runs.len() {
            return self.gap_tail(Level::Recessive, 2, behind - 2 * BIT_Q20);
        }
        let dominant = self.next_run_q20(Level::Dominant)?;
        if dominant * 2 > 7 * BIT_Q20 {
            // Not an acknowledge but an error flag; how late it starts tells what was missed.
            let position = if behind * 4 > 5 * BIT_Q20 { 2 } else { 0 };
            return Err(self.tail_failure(position, Level::Recessive));
        }
        if behind * 2 > 7 * BIT_Q20 {
            let position = ((behind + BIT_Q20 / 2) >> 20).clamp(3, 8) as u32;
            return Err(self.tail_failure(position, Level::Recessive));
        }
        let gap = self.next_run_q20(Level::Recessive)?;
        self.gap_tail(Level::Dominant, 2, gap)
    }

    /// The recessive run from the ACK delimiter (`position` 2) on.
    fn gap_tail(&self, ack: Level, position: u32, gap_q20: i32) -> Result<Tail, Failure> {
        let ended_by_edge = self.next <= self.activity.runs.len();
        let bits = ((gap_q20 + BIT_Q20 / 2) >> 20).max(0) as u32;
        // ACK delimiter and seven bits of EOF; a receiver does not mind the last one.
        match (bits, ended_by_edge) {
            (8.., _) | (7, false) => Ok(Tail { ack, overload: false }),
            (7, true) => Ok(Tail { ack, overload: true }),
            (bits, true) => Err(self.tail_failure(position + bits, ack)),
            (bits, false) => Err(self.fail(ErrorKind::Truncated, position_field(position + bits))),
        }
    }

    /// The next run, which must be of `level`, in nominal bits times 2^20.
    fn next_run_q20(&mut self, level: Level) -> Result<i32, Failure> {
        match self.activity.run(self.next) {
            Some((ticks, found)) if found == level => {
                self.next += 1;
                Ok(self.rates.nominal.bits_q20(ticks))
            }
            _ => Err(self.fail(ErrorKind::Truncated, Field::AckSlot)),
        }
    }
}
