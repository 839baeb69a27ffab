//! The slcan adapter: the commands of each firmware, and what each says at a wrong rate.

#[path = "../common/mod.rs"]
mod common;

mod bus;
mod firmwares;
mod lawicel;
mod wrong_rate;
