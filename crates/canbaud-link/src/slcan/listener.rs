//! A serial adapter as a controller that only listens.

use std::time::Duration;

use canbaud::detect::scan::{
    Candidate, Capabilities, Configured, Controller, ErrorSeen, Evidence, FdSupport, FrameSeen,
    Observation, Origin, RateChoice,
};
use canbaud::units::{Bitrate, Micros};

use super::channel::{Answer, Channel, Heard};
use super::firmware::Firmware;
use super::rate;
use crate::{Clock, LinkError, Listener};

/// Serial at 115200 bit/s, and the latency timer of a USB bridge.
const LATENCY: Micros = Micros::from_ms(50);
/// How often the flags are asked for.
const POLL: Micros = Micros::from_ms(20);
/// A command that no firmware has: who confirms it confirms anything.
const NONSENSE: &str = "#";

/// What to do with a firmware whose only way to listen is `M1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SilentMode {
    /// Refuse it: the published sources forget `M1` when the channel opens, and the adapter
    /// disturbs the bus.
    #[default]
    Refused,
    /// The user knows that this one honours it.
    Trusted,
}

/// Whether the channel of the adapter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Closed,
    Configured,
    Listening,
}

/// A serial adapter that only listens; closed when it goes out of use.
#[derive(Debug)]
pub struct SlcanListener {
    channel: Channel,
    firmware: Firmware,
    rates: Vec<Bitrate>,
    state: State,
    clock: Clock,
    /// When to ask for the flags.
    due: Micros,
    fetches: Fetches,
    /// Answers to `F` that told of errors.
    errors: u16,
    /// Whether the scan knows how many there were when listening began.
    count: Count,
}

/// Opening forgets the flags, so counting goes on from what it was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Count {
    Untold,
    Told,
}

/// Whether frames wait for `A`: CAN232 comes with auto-poll off, and to switch it on would change
/// what it remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fetches {
    Yes,
    No,
}

impl SlcanListener {
    /// Opens the port at `path`, closes the adapter's channel and finds out who it is.
    ///
    /// # Errors
    /// Nothing answers, or the adapter cannot listen without disturbing the bus.
    pub fn open(
        path: &str,
        baud: u32,
        silent: SilentMode,
        clock: Clock,
    ) -> Result<Self, LinkError> {
        let mut channel = Channel::open(path, baud)?;
        let firmware = channel.identify()?;
        let refuse = |reason: &str| LinkError::NoListenOnly {
            adapter: path.to_owned(),
            reason: reason.to_owned(),
        };
        match firmware {
            Firmware::CanableStock if silent == SilentMode::Refused => {
                return Err(refuse(
                    "the slcan firmware that CANable adapters come with has no L command, and its \
                     published sources forget M1 when the channel opens",
                ));
            }
            Firmware::Other if channel.command(NONSENSE)? == Answer::Done => {
                return Err(refuse(
                    "its firmware confirms commands that do not exist, so nobody knows whether it \
                     listens when told to",
                ));
            }
            Firmware::CanableStock
            | Firmware::Lawicel
            | Firmware::Usbtin
            | Firmware::Canable2 { .. }
            | Firmware::Other => {}
        }
        let rates = match rate::range(firmware) {
            Some(_) => Vec::new(),
            None => firmware.digits().iter().map(|digit| digit.1).collect(),
        };
        let (due, fetches) = (Micros(0), Fetches::No);
        Ok(Self {
            channel,
            firmware,
            rates,
            state: State::Closed,
            clock,
            due,
            fetches,
            errors: 0,
            count: Count::Told,
        })
    }

    /// Whose firmware it is.
    #[must_use]
    pub const fn firmware(&self) -> Firmware {
        self.firmware
    }

    const fn confirms(&self) -> bool {
        !matches!(self.firmware, Firmware::CanableStock)
    }

