//! Calls every part of canbaud with values that no compiler can foresee.
//!
//! A firmware that links this has all features of the library in it: what is not in the linked
//! file, no feature needs.
#![no_std]
#![forbid(unsafe_code)]

mod buses;
mod edges;
mod protocols;
mod text;
mod timing;

use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud::wire::{Frame, FrameKind, Id};

/// Values out of bytes that come from outside.
pub(crate) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Source<'_> {
    fn byte(&mut self) -> u8 {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at = if self.at + 1 < self.bytes.len() { self.at + 1 } else { 0 };
        byte
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    fn time(&mut self) -> Micros {
        Micros(u64::from(self.word()))
    }

    fn bitrate(&mut self) -> Bitrate {
        Bitrate::new(self.word()).unwrap_or(RATE)
    }

    fn clock(&mut self) -> Hertz {
        Hertz::new(u64::from(self.word())).unwrap_or(CLOCK)
    }

    fn frame(&mut self) -> Option<Frame> {
        let kind = match self.byte() % 3 {
            0 => FrameKind::Data,
            1 => FrameKind::Remote,
            _ => FrameKind::Fd { brs: self.byte() & 1 == 1, esi: false },
        };
        let id = if self.byte() & 1 == 1 {
            Id::extended(self.word() >> 3)
        } else {
            Id::base((self.word() >> 21) as u16)
        };
        let data = [self.byte(); 64];
        let dlc = self.byte() & 15;
        let data = data.get(..Frame::data_length(kind, dlc))?;
        Frame::new(id?, kind, dlc, data).ok()
    }
}

const RATE: Bitrate = match Bitrate::new(500_000) {
    Some(rate) => rate,
    None => panic!("500 kbit/s is a rate"),
};
const CLOCK: Hertz = match Hertz::new(80_000_000) {
    Some(clock) => clock,
    None => panic!("80 MHz is a frequency"),
};

/// A hash over results, so that they are needed.
pub(crate) struct Sink(u32);

impl Sink {
    fn take(&mut self, value: u32) {
        self.0 = (self.0 ^ value).wrapping_mul(0x0100_0193);
    }

    fn take_long(&mut self, value: u64) {
        self.take(value as u32);
        self.take((value >> 32) as u32);
    }
}

/// Feeds `bytes` to every part of the library; the result depends on all of them.
#[must_use]
pub fn exercise(bytes: &[u8]) -> u32 {
    let mut source = Source { bytes, at: 0 };
    let mut sink = Sink(0x811C_9DC5);
    edges::exercise(&mut source, &mut sink);
    timing::exercise(&mut source, &mut sink);
    buses::exercise(&mut source, &mut sink);
    protocols::exercise(&mut source, &mut sink);
    text::exercise(&mut source, &mut sink);
    sink.0
}
