//! What happened on the bus as files that other tools open.

mod candump;
mod recorder;
mod sr;
mod vcd;

pub use candump::write_candump;
pub use recorder::Recorder;
pub use sr::{SrError, write_sr};
pub use vcd::write_vcd;
