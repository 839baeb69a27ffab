//! The seam between a scan and a CAN controller: it can listen, and nothing else.

use super::{Candidate, Observation};
use crate::units::{Bitrate, Micros};

/// What a controller in bus monitoring tells about a wrong rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Evidence {
    /// Each protocol error, or at least that there was one.
    Errors,
    /// Only a receive error counter that moves.
    Counter,
    /// Nothing: only frames. A wrong rate and a silent bus look alike.
    FramesOnly,
}

/// Which bit rates a controller can be set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RateChoice<'a> {
    /// Any between these that its bit timing can make.
    Between(Bitrate, Bitrate),
    /// Only these.
    Only(&'a [Bitrate]),
}

/// What a controller can do with CAN FD.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FdSupport {
    /// It takes CAN FD frames for errors.
    Classic,
    /// It receives CAN FD frames.
    Fd,
}

/// What a controller can be set to, and what it tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capabilities<'a> {
    /// Nominal bit rates.
    pub rates: RateChoice<'a>,
    /// What it tells about a wrong rate.
    pub evidence: Evidence,
    /// CAN FD.
    pub fd: FdSupport,
    /// The longest that [`Controller::configure`] and [`Controller::start_monitoring`] may take
    /// together \[T_cc, Koppe\].
    pub reconfiguration: Micros,
    /// The longest that an observation may be on its way to [`Controller::observe`].
    pub latency: Micros,
}

/// What a controller was really set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Configured {
    /// The nominal bit rate that clock and bit timing make, read back where that is possible.
    pub nominal: Bitrate,
    /// The data bit rate likewise.
    pub data: Option<Bitrate>,
}

/// A CAN controller that listens: limits, configure, start monitoring, events, stop.
///
/// There is no method that transmits, acknowledges or sends an error flag, and an implementation
/// must not: [`Self::start_monitoring`] enters bus monitoring (listen-only) or fails.
pub trait Controller {
    /// What can go wrong with the controller itself; trouble on the bus is an [`Observation`].
    type Error;

    /// What it can be set to, and what it tells.
    fn capabilities(&self) -> Capabilities<'_>;

    /// Sets the bit timing, while stopped, and says what it really became.
    ///
    /// # Errors
    /// The controller's, also if it cannot make the rate.
    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, Self::Error>;

    /// Starts to listen, with every frame accepted and what the FIFO held before thrown away.
    ///
    /// # Errors
    /// The controller's, also if it cannot listen without transmitting.
    fn start_monitoring(&mut self) -> Result<(), Self::Error>;

    /// The oldest thing heard that was not told yet; does not wait.
    ///
    /// # Errors
    /// The controller's.
    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, Self::Error>;

    /// Stops listening; the line stays recessive.
    ///
    /// # Errors
    /// The controller's.
    fn stop(&mut self) -> Result<(), Self::Error>;
}
