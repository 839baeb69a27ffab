//! What the command needs of a live controller beyond hearing.

use std::time::Duration;

use canbaud::detect::scan::Controller;

use crate::LinkError;

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

    /// Puts the adapter back as it was found, and says what could not be.
    ///
    /// # Errors
    /// What could not be put back.
    fn restore(&mut self) -> Result<(), LinkError>;
}
