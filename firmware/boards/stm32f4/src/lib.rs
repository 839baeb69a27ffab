//! canbaud on an STM32F405/407: the peripherals behind [`Registers`], so that what is done with them
//! is tested on any machine. `main.rs` puts them together.
#![no_std]

mod bxcan;
mod capture;
mod measure;
mod registers;

pub use bxcan::{Bxcan, Error};
pub use capture::Capture;
pub use measure::{Measured, Measurement};
pub use registers::{Block, Registers};
