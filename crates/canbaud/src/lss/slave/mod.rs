//! The side of the device.

mod activation;
mod machine;
mod options;
mod selection;

pub use machine::{Slave, SlaveAction};
pub use options::{Automatic, Configuration, SlaveOptions, Storage, StoreError};
