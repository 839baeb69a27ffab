//! From SOF to the end of the CRC sequence: destuffing, fields, CRC [ISO 11898-1 frame formats].

use canbaud::wire::{FdCrc, Frame, FrameKind, Id, Level};

use super::crc::{RUN, RunningCrc, ones_if};
use crate::event::{ErrorKind, Place};
use crate::node::config::FdSupport;

/// The field that the next bit (stuff bits apart) belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Field {
    Sof,
    BaseId,
    /// RTR of the base format, SRR of the extended one, RRS of CAN FD.
    Rtr,
    Ide,
    ExtendedId,
    /// RTR or RRS of the extended format.
    ExtendedRtr,
    /// FDF, or the reserved bit in its place.
    Fdf,
    /// r0 of a classic extended frame.
    R0,
    /// res of a CAN FD frame.
    Res,
    Brs,
    Esi,
    Dlc,
    Data,
    /// Stuff count of an ISO CAN FD frame.
    StuffCount,
    Crc,
    /// The stuff bit that may follow the last CRC bit of a classic frame.
    LastStuff,
}

/// What a bit came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// More to come.
    Continue,
    /// BRS was recessive: the data bit rate begins.
    DataRate,
    /// The CRC sequence is complete.
    End,
    /// This is no frame.
    Error(ErrorKind, Place),
    /// FDF and res recessive, or FDF recessive in a node that only tolerates CAN FD.
    Exception,
}

/// The part of a frame that has been read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Reader {
    support: FdSupport,
    fd_crc: FdCrc,
    /// Bits read, with SOF and stuff bits.
    bits: u32,
    field: Field,
    /// Bits of the field that are still to come.
    left: u32,
    value: u32,
    last: Level,
    run: u32,
    stuff_bits: u32,
    /// CRC field of CAN FD: bits until the next fixed stuff bit.
    until_fixed: u32,
    crc: RunningCrc,
    crc_good: bool,
    id: u32,
    extended: bool,
    remote: bool,
    fd: bool,
    brs: bool,
    esi: bool,
    dlc: u8,
    data: [u8; 64],
    length: usize,
    filled: usize,
}

impl Reader {
    pub(super) fn new(support: FdSupport, fd_crc: FdCrc) -> Self {
        Self {
            support,
            fd_crc,
            bits: 0,
            field: Field::Sof,
            left: 1,
            value: 0,
            last: Level::Recessive,
            run: 0,
            stuff_bits: 0,
            until_fixed: 0,
            crc: RunningCrc::new(fd_crc),
            crc_good: true,
            id: 0,
            extended: false,
            remote: false,
            fd: false,
            brs: false,
            esi: false,
            dlc: 0,
            data: [0; 64],
            length: 0,
            filled: 0,
        }
    }

    /// Begins anew, before SOF.
    pub(super) fn reset(&mut self) {
        *self = Self::new(self.support, self.fd_crc);
    }

    /// Bits read, with SOF and stuff bits.
    pub(super) const fn bits(&self) -> u32 {
        self.bits
    }

    /// Whether the next bit is one of dynamic stuffing.
    pub(super) fn stuff_bit_is_due(&self) -> bool {
        self.run == RUN && !self.in_fd_crc()
    }

    fn in_fd_crc(&self) -> bool {
        self.fd && matches!(self.field, Field::StuffCount | Field::Crc)
    }

    /// Whether a sender of this format may lose arbitration with the next bit; a stuff bit there
    /// lies before the RTR bit.
    pub(super) const fn in_arbitration(&self, extended: bool) -> bool {
        match self.field {
            Field::Sof | Field::BaseId | Field::Rtr => true,
            Field::Ide | Field::ExtendedId | Field::ExtendedRtr => extended,
            _ => false,
        }
    }

    /// Whether the edge from FDF to res, at which receivers synchronise hard, is next.
    #[inline]
    pub(super) fn expects_res(&self) -> bool {
        self.field == Field::Res
    }

    /// Whether the next bit of a CAN FD frame comes after res.
    pub(super) const fn is_past_res(&self) -> bool {
        matches!(
            self.field,
            Field::Brs | Field::Esi | Field::Dlc | Field::Data | Field::StuffCount | Field::Crc
        )
    }

