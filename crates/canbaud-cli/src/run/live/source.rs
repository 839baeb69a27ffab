//! Which of the sources is a live bus.

use std::fmt;
use std::path::{Path, PathBuf};

use canbaud_link::replay::ReplayListener;
use canbaud_link::slcan::{SilentMode, SlcanListener};
use canbaud_link::{Clock, LinkError, Listener};

use super::LiveArgs;

/// Bit rate of a serial port, where it matters at all.
const BAUD: u32 = 115_200;

/// A live bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum LiveSource {
    /// An interface of Linux.
    Interface(String),
    /// A serial port with a slcan adapter.
    Slcan {
        /// Its path.
        port: String,
        /// Its bit rate.
        baud: u32,
    },
    /// A capture file that plays the bus.
    Replay {
        /// Its path.
        path: PathBuf,
        /// Its channel; the first one unless it is named.
        channel: Option<String>,
    },
}

impl LiveSource {
    /// The live bus that `source` names; `None` for a file.
    ///
    /// A file of the same name goes first; an interface is one that exists, or is called like one.
    pub(crate) fn parse(source: &Path) -> Option<Self> {
        let text = source.to_str()?;
        if let Some(rest) = text.strip_prefix("slcan:") {
            let (port, baud) = match rest.rsplit_once('@') {
                Some((port, baud)) => match baud.parse() {
                    Ok(baud) if baud > 0 => (port, baud),
                    _ => (rest, BAUD),
                },
                None => (rest, BAUD),
            };
            return Some(Self::Slcan { port: port.to_owned(), baud });
        }
        if let Some(rest) = text.strip_prefix("replay:") {
            let (path, channel) = match rest.rsplit_once('#') {
                Some((path, channel)) => (path, Some(channel.to_owned())),
                None => (rest, None),
            };
            return Some(Self::Replay { path: PathBuf::from(path), channel });
        }
        if let Some(name) = text.strip_prefix("socketcan:") {
            return Some(Self::Interface(name.to_owned()));
        }
        let interface = !source.exists()
            && !text.contains('/')
            && (Path::new("/sys/class/net").join(text).exists() || is_called_like_one(text));
        interface.then(|| Self::Interface(text.to_owned()))
    }

    /// Opens it to listen.
    pub(super) fn open(
        &self,
        args: &LiveArgs,
        clock: Clock,
    ) -> Result<Box<dyn Listener>, LinkError> {
        match self {
            Self::Interface(name) => interface(name, clock),
            Self::Slcan { port, baud } => {
                let silent = if args.trust_m1 { SilentMode::Trusted } else { SilentMode::Refused };
                Ok(Box::new(SlcanListener::open(port, *baud, silent, clock)?))
            }
            Self::Replay { path, channel } => {
                Ok(Box::new(ReplayListener::open(path, channel.as_deref(), clock)?))
            }
        }
    }
}

#[cfg(target_os = "linux")]
fn interface(name: &str, clock: Clock) -> Result<Box<dyn Listener>, LinkError> {
    Ok(Box::new(canbaud_link::socketcan::SocketCanListener::open(name, clock)?))
}

#[cfg(not(target_os = "linux"))]
fn interface(_: &str, _: Clock) -> Result<Box<dyn Listener>, LinkError> {
    Err(LinkError::NoKernelCan)
}

/// `can0`, `vcan1`, `slcan2`: letters that end in `can`, and a number.
fn is_called_like_one(text: &str) -> bool {
    let letters = text.trim_end_matches(|c: char| c.is_ascii_digit());
    letters.len() < text.len()
        && letters.ends_with("can")
        && letters.chars().all(|c| c.is_ascii_lowercase())
}

impl fmt::Display for LiveSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::Interface(name) => name.into(),
            Self::Slcan { port, .. } => port.into(),
            Self::Replay { path, .. } => path.to_string_lossy(),
        };
        f.write_str(&crate::printable::printable(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<LiveSource> {
        LiveSource::parse(Path::new(text))
    }

    fn slcan(port: &str, baud: u32) -> Option<LiveSource> {
        Some(LiveSource::Slcan { port: port.to_owned(), baud })
    }

    #[test]
    fn serial_ports_may_name_their_bit_rate() {
        assert_eq!(parse("slcan:/dev/ttyACM0"), slcan("/dev/ttyACM0", 115_200));
        assert_eq!(parse("slcan:/dev/ttyUSB0@3000000"), slcan("/dev/ttyUSB0", 3_000_000));
        assert_eq!(parse("slcan:COM3"), slcan("COM3", 115_200));
        assert_eq!(parse("slcan:/dev/odd@name"), slcan("/dev/odd@name", 115_200));
    }

    #[test]
    fn a_replay_may_name_its_channel() {
        let replay = |path: &str, channel: Option<&str>| {
            let channel = channel.map(str::to_owned);
            Some(LiveSource::Replay { path: PathBuf::from(path), channel })
        };
        assert_eq!(parse("replay:bus.sr"), replay("bus.sr", None));
        assert_eq!(parse("replay:a b/bus.sr#CAN RX"), replay("a b/bus.sr", Some("CAN RX")));
    }

    #[test]
    fn files_are_no_interfaces() {
        for name in ["can0", "vcan12", "slcan1"] {
            assert_eq!(parse(name), Some(LiveSource::Interface(name.to_owned())));
        }
        for name in ["bus.sr", "can0.vcd", "./can0", "scan", "Cargo.toml", "scan.sr1"] {
            assert_eq!(parse(name), None, "{name}");
        }
        assert_eq!(parse("socketcan:odd"), Some(LiveSource::Interface("odd".to_owned())));
    }
}
