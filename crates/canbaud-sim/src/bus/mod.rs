//! The wire: wired-AND at a star point, and what lies between it and each node.

mod line;
mod log;
mod transceiver;

pub(crate) use line::Line;
pub(crate) use log::{Edge, EdgeLog};
pub use transceiver::Transceiver;
