//! What goes in and out of a node.

use super::NmtCommand;
use crate::detect::scan::{Candidate, Configured, Observation};
use crate::fault::State;
use crate::units::Bitrate;
use crate::wire::Frame;

/// What the device has to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: frames live on the stack")]
pub enum Action {
    /// Switch the controller off; the line stays recessive. The timer goes on.
    Stop,
    /// Set the controller to this rate in bus monitoring (or with the gate closed), throw away what
    /// its FIFO holds, and say [`Input::Ready`] or [`Input::Refused`].
    Listen(Candidate),
    /// Set the controller to this rate in normal mode (gate open), with its error counters at 0,
    /// and say [`Input::Ready`] or [`Input::Refused`].
    TakePart(Candidate),
    /// Send this frame, and say [`Input::Sent`]. There is never more than one under way.
    Send(Frame),
    /// Keep this bit rate ([`super::save`]): it was right.
    Remember(Bitrate),
    /// The NMT master asks for a reset; the node itself sends its boot-up message again.
    Reset(NmtCommand),
}

/// Whether a node may send at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sending {
    /// It may.
    Allowed,
    /// It takes part, and sends no frame of its own.
    Forbidden,
}

/// What happened in the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: frames live on the stack")]
pub enum Input {
    /// The last [`Action::Listen`] or [`Action::TakePart`] is in force.
    Ready(Configured),
    /// The controller cannot do it: no such bit timing, or no bus monitoring.
    Refused,
    /// The controller heard something, in bus monitoring or in normal mode. In normal mode errors
    /// matter only until the first frame was received or sent.
    Heard(Observation),
    /// The frame of the last [`Action::Send`] was sent and acknowledged.
    Sent,
    /// The error state or the error counters of the controller in normal mode.
    Fault {
        /// What the controller says that it is.
        state: State,
        /// The transmit error counter, not looked at in bus-off.
        tec: u16,
        /// The receive error counter, not looked at in bus-off.
        rec: u16,
    },
}