    /// Sends a command that has to be confirmed, where the firmware confirms anything.
    fn must(&mut self, command: &str) -> Result<(), LinkError> {
        if !self.confirms() {
            return self.channel.tell(format!("{command}\r").as_bytes());
        }
        let adapter = self.channel.name().to_owned();
        match self.channel.command(command)? {
            Answer::Done => Ok(()),
            Answer::Refused => Err(LinkError::Refused { adapter, command: command.to_owned() }),
            Answer::Nothing | Answer::Text(_) => {
                Err(LinkError::NoAnswer { adapter, command: command.to_owned() })
            }
        }
    }

    /// Closes the channel; a closed one may refuse that.
    fn close(&mut self) -> Result<(), LinkError> {
        if !self.confirms() {
            self.channel.tell(b"C\r")?;
        } else if self.channel.command("C")? == Answer::Nothing {
            // A busy one: frames were on their way.
            if self.channel.command("C")? == Answer::Nothing {
                let adapter = self.channel.name().to_owned();
                return Err(LinkError::NoAnswer { adapter, command: "C".to_owned() });
            }
        }
        // Not before it is certain: whoever tidies up tries once more.
        self.state = State::Closed;
        self.channel.clear();
        Ok(())
    }

    /// Asks for what the adapter does not tell by itself.
    fn poll(&mut self, now: Micros) -> Result<(), LinkError> {
        if now < self.due {
            return Ok(());
        }
        self.due = now + POLL;
        if self.firmware.error_flag().is_some() {
            self.channel.tell(b"F\r")?;
        }
        if self.fetches == Fetches::Yes {
            self.channel.tell(b"A\r")?;
        }
        Ok(())
    }

    fn observation(&mut self, heard: Heard) -> Option<Observation> {
        let error = |class, place| Observation::Error(ErrorSeen { class, place, received: None });
        match heard {
            Heard::Frame(frame) => {
                let seen = FrameSeen { frame, origin: Origin::Bus, received: None };
                Some(Observation::Frame(seen))
            }
            Heard::Error(class, place) => Some(error(class, place)),
            Heard::ReceiveErrors(count) => Some(Observation::ReceiveErrors(count)),
            Heard::Lost => Some(Observation::Lost),
            Heard::Flags(flags)
                if self.firmware.error_flag().is_some_and(|bit| flags & bit != 0) =>
            {
                // At least one error since the flags were asked for last: a count, no single one.
                self.errors = self.errors.wrapping_add(1);
                Some(Observation::ReceiveErrors(self.errors))
            }
            Heard::Flags(flags) if flags & self.firmware.lost_flags() != 0 => {
                Some(Observation::Lost)
            }
            Heard::Flags(_) => None,
        }
    }

    fn misuse(&self, what: &'static str) -> LinkError {
        LinkError::State { adapter: self.channel.name().to_owned(), what }
    }

    fn unsettable(&self, candidate: &Candidate) -> LinkError {
        LinkError::Rate {
            adapter: self.channel.name().to_owned(),
            rate: candidate.nominal,
            reason: format!("{} has no command for it", self.firmware.title()),
        }
    }
}

/// `Y` and its digit.
fn data_command(rate: Bitrate) -> Option<&'static str> {
    match rate.bits_per_second() {
        500_000 => Some("Y0"),
        1_000_000 => Some("Y1"),
        2_000_000 => Some("Y2"),
        4_000_000 => Some("Y4"),
        5_000_000 => Some("Y5"),
        8_000_000 => Some("Y8"),
        _ => None,
    }
}

impl Controller for SlcanListener {
    type Error = LinkError;

