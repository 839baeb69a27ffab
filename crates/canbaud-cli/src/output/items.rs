//! Items made by hand for the tests of the outputs; a tick is a microsecond.

use canbaud::units::{Hertz, Timebase};
use canbaud::wire::{
    BusError, ErrorKind, FdCrc, Field, Frame, FrameKind, Id, Item, ItemKind, Received,
};

use super::stamp::Clock;

pub(super) fn microseconds() -> Clock {
    Clock { timebase: Timebase::from_frequency(Hertz::new(1_000_000).unwrap()), start_s: 0 }
}

pub(super) const BASE: Id = Id::Base(0x123);
pub(super) const EXTENDED: Id = Id::Extended(0x18FE_F100);

/// An acknowledged frame at tick `start`.
pub(super) fn frame(start: u64, id: Id, kind: FrameKind, dlc: u8, data: &[u8]) -> Item {
    let received = Received {
        frame: Frame::new(id, kind, dlc, data).unwrap(),
        crc: 0,
        fd_crc: kind.is_fd().then_some(FdCrc::Iso),
        acknowledged: true,
    };
    Item { start, end: start + 100, kind: ItemKind::Frame(received) }
}

pub(super) fn fd(start: u64, brs: bool, esi: bool, dlc: u8, data: &[u8]) -> Item {
    frame(start, BASE, FrameKind::Fd { brs, esi }, dlc, data)
}

pub(super) fn error(start: u64, kind: ErrorKind, field: Field, id: Option<Id>) -> Item {
    let error = BusError { kind, field, at: start + 70, id };
    Item { start, end: start + 90, kind: ItemKind::Error(error) }
}

pub(super) fn overload(start: u64) -> Item {
    Item { start, end: start + 14, kind: ItemKind::Overload }
}

/// One of everything, with its place in time as its number.
pub(super) fn everything() -> Vec<Item> {
    let bytes: Vec<u8> = (0..64).collect();
    vec![
        frame(1, BASE, FrameKind::Data, 0, &[]),
        frame(2, EXTENDED, FrameKind::Data, 8, &[0, 1, 2, 0xFD, 0xFE, 0xFF, 0x7F, 0x80]),
        frame(3, BASE, FrameKind::Data, 15, &bytes[..8]),
        frame(4, BASE, FrameKind::Remote, 0, &[]),
        frame(5, EXTENDED, FrameKind::Remote, 5, &[]),
        frame(6, BASE, FrameKind::Remote, 12, &[]),
        fd(7, false, false, 0, &[]),
        fd(8, true, false, 9, &bytes[..12]),
        fd(9, true, true, 15, &bytes),
        frame(10, Id::Base(0x7FF), FrameKind::Data, 1, &[0xA5]),
        frame(11, Id::Extended(0), FrameKind::Data, 1, &[0x5A]),
        error(12, ErrorKind::Stuff, Field::Data, Some(BASE)),
        error(13, ErrorKind::Crc, Field::Crc, Some(EXTENDED)),
        error(14, ErrorKind::Form, Field::EndOfFrame(3), Some(BASE)),
        error(15, ErrorKind::Acknowledge, Field::AckSlot, Some(BASE)),
        error(16, ErrorKind::Truncated, Field::Arbitration, None),
        error(17, ErrorKind::Disturbance, Field::Intermission, None),
        overload(18),
    ]
}
