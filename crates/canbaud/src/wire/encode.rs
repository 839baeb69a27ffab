//! A frame to the bits that its sender puts on the bus [ISO 11898-1].

use super::bits::BitString;
use super::crc::{Crc, CrcKind};
use super::frame::{Frame, FrameKind, Id};
use super::item::FdCrc;
use super::line::Level;

/// The bits of one frame from SOF to the last bit of EOF, the ACK slot recessive as its sender
/// leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncodedFrame {
    /// The bits in wire order.
    pub bits: BitString,
    /// Index of the BRS bit, if it is recessive: the data bit rate begins at its sample point.
    pub brs: Option<usize>,
    /// Index of the CRC delimiter: the nominal bit rate is back from its sample point on.
    pub crc_delimiter: usize,
    /// Bits that dynamic stuffing added.
    pub stuff_bits: usize,
}

impl EncodedFrame {
    /// The same frame with a dominant ACK slot, as the bus shows it once somebody listens.
    #[must_use]
    pub fn acknowledged(mut self) -> Self {
        self.bits.set_dominant(self.crc_delimiter.saturating_add(1));
        self
    }
}

/// Encodes `frame`; `fd_crc` matters for CAN FD frames only.
///
/// ```
/// use canbaud::wire::{encode, FdCrc, Frame, FrameKind, Id};
/// let frame = Frame::new(Id::Base(0x555), FrameKind::Data, 0, &[]).unwrap();
/// let encoded = encode(&frame, FdCrc::Iso);
/// // SOF 1, ID 11, RTR, IDE, r0, DLC 4, CRC 15, then the stuff bits.
/// assert_eq!(encoded.crc_delimiter, 34 + encoded.stuff_bits);
/// ```
#[must_use]
pub fn encode(frame: &Frame, fd_crc: FdCrc) -> EncodedFrame {
    let mut out = Stuffer::new();
    let brs = push_header(&mut out, frame);
    for byte in frame.data() {
        out.push(u32::from(*byte), 8);
    }
    if frame.kind().is_fd() {
        push_fd_crc(&mut out, frame, fd_crc);
    } else {
        let mut crc = Crc::new(CrcKind::CRC15);
        out.plain_into(&mut crc);
        out.push(crc.value(), 15);
        out.close();
    }
    let crc_delimiter = out.bits.len();
    // CRC delimiter, ACK slot, ACK delimiter and seven bits EOF.
    out.bits.push(u32::MAX, 10);
    EncodedFrame { bits: out.bits, brs, crc_delimiter, stuff_bits: out.stuff_bits }
}

/// SOF, arbitration and control field; returns the place of a recessive BRS bit.
fn push_header(out: &mut Stuffer, frame: &Frame) -> Option<usize> {
    let remote = u32::from(frame.kind() == FrameKind::Remote);
    out.push(0, 1);
    match frame.id() {
        Id::Base(id) => {
            out.push(u32::from(id), 11);
            // RTR (RRS in a CAN FD frame), then IDE.
            out.push(remote << 1, 2);
        }
        Id::Extended(id) => {
            out.push(id >> 18, 11);
            // SRR and IDE, both recessive.
            out.push(0b11, 2);
            out.push(id, 18);
            out.push(remote, 1);
        }
    }
    let brs = match frame.kind() {
        FrameKind::Fd { brs, esi } => {
            // FDF recessive, res dominant.
            out.push(0b10, 2);
            let at = out.bits.len();
            out.push(u32::from(brs), 1);
            out.push(u32::from(esi), 1);
            brs.then_some(at)
        }
        FrameKind::Data | FrameKind::Remote => {
            // r0, or r1 and r0 of an extended frame, dominant.
            out.push(0, if frame.id().is_extended() { 2 } else { 1 });
            None
        }
    };
    out.push(u32::from(frame.dlc()), 4);
    brs
}

/// Stuff count (ISO only) and CRC sequence with their fixed stuff bits.
fn push_fd_crc(out: &mut Stuffer, frame: &Frame, fd_crc: FdCrc) {
    let kind = fd_crc_kind(fd_crc, frame.data().len());
    let mut crc = Crc::new(kind);
    for level in out.bits.iter() {
        crc.push_bits(u32::from(level == Level::Recessive), 1);
    }
    let mut field = FixedStuffer { bits: &mut out.bits, in_group: 0 };
    if fd_crc == FdCrc::Iso {
        let count = stuff_count(out.stuff_bits);
        crc.push_bits(count, 4);
        field.push(count, 4);
    }
    field.push(crc.value(), kind.width());
}

/// The CRC that a CAN FD frame of `length` data bytes carries.
#[must_use]
pub(super) const fn fd_crc_kind(fd_crc: FdCrc, length: usize) -> CrcKind {
    match (fd_crc, length) {
        (FdCrc::Iso, 0..=16) => CrcKind::CRC17,
        (FdCrc::Iso, _) => CrcKind::CRC21,
        (FdCrc::NonIso, 0..=16) => CrcKind::CRC17_NON_ISO,
        (FdCrc::NonIso, _) => CrcKind::CRC21_NON_ISO,
    }
}

/// The four bits of the stuff count: the number modulo 8 in Gray code, then even parity.
#[must_use]
pub(super) const fn stuff_count(stuff_bits: usize) -> u32 {
    let count = (stuff_bits % 8) as u32;
    let gray = count ^ (count >> 1);
    (gray << 1) | (gray.count_ones() & 1)
}

/// Dynamic stuffing: after five equal bits, one of the other level.
struct Stuffer {
    bits: BitString,
    plain: BitString,
    run: u32,
    last: Level,
    stuff_bits: usize,
}

impl Stuffer {
    const fn new() -> Self {
        Self {
            bits: BitString::new(),
            plain: BitString::new(),
            run: 0,
            last: Level::Recessive,
            stuff_bits: 0,
        }
    }

    fn push(&mut self, bits: u32, count: u32) {
        self.plain.push(bits, count);
        for index in (0..count).rev() {
            self.settle();
            let bit = (bits >> index) & 1;
            let level = if bit == 1 { Level::Recessive } else { Level::Dominant };
            self.bits.push(bit, 1);
            self.run = if level == self.last { self.run + 1 } else { 1 };
            self.last = level;
        }
    }

    /// Inserts the stuff bit that is due, if one is.
    fn settle(&mut self) {
        if self.run == 5 {
            self.last = self.last.toggled();
            self.bits.push_run(self.last, 1);
            self.stuff_bits += 1;
            self.run = 1;
        }
    }

    /// The end of a classic CRC sequence: five equal bits there are stuffed, too.
    fn close(&mut self) {
        self.settle();
    }

    fn plain_into(&self, crc: &mut Crc) {
        for level in self.plain.iter() {
            crc.push_bits(u32::from(level == Level::Recessive), 1);
        }
    }
}

/// Fixed stuffing: before the first and after every fourth bit, the inverse of the bit before.
struct FixedStuffer<'a> {
    bits: &'a mut BitString,
    in_group: u32,
}

impl FixedStuffer<'_> {
    fn push(&mut self, bits: u32, count: u32) {
        for index in (0..count).rev() {
            if self.in_group == 0 {
                let before = self.bits.level(self.bits.len().saturating_sub(1));
                self.bits.push_run(before.toggled(), 1);
            }
            self.bits.push(bits >> index, 1);
            self.in_group = (self.in_group + 1) % 4;
        }
    }
}
