//! Saleae Logic 1 captures, `.logicdata`, version 5 ("Data save").
//!
//! The format is not documented. What is known: numbers are a length byte (0 to 8) and that many
//! little-endian bytes; the run lengths of a channel lie in four arrays by their size, and index
//! records say which array goes on where. `block` finds and checks these arrays, `runs` walks them.

mod block;
mod numbers;
mod reader;
mod runs;

pub(crate) use numbers::MAGIC;
pub(crate) use reader::open;
