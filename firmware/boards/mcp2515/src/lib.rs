//! Microchip MCP2515 over SPI (`embedded-hal` 1.0) as a controller that only listens.
//!
//! Wiring: SCK, SI, SO, CS, and nothing on the TXnRTS pins; INT may wake the main loop. SPI mode 0,
//! up to 10 MHz. In configuration mode, after power-on and reset, TXCAN is recessive, and in
//! listen-only mode it stays so: the driver never enters a mode that transmits and holds no
//! instruction that asks for it.
//!
//! What it needs from the chip is in `registers`, with the sections of the data sheet DS20001801.
#![no_std]
#![forbid(unsafe_code)]

mod driver;
mod registers;

pub use driver::{Error, Mcp2515};
