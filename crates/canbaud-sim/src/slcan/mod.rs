//! A slcan (Lawicel) adapter whose other side is a node of the simulation.
//!
//! Commands and answers are those of the CAN232 manual and of the firmwares that follow it; error
//! records are those that the kernel's slcan driver reads.

mod adapter;
mod filter;
mod frame;
mod rates;

#[cfg(unix)]
mod pty;

pub use adapter::{Adapter, Dialect, ErrorReports};
#[cfg(unix)]
pub use pty::Pty;
