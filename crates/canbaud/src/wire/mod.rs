//! From edges to bits to frames, and back.
//!
//! Encoding: [`Frame`] -> [`encode`] -> [`EncodedFrame`].
//!
//! Decoding: edges -> `activity` (stretches between gaps, glitches dropped) -> `attempts` (ways to
//! place the bit grid) -> `reader` (`sync`: ticks to bits; then stuffing, fields, CRC, tail) ->
//! [`Item`]. All of it behind [`Decoder`].

mod activity;
pub(crate) mod attempts;
mod bits;
pub(crate) mod clock;
mod crc;
mod decoder;
mod encode;
mod frame;
mod item;
mod line;
pub(crate) mod phase;
pub(crate) mod reader;
mod sums;
pub(crate) mod sync;

pub use bits::BitString;
pub use crc::{Crc, CrcKind};
pub use decoder::{BusTiming, DataRateWanted, DataTiming, Decoded, Decoder, Listener};
pub use encode::{EncodedFrame, encode};
pub use frame::{Frame, FrameError, FrameKind, Id};
pub use item::{BusError, ErrorKind, FdCrc, Field, Item, ItemKind, Received};
pub use line::{Level, Logic, Polarity};
pub use sums::{Fit, PhaseSums};
