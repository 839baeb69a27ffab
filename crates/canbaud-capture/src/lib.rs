//! Reads logic analyser and oscilloscope captures as streams of edges, in bounded memory.
//!
//! ```
//! use core::ops::ControlFlow;
//! use canbaud::wire::Logic;
//! use canbaud_capture::{EdgeSink, OpenOptions, from_reader};
//!
//! /// The shortest pulse of a capture.
//! struct Shortest { last: u64, ticks: u64 }
//!
//! impl EdgeSink for Shortest {
//!     fn begin(&mut self, _channel: usize, at: u64, _level: Logic) {
//!         self.last = at;
//!     }
//!     fn edges(&mut self, _channel: usize, times: &[u64]) -> ControlFlow<()> {
//!         for &time in times {
//!             self.ticks = self.ticks.min(time - self.last);
//!             self.last = time;
//!         }
//!         ControlFlow::Continue(())
//!     }
//!     fn end(&mut self, _channel: usize, _at: u64) {}
//! }
//!
//! let dump = b"$timescale 1 us $end $var wire 1 ! RX $end $enddefinitions $end
//!              #0 1! #40 0! #48 1! #56 0! #72 1! #100";
//! let mut capture = from_reader(std::io::Cursor::new(dump), &OpenOptions::default())?;
//! assert_eq!(capture.channels()[0].name, "RX");
//! let mut shortest = Shortest { last: 0, ticks: u64::MAX };
//! capture.stream(&mut shortest)?;
//! assert_eq!(capture.timebase().nanoseconds(shortest.ticks), Some(8_000)); // 125 kbit/s
//! # Ok::<(), canbaud_capture::CaptureError>(())
//! ```
//!
//! [`open`] finds the format from the content; [`Capture::stream`] hands the edges of the selected
//! channels to an [`EdgeSink`] in blocks and can be called again. Voltages become edges at a
//! threshold that is found from the signal; CAN_H and CAN_L also as their difference.
//!
//! Files are streamed: memory does not grow with their length. Nothing in a file is trusted; what is
//! wrong with it is a [`CaptureError`] of one line with its [`Place`]. `docs/formats.md` lists the
//! formats, their traps and the limits.
//!
//! # Inside
//! `open` → `sniff` → one reader per format (`sr`, `vcd`, `csv`, `saleae`, `dsview`, `logicdata`,
//! `isf`) → `packed` (samples in words) or `analogue` (voltages) → `sink` (blocks of edges, and the
//! rule that two edges on one tick cancel out).
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
mod isf;
mod lines;
mod logicdata;
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
