//! An interface that takes part in the traffic.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use canbaud::units::Bitrate;
use canbaud::wire::Frame;
use socketcan::CanSocket;

use super::FrameBus;
use super::rate::Rate;
use crate::LinkError;
use crate::socketcan::netlink::{Link, ctrlmode};
use crate::socketcan::{Raw, Rtnl, encode, raw};

/// How long a full queue of the interface may take to get a place.
const QUEUE_FULL: Duration = Duration::from_millis(500);
const ENOBUFS: i32 = 105;

/// An open interface of Linux that sends and receives; a bit rate that was set is put back when it
/// goes out of use, unless it is kept.
#[derive(Debug)]
pub struct SocketCanBus {
    socket: CanSocket,
    rate: Rate,
}

impl SocketCanBus {
    /// Opens the interface `name`, which somebody has set up.
    ///
    /// # Errors
    /// There is no such interface, it is down, or the system says no.
    pub fn open(name: &str) -> Result<Self, LinkError> {
        let mut rtnl = Rtnl::open()?;
        let link = rtnl.link(name)?;
        if !link.is_can() {
            return Err(LinkError::NotCan { name: name.to_owned() });
        }
        if !link.flags.is_up() {
            let what = "the interface is down: set it up first (ip link set ... up)";
            return Err(LinkError::State { adapter: name.to_owned(), what });
        }
        if link.can.as_ref().is_some_and(|can| can.ctrlmode & ctrlmode::LISTEN_ONLY != 0) {
            let what = "the interface listens only: set it down, then ip link set ... type can \
                        listen-only off";
            return Err(LinkError::State { adapter: name.to_owned(), what });
        }
        let socket = open(&link)?;
        Ok(Self { socket, rate: Rate::new(Box::new(rtnl), link) })
    }

    const fn link(&self) -> &Link {
        self.rate.link()
    }
}

impl FrameBus for SocketCanBus {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let bytes = encode(frame);
        let until = Instant::now() + QUEUE_FULL;
        loop {
            match self.socket.write(&bytes) {
                Ok(_) => return Ok(()),
                Err(error) if is_full(&error) && Instant::now() < until => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Err(error) => {
                    return Err(LinkError::io(
                        format!("cannot send on {}", self.link().name),
                        error,
                    ));
                }
            }
        }
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError> {
        let until = Instant::now() + timeout;
        let broken = |error| LinkError::io(format!("cannot read from {}", self.link().name), error);
        loop {
            match raw::receive(&self.socket).map_err(broken)? {
                // Frames of other programs on this machine count: on vcan there are no others.
                Some(heard) => {
                    if let Raw::Frame(frame) = heard.raw {
                        return Ok(Some(frame));
                    }
                }
                None => {
                    let Some(left) = until.checked_duration_since(Instant::now()) else {
                        return Ok(None);
                    };
                    raw::wait(&self.socket, left).map_err(broken)?;
                }
            }
        }
    }

    fn set_bitrate(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        if self.is_virtual() {
            return Ok(());
        }
        self.rate.set(bitrate)?;
        self.socket = open(self.link())?;
        Ok(())
    }

    fn is_virtual(&self) -> bool {
        self.link().is_virtual()
    }

    fn keep(&mut self) -> bool {
        self.rate.keep()
    }

    fn restore(&mut self) -> Result<bool, LinkError> {
        self.rate.restore()
    }

    fn by_hand(&self) -> Option<String> {
        Some(self.rate.by_hand())
    }
}

fn open(link: &Link) -> Result<CanSocket, LinkError> {
    let socket = raw::open(&link.name, link.index)?;
    // Its own frames would be taken for answers.
    socketcan::SocketOptions::set_recv_own_msgs(&socket, false)
        .map_err(|error| LinkError::io(format!("cannot open {}", link.name), error))?;
    Ok(socket)
}

fn is_full(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::WouldBlock || error.raw_os_error() == Some(ENOBUFS)
}
