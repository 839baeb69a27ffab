//! From edges to bits to frames, and back.
//!
//! Encoding: [`Frame`] -> [`encode`] -> [`EncodedFrame`].

mod bits;
mod crc;
mod encode;
mod frame;
mod item;
mod line;

pub use bits::BitString;
pub use crc::{Crc, CrcKind};
pub use encode::{EncodedFrame, encode};
pub use frame::{Frame, FrameError, FrameKind, Id};
pub use item::{BusError, ErrorKind, FdCrc, Field, Item, ItemKind, Received};
pub use line::{Level, Logic, Polarity};
