//! Frames over UDP multicast, in the form of python-can's `udp_multicast` (MessagePack).

use std::collections::VecDeque;
use std::io;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant, SystemTime};

use canbaud::units::Bitrate;
use canbaud::wire::{Frame, FrameKind, Id};
use serde::{Deserialize, Serialize};
use socket2::{Domain, Protocol, Socket, Type};

use super::FrameBus;
use crate::LinkError;

/// Longer datagrams are cut, and then are no frame.
const DATAGRAM: usize = 4096;
/// Datagrams sent that may still come back.
const SENT: usize = 256;

/// A channel to everybody in the same group; there is no bit rate on it.
#[derive(Debug)]
pub struct MulticastBus {
    socket: UdpSocket,
    group: SocketAddrV4,
    /// What comes back because the group is joined by its sender.
    sent: VecDeque<Vec<u8>>,
}

impl MulticastBus {
    /// The group that python-can uses by default for IPv4.
    pub const GROUP: Ipv4Addr = Ipv4Addr::new(239, 74, 163, 2);
    /// The port that python-can uses by default.
    pub const PORT: u16 = 43113;

    /// Joins `group`; frames do not leave the local network.
    ///
    /// # Errors
    /// Whatever the system says.
    pub fn join(group: Ipv4Addr, port: u16) -> Result<Self, LinkError> {
        let group = SocketAddrV4::new(group, port);
        let open = || -> io::Result<UdpSocket> {
            let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
            socket.set_reuse_address(true)?;
            #[cfg(all(unix, not(any(target_os = "solaris", target_os = "illumos"))))]
            socket.set_reuse_port(true)?;
            socket.bind(&SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port).into())?;
            socket.join_multicast_v4(group.ip(), &Ipv4Addr::UNSPECIFIED)?;
            socket.set_multicast_ttl_v4(1)?;
            // Waited for by poll.
            #[cfg(unix)]
            socket.set_nonblocking(true)?;
            Ok(socket.into())
        };
        let socket =
            open().map_err(|error| LinkError::io(format!("cannot join {group}"), error))?;
        Ok(Self { socket, group, sent: VecDeque::new() })
    }

    /// Whether `datagram` is one of its own.
    fn is_own(&mut self, datagram: &[u8]) -> bool {
        let place = self.sent.iter().position(|sent| sent == datagram);
        place.and_then(|place| self.sent.remove(place)).is_some()
    }
}

impl FrameBus for MulticastBus {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let cannot = |error| LinkError::io(format!("cannot send to {}", self.group), error);
        let bytes =
            pack(frame, SystemTime::now()).map_err(|error| cannot(io::Error::other(error)))?;
        self.socket.send_to(&bytes, self.group).map_err(cannot)?;
        if self.sent.len() == SENT {
            self.sent.pop_front();
        }
        self.sent.push_back(bytes);
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError> {
        let until = Instant::now() + timeout;
        let mut datagram = [0; DATAGRAM];
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let read = wait(&self.socket, left).and_then(|()| self.socket.recv(&mut datagram));
            match read {
                Ok(count) => {
                    let datagram = datagram.get(..count).unwrap_or_default();
                    if let Some(frame) = unpack(datagram).filter(|_| !self.is_own(datagram)) {
                        return Ok(Some(frame));
                    }
                }
                Err(error) if is_timeout(&error) => {}
                Err(error) => {
                    return Err(LinkError::io(format!("cannot read from {}", self.group), error));
                }
            }
            if left.is_zero() {
                return Ok(None);
            }
        }
    }

    fn set_bitrate(&mut self, _bitrate: Bitrate) -> Result<(), LinkError> {
        Ok(())
    }

    fn is_virtual(&self) -> bool {
        true
    }
}

/// Waits for a datagram: a read timeout of the socket would be rounded to the clock of the kernel,
/// several ms.
#[cfg(unix)]
fn wait(socket: &UdpSocket, timeout: Duration) -> io::Result<()> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let limit = Timespec {
        tv_sec: timeout.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: timeout.subsec_nanos().into(),
    };
    match poll(&mut [PollFd::new(socket, PollFlags::IN)], Some(&limit)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(unix))]
fn wait(socket: &UdpSocket, timeout: Duration) -> io::Result<()> {
    // A timeout of 0 would mean for ever.
    socket.set_read_timeout(Some(timeout.max(Duration::from_micros(1))))
}

fn is_timeout(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}

/// The fields of python-can's `Message`.
#[derive(Serialize, Deserialize)]
struct Message<'a> {
    #[serde(default, deserialize_with = "ignored")]
    timestamp: f64,
    arbitration_id: u32,
    is_extended_id: bool,
    #[serde(default)]
    is_remote_frame: bool,
    #[serde(default)]
    is_error_frame: bool,
    #[serde(default, deserialize_with = "ignored_channel")]
    channel: Option<u32>,
    /// In bytes, of CAN FD frames too.
    dlc: u8,
    #[serde(borrow)]
    data: &'a serde_bytes::Bytes,
    #[serde(default)]
    is_fd: bool,
    #[serde(default)]
    bitrate_switch: bool,
    #[serde(default)]
    error_state_indicator: bool,
}

