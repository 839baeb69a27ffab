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
    ///
    /// # Errors
    /// What is wrong with a name that can only be a live bus.
    pub(crate) fn parse(source: &Path) -> Result<Option<Self>, String> {
        let Some(text) = source.to_str() else { return Ok(None) };
        if let Some(rest) = text.strip_prefix("slcan:") {
            return slcan(rest).map(Some);
        }
        if let Some(rest) = text.strip_prefix("replay:") {
            return replay(rest).map(Some);
        }
        if let Some(name) = text.strip_prefix("socketcan:") {
            return match name {
                "" => Err("socketcan: wants an interface: socketcan:can0".to_owned()),
                _ => Ok(Some(Self::Interface(name.to_owned()))),
            };
        }
        if is_serial_port(source) {
            // Not asked unasked: whatever is there would be sent a command.
            return Err(format!(
                "{text} is a serial port; of an adapter with slcan firmware, say slcan:{text}"
            ));
        }
        let interface = !source.exists()
            && !text.contains('/')
            && (Path::new("/sys/class/net").join(text).exists() || is_called_like_one(text));
        Ok(interface.then(|| Self::Interface(text.to_owned())))
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

/// What follows `slcan:`.
fn slcan(rest: &str) -> Result<LiveSource, String> {
    let port = |port: &str, baud| LiveSource::Slcan { port: port.to_owned(), baud };
    match rest.rsplit_once('@') {
        _ if rest.is_empty() => Err("slcan: wants a serial port: slcan:/dev/ttyACM0".to_owned()),
        Some((path, baud)) if !Path::new(rest).exists() => match baud.parse() {
            Ok(baud) if baud > 0 && !path.is_empty() => Ok(port(path, baud)),
            _ => Err(format!(
                "slcan:{rest}: behind @ stands the bit rate of the serial port, such as \
                 slcan:/dev/ttyUSB0@{BAUD}"
            )),
        },
        Some(_) | None => Ok(port(rest, BAUD)),
    }
}

/// What follows `replay:`.
fn replay(rest: &str) -> Result<LiveSource, String> {
    let replay = |path: &str, channel: Option<&str>| LiveSource::Replay {
        path: PathBuf::from(path),
        channel: channel.map(str::to_owned),
    };
    match rest.rsplit_once('#') {
        _ if rest.is_empty() => Err("replay: wants a capture file: replay:bus.sr".to_owned()),
        Some((path, channel)) if !Path::new(rest).exists() => match (path, channel) {
            ("", _) | (_, "") => Err(format!(
                "replay:{rest}: a file and a channel are wanted, such as replay:bus.sr#RX"
            )),
            _ => Ok(replay(path, Some(channel))),
        },
        Some(_) | None => Ok(replay(rest, None)),
    }
}

/// A terminal device that is there, or a name that only such a device has.
fn is_serial_port(source: &Path) -> bool {
    let named = |path: &Path| {
        let text = path.to_string_lossy();
        let begins = |begin: &&str| text.starts_with(begin);
        ["/dev/tty", "/dev/cu.", "/dev/pts/", "/dev/serial/"].iter().any(begins)
    };
    let windows = source.to_str().and_then(|text| text.strip_prefix("COM"));
    let is_com = |digits: &str| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    match source.canonicalize() {
        Ok(real) => is_device(&real) && named(&real),
        Err(_) => named(source) || windows.is_some_and(is_com),
    }
}

#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    path.metadata().is_ok_and(|data| data.file_type().is_char_device())
}

#[cfg(not(unix))]
fn is_device(_: &Path) -> bool {
    true
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
        LiveSource::parse(Path::new(text)).unwrap()
    }

    fn refused(text: &str) -> String {
        LiveSource::parse(Path::new(text)).unwrap_err()
    }

    fn slcan(port: &str, baud: u32) -> Option<LiveSource> {
        Some(LiveSource::Slcan { port: port.to_owned(), baud })
    }

    #[test]
    fn serial_ports_may_name_their_bit_rate() {
        assert_eq!(parse("slcan:/dev/ttyACM0"), slcan("/dev/ttyACM0", 115_200));
        assert_eq!(parse("slcan:/dev/ttyUSB0@3000000"), slcan("/dev/ttyUSB0", 3_000_000));
        assert_eq!(parse("slcan:COM3"), slcan("COM3", 115_200));
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        assert_eq!(refused("slcan:"), "slcan: wants a serial port: slcan:/dev/ttyACM0");
        for wrong in ["slcan:/dev/ttyUSB0@fast", "slcan:/dev/ttyUSB0@", "slcan:/dev/ttyUSB0@0"] {
            let why = refused(wrong);
            assert!(why.starts_with(wrong) && why.contains("slcan:/dev/ttyUSB0@115200"), "{why}");
        }
        assert!(refused("replay:").contains("replay:bus.sr"));
        assert!(refused("replay:bus.sr#").contains("replay:bus.sr#RX"));
        assert!(refused("socketcan:").contains("socketcan:can0"));
    }

    #[test]
    fn a_serial_port_gets_its_prefix() {
        for port in ["/dev/ttyACM99", "/dev/cu.usbmodem99", "/dev/serial/by-id/none", "COM3"] {
            assert!(refused(port).ends_with(&format!("say slcan:{port}")), "{port}");
        }
        for file in ["COM", "COM3.sr", "/dev/null", "/dev/stdin.sr", "ttyACM0"] {
            assert_eq!(parse(file), None, "{file}");
        }
    }

    /// An at sign or a hash in the name of what is there.
    #[test]
    fn what_exists_is_meant_as_it_is_written() {
        let directory = tempfile::tempdir().unwrap();
        let odd = directory.path().join("odd@name#1");
        std::fs::write(&odd, "").unwrap();
        let odd = odd.to_str().unwrap();
        assert_eq!(parse(&format!("slcan:{odd}")), slcan(odd, 115_200));
        let replay = LiveSource::Replay { path: PathBuf::from(odd), channel: None };
        assert_eq!(parse(&format!("replay:{odd}")), Some(replay));
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
