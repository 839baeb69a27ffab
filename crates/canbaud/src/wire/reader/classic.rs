//! Data and CRC of a classic frame.

use super::super::clock::BIT_Q20;
use super::super::crc::{Crc, CrcKind};
use super::super::frame::Frame;
use super::super::item::{ErrorKind, Field};
use super::header::Format;
use super::tail::TailRule;
use super::{Failure, Outcome, Reader, Stuffing};

impl Reader<'_> {
    pub(super) fn classic(&mut self, format: Format) -> Result<Outcome, Failure> {
        let length = Frame::data_length(format.kind, format.dlc);
        let crc_at = format.data_at + 8 * length;
        let end = self.fill_to_end(crc_at + 15)?;
        self.crc_run = self.next - 1;
        self.nominal_bits = self.bits;
        let crc = self.plain.bits(crc_at, 15);
        self.crc_compared = true;
        self.crc_right = crc == self.classic_crc(crc_at);
        let tick = self.rates.nominal.bits_q20(1);
        // Five equal bits at the end of the CRC sequence: a stuff bit comes before the delimiter.
        let (behind, level) = match self.stuffing {
            Stuffing::Open => (end.behind_q20, end.level),
            Stuffing::Due if end.extra > 0 => {
                return Err(self.fail(ErrorKind::Stuff, Field::Crc));
            }
            Stuffing::Due => {
                self.nominal_bits += 1;
                let level = end.level.toggled();
                (self.tail_run_q20(level)? - BIT_Q20, level)
            }
        };
        let tail = self.tail(behind, level, TailRule::classic(tick));
        self.conclude(format, crc, None, tail)
    }

    fn classic_crc(&self, crc_at: usize) -> u32 {
        let mut crc = Crc::new(CrcKind::CRC15);
        push_bits(&mut crc, &self.plain, crc_at);
        crc.value()
    }

    /// The frame whose header is `format` and whose data were read.
    pub(super) fn frame_of(&self, format: Format) -> Result<Frame, Failure> {
        let length = Frame::data_length(format.kind, format.dlc);
        let mut data = [0_u8; 64];
        for (index, byte) in data.iter_mut().take(length).enumerate() {
            *byte = self.plain.bits(format.data_at + 8 * index, 8) as u8;
        }
        let data = data.get(..length).unwrap_or(&[]);
        let id = self.id().ok_or(self.fail(ErrorKind::Truncated, Field::Arbitration))?;
        Frame::new(id, format.kind, format.dlc, data)
            .map_err(|_| self.fail(ErrorKind::Form, Field::Control))
    }
}

/// Feeds the first `count` bits of `bits` to `crc`.
pub(super) fn push_bits(crc: &mut Crc, bits: &super::BitString, count: usize) {
    let mut at = 0;
    while at < count {
        let step = (count - at).min(32) as u32;
        crc.push_bits(bits.bits(at, step), step);
        at += step as usize;
    }
}
