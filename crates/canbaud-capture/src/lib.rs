//! Reads logic analyser and oscilloscope captures as streams of edges, in bounded memory.
#![forbid(unsafe_code)]

mod analogue;
mod capture;
mod csv;
mod dsview;
mod error;
mod format;
mod grid;
mod ini;
mod input;
mod lines;
mod number;
mod open;
mod packed;
mod saleae;
mod sink;
mod sniff;
mod sr;
mod vcd;
mod zip;

pub use analogue::{Levels, Threshold};
pub use capture::{Capture, Channel, ChannelKind, ChannelSummary, OpenOptions, Signal, Summary};
pub use error::{CaptureError, Place};
pub use format::{Format, UnknownFormat, WordSize};
pub use open::{from_reader, open};
pub use sink::EdgeSink;
