//! Where to transmit.

use std::fmt;
use std::net::Ipv4Addr;
use std::path::Path;
use std::str::FromStr;

use canbaud::units::Bitrate;
#[cfg(target_os = "linux")]
use canbaud_link::bus::SocketCanBus;
use canbaud_link::bus::{FrameBus, MulticastBus, SlcanBus};

use super::trouble::Trouble;
use crate::run::live::LiveSource;

/// A channel that the user named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Channel {
    /// An interface of Linux.
    Interface(String),
    /// A serial port with a slcan adapter.
    Slcan {
        /// Its path.
        port: String,
        /// Its bit rate.
        baud: u32,
    },
    /// UDP multicast.
    Multicast(Ipv4Addr, u16),
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(rest) = text.strip_prefix("udp:") {
            return multicast(rest);
        }
        let source = if text.starts_with("/dev/") {
            LiveSource::parse(Path::new(&format!("slcan:{text}")))?
        } else {
            LiveSource::parse(Path::new(text))?
        };
        let wanted = "a channel is wanted: can0, slcan:/dev/ttyACM0 or udp:239.74.163.2:43113";
        match source {
            Some(LiveSource::Interface(name)) => Ok(Self::Interface(name)),
            Some(LiveSource::Slcan { port, baud }) => Ok(Self::Slcan { port, baud }),
            Some(LiveSource::Replay { .. }) => Err("nothing can be sent to a recording".to_owned()),
            None => Err(wanted.to_owned()),
        }
    }
}

fn multicast(text: &str) -> Result<Channel, String> {
    let (group, port) = text.split_once(':').unwrap_or((text, ""));
    let group: Ipv4Addr =
        group.parse().map_err(|_| "udp: wants an IPv4 multicast group".to_owned())?;
    if !group.is_multicast() {
        return Err("udp: wants a multicast group, 224.0.0.0 to 239.255.255.255".into());
    }
    let port = match port {
        "" => MulticastBus::PORT,
        port => port.parse().map_err(|_| "a port is 0 to 65535".to_owned())?,
    };
    Ok(Channel::Multicast(group, port))
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interface(name) | Self::Slcan { port: name, .. } => {
                f.write_str(&crate::printable::printable(name))
            }
            Self::Multicast(group, port) => write!(f, "udp:{group}:{port}"),
        }
    }
}

impl Channel {
    /// Opens it for sending.
    pub(crate) fn open(&self, bitrate: Option<Bitrate>) -> Result<Box<dyn FrameBus>, Trouble> {
        Ok(match self {
            #[cfg(target_os = "linux")]
            Self::Interface(name) => {
                let mut bus = SocketCanBus::open(name)?;
                if let Some(bitrate) = bitrate {
                    bus.set_bitrate(bitrate)?;
                }
                Box::new(bus)
            }
            #[cfg(not(target_os = "linux"))]
            Self::Interface(_) => {
                return Err(canbaud_link::LinkError::NoKernelCan.into());
            }
            Self::Slcan { port, baud } => {
                let bitrate = bitrate.ok_or_else(|| {
                    Trouble::Usage(format!(
                        "{port} needs --bitrate: an adapter has none of its own"
                    ))
                })?;
                Box::new(SlcanBus::open(port, *baud, bitrate)?)
            }
            Self::Multicast(group, port) => Box::new(MulticastBus::join(*group, *port)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_told_by_their_form() {
        let interface = |name: &str| Ok(Channel::Interface(name.to_owned()));
        assert_eq!("can0".parse(), interface("can0"));
        assert_eq!("vcan0".parse(), interface("vcan0"));
        for text in ["/dev/ttyACM0", "slcan:/dev/ttyACM0"] {
            let port = "/dev/ttyACM0".to_owned();
            assert_eq!(text.parse(), Ok(Channel::Slcan { port, baud: 115_200 }), "{text}");
        }
        let udp = Channel::Multicast(Ipv4Addr::new(239, 0, 0, 1), 5000);
        assert_eq!("udp:239.0.0.1:5000".parse(), Ok(udp));
        for bad in [
            "udp:10.0.0.1",
            "udp:239.0.0.1:x",
            "bus.sr",
            "replay:bus.sr",
            "slcan:",
            "slcan:/dev/ttyACM0@fast",
        ] {
            assert!(bad.parse::<Channel>().is_err(), "{bad}");
        }
    }
}
