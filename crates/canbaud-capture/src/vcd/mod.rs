//! Value change dumps, `.vcd` [IEEE 1364-2005, 18].
//!
//! `tokens` splits the text, `header` reads the declarations, `changes` the changes;
//! `voltages` and `reader` make edges of them.

mod changes;
mod header;
mod reader;
mod tokens;
mod voltages;

pub(crate) use reader::open;
