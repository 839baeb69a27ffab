//! Data, stuff count and CRC of a CAN FD frame, and its tail.

use super::super::bits::BitString;
use super::super::crc::Crc;
use super::super::encode::{fd_crc_kind, stuff_count};
use super::super::frame::Frame;
use super::super::item::{ErrorKind, FdCrc, Field};
use super::super::line::Level;
use super::classic::push_bits;
use super::header::Format;
use super::tail::TailRule;
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
        let tail = self.tail(end.behind_q20, end.level, TailRule::FD);
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
}
