//! What a listening controller heard.

use crate::units::Micros;
use crate::wire::Frame;

/// Where a frame comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// From the bus.
    Bus,
    /// From this host: the driver or the network stack handed a frame of a local process back.
    Local,
}

/// A frame that the controller accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameSeen {
    /// The frame.
    pub frame: Frame,
    /// Where it comes from.
    pub origin: Origin,
    /// When it was received, on the scan's clock, where driver or hardware say so: a FIFO may hold
    /// frames from before the last change of rate.
    pub received: Option<Micros>,
}

/// The kind of a protocol error [ISO 11898-1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorClass {
    /// Six equal bits where stuffing forbids them.
    Stuff,
    /// A bit of fixed form has the wrong level.
    Form,
    /// The CRC does not match.
    Crc,
    /// A bit error; a controller that only listens sees one where it could not drive its own flag.
    Bit,
    /// Nobody acknowledged.
    Acknowledge,
    /// An error that the controller does not tell more about.
    Unknown,
}

/// Where in a frame an error was, as far as it matters to a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorPlace {
    /// SOF, identifier, RTR: where the controller tells this apart.
    Arbitration,
    /// From SOF to the CRC sequence, or behind [`Self::Arbitration`] where that is told apart.
    BeforeCrcEnd,
    /// The CRC delimiter, with the CRC sequence read.
    CrcDelimiter,
    /// The ACK slot.
    AckSlot,
    /// The ACK delimiter: all that precedes it had the right form. With [`ErrorClass::Crc`] the CRC
    /// was wrong; else a dominant level stands there, as behind a frame that nobody acknowledges.
    AckDelimiter,
    /// End of frame.
    EndOfFrame,
    /// An error or overload flag, a delimiter, intermission.
    Between,
    /// The controller does not say.
    Unknown,
}

/// A protocol error that the controller reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ErrorSeen {
    /// Its kind.
    pub class: ErrorClass,
    /// Its place.
    pub place: ErrorPlace,
    /// When, as for [`FrameSeen::received`].
    pub received: Option<Micros>,
}

/// What a controller tells a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: observations live on the stack")]
pub enum Observation {
    /// A frame.
    Frame(FrameSeen),
    /// A protocol error.
    Error(ErrorSeen),
    /// The receive error counter, where the controller counts but does not report errors: read
    /// once when listening begins, and again from time to time.
    ReceiveErrors(u16),
    /// Edges on the line since the last such observation, where the controller counts them.
    Edges(u32),
    /// Frames or errors were lost (FIFO overrun).
    Lost,
}
