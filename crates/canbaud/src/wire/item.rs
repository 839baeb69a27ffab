//! What the decoder reports: frames, and trouble as data.

use core::fmt;

use super::frame::{Frame, Id};

/// Where in a frame something happened [ISO 11898-1 field names].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Field {
    /// Start of frame to the end of the arbitration field.
    Arbitration,
    /// Control field: IDE or FDF to DLC.
    Control,
    /// Data field.
    Data,
    /// Stuff count and CRC sequence.
    Crc,
    /// CRC delimiter.
    CrcDelimiter,
    /// ACK slot.
    AckSlot,
    /// ACK delimiter.
    AckDelimiter,
    /// End of frame, bit 1 to 7.
    EndOfFrame(u8),
    /// Intermission and idle.
    Intermission,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arbitration => f.write_str("arbitration field"),
            Self::Control => f.write_str("control field"),
            Self::Data => f.write_str("data field"),
            Self::Crc => f.write_str("CRC field"),
            Self::CrcDelimiter => f.write_str("CRC delimiter"),
            Self::AckSlot => f.write_str("ACK slot"),
            Self::AckDelimiter => f.write_str("ACK delimiter"),
            Self::EndOfFrame(bit) => write!(f, "EOF bit {bit}"),
            Self::Intermission => f.write_str("intermission"),
        }
    }
}

/// Why a receiver would not have accepted what it saw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// Six equal bits where stuffing forbids them.
    Stuff,
    /// The CRC sequence or the stuff count does not match.
    Crc,
    /// A fixed-form bit has the wrong level.
    Form,
    /// The CRC is right, nobody acknowledged, and the sender's error flag follows.
    Acknowledge,
    /// A CAN FD frame switches to a data bit rate that is not known.
    DataRateUnknown,
    /// The recording begins or ends inside the frame.
    Truncated,
    /// Dominant levels that are no frame: a wake-up pulse, a disturbance, a stuck line.
    Disturbance,
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stuff => "stuff error",
            Self::Crc => "CRC error",
            Self::Form => "form error",
            Self::Acknowledge => "acknowledge error",
            Self::DataRateUnknown => "data bit rate unknown",
            Self::Truncated => "truncated",
            Self::Disturbance => "disturbance",
        })
    }
}

/// Which definition of CAN FD a frame follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FdCrc {
    /// ISO 11898-1:2015: with stuff count, CRC register started at 1 followed by zeros.
    Iso,
    /// The original Bosch CAN FD 1.0: no stuff count, CRC register started at 0.
    NonIso,
}

/// A frame that a receiving controller accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Received {
    /// The frame.
    pub frame: Frame,
    /// The CRC sequence as received (15, 17 or 21 bits).
    pub crc: u32,
    /// For a CAN FD frame, which CRC it carries.
    pub fd_crc: Option<FdCrc>,
    /// Whether the ACK slot was dominant.
    pub acknowledged: bool,
}

/// A frame that was destroyed, or no frame at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusError {
    /// What is wrong.
    pub kind: ErrorKind,
    /// Where.
    pub field: Field,
    /// When, in ticks.
    pub at: u64,
    /// The identifier, if all of it was read before.
    pub id: Option<Id>,
}

/// What one stretch of activity on the bus was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: items live on the stack, there is no box")]
pub enum ItemKind {
    /// A good frame: CRC right and no error up to the last but one bit of EOF.
    Frame(Received),
    /// A destroyed frame with its error flags, or a disturbance.
    Error(BusError),
    /// An overload frame.
    Overload,
}

/// What one stretch of activity on the bus was, and when.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Item {
    /// The first dominant edge (of SOF, for a frame), in ticks.
    pub start: u64,
    /// The end of the last EOF bit, or the last edge of a destroyed frame, in ticks.
    pub end: u64,
    /// What it was.
    pub kind: ItemKind,
}
