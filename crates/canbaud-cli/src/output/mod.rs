//! What a user gets to see; one file per form.

mod advice;
mod candump;
mod digits;
mod expected;
mod frames_json;
mod number;
pub(crate) use number::{bitrate, count};
mod paint;
mod pcapng;
mod report_json;
mod socketcan;
mod stamp;
mod text;
mod words;

#[cfg(test)]
mod items;

pub(crate) mod live_json;
pub(crate) mod live_text;

use std::io;

use canbaud::wire::Item;

pub(crate) use candump::{Candump, RawDlc};
pub(crate) use frames_json::FramesJson;
pub(crate) use paint::Paint;
pub(crate) use pcapng::Pcapng;
pub(crate) use report_json::{push_report, push_unreadable};
pub(crate) use stamp::Clock;
pub(crate) use text::{Detail, render, summary};

/// Writes the items of a decoded bus, one after the other.
pub(crate) trait ItemWriter {
    /// Writes one item.
    fn write(&mut self, item: &Item) -> io::Result<()>;
    /// Hands over everything that is still buffered.
    fn finish(&mut self) -> io::Result<()>;
}
