//! Expected lines follow the documentation of the format in can-utils (`lib.h`) and
//! `linux/can/error.h`.

use canbaud::units::{Hertz, Timebase};
use canbaud::wire::{ErrorKind, Field, FrameKind, Id, Item, ItemKind};

use super::*;
use crate::output::items::{BASE, EXTENDED, error, everything, fd, frame, microseconds, overload};

fn text(items: &[Item], clock: Clock, raw_dlc: RawDlc) -> String {
    let mut out = Vec::new();
    let mut writer = Candump::new(&mut out, clock, raw_dlc);
    for item in items {
        writer.write(item).unwrap();
    }
    writer.finish().unwrap();
    String::from_utf8(out).unwrap()
}

fn line(item: Item) -> String {
    text(&[item], microseconds(), RawDlc::Hidden)
}

#[test]
fn classic_frames_are_written_as_candump_does() {
    let bytes = [0xDE, 0xAD, 0xBE, 0xEF];
    assert_eq!(
        line(frame(123_456, BASE, FrameKind::Data, 4, &bytes)),
        "(0000000000.123456) can0 123#DEADBEEF\n"
    );
    assert_eq!(
        line(frame(1_500_000, EXTENDED, FrameKind::Data, 1, &[7])),
        "(0000000001.500000) can0 18FEF100#07\n"
    );
    // An identifier below 0x800 in extended format keeps its eight digits.
    assert_eq!(
        line(frame(0, Id::Extended(0x42), FrameKind::Data, 0, &[])),
        "(0000000000.000000) can0 00000042#\n"
    );
}

#[test]
fn remote_frames_tell_their_dlc_unless_it_is_0() {
    assert!(line(frame(0, BASE, FrameKind::Remote, 0, &[])).ends_with(" 123#R\n"));
    assert!(line(frame(0, BASE, FrameKind::Remote, 8, &[])).ends_with(" 123#R8\n"));
    assert!(line(frame(0, EXTENDED, FrameKind::Remote, 3, &[])).ends_with(" 18FEF100#R3\n"));
}

#[test]
fn dlc_above_8_shows_only_on_request() {
    let data = frame(0, BASE, FrameKind::Data, 9, &[0x11; 8]);
    let remote = frame(0, BASE, FrameKind::Remote, 15, &[]);
    assert!(line(data).ends_with(" 123#1111111111111111\n"));
    assert!(line(remote).ends_with(" 123#R8\n"));
    let raw = |item| text(&[item], microseconds(), RawDlc::Shown);
    assert!(raw(data).ends_with(" 123#1111111111111111_9\n"));
    assert!(raw(remote).ends_with(" 123#R8_F\n"));
    let eight = frame(0, BASE, FrameKind::Data, 8, &[0x11; 8]);
    assert!(raw(eight).ends_with(" 123#1111111111111111\n"));
    let long_fd = fd(0, false, false, 9, &[0; 12]);
    assert!(!raw(long_fd).contains('_'), "the length of a CAN FD frame tells its DLC");
}

#[test]
fn fd_flags_are_brs_1_esi_2_fdf_4() {
    assert!(line(fd(0, false, false, 1, &[0xAB])).ends_with(" 123##4AB\n"));
    assert!(line(fd(0, true, false, 1, &[0xAB])).ends_with(" 123##5AB\n"));
    assert!(line(fd(0, false, true, 1, &[0xAB])).ends_with(" 123##6AB\n"));
    assert!(line(fd(0, true, true, 0, &[])).ends_with(" 123##7\n"));
}

#[test]
fn errors_carry_their_class_violation_and_location() {
    let tail = |kind, field| {
        let line = line(error(0, kind, field, None));
        line.trim_end().rsplit(' ').next().unwrap().to_owned()
    };
    // ERR_FLAG | BUSERROR | PROT; data[2] violation, data[3] location.
    assert_eq!(tail(ErrorKind::Stuff, Field::Data), "20000088#0000040A00000000");
    assert_eq!(tail(ErrorKind::Form, Field::CrcDelimiter), "20000088#0000021800000000");
    assert_eq!(tail(ErrorKind::Form, Field::AckDelimiter), "20000088#0000021B00000000");
    assert_eq!(tail(ErrorKind::Form, Field::EndOfFrame(6)), "20000088#0000021A00000000");
    assert_eq!(tail(ErrorKind::Crc, Field::Crc), "20000088#0000000800000000");
    // … | ACK.
    assert_eq!(tail(ErrorKind::Acknowledge, Field::AckSlot), "200000A8#0000001900000000");
    assert_eq!(tail(ErrorKind::Truncated, Field::Arbitration), "20000088#0000000000000000");
    assert!(line(overload(0)).ends_with(" 20000088#0000201200000000\n"));
}

