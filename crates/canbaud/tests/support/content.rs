//! Frames with random and with structured content.

use super::prng::Prng;
use canbaud::wire::{Frame, FrameKind, Id};

/// Classic or CAN FD.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    Classic,
    Fd,
}

/// A frame of the family.
pub fn frame(prng: &mut Prng, family: Family) -> Frame {
    let kind = match family {
        Family::Classic if prng.chance(0.12) => FrameKind::Remote,
        Family::Classic => FrameKind::Data,
        Family::Fd => FrameKind::Fd { brs: prng.chance(0.75), esi: prng.chance(0.1) },
    };
    of_kind(prng, kind)
}

/// Another frame of the same kind.
pub fn like(prng: &mut Prng, other: &Frame) -> Frame {
    of_kind(prng, other.kind())
}

fn of_kind(prng: &mut Prng, kind: FrameKind) -> Frame {
    let dlc = match kind {
        FrameKind::Fd { .. } => prng.below(16) as u8,
        FrameKind::Data | FrameKind::Remote if prng.chance(0.1) => 9 + prng.below(7) as u8,
        FrameKind::Data | FrameKind::Remote => prng.below(9) as u8,
    };
    let id = id(prng);
    let data = payload(prng, Frame::data_length(kind, dlc));
    Frame::new(id, kind, dlc, &data).expect("a payload of the length that kind and DLC ask for")
}

fn id(prng: &mut Prng) -> Id {
    const LIMIT: u32 = 1 << 29;
    let raw = match prng.below(6) {
        0 => 0,
        1 => LIMIT - 1,
        2 => 0x1555_5555,
        3 => 1 << prng.below(29),
        _ => prng.below(u64::from(LIMIT)) as u32,
    };
    if prng.chance(0.5) { Id::Base((raw & 0x7FF) as u16) } else { Id::Extended(raw) }
}

fn payload(prng: &mut Prng, length: usize) -> Vec<u8> {
    let seed = prng.next();
    let byte = (seed & 0xFF) as u8;
    match (seed >> 8) % 8 {
        0 => vec![0; length],
        1 => vec![0xFF; length],
        2 => vec![prng.pick(&[0x55, 0xAA, 0x0F, 0x33]); length],
        3 => vec![byte; length],
        4 => (0..length).map(|i| byte.wrapping_add(i as u8)).collect(),
        _ => (0..length).map(|_| prng.below(256) as u8).collect(),
    }
}
