//! Adapters: what there is on this machine, and what is known of their behaviour at a wrong rate.

#[cfg(target_os = "linux")]
mod interfaces;
mod known;
mod serial;

#[cfg(target_os = "linux")]
pub use interfaces::{InterfaceAdapter, InterfaceUse, interface_adapters};
pub use known::{KnownDriver, ListenOnly, WrongRate, driver_of_controller, known, known_drivers};
pub use serial::{SerialAdapter, serial_adapters};
