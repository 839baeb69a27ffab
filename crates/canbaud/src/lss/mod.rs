//! Layer setting services: bit rate and node-ID of CANopen devices over the bus [CiA 305].
//!
//! | part | what it is |
//! |---|---|
//! | [`Request`], [`Response`] | every command of the protocol, to and from eight bytes |
//! | [`RateSetting`], [`TABLE`] | bit timing table 0, whose index 9 is automatic detection |
//! | [`Slave`] | the side of the device |
//! | [`Exchange`], [`Fastscan`], [`Activation`] | the side of the master, one procedure each |
//!
//! Nothing here does I/O or knows a clock. A machine is driven in turns: hand it what came
//! (`handle`), carry out what it wants until it wants nothing (`poll`), wait for the next frame or
//! its `deadline`, whichever is first. Time never goes backwards. `docs/lss.md` is the guide.
//!
//! In: frames and the time. Out: frames to send, and what else is to be done. Never: a frame that
//! the protocol does not owe.

mod address;
mod master;
mod node_id;
mod rate;
mod request;
mod response;
mod slave;
mod wire;

pub use address::{IdRange, LssAddress, Part};
pub use master::{
    Activation, ActivationAction, Exchange, ExchangeAction, Fastscan, FastscanAction,
    FastscanError, FastscanOptions, FastscanStatistics, Found, Pace, Reply, Service, ServiceError,
    Strategy,
};
pub use node_id::NodeId;
pub use rate::{RateSet, RateSetting, TABLE, TableRow};
pub use request::{Bound, LssState, Request};
pub use response::{Outcome, Response};
pub use slave::{
    Automatic, Configuration, NoTables, Slave, SlaveAction, SlaveOptions, Storage, StoreError,
    TableEntry, Tables,
};
pub use wire::{MASTER_COB_ID, SLAVE_COB_ID};
