//! `struct can_frame` and `struct canfd_frame` as bytes [linux/can.h].

use canbaud::wire::{Frame, FrameKind, Id};

/// Bytes of `struct can_frame`.
const CLASSIC: usize = 16;
/// Bytes of `struct canfd_frame`.
const FD: usize = 72;
const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
const ERROR: u32 = 0x2000_0000;
const BRS: u8 = 1;
const ESI: u8 = 2;

/// What came from a socket.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "one of these lives at a time")]
pub(crate) enum Raw {
    /// A frame.
    Frame(Frame),
    /// An error frame of Linux: class bits and data.
    Error {
        /// `CAN_ERR_*`.
        class: u32,
        /// The data.
        data: [u8; 8],
    },
}

/// Reads a frame; `None` if the bytes are none.
pub(crate) fn parse(bytes: &[u8]) -> Option<Raw> {
    let id = u32::from_ne_bytes(*bytes.first_chunk()?);
    let &[length, flags, _, raw_dlc] = bytes.get(4..8)?.first_chunk()?;
    let data = bytes.get(8..)?;
    if id & ERROR != 0 {
        return Some(Raw::Error { class: id & 0x1FFF_FFFF, data: *data.first_chunk()? });
    }
    let kind = match bytes.len() {
        FD => FrameKind::Fd { brs: flags & BRS != 0, esi: flags & ESI != 0 },
        CLASSIC if id & REMOTE != 0 => FrameKind::Remote,
        CLASSIC => FrameKind::Data,
        _ => return None,
    };
    let identifier = if id & EXTENDED != 0 {
        Id::extended(id & 0x1FFF_FFFF)?
    } else {
        Id::base(u16::try_from(id & 0x1FFF_FFFF).ok()?)?
    };
    let dlc = match (kind, length) {
        (FrameKind::Fd { .. }, length) => dlc_of(length)?,
        (_, 8) if (9..=15).contains(&raw_dlc) => raw_dlc,
        (_, 0..=8) => length,
        _ => return None,
    };
    let data = data.get(..Frame::data_length(kind, dlc))?;
    Frame::new(identifier, kind, dlc, data).ok().map(Raw::Frame)
}

/// The least DLC that holds `length` bytes; `None` above 64.
fn dlc_of(length: u8) -> Option<u8> {
    let kind = FrameKind::Fd { brs: false, esi: false };
    (0..=15).find(|dlc| Frame::data_length(kind, *dlc) >= usize::from(length))
}

/// A frame as the kernel takes it.
pub(crate) fn encode(frame: &Frame) -> Vec<u8> {
    let mut id = frame.id().raw();
    if frame.id().is_extended() {
        id |= EXTENDED;
    }
    let (size, flags) = match frame.kind() {
        FrameKind::Remote => {
            id |= REMOTE;
            (CLASSIC, 0)
        }
        FrameKind::Data => (CLASSIC, 0),
        FrameKind::Fd { brs, esi } => (FD, if brs { BRS } else { 0 } | if esi { ESI } else { 0 }),
    };
    let length = match frame.kind() {
        FrameKind::Remote => frame.dlc().min(8),
        // At most 64.
        FrameKind::Data | FrameKind::Fd { .. } => u8::try_from(frame.data().len()).unwrap_or(64),
    };
    let raw_dlc = if size == CLASSIC && frame.dlc() > 8 { frame.dlc() } else { 0 };
    let mut bytes = id.to_ne_bytes().to_vec();
    bytes.extend([length, flags, 0, raw_dlc]);
    bytes.extend(frame.data());
    bytes.resize(size, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    #[cfg(target_endian = "little")]
    fn bytes_of_the_kernel_are_these_frames() {
        let classic = [0x23, 1, 0, 0, 2, 0, 0, 0, 0xDE, 0xAD, 0, 0, 0, 0, 0, 0];
        let want = Frame::new(Id::Base(0x123), FrameKind::Data, 2, &[0xDE, 0xAD]).unwrap();
        assert_eq!(parse(&classic), Some(Raw::Frame(want)));
        assert_eq!(encode(&want), classic);
        let mut fd = [0; 72];
        fd[..9].copy_from_slice(&[0x78, 0x56, 0x34, 0x92, 12, 0x05, 0, 0, 0xAA]);
        let Some(Raw::Frame(frame)) = parse(&fd) else { panic!() };
        assert_eq!(frame.id(), Id::Extended(0x1234_5678));
        assert_eq!(frame.kind(), FrameKind::Fd { brs: true, esi: false });
        assert_eq!((frame.dlc(), frame.data()[0]), (9, 0xAA));
        // 20000288#0000040000000006 of candump.
        let error = [0x88, 2, 0, 0x20, 8, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 6];
        assert_eq!(
            parse(&error),
            Some(Raw::Error { class: 0x288, data: [0, 0, 4, 0, 0, 0, 0, 6] })
        );
    }

    #[test]
    fn what_is_no_frame_is_none() {
        assert_eq!(parse(&[]), None);
        assert_eq!(parse(&[0; 15]), None);
        // 2048 without the flag of the extended format, and a length of 9.
        let mut bytes = [0; 16];
        bytes[..4].copy_from_slice(&0x800_u32.to_ne_bytes());
        assert_eq!(parse(&bytes), None);
        bytes = [0; 16];
        bytes[4] = 9;
        assert_eq!(parse(&bytes), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_without_panic_and_frames_come_back(
            bytes in prop::collection::vec(any::<u8>(), 0..80),
        ) {
            if let Some(Raw::Frame(frame)) = parse(&bytes) {
                prop_assert_eq!(parse(&encode(&frame)), Some(Raw::Frame(frame)));
            }
        }
    }
}
