//! A socket to rtnetlink.

use std::io;

use netlink_sys::protocols::NETLINK_ROUTE;
use netlink_sys::{Socket, SocketAddr};

use super::netlink::{
    Change, Link, LinkChange, Message, Messages, NetlinkError, dump_links, get_link,
};
use crate::LinkError;

/// Bytes of a datagram: the kernel's own limit for dumps.
const DATAGRAM: usize = 1 << 15;
/// Datagrams to one request: far more interfaces than a machine has.
const DATAGRAMS: usize = 4096;
/// EINTR, and what the kernel has for it inside (ERESTARTSYS and its relatives).
const INTERRUPTED: [i32; 5] = [4, 512, 513, 514, 516];
/// Signals that a change may meet.
const INTERRUPTIONS: usize = 8;
const EPERM: i32 = 1;
const ENODEV: i32 = 19;

/// What is asked of the kernel about one interface; tests have a kernel of their own.
pub(crate) trait LinkLayer: std::fmt::Debug + Send {
    /// The interface called `name`.
    fn link(&mut self, name: &str) -> Result<Link, LinkError>;
    /// The interface `index` as it is now.
    fn read_back(&mut self, name: &str, index: u32) -> Result<Link, LinkError>;
    /// Changes `link`.
    fn change(&mut self, link: &Link, change: &LinkChange) -> Result<(), LinkError>;
}

impl LinkLayer for Rtnl {
    fn link(&mut self, name: &str) -> Result<Link, LinkError> {
        Self::link(self, name)
    }

    fn read_back(&mut self, name: &str, index: u32) -> Result<Link, LinkError> {
        Self::read_back(self, name, index)
    }

    fn change(&mut self, link: &Link, change: &LinkChange) -> Result<(), LinkError> {
        Self::change(self, link, change)
    }
}

/// A connection to the kernel's link layer; every request is answered before it returns.
#[derive(Debug)]
pub struct Rtnl {
    socket: Socket,
    sequence: u32,
}

