//! canbaud finds the bit rate of any CAN or CAN FD bus, proves it, and never disturbs the bus.
//!
//! Reading order: [`units`] (every quantity has a type), [`wire`] (edges, bits, frames),
//! [`detect`] (the verdict), [`timing`] (bit timing and registers of controllers), [`lss`] (the bit
//! rate and node-ID of CANopen devices), [`node`] (a device that does all of it by itself; [`fault`]
//! is the error confinement behind it).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod detect;
pub mod fault;
mod fixed;
pub mod lss;
pub mod node;
pub mod rates;
pub mod timing;
pub mod units;
pub mod wire;

/// The examples of the README compile.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The examples of the guide to LSS compile.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/lss.md")]
struct LssGuide;
