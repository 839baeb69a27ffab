//! A channel that is given up when a signal comes, and put back.

use std::io;
use std::time::Duration;

use canbaud::units::Bitrate;
use canbaud::wire::Frame;
use canbaud_link::LinkError;
use canbaud_link::bus::FrameBus;

use super::channel::Channel;
use super::trouble::Trouble;
use crate::run::live::Stop;
use crate::tell::tell;

/// A channel on which nothing is received any more when a signal came.
pub(crate) struct Watched {
    bus: Box<dyn FrameBus>,
    stop: Stop,
}

impl Watched {
    /// Opens `channel`; from now on signals do not end the program.
    pub(crate) fn open(channel: &Channel, bitrate: Option<Bitrate>) -> Result<Self, Trouble> {
        let stop = Stop::install()?;
        Ok(Self { bus: channel.open(bitrate)?, stop })
    }

    /// The number of the signal that came.
    pub(crate) fn signal(&self) -> Option<u8> {
        self.stop.signal()
    }

    /// What an error of the channel means: the signal, if one came.
    pub(crate) fn trouble(&self, error: LinkError) -> Trouble {
        self.signal().map_or(Trouble::Link(error), Trouble::Stopped)
    }

    /// Puts the channel back as it was found, and says so.
    pub(crate) fn put_back(&mut self, channel: &Channel) -> Result<(), Trouble> {
        match self.restore() {
            Ok(true) => tell!("canbaud: {channel} is put back as it was found"),
            Ok(false) => {}
            Err(error) => return Err(Trouble::NotRestored(error, self.by_hand())),
        }
        Ok(())
    }
}

impl FrameBus for Watched {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        self.bus.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError> {
        if self.signal().is_some() {
            let source = io::ErrorKind::Interrupted.into();
            return Err(LinkError::Io { what: "receiving".to_owned(), source });
        }
        self.bus.receive(timeout)
    }

    fn set_bitrate(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        self.bus.set_bitrate(bitrate)
    }

    fn is_virtual(&self) -> bool {
        self.bus.is_virtual()
    }

    fn keep(&mut self) -> bool {
        self.bus.keep()
    }

    fn restore(&mut self) -> Result<bool, LinkError> {
        self.bus.restore()
    }

    fn by_hand(&self) -> Option<String> {
        self.bus.by_hand()
    }
}
