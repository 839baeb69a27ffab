//! CRC delimiter, ACK and EOF.
//!
//! The acknowledge comes from other nodes, a propagation delay away and by their own clocks, and
//! the delimiter of a CAN FD frame is partly data rate, partly nominal: so edges are judged by
//! time here, not counted.

use super::super::clock::BIT_Q20;
use super::super::item::{ErrorKind, Field};
use super::super::line::Level;
use super::{Failure, Reader};

/// What the tail of an accepted frame said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tail {
    pub(super) ack: Level,
    /// The last bit of EOF was dominant: an overload condition, the frame is valid.
    pub(super) overload: bool,
}

/// How exact the edges of the tail must be, in nominal bits times 2^20.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TailRule {
    /// The shortest CRC delimiter.
    delimiter_min: i32,
    /// The latest start of an acknowledge behind the CRC sequence.
    ack_start_max: i32,
    /// The longest acknowledge.
    ack_max: i32,
}

impl TailRule {
    /// CAN FD: up to two bits of delimiter, up to two bits of acknowledge, and delays.
    pub(super) const FD: Self =
        Self { delimiter_min: 0, ack_start_max: 7 * BIT_Q20 / 2, ack_max: 7 * BIT_Q20 / 2 };

    /// Classic: one bit each, and delays of up to half of one; `tick` is one tick.
    pub(super) const fn classic(tick: i32) -> Self {
        Self {
            delimiter_min: 4 * BIT_Q20 / 10,
            ack_start_max: 16 * BIT_Q20 / 10 + tick / 2,
            ack_max: 15 * BIT_Q20 / 10 + tick / 2,
        }
    }
}

/// Index of the ACK delimiter, counted from the CRC delimiter.
const ACK_DELIMITER: u32 = 2;

impl Reader<'_> {
    /// Reads the tail; of the last run, which was at `level`, `behind_q20` nominal bits (times
    /// 2^20) lie behind the CRC sequence.
    pub(super) fn tail(
        &mut self,
        behind_q20: i32,
        level: Level,
        rule: TailRule,
    ) -> Result<Tail, Failure> {
        let behind = match level {
            Level::Recessive => behind_q20,
            Level::Dominant if behind_q20 > BIT_Q20 / 2 => return Err(self.tail_failure(0)),
            Level::Dominant => self.tail_run_q20(Level::Recessive)?,
        };
        if self.next > self.activity.runs.len() {
            // Nobody acknowledged: CRC delimiter and ACK slot are part of the gap.
            return self.behind_ack(Level::Recessive, behind - 2 * BIT_Q20);
        }
        let dominant = self.tail_run_q20(Level::Dominant)?;
        if behind < rule.delimiter_min {
            return Err(self.tail_failure(0));
        }
        let start = ((behind + BIT_Q20 / 2) >> 20).max(0) as u32;
        if behind > rule.ack_start_max {
            return Err(self.tail_failure(start.clamp(ACK_DELIMITER, 8)));
        }
        if dominant > rule.ack_max {
            // Not an acknowledge but an error flag; how late it starts tells what was missed.
            let late = start >= ACK_DELIMITER;
            return Err(match late {
                true => self.tail_failure(ACK_DELIMITER),
                false => self.form_failure(ACK_DELIMITER),
            });
        }
        let gap = self.tail_run_q20(Level::Recessive)?;
        self.behind_ack(Level::Dominant, gap)
    }

    /// The recessive run from the ACK delimiter on.
    fn behind_ack(&self, ack: Level, gap_q20: i32) -> Result<Tail, Failure> {
        let ended_by_edge = self.next <= self.activity.runs.len();
        let bits = ((gap_q20 + BIT_Q20 / 2) >> 20).max(0) as u32;
        // ACK delimiter and seven bits of EOF; a receiver does not mind the last one. What the
        // recording does not show any more is not held against the frame.
        match (bits, ended_by_edge) {
            (8.., _) | (_, false) => Ok(Tail { ack, overload: false }),
            (7, true) => Ok(Tail { ack, overload: true }),
            (bits, true) if ack == Level::Recessive => Err(self.tail_failure(ACK_DELIMITER + bits)),
            (bits, true) => Err(self.form_failure(ACK_DELIMITER + bits)),
        }
    }

    /// The next run, which must be of `level`, in nominal bits times 2^20.
    pub(super) fn tail_run_q20(&mut self, level: Level) -> Result<i32, Failure> {
        match self.activity.run(self.next) {
            Some((ticks, found)) if found == level => {
                self.next += 1;
                Ok(self.rates.nominal.bits_q20(ticks))
            }
            _ => Err(self.fail(ErrorKind::Truncated, Field::AckSlot)),
        }
    }

    /// A dominant bit at `position` of the tail, nobody having acknowledged before.
    fn tail_failure(&self, position: u32) -> Failure {
        let kind = match position {
            _ if !self.crc_right => ErrorKind::Crc,
            ACK_DELIMITER => ErrorKind::Acknowledge,
            _ => ErrorKind::Form,
        };
        self.tail_failure_of(kind, position)
    }

    /// A dominant bit at `position` of the tail, behind an acknowledge.
    fn form_failure(&self, position: u32) -> Failure {
        let kind = if self.crc_right { ErrorKind::Form } else { ErrorKind::Crc };
        self.tail_failure_of(kind, position)
    }

    fn tail_failure_of(&self, kind: ErrorKind, position: u32) -> Failure {
        Failure { kind, field: position_field(position), run: self.next.saturating_sub(1) }
    }
}

/// The field of the bit at `position`, counted from the CRC delimiter.
const fn position_field(position: u32) -> Field {
    match position {
        0 => Field::CrcDelimiter,
        1 => Field::AckSlot,
        2 => Field::AckDelimiter,
        3..=9 => Field::EndOfFrame((position - 2) as u8),
        _ => Field::Intermission,
    }
}
