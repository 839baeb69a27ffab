//! `decode --format json`: one object a line, described by `schemas/decode.schema.json`.

use std::io::{self, Write};

use canbaud::wire::{BusError, ErrorKind, Field, Frame, FrameKind, Id, Item, ItemKind, Received};

use super::ItemWriter;
use super::digits::{Case, push_bytes, push_decimal, push_number};
use super::stamp::{Clock, Stamp};

/// Writes one object a line. Every object has the same keys; what an item lacks is `null`.
pub(crate) struct FramesJson<W> {
    out: W,
    stamp: Stamp,
    line: Vec<u8>,
}

impl<W: Write> FramesJson<W> {
    /// A writer for items whose ticks `clock` tells.
    pub(crate) fn new(out: W, clock: Clock) -> Self {
        Self { out, stamp: Stamp::nanos(clock), line: Vec::with_capacity(384) }
    }

    fn push_time(&mut self, ticks: u64) {
        let nanos = self.stamp.count(ticks);
        push_number(&mut self.line, nanos / 1_000_000_000);
        self.line.push(b'.');
        push_decimal(&mut self.line, nanos % 1_000_000_000, 9);
    }

    fn push(&mut self, text: &str) {
        self.line.extend_from_slice(text.as_bytes());
    }

    fn push_flag(&mut self, key: &str, value: bool) {
        self.push(key);
        self.push(if value { "true" } else { "false" });
    }

    fn push_id(&mut self, id: Id) {
        self.push(",\"id\":");
        push_number(&mut self.line, u64::from(id.raw()));
        self.push_flag(",\"extended\":", id.is_extended());
    }

    fn push_frame(&mut self, frame: &Frame, acknowledged: bool) {
        let kind = frame.kind();
        let (brs, esi) = match kind {
            FrameKind::Fd { brs, esi } => (brs, esi),
            FrameKind::Data | FrameKind::Remote => (false, false),
        };
        self.push_id(frame.id());
        self.push_flag(",\"remote\":", kind == FrameKind::Remote);
        self.push_flag(",\"fd\":", kind.is_fd());
        self.push_flag(",\"brs\":", brs);
        self.push_flag(",\"esi\":", esi);
        self.push(",\"dlc\":");
        push_number(&mut self.line, u64::from(frame.dlc()));
        self.push(",\"data\":\"");
        push_bytes(&mut self.line, frame.data(), Case::Lower);
        self.push_flag("\",\"ack\":", acknowledged);
        self.push(match kind {
            FrameKind::Remote => ",\"kind\":\"remote\"",
            FrameKind::Data | FrameKind::Fd { .. } => ",\"kind\":\"data\"",
        });
        self.push(",\"error\":null,\"field\":null,\"error_t\":null");
    }

    fn push_error(&mut self, error: &BusError) {
        match error.id {
            Some(id) => self.push_id(id),
            None => self.push(",\"id\":null,\"extended\":null"),
        }
        self.push(NO_FRAME);
        self.push(",\"kind\":\"error\",\"error\":\"");
        self.push(error_name(error.kind));
        self.push("\",\"field\":\"");
        self.push(field_name(error.field));
        if let Field::EndOfFrame(bit) = error.field {
            push_number(&mut self.line, u64::from(bit));
        }
        self.push("\",\"error_t\":");
        self.push_time(error.at);
    }
}

const NO_FRAME: &str = ",\"remote\":null,\"fd\":null,\"brs\":null,\"esi\":null,\"dlc\":null,\
                        \"data\":null,\"ack\":null";

impl<W: Write> ItemWriter for FramesJson<W> {
    fn write(&mut self, item: &Item) -> io::Result<()> {
        self.line.clear();
        self.push("{\"t\":");
        self.push_time(item.start);
        match &item.kind {
            ItemKind::Frame(Received { frame, acknowledged, .. }) => {
                self.push_frame(frame, *acknowledged);
            }
            ItemKind::Error(error) => self.push_error(error),
            ItemKind::Overload => {
                self.push(",\"id\":null,\"extended\":null");
                self.push(NO_FRAME);
                self.push(",\"kind\":\"overload\",\"error\":null,\"field\":null,\"error_t\":null");
            }
        }
        self.push("}\n");
        self.out.write_all(&self.line)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

const fn error_name(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::Stuff => "stuff",
        ErrorKind::Crc => "crc",
        ErrorKind::Form => "form",
        ErrorKind::Acknowledge => "acknowledge",
        ErrorKind::DataRateUnknown => "data_rate_unknown",
        ErrorKind::Truncated => "truncated",
        ErrorKind::Disturbance => "disturbance",
        _ => "other",
    }
}

/// The name of a field; EOF is followed by its bit number.
const fn field_name(field: Field) -> &'static str {
    match field {
        Field::Arbitration => "arbitration",
        Field::Control => "control",
        Field::Data => "data",
        Field::Crc => "crc",
        Field::CrcDelimiter => "crc_delimiter",
        Field::AckSlot => "ack_slot",
        Field::AckDelimiter => "ack_delimiter",
        Field::EndOfFrame(_) => "eof_",
        Field::Intermission => "intermission",
        _ => "other",
    }
}

#[cfg(test)]
mod tests;
