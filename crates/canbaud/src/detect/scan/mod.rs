//! Finding the rate of a live bus with a controller that only listens.
//!
//! | part | what it is |
//! |---|---|
//! | [`Scan`] | the machine: observations in, actions out, no I/O, no clock of its own |
//! | [`Candidates`], [`Settings`], [`Policy`] | what it is told |
//! | [`Action`], [`Outcome`], [`Found`] | what it asks for, and what it says in the end |
//! | [`Status`], [`Standing`] | what it is doing, for people who watch |
//! | [`Controller`] | what a scan needs of a CAN controller; it has no way to transmit |
//! | [`Capabilities`] | what a controller can be set to, and what it tells |
//! | [`Candidate`] | a rate to listen at |
//! | [`Observation`] | what the controller heard, as data for the scan |
//! | [`Driver`] | pumps a controller for a scan |
//!
//! `docs/scan.md` says how the policies work, what they cost, and where the bounds come from.

mod bounds;
mod burst;
mod candidate;
mod candidates;
mod controller;
mod driver;
mod hearing;
mod likelihood;
mod machine;
mod observation;
mod outcome;
mod policy;
mod settings;
mod status;
mod track;
mod verdict;

pub use candidate::{Candidate, Capture};
pub use candidates::{Candidates, TooMany};
pub use controller::{Capabilities, Configured, Controller, Evidence, FdSupport, RateChoice};
pub use driver::{Driver, Progress};
pub use machine::{Action, Scan};
pub use observation::{ErrorClass, ErrorPlace, ErrorSeen, FrameSeen, Observation, Origin};
pub use outcome::{Acknowledgement, FdSeen, Found, Ground, Misfit, Outcome};
pub use settings::{End, Policy, Settings, UnknownPolicy};
pub use status::{Activity, Standing, Status};
