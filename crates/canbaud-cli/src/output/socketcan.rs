//! Frames and errors in the terms of Linux SocketCAN, which candump logs and pcapng share.
//!
//! Source: `linux/can.h` and `linux/can/error.h`.

use canbaud::wire::{BusError, ErrorKind, Field, Frame, FrameKind, ItemKind, Received};

/// The frame is extended.
pub(super) const EFF_FLAG: u32 = 0x8000_0000;
/// The frame is a remote frame.
pub(super) const RTR_FLAG: u32 = 0x4000_0000;
/// The frame is an error message; its identifier is a set of error classes.
pub(super) const ERR_FLAG: u32 = 0x2000_0000;

/// Error class: protocol violation, told in data bytes 2 and 3.
const ERR_PROT: u32 = 0x08;
/// Error class: no acknowledge.
const ERR_ACK: u32 = 0x20;
/// Error class: bus error. python-can takes a line for an error frame only with this class.
const ERR_BUSERROR: u32 = 0x80;

const FD_BRS: u8 = 0x01;
const FD_ESI: u8 = 0x02;
/// Marks a CAN FD frame whatever its length; current kernels always set it.
const FD_FDF: u8 = 0x04;

/// One item as SocketCAN would deliver it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Message<'a> {
    /// A classic data frame.
    Data(&'a Frame),
    /// A classic remote frame.
    Remote(&'a Frame),
    /// A CAN FD frame with its flags.
    Fd(&'a Frame, u8),
    /// An error frame: identifier with the error flag, and the data.
    Error(u32, [u8; 8]),
}

impl<'a> Message<'a> {
    pub(super) fn of(item: &'a ItemKind) -> Self {
        match item {
            ItemKind::Frame(Received { frame, .. }) => match frame.kind() {
                FrameKind::Data => Self::Data(frame),
                FrameKind::Remote => Self::Remote(frame),
                FrameKind::Fd { brs, esi } => {
                    let brs = if brs { FD_BRS } else { 0 };
                    let esi = if esi { FD_ESI } else { 0 };
                    Self::Fd(frame, FD_FDF | brs | esi)
                }
            },
            ItemKind::Error(error) => error_message(error),
            ItemKind::Overload => {
                Self::Error(ERR_FLAG | ERR_PROT | ERR_BUSERROR, protocol(0x20, 0x12))
            }
        }
    }
}

fn error_message(error: &BusError) -> Message<'static> {
    let class = match error.kind {
        ErrorKind::Acknowledge => ERR_PROT | ERR_BUSERROR | ERR_ACK,
        _ => ERR_PROT | ERR_BUSERROR,
    };
    let violation = match error.kind {
        ErrorKind::Form => 0x02,
        ErrorKind::Stuff => 0x04,
        // A CRC error has no bit of its own: its location tells it.
        _ => 0,
    };
    Message::Error(ERR_FLAG | class, protocol(violation, location(error.field)))
}

/// The data of an error message: violation in byte 2, location in byte 3.
const fn protocol(violation: u8, location: u8) -> [u8; 8] {
    [0, 0, violation, location, 0, 0, 0, 0]
}

/// `CAN_ERR_PROT_LOC_*`; 0 (unspecified) where the field covers several of them.
const fn location(field: Field) -> u8 {
    match field {
        Field::Data => 0x0A,
        Field::Crc => 0x08,
        Field::CrcDelimiter => 0x18,
        Field::AckSlot => 0x19,
        Field::AckDelimiter => 0x1B,
        Field::EndOfFrame(_) => 0x1A,
        Field::Intermission => 0x12,
        _ => 0,
    }
}
