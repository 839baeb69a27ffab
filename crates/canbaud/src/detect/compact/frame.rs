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
/// The last bit before the data: the last of the DLC, in base and in extended format; SOF is 0.
const DLC_END_BASE: u32 = 18;
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
    /// Equal bits in a row.
    equal: u32,
    last: Level,
    remote: bool,
    dlc_end: u32,
    crc_end: u32,
}

/// What comes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Stuffed,
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
            equal: 0,
            last: Level::Recessive,
            remote: false,
            dlc_end: DLC_END_BASE,
            crc_end: u32::MAX,
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
            if self.place == Place::Stuffed {
                self.take(Level::Recessive, 1);
            }
        }
        matches!(self.place, Place::Delimiter | Place::End)
    }

    pub(super) const fn crc_is_right(&self) -> bool {
        self.crc == 0
    }

    fn stuffed(&mut self, level: Level) -> Place {
        let was_full = self.equal == STUFF;
        self.equal = if level == self.last { self.equal + 1 } else { 1 };
        self.last = level;
        if was_full {
            // The stuff bit has to be the other level; a last one may follow the CRC.
            return match (self.equal, self.at > self.crc_end) {
                (1, false) => Place::Stuffed,
                (1, true) => Place::Delimiter,
                _ => Place::Wrong,
            };
        }
        let bit = u32::from(level == Level::Recessive);
        self.recent = self.recent << 1 | bit;
        let carry = u32::from(self.crc >> 14) & 1 ^ bit;
        self.crc = (self.crc << 1 & 0x7FFF) ^ if carry == 1 { CRC_15 } else { 0 };
        let at = self.at;
        self.at += 1;
        self.field(at)
    }

    /// Looks at the field that ends with the bit `at`.
    fn field(&mut self, at: u32) -> Place {
        let is_extended = self.dlc_end == DLC_END_EXTENDED;
        let right = match at {
            // SOF.
            0 => self.recent & 1 == 0,
            // RTR and IDE, or SRR and IDE.
            13 => {
                self.remote = self.recent & 2 == 2;
                if self.recent & 1 == 1 {
                    self.dlc_end = DLC_END_EXTENDED;
                }
                // SRR is recessive.
                self.recent & 3 != 1
            }
            // Recessive, it is FDF.
            14 if !is_extended => self.recent & 1 == 0,
            32 if is_extended => {
                self.remote = self.recent & 1 == 1;
                true
            }
            33 if is_extended => self.recent & 1 == 0,
            _ => true,
        };
        if at == self.dlc_end {
            let bytes = if self.remote { 0 } else { u32::min(self.recent & 15, 8) };
            self.crc_end = at + 8 * bytes + CRC_BITS;
        }
        match (right, at == self.crc_end && self.equal < STUFF) {
            (false, _) => Place::Wrong,
            (true, true) => Place::Delimiter,
            (true, false) => Place::Stuffed,
        }
    }
}
