//! A serial adapter that takes part in the traffic.

use std::time::{Duration, Instant};

use canbaud::detect::scan::Candidate;
use canbaud::units::Bitrate;
use canbaud::wire::Frame;

use super::FrameBus;
use crate::LinkError;
use crate::slcan::{Answer, Channel, Firmware, Heard, LINE_MAX, print, rate_command};

/// An open serial adapter that sends and receives; closed when it goes out of use.
#[derive(Debug)]
pub struct SlcanBus {
    channel: Channel,
    firmware: Firmware,
    state: State,
}

/// Of the adapter's channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Closed,
    /// It may take part in the traffic.
    Open,
}

impl SlcanBus {
    /// Opens the port at `path` and the adapter's channel at `bitrate`, in normal mode.
    ///
    /// # Errors
    /// Nothing answers, or the adapter cannot be set to the rate.
    pub fn open(path: &str, baud: u32, bitrate: Bitrate) -> Result<Self, LinkError> {
        let mut channel = Channel::open(path, baud)?;
        let firmware = channel.identify()?;
        let mut bus = Self { channel, firmware, state: State::Closed };
        bus.start(bitrate)?;
        Ok(bus)
    }

    fn start(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        let adapter = self.channel.name().to_owned();
        let set = rate_command(self.firmware, &Candidate::classic(bitrate)).ok_or_else(|| {
            let reason = format!("{} has no command for it", self.firmware.title());
            LinkError::Rate { adapter, rate: bitrate, reason }
        })?;
        self.must(&set.text)?;
        // Also if the answer does not come.
        self.state = State::Open;
        self.must("O")
    }

    fn must(&mut self, command: &str) -> Result<(), LinkError> {
        let adapter = self.channel.name().to_owned();
        match self.firmware {
            Firmware::CanableStock => self.channel.tell(format!("{command}\r").as_bytes()),
            _ => match self.channel.command(command)? {
                Answer::Done => Ok(()),
                Answer::Refused => Err(LinkError::Refused { adapter, command: command.to_owned() }),
                Answer::Nothing | Answer::Text(_) => {
                    Err(LinkError::NoAnswer { adapter, command: command.to_owned() })
                }
            },
        }
    }

    fn close(&mut self) -> Result<(), LinkError> {
        match self.must("C") {
            // It was closed already.
            Ok(()) | Err(LinkError::Refused { .. }) => {}
            Err(error) => return Err(error),
        }
        self.state = State::Closed;
        self.channel.clear();
        Ok(())
    }
}

impl FrameBus for SlcanBus {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let mut line = [0; LINE_MAX];
        let length = print(frame, &mut line);
        // Confirmations are passed over: they say that the adapter has it, not that the bus has.
        self.channel.tell(line.get(..length).unwrap_or_default())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError> {
        let until = Instant::now() + timeout;
        loop {
            while let Some(heard) = self.channel.next() {
                if let Heard::Frame(frame) = heard {
                    return Ok(Some(frame));
                }
            }
            match until.checked_duration_since(Instant::now()) {
                Some(left) => self.channel.read(left)?,
                None => return Ok(None),
            }
        }
    }

    fn set_bitrate(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        self.close()?;
        self.start(bitrate)
    }

    fn restore(&mut self) -> Result<bool, LinkError> {
        if self.state == State::Open {
            match self.close() {
                // What is gone takes part in nothing.
                Ok(()) | Err(LinkError::Gone { .. }) => self.state = State::Closed,
                Err(error) => {
                    let adapter = self.channel.name().to_owned();
                    return Err(LinkError::NotRestored { adapter, reason: error.to_string() });
                }
            }
        }
        // A closed channel is how every adapter is left: nothing to speak of.
        Ok(false)
    }

    fn by_hand(&self) -> Option<String> {
        Some(format!("printf 'C\\r' > {}, or unplug it", self.channel.name()))
    }
}

impl Drop for SlcanBus {
    fn drop(&mut self) {
        // On a way out that already has something else to say.
        let _ = self.restore();
    }
}
