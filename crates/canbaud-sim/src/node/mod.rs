//! A node, split as ISO 11898-1 splits it: bit time, sampling, protocol control, fault confinement.

mod bit_time;
mod config;
mod core;
mod fault;
mod protocol;
mod sampling;

pub use bit_time::SyncOutcome;
pub use config::{
    FdSupport, Gate, Mode, MonitoringCounters, NodeConfig, Oscillator, Recovery, Retransmission,
    Tdc, Wire,
};
pub(crate) use core::Step;
pub use core::{Node, SyncCorners};
pub use fault::FaultConfinement;
