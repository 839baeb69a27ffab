//! What the command needs of a live controller beyond hearing.

use std::time::Duration;

use canbaud::detect::scan::{Candidate, Capabilities, Configured, Controller, Observation};
use canbaud::units::Micros;

use crate::LinkError;

/// How to leave an interface behind a successful scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum After {
    /// At the found rate, listening.
    Listening,
    /// At the found rate, taking part in the traffic.
    Normal,
}

/// A [`Controller`] of this machine: one can wait for it, and it is put back as it was found.
///
/// Dropping it puts it back, too, but cannot say what went wrong.
pub trait Listener: Controller<Error = LinkError> {
    /// Waits until there may be something to observe, at most `timeout`; a signal ends it earlier.
    ///
    /// # Errors
    /// The adapter is gone.
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError>;

    /// The adapter in a few words, for the report.
    fn describe(&self) -> String;

    /// What the user should know before the scan begins, a sentence each.
    fn remarks(&self) -> Vec<String>;

    /// Leaves the adapter at `candidate` for good, instead of putting it back as it was found.
    ///
    /// # Errors
    /// It cannot be left so; it is put back later then.
    fn keep(&mut self, candidate: &Candidate, after: After) -> Result<(), LinkError> {
        let _ = (candidate, after);
        let what = "its setting does not outlive this program";
        Err(LinkError::State { adapter: self.describe(), what })
    }

    /// What [`Self::restore`] had to leave as it is, and why.
    fn left_over(&self) -> Option<&'static str> {
        None
    }

    /// How a person puts the adapter back where [`Self::restore`] cannot.
    fn by_hand(&self) -> Option<String> {
        None
    }

    /// Puts the adapter back as it was found, and says what could not be.
    ///
    /// # Errors
    /// What could not be put back.
    fn restore(&mut self) -> Result<(), LinkError>;
}

impl Controller for &mut dyn Listener {
    type Error = LinkError;

    fn capabilities(&self) -> Capabilities<'_> {
        (**self).capabilities()
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, LinkError> {
        (**self).configure(candidate)
    }

    fn start_monitoring(&mut self) -> Result<(), LinkError> {
        (**self).start_monitoring()
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, LinkError> {
        (**self).observe(now)
    }

    fn stop(&mut self) -> Result<(), LinkError> {
        (**self).stop()
    }
}
