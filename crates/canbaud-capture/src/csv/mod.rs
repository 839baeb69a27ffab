//! Comma separated values: sigrok, Saleae Logic 2 and oscilloscopes of any maker.
//!
//! The makers differ in what precedes the first row of numbers. `header` finds that row and what the
//! columns mean, `clock` when each row was sampled, `rows` reads the rows and
//! `reader` makes edges of them.

mod cells;
mod clock;
mod header;
mod labels;
mod reader;
mod rows;

pub(crate) use header::sniff;
pub(crate) use reader::open;
