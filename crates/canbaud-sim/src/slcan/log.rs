//! What a host asked of the adapter, and what the adapter did to the bus.

use core::fmt;

use crate::node::Mode;
use crate::time::Time;

/// One line of the log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// When.
    pub at: Time,
    /// What.
    pub what: What,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum What {
    /// The host sent a command.
    Command {
        /// The command without its CR, other than printable characters escaped.
        text: String,
        /// What became of it.
        effect: Effect,
    },
    /// The adapter was not silent: it sent an active error flag.
    ErrorFlag,
    /// The adapter was not silent: it acknowledged a frame.
    Acknowledged,
}

/// What became of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Unknown, not allowed now, or out of range: nothing happened.
    Refused,
    /// Something was set, or there was nothing to do.
    Set,
    /// A question was answered.
    Answered,
    /// The channel opened.
    Opened(Mode),
    /// The channel closed.
    Closed,
    /// A frame waits to be sent.
    Sent,
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Refused => "refused",
            Self::Set => "set",
            Self::Answered => "answered",
            Self::Opened(Mode::BusMonitoring) => "open listen-only",
            Self::Opened(Mode::Loopback) => "open loopback",
            Self::Opened(Mode::Normal | Mode::Restricted | Mode::Disabled) => "open normal",
            Self::Closed => "closed",
            Self::Sent => "sent",
        })
    }
}

/// Seconds, the command, and after a colon what became of it.
impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let us = self.at.femtoseconds() / 1_000_000_000;
        write!(f, "{}.{:06} ", us / 1_000_000, us % 1_000_000)?;
        match &self.what {
            What::Command { text, effect } => write!(f, "{text}: {effect}"),
            What::ErrorFlag => f.write_str("! error flag on the bus"),
            What::Acknowledged => f.write_str("! frame acknowledged"),
        }
    }
}

/// The text of a command that may be anything.
pub(super) fn printable(line: &[u8]) -> String {
    line.escape_ascii().to_string()
}
