//! A capture file in the place of a bus, in real time and again and again.
//!
//! For demonstrations and tests: the file is decoded at the rate that the scan asks for, so a wrong
//! rate shows the errors that it would show.

mod listener;
mod receiver;
mod track;

pub use listener::ReplayListener;
