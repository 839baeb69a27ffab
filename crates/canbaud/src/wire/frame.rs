//! Frames as a user knows them.

use core::fmt;

/// A CAN identifier, base (11 bit) or extended (29 bit) [ISO 11898-1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Id {
    /// Base format, 0 to 0x7FF.
    Base(u16),
    /// Extended format, 0 to 0x1FFF_FFFF.
    Extended(u32),
}

impl Id {
    /// A base identifier; `None` above 0x7FF.
    #[must_use]
    pub const fn base(id: u16) -> Option<Self> {
        if id > 0x7FF { None } else { Some(Self::Base(id)) }
    }

    /// An extended identifier; `None` above 0x1FFF_FFFF.
    #[must_use]
    pub const fn extended(id: u32) -> Option<Self> {
        if id > 0x1FFF_FFFF { None } else { Some(Self::Extended(id)) }
    }

    /// The identifier as a number, without its format.
    #[must_use]
    pub const fn raw(self) -> u32 {
        match self {
            Self::Base(id) => id as u32,
            Self::Extended(id) => id,
        }
    }

    /// Whether this is the 29-bit format.
    #[must_use]
    pub const fn is_extended(self) -> bool {
        matches!(self, Self::Extended(_))
    }
}

impl fmt::Display for Id {
    /// Three hexadecimal digits for a base identifier, eight for an extended one, as candump does.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base(id) => write!(f, "{id:03X}"),
            Self::Extended(id) => write!(f, "{id:08X}"),
        }
    }
}

/// The kind of a frame [ISO 11898-1: CBFF, CEFF, FBFF, FEFF].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FrameKind {
    /// Classic data frame.
    Data,
    /// Classic remote frame: carries a DLC but no data.
    Remote,
    /// CAN FD data frame.
    Fd {
        /// Bit rate switch: the data phase runs at the data bit rate.
        brs: bool,
        /// Error state indicator: the sender is error passive.
        esi: bool,
    },
}

impl FrameKind {
    /// Whether this is a CAN FD frame.
    #[must_use]
    pub const fn is_fd(self) -> bool {
        matches!(self, Self::Fd { .. })
    }
}

/// Why [`Frame::new`] refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// The identifier is above 0x7FF or 0x1FFF_FFFF.
    Id(u32),
    /// The DLC is above 15.
    Dlc(u8),
    /// The number of data bytes is not what kind and DLC ask for.
    Length {
        /// Bytes given.
        given: usize,
        /// Bytes that kind and DLC ask for.
        wanted: usize,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(id) => write!(f, "identifier {id:X} outside 0 to 7FF, extended 0 to 1FFFFFFF"),
            Self::Dlc(dlc) => write!(f, "DLC {dlc} outside 0 to 15"),
            Self::Length { given, wanted } => {
                write!(f, "{given} data bytes where kind and DLC ask for {wanted}")
            }
        }
    }
}

impl core::error::Error for FrameError {}

/// One valid frame: identifier, kind, DLC as sent (0 to 15) and data.
///
/// ```
/// use canbaud::wire::{Frame, FrameKind, Id};
/// let frame = Frame::new(Id::Base(0x123), FrameKind::Data, 2, &[0xDE, 0xAD]).unwrap();
/// assert_eq!(frame.data(), &[0xDE, 0xAD]);
/// // A remote frame has a DLC and no data; DLC 9 to 15 of a classic frame mean 8 bytes.
/// assert!(Frame::new(Id::Base(1), FrameKind::Remote, 8, &[]).is_ok());
/// assert!(Frame::new(Id::Base(1), FrameKind::Data, 15, &[0; 8]).is_ok());
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frame {
    id: Id,
    kind: FrameKind,
    dlc: u8,
    data: [u8; 64],
}

impl Frame {
    /// A frame; `data` must have the length that `kind` and `dlc` ask for
    /// ([`Frame::data_length`]).
    ///
    /// # Errors
    /// [`FrameError`] if the identifier or the DLC is out of range or the length differs.
    pub fn new(id: Id, kind: FrameKind, dlc: u8, data: &[u8]) -> Result<Self, FrameError> {
        let id_max = if id.is_extended() { 0x1FFF_FFFF } else { 0x7FF };
        if id.raw() > id_max {
            return Err(FrameError::Id(id.raw()));
        }
        if dlc > 15 {
            return Err(FrameError::Dlc(dlc));
        }
        let wanted = Self::data_length(kind, dlc);
        let mut bytes = [0; 64];
        match bytes.get_mut(..wanted) {
            Some(room) if data.len() == wanted => room.copy_from_slice(data),
            _ => return Err(FrameError::Length { given: data.len(), wanted }),
        }
        Ok(Self { id, kind, dlc, data: bytes })
    }

    /// A classic data frame of eight bytes; only the lower 11 bits of `id` count.
    pub(crate) const fn of_eight(id: u16, bytes: [u8; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = bytes;
        let mut data = [0; 64];
        (data[0], data[1], data[2], data[3]) = (a, b, c, d);
        (data[4], data[5], data[6], data[7]) = (e, f, g, h);
        Self { id: Id::Base(id & 0x7FF), kind: FrameKind::Data, dlc: 8, data }
    }

    /// Data bytes that a frame of `kind` with `dlc` carries [ISO 11898-1, coding of the DLC].
    #[must_use]
    pub const fn data_length(kind: FrameKind, dlc: u8) -> usize {
        match (kind, dlc) {
            (FrameKind::Remote, _) => 0,
            (_, 0..=8) => dlc as usize,
            (FrameKind::Data, _) => 8,
            (FrameKind::Fd { .. }, 9) => 12,
            (FrameKind::Fd { .. }, 10) => 16,
            (FrameKind::Fd { .. }, 11) => 20,
            (FrameKind::Fd { .. }, 12) => 24,
            (FrameKind::Fd { .. }, 13) => 32,
            (FrameKind::Fd { .. }, 14) => 48,
            (FrameKind::Fd { .. }, _) => 64,
        }
    }

    /// The identifier.
    #[must_use]
    pub const fn id(&self) -> Id {
        self.id
    }

    /// The kind.
    #[must_use]
    pub const fn kind(&self) -> FrameKind {
        self.kind
    }

    /// The data length code as it is on the wire, 0 to 15.
    #[must_use]
    pub const fn dlc(&self) -> u8 {
        self.dlc
    }

    /// The data.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.data.get(..Self::data_length(self.kind, self.dlc)).unwrap_or(&[])
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Frame")
            .field("id", &format_args!("{}", self.id))
            .field("kind", &self.kind)
            .field("dlc", &self.dlc)
            .field("data", &format_args!("{:02X?}", self.data()))
            .finish()
    }
}
