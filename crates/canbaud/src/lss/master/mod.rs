//! The side of the master: one machine for each procedure.

mod activation;
mod exchange;
mod fastscan;
mod pace;
mod service;

pub use activation::{Activation, ActivationAction};
pub use exchange::{Exchange, ExchangeAction};
pub use fastscan::{
    Fastscan, FastscanAction, FastscanError, FastscanOptions, FastscanStatistics, Found, Strategy,
};
pub use pace::Pace;
pub use service::{Reply, Service, ServiceError};
