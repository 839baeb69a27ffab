//! SOF to DLC: tells classic from CAN FD and finds the bit rate switch.

use super::super::frame::FrameKind;
use super::super::item::{ErrorKind, Field};
use super::super::line::Level;
use super::super::sync::Sync;
use super::{Failure, Phase, Reader};

/// What the header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Header {
    Classic(Format),
    Fd(Format),
    DataRateWanted { brs_run: usize },
}

/// Kind, DLC, and where the data begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    pub(super) kind: FrameKind,
    pub(super) dlc: u8,
    /// Index of the first data bit, without stuff bits.
    pub(super) data_at: usize,
}

/// Index of the IDE bit.
const IDE: usize = 13;

impl Reader<'_> {
    pub(super) fn header(&mut self) -> Result<Header, Failure> {
        self.fill(IDE + 1)?;
        // Index of the bit that is FDF in a CAN FD frame: r0 in a base frame, r1 in an extended.
        let (remote_at, fdf) = match self.plain.level(IDE) {
            Level::Dominant => (12, 14),
            Level::Recessive => (32, 33),
        };
        self.fill(fdf + 1)?;
        match self.plain.level(fdf) {
            Level::Recessive => {
                self.is_fd = true;
                self.fd_header(fdf)
            }
            Level::Dominant => {
                let dlc_at = if fdf == 33 { 35 } else { 15 };
                self.fill(dlc_at + 4)?;
                let kind = match self.plain.level(remote_at) {
                    Level::Recessive => FrameKind::Remote,
                    Level::Dominant => FrameKind::Data,
                };
                let dlc = self.plain.bits(dlc_at, 4) as u8;
                Ok(Header::Classic(Format { kind, dlc, data_at: dlc_at + 4 }))
            }
        }
    }

    /// From FDF on: res, BRS, ESI, DLC.
    fn fd_header(&mut self, fdf: usize) -> Result<Header, Failure> {
        let (brs_at, esi_at, dlc_at) = (fdf + 2, fdf + 3, fdf + 4);
        self.fill(fdf + 2)?;
        if self.plain.level(fdf + 1) == Level::Recessive {
            // CAN XL, or a reserved format: a CAN FD receiver leaves the frame here.
            return Err(self.fail(ErrorKind::Form, Field::Control));
        }
        // FDF and res differ, so res is the first of its level: no stuff bit is due before BRS.
        let next = self.activity.run(self.next);
        if self.plain.len() == brs_at && matches!(next, Some((_, Level::Recessive))) {
            let Some(data) = self.rates.data else {
                return Ok(Header::DataRateWanted { brs_run: self.next });
            };
            self.switch_bit_rate(data)?;
        }
        self.fill(dlc_at + 4)?;
        let kind = FrameKind::Fd {
            brs: self.plain.level(brs_at) == Level::Recessive,
            esi: self.plain.level(esi_at) == Level::Recessive,
        };
        let dlc = self.plain.bits(dlc_at, 4) as u8;
        Ok(Header::Fd(Format { kind, dlc, data_at: dlc_at + 4 }))
    }

    /// Takes the run that begins with BRS and goes on at the data
    /// bit rate from the edge that ends it.
    fn switch_bit_rate(&mut self, data: super::DataRate) -> Result<(), Failure> {
        let Some((ticks, level)) = self.activity.run(self.next) else {
            return Err(self.fail(ErrorKind::Truncated, Field::Control));
        };
        let late = data.clock.signed_bits_q20(self.rates.late_ticks_q20);
        let skip = data.clock.signed_bits_q20(data.brs_ticks_q20.min(i64::MAX as u64) as i64);
        // The edge before BRS leads to recessive, so it was late.
        let mut sync = Sync::new(super::Pace::Anchored, data.clock, late, late);
        let behind = sync.bits_after(ticks, level, skip);
        let bits = 1 + behind;
        if bits > 5 {
            return Err(self.fail(ErrorKind::Stuff, Field::Control));
        }
        self.take(bits, level);
        self.brs_run = Some(self.next);
        self.nominal_bits = self.bits;
        self.next += 1;
        self.sync.switch(data.clock, late);
        self.phase = Phase::Data;
        self.bits = 0;
        self.ticks = 0;
        self.data.falling.push(0, 0);
        self.data_bits = 1 + behind;
        Ok(())
    }
}
