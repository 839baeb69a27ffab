//! Live CAN buses, by adapters that listen and by channels that may transmit.
//!
//! The two never meet: a scan gets a [`Listener`], which has no way to send a frame, and what sends
//! on purpose (LSS) asks for a [`bus::FrameBus`] by name.
//!
//! | module | what it is |
//! |---|---|
//! | [`socketcan`] | interfaces of Linux: rtnetlink for setting up, `CAN_RAW` for hearing |
//! | [`slcan`] | serial adapters with the Lawicel protocol and its relatives |
//! | [`sim`] | a simulated controller on a simulated bus |
//! | [`replay`] | a capture file in the place of a bus |
//! | [`adapters`] | what there is on this machine, and what is known of it |
//! | [`bus`] | channels that transmit, for LSS |
//! | [`lss`] | the LSS master on one of them |
#![forbid(unsafe_code)]

pub mod adapters;
pub mod bus;
mod clock;
mod error;
mod listener;
pub mod lss;
pub mod replay;
pub mod sim;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod socketcan;

pub use clock::Clock;
pub use error::{ErrorKind, LinkError};
pub use listener::{After, Listener};
