//! `canbaud timing` and `canbaud controllers`.

mod args;
mod autobaud;
mod catalogue;
mod decode;
mod json;
mod names;
mod picture;
mod plan;
mod refusal;
mod snippets;
mod tables;
#[cfg(test)]
mod tests;
mod text;

pub(crate) use args::{ControllersArgs, TIMING_HELP, TimingArgs};
pub(crate) use catalogue::controllers;
pub(crate) use plan::timing;
