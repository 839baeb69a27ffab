//! The side of the device.

mod action;
mod activation;
mod machine;
mod options;
mod selection;

pub use action::SlaveAction;
pub use machine::Slave;
pub use options::{Automatic, Configuration, SlaveOptions, Storage, StoreError};