    fn capabilities(&self) -> Capabilities<'_> {
        let rates = match rate::range(self.firmware) {
            Some((slowest, fastest)) => RateChoice::Between(slowest, fastest),
            None => RateChoice::Only(&self.rates),
        };
        let fd = match self.firmware {
            Firmware::Canable2 { .. } => FdSupport::Fd,
            _ => FdSupport::Classic,
        };
        let patience = u64::try_from(self.channel.patience().as_micros()).unwrap_or(u64::MAX);
        Capabilities {
            rates,
            evidence: self.firmware.evidence(),
            fd,
            // Closing, the rate, opening.
            reconfiguration: Micros(patience).times(3),
            latency: LATENCY,
        }
    }

    fn configure(&mut self, candidate: &Candidate) -> Result<Configured, LinkError> {
        if self.state != State::Closed {
            self.close()?;
        }
        let Some(set) = rate::command(self.firmware, candidate) else {
            return Err(self.unsettable(candidate));
        };
        let data = match candidate.data {
            None => None,
            Some(rate) => match data_command(rate) {
                Some(command) if matches!(self.firmware, Firmware::Canable2 { .. }) => {
                    Some((rate, command))
                }
                _ => return Err(self.unsettable(candidate)),
            },
        };
        self.must(&set.text)?;
        if let Some((_, command)) = data {
            self.must(command)?;
        }
        self.state = State::Configured;
        Ok(Configured { nominal: set.rate, data: data.map(|(rate, _)| rate) })
    }

    fn start_monitoring(&mut self) -> Result<(), LinkError> {
        if self.state != State::Configured {
            return Err(self.misuse("it listens only behind being configured"));
        }
        // Another program may have left a filter; all bits are "don't care" [CAN232 manual].
        match self.firmware {
            Firmware::CanableStock | Firmware::Other => {}
            _ => self.must("mFFFFFFFF")?,
        }
        // Listening from the first moment on, or not at all.
        self.state = State::Listening;
        self.channel.clear();
        match self.firmware {
            Firmware::CanableStock => {
                self.must("M1")?;
                self.must("O")?;
            }
            _ => self.must("L")?,
        }
        if self.firmware == Firmware::Lawicel {
            let fetched = self.channel.command("A")? == Answer::Done;
            self.fetches = if fetched { Fetches::Yes } else { Fetches::No };
        }
        self.due = self.clock.now() + POLL;
        self.errors = 0;
        self.count = if self.firmware.error_flag().is_some() { Count::Untold } else { Count::Told };
        Ok(())
    }

    fn observe(&mut self, now: Micros) -> Result<Option<Observation>, LinkError> {
        if self.state != State::Listening {
            return Err(self.misuse("it hears only while it listens"));
        }
        if self.count == Count::Untold {
            self.count = Count::Told;
            return Ok(Some(Observation::ReceiveErrors(self.errors)));
        }
        while let Some(heard) = self.channel.next() {
            if let Some(observation) = self.observation(heard) {
                return Ok(Some(observation));
            }
        }
        self.poll(now)?;
        Ok(None)
    }

    fn stop(&mut self) -> Result<(), LinkError> {
        match self.state {
            State::Closed => Ok(()),
            State::Configured | State::Listening => self.close(),
        }
    }
}

impl Listener for SlcanListener {
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError> {
        if self.channel.has_news() {
            return Ok(());
        }
        let polled = self.firmware.error_flag().is_some() || self.fetches == Fetches::Yes;
        let timeout = if polled { timeout.min(Duration::from_micros(POLL.0)) } else { timeout };
        self.channel.read(timeout)
    }

    fn describe(&self) -> String {
        format!("{} ({})", self.channel.name(), self.firmware.title())
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.firmware == Firmware::Other {
            remarks.push(
                "the firmware is unknown: it confirms L, and whether it is silent then is its word"
                    .to_owned(),
            );
        }
        if self.firmware.evidence() == Evidence::FramesOnly {
            remarks.push("this adapter does not tell a wrong rate from a silent bus".to_owned());
        }
        if !self.rates.is_empty() {
            let rates: Vec<String> = self.rates.iter().map(Bitrate::to_string).collect();
            remarks.push(format!("this adapter can be set to {} only", rates.join(", ")));
        }
        remarks
    }

    fn by_hand(&self) -> Option<String> {
        Some(format!("printf 'C\\r' > {}, or unplug it", self.channel.name()))
    }

    fn restore(&mut self) -> Result<(), LinkError> {
        match self.state {
            State::Closed => Ok(()),
            State::Configured | State::Listening => self.close(),
        }
    }
}

impl Drop for SlcanListener {
    fn drop(&mut self) {
        // On a way out that already has something else to say.
        let _ = self.restore();
    }
}