    pub(super) const fn is_fd(&self) -> bool {
        self.fd
    }

    pub(super) const fn crc_is_good(&self) -> bool {
        self.crc_good
    }

    /// How many bits from the next one on cannot end the frame, break a rule or change the rate,
    /// whatever their levels.
    #[inline]
    pub(super) fn quiet_bits(&self) -> u32 {
        let before_stuff_error = RUN.saturating_sub(self.run);
        match self.field {
            Field::BaseId | Field::ExtendedId => before_stuff_error.min(self.left - 1),
            // The CRC field of CAN FD may begin right after, with a fixed stuff bit.
            Field::Dlc if self.fd => before_stuff_error.min(self.left),
            Field::Data if self.fd => {
                let bytes = self.length - self.filled - 1;
                before_stuff_error.min(self.left + 8 * bytes as u32)
            }
            Field::Dlc | Field::Data => before_stuff_error,
            Field::Crc | Field::StuffCount if self.fd => self.until_fixed.min(self.left - 1),
            Field::Crc => before_stuff_error.min(self.left - 1),
            Field::Sof
            | Field::Rtr
            | Field::Ide
            | Field::ExtendedRtr
            | Field::Fdf
            | Field::R0
            | Field::Res
            | Field::Brs
            | Field::Esi
            | Field::StuffCount
            | Field::LastStuff => 0,
        }
    }

    /// Where the next bit lies.
    pub(super) const fn place(&self) -> Place {
        match self.field {
            Field::Sof | Field::BaseId | Field::Rtr | Field::ExtendedId | Field::ExtendedRtr => {
                Place::Arbitration
            }
            Field::Ide
            | Field::Fdf
            | Field::R0
            | Field::Res
            | Field::Brs
            | Field::Esi
            | Field::Dlc => Place::Control,
            Field::Data => Place::Data,
            Field::StuffCount | Field::Crc | Field::LastStuff => Place::Crc,
        }
    }

    /// The frame, once the CRC sequence is complete.
    pub(super) fn frame(&self) -> Option<Frame> {
        let id = if self.extended { Id::extended(self.id) } else { Id::base(self.id as u16) }?;
        let kind = match (self.fd, self.remote) {
            (true, _) => FrameKind::Fd { brs: self.brs, esi: self.esi },
            (false, true) => FrameKind::Remote,
            (false, false) => FrameKind::Data,
        };
        Frame::new(id, kind, self.dlc, self.data.get(..self.length)?).ok()
    }

    /// Takes the next bit.
    #[inline]
    pub(super) fn push(&mut self, level: Level) -> Step {
        self.push_run(level, 1).1
    }

    /// Takes up to `bits` bits of one level, as long as nothing but [`Step::Continue`] comes of
    /// them. Returns how many did, and what came of the one after them, which is taken, too.
    #[inline]
    pub(super) fn push_run(&mut self, level: Level, bits: u32) -> (u32, Step) {
        let mut done = 0;
        while done < bits {
            let (step, count) = if self.in_fd_crc() {
                (self.push_fd_crc(level), 1)
            } else if self.run == RUN {
                (self.push_stuff_bit(level), 1)
            } else {
                let run = if level == self.last { self.run } else { 0 };
                let count = (bits - done).min(RUN - run).min(self.left);
                self.run = run + count;
                self.last = level;
                if self.field != Field::Crc {
                    self.crc.push_run(level, count);
                }
                (self.take(level, count), count)
            };
            done += count;
            self.bits += count;
            if step != Step::Continue {
                return (done - 1, step);
            }
        }
        (bits, Step::Continue)
    }

    /// The bit after five equal ones.
    #[inline]
    fn push_stuff_bit(&mut self, level: Level) -> Step {
        if level == self.last {
            return Step::Error(ErrorKind::Stuff, self.place());
        }
        self.last = level;
        self.run = 1;
        self.stuff_bits += 1;
        self.crc.push_stuff_bit(level);
        if self.field == Field::LastStuff { Step::End } else { Step::Continue }
    }

    /// Takes bits of one level that are no stuff bits, at most those that the field has left.
    #[inline]
    fn take(&mut self, level: Level, count: u32) -> Step {
        self.value = (self.value << count) | ones_if(level, count);
        self.left -= count;
        if self.left > 0 { Step::Continue } else { self.finish() }
    }

