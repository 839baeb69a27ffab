//! canbaud finds the bit rate of any CAN or CAN FD bus, proves it, and never disturbs the bus.
//!
//! Reading order: [`units`] (every quantity has a type), [`wire`] (edges, bits, frames),
//! [`detect`] (the verdict), [`timing`] (bit timing and registers of controllers), [`lss`] (the bit
//! rate and node-ID of CANopen devices).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod detect;
pub mod lss;
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
