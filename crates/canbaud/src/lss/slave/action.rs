//! What a slave wants of its node.

use crate::lss::{NodeId, RateSetting};
use crate::wire::Frame;

/// What the node has to do, at once and in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: actions live on the stack")]
pub enum SlaveAction {
    /// Send this frame.
    Send(Frame),
    /// Send nothing at all, LSS or not, until [`SlaveAction::ResumeSending`]: take back what waits
    /// in the controller. The node goes on listening.
    StopSending,
    /// Set the controller to this bit rate. [`RateSetting::Automatic`]: listen silently until the
    /// bit rate is found, set the controller to it, and call [`rate_found`](super::Slave::rate_found).
    SwitchBitRate(RateSetting),
    /// The node may send again.
    ResumeSending,
    /// Enter the NMT state reset communication by itself: the device had no node-ID and was given
    /// this one. It calls [`reset_communication`](super::Slave::reset_communication) and boots up with it.
    ResetCommunication(NodeId),
}
