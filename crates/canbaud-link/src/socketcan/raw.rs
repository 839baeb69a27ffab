//! A `CAN_RAW` socket that hears everything of one interface.

use std::io::{self, IoSliceMut};
use std::os::fd::{AsFd, AsRawFd};
use std::time::{Duration, SystemTime};

use nix::sys::socket::{ControlMessageOwned, MsgFlags, recvmsg, setsockopt, sockopt};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::{RecvAncillaryBuffer, RecvFlags};
use socketcan::{CanSocket, Socket, SocketOptions};

use super::frame::{Raw, parse};
use crate::LinkError;

const EAFNOSUPPORT: i32 = 97;
const EPROTONOSUPPORT: i32 = 93;
const SOL_CAN_RAW: i32 = 101;
const CAN_RAW_FD_FRAMES: i32 = 5;
/// The frame was handed back by this host [raw_recvmsg() of the kernel].
const MSG_DONTROUTE: u32 = 0x4;
/// A frame of CAN FD; one byte more shows what is none.
const LONGEST: usize = 73;

/// One thing heard.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reception {
    pub(crate) raw: Raw,
    /// From a process of this machine, whether it was on the bus or not.
    pub(crate) local: bool,
    /// When the kernel got it.
    pub(crate) stamp: Option<SystemTime>,
}

/// An open socket; it has no way to send.
#[derive(Debug)]
pub(crate) struct RawSocket {
    socket: CanSocket,
}

impl RawSocket {
    /// Hears frames and error frames of interface `index` from now on.
    pub(crate) fn open(name: &str, index: u32) -> Result<Self, LinkError> {
        Ok(Self { socket: open(name, index)? })
    }

    /// The oldest thing heard that was not read yet.
    pub(crate) fn receive(&self) -> io::Result<Option<Reception>> {
        receive(&self.socket)
    }

    /// Waits for something to read.
    pub(crate) fn wait(&self, timeout: Duration) -> io::Result<()> {
        wait(&self.socket, timeout)
    }
}

/// A socket bound to interface `index`, not blocking, that hears everything.
pub(crate) fn open(name: &str, index: u32) -> Result<CanSocket, LinkError> {
    let what = || format!("cannot listen to {name}");
    let socket = CanSocket::open_iface(index).map_err(|error| match error.raw_os_error() {
        Some(EAFNOSUPPORT | EPROTONOSUPPORT) => LinkError::NoKernelCan,
        _ => LinkError::io(what(), error),
    })?;
    let prepare = || -> io::Result<()> {
        socket.set_nonblocking(true)?;
        socket.set_error_filter_accept_all()?;
        // Kernels without CAN FD have none to hear.
        let _ = socket.set_socket_option_int(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1);
        setsockopt(&socket, sockopt::ReceiveTimestampns, &true)?;
        Ok(())
    };
    prepare().map_err(|error| LinkError::io(what(), error))?;
    Ok(socket)
}

/// The oldest thing heard that was not read yet; what is no frame is passed over.
pub(crate) fn receive(socket: &CanSocket) -> io::Result<Option<Reception>> {
    loop {
        let Some(local) = next_is_local(socket)? else { return Ok(None) };
        let mut bytes = [0; LONGEST];
        let mut parts = [IoSliceMut::new(&mut bytes)];
        let mut control = nix::cmsg_space!(nix::sys::time::TimeSpec);
        let message = recvmsg::<()>(
            socket.as_raw_fd(),
            &mut parts,
            Some(&mut control),
            MsgFlags::MSG_DONTWAIT,
        )?;
        let stamp = message.cmsgs()?.find_map(|control| match control {
            ControlMessageOwned::ScmTimestampns(time) => wall(time),
            _ => None,
        });
        let count = message.bytes;
        if let Some(raw) = parse(bytes.get(..count).unwrap_or_default()) {
            return Ok(Some(Reception { raw, local, stamp }));
        }
    }
}

/// Whether the next frame comes from this host; `None` if there is no next frame.
///
/// A look ahead, because only this call tells the flag and only the other one the time stamp.
fn next_is_local(socket: &CanSocket) -> io::Result<Option<bool>> {
    let mut byte = [0];
    let mut parts = [IoSliceMut::new(&mut byte)];
    let how = RecvFlags::PEEK | RecvFlags::DONTWAIT;
    match rustix::net::recvmsg(socket, &mut parts, &mut RecvAncillaryBuffer::default(), how) {
        Ok(ahead) => Ok(Some(ahead.flags.bits() & MSG_DONTROUTE != 0)),
        Err(rustix::io::Errno::AGAIN | rustix::io::Errno::INTR) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

fn wall(time: nix::sys::time::TimeSpec) -> Option<SystemTime> {
    let seconds = u64::try_from(time.tv_sec()).ok()?;
    let nanoseconds = u32::try_from(time.tv_nsec()).ok().filter(|ns| *ns < 1_000_000_000)?;
    SystemTime::UNIX_EPOCH.checked_add(Duration::new(seconds, nanoseconds))
}

/// Waits for something to read; an interruption ends it.
pub(crate) fn wait(file: impl AsFd, timeout: Duration) -> io::Result<()> {
    let limit = Timespec {
        tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    let mut files = [PollFd::from_borrowed_fd(file.as_fd(), PollFlags::IN)];
    match poll(&mut files, Some(&limit)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}
