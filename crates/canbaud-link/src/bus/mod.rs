//! Channels that transmit, for what the user asked for by name; a scan never sees one.
//!
//! | channel | where |
//! |---|---|
//! | [`SocketCanBus`] | an interface of Linux, vcan included |
//! | [`SlcanBus`] | a serial adapter |
//! | [`MulticastBus`] | UDP multicast, as python-can's `udp_multicast` speaks it |
//! | [`MemoryNet`] | within a program: nodes hear each other at the same bit rate |

mod memory;
mod multicast;
#[cfg(target_os = "linux")]
mod rate;
mod slcan;
#[cfg(target_os = "linux")]
mod socketcan;

use std::time::Duration;

use canbaud::units::Bitrate;
use canbaud::wire::Frame;

use crate::LinkError;

pub use memory::{MemoryBus, MemoryNet};
pub use multicast::MulticastBus;
pub use slcan::SlcanBus;
#[cfg(target_os = "linux")]
pub use socketcan::SocketCanBus;

/// A channel that sends and receives frames.
///
/// ```
/// use canbaud::units::Bitrate;
/// use canbaud::wire::{Frame, FrameKind, Id};
/// use canbaud_link::bus::{FrameBus, MemoryNet};
/// use std::time::Duration;
/// let net = MemoryNet::new();
/// let mut master = net.join(Bitrate::new(125_000).unwrap());
/// let mut slave = net.join(Bitrate::new(125_000).unwrap());
/// let frame = Frame::new(Id::Base(0x7E5), FrameKind::Data, 8, &[4, 1, 0, 0, 0, 0, 0, 0]).unwrap();
/// master.send(&frame).unwrap();
/// assert_eq!(slave.receive(Duration::ZERO).unwrap(), Some(frame));
/// ```
pub trait FrameBus {
    /// Sends a frame; returns when the channel has taken it.
    ///
    /// # Errors
    /// The channel cannot take it.
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError>;

    /// The next frame of another node, waited for up to `timeout`; own frames do not come back.
    ///
    /// # Errors
    /// The channel is gone.
    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError>;

    /// Changes the bit rate; what was received and not read yet is thrown away.
    ///
    /// # Errors
    /// The channel cannot be set to it.
    fn set_bitrate(&mut self, bitrate: Bitrate) -> Result<(), LinkError>;

    /// Whether there is no bit rate on it, and so nothing to be disturbed by a wrong one.
    fn is_virtual(&self) -> bool {
        false
    }

    /// What was set stays when the channel goes out of use; whether there was anything to keep.
    fn keep(&mut self) -> bool {
        false
    }

    /// Puts the channel back as it was found, unless it is kept; whether there was anything to put
    /// back.
    ///
    /// # Errors
    /// What could not be put back.
    fn restore(&mut self) -> Result<bool, LinkError> {
        Ok(false)
    }

    /// How a person puts it back where [`Self::restore`] cannot.
    fn by_hand(&self) -> Option<String> {
        None
    }
}