/// A time of any type of number.
fn ignored<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    serde::de::IgnoredAny::deserialize(from).map(|_| 0.0)
}

/// A channel of any type.
fn ignored_channel<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    serde::de::IgnoredAny::deserialize(from).map(|_| None)
}

fn pack(frame: &Frame, now: SystemTime) -> Result<Vec<u8>, rmp_serde::encode::Error> {
    let data = frame.data();
    let length = match frame.kind() {
        FrameKind::Remote => frame.dlc().min(8),
        // At most 64.
        FrameKind::Data | FrameKind::Fd { .. } => u8::try_from(data.len()).unwrap_or(64),
    };
    let (bitrate_switch, error_state_indicator) = match frame.kind() {
        FrameKind::Fd { brs, esi } => (brs, esi),
        FrameKind::Data | FrameKind::Remote => (false, false),
    };
    let since = now.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    rmp_serde::to_vec_named(&Message {
        timestamp: since.as_secs_f64(),
        arbitration_id: frame.id().raw(),
        is_extended_id: frame.id().is_extended(),
        is_remote_frame: frame.kind() == FrameKind::Remote,
        is_error_frame: false,
        channel: None,
        dlc: length,
        data: serde_bytes::Bytes::new(data),
        is_fd: frame.kind().is_fd(),
        bitrate_switch,
        error_state_indicator,
    })
}

/// `None` for an error frame and for what is no frame.
fn unpack(datagram: &[u8]) -> Option<Frame> {
    let message: Message<'_> = rmp_serde::from_slice(datagram).ok()?;
    if message.is_error_frame {
        return None;
    }
    let id = if message.is_extended_id {
        Id::extended(message.arbitration_id)?
    } else {
        Id::base(u16::try_from(message.arbitration_id).ok()?)?
    };
    let kind = match (message.is_fd, message.is_remote_frame) {
        (true, _) => {
            FrameKind::Fd { brs: message.bitrate_switch, esi: message.error_state_indicator }
        }
        (false, true) => FrameKind::Remote,
        (false, false) => FrameKind::Data,
    };
    let dlc = match kind {
        FrameKind::Remote => message.dlc,
        _ => (0..=15).find(|dlc| Frame::data_length(kind, *dlc) == message.data.len())?,
    };
    Frame::new(id, kind, dlc, message.data).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `msgpack.packb` of python-can's fields for an empty Message(arbitration_id=0x7E5, data=[4, 1]),
    /// written out by the MessagePack specification.
    fn of_python_can() -> Vec<u8> {
        let mut bytes = vec![0x8B];
        let mut field = |name: &str, value: &[u8]| {
            bytes.push(0xA0 + name.len() as u8);
            bytes.extend(name.as_bytes());
            bytes.extend(value);
        };
        field("timestamp", &[0xCB, 0, 0, 0, 0, 0, 0, 0, 0]);
        field("arbitration_id", &[0xCD, 0x07, 0xE5]);
        field("is_extended_id", &[0xC2]);
        field("is_remote_frame", &[0xC2]);
        field("is_error_frame", &[0xC2]);
        field("channel", &[0xA5, b'v', b'c', b'a', b'n', b'0']);
        field("dlc", &[2]);
        field("data", &[0xC4, 2, 4, 1]);
        field("is_fd", &[0xC2]);
        field("bitrate_switch", &[0xC2]);
        field("error_state_indicator", &[0xC2]);
        bytes
    }

    #[test]
    fn messages_of_python_can_are_read() {
        let want = Frame::new(Id::Base(0x7E5), FrameKind::Data, 2, &[4, 1]).unwrap();
        assert_eq!(unpack(&of_python_can()), Some(want));
    }

    #[test]
    fn every_kind_there_and_back() {
        let frames = [
            Frame::new(Id::Base(1), FrameKind::Remote, 5, &[]).unwrap(),
            Frame::new(Id::Extended(0x1ABC_DEF0), FrameKind::Data, 8, &[9; 8]).unwrap(),
            Frame::new(Id::Base(2), FrameKind::Fd { brs: true, esi: true }, 13, &[3; 32]).unwrap(),
        ];
        for frame in frames {
            assert_eq!(unpack(&pack(&frame, SystemTime::now()).unwrap()), Some(frame));
        }
    }

    proptest! {
        #[test]
        fn any_datagram_is_a_frame_or_none(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            unpack(&bytes);
        }

        #[test]
        fn damaged_messages_do_not_panic(at in 0_usize..150, with in any::<u8>()) {
            let mut bytes = of_python_can();
            let place = at % bytes.len();
            bytes[place] = with;
            unpack(&bytes);
        }
    }
}
