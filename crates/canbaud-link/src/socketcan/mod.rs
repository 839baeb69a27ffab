//! Interfaces of Linux.
//!
//! | part | what it is |
//! |---|---|
//! | [`netlink`] | rtnetlink as bytes: what an interface is and can, and how to set it up |
//! | [`SocketCanListener`] | an interface as a controller that only listens |

mod error_frame;
mod frame;
mod hear;
mod listener;
#[cfg(test)]
pub(crate) mod mock;
pub mod netlink;
pub(crate) mod raw;
mod restore;
mod rtnl;
mod setup;
mod wide;

pub use listener::SocketCanListener;
pub use rtnl::Rtnl;

pub(crate) use frame::{Raw, encode};
pub(crate) use restore::Saved;
pub(crate) use rtnl::LinkLayer;
pub(crate) use setup::{Device, Profile};
