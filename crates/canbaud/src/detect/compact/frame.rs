//! A classic frame out of runs of bits [ISO 11898-1, 10.4].

use crate::wire::Level;

/// x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1, without the highest term.
const CRC_15: u16 = 0x4599;
const CRC_BITS: u32 = 15;
/// Equal bits after which a stuff bit follows.
const STUFF: u32 = 5;
/// An error flag has at least six bits.
const FLAG: u32 = 6;
/// More bits of a run change nothing: they are wrong.
const RUN_MAX: u32 = 8;
/// Bits at which something is decided, in base and in extended format; SOF is 0.
const IDE: u32 = 13;
const FDF_BASE: u32 = 14;
const DLC_END_BASE: u32 = 18;
const RTR_EXTENDED: u32 = 32;
const FDF_EXTENDED: u32 = 33;
const DLC_END_EXTENDED: u32 = 38;

/// Reads from SOF to the acknowledge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader {
    place: Place,
    crc: u16,
    /// Bits without stuff bits.
    at: u32,
    /// The last bits, the latest lowest.
    recent: u32,
    /// Of all bits.
    print: u32,
    /// Equal bits in a row.
    equal: u32,
    last: Level,
    remote: bool,
    format: Format,
    /// Where the field ends that is to be looked at next.
    next: u32,
}

/// As much as is known about the fields in front of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Base,
    Extended,
    /// They are read.
    Known,
}

/// What comes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Stuffed,
    /// Five equal bits ended the CRC.
    LastStuffBit,
    /// The CRC delimiter, or the gap if nobody acknowledged.
    Delimiter,
    Acknowledge,
    /// Nobody acknowledged: the sender's error flag, or the gap.
    Flag,
    /// Only the gap may follow.
    End,
    /// This is no classic frame.
    Wrong,
}

impl Reader {
    pub(super) const fn new() -> Self {
        Self {
            place: Place::Stuffed,
            crc: 0,
            at: 0,
            recent: 0,
            print: 0,
            equal: 0,
            last: Level::Recessive,
            remote: false,
            format: Format::Base,
            next: IDE,
        }
    }

    /// Takes `count` bits of one level.
    pub(super) fn take(&mut self, level: Level, count: u32) {
        if self.place == Place::Flag && count >= FLAG {
            self.place = Place::End;
            return;
        }
        for _ in 0..count.min(RUN_MAX) {
            self.place = match (self.place, level) {
                (Place::Stuffed, _) => self.stuffed(level),
                (Place::LastStuffBit, _) if level != self.last => Place::Delimiter,
                (Place::Delimiter, Level::Recessive) => Place::Acknowledge,
                (Place::Acknowledge, Level::Dominant) => Place::End,
                (Place::Acknowledge, Level::Recessive) => Place::Flag,
                _ => Place::Wrong,
            };
        }
    }

    /// Whether the frame is complete; the gap behind it may hold the last bits of the CRC.
    pub(super) fn ends_in_gap(&mut self) -> bool {
        for _ in 0..STUFF {
            if matches!(self.place, Place::Stuffed | Place::LastStuffBit) {
                self.take(Level::Recessive, 1);
            }
        }
        matches!(self.place, Place::Delimiter | Place::End)
    }

    pub(super) fn is_wrong(&self) -> bool {
        self.place == Place::Wrong
    }

    /// What two frames hardly ever have in common.
    pub(super) const fn print(&self) -> u32 {
        self.print
    }

    pub(super) const fn crc_is_right(&self) -> bool {
        self.crc == 0
    }

    fn stuffed(&mut self, level: Level) -> Place {
        let was_full = self.equal == STUFF;
        self.equal = if level == self.last { self.equal + 1 } else { 1 };
        self.last = level;
        if was_full {
            // The stuff bit has to be the other level.
            return if self.equal == 1 { Place::Stuffed } else { Place::Wrong };
        }
        let bit = u32::from(level == Level::Recessive);
        self.recent = self.recent << 1 | bit;
        self.print = self.print.wrapping_mul(31).wrapping_add(bit);
        let carry = u32::from(self.crc >> 14) & 1 ^ bit;
        self.crc = (self.crc << 1 & 0x7FFF) ^ if carry == 1 { CRC_15 } else { 0 };
        self.at += 1;
        if self.at <= self.next { Place::Stuffed } else { self.field() }
    }

    /// Looks at the field that ends with the bit `next`, and says where the next one ends.
    fn field(&mut self) -> Place {
        let bit = |behind: u32| self.recent >> behind & 1 == 1;
        let right = match (self.next, self.format) {
            (IDE, _) => {
                self.format = if bit(0) { Format::Extended } else { Format::Base };
                self.remote = bit(1);
                self.next = if bit(0) { RTR_EXTENDED } else { FDF_BASE };
                // In extended format SRR is where RTR is in base format; it is recessive.
                self.remote || self.format == Format::Base
            }
            (RTR_EXTENDED, Format::Extended) => {
                self.remote = bit(0);
                self.next = FDF_EXTENDED;
                true
            }
            // Recessive, it would be a CAN FD frame.
            (FDF_BASE, Format::Base) => {
                self.next = DLC_END_BASE;
                !bit(0)
            }
            (FDF_EXTENDED, Format::Extended) => {
                self.next = DLC_END_EXTENDED;
                !bit(0)
            }
            (DLC_END_BASE, Format::Base) | (DLC_END_EXTENDED, Format::Extended) => {
                let bytes = if self.remote { 0 } else { u32::min(self.recent & 15, 8) };
                self.next += 8 * bytes + CRC_BITS;
                self.format = Format::Known;
                true
            }
            // The end of the CRC. A last stuff bit may follow.
            _ if self.equal == STUFF => return Place::LastStuffBit,
            _ => return Place::Delimiter,
        };
        if right { Place::Stuffed } else { Place::Wrong }
    }
}
