//! What frames carry.

use canbaud::wire::{Frame, FrameKind, Id};

use crate::rng::Rng;

/// The data bytes of a stream of frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Payload {
    /// Pseudo-random bytes.
    Random,
    /// All bits dominant.
    Zeros,
    /// All bits recessive.
    Ones,
    /// 3Ch over and over: with DLC 8 as many stuff bits as there can be.
    WorstStuffing,
    /// A number that counts up, big-endian in the last bytes, the others 0.
    Counter,
    /// These bytes.
    Fixed(Vec<u8>),
}

/// Identifier, kind and length of a stream of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameFormat {
    /// Identifier.
    pub id: Id,
    /// Kind.
    pub kind: FrameKind,
    /// Data length code, 0 to 15.
    pub dlc: u8,
}

/// Why frames of a format cannot carry a payload.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PayloadError {
    /// The DLC is out of range.
    #[error("dlc is {0}, allowed are 0 to 15")]
    Dlc(u8),
    /// Fixed bytes that do not have the length of the DLC.
    #[error("payload has {given} bytes where the DLC asks for {wanted}")]
    Length {
        /// Bytes given.
        given: usize,
        /// Bytes asked for.
        wanted: usize,
    },
}

impl Payload {
    /// Frame number `count` of a stream.
    ///
    /// # Errors
    /// [`PayloadError`] if format and payload do not fit together.
    pub fn frame(
        &self,
        format: FrameFormat,
        count: u64,
        rng: &mut Rng,
    ) -> Result<Frame, PayloadError> {
        let wanted = match format.dlc {
            0..=15 => Frame::data_length(format.kind, format.dlc),
            dlc => return Err(PayloadError::Dlc(dlc)),
        };
        let mut bytes = match self {
            Self::Zeros | Self::Counter => vec![0; wanted],
            Self::Ones => vec![0xFF; wanted],
            Self::WorstStuffing => vec![0x3C; wanted],
            Self::Random => (0..wanted).map(|_| rng.bits() as u8).collect(),
            Self::Fixed(bytes) => bytes.clone(),
        };
        if *self == Self::Counter {
            for (byte, counted) in bytes.iter_mut().rev().zip(count.to_le_bytes()) {
                *byte = counted;
            }
        }
        let given = bytes.len();
        Frame::new(format.id, format.kind, format.dlc, &bytes)
            .map_err(|_| PayloadError::Length { given, wanted })
    }
}
