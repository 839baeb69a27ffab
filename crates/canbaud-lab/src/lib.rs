//! Devices that run canbaud, on a simulated bus.
//!
//! The simulator must not know canbaud's detectors, and the detectors must not know the simulator;
//! here they meet. [`Network`] is a simulated bus with [`Device`]s on it: a controller, a capture
//! timer, a memory, and [`canbaud::node::Node`] as their software. [`Ap2925`] is the procedure of
//! that application note beside it.
//!
//! `docs/mission.md` is made by `examples/mission`, from [`mission`].
#![forbid(unsafe_code)]

mod ap2925;
mod autonomous;
mod config;
mod controller;
mod day;
mod device;
mod ears;
mod journal;
mod lss;
mod memory;
pub mod mission;
mod network;
mod plant;
mod time;

pub use ap2925::{Ap2925, Ap2925Table};
pub use autonomous::Autonomous;
pub use config::{DeviceConfig, Listener};
pub use day::{Report, Shift};
pub use device::{Company, Device, Joined};
pub use memory::Memory;
pub use network::{Network, Tally};
pub use plant::{Mix, Outcome, Plant};
