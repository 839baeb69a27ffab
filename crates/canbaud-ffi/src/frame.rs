//! CAN frames.

use crate::canbaud_status;
use canbaud::wire::{Frame, FrameKind, Id};

/// Kinds of frames.
#[repr(u8)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum canbaud_frame_kind {
    /// Classic data frame.
    DATA = 0,
    /// Classic remote frame.
    REMOTE = 1,
    /// CAN FD frame without bit rate switch.
    FD = 2,
    /// CAN FD frame with bit rate switch.
    FD_BRS = 3,
}

/// A CAN frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct canbaud_frame {
    /// Identifier: 11 bits, or 29 if `extended`.
    pub id: u32,
    /// 0: base format; 1: extended format.
    pub extended: u8,
    /// One of canbaud_frame_kind.
    pub kind: u8,
    /// Data length code, 0 to 15.
    pub dlc: u8,
    /// Error state indicator of a CAN FD frame: 0 or 1.
    pub esi: u8,
    /// Data; what is beyond the length that `dlc` stands for does not matter.
    pub data: [u8; 64],
}

pub(crate) fn from_c(frame: &canbaud_frame) -> Result<Frame, canbaud_status> {
    let kind = match frame.kind {
        0 => FrameKind::Data,
        1 => FrameKind::Remote,
        2 => FrameKind::Fd { brs: false, esi: frame.esi != 0 },
        3 => FrameKind::Fd { brs: true, esi: frame.esi != 0 },
        _ => return Err(canbaud_status::OUT_OF_RANGE),
    };
    let id = match frame.extended {
        0 => u16::try_from(frame.id).ok().and_then(Id::base),
        _ => Id::extended(frame.id),
    };
    let data = frame.data.get(..Frame::data_length(kind, frame.dlc)).unwrap_or(&[]);
    id.and_then(|id| Frame::new(id, kind, frame.dlc, data).ok()).ok_or(canbaud_status::OUT_OF_RANGE)
}

pub(crate) fn to_c(frame: &Frame) -> canbaud_frame {
    let (kind, esi) = match frame.kind() {
        FrameKind::Data => (canbaud_frame_kind::DATA, false),
        FrameKind::Remote => (canbaud_frame_kind::REMOTE, false),
        FrameKind::Fd { brs: false, esi } => (canbaud_frame_kind::FD, esi),
        FrameKind::Fd { brs: true, esi } => (canbaud_frame_kind::FD_BRS, esi),
    };
    let mut data = [0; 64];
    data.iter_mut().zip(frame.data()).for_each(|(to, from)| *to = *from);
    canbaud_frame {
        id: frame.id().raw(),
        extended: u8::from(frame.id().is_extended()),
        kind: kind as u8,
        dlc: frame.dlc(),
        esi: u8::from(esi),
        data,
    }
}
