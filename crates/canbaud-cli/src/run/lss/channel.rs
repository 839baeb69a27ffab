//! Where to transmit.

use std::fmt;
use std::net::Ipv4Addr;
use std::str::FromStr;

use canbaud::units::Bitrate;
#[cfg(target_os = "linux")]
use canbaud_link::bus::SocketCanBus;
use canbaud_link::bus::{FrameBus, MulticastBus, SlcanBus};

use super::trouble::Trouble;

/// A channel that the user named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Channel {
    /// An interface of Linux.
    SocketCan(String),
    /// A serial port with an adapter.
    Serial(String),
    /// UDP multicast.
    Multicast(Ipv4Addr, u16),
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(rest) = text.strip_prefix("udp:") {
            let (group, port) = rest.split_once(':').unwrap_or((rest, ""));
            let group: Ipv4Addr =
                group.parse().map_err(|_| "udp: wants an IPv4 multicast group".to_owned())?;
            if !group.is_multicast() {
                return Err("udp: wants a multicast group, 224.0.0.0 to 239.255.255.255".into());
            }
            let port = match port {
                "" => MulticastBus::PORT,
                port => port.parse().map_err(|_| "a port is 0 to 65535".to_owned())?,
            };
            return Ok(Self::Multicast(group, port));
        }
        let serial = text.contains('/') || text.to_ascii_uppercase().starts_with("COM");
        Ok(if serial { Self::Serial(text.to_owned()) } else { Self::SocketCan(text.to_owned()) })
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SocketCan(name) | Self::Serial(name) => f.write_str(name),
            Self::Multicast(group, port) => write!(f, "udp:{group}:{port}"),
        }
    }
}

impl Channel {
    /// Opens it for sending.
    pub(super) fn open(
        &self,
        bitrate: Option<Bitrate>,
        baud: u32,
    ) -> Result<Box<dyn FrameBus>, Trouble> {
        Ok(match self {
            #[cfg(target_os = "linux")]
            Self::SocketCan(name) => {
                let mut bus = SocketCanBus::open(name)?;
                if let Some(bitrate) = bitrate {
                    bus.set_bitrate(bitrate)?;
                }
                Box::new(bus)
            }
            #[cfg(not(target_os = "linux"))]
            Self::SocketCan(name) => {
                return Err(Trouble::Usage(format!("{name}: only Linux has interfaces for CAN")));
            }
            Self::Serial(path) => {
                let bitrate = bitrate.ok_or_else(|| {
                    Trouble::Usage(format!(
                        "{path} needs --bitrate: an adapter has none of its own"
                    ))
                })?;
                Box::new(SlcanBus::open(path, baud, bitrate)?)
            }
            Self::Multicast(group, port) => Box::new(MulticastBus::join(*group, *port)?),
        })
    }

    /// Whether it is known that there is no bit rate on it, and nothing to be disturbed by a wrong
    /// one.
    pub(super) fn is_virtual(&self) -> bool {
        match self {
            Self::SocketCan(name) => name.starts_with("vcan") || name.starts_with("vxcan"),
            Self::Serial(_) => false,
            Self::Multicast(..) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_told_by_their_form() {
        let socket = |name: &str| Ok(Channel::SocketCan(name.to_owned()));
        assert_eq!("can0".parse(), socket("can0"));
        let serial = |name: &str| Ok(Channel::Serial(name.to_owned()));
        assert_eq!("/dev/ttyACM0".parse(), serial("/dev/ttyACM0"));
        assert_eq!("COM3".parse(), serial("COM3"));
        let udp = Channel::Multicast(Ipv4Addr::new(239, 0, 0, 1), 5000);
        assert_eq!("udp:239.0.0.1:5000".parse(), Ok(udp));
        assert!("udp:10.0.0.1".parse::<Channel>().is_err());
        assert!("udp:239.0.0.1:x".parse::<Channel>().is_err());
    }
}
