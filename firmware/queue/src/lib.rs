//! From a capture interrupt to a detector: edges with their polarity, and what is made of them when
//! some are missing.
#![no_std]
#![forbid(unsafe_code)]

mod edge;
mod queue;
mod recorder;

pub use edge::{Before, Edge};
pub use queue::{CaptureQueue, Taken};
pub use recorder::{Detector, Recorder};
