//! A serial port with an adapter at its other end.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use canbaud::detect::scan::{ErrorClass, ErrorPlace};
use canbaud::wire::Frame;
use serial2::{SerialPort, Settings};

use super::codec::{Line, Lines, Record};
use super::firmware::{Answers, Firmware};
use crate::LinkError;

/// An adapter that answers does so within this, over USB and at 115200 bit/s.
const PATIENCE: Duration = Duration::from_millis(300);
/// Never less, however quick it was: a loaded machine takes its time.
const PATIENCE_MIN: Duration = Duration::from_millis(100);
/// How long a command may take to be written.
const WRITING: Duration = Duration::from_millis(500);
/// Things heard that wait to be told; the oldest goes.
const HEARD: usize = 1024;
/// Bytes that are read at a time.
const CHUNK: usize = 4096;

/// What an adapter tells unasked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "one of these lives at a time")]
pub(crate) enum Heard {
    Frame(Frame),
    Error(ErrorClass, ErrorPlace),
    ReceiveErrors(u16),
    Flags(u8),
    Lost,
}

/// What an adapter says to a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Answer {
    /// CR.
    Done,
    /// BEL.
    Refused,
    /// A line.
    Text(Vec<u8>),
    /// Nothing in time.
    Nothing,
}

/// What is awaited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Awaited {
    /// CR or BEL.
    Confirmation,
    /// A line, or BEL.
    Text,
}

/// An open port.
#[derive(Debug)]
pub(crate) struct Channel {
    port: SerialPort,
    name: String,
    lines: Lines,
    heard: VecDeque<Heard>,
    /// The answer that came last, while one is awaited.
    answer: Option<Answer>,
    awaited: Option<Awaited>,
    slowest: Duration,
}