    fn go(&mut self, field: Field, bits: u32) -> Step {
        self.field = field;
        self.left = bits;
        self.value = 0;
        Step::Continue
    }

    /// The last bit of a field is in.
    fn finish(&mut self) -> Step {
        let value = self.value;
        let set = value == 1;
        match self.field {
            Field::Sof => self.go(Field::BaseId, 11),
            Field::BaseId => {
                self.id = value;
                self.go(Field::Rtr, 1)
            }
            Field::Rtr => {
                self.remote = set;
                self.go(Field::Ide, 1)
            }
            Field::Ide => {
                self.extended = set;
                if set { self.go(Field::ExtendedId, 18) } else { self.go(Field::Fdf, 1) }
            }
            Field::ExtendedId => {
                self.id = (self.id << 18) | value;
                self.go(Field::ExtendedRtr, 1)
            }
            Field::ExtendedRtr => {
                self.remote = set;
                self.go(Field::Fdf, 1)
            }
            Field::Fdf => self.finish_fdf(set),
            Field::R0 => self.go(Field::Dlc, 4),
            Field::Res if set => Step::Exception,
            Field::Res => self.go(Field::Brs, 1),
            Field::Brs => {
                self.brs = set;
                self.go(Field::Esi, 1);
                if set { Step::DataRate } else { Step::Continue }
            }
            Field::Esi => {
                self.esi = set;
                self.go(Field::Dlc, 4)
            }
            Field::Dlc => self.finish_dlc(value),
            Field::Data => {
                self.data[self.filled] = value as u8;
                self.filled += 1;
                if self.filled < self.length { self.go(Field::Data, 8) } else { self.begin_crc() }
            }
            Field::StuffCount => {
                // The number of stuff bits modulo 8 in Gray code, then even parity.
                let count = self.stuff_bits % 8;
                let gray = count ^ (count >> 1);
                self.crc_good = value == ((gray << 1) | (gray.count_ones() % 2));
                self.go(Field::Crc, self.crc.width())
            }
            Field::Crc => {
                self.crc_good &= value == self.crc.value();
                if self.fd || self.run < RUN {
                    return Step::End;
                }
                self.go(Field::LastStuff, 1)
            }
            Field::LastStuff => Step::End,
        }
    }

    fn finish_fdf(&mut self, recessive: bool) -> Step {
        match (self.support, recessive) {
            (FdSupport::Enabled, true) => {
                self.fd = true;
                self.remote = false;
                self.go(Field::Res, 1)
            }
            (FdSupport::Tolerant, true) => Step::Exception,
            (FdSupport::None, true) | (_, false) => {
                self.crc.choose_classic();
                if self.extended { self.go(Field::R0, 1) } else { self.go(Field::Dlc, 4) }
            }
        }
    }

    fn finish_dlc(&mut self, value: u32) -> Step {
        self.dlc = value as u8;
        let kind = match (self.fd, self.remote) {
            (true, _) => FrameKind::Fd { brs: self.brs, esi: self.esi },
            (false, true) => FrameKind::Remote,
            (false, false) => FrameKind::Data,
        };
        self.length = Frame::data_length(kind, self.dlc);
        if self.fd {
            self.crc.choose_fd(self.length);
        }
        if self.length > 0 { self.go(Field::Data, 8) } else { self.begin_crc() }
    }

    fn begin_crc(&mut self) -> Step {
        self.until_fixed = 0;
        if self.fd && self.fd_crc == FdCrc::Iso {
            self.go(Field::StuffCount, 4)
        } else {
            self.go(Field::Crc, self.crc.width())
        }
    }

    /// A bit of the CRC field of a CAN FD frame: a fixed stuff bit before every four.
    fn push_fd_crc(&mut self, level: Level) -> Step {
        if self.until_fixed == 0 {
            if level == self.last {
                return Step::Error(ErrorKind::Form, Place::Crc);
            }
            self.last = level;
            self.until_fixed = 4;
            return Step::Continue;
        }
        self.until_fixed -= 1;
        self.last = level;
        if self.field == Field::StuffCount {
            self.crc.push_run(level, 1);
        }
        self.take(level, 1)
    }
}
