//! Scans on simulated buses, each with what makes other scans fail; all laws of the bus are checked.

mod data_rates;
mod silence;
mod stage;
mod sweep;
mod trouble;