impl Channel {
    /// Opens the port at `path`, for this program alone.
    pub(crate) fn open(path: &str, baud: u32) -> Result<Self, LinkError> {
        let settings = |mut settings: Settings| {
            settings.set_raw();
            settings.set_baud_rate(baud)?;
            Ok(settings)
        };
        let mut port =
            SerialPort::open(path, settings).map_err(|error| cannot_open(path, error))?;
        // Where the system can: slcand or a modem manager on the same port would garble both.
        #[cfg(unix)]
        let _ = rustix::termios::ioctl_tiocexcl(&port);
        port.set_write_timeout(WRITING)
            .map_err(|error| LinkError::io(format!("cannot set up {path}"), error))?;
        Ok(Self {
            port,
            name: path.to_owned(),
            lines: Lines::new(),
            heard: VecDeque::new(),
            answer: None,
            awaited: None,
            slowest: Duration::ZERO,
        })
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// How long an answer is waited for.
    pub(crate) fn patience(&self) -> Duration {
        match self.slowest {
            Duration::ZERO => PATIENCE,
            slowest => (4 * slowest).clamp(PATIENCE_MIN, PATIENCE),
        }
    }

    /// Sends `command`, to which CR or BEL is the answer.
    pub(crate) fn command(&mut self, command: &str) -> Result<Answer, LinkError> {
        self.ask(command, Awaited::Confirmation, self.patience())
    }

    /// Sends `command`, to which a line is the answer.
    pub(crate) fn question(&mut self, command: &str) -> Result<Answer, LinkError> {
        self.ask(command, Awaited::Text, self.patience())
    }

    /// Sends `command` without waiting for anything.
    pub(crate) fn tell(&self, command: &[u8]) -> Result<(), LinkError> {
        self.port.write_all(command).map_err(|error| self.broken("write to", error))
    }

    /// What was heard and not told yet.
    pub(crate) fn next(&mut self) -> Option<Heard> {
        self.heard.pop_front()
    }

    /// Whether something was heard that was not told yet.
    pub(crate) fn has_news(&self) -> bool {
        !self.heard.is_empty()
    }

    /// Forgets what was heard.
    pub(crate) fn clear(&mut self) {
        self.heard.clear();
    }

    /// Reads what comes within `timeout`, at most once.
    pub(crate) fn read(&mut self, timeout: Duration) -> Result<(), LinkError> {
        let mut bytes = [0; CHUNK];
        // A timeout of 0 may mean for ever, less than 1 ms counts as 0.
        let timeout = timeout.max(Duration::from_millis(1));
        let read = self.port.set_read_timeout(timeout).and_then(|()| self.port.read(&mut bytes));
        match read {
            Ok(0) => Err(LinkError::Gone { adapter: self.name.clone() }),
            Ok(count) => {
                for byte in bytes.get(..count).unwrap_or_default() {
                    self.take(*byte);
                }
                Ok(())
            }
            Err(error) => match error.kind() {
                io::ErrorKind::TimedOut
                | io::ErrorKind::WouldBlock
                | io::ErrorKind::Interrupted => Ok(()),
                _ => Err(self.broken("read from", error)),
            },
        }
    }

    fn ask(
        &mut self,
        command: &str,
        awaited: Awaited,
        patience: Duration,
    ) -> Result<Answer, LinkError> {
        self.answer = None;
        self.awaited = Some(awaited);
        let asked = Instant::now();
        self.tell(format!("{command}\r").as_bytes())?;
        let answer = loop {
            if let Some(answer) = self.answer.take() {
                self.slowest = self.slowest.max(asked.elapsed());
                break answer;
            }
            match patience.checked_sub(asked.elapsed()) {
                Some(left) if !left.is_zero() => self.read(left)?,
                _ => break Answer::Nothing,
            }
        };
        self.awaited = None;
        Ok(answer)
    }

    fn take(&mut self, byte: u8) {
        let record = match self.lines.push(byte) {
            None => return,
            Some(Line::Bell) => {
                self.answer = Some(Answer::Refused);
                return;
            }
            // The answer to a question is no frame, whatever letter it begins with.
            Some(Line::Text(line)) if self.awaited == Some(Awaited::Text) && !line.is_empty() => {
                self.answer.get_or_insert(Answer::Text(line.to_vec()));
                return;
            }
            Some(Line::Text(line)) => Record::parse(line),
        };
        let heard = match record {
            // `A` ends what `A` fetches.
            Record::Done | Record::Text(b"A") => {
                if self.awaited == Some(Awaited::Confirmation) {
                    self.answer = Some(Answer::Done);
                }
                return;
            }
            Record::Frame(frame) => Heard::Frame(frame),
            Record::Error(class, place) => Heard::Error(class, place),
            Record::ReceiveErrors(count) => Heard::ReceiveErrors(count),
            Record::Flags(flags) => Heard::Flags(flags),
            Record::Lost => Heard::Lost,
            Record::Sent | Record::Text(_) => return,
        };
        if self.heard.len() == HEARD {
            self.heard.pop_front();
        }
        self.heard.push_back(heard);
    }

    fn broken(&self, what: &str, error: io::Error) -> LinkError {
        // EIO, ENXIO, ENODEV: what the system says of a port without a device.
        let gone = matches!(error.raw_os_error(), Some(5 | 6 | 19)) && cfg!(unix);
        let gone = gone || error.kind() == io::ErrorKind::BrokenPipe;
        if gone {
            LinkError::Gone { adapter: self.name.clone() }
        } else {
            LinkError::io(format!("cannot {what} {}", self.name), error)
        }
    }

    /// Closes the channel of the adapter, whatever state it is in, and asks who it is.
    pub(crate) fn identify(&mut self) -> Result<Firmware, LinkError> {
        // The first one ends what another program left half said; BEL is an answer, too.
        let first = self.command("C")?;
        let second = self.command("C")?;
        let text = |answer| match answer {
            Answer::Text(text) => text,
            Answer::Done | Answer::Refused | Answer::Nothing => Vec::new(),
        };
        let version = text(self.question("V")?);
        let confirms = first != Answer::Nothing || second != Answer::Nothing;
        // Who does not answer anything else is not asked anything else.
        let (mut detail, mut serial, mut controller) = Default::default();
        if confirms {
            detail = text(self.question("v")?);
            serial = text(self.question("N")?);
            if detail.windows(7).any(|part| part == b"canable") {
                controller = text(self.question("i")?);
            }
        }
        let answers = Answers {
            confirms,
            version: &version,
            detail: &detail,
            serial: &serial,
            controller: &controller,
        };
        self.clear();
        Firmware::identify(&answers).ok_or_else(|| LinkError::NoAnswer {
            adapter: self.name.clone(),
            command: "C and V".to_owned(),
        })
    }
}

/// ENOTTY: nothing serial is there.
const NOT_SERIAL: i32 = 25;

fn cannot_open(path: &str, error: io::Error) -> LinkError {
    let port = path.to_owned();
    match error.kind() {
        io::ErrorKind::PermissionDenied => LinkError::PortPermission { port },
        io::ErrorKind::NotFound => LinkError::NoPort { port },
        io::ErrorKind::ResourceBusy => LinkError::PortBusy { port },
        _ if cfg!(unix) && error.raw_os_error() == Some(NOT_SERIAL) => {
            LinkError::NotSerial { port }
        }
        _ => LinkError::io(format!("cannot open {path}"), error),
    }
}
