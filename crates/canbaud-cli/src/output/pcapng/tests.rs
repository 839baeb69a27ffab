//! Expected bytes are put together by hand from draft-ietf-opsawg-pcapng and
//! LINKTYPE_CAN_SOCKETCAN.

use canbaud::wire::{ErrorKind, Field, FrameKind, Item};

use super::*;
use crate::output::items::{BASE, EXTENDED, error, everything, fd, frame, microseconds};

fn file(items: &[Item]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut writer = Pcapng::new(&mut out, microseconds()).unwrap();
    for item in items {
        writer.write(item).unwrap();
    }
    writer.finish().unwrap();
    out
}

/// The blocks of a file: type and body, after checking that both lengths agree.
fn blocks(mut file: &[u8]) -> Vec<(u32, Vec<u8>)> {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap());
    let mut blocks = Vec::new();
    while !file.is_empty() {
        let length = word(&file[4..8]) as usize;
        assert!(length.is_multiple_of(4));
        assert_eq!(word(&file[length - 4..length]) as usize, length);
        blocks.push((word(&file[..4]), file[8..length - 4].to_vec()));
        file = &file[length..];
    }
    blocks
}

#[test]
fn headers_are_those_of_the_specification() {
    let blocks = blocks(&file(&[]));
    assert_eq!(blocks.len(), 2);
    let (kind, section) = &blocks[0];
    assert_eq!(*kind, 0x0A0D_0D0A);
    assert_eq!(
        section[..16],
        [
            0x4D, 0x3C, 0x2B, 0x1A, // byte order magic
            1, 0, 0, 0, // version 1.0
            0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, // section length unknown
        ]
    );
    let (kind, interface) = &blocks[1];
    assert_eq!(*kind, 1);
    assert_eq!(
        interface[..],
        [
            227, 0, 0, 0, // LINKTYPE_CAN_SOCKETCAN, reserved
            0, 0, 0, 0, // no snapshot length
            2, 0, 4, 0, b'c', b'a', b'n', b'0', // if_name
            9, 0, 1, 0, 9, 0, 0, 0, // if_tsresol 10^-9, padded
            0, 0, 0, 0, // end of options
        ]
    );
}

#[test]
fn classic_frame_is_byte_exact() {
    // 5000 s are 5_000_000_000_000 ns = 0x48C_2739_5000.
    let item = frame(5_000_000_000, EXTENDED, FrameKind::Data, 3, &[0xAA, 0xBB, 0xCC]);
    let (kind, packet) = blocks(&file(&[item])).remove(2);
    assert_eq!(kind, 6);
    assert_eq!(
        packet,
        [
            0, 0, 0, 0, // interface
            0x8C, 0x04, 0, 0, 0x00, 0x50, 0x39, 0x27, // time, high half first
            16, 0, 0, 0, 16, 0, 0, 0, // captured and original length
            0x98, 0xFE, 0xF1, 0x00, // extended flag and identifier, big-endian
            3, 0, 0, 0, // length, no FD flags
            0xAA, 0xBB, 0xCC, 0, 0, 0, 0, 0,
        ]
    );
}

#[test]
fn fd_frame_has_72_bytes_and_its_flags() {
    let item = fd(0, true, true, 9, &[0x55; 12]);
    let (_, packet) = blocks(&file(&[item])).remove(2);
    assert_eq!(packet[12..20], [72, 0, 0, 0, 72, 0, 0, 0]);
    let frame = &packet[20..];
    assert_eq!(frame.len(), 72);
    assert_eq!(frame[..8], [0, 0, 0x01, 0x23, 12, 0x07, 0, 0]);
    assert_eq!(frame[8..20], [0x55; 12]);
    assert_eq!(frame[20..], [0; 52]);
}

#[test]
fn remote_and_raw_dlc_are_told() {
    let item = frame(0, BASE, FrameKind::Remote, 12, &[]);
    let (_, packet) = blocks(&file(&[item])).remove(2);
    assert_eq!(packet[20..28], [0x40, 0, 0x01, 0x23, 8, 0, 0, 12]);
    let item = frame(0, BASE, FrameKind::Data, 8, &[1; 8]);
    let (_, packet) = blocks(&file(&[item])).remove(2);
    assert_eq!(packet[27], 0, "a DLC of 8 is told by the length");
}

#[test]
fn error_frame_carries_the_error_flag() {
    let item = error(0, ErrorKind::Stuff, Field::Data, None);
    let (_, packet) = blocks(&file(&[item])).remove(2);
    assert_eq!(packet[20..], [0x20, 0, 0, 0x88, 8, 0, 0, 0, 0, 0, 0x04, 0x0A, 0, 0, 0, 0]);
}

#[test]
fn every_item_becomes_one_packet() {
    let items = everything();
    let blocks = blocks(&file(&items));
    assert_eq!(blocks.len(), 2 + items.len());
    assert!(blocks[2..].iter().all(|(kind, _)| *kind == 6));
}
