//! A node, split as ISO 11898-1 splits it: bit time, sampling, protocol control, fault confinement.

mod alone;
mod bit_time;
mod config;
mod core;
mod corners;
mod fault;
mod follow;
mod late;
mod protocol;
mod sampling;
mod segments;
mod steps;

pub(crate) use alone::{Change, Plan};
pub use bit_time::SyncOutcome;
pub use config::{
    FdSupport, Gate, Mode, MonitoringCounters, NodeConfig, Oscillator, Recovery, Retransmission,
    Tdc, Wire,
};
pub use core::Node;
pub use corners::SyncCorners;
pub use fault::FaultConfinement;
pub(crate) use late::{Before, Samples, Unseen};
pub(crate) use protocol::Score;
pub(crate) use steps::Step;
