//! Protocol control [ISO 11898-1]: what a node makes of each sampled bit, and what it drives next.

mod crc;
mod flags;
mod frame;
mod machine;
mod reader;
mod transmit;

pub(crate) use machine::{Protocol, Quiet, Setup};
