//! Fastscan: finds the address of a device that has no node-ID [CiA 305].

mod machine;
mod options;
mod rhythm;
mod search;

pub use machine::{Fastscan, FastscanAction};
pub use options::{FastscanError, FastscanOptions, FastscanStatistics, Found, Strategy};
