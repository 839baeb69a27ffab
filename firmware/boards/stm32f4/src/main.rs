//! AP2925 on an STM32F405: measure, configure, verify silently. What takes part in the bus then is the
//! application.
//!
//! Wiring: RXD of the transceiver to PA11 (CAN1_RX) and to PA0 (TIM2_CH1); PA12 (CAN1_TX) to TXD. PA12
//! stays what it is after reset, an input, with a pull-up: TXD is recessive whatever the software does.
#![cfg_attr(target_arch = "arm", no_std, no_main)]

#[cfg(not(target_arch = "arm"))]
fn main() {
    eprintln!("this is for an STM32F4: cargo build --release --target thumbv7em-none-eabihf");
}

#[cfg(target_arch = "arm")]
mod board;
