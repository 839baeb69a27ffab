//! Protocol control [ISO 11898-1]: what a node makes of each sampled bit, and what it drives next.

mod alone;
mod crc;
mod flags;
mod frame;
mod machine;
mod quiet;
mod reader;
mod transmit;

pub(crate) use alone::{Alone, Score};
pub(crate) use machine::{Protocol, Setup};
pub(crate) use quiet::{Quiet, Reading};
