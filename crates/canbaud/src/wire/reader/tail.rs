//! CRC delimiter, ACK and EOF where all bits are nominal and counted.

use super::super::item::{ErrorKind, Field};
use super::super::line::Level;
use super::{Failure, Reader};

/// Bits from the CRC delimiter to the last bit of EOF.
const TAIL_BITS: u32 = 10;

/// What the tail of an accepted frame said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tail {
    pub(super) ack: Level,
    /// The last bit of EOF was dominant: an overload condition, the frame is valid.
    pub(super) overload: bool,
}

impl Reader<'_> {
    /// Reads the tail; the first `extra` bits of it, of `level`, belong to the run before.
    pub(super) fn tail(&mut self, extra: u32, level: Level) -> Result<Tail, Failure> {
        let mut seen = 0;
        let mut ack = Level::Recessive;
        let (mut bits, mut level) = (extra, level);
        loop {
            let end = TAIL_BITS.min(seen + bits);
            if level == Level::Dominant {
                for position in seen..end {
                    match position {
                        1 => ack = Level::Dominant,
                        9 => return Ok(Tail { ack, overload: true }),
                        _ => return Err(self.tail_failure(position, ack)),
                    }
                }
            }
            seen = end;
            if seen == TAIL_BITS {
                return Ok(Tail { ack, overload: false });
            }
            let Some((ticks, next)) = self.activity.run(self.next) else {
                // The last bit of EOF does not matter to a receiver.
                return if seen == TAIL_BITS - 1 {
                    Ok(Tail { ack, overload: false })
                } else {
                    Err(self.fail(ErrorKind::Truncated, position_field(seen)))
                };
            };
            bits = self.sync.bits(ticks, next);
            level = next;
            self.next += 1;
        }
    }

    /// A dominant bit at `position` of the tail.
    pub(super) fn tail_failure(&self, position: u32, ack: Level) -> Failure {
        let kind = match position {
            _ if !self.crc_right => ErrorKind::Crc,
            2 if ack == Level::Recessive => ErrorKind::Acknowledge,
            _ => ErrorKind::Form,
        };
        Failure { kind, field: position_field(position), run: self.next.saturating_sub(1) }
    }
}

/// The field of the bit at `position`, counted from the CRC delimiter.
pub(super) const fn position_field(position: u32) -> Field {
    match position {
        0 => Field::CrcDelimiter,
        1 => Field::AckSlot,
        2 => Field::AckDelimiter,
        _ => Field::EndOfFrame((position - 2) as u8),
    }
}
