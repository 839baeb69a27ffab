//! The codec, by the documents and by anything.

use canbaud::detect::scan::{ErrorClass, ErrorPlace};
use canbaud::wire::{Frame, FrameKind, Id};
use canbaud_link::slcan::{Answers, Firmware, LINE_MAX, Line, Lines, Record, print};
use proptest::prelude::*;

fn frame(id: Id, kind: FrameKind, dlc: u8, data: &[u8]) -> Frame {
    Frame::new(id, kind, dlc, data).unwrap()
}

/// The CAN232 manual; Nakakiyo092/canable2-fw, document 1.
#[test]
fn frames_of_the_documents() {
    let data = FrameKind::Data;
    let fd = |brs| FrameKind::Fd { brs, esi: false };
    let cases: [(&[u8], Frame); 8] = [
        (b"t10021133", frame(Id::Base(0x100), data, 2, &[0x11, 0x33])),
        (b"t10021133EA5F", frame(Id::Base(0x100), data, 2, &[0x11, 0x33])),
        (b"t1002113300ABCDEF", frame(Id::Base(0x100), data, 2, &[0x11, 0x33])),
        (b"T0000010021133", frame(Id::Extended(0x100), data, 2, &[0x11, 0x33])),
        (b"r1002", frame(Id::Base(0x100), FrameKind::Remote, 2, &[])),
        (b"R000001003", frame(Id::Extended(0x100), FrameKind::Remote, 3, &[])),
        (
            b"d7ff9000102030405060708090a0b",
            frame(Id::Base(0x7FF), fd(false), 9, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]),
        ),
        (b"B1fffffff0", frame(Id::Extended(0x1FFF_FFFF), fd(true), 0, &[])),
    ];
    for (line, want) in cases {
        assert_eq!(Record::parse(line), Record::Frame(want), "{}", line.escape_ascii());
    }
}

/// `slcan_bump_err()` and `slcan_bump_state()` of Linux 6.12.
#[test]
fn error_records_as_the_kernel_reads_them() {
    assert_eq!(Record::parse(b"e1s"), Record::Error(ErrorClass::Stuff, ErrorPlace::Unknown));
    assert_eq!(Record::parse(b"e1a"), Record::Error(ErrorClass::Acknowledge, ErrorPlace::AckSlot));
    assert_eq!(Record::parse(b"e2of"), Record::Error(ErrorClass::Form, ErrorPlace::Unknown));
    assert_eq!(Record::parse(b"e1o"), Record::Lost);
    assert_eq!(Record::parse(b"sp128007"), Record::ReceiveErrors(128));
    assert_eq!(Record::parse(b"F84"), Record::Flags(0x84));
    assert_eq!(Record::parse(b""), Record::Done);
    assert_eq!(Record::parse(b"z"), Record::Sent);
}

#[test]
fn what_is_almost_a_record_is_text() {
    let lines: [&[u8]; 14] = [
        b"t",
        b"t100",
        b"t1009",
        b"t10021",
        b"t1002113",
        b"t10021133E",
        b"t8000",
        b"T200000000",
        b"tXYZ0",
        b"e2s",
        b"e1x",
        b"sp12800",
        b"F8",
        b"F841",
    ];
    for line in lines {
        assert_eq!(Record::parse(line), Record::Text(line), "{}", line.escape_ascii());
    }
}

#[test]
fn nobody_is_taken_for_somebody_else() {
    let say = |confirms, version, detail, serial| Answers {
        confirms,
        version,
        detail,
        serial,
        controller: b"",
    };
    let cases: [(Answers<'_>, Option<Firmware>); 7] = [
        (say(true, b"V1013", b"", b"NA123"), Some(Firmware::Lawicel)),
        (say(true, b"V0100", b"v0108", b"NFFFF"), Some(Firmware::Usbtin)),
        (say(true, b"VL2K1", b"", b""), Some(Firmware::Canable2 { clock: None })),
        // A clone with another meaning of F, and one with less to say.
        (say(true, b"V0102", b"", b"NA123"), Some(Firmware::Other)),
        (say(true, b"", b"", b""), Some(Firmware::Other)),
        (
            say(false, b"8ca5d39 https://github.com/normaldotcom/canable-fw.git", b"", b""),
            Some(Firmware::CanableStock),
        ),
        (say(false, b"", b"", b""), None),
    ];
    for (answers, want) in cases {
        assert_eq!(Firmware::identify(&answers), want, "{answers:?}");
    }
}

#[test]
fn a_line_without_end_is_cut_and_the_next_one_is_whole() {
    let mut lines = Lines::new();
    for _ in 0..100_000 {
        assert_eq!(lines.push(b't'), None);
    }
    assert_eq!(lines.push(b'\r'), Some(Line::Text(&[b't'; LINE_MAX])));
    for byte in *b"F00" {
        assert_eq!(lines.push(byte), None);
    }
    assert_eq!(lines.push(b'\r'), Some(Line::Text(b"F00")));
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0_u16..=0x7FF).prop_map(Id::Base),
        (0_u32..=0x1FFF_FFFF).prop_map(Id::Extended)
    ];
    let kind = prop_oneof![
        Just(FrameKind::Data),
        Just(FrameKind::Remote),
        any::<bool>().prop_map(|brs| FrameKind::Fd { brs, esi: false }),
    ];
    (id, kind, 0_u8..=15, prop::collection::vec(any::<u8>(), 64)).prop_map(
        |(id, kind, dlc, data)| {
            let dlc = if kind.is_fd() { dlc } else { dlc.min(8) };
            frame(id, kind, dlc, &data[..Frame::data_length(kind, dlc)])
        },
    )
}

proptest! {
    #[test]
    fn any_bytes_are_lines_and_any_line_is_a_record(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut lines = Lines::new();
        for byte in bytes {
            if let Some(Line::Text(line)) = lines.push(byte) {
                let _ = Record::parse(line);
            }
        }
    }

    #[test]
    fn what_is_printed_is_read(frame in any_frame()) {
        let mut line = [0; LINE_MAX];
        let length = print(&frame, &mut line);
        prop_assert_eq!(line[length - 1], b'\r');
        prop_assert_eq!(Record::parse(&line[..length - 1]), Record::Frame(frame));
    }

    #[test]
    fn any_answers_are_somebody_or_nobody(
        confirms in any::<bool>(),
        texts in prop::array::uniform4(prop::collection::vec(any::<u8>(), 0..80)),
    ) {
        let [version, detail, serial, controller] = &texts;
        let _ = Firmware::identify(&Answers { confirms, version, detail, serial, controller });
    }
}
