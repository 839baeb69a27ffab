//! Why a capture cannot be read: always a place and a reason.

use core::fmt;
use std::io;

use crate::Format;
use crate::capture::Channel;

/// Where in a file something is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// A byte offset from 0 in the file.
    Byte(u64),
    /// A line from 1 of a text file.
    Line(u64),
    /// A member of a zip archive.
    Member(String),
    /// A byte offset from 0 in the inflated content of a member.
    MemberByte(String, u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(at) => write!(f, "at byte {at}"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Member(name) => write!(f, "member {name:?}"),
            Self::MemberByte(name, at) => write!(f, "member {name:?} at byte {at}"),
        }
    }
}

/// Why a capture cannot be read.
///
/// The text is one line and does not name the file: who opened it knows its name.
///
/// ```
/// use canbaud_capture::{CaptureError, OpenOptions, from_reader};
/// let error = from_reader(std::io::Cursor::new(b""), &OpenOptions::default()).unwrap_err();
/// assert!(matches!(error, CaptureError::Empty));
/// assert_eq!(error.to_string(), "the file is empty");
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The file cannot be opened.
    #[error("cannot open: {0}")]
    Open(#[source] io::Error),
    /// The operating system failed while reading.
    #[error("{place}: cannot read: {source}")]
    Read {
        /// How far reading had come.
        place: Place,
        /// What the system said.
        source: io::Error,
    },
    /// A directory was given.
    #[error("is a directory, not a capture file")]
    Directory,
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// No format fits the content.
    #[error("no known capture format fits the content ({0})")]
    Unrecognised(String),
    /// The format is known, but this variant of it is not read.
    #[error("{format}: {what}")]
    Unsupported {
        /// The format.
        format: Format,
        /// What is not read, and what is.
        what: String,
    },
    /// The file holds no sample rate and none was given.
    #[error("{0}: the file does not hold its sample rate; give it (samplerate)")]
    NoSamplerate(Format),
    /// The content contradicts its format.
    #[error("{place}: {reason}")]
    Damaged {
        /// Where.
        place: Place,
        /// What is wrong there.
        reason: String,
    },
    /// A channel was asked for that the file does not have.
    #[error("no channel {name:?}; there are {channels}")]
    NoSuchChannel {
        /// The name asked for.
        name: String,
        /// The names that there are, separated by commas.
        channels: String,
    },
    /// A bound against hostile files is passed.
    #[error("{what} is {value}, more than the limit of {max}")]
    Limit {
        /// What is bounded.
        what: &'static str,
        /// What the file says.
        value: u64,
        /// The bound.
        max: u64,
    },
}

impl CaptureError {
    /// That `name` is none of `channels`.
    #[must_use]
    pub fn no_such_channel(name: &str, channels: &[Channel]) -> Self {
        let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        Self::NoSuchChannel { name: name.to_owned(), channels: names.join(", ") }
    }

    pub(crate) fn damaged(place: Place, reason: impl Into<String>) -> Self {
        Self::Damaged { place, reason: reason.into() }
    }

    pub(crate) fn unsupported(format: Format, what: impl Into<String>) -> Self {
        Self::Unsupported { format, what: what.into() }
    }

    /// An I/O error at a byte of the file; an early end is damage, not a failure of the system.
    pub(crate) fn io(at: u64, source: io::Error) -> Self {
        let place = Place::Byte(at);
        match source.kind() {
            io::ErrorKind::UnexpectedEof => Self::damaged(place, "the file ends too early"),
            _ => Self::Read { place, source },
        }
    }
}

/// Why a reader stopped before the end.
pub(crate) enum Halt {
    /// The sink asked for it.
    Stopped,
    /// The file is bad.
    Failed(CaptureError),
}

impl From<CaptureError> for Halt {
    fn from(error: CaptureError) -> Self {
        Self::Failed(error)
    }
}