impl Rtnl {
    /// Opens one.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn open() -> Result<Self, LinkError> {
        let open = || -> io::Result<Socket> {
            let mut socket = Socket::new(NETLINK_ROUTE)?;
            socket.bind_auto()?;
            // Explanations; kernels before 4.12 have none.
            let _ = socket.set_ext_ack(true);
            // The kernel has answered when the request returns: nothing here ever waits.
            socket.set_non_blocking(true)?;
            Ok(socket)
        };
        let socket = open().map_err(|error| LinkError::io("cannot open rtnetlink", error))?;
        Ok(Self { socket, sequence: 0 })
    }

    /// All interfaces.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn links(&mut self) -> Result<Vec<Link>, LinkError> {
        let what = "cannot list the interfaces";
        let sequence = self.next();
        let answer = self.exchange(&dump_links(sequence), sequence, Wanted::UntilDone);
        let (links, refusal) = answer.map_err(|error| LinkError::io(what, error))?;
        match refusal {
            Some(error) => Err(LinkError::io(what, io::Error::from_raw_os_error(error.errno))),
            None => Ok(links),
        }
    }

    /// The interface called `name`.
    ///
    /// # Errors
    /// [`LinkError::NoInterface`] with those that there are.
    pub fn link(&mut self, name: &str) -> Result<Link, LinkError> {
        let links = self.links()?;
        if let Some(link) = links.iter().find(|link| link.name == name) {
            return Ok(link.clone());
        }
        let available = links.into_iter().filter(Link::is_can).map(|link| link.name).collect();
        Err(LinkError::NoInterface { name: name.to_owned(), available })
    }

    /// The interface `index` as it is now.
    ///
    /// # Errors
    /// [`LinkError::Gone`] if it is not there any more.
    pub fn read_back(&mut self, name: &str, index: u32) -> Result<Link, LinkError> {
        let what = || format!("cannot read back {name}");
        let sequence = self.next();
        let answer = self.exchange(&get_link(sequence, index), sequence, Wanted::OneLink);
        let (links, refusal) = answer.map_err(|error| LinkError::io(what(), error))?;
        match (links.into_iter().next(), refusal) {
            (Some(link), _) => Ok(link),
            (None, Some(error)) if error.errno != ENODEV => {
                Err(LinkError::io(what(), io::Error::from_raw_os_error(error.errno)))
            }
            (None, _) => Err(LinkError::Gone { adapter: name.to_owned() }),
        }
    }

    /// Changes `link`.
    ///
    /// # Errors
    /// [`LinkError::Permission`], [`LinkError::Gone`], or what the kernel says. A part of the change
    /// may have been made then: read it back.
    pub fn change(&mut self, link: &Link, change: &LinkChange) -> Result<(), LinkError> {
        let mut result = self.try_change(link.index, change);
        // Drivers that wait for their hardware stop waiting when a signal comes.
        for _ in 0..INTERRUPTIONS {
            match &result {
                Err(Refusal::Kernel(error)) if INTERRUPTED.contains(&error.errno) => {
                    result = self.try_change(link.index, change);
                }
                _ => break,
            }
        }
        match result {
            Ok(()) => Ok(()),
            Err(Refusal::System(error)) => {
                Err(LinkError::io(format!("cannot change {}", link.name), error))
            }
            Err(Refusal::Kernel(error)) => Err(refused(&link.name, change, error)),
        }
    }

    fn try_change(&mut self, index: u32, change: &LinkChange) -> Result<(), Refusal> {
        let sequence = self.next();
        let request = change.encode(sequence, index);
        let (_, refusal) =
            self.exchange(&request, sequence, Wanted::UntilDone).map_err(Refusal::System)?;
        refusal.map_or(Ok(()), |error| Err(Refusal::Kernel(error)))
    }

    const fn next(&mut self) -> u32 {
        self.sequence = self.sequence.wrapping_add(1);
        self.sequence
    }

    /// Sends a request and reads until its end.
    fn exchange(
        &self,
        request: &[u8],
        sequence: u32,
        wanted: Wanted,
    ) -> io::Result<(Vec<Link>, Option<NetlinkError>)> {
        self.socket.send_to(request, &SocketAddr::new(0, 0), 0)?;
        let mut links = Vec::new();
        for _ in 0..DATAGRAMS {
            let mut datagram = vec![0; DATAGRAM];
            let mut room = &mut datagram[..];
            let count = self.socket.recv(&mut room, 0)?;
            for (number, message) in Messages::new(datagram.get(..count).unwrap_or_default()) {
                match message {
                    _ if number != sequence => {}
                    Message::Link(body) => {
                        links.extend(Link::parse(body));
                        if wanted == Wanted::OneLink {
                            return Ok((links, None));
                        }
                    }
                    Message::Done => return Ok((links, None)),
                    Message::Error(error) => return Ok((links, Some(error))),
                    Message::Other(_) => {}
                }
            }
        }
        Err(io::Error::other("the kernel does not come to an end"))
    }
}

/// What ends an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    OneLink,
    UntilDone,
}

enum Refusal {
    System(io::Error),
    Kernel(NetlinkError),
}

/// The error of a change in words.
fn refused(name: &str, change: &LinkChange, error: NetlinkError) -> LinkError {
    match error.errno {
        EPERM => LinkError::Permission { interface: name.to_owned() },
        ENODEV => LinkError::Gone { adapter: name.to_owned() },
        errno => {
            let action = match change.set {
                Some(Change::Up) => "cannot set up",
                Some(Change::Down) => "cannot set down",
                None => "cannot configure",
            };
            let source = io::Error::from_raw_os_error(errno);
            let what = match error.message {
                Some(message) => format!("{action} {name} ({message})"),
                None => format!("{action} {name}"),
            };
            LinkError::io(what, source)
        }
    }
}