#[test]
fn time_is_rounded_to_the_microsecond() {
    let timebase = Timebase::from_frequency(Hertz::new(3_000_000).unwrap());
    let timer = Clock { timebase, start_s: 0 };
    let item = frame(5, BASE, FrameKind::Data, 0, &[]);
    assert!(text(&[item], timer, RawDlc::Hidden).starts_with("(0000000000.000002) "));
}

/// What a reader of a log line gets.
#[derive(Debug, PartialEq)]
enum Parsed {
    Data { id: u32, extended: bool, data: Vec<u8> },
    Remote { id: u32, extended: bool, dlc: u32 },
    Fd { id: u32, brs: bool, esi: bool, data: Vec<u8> },
    Error { classes: u32 },
}

/// Reads a line by the grammar in can-utils `lib.h`, with nothing of the writer.
fn parse(line: &str) -> (f64, Parsed) {
    let fields: Vec<&str> = line.split(' ').collect();
    let [time, interface, body] = fields[..] else { panic!("three fields: {line}") };
    assert_eq!(interface, "can0");
    let time = time.strip_prefix('(').unwrap().strip_suffix(')').unwrap();
    assert_eq!(time.split_once('.').unwrap().1.len(), 6);
    let (id_text, rest) = body.split_once('#').unwrap();
    let raw = u32::from_str_radix(id_text, 16).unwrap();
    let extended = match id_text.len() {
        3 => false,
        8 => true,
        n => panic!("{n} digits: {line}"),
    };
    let bytes = |text: &str| -> Vec<u8> {
        assert!(text.len().is_multiple_of(2), "{line}");
        (0..text.len() / 2)
            .map(|i| u8::from_str_radix(&text[2 * i..2 * i + 2], 16).unwrap())
            .collect()
    };
    let id = raw & 0x1FFF_FFFF;
    let parsed = if raw & 0x2000_0000 != 0 {
        assert_eq!(bytes(rest).len(), 8);
        Parsed::Error { classes: id }
    } else if let Some(dlc) = rest.strip_prefix('R') {
        Parsed::Remote { id, extended, dlc: dlc.parse().unwrap_or(0) }
    } else if let Some(rest) = rest.strip_prefix('#') {
        let flags = rest[..1].parse::<u32>().unwrap();
        assert_ne!(flags & 4, 0);
        let data = bytes(&rest[1..]);
        Parsed::Fd { id, brs: flags & 1 != 0, esi: flags & 2 != 0, data }
    } else {
        Parsed::Data { id, extended, data: bytes(rest) }
    };
    (time.parse().unwrap(), parsed)
}

#[test]
fn everything_survives_an_independent_parser() {
    let items = everything();
    let text = text(&items, microseconds(), RawDlc::Hidden);
    assert_eq!(text.lines().count(), items.len());
    for (item, line) in items.iter().zip(text.lines()) {
        let (time, parsed) = parse(line);
        assert!((time - item.start as f64 * 1e-6).abs() < 1e-9, "{line}");
        let wanted = match &item.kind {
            ItemKind::Frame(received) => {
                let frame = &received.frame;
                let (id, extended) = (frame.id().raw(), frame.id().is_extended());
                let data = frame.data().to_vec();
                match frame.kind() {
                    FrameKind::Data => Parsed::Data { id, extended, data },
                    FrameKind::Remote => {
                        Parsed::Remote { id, extended, dlc: u32::from(frame.dlc()).min(8) }
                    }
                    FrameKind::Fd { brs, esi } => Parsed::Fd { id, brs, esi, data },
                }
            }
            ItemKind::Error(e) if e.kind == ErrorKind::Acknowledge => {
                Parsed::Error { classes: 0xA8 }
            }
            ItemKind::Error(_) | ItemKind::Overload => Parsed::Error { classes: 0x88 },
        };
        assert_eq!(parsed, wanted, "{line}");
    }
}
