//! The rate from the edges of one classic frame, in little memory and few instructions.
//!
//! `detector` cuts the edges into stretches between two gaps; `grid` finds the bit times at which
//! all edges of a stretch lie on one grid; `frame` reads the bits and compares the CRC.

mod detector;
mod frame;
mod grid;

pub use detector::CompactDetector;
