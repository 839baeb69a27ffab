//! pcapng with SocketCAN packets, for Wireshark.
//!
//! Sources: draft-ietf-opsawg-pcapng (blocks and options), LINKTYPE_CAN_SOCKETCAN (packets).

use std::io::{self, Write};

use canbaud::wire::{Frame, Item};

use super::ItemWriter;
use super::socketcan::{EFF_FLAG, Message, RTR_FLAG};
use super::stamp::{Clock, Stamp};

const SECTION_HEADER: u32 = 0x0A0D_0D0A;
const BYTE_ORDER_MAGIC: u32 = 0x1A2B_3C4D;
const INTERFACE_DESCRIPTION: u32 = 1;
const ENHANCED_PACKET: u32 = 6;
const LINKTYPE_CAN_SOCKETCAN: u16 = 227;

const OPT_END: u16 = 0;
const SHB_USER_APPLICATION: u16 = 4;
const IF_NAME: u16 = 2;
const IF_TSRESOL: u16 = 9;

/// Bytes of a packet with a classic frame, and with a CAN FD frame.
const CLASSIC: usize = 16;
const FD: usize = 72;

/// Writes one section with one interface, time in nanoseconds.
pub(crate) struct Pcapng<W> {
    out: W,
    stamp: Stamp,
    block: Vec<u8>,
}

impl<W: Write> Pcapng<W> {
    /// Writes the headers; `clock` tells the ticks of the items.
    pub(crate) fn new(mut out: W, clock: Clock) -> io::Result<Self> {
        let mut block = Vec::with_capacity(128);
        push_section(&mut block);
        out.write_all(&block)?;
        push_interface(&mut block);
        out.write_all(&block)?;
        Ok(Self { out, stamp: Stamp::nanos(clock), block })
    }
}

impl<W: Write> ItemWriter for Pcapng<W> {
    fn write(&mut self, item: &Item) -> io::Result<()> {
        let mut packet = [0; FD];
        let length = fill_packet(&mut packet, Message::of(&item.kind));
        let nanos = self.stamp.count(item.start);
        begin(&mut self.block, ENHANCED_PACKET);
        // Interface 0, then the time as its high and its low half.
        push_u32(&mut self.block, 0);
        push_u32(&mut self.block, (nanos >> 32) as u32);
        push_u32(&mut self.block, nanos as u32);
        // Captured and original length; both packet sizes are multiples of 4, so no padding.
        push_u32(&mut self.block, length as u32);
        push_u32(&mut self.block, length as u32);
        self.block.extend_from_slice(&packet[..length]);
        end(&mut self.block);
        self.out.write_all(&self.block)
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Fills in the packet of `message`; its length.
fn fill_packet(packet: &mut [u8; FD], message: Message<'_>) -> usize {
    match message {
        Message::Data(frame) => {
            put_header(packet, id(frame), frame.data().len() as u8);
            packet[7] = raw_dlc(frame);
            packet[8..8 + frame.data().len()].copy_from_slice(frame.data());
            CLASSIC
        }
        Message::Remote(frame) => {
            put_header(packet, id(frame) | RTR_FLAG, frame.dlc().min(8));
            packet[7] = raw_dlc(frame);
            CLASSIC
        }
        Message::Fd(frame, flags) => {
            put_header(packet, id(frame), frame.data().len() as u8);
            packet[5] = flags;
            packet[8..8 + frame.data().len()].copy_from_slice(frame.data());
            FD
        }
        Message::Error(id, data) => {
            put_header(packet, id, 8);
            packet[8..16].copy_from_slice(&data);
            CLASSIC
        }
    }
}

/// The identifier is big-endian whatever the byte order of the section.
fn put_header(packet: &mut [u8; FD], id: u32, length: u8) {
    packet[..4].copy_from_slice(&id.to_be_bytes());
    packet[4] = length;
}

const fn id(frame: &Frame) -> u32 {
    let flag = if frame.id().is_extended() { EFF_FLAG } else { 0 };
    frame.id().raw() | flag
}

/// The field "Len 8 DLC": the DLC of a classic frame if it is above 8, else 0.
const fn raw_dlc(frame: &Frame) -> u8 {
    if frame.dlc() > 8 { frame.dlc() } else { 0 }
}

fn push_section(block: &mut Vec<u8>) {
    begin(block, SECTION_HEADER);
    push_u32(block, BYTE_ORDER_MAGIC);
    // Version 1.0; the length of the section is not given (-1), so that it can be streamed.
    block.extend_from_slice(&1_u16.to_le_bytes());
    block.extend_from_slice(&0_u16.to_le_bytes());
    block.extend_from_slice(&u64::MAX.to_le_bytes());
    let application = concat!("canbaud ", env!("CARGO_PKG_VERSION"));
    push_option(block, SHB_USER_APPLICATION, application.as_bytes());
    push_option(block, OPT_END, &[]);
    end(block);
}

fn push_interface(block: &mut Vec<u8>) {
    begin(block, INTERFACE_DESCRIPTION);
    block.extend_from_slice(&LINKTYPE_CAN_SOCKETCAN.to_le_bytes());
    // Reserved, then the snapshot length: no limit.
    block.extend_from_slice(&0_u16.to_le_bytes());
    push_u32(block, 0);
    push_option(block, IF_NAME, b"can0");
    // 10^-9 s.
    push_option(block, IF_TSRESOL, &[9]);
    push_option(block, OPT_END, &[]);
    end(block);
}

/// Starts a block; its length follows at the end.
fn begin(block: &mut Vec<u8>, kind: u32) {
    block.clear();
    push_u32(block, kind);
    push_u32(block, 0);
}

/// Closes a block: its length stands at both ends.
fn end(block: &mut Vec<u8>) {
    let length = (block.len() + 4) as u32;
    block[4..8].copy_from_slice(&length.to_le_bytes());
    push_u32(block, length);
}

fn push_option(block: &mut Vec<u8>, code: u16, value: &[u8]) {
    block.extend_from_slice(&code.to_le_bytes());
    block.extend_from_slice(&(value.len() as u16).to_le_bytes());
    block.extend_from_slice(value);
    block.resize(block.len().next_multiple_of(4), 0);
}

fn push_u32(block: &mut Vec<u8>, value: u32) {
    block.extend_from_slice(&value.to_le_bytes());
}

#[cfg(test)]
mod tests;
