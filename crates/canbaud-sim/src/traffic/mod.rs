//! Who asks to send what, and when.

mod payload;
mod replay;
mod source;

pub use payload::{FrameFormat, Payload, PayloadError};
pub use replay::{ReplayError, parse_candump};
pub use source::{Arrivals, Source};
