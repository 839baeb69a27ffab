//! USB/IP, the protocol of the kernel's `vhci_hcd`: requests in, replies out
//! [Linux, Documentation/usb/usbip_protocol.rst]. Every number is big endian.

use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;

const HEADER: usize = 48;
const CMD_SUBMIT: u32 = 1;
const CMD_UNLINK: u32 = 2;
const RET_SUBMIT: u32 = 3;
const RET_UNLINK: u32 = 4;

/// `ECONNRESET`: a request that was waiting and was taken back.
const TAKEN_BACK: i32 = -104;
/// `EPIPE`: the endpoint stalls.
const STALLED: i32 = -32;

const ATTACH: &str = "/sys/devices/platform/vhci_hcd.0/attach";
/// Port 0; bus 1, device 2; full speed.
const PORT: u32 = 0;
const DEVICE_ID: u32 = 0x0001_0002;
const FULL_SPEED: u32 = 2;

/// A setup packet [USB 2.0, 9.3].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Setup {
    pub(super) request_type: u8,
    pub(super) request: u8,
    pub(super) value: u16,
    pub(super) length: u16,
}

/// What the host controller asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Request {
    /// A transfer on endpoint 0.
    Control { number: u32, setup: Setup, data: Vec<u8> },
    /// Wants data, whenever there is some.
    BulkIn { number: u32 },
    /// Brings data.
    BulkOut { number: u32, data: Vec<u8> },
    /// Takes a request back.
    Unlink { number: u32, target: u32 },
}

/// How a transfer ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Reply {
    /// Data for the host.
    Data(Vec<u8>),
    /// So many bytes were taken.
    Taken(usize),
    /// The device does not know such a request.
    Stall,
}

/// Plugs the device in: the other end of the socket becomes port 0 of the virtual host controller.
pub(super) fn attach() -> io::Result<UnixStream> {
    let (host, device) = UnixStream::pair()?;
    fs::write(ATTACH, format!("{PORT} {} {DEVICE_ID} {FULL_SPEED}", host.as_raw_fd()))?;
    // The kernel holds its end by itself.
    Ok(device)
}

fn be32(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_be_bytes(word)
}

/// Waits for the next request.
pub(super) fn read_request(stream: &mut impl Read) -> io::Result<Request> {
    let mut header = [0; HEADER];
    stream.read_exact(&mut header)?;
    let number = be32(&header, 4);
    match be32(&header, 0) {
        CMD_SUBMIT => {}
        CMD_UNLINK => return Ok(Request::Unlink { number, target: be32(&header, 20) }),
        other => return Err(io::Error::other(format!("unknown USB/IP command {other}"))),
    }
    let (is_in, endpoint) = (be32(&header, 12) == 1, be32(&header, 16));
    let length = be32(&header, 24) as usize;
    let mut data = vec![0; if is_in { 0 } else { length }];
    stream.read_exact(&mut data)?;
    Ok(match (endpoint, is_in) {
        (0, _) => Request::Control { number, setup: setup(&header[40..]), data },
        (_, true) => Request::BulkIn { number },
        (_, false) => Request::BulkOut { number, data },
    })
}

/// Setup packets are little endian, as on the wire.
fn setup(bytes: &[u8]) -> Setup {
    Setup {
        request_type: bytes[0],
        request: bytes[1],
        value: u16::from_le_bytes([bytes[2], bytes[3]]),
        length: u16::from_le_bytes([bytes[6], bytes[7]]),
    }
}

fn header(command: u32, number: u32, status: i32, actual: usize) -> Vec<u8> {
    let mut header = Vec::with_capacity(HEADER);
    // Device, direction and endpoint are zero in replies.
    for word in [command, number, 0, 0, 0, status as u32, actual as u32] {
        header.extend(word.to_be_bytes());
    }
    header.resize(HEADER, 0);
    header
}

/// Ends a transfer.
pub(super) fn complete(stream: &mut impl Write, number: u32, reply: &Reply) -> io::Result<()> {
    let (status, actual, data): (_, _, &[u8]) = match reply {
        Reply::Data(data) => (0, data.len(), data),
        Reply::Taken(count) => (0, *count, &[]),
        Reply::Stall => (STALLED, 0, &[]),
    };
    let mut message = header(RET_SUBMIT, number, status, actual);
    message.extend(data);
    stream.write_all(&message)
}

/// Answers an unlink.
pub(super) fn unlinked(stream: &mut impl Write, number: u32, was_waiting: bool) -> io::Result<()> {
    let status = if was_waiting { TAKEN_BACK } else { 0 };
    stream.write_all(&header(RET_UNLINK, number, status, 0))
}
