//! Scans on simulated buses: every policy over the same scenarios.

mod campaign;
mod score;
mod tables;

pub use campaign::{Campaign, random, run_random};
pub use score::Score;
pub use tables::{TABLES, Table};
