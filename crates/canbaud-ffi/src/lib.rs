//! The C API of canbaud; `include/canbaud.h` is made from it.
//!
//! Every function takes storage that the caller owns, checks its pointers and values, and says what
//! is wrong by a status. Nothing allocates, nothing panics, nothing is kept in statics.
//!
//! This is the only crate with unsafe code: what a pointer from C points to.
#![cfg_attr(not(feature = "std"), no_std)]
#![allow(non_camel_case_types, reason = "the names are those of the C API")]

mod compact;
mod controllers;
mod frame;
mod lss;
mod pulse;
mod scan;
mod status;
mod storage;
mod timing;

pub use compact::*;
pub use controllers::*;
pub use frame::*;
pub use lss::*;
pub use pulse::*;
pub use scan::*;
pub use status::*;
pub use timing::*;

/// A library for firmware has to have one; nothing in canbaud can reach it.
#[cfg(not(feature = "std"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
