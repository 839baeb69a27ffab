//! Messages: a header of 16 bytes, then a body.

use super::attribute::Attributes;

/// Bytes of `struct nlmsghdr`.
pub(super) const HEADER: usize = 16;
const NLMSG_ERROR: u16 = 2;
const NLMSG_DONE: u16 = 3;
pub(super) const RTM_NEWLINK: u16 = 16;
/// The request is not repeated in the error.
const F_CAPPED: u16 = 0x100;
/// Attributes follow the error.
const F_ACK_TLVS: u16 = 0x200;
const NLMSGERR_ATTR_MSG: u16 = 1;

/// What the kernel says to a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NetlinkError {
    /// The error number, positive.
    pub errno: i32,
    /// What the kernel has to say beyond it.
    pub message: Option<String>,
}

/// One message from the kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message<'a> {
    /// A link: everything behind the header.
    Link(&'a [u8]),
    /// The request was carried out.
    Done,
    /// The request was refused.
    Error(NetlinkError),
    /// Anything else.
    Other(u16),
}

/// The messages of one datagram; ends at the first that does not fit.
#[derive(Debug, Clone, Copy)]
pub struct Messages<'a> {
    bytes: &'a [u8],
}

impl<'a> Messages<'a> {
    /// The messages in `bytes`.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }
}

impl<'a> Iterator for Messages<'a> {
    /// The sequence number and the message.
    type Item = (u32, Message<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let length = u32::from_ne_bytes(*self.bytes.first_chunk()?) as usize;
        let kind = u16::from_ne_bytes(*self.bytes.get(4..)?.first_chunk()?);
        let flags = u16::from_ne_bytes(*self.bytes.get(6..)?.first_chunk()?);
        let sequence = u32::from_ne_bytes(*self.bytes.get(8..)?.first_chunk()?);
        let body = self.bytes.get(HEADER..length)?;
        self.bytes = self.bytes.get(length.next_multiple_of(4)..).unwrap_or_default();
        let message = match kind {
            NLMSG_ERROR => error(body, flags)?,
            NLMSG_DONE => Message::Done,
            RTM_NEWLINK => Message::Link(body),
            other => Message::Other(other),
        };
        Some((sequence, message))
    }
}

fn error<'a>(body: &[u8], flags: u16) -> Option<Message<'a>> {
    let errno = i32::from_ne_bytes(*body.first_chunk()?);
    if errno == 0 {
        return Some(Message::Done);
    }
    let message = (flags & F_ACK_TLVS != 0).then(|| explanation(body, flags)).flatten();
    Some(Message::Error(NetlinkError { errno: errno.saturating_neg(), message }))
}

/// The text behind the repeated request.
fn explanation(body: &[u8], flags: u16) -> Option<String> {
    let request = u32::from_ne_bytes(*body.get(4..)?.first_chunk()?) as usize;
    let request =
        if flags & F_CAPPED != 0 { HEADER } else { request.checked_next_multiple_of(4)? };
    let attributes = Attributes::new(body.get(request.checked_add(4)?..)?);
    Some(attributes.find(NLMSGERR_ATTR_MSG)?.text())
}
