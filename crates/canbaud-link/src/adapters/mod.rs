//! Adapters: what there is on this machine, and what is known of their behaviour at a wrong rate.

mod known;

pub use known::{KnownDriver, ListenOnly, WrongRate, known, known_drivers};
