//! Why a command came to nothing: one line, a hint, an exit code.

use std::fmt;
use std::io;
use std::time::Duration;

use canbaud::lss::{FastscanError, LssAddress, Outcome, Service, ServiceError};
use canbaud_link::LinkError;

use crate::exit::Exit;
use crate::printable::printable;
use crate::run::live::signal;

/// What went wrong.
#[derive(Debug)]
pub(crate) enum Trouble {
    /// The command line asks for something impossible.
    Usage(String),
    /// Transmitting was not allowed.
    NotAllowed(String),
    /// The channel.
    Link(LinkError),
    /// A service.
    Service(Service, ServiceError),
    /// A scan.
    Fastscan(FastscanError),
    /// No device answered a scan.
    NobodyFound,
    /// The same device answered again.
    Again(LssAddress),
    /// The device did not come back.
    NotBack(Duration),
    /// A signal of this number came.
    Stopped(u8),
    /// The channel is not as it was found, and how a person puts it back.
    NotRestored(LinkError, Option<String>),
    /// The output cannot be written.
    Output(io::Error),
}

impl From<LinkError> for Trouble {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        match (error.kind(), signal()) {
            (io::ErrorKind::Interrupted, Some(signal)) => Self::Stopped(signal),
            _ => Self::Output(error),
        }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => f.write_str(what),
            Self::NotAllowed(channel) => write!(f, "this transmits on {channel}: say --transmit"),
            Self::Link(error) => f.write_str(&printable(&error.to_string())),
            Self::Stopped(signal) => write!(f, "stopped by signal {signal}"),
            Self::Service(service, ServiceError::Refused(outcome)) => {
                write!(f, "{}: the device refuses: {}", name(service), reason(service, *outcome))
            }
            Self::Service(service, error) => write!(f, "{}: {error}", name(service)),
            Self::Fastscan(error) => write!(f, "fastscan: {error}"),
            Self::NobodyFound => f.write_str("no device without node-ID answers"),
            Self::Again(address) => write!(
                f,
                "{address} answers the scan again although it was found: the scan ends here"
            ),
            Self::NotBack(time) => {
                let seconds = time.as_secs_f64();
                write!(
                    f,
                    "the device did not answer within {seconds} s at the bit rate of this bus"
                )
            }
            Self::NotRestored(error, _) => f.write_str(&printable(&error.to_string())),
            Self::Output(error) => write!(f, "cannot write: {error}"),
        }
    }
}

impl Trouble {
    pub(super) fn hint(&self) -> Option<String> {
        if let Self::NotRestored(_, Some(way)) = self {
            return Some(format!("put it back by hand: {}", printable(way)));
        }
        self.fixed_hint().map(str::to_owned)
    }

    const fn fixed_hint(&self) -> Option<&'static str> {
        match self {
            Self::NotAllowed(_) => Some("--dry-run shows the frames and opens nothing"),
            Self::Service(_, ServiceError::NoAnswer(_)) => Some(
                "is the bit rate right and the interface in normal mode? An address has to be \
                 exact; canbaud lss scan finds those without node-ID",
            ),
            Self::NobodyFound => Some(
                "is the bit rate right? At a wrong one, this disturbs the bus. Those with a node-ID \
                 never answer a scan: canbaud lss inquire",
            ),
            Self::Service(_, ServiceError::SeveralAnswers) => {
                Some("name one with --address, or let one alone on the bus")
            }
            Self::NotBack(_) => Some(
                "a device that detects needs traffic and a listener that acknowledges; canbaud lss \
                 inquire asks again",
            ),
            _ => None,
        }
    }

    pub(super) fn exit(&self) -> Exit {
        match self {
            Self::Usage(_) | Self::NotAllowed(_) => Exit::Usage,
            Self::Link(_) | Self::NotRestored(..) => Exit::Unusable,
            Self::Stopped(signal) => Exit::Stopped(*signal),
            Self::Service(_, ServiceError::NoAnswer(_)) | Self::NotBack(_) | Self::NobodyFound => {
                Exit::NoTraffic
            }
            Self::Service(..) | Self::Fastscan(_) | Self::Again(_) => Exit::Undecided,
            // A reader that has seen enough is no trouble.
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => Exit::Found,
            Self::Output(_) => Exit::Unreadable,
        }
    }
}

/// The service in words [CiA 305].
pub(super) const fn name(service: &Service) -> &'static str {
    match service {
        Service::SwitchStateGlobal(_) => "switch state global",
        Service::SwitchStateSelective(_) => "switch state selective",
        Service::ConfigureNodeId(_) => "configure node-ID",
        Service::ConfigureBitTiming { .. } => "configure bit timing",
        Service::StoreConfiguration => "store configuration",
        Service::InquireIdentity(_) => "inquire identity",
        Service::InquireNodeId => "inquire node-ID",
        Service::IdentifyRemoteSlave(_) => "identify remote slave",
        Service::IdentifyNonConfiguredRemoteSlave => "identify non-configured remote slave",
    }
}

/// What an error code means for a service.
fn reason(service: &Service, outcome: Outcome) -> String {
    let meaning = match (service, outcome.error_code) {
        (Service::ConfigureNodeId(_), 1) => "node-ID out of range",
        (Service::ConfigureBitTiming { .. }, 1) => "bit timing not supported",
        (Service::StoreConfiguration, 1) => "storing not supported",
        (Service::StoreConfiguration, 2) => "the storage medium cannot be accessed",
        (_, 255) => return outcome.to_string(),
        _ => "reserved error code",
    };
    format!("{meaning} ({outcome})")
}
