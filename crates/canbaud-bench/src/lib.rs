//! Measures `canbaud::detect` on the simulated captures of `canbaud_sim::benchmark`, beside the
//! minimum pulse method of AP2925 on the same edges, and keeps `docs/accuracy.md` up to date.
//!
//! [`scans`] does the same for `canbaud::detect::scan` on simulated controllers.
//!
//! Nothing here is published. [`document`] is for any program that writes a section of the document.
#![forbid(unsafe_code)]

pub mod case;
pub mod document;
pub mod judge;
pub mod scans;
pub mod tables;
pub mod tally;
mod work;
