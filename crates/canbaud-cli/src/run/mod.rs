//! The commands: from what the user said to what the user gets.

mod adapters;
mod decode;
mod detect;
mod failure;
pub(crate) mod live;
mod lss;
mod progress;
mod queue;
mod simulate;
pub(crate) mod timing;

pub(crate) use adapters::{AdaptersArgs, adapters};
pub(crate) use decode::decode;
pub(crate) use detect::detect;
pub(crate) use lss::{LSS_HELP, LssArgs, lss};
pub(crate) use simulate::{SimulateArgs, simulate};
pub(crate) use timing::{controllers, timing};
