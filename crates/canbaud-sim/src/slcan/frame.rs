//! Frames as slcan writes them: `tiiildd…` and its relatives.

use canbaud::wire::{Frame, FrameKind, Id};

use super::command::{Report, Stamps, Switch};
use crate::time::Time;

/// The letter of a frame: lower case for a base identifier.
const fn letter(frame: &Frame) -> char {
    match (frame.kind(), frame.id().is_extended()) {
        (FrameKind::Data, false) => 't',
        (FrameKind::Data, true) => 'T',
        (FrameKind::Remote, false) => 'r',
        (FrameKind::Remote, true) => 'R',
        (FrameKind::Fd { brs: false, .. }, false) => 'd',
        (FrameKind::Fd { brs: false, .. }, true) => 'D',
        (FrameKind::Fd { brs: true, .. }, false) => 'b',
        (FrameKind::Fd { brs: true, .. }, true) => 'B',
    }
}

/// A frame without its CR, with what `report` wants after the data; it happened at `at`.
pub(super) fn print(frame: &Frame, report: Report, at: Time) -> String {
    use core::fmt::Write;
    let dlc = if frame.kind().is_fd() { frame.dlc() } else { frame.dlc().min(8) };
    let mut text = format!("{}{}{dlc:X}", letter(frame), frame.id());
    for byte in frame.data() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02X}");
    }
    let us = at.femtoseconds() / 1_000_000_000;
    let _ = match report.stamps {
        Stamps::None => Ok(()),
        Stamps::Milliseconds => write!(text, "{:04X}", us / 1_000 % 60_000),
        Stamps::Microseconds => write!(text, "{:08X}", us % 3_600_000_000),
    };
    if let (Switch::On, FrameKind::Fd { esi, .. }) = (report.esi, frame.kind()) {
        text.push(if esi { '1' } else { '0' });
    }
    text
}

fn hex(text: &str) -> Option<u32> {
    // from_str_radix would take a sign.
    let digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    if digits { u32::from_str_radix(text, 16).ok() } else { None }
}

/// A frame to send, letter included; `None` if that is none.
pub(super) fn parse(line: &str) -> Option<Frame> {
    let kind = match line.get(..1)? {
        "t" | "T" => FrameKind::Data,
        "r" | "R" => FrameKind::Remote,
        "d" | "D" => FrameKind::Fd { brs: false, esi: false },
        "b" | "B" => FrameKind::Fd { brs: true, esi: false },
        _ => return None,
    };
    let extended = line.as_bytes().first()?.is_ascii_uppercase();
    let digits = if extended { 8 } else { 3 };
    let raw = hex(line.get(1..=digits)?)?;
    let id = if extended { Id::extended(raw)? } else { Id::base(u16::try_from(raw).ok()?)? };
    let dlc = hex(line.get(digits + 1..digits + 2)?)? as u8;
    if dlc > 8 && !kind.is_fd() {
        return None;
    }
    let body = line.get(digits + 2..)?;
    let wanted = Frame::data_length(kind, dlc);
    if body.len() != 2 * wanted {
        return None;
    }
    let bytes: Option<Vec<u8>> =
        (0..wanted).map(|at| Some(hex(body.get(2 * at..2 * at + 2)?)? as u8)).collect();
    Frame::new(id, kind, dlc, &bytes?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Span;

    #[test]
    fn every_letter_there_and_back() {
        for line in [
            "t1232DEAD",
            "T1FFFFFFF0",
            "r7FF8",
            "R000000014",
            "d1239000102030405060708090A0B",
            "B123456781AA",
        ] {
            let plain = Report::with(Stamps::None);
            assert_eq!(print(&parse(line).unwrap(), plain, Time::ZERO), line);
        }
    }

    #[test]
    fn stamps_and_esi_follow_the_data() {
        let print = |line: &str, report: Report, ms: u64| {
            super::print(&parse(line).unwrap(), report, Time::ZERO + Span::from_ms(ms))
        };
        let ms = Report::with(Stamps::Milliseconds);
        assert_eq!(print("t0010", ms, 59_999), "t0010EA5F");
        assert_eq!(print("t0010", ms, 60_000), "t00100000");
        let us = Report { esi: Switch::On, ..Report::with(Stamps::Microseconds) };
        // One hour less one millisecond, and CAN FD alone has an ESI.
        assert_eq!(print("d0010", us, 3_599_999), "d0010D693A0180");
        assert_eq!(print("t0010", us, 3_600_000), "t001000000000");
    }

    #[test]
    fn nonsense_is_refused() {
        for line in ["t8000", "t12", "t1239", "t1231", "t1231A", "t1231AAB", "T200000000", "t+120"]
        {
            assert!(parse(line).is_none(), "{line}");
        }
    }
}
