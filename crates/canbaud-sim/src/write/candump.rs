//! The log format of can-utils (`candump -l`).

use std::io::{self, Write};

use canbaud::wire::{Frame, FrameKind, Id};

use crate::time::Time;

/// Writes `frames` as a log of interface `channel`; times count from 0.
///
/// # Errors
/// Whatever writing comes to.
pub fn write_candump<'a>(
    out: &mut impl Write,
    channel: &str,
    frames: impl IntoIterator<Item = (Time, &'a Frame)>,
) -> io::Result<()> {
    for (at, frame) in frames {
        let us = at.femtoseconds() / 1_000_000_000;
        write!(out, "({:010}.{:06}) {channel} ", us / 1_000_000, us % 1_000_000)?;
        match frame.id() {
            Id::Base(id) => write!(out, "{id:03X}#")?,
            Id::Extended(id) => write!(out, "{id:08X}#")?,
        }
        match frame.kind() {
            FrameKind::Data => {}
            FrameKind::Remote if frame.dlc() == 0 => write!(out, "R")?,
            FrameKind::Remote => write!(out, "R{:X}", frame.dlc().min(8))?,
            FrameKind::Fd { brs, esi } => {
                write!(out, "#{:X}", u8::from(brs) | u8::from(esi) << 1)?;
            }
        }
        for byte in frame.data() {
            write!(out, "{byte:02X}")?;
        }
        writeln!(out)?;
    }
    out.flush()
}
