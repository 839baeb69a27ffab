//! A simulated bus and a simulated controller on it, for scans without hardware.
//!
//! [`SimBus`] is a bus with its traffic, [`SimController`] implements
//! [`Controller`](canbaud::detect::scan::Controller) on one of its nodes. What an adapter tells,
//! and how late, is a matter of [`Adapter`].

mod adapter;
mod bus;
mod controller;
pub mod trial;

pub use adapter::{Adapter, Stamps};
pub use bus::{Destroyer, SimBus};
pub use controller::{SimController, SimError};
