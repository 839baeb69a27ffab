//! Serial adapters with the Lawicel protocol and its relatives.
//!
//! | part | what it is |
//! |---|---|
//! | [`Lines`], [`Record`], [`print()`] | the codec: bytes in, records out; no I/O |
//! | [`Firmware`], [`Answers`] | whose firmware it is, by its answers; no I/O |
//! | [`SlcanListener`] | an adapter as a controller that only listens |

mod channel;
mod codec;
mod firmware;
mod listener;
mod rate;

pub use codec::{LINE_MAX, Line, Lines, Record, print};
pub use firmware::{Answers, Digit, Firmware};
pub use listener::{SilentMode, SlcanListener};

pub(crate) use channel::{Answer, Channel, Heard};
pub(crate) use rate::command as rate_command;
