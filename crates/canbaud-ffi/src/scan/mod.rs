//! The listen-only scan.

mod calls;
mod convert;
mod types;

pub use calls::*;
pub use types::*;
