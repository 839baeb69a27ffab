//! What can go wrong with an adapter; trouble on the bus is no error.

use std::io;

use canbaud::units::Bitrate;

/// Whose problem it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// The user may not do that.
    Permission,
    /// The adapter is absent, gone, or cannot do what a scan needs.
    Unusable,
    /// A recording cannot be read.
    Unreadable,
}

/// What can go wrong with an adapter.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The kernel refuses to change the interface.
    #[error("setting up {interface} needs the capability CAP_NET_ADMIN")]
    Permission {
        /// The interface.
        interface: String,
    },
    /// The serial port may not be opened.
    #[error("no permission to open {port}")]
    PortPermission {
        /// Its path.
        port: String,
    },
    /// There is no such port.
    #[error("there is no serial port {port}")]
    NoPort {
        /// What was asked for.
        port: String,
    },
    /// What is there is no serial port.
    #[error("{port} is no serial port")]
    NotSerial {
        /// Its path.
        port: String,
    },
    /// Another program has the port.
    #[error("another program uses {port}")]
    PortBusy {
        /// Its path.
        port: String,
    },
    /// There is no such interface.
    #[error("there is no interface {name}{}", among(.available))]
    NoInterface {
        /// What was asked for.
        name: String,
        /// The CAN interfaces that there are.
        available: Vec<String>,
    },
    /// The interface is no CAN interface.
    #[error("{name} is no CAN interface")]
    NotCan {
        /// The interface.
        name: String,
    },
    /// The interface has no bit rate at all (vcan, vxcan).
    #[error("{name} is a virtual CAN interface: it has no bit rate to find")]
    Virtual {
        /// The interface.
        name: String,
    },
    /// The kernel has no CAN.
    #[error("this kernel has no CAN sockets")]
    NoKernelCan,
    /// The adapter cannot listen without disturbing the bus.
    #[error("{adapter} cannot listen without disturbing the bus: {reason}")]
    NoListenOnly {
        /// The adapter.
        adapter: String,
        /// Why.
        reason: String,
    },
    /// The adapter cannot be set to this rate.
    #[error("{adapter} cannot be set to {rate}: {reason}")]
    Rate {
        /// The adapter.
        adapter: String,
        /// What was wanted.
        rate: Bitrate,
        /// What it can.
        reason: String,
    },
    /// What was read back is not what was set.
    #[error("{adapter}: {what} was set, but reads back as {got}")]
    NotTaken {
        /// The adapter.
        adapter: String,
        /// What was set.
        what: String,
        /// What it is.
        got: String,
    },
    /// A state that could not be restored.
    #[error("{adapter} could not be put back as it was found: {reason}")]
    NotRestored {
        /// The adapter.
        adapter: String,
        /// What happened.
        reason: String,
    },
    /// The adapter went away.
    #[error("{adapter} is gone: unplugged, or its driver was removed")]
    Gone {
        /// The adapter.
        adapter: String,
    },
    /// Nothing that speaks slcan answers.
    #[error("{adapter}: no answer to {command}")]
    NoAnswer {
        /// The adapter.
        adapter: String,
        /// What was sent.
        command: String,
    },
    /// The adapter refuses a command.
    #[error("{adapter} refuses {command}")]
    Refused {
        /// The adapter.
        adapter: String,
        /// What was sent.
        command: String,
    },
    /// The order of calls was wrong: a bus that is not set up cannot be heard.
    #[error("{adapter}: {what}")]
    State {
        /// The adapter.
        adapter: String,
        /// What is wrong.
        what: &'static str,
    },
    /// A recording cannot play the bus.
    #[error("{path}: {reason}")]
    Recording {
        /// Its path.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Whatever the system says.
    #[error("{what}: {source}")]
    Io {
        /// What was being done.
        what: String,
        /// The reason.
        source: io::Error,
    },
}

impl LinkError {
    /// Whose problem it is.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Permission { .. } | Self::PortPermission { .. } => ErrorKind::Permission,
            Self::Recording { .. } => ErrorKind::Unreadable,
            _ => ErrorKind::Unusable,
        }
    }

    pub(crate) fn io(what: impl Into<String>, source: impl Into<io::Error>) -> Self {
        Self::Io { what: what.into(), source: source.into() }
    }
}

fn among(available: &[String]) -> String {
    match available {
        [] => "; this machine has no CAN interface".to_owned(),
        names => format!("; there are {}", names.join(", ")),
    }
}
