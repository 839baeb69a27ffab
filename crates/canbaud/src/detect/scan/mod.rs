//! Finding the rate of a live bus with a controller that only listens.
//!
//! | part | what it is |
//! |---|---|
//! | [`Controller`] | what a scan needs of a CAN controller; it has no way to transmit |
//! | [`Capabilities`] | what a controller can be set to, and what it tells |
//! | [`Candidate`] | a rate to listen at |
//! | [`Observation`] | what the controller heard, as data for the scan |

mod candidate;
mod controller;
mod observation;

pub use candidate::{Candidate, Capture};
pub use controller::{Capabilities, Configured, Controller, Evidence, FdSupport, RateChoice};
pub use observation::{ErrorClass, ErrorPlace, ErrorSeen, FrameSeen, Observation, Origin};
