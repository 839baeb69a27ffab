//! From edges to bits to frames, and back.

mod line;

pub use line::{Level, Logic, Polarity};
