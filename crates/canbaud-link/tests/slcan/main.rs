//! The slcan backend against adapters on a pty: the simulator's, and some that misbehave.
#![cfg(unix)]

mod bench;
mod bus;
mod codec;
mod firmwares;
mod misbehaving;
mod rates;
