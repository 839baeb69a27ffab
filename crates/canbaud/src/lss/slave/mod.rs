//! The side of the device.

mod action;
mod activation;
mod machine;
mod options;
mod selection;
mod tables;

pub use action::SlaveAction;
pub use machine::Slave;
pub use options::{Automatic, Configuration, SlaveOptions, Storage, StoreError};
pub use tables::{NoTables, TableEntry, Tables};
