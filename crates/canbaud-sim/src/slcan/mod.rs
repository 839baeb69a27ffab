//! A slcan (Lawicel) adapter whose other side is a node of the simulation.
//!
//! Commands and answers are those of the CAN232 manual and of the firmwares that follow it; error
//! records are those that the kernel's slcan driver reads.

mod adapter;
mod command;
mod filter;
mod firmware;
mod frame;
mod log;
mod rates;
mod status;

#[cfg(unix)]
mod pty;

pub use adapter::Adapter;
pub use firmware::{ErrorReports, Firmware, SilentMode};
pub use log::{Effect, Entry, What};
#[cfg(unix)]
pub use pty::Pty;
