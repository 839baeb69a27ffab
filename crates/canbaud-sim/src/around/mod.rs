//! What stands between a bus and software that looks for its bit rate: a controller with its
//! registers and delays, a capture timer, a polling loop.

mod controller;
mod polling;
mod timer;

pub use controller::{Controller, ControllerSettings, ErrorCode, Fifo, Received};
pub use polling::{PollingLoop, Pulse};
pub use timer::{Capture, CaptureTimer};
