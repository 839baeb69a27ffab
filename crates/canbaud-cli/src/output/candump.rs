//! candump log lines, as `candump -l` of can-utils writes them.

use std::io::{self, Write};

use canbaud::wire::{Frame, Item};

use super::ItemWriter;
use super::digits::{Case, push_bytes, push_decimal, push_hex};
use super::socketcan::Message;
use super::stamp::{Clock, Stamp};

/// Whether DLC 9 to 15 of a classic frame are told with the suffix `_9` to `_F`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RawDlc {
    /// As candump without options: every reader understands it.
    Hidden,
    /// As `candump -8`: can-utils of 2021 and later read it, python-can 4 does not.
    Shown,
}

/// Writes `(0000000012.345678) can0 123#DEADBEEF`.
pub(crate) struct Candump<W> {
    out: W,
    stamp: Stamp,
    raw_dlc: RawDlc,
    line: Vec<u8>,
}

impl<W: Write> Candump<W> {
    /// A writer for items whose ticks `clock` tells.
    pub(crate) fn new(out: W, clock: Clock, raw_dlc: RawDlc) -> Self {
        Self { out, stamp: Stamp::micros(clock), raw_dlc, line: Vec::with_capacity(192) }
    }

    fn push_id(&mut self, frame: &Frame) {
        let digits = if frame.id().is_extended() { 8 } else { 3 };
        push_hex(&mut self.line, frame.id().raw(), digits);
        self.line.push(b'#');
    }

    /// The suffix of a classic frame whose DLC is above 8.
    fn push_raw_dlc(&mut self, frame: &Frame) {
        if self.raw_dlc == RawDlc::Shown && frame.dlc() > 8 {
            self.line.push(b'_');
            push_hex(&mut self.line, u32::from(frame.dlc()), 1);
        }
    }

    fn push_message(&mut self, message: Message<'_>) {
        match message {
            Message::Data(frame) => {
                self.push_id(frame);
                push_bytes(&mut self.line, frame.data(), Case::Upper);
                self.push_raw_dlc(frame);
            }
            Message::Remote(frame) => {
                self.push_id(frame);
                self.line.push(b'R');
                match frame.dlc() {
                    0 => {}
                    dlc => push_hex(&mut self.line, u32::from(dlc.min(8)), 1),
                }
                self.push_raw_dlc(frame);
            }
            Message::Fd(frame, flags) => {
                self.push_id(frame);
                self.line.push(b'#');
                push_hex(&mut self.line, u32::from(flags), 1);
                push_bytes(&mut self.line, frame.data(), Case::Upper);
            }
            Message::Error(id, data) => {
                push_hex(&mut self.line, id, 8);
                self.line.push(b'#');
                push_bytes(&mut self.line, &data, Case::Upper);
            }
        }
    }
}

impl<W: Write> ItemWriter for Candump<W> {
    fn write(&mut self, item: &Item) -> io::Result<()> {
        let micros = self.stamp.count(item.start);
        self.line.clear();
        self.line.push(b'(');
        push_decimal(&mut self.line, micros / 1_000_000, 10);
        self.line.push(b'.');
        push_decimal(&mut self.line, micros % 1_000_000, 6);
        self.line.extend_from_slice(b") can0 ");
        self.push_message(Message::of(&item.kind));
        self.line.push(b'\n');
        self.out.write_all(&self.line)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests;
